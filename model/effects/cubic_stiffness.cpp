#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// y''/g = ... - k3 y^3.
template <typename T>
struct CubicStiffness {
  static T Force(const LawParameters<T>& p, const Motion<T>& motion) { return -p[0] * motion.y * motion.y * motion.y; }
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->forces.Add({.p = {p[0]}, .force = &Force});
  }
};

}  // namespace

const Effect& CubicStiffnessEffect() {
  static const Effect effect{
      .id = "cubic_stiffness",
      .title = "stiffness that changes with the square of the displacement",
      .equation = "y''/g = ... - k3 y^3",
      .acts_on = ActsOn::kStiffness,
      .parameters = {{.symbol = "k3",
                      .unit = "1/m^3",
                      .meaning = "hardening > 0, softening < 0",
                      .low = -5000,  // at 30 mm as large as the pendulum's own stiffness (3 to 6 1/m)
                      .high = 5000,
                      .starts = {400}}},
      .signature = {.text = "the frequency moves with the square of the amplitude, sliding or rolling; no loss"},
      .confused_with = "pendulum_geometry, velocity_strengthening, stribeck_friction, end_stop",
      .separated_by = "releases at two amplitudes, one so large that the joints slide nearly all the time",
      .repairs = {"backbone", "odd_harmonics", "residual_against_displacement"},
      .law = MakeLaw<CubicStiffness>()};
  return effect;
}

}  // namespace uiclink
