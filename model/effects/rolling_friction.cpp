#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - T_r sign(y'), at all times; holds the mass at rest where it can.
template <typename T>
struct RollingFriction {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->rolling += p[0];
    oscillator->has_rolling = true;
  }
};

/// W = 4 T_r A.
double LossPerCycle(std::span<const double> p, double A, double /*w*/) { return 4 * p[0] * A; }

}  // namespace

const Effect& RollingFrictionEffect() {
  static const Effect effect{
      .id = "rolling_friction",
      .title = "friction of the rolling joints",
      .equation = "y''/g = ... - T_r sign(y')",
      .acts_on = ActsOn::kForce,
      .parameters = {{.symbol = "T_r",
                      .unit = "-",
                      .meaning = "friction while the joints roll",
                      .low = 0,
                      .high = 0.02,
                      .starts = {3e-4}}},
      .signature = {.text = "the decay is linear where all joints only roll, and ends in finite time",
                    .loss_exponent = 1},
      .confused_with = "viscous_damping, micro_slip, extra_slider, friction_drift",
      .separated_by = "a longer tail: the amplitude of the rolling phase over at least a factor of 3",
      .repairs = {"loss_per_half_cycle", "rolling_decay"},
      .loss_per_cycle = &LossPerCycle,
      .law = MakeLaw<RollingFriction>()};
  return effect;
}

}  // namespace uiclink
