#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// A joint breaks out and slides at T0 (1 + b |y'|), y' the speed of the mass.
template <typename T>
struct VelocityStrengthening {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->strengthening += p[0];
    oscillator->has_strengthening = true;
  }
};

}  // namespace

const Effect& VelocityStrengtheningEffect() {
  static const Effect effect{
      .id = "velocity_strengthening",
      .title = "friction that rises with the speed of sliding",
      .equation = "a joint breaks out and slides at T0 (1 + b |y'|),  y' the speed of the mass",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "b",
                      .unit = "s/m",
                      .meaning = "growth with speed",
                      .low = 0,
                      .high = 20,  // friction five times as large at 0.2 m/s
                      .starts = {1}}},
      .signature = {.text = "T0 from the decrement grows with the amplitude; no loss where all joints only roll"},
      .confused_with = "quadratic_drag, cubic_stiffness, stribeck_friction, clearance",
      .separated_by = "releases at two large amplitudes, and a tail that shows what the rolling joints lose",
      .repairs = {"loss_per_half_cycle", "T0_from_decrement", "T0_from_centre", "residual_against_velocity"},
      .law = MakeLaw<VelocityStrengthening>()};
  return effect;
}

}  // namespace uiclink
