#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// The spring of every joint is slack over a free travel of +-gap.
template <typename T>
struct Clearance {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->gap += p[0];
    oscillator->has_gap = true;
  }
};

}  // namespace

const Effect& ClearanceEffect() {
  static const Effect effect{
      .id = "clearance",
      .title = "play in the joints",
      .equation = "T = -k (z - clip(z, +-gap)),  z the deflection of the joint",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "gap",
                      .unit = "m",
                      .meaning = "half the play",
                      .low = 0,
                      .high = 0.005,  // bolt and eye worn by 10 mm: such a link has long been taken out
                      .starts = {3e-4}}},
      .signature = {.text = "the frequency falls again at the smallest amplitudes; rest anywhere within the play"},
      .confused_with = "stribeck_friction, velocity_strengthening",
      .separated_by = "a tail down to amplitudes of the size of the play",
      .repairs = {"backbone", "rest_off_centre", "T0_from_lock", "odd_harmonics", "residual_against_displacement"},
      .law = MakeLaw<Clearance>()};
  return effect;
}

}  // namespace uiclink
