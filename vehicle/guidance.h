#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "model/scalar.h"
#include "vehicle/lanes.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

// Guidance impacts (chapter 6): linear springs beyond a clearance, without damping. T is double or Dual<N>; no function
// allocates. The force is continuous at contact, its slope is not: an integrator that holds the side between events
// keeps its order.

/// +1 or -1 where a stop is touched on that side, 0 in the free travel.
template <typename T>
int TouchedSide(const GuidanceStop& stop, const T& d) {
  if (Value(d) > stop.clearance) return 1;
  return Value(d) < -stop.clearance ? -1 : 0;
}

/// Penetration into the stop on one side [m], negative while free; its zero is the event. @param side  +1 or -1.
template <typename T>
T CalcPenetration(const GuidanceStop& stop, int side, const T& d) {
  return static_cast<double>(side) * d - stop.clearance;
}

/// Force of the stop of one axle box on the wheelset [N]:  -k (|d| - clearance) sign d  beyond the clearance, 0 within.
/// @param d     displacement of the axle box relative to the body [m].
/// @param side  the side that is touched, fixed between events (TouchedSide).
template <typename T>
T CalcStopForce(const GuidanceStop& stop, int side, const T& d) {
  if (side == 0) return T(0);
  return (-stop.k * side) * CalcPenetration(stop, side, d);
}
/// The side found out from d. V is a scalar or Lanes; Stop is GuidanceStop, or has its numbers in Lanes.
template <typename Stop, typename V>
[[gnu::always_inline]] inline V CalcStopForce(const Stop& stop, const V& d) {
  const V zero(0.0);
  const V beyond = Choose(d < zero, d + stop.clearance, d - stop.clearance);
  return -(stop.k * Choose(d * d < V(stop.clearance * stop.clearance), zero, beyond));
}

/// The longitudinal forces of chapter 6.
enum class GuidanceLaw {
  kPrinted,       ///< along x alone, arm a1 cos psi: not the gradient of a potential, so energy is not conserved
  kConservative,  ///< the gradient of k p^2/2: also tau tan psi along y and tau (a +- y) / cos^2 psi in yaw
};

/// A wheelset alone between its guides (chapter 6, figures 6.2 and 6.3): x, y, psi; six contacts tau_1 .. tau_6.
struct WheelsetBetweenGuides {
  double m = 0;    ///< [kg]
  double I_z = 0;  ///< [kg m^2]
  double a = 0;    ///< lateral distance of the guides from the middle [m]
  double b = 0;    ///< longitudinal clearance [m]
  double c = 0;    ///< lateral clearance [m]
  double k_x = 0;  ///< longitudinal stiffness of a guide [N/m]
  double k_y = 0;  ///< lateral stiffness of a contact [N/m]; two of them act together
  GuidanceLaw law = GuidanceLaw::kPrinted;
};

/// Position of the wheelset.
template <typename T>
struct WheelsetPosition {
  T x{}, y{}, psi{};
};

/// The eight places where it can touch: longitudinal guide of the +y side forward (p1 > b) and backward (p1 < -b), then
/// of the -y side (p2), then lateral contacts 3 to 6.
inline constexpr std::size_t kGuideContacts = 8;

/// Which of them touch: bit i is set while contact i does.
using GuideContacts = std::uint32_t;

/// Penetrations [m], positive in contact. With t = tan psi and q = 1 - cos psi:
///   p1 = (a + y) t + x,  p2 = -(a - y) t + x:   p1 - b,  -p1 - b,  p2 - b,  -p2 - b;
///   3: y - c + (a + c) q,  5: y - c - (a - c) q  on +y;   6: -y - c + (a + c) q,  4: -y - c - (a - c) q  on -y.
template <typename T>
std::array<T, kGuideContacts> CalcPenetrations(const WheelsetBetweenGuides& w, const WheelsetPosition<T>& at) {
  using std::sin;
  using std::tan;
  const T t = tan(at.psi);
  const T half = sin(0.5 * at.psi);
  const T q = 2.0 * half * half;  // 1 - cos psi without cancellation
  const T p1 = (w.a + at.y) * t + at.x;
  const T p2 = (at.y - w.a) * t + at.x;
  return {p1 - w.b,
          -p1 - w.b,
          p2 - w.b,
          -p2 - w.b,
          at.y - w.c + (w.a + w.c) * q,
          -at.y - w.c - (w.a - w.c) * q,
          at.y - w.c - (w.a - w.c) * q,
          -at.y - w.c + (w.a + w.c) * q};
}

/// What touches in a position.
inline GuideContacts FindGuideContacts(const WheelsetBetweenGuides& w, const WheelsetPosition<double>& at) {
  const std::array<double, kGuideContacts> p = CalcPenetrations(w, at);
  GuideContacts contacts = 0;
  for (std::size_t i = 0; i < kGuideContacts; ++i) contacts |= static_cast<GuideContacts>(p[i] > 0) << i;
  return contacts;
}

/// Force and moment on the wheelset.
template <typename T>
struct GuideForce {
  T x{}, y{}, psi{};  ///< [N], [N], [N m]
};

/// Sum of the contacts that `contacts` says:
///   F_x = tau_1 + tau_2,  F_y = tau_3 + .. + tau_6,
///   M = (a + y) tau_1 - (a - y) tau_2 + [(a + c)(tau_3 - tau_6) + (a - c)(tau_4 - tau_5)] sin psi   (section 6.2.2).
template <typename T>
GuideForce<T> CalcGuideForce(const WheelsetBetweenGuides& w, GuideContacts contacts, const WheelsetPosition<T>& at) {
  using std::sin;
  using std::tan;
  const std::array<T, kGuideContacts> p = CalcPenetrations(w, at);
  const auto tau = [&](std::size_t i, double k, double sign) {
    return (contacts >> i) & 1u ? T(-sign * k * p[i]) : T(0);
  };
  const T tau1 = tau(0, w.k_x, 1) + tau(1, w.k_x, -1);
  const T tau2 = tau(2, w.k_x, 1) + tau(3, w.k_x, -1);
  const T tau3 = tau(4, w.k_y, 1), tau4 = tau(5, w.k_y, -1), tau5 = tau(6, w.k_y, 1), tau6 = tau(7, w.k_y, -1);
  GuideForce<T> force;
  force.x = tau1 + tau2;
  force.y = tau3 + tau4 + tau5 + tau6;
  force.psi = ((w.a + w.c) * (tau3 - tau6) + (w.a - w.c) * (tau4 - tau5)) * sin(at.psi);
  const T longitudinal = (w.a + at.y) * tau1 - (w.a - at.y) * tau2;
  if (w.law == GuidanceLaw::kPrinted) {
    force.psi += longitudinal;
  } else {
    const T t = tan(at.psi);
    force.y += (tau1 + tau2) * t;
    force.psi += longitudinal * (1.0 + t * t);
  }
  return force;
}

/// Energy stored in the contacts [J].
template <typename T>
T CalcGuideEnergy(const WheelsetBetweenGuides& w, GuideContacts contacts, const WheelsetPosition<T>& at) {
  const std::array<T, kGuideContacts> p = CalcPenetrations(w, at);
  T energy(0);
  for (std::size_t i = 0; i < kGuideContacts; ++i) {
    if ((contacts >> i) & 1u) energy += 0.5 * (i < 4 ? w.k_x : w.k_y) * p[i] * p[i];
  }
  return energy;
}

}  // namespace uiclink
