#pragma once

#include "vehicle/contact/contact_curve.h"
#include "vehicle/lanes.h"

namespace uiclink {

// V is Lanes (four corners at once) or a scalar (one corner). Every formula below is written for the left side; the
// right one is its mirror image: y, phi, psi and their rates change sign on the way in, lateral forces and moments
// about x and z on the way out.

/// A wheelset as the left wheel sees it, or as the right one sees it in the mirror.
template <typename V>
struct WheelsetMotion {
  V vx, y, vy, z, vz, phi, vphi, sin_phi, cos_phi, pitch_rate, psi, vpsi;
};

/// Force at a wheel or corner on the wheelset (track frame) and its moment about the wheelset's centre (wheelset
/// frame).
template <typename V>
struct Resultant {
  V x, y, z, roll, pitch, yaw;
};

template <typename V>
struct WheelForces {
  V q, N, F_x, F_y, xi_x, xi_y, xi_s;
  Resultant<V> total;
};

/// Sine and cosine of the roll of a wheelset by their series: to the last digit up to 0.1 rad, more than any table has.
template <typename V>
struct SineCosine {
  V sine, cosine;
};
template <typename V>
[[gnu::always_inline]] inline SineCosine<V> CalcSineCosine(const V& x) {
  const V x2 = x * x;
  return {x * (1.0 + x2 * (-1.0 / 6 + x2 * (1.0 / 120 + x2 * (-1.0 / 5040 + x2 * (1.0 / 362880))))),
          1.0 + x2 * (-0.5 + x2 * (1.0 / 24 + x2 * (-1.0 / 720 + x2 * (1.0 / 40320 - x2 * (1.0 / 3628800)))))};
}

/// P is double, or Lanes where every lane is another wagon.
template <typename P>
struct WheelSettingsOf {
  P per_V;  ///< 1/V [s/m]
  P mu;
  bool printed_roll;
};
using WheelSettings = WheelSettingsOf<double>;

/// (3.1) to (3.3) and appendices C, D.  q: approach [m].
template <typename V, typename P>
[[gnu::always_inline]] inline WheelForces<V> CalcWheel(const WheelsetMotion<V>& m, const WheelContact<V>& c,
                                                       const V& approach, const WheelSettingsOf<P>& settings) {
  WheelForces<V> f;
  const V zero(0.0);
  f.q = approach;
  const V q = Choose(zero < approach, approach, zero);
  const V root = SafeSqrt(q);
  const V q_root = q * root;
  f.N = c.n * q_root;

  f.xi_x = 1.0 + (m.vx - c.r * m.pitch_rate - c.a * m.vpsi) * settings.per_V;
  f.xi_y = ((m.vy + c.r * m.vphi) * settings.per_V - m.psi) * c.cos_delta +
           (m.vz + c.a * m.vphi) * settings.per_V * c.sin_delta;
  f.xi_s = (m.vpsi * c.cos_delta - m.pitch_rate * c.sin_delta) * settings.per_V;

  // Kalker's linear forces, then the saturation of Shen, Hedrick and Elkins. No force is below 1e-30 N.
  const V linear_x = -(c.f11 * q * f.xi_x);
  const V linear_y = -(c.f22 * q * f.xi_y + c.f23 * q_root * f.xi_s);
  const V limit = settings.mu * f.N + 1e-30;
  const V u = SafeSqrt(linear_x * linear_x + linear_y * linear_y) / limit;
  const V eps = Choose(u < V(3.0), 1.0 + u * (u * (1.0 / 27) - 1.0 / 3), 1.0 / (u + 1e-30));
  f.F_x = eps * linear_x;
  f.F_y = eps * linear_y;

  const V C_y = c.cos_delta * f.F_y - c.sin_delta * f.N;
  const V C_z = c.sin_delta * f.F_y + c.cos_delta * f.N;
  f.total.x = f.F_x - m.psi * C_y;
  f.total.y = m.psi * f.F_x + m.cos_phi * C_y - m.sin_phi * C_z;
  f.total.z = m.sin_phi * C_y + m.cos_phi * C_z;
  f.total.roll = settings.printed_roll ? c.a * C_z : c.a * C_z + c.r * C_y;
  f.total.pitch = -(c.r * f.F_x);
  f.total.yaw = -(c.a * f.F_x);
  return f;
}

/// The approach from the touching height: the point (a, -r) of the wheel moves by phi - phi_k about the wheelset's
/// centre and by z - z_k with it, seen along the contact's normal.
template <typename V>
[[gnu::always_inline]] inline V CalcApproach(const WheelsetMotion<V>& m, const WheelContact<V>& c,
                                             const KinematicPose<V>& k) {
  return (m.phi - k.phi) * (c.r * c.sin_delta - c.a * c.cos_delta) -
         (m.z - k.z) * (c.cos_delta * m.cos_phi - c.sin_delta * m.sin_phi);
}

/// The approach as appendix E prints it; q0 of the table and a_rail at the wheelset's displacement.
template <typename V>
[[gnu::always_inline]] inline V CalcPrintedApproach(const WheelsetMotion<V>& m, const WheelContact<V>& c, const V& q0,
                                                    const V& a_rail) {
  const V sine = c.sin_delta * m.cos_phi + c.cos_delta * m.sin_phi;
  const V cosine = c.cos_delta * m.cos_phi - c.sin_delta * m.sin_phi;
  return q0 - (a_rail - m.y - c.a - m.phi * c.r) * sine - (m.z + m.phi * c.a) * cosine;
}

template <typename V>
[[gnu::always_inline]] inline void AddShare(const V& share, const V& a, V* b) {
  *b = *b + share * (a - *b);
}

/// The load goes over from contact b to contact a.
template <typename V>
[[gnu::always_inline]] inline void Blend(const V& share, const WheelForces<V>& a, WheelForces<V>* b) {
  AddShare(share, a.q, &b->q);
  AddShare(share, a.N, &b->N);
  AddShare(share, a.F_x, &b->F_x);
  AddShare(share, a.F_y, &b->F_y);
  AddShare(share, a.xi_x, &b->xi_x);
  AddShare(share, a.xi_y, &b->xi_y);
  AddShare(share, a.xi_s, &b->xi_s);
  AddShare(share, a.total.x, &b->total.x);
  AddShare(share, a.total.y, &b->total.y);
  AddShare(share, a.total.z, &b->total.z);
  AddShare(share, a.total.roll, &b->total.roll);
  AddShare(share, a.total.pitch, &b->total.pitch);
  AddShare(share, a.total.yaw, &b->total.yaw);
}

}  // namespace uiclink
