#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - k2 y^2.
template <typename T>
struct QuadraticStiffness {
  static T Force(const LawParameters<T>& p, const Motion<T>& motion) { return -p[0] * motion.y * motion.y; }
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->forces.Add({.p = {p[0]}, .force = &Force});
  }
};

}  // namespace

const Effect& QuadraticStiffnessEffect() {
  static const Effect effect{
      .id = "quadratic_stiffness",
      .title = "stiffness that differs between the sides: a worn, non-circular profile",
      .equation = "y''/g = ... - k2 y^2",
      .acts_on = ActsOn::kStiffness,
      .parameters = {{.symbol = "k2",
                      .unit = "1/m^2",
                      .meaning = "stiffer towards y > 0, or < 0",
                      .low = -100,  // at 30 mm the softer side would have lost most of the pendulum's stiffness
                      .high = 100,
                      .starts = {8}}},
      .signature = {.text = "the mid-line moves with the square of the amplitude, with a second harmonic",
                    .even_harmonics = true},
      .confused_with = "sensor_nonlinearity, end_stop",
      .separated_by =
          "a calibrated sensor, or the sensor moved by some millimetres: the curve of a sensor moves with it",
      .repairs = {"mid_line", "even_harmonics", "residual_against_displacement"},
      .law = MakeLaw<QuadraticStiffness>()};
  return effect;
}

}  // namespace uiclink
