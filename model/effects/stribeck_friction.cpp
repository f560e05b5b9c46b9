#include <cmath>

#include "model/effects/catalogue.h"

namespace uiclink {
namespace {

/// A joint that sticks breaks out at T0 (1 + s); one that slides has T0 (1 + s exp(-(v/v_s)^2)). p = {s, v_s}.
template <typename T>
struct StribeckFriction {
  static T Sliding(const LawParameters<T>& p, const T& speed) {
    using std::exp;
    const T x = speed / p[1];
    return p[0] * exp(-x * x);
  }
  static T Slope(const LawParameters<T>& p, const T& speed) { return -2.0 * speed / (p[1] * p[1]) * Sliding(p, speed); }
  static T Sticking(const LawParameters<T>& p) { return p[0]; }

  /// Towards the turning point the limit of the deflection, y_c (1 + s exp(-(v/v_s)^2)), rises at the rate
  ///   y_c s exp(-(v/v_s)^2) 2 v a/v_s^2.
  /// The joint slides while that is below v, so it sticks at exp(-(v/v_s)^2) = 1/q,  q = 2 y_c s a/v_s^2, if q > 1.
  static T StickingSpeedSquared(const LawParameters<T>& p, const T& y_c, const T& a) {
    using std::log;
    const T q = 2.0 * y_c * p[0] * a / (p[1] * p[1]);
    return Value(q) > 1 ? T(p[1] * p[1] * log(q)) : T(0);
  }

  static void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) {
    oscillator->speed_terms.Add({.p = {p[0], p[1]},
                                 .sliding = &Sliding,
                                 .slope = &Slope,
                                 .sticking = &Sticking,
                                 .sticking_speed_squared = &StickingSpeedSquared});
  }
};

}  // namespace

const Effect& StribeckFrictionEffect() {
  static const Effect effect{
      .id = "stribeck_friction",
      .title = "friction that falls from a static peak with the speed of sliding",
      .equation = "a joint breaks out at T0 (1 + s) and slides at T0 (1 + s exp(-(y'/v_s)^2))",
      .acts_on = ActsOn::kFrictionLaw,
      .parameters = {{.symbol = "s",
                      .unit = "-",
                      .meaning = "static excess",
                      .low = 0,
                      .high = 1.5,  // dry steel: static friction up to some 2.5 times the kinetic one
                      .starts = {0.15}},
                     {.symbol = "v_s",
                      .unit = "m/s",
                      .meaning = "Stribeck speed",
                      .low = 1e-3,
                      .high = 0.5,  // above the largest speeds of a link: then s is part of T0
                      .coordinate = Coordinate::kLog,
                      .start_scale = StartScale::kSpeed,
                      .starts = {0.1, 0.3}}},
      .signature = {.text = "T0 from the locked state exceeds T0 from the decrement; a step of force at each breakout"},
      .confused_with = "clearance, velocity_strengthening, cubic_stiffness",
      .separated_by = "many small releases just above the slip of the joints, where the speed stays below v_s",
      .repairs = {"T0_from_lock", "T0_from_decrement", "T0_from_centre", "residual_against_velocity",
                  "loss_per_half_cycle"},
      .law = MakeLaw<StribeckFriction>()};
  return effect;
}

}  // namespace uiclink
