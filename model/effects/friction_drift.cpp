#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// T0(t) = T0 (1 + rate t), t from the start of the record.
template <typename T>
struct FrictionDrift {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->drift += p[0];
    oscillator->has_drift = true;
  }
};

}  // namespace

const Effect& FrictionDriftEffect() {
  static const Effect effect{
      .id = "friction_drift",
      .title = "friction that changes during the record: running in, heating, dirt",
      .equation = "T0(t) = T0 (1 + rate t), t from the start of the record",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "rate",
                      .unit = "1/s",
                      .meaning = "relative change of T0",
                      .low = -0.06,  // the friction of a 15 s record would be gone at its end
                      .high = 0.3,
                      .starts = {0.02}}},
      .signature = {.text =
                        "T0 from the decrement changes along the record, and differs at equal amplitudes reached at "
                        "different times"},
      .confused_with = "viscous_damping, micro_slip, rolling_friction",
      .separated_by = "releases from different amplitudes in shuffled order: time and amplitude go their own ways",
      .repairs = {"loss_per_half_cycle", "backbone_in_time", "residual_against_time", "T0_from_lock",
                  "T0_from_decrement", "rolling_decay"},
      .law = MakeLaw<FrictionDrift>()};
  return effect;
}

}  // namespace uiclink
