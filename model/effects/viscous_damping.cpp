#include <numbers>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - c y'.  Affine, so arcs keep their closed form.
template <typename T>
struct ViscousDamping {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) { oscillator->damping += p[0]; }
};

/// W = integral c y' dy = pi c w A^2.
double LossPerCycle(std::span<const double> p, double A, double w) { return std::numbers::pi * p[0] * w * A * A; }

}  // namespace

const Effect& ViscousDampingEffect() {
  static const Effect effect{
      .id = "viscous_damping",
      .title = "viscous damping beside the dry friction",
      .equation = "y''/g = ... - c y'",
      .acts_on = ActsOn::kForce,
      .parameters =
          {{.symbol = "c", .unit = "s/m", .meaning = "damping per unit load", .low = 0, .high = 0.3, .starts = {0.01}}},
      .signature = {.text = "the decay is exponential where all joints only roll, at a frequency that stays",
                    .loss_exponent = 2},
      .confused_with = "rolling_friction, micro_slip, quadratic_drag, friction_drift",
      .separated_by = "a longer tail: the amplitude of the rolling phase over at least a factor of 3",
      .repairs = {"loss_per_half_cycle", "rolling_decay"},
      .loss_per_cycle = &LossPerCycle,
      .law = MakeLaw<ViscousDamping>()};
  return effect;
}

}  // namespace uiclink
