#include "vehicle/wagon_rate.h"

#include <cmath>
#include <type_traits>

#include "vehicle/guidance.h"
#include "vehicle/lanes.h"
#include "vehicle/vertical_spring.h"
#include "vehicle/wheel_force.h"

// The rate is compiled twice, for processors with and without vectors of four doubles, and chosen when the program is
// loaded. Both give the same numbers (lanes.h).
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define UICLINK_FOR_EACH_PROCESSOR __attribute__((target_clones("avx2", "default")))
#else
#define UICLINK_FOR_EACH_PROCESSOR
#endif

namespace uiclink {
namespace {

// Wheels and corners are computed as on the left side (wheel_force.h).

// ---------------------------------------------------------------------------------------------------------------------
// Four corners at once for double, one after the other for scalars with derivatives.

constexpr std::array<double, kCorners> kSides{1, -1, 1, -1};

/// What of the state belongs to a corner, as a value for all four (Lanes) or for one.
struct AllCorners {
  using V = Lanes;
  const StateVector<double>& x;

  [[gnu::always_inline]] V Axle(std::size_t i) const {
    const double front = x[i];
    const double rear = x[kRearWheelset + i];
    return {front, front, rear, rear};
  }
  [[gnu::always_inline]] V Body(std::size_t i) const { return x[kBody + i]; }
  [[gnu::always_inline]] V Leaf() const { return Lanes(&x[kLeafForces]); }
  [[gnu::always_inline]] static V Side() { return Lanes(kSides.data()); }
};

template <typename T>
struct OneCorner {
  using V = T;
  const StateVector<T>& x;
  std::size_t corner;

