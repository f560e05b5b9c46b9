#include <cmath>
#include <limits>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// 1 - sin(sqrt u)/sqrt u, smooth at u = 0.
template <typename T>
T SineDeficit(const T& u) {
  using std::sin;
  using std::sqrt;
  if (Value(u) > 1) {
    const T root = sqrt(u);
    return 1.0 - sin(root) / root;
  }
  // u/3! - u^2/5! + ...: the first term left out is 1/21! = 2e-20 at u = 1.
  T sum(0), power(1);
  double factorial = 1;
  for (int n = 1; n <= 9; ++n) {
    factorial *= 2.0 * n * (2.0 * n + 1);
    power *= u;
    sum += (n % 2 == 1 ? 1 : -1) / factorial * power;
  }
  return sum;
}

/// -k l sin(y/l) instead of -k y. p = {1/l^2, k}.
template <typename T>
struct PendulumGeometry {
  static T Force(const LawParameters<T>& p, const Motion<T>& motion) {
    return p[1] * motion.y * SineDeficit(T(p[0] * motion.y * motion.y));
  }
  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->forces.Add({.p = {p[0], oscillator->k}, .force = &Force});
  }
};

}  // namespace

const Effect& PendulumGeometryEffect() {
  static const Effect effect{
      .id = "pendulum_geometry",
      .title = "the pendulum's restoring force at large swing",
      .equation = "y''/g = -k l sin(y/l) + ...  instead of -k y",
      .acts_on = ActsOn::kStiffness,
      .parameters = {{.symbol = "l",
                      .unit = "m",
                      .meaning = "swinging length",
                      .low = 0.02,  // no link is shorter; a swing of 45 mm would be 130 degrees
                      .high = std::numeric_limits<double>::infinity(),
                      .coordinate = Coordinate::kInverseSquare,
                      .start_scale = StartScale::kSwing,
                      .starts = {2}}},
      .neutral = std::numeric_limits<double>::infinity(),
      .signature = {.text = "softening: the frequency falls by y^2/(16 l^2), seen only where the swing is large"},
      .confused_with = "cubic_stiffness",
      .separated_by = "the drawing of the link: a length that no link has is another softening stiffness",
      .repairs = {"backbone", "odd_harmonics", "residual_against_displacement"},
      .law = MakeLaw<PendulumGeometry>()};
  return effect;
}

}  // namespace uiclink
