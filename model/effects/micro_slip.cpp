#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// Enough that the corners of the loop are round: the step from one slider to the next is k/16.
constexpr int kSliders = 16;

/// Slip displacement of slider j = 0, 1, ... as a share of y_max.
constexpr double Share(int j) { return (j + 0.5) / kSliders; }

/// 16 sliders of stiffness k/16 that slip at (j - 1/2) y_max/16, j = 1..16: a uniform Iwan distribution. They are
/// creepage in the contacts, not joints: what happens to the friction of the joints does not happen to them.
template <typename T>
struct MicroSlip {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    for (int j = 0; j < kSliders; ++j)
      oscillator->sliders.Add({.k = p[0] / double{kSliders}, .y_c = p[1] * Share(j), .joint = false});
  }
};

/// W = sum over the sliders that slip of 4 (k/16) y_c (A - y_c);  about (2/3) k A^3/y_max up to A = y_max.
double LossPerCycle(std::span<const double> p, double A, double /*w*/) {
  double loss = 0;
  for (int j = 0; j < kSliders; ++j) {
    const double y_c = p[1] * Share(j);
    if (A > y_c) loss += 4 * p[0] / kSliders * y_c * (A - y_c);
  }
  return loss;
}

}  // namespace

const Effect& MicroSlipEffect() {
  static const Effect effect{
      .id = "micro_slip",
      .title = "micro-slip: many small sliders beside the joints (Iwan)",
      .equation = "y''/g = ... + sum of 16 sliders of stiffness k/16 that slip at (j - 1/2) y_max/16",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "k",
                      .unit = "1/m",
                      .meaning = "stiffness of all together",
                      .low = 0,
                      .high = 30,  // several times the pendulum itself: no longer a small thing beside the joints
                      .starts = {0.3}},
                     {.symbol = "y_max",
                      .unit = "m",
                      .meaning = "largest slip displacement",
                      .low = 1e-4,  // below, all of them slip all the time: rolling friction
                      .high = 0.05,
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSwing,
                      .starts = {0.1, 0.04, 0.25}}},
      .signature = {.text = "corners of the loop are rounded, the backbone bends where all joints only roll, too",
                    .loss_exponent = 3},
      .confused_with = "rolling_friction, viscous_damping, extra_slider, quadratic_drag, friction_drift",
      .separated_by =
          "frequency and loss of small amplitudes: a longer tail, or a release below the slip of the joints",
      .repairs = {"loss_per_half_cycle", "rolling_decay", "backbone", "T0_from_lock"},
      .loss_per_cycle = &LossPerCycle,
      .law = MakeLaw<MicroSlip>()};
  return effect;
}

}  // namespace uiclink
