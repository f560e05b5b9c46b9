#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// T0 (1 + a) sliding towards y > 0, T0 (1 - a) towards y < 0.
template <typename T>
struct AsymmetricFriction {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) { oscillator->asymmetry += p[0]; }
};

}  // namespace

const Effect& AsymmetricFrictionEffect() {
  static const Effect effect{
      .id = "asymmetric_friction",
      .title = "friction that differs between the directions of sliding",
      .equation = "a joint slides at T0 (1 + a) towards y > 0, at T0 (1 - a) towards y < 0",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "a", .unit = "-", .meaning = "asymmetry", .low = -0.9, .high = 0.9, .starts = {0.1}}},
      .signature = {.text = "the sliding centres are not symmetric about the rest position before the push",
                    .even_harmonics = true},
      .confused_with = "zero offset",
      .separated_by = "the rest reading before the push with joints known to be free of force, or a force channel",
      .unseen =
          "its force is that of a symmetric joint and a constant, and a constant force shifts the whole motion: "
          "exactly the zero offset that every record has",
      .repairs = {"rest_off_centre", "mid_line"},
      .law = MakeLaw<AsymmetricFriction>()};
  return effect;
}

}  // namespace uiclink