  const V& Axle(std::size_t i) const { return x[AxleOf(corner) * wheelset::kSize + i]; }
  const V& Body(std::size_t i) const { return x[kBody + i]; }
  const V& Leaf() const { return x[kLeafForces + corner]; }
  V Side() const { return V(SideOf(corner)); }
};

/// @param pitch_rate  V/r0 [rad/s]
template <typename At>
[[gnu::always_inline]] inline WheelsetMotion<typename At::V> SeeFromWheel(const At& at, double pitch_rate) {
  const auto side = at.Side();
  const SineCosine<typename At::V> roll = CalcSineCosine(at.Axle(wheelset::kPhi));
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

template <typename V>
void Mirror(const V& side, Resultant<V>* total) {
  total->y = side * total->y;
  total->roll = side * total->roll;
  total->yaw = side * total->yaw;
}

template <typename V>
struct CornerTotals {
  Resultant<V> on_wheelset;
  V body_y, body_z, body_roll, body_yaw;
  V leaf_rate;
};

/// Force of the vertical spring, > 0 in compression, and the rate of a leaf spring's force.
template <typename V>
[[gnu::always_inline]] inline void CalcSpring(const Wagon& w, const V& s, const V& vs, const V& leaf_force, V* force,
                                              V* leaf_rate) {
  switch (w.options.suspension) {
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

template <typename At, typename K>
[[gnu::always_inline]] inline CornerDeflection<typename At::V> CalcDeflection(const Wagon& w, const At& at,
                                                                              const CornerPlace<K>& place) {
  return CalcDeflection<typename At::V>(
      place, w.body.h, [&](std::size_t i) -> decltype(auto) { return at.Axle(i); },
      [&](std::size_t i) -> decltype(auto) { return at.Body(i); });
}

/// From the forces at a corner (on the wheelset, track frame) to those of wheelset and body.
template <typename At, typename K>
[[gnu::always_inline]] inline CornerTotals<typename At::V> CalcCorner(const Wagon& w, const At& at,
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
  t.body_roll = w.body.h * B_y + place.Y * B_z;
  t.body_yaw = place.X * B_y - place.Y * B_x;
  return t;
}

/// The rates from the sums.
template <typename T>
[[gnu::always_inline]] inline void Assemble(const Wagon& w, const StateVector<T>& x,
                                            const std::array<Resultant<T>, kAxles>& axles, const T& body_y,
                                            const T& body_z, const T& body_roll, const T& body_yaw,
                                            StateVector<T>* rate) {
  StateVector<T>& r = *rate;
  const Wagon::Fixed& k = w.fixed();
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const std::size_t at = axle * wheelset::kSize;
    const Resultant<T>& f = axles[axle];
    r[at + wheelset::kX] = x[at + wheelset::kXRate];
    r[at + wheelset::kXRate] = f.x * k.per_m_w;
    r[at + wheelset::kY] = x[at + wheelset::kYRate];
    r[at + wheelset::kYRate] = f.y * k.per_m_w;
    r[at + wheelset::kZ] = x[at + wheelset::kZRate];
    r[at + wheelset::kZRate] = f.z * k.per_m_w - w.g;
    r[at + wheelset::kPhi] = x[at + wheelset::kPhiRate];
    r[at + wheelset::kPhiRate] = f.roll * k.per_I_wx;
    r[at + wheelset::kBeta] = f.pitch * k.per_I_wy;
    r[at + wheelset::kPsi] = x[at + wheelset::kPsiRate];
    r[at + wheelset::kPsiRate] = f.yaw * k.per_I_wz;
  }
  r[kBody + body::kY] = x[kBody + body::kYRate];
  r[kBody + body::kYRate] = body_y * k.per_m_c;
  r[kBody + body::kZ] = x[kBody + body::kZRate];
  r[kBody + body::kZRate] = body_z * k.per_m_c - w.g;
  r[kBody + body::kPhi] = x[kBody + body::kPhiRate];
  r[kBody + body::kPhiRate] = body_roll * k.per_I_cx;
  r[kBody + body::kPsi] = x[kBody + body::kPsiRate];
  r[kBody + body::kPsiRate] = body_yaw * k.per_I_cz;
}

// ---------------------------------------------------------------------------------------------------------------------
// double: four corners at once.

/// Contact quantities of the four wheels: each wheel's from its cell, several quantities at once, then turned so that
/// each quantity has the four wheels in its lanes.
struct FourContacts {
  static_assert(ContactCurve::kQuantities == 8);
  Lanes first[kCorners];   ///< quantities 0 to 3 by wheel
  Lanes second[kCorners];  ///< 4 to 7
  alignas(32) double pose[2][kCorners];
  ContactCurve::Place places[kCorners];
  bool jumps;

  [[gnu::always_inline]] void Set(std::size_t wheel, const ContactCurve::Cubic& c, double t) {
    const auto at = [&](std::size_t i) {
      return ((Lanes(&c[3][i]) * t + Lanes(&c[2][i])) * t + Lanes(&c[1][i])) * t + Lanes(&c[0][i]);
    };
    first[wheel] = at(0);
    second[wheel] = at(4);
  }
  [[gnu::always_inline]] void Find(const ContactCurve& curve, const Lanes& y) {
    jumps = false;
    for (std::size_t wheel = 0; wheel < kCorners; ++wheel) {
      const ContactCurve::Place place = curve.Find(y[wheel]);
      places[wheel] = place;
      Set(wheel, curve.cubic(place.cell), place.t);
      const ContactCurve::PoseCubic& c = curve.pose_cubic(place.cell);
      for (std::size_t i = 0; i < 2; ++i)
        pose[i][wheel] = ((c[3][i] * place.t + c[2][i]) * place.t + c[1][i]) * place.t + c[0][i];
      jumps |= curve.after_jump(place.cell) != nullptr;
    }
  }
  [[gnu::always_inline]] WheelContact<Lanes> Contact() const {
    Lanes a = first[0], r = first[1], sine = first[2], cosine = first[3];
    Lanes n = second[0], f11 = second[1], f22 = second[2], f23 = second[3];
    Lanes::Transpose(&a, &r, &sine, &cosine);
    Lanes::Transpose(&n, &f11, &f22, &f23);
    return {a, r, sine, cosine, n, f11, f22, f23};
  }
  [[gnu::always_inline]] KinematicPose<Lanes> Pose() const { return {Lanes(pose[0]), Lanes(pose[1])}; }
};

[[gnu::always_inline]] inline Lanes CalcApproach(const Wagon& w, const WheelsetMotion<Lanes>& m,
                                                 const WheelContact<Lanes>& c, const FourContacts& contacts) {
  if (w.options.penetration == Penetration::kTouching) return CalcApproach(m, c, contacts.Pose());
  alignas(32) double q0[kCorners], a_rail[kCorners];
  for (std::size_t i = 0; i < kCorners; ++i) {
    q0[i] = w.contact.CalcStaticApproach(m.y[i]);
    a_rail[i] = w.contact.CalcRailDistance(m.y[i]);
  }
  return CalcPrintedApproach(m, c, Lanes(q0), Lanes(a_rail));
}

[[gnu::always_inline]] inline WheelForces<Lanes> CalcWheels(const Wagon& w, const WheelsetMotion<Lanes>& m,
                                                            const WheelSettings& settings) {
  FourContacts contacts;
  contacts.Find(w.contact, m.y);
  const WheelContact<Lanes> contact = contacts.Contact();
  WheelForces<Lanes> forces = CalcWheel(m, contact, CalcApproach(w, m, contact, contacts), settings);
  if (contacts.jumps) [[unlikely]] {
    alignas(32) double share[kCorners] = {0, 0, 0, 0};
    for (std::size_t i = 0; i < kCorners; ++i) {
      const ContactCurve::Place& place = contacts.places[i];
      if (const ContactCurve::Cubic* after = w.contact.after_jump(place.cell)) {
        contacts.Set(i, *after, place.t);
        share[i] = ContactCurve::ShareAfter(place.t);
      }
    }
    const WheelContact<Lanes> after = contacts.Contact();
    Blend(Lanes(share), CalcWheel(m, after, CalcApproach(w, m, after, contacts), settings), &forces);
  }
  return forces;
}

/// F = C - K d - c v of four links; what is not affine is added corner by corner.
[[gnu::always_inline]] inline Lanes CalcLinks(const std::array<Link, kCorners>& links,
                                              const std::array<LinkState, kCorners>& states, const Lanes& d,
                                              const Lanes& v, bool all_affine) {
  const Lanes K(states[0].K, states[1].K, states[2].K, states[3].K);
  const Lanes C(states[0].C, states[1].C, states[2].C, states[3].C);
  const Lanes c(states[0].c, states[1].c, states[2].c, states[3].c);
  const Lanes affine = C - K * d - c * v;
  if (all_affine) return affine;
  alignas(32) double other[kCorners];
  for (std::size_t i = 0; i < kCorners; ++i)
    other[i] = links[i].is_affine() ? 0.0 : states[i].CalcOther(links[i], d[i], v[i]);
  return affine + Lanes(other);
}

[[gnu::always_inline]] inline double SumOfAxle(const Lanes& v, std::size_t axle) {
  return v[2 * axle] + v[2 * axle + 1];
}
[[gnu::always_inline]] inline double SumOfAll(const Lanes& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

[[gnu::always_inline]] inline Resultant<double> SumOfAxle(const Resultant<Lanes>& wheels, const Resultant<Lanes>& boxes,
                                                          std::size_t axle) {
  return {SumOfAxle(wheels.x + boxes.x, axle), SumOfAxle(wheels.y + boxes.y, axle),
          SumOfAxle(wheels.z + boxes.z, axle), SumOfAxle(wheels.roll + boxes.roll, axle),
          SumOfAxle(wheels.pitch, axle),       SumOfAxle(wheels.yaw + boxes.yaw, axle)};
}

void Store(const WheelForces<Lanes>& f, const Lanes& side, WagonForces* out) {
  for (std::size_t i = 0; i < kCorners; ++i) {
    out->wheels[i] = {.q = f.q[i],
                      .N = f.N[i],
                      .F_x = f.F_x[i],
                      .F_y = side[i] * f.F_y[i],
                      .xi_x = f.xi_x[i],
                      .xi_y = side[i] * f.xi_y[i],
                      .xi_s = side[i] * f.xi_s[i],
                      .Q = f.total.z[i],
                      .Y = f.total.y[i],
                      .X = f.total.x[i],
                      .roll = f.total.roll[i],
                      .pitch = f.total.pitch[i],
                      .yaw = f.total.yaw[i]};
  }
}

[[gnu::always_inline]] inline void CalcAll(const Wagon& w, double V, const LinkStates& links,
                                           const StateVector<double>& x, StateVector<double>* rate, WagonForces* out) {
  const AllCorners at{x};
  const WheelsetMotion<Lanes> motion = SeeFromWheel(at, V / w.r0);
  WheelForces<Lanes> wheels =
      CalcWheels(w, motion, {.per_V = 1 / V, .mu = w.mu, .printed_roll = w.options.printed_roll});
  Mirror(at.Side(), &wheels.total);

  const Wagon::Fixed& fixed = w.fixed();
  const CornerPlace<Lanes> place{.e_b = Lanes(fixed.e_b.data()),
                                 .X = Lanes(fixed.X.data()),
                                 .Y = Lanes(fixed.Y.data()),
                                 .s_eq = Lanes(fixed.s_eq.data())};
  const CornerDeflection<Lanes> d = CalcDeflection(w, at, place);
  const Lanes S_x = CalcLinks(w.longitudinal, links.longitudinal, d.dx, d.vx, w.all_links_affine());
  const Lanes S_y = CalcLinks(w.lateral, links.lateral, d.dy, d.vy, w.all_links_affine());
  Lanes guide_x(0.0), guide_y(0.0);
  if (w.options.guidance) {
    guide_x = CalcStopForce(w.guidance.longitudinal, d.dx);
    guide_y = CalcStopForce(w.guidance.lateral, d.dy);
  }
  Lanes spring(0.0), leaf_rate(0.0);
  CalcSpring(w, d.s, d.vs, at.Leaf(), &spring, &leaf_rate);
  const CornerTotals<Lanes> corner = CalcCorner(w, at, place, S_x + guide_x, S_y + guide_y, -spring);

  const std::array<Resultant<double>, kAxles> axles{SumOfAxle(wheels.total, corner.on_wheelset, 0),
                                                    SumOfAxle(wheels.total, corner.on_wheelset, 1)};
  Assemble<double>(w, x, axles, SumOfAll(corner.body_y), SumOfAll(corner.body_z), SumOfAll(corner.body_roll),
                   SumOfAll(corner.body_yaw), rate);
  leaf_rate.Store(&(*rate)[kLeafForces]);

  if (out == nullptr) return;
  Store(wheels, at.Side(), out);
  S_x.Store(out->link_x.data());
  S_y.Store(out->link_y.data());
  spring.Store(out->spring.data());
  guide_x.Store(out->guide_x.data());
  guide_y.Store(out->guide_y.data());
}

UICLINK_FOR_EACH_PROCESSOR
void CalcRateOfDoubles(const Wagon& w, double V, const LinkStates& links, const StateVector<double>& x,
                       StateVector<double>* rate, WagonForces* out) {
  CalcAll(w, V, links, x, rate, out);
}

// ---------------------------------------------------------------------------------------------------------------------
// Scalars with derivatives: corner by corner.

template <typename T>
WheelForces<T> CalcWheel(const Wagon& w, const WheelsetMotion<T>& m, const WheelSettings& settings) {
  const ContactCurve& curve = w.contact;
  const ContactCurve::Place place = curve.Find(Value(m.y));
  const T t = curve.Local(m.y, place);
  const auto at = [&](const ContactCurve::Cubic& cubic) {
    const WheelContact<T> contact = ContactCurve::Evaluate(cubic, t);
    if (w.options.penetration == Penetration::kTouching) {
      const KinematicPose<T> pose = ContactCurve::Evaluate(curve.pose_cubic(place.cell), t);
      return CalcWheel(m, contact, CalcApproach(m, contact, pose), settings);
    }
    return CalcWheel(m, contact,
                     CalcPrintedApproach(m, contact, curve.CalcStaticApproach(m.y), curve.CalcRailDistance(m.y)),
                     settings);
  };
  WheelForces<T> forces = at(curve.cubic(place.cell));
  if (const ContactCurve::Cubic* after = curve.after_jump(place.cell))
    Blend(ContactCurve::ShareAfter(t), at(*after), &forces);
  return forces;
}

/// The force of a link with its derivatives, by its slopes.
template <typename T>
T CalcLink(const Link& link, const LinkState& state, const T& d, const T& v) {
  const LinkState::Slopes s = state.CalcSlopes(link, Value(d), Value(v));
  T F = s.F_d * (d - Value(d)) + s.F_v * (v - Value(v));
  SetValue(F, s.F);
  return F;
}

template <typename T>
void CalcRateOfDuals(const Wagon& w, double V, const LinkStates& links, const StateVector<T>& x, StateVector<T>* rate) {
  const WheelSettings settings{.per_V = 1 / V, .mu = w.mu, .printed_roll = w.options.printed_roll};
  std::array<Resultant<T>, kAxles> axles;
  for (Resultant<T>& axle : axles) axle = {T(0.0), T(0.0), T(0.0), T(0.0), T(0.0), T(0.0)};
  T body_y(0.0), body_z(0.0), body_roll(0.0), body_yaw(0.0);

  for (std::size_t i = 0; i < kCorners; ++i) {
    const OneCorner<T> at{x, i};
    WheelForces<T> wheel = CalcWheel(w, SeeFromWheel(at, V / w.r0), settings);
    Mirror(at.Side(), &wheel.total);

    const CornerPlace<double> place = PlaceOf(w, i);
    const CornerDeflection<T> d = CalcDeflection(w, at, place);
    T P_x = CalcLink(w.longitudinal[i], links.longitudinal[i], d.dx, d.vx);
    T P_y = CalcLink(w.lateral[i], links.lateral[i], d.dy, d.vy);
    if (w.options.guidance) {
      P_x += CalcStopForce(w.guidance.longitudinal, d.dx);
      P_y += CalcStopForce(w.guidance.lateral, d.dy);
    }
    T spring(0.0), leaf_rate(0.0);
    CalcSpring(w, d.s, d.vs, at.Leaf(), &spring, &leaf_rate);
    const CornerTotals<T> corner = CalcCorner(w, at, place, P_x, P_y, T(-spring));
    (*rate)[kLeafForces + i] = leaf_rate;

    Resultant<T>& axle = axles[AxleOf(i)];
    axle.x += wheel.total.x + corner.on_wheelset.x;
    axle.y += wheel.total.y + corner.on_wheelset.y;
    axle.z += wheel.total.z + corner.on_wheelset.z;
    axle.roll += wheel.total.roll + corner.on_wheelset.roll;
    axle.pitch += wheel.total.pitch;
    axle.yaw += wheel.total.yaw + corner.on_wheelset.yaw;
    body_y += corner.body_y;
    body_z += corner.body_z;
    body_roll += corner.body_roll;
    body_yaw += corner.body_yaw;
  }
  Assemble(w, x, axles, body_y, body_z, body_roll, body_yaw, rate);
}

}  // namespace

template <>
void CalcRate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x,
              StateVector<double>* rate) {
  CalcRateOfDoubles(wagon, V, links, x, rate, nullptr);
}

template <>
void CalcRate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<Dual<kMaxState>>& x,
              StateVector<Dual<kMaxState>>* rate) {
  CalcRateOfDuals(wagon, V, links, x, rate);
}

void CalcForces(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x,
                StateVector<double>* rate, WagonForces* forces) {
  CalcRateOfDoubles(wagon, V, links, x, rate, forces);
}

}  // namespace uiclink
