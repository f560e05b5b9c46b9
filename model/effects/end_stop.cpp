#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - k (y - position) beyond the stop. p = {k, position}.
template <typename T>
struct EndStop {
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->stops.Add({.k = p[0], .position = p[1]});
  }
};

}  // namespace

const Effect& EndStopEffect() {
  static const Effect effect{
      .id = "end_stop",
      .title = "a stop on one side",
      .equation = "y''/g = ... - k (y - position) beyond the stop: above position > 0, below position < 0",
      .acts_on = ActsOn::kForce,
      .parameters = {{.symbol = "k",
                      .unit = "1/m",
                      .meaning = "stiffness of the stop",
                      .low = 0,
                      .high = 2e4,  // 70 MN/m under 3.7 kN: a steel frame hit at a stiff place
                      .starts = {100}},
                     {.symbol = "position",
                      .unit = "m",
                      .meaning = "displacement at the touch",
                      .low = -0.1,
                      .high = 0.1,
                      .start_scale = StartScale::kSwing,
                      .starts = {0.95, 0.85, 0.75, 0.6, -0.6, -0.75, -0.85, -0.95}}},
      .signature = {.text = "extrema of one side are cut and turn faster, above one amplitude only",
                    .even_harmonics = true},
      .confused_with = "sensor_saturation, quadratic_stiffness, cubic_stiffness",
      .separated_by = "a release below the stop; the stop itself can be looked for at the place",
      .repairs = {"backbone", "even_harmonics", "mid_line", "residual_against_displacement", "loss_per_half_cycle"},
      .law = MakeLaw<EndStop>()};
  return effect;
}

}  // namespace uiclink
