#pragma once

#include "vehicle/vertical_spring.h"
#include "vehicle/wagon.h"
#include "vehicle/wheel_force.h"

namespace uiclink {

// As in wheel_force.h, V is Lanes (four corners at once, or one of each of four wagons) or a scalar (one corner). "At"
// gives the motions of the corner's wheelset and of the body by their index, Axle(i) and Body(i), and its Side().

/// @param roll  of the wheelset's roll.
/// @param pitch_rate  V/r0 [rad/s]
template <typename At, typename P>
[[gnu::always_inline]] inline WheelsetMotion<typename At::V> SeeFromWheel(const At& at,
                                                                          const SineCosine<typename At::V>& roll,
                                                                          const P& pitch_rate) {
  const auto side = at.Side();
  return {.vx = at.Axle(wheelset::kXRate),
          .y = side * at.Axle(wheelset::kY),
          .vy = side * at.Axle(wheelset::kYRate),
          .z = at.Axle(wheelset::kZ),
          .vz = at.Axle(wheelset::kZRate),
          .phi = side * at.Axle(wheelset::kPhi),
          .vphi = side * at.Axle(wheelset::kPhiRate),
          .sin_phi = side * roll.sine,
          .cos_phi = roll.cosine,
          .pitch_rate = pitch_rate + at.Axle(wheelset::kBeta),
          .psi = side * at.Axle(wheelset::kPsi),
          .vpsi = side * at.Axle(wheelset::kPsiRate)};
}

template <typename S, typename V>
[[gnu::always_inline]] inline void Mirror(const S& side, Resultant<V>* total) {
  total->y = side * total->y;
  total->roll = side * total->roll;
  total->yaw = side * total->yaw;
}

template <typename At, typename H, typename K>
[[gnu::always_inline]] inline CornerDeflection<typename At::V> CalcDeflection(const H& h, const At& at,
                                                                              const CornerPlace<K>& place) {
  return CalcDeflection<typename At::V>(
      place, h, [&](std::size_t i) -> decltype(auto) { return at.Axle(i); },
      [&](std::size_t i) -> decltype(auto) { return at.Body(i); });
}

/// What a corner adds to the forces and moments on its wheelset and on the body.
template <typename V>
struct CornerTotals {
  Resultant<V> on_wheelset;
  V body_y, body_z, body_roll, body_yaw;
  V leaf_rate;
};

/// Force of the vertical spring, > 0 in compression, and the rate of a leaf spring's force.
/// @param w  Wagon, or four of them.
template <typename W, typename V>
[[gnu::always_inline]] inline void CalcSpring(Suspension suspension, const W& w, const V& s, const V& vs,
                                              const V& leaf_force, V* force, V* leaf_rate) {
  switch (suspension) {
    case Suspension::kLinear:
      *force = CalcSpringForce(w.linear, s, vs);
      break;
    case Suspension::kParabolic:
      *force = CalcSpringForce(w.parabolic, w.parabolic_damping, s, vs);
      break;
    case Suspension::kLeaf:
      *force = leaf_force;
      *leaf_rate = CalcLeafRate(w.leaf, leaf_force, s, vs);
      break;
  }
}

/// From the forces at a corner (on the wheelset, track frame) to those of wheelset and body.
/// @param h  of the body.
template <typename At, typename H, typename K>
[[gnu::always_inline]] inline CornerTotals<typename At::V> CalcCorner(const H& h, const At& at,
                                                                      const CornerPlace<K>& place,
                                                                      const typename At::V& P_x,
                                                                      const typename At::V& P_y,
                                                                      const typename At::V& P_z) {
  using V = typename At::V;
  CornerTotals<V> t;
  t.on_wheelset.x = P_x;
  t.on_wheelset.y = P_y;
  t.on_wheelset.z = P_z;
  t.on_wheelset.roll = place.e_b * (P_z - at.Axle(wheelset::kPhi) * P_y);
  t.on_wheelset.yaw = -(place.e_b * (P_x + at.Axle(wheelset::kPsi) * P_y));

  // The opposite on the body, turned into its frame for the moments: B_x, B_y, B_z.
  const V& phi = at.Body(body::kPhi);
  const V& psi = at.Body(body::kPsi);
  const V B_x = -(P_x + psi * P_y);
  const V B_y = psi * P_x - P_y - phi * P_z;
  const V B_z = phi * P_y - P_z;
  t.body_y = -P_y;
  t.body_z = -P_z;
  t.body_roll = h * B_y + place.Y * B_z;
  t.body_yaw = place.X * B_y - place.Y * B_x;
  return t;
}

/// Forces and moments on the body that move it.
template <typename T>
struct BodyTotals {
  T y, z, roll, yaw;
};

/// The rates from the sums.
/// @param k  Wagon::Fixed, or the same of four wagons.
template <typename K, typename G, typename T>
[[gnu::always_inline]] inline void Assemble(const K& k, const G& g, const StateVector<T>& x,
                                            const std::array<Resultant<T>, kAxles>& axles, const BodyTotals<T>& on_body,
                                            StateVector<T>* rate) {
  StateVector<T>& r = *rate;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const std::size_t at = axle * wheelset::kSize;
    const Resultant<T>& f = axles[axle];
    r[at + wheelset::kX] = x[at + wheelset::kXRate];
    r[at + wheelset::kXRate] = f.x * k.per_m_w;
    r[at + wheelset::kY] = x[at + wheelset::kYRate];
    r[at + wheelset::kYRate] = f.y * k.per_m_w;
    r[at + wheelset::kZ] = x[at + wheelset::kZRate];
    r[at + wheelset::kZRate] = f.z * k.per_m_w - g;
    r[at + wheelset::kPhi] = x[at + wheelset::kPhiRate];
    r[at + wheelset::kPhiRate] = f.roll * k.per_I_wx;
    r[at + wheelset::kBeta] = f.pitch * k.per_I_wy;
    r[at + wheelset::kPsi] = x[at + wheelset::kPsiRate];
    r[at + wheelset::kPsiRate] = f.yaw * k.per_I_wz;
  }
  r[kBody + body::kY] = x[kBody + body::kYRate];
  r[kBody + body::kYRate] = on_body.y * k.per_m_c;
  r[kBody + body::kZ] = x[kBody + body::kZRate];
  r[kBody + body::kZRate] = on_body.z * k.per_m_c - g;
  r[kBody + body::kPhi] = x[kBody + body::kPhiRate];
  r[kBody + body::kPhiRate] = on_body.roll * k.per_I_cx;
  r[kBody + body::kPsi] = x[kBody + body::kPsiRate];
  r[kBody + body::kPsiRate] = on_body.yaw * k.per_I_cz;
}

}  // namespace uiclink
