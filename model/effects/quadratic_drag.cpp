#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - d y' |y'|.
template <typename T>
struct QuadraticDrag {
  static T Force(const LawParameters<T>& p, const Motion<T>& motion) {
    return Value(motion.v) < 0 ? p[0] * motion.v * motion.v : -p[0] * motion.v * motion.v;
  }
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->forces.Add({.p = {p[0]}, .force = &Force});
  }
};

/// W = 4 integral over a quarter of d y'^2 dy = (8/3) d w^2 A^3.
double LossPerCycle(std::span<const double> p, double A, double w) { return 8.0 / 3 * p[0] * w * w * A * A * A; }

}  // namespace

const Effect& QuadraticDragEffect() {
  static const Effect effect{
      .id = "quadratic_drag",
      .title = "drag that grows with the square of the speed",
      .equation = "y''/g = ... - d y' |y'|",
      .acts_on = ActsOn::kForce,
      // Air on a plate of 1 m^2 is 2e-4; 3 brakes a link that swings by 30 mm as strongly as its pendulum pulls.
      .parameters =
          {{.symbol = "d", .unit = "s^2/m^2", .meaning = "drag per unit load", .low = 0, .high = 3, .starts = {0.3}}},
      .signature = {.text = "1/amplitude grows linearly in time where all joints only roll; gone at small amplitudes",
                    .loss_exponent = 3},
      .confused_with = "viscous_damping, velocity_strengthening, micro_slip",
      .separated_by = "releases at two amplitudes, one of them so small that all joints only roll",
      .repairs = {"loss_per_half_cycle", "rolling_decay", "residual_against_velocity", "T0_from_decrement"},
      .loss_per_cycle = &LossPerCycle,
      .law = MakeLaw<QuadraticDrag>()};
  return effect;
}

}  // namespace uiclink
