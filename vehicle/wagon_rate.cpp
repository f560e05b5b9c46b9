#include "vehicle/wagon_rate.h"

#include <cmath>
#include <type_traits>

#include "vehicle/contact_lanes.h"
#include "vehicle/corner_force.h"
#include "vehicle/guidance.h"
#include "vehicle/lanes.h"
#include "vehicle/processors.h"
#include "vehicle/wheel_force.h"

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

// ---------------------------------------------------------------------------------------------------------------------
// double: four corners at once.

[[gnu::always_inline]] inline WheelForces<Lanes> CalcWheels(const Wagon& w, const WheelsetMotion<Lanes>& m,
                                                            const WheelSettings& settings) {
  const auto approach = [&](const WheelContact<Lanes>& c, const KinematicPose<Lanes>& pose) {
    if (w.options.penetration == Penetration::kTouching) return CalcApproach(m, c, pose);
    alignas(32) double q0[kCorners], a_rail[kCorners];
    for (std::size_t i = 0; i < kCorners; ++i) {
      q0[i] = w.contact.CalcStaticApproach(m.y[i]);
      a_rail[i] = w.contact.CalcRailDistance(m.y[i]);
    }
    return CalcPrintedApproach(m, c, Lanes(q0), Lanes(a_rail));
  };
  return CalcWheels([&](std::size_t) -> const ContactCurve& { return w.contact; }, m, settings, approach);
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
  const WheelsetMotion<Lanes> motion = SeeFromWheel(at, CalcSineCosine(at.Axle(wheelset::kPhi)), V / w.r0);
  WheelForces<Lanes> wheels =
      CalcWheels(w, motion, {.per_V = 1 / V, .mu = w.mu, .printed_roll = w.options.printed_roll});
  Mirror(at.Side(), &wheels.total);

  const Wagon::Fixed& fixed = w.fixed();
  const CornerPlace<Lanes> place{.e_b = Lanes(fixed.e_b.data()),
                                 .X = Lanes(fixed.X.data()),
                                 .Y = Lanes(fixed.Y.data()),
                                 .s_eq = Lanes(fixed.s_eq.data())};
  const CornerDeflection<Lanes> d = CalcDeflection(w.body.h, at, place);
  const Lanes S_x = CalcLinks(w.longitudinal, links.longitudinal, d.dx, d.vx, w.all_links_affine());
  const Lanes S_y = CalcLinks(w.lateral, links.lateral, d.dy, d.vy, w.all_links_affine());
  Lanes guide_x(0.0), guide_y(0.0);
  if (w.options.guidance) {
    guide_x = CalcStopForce(w.guidance.longitudinal, d.dx);
    guide_y = CalcStopForce(w.guidance.lateral, d.dy);
  }
  Lanes spring(0.0), leaf_rate(0.0);
  CalcSpring(w.options.suspension, w, d.s, d.vs, at.Leaf(), &spring, &leaf_rate);
  const CornerTotals<Lanes> corner = CalcCorner(w.body.h, at, place, S_x + guide_x, S_y + guide_y, -spring);

  const std::array<Resultant<double>, kAxles> axles{SumOfAxle(wheels.total, corner.on_wheelset, 0),
                                                    SumOfAxle(wheels.total, corner.on_wheelset, 1)};
  const BodyTotals<double> on_body{SumOfAll(corner.body_y), SumOfAll(corner.body_z), SumOfAll(corner.body_roll),
                                   SumOfAll(corner.body_yaw)};
  Assemble(fixed, w.g, x, axles, on_body, rate);
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
  BodyTotals<T> on_body{T(0.0), T(0.0), T(0.0), T(0.0)};

  for (std::size_t i = 0; i < kCorners; ++i) {
    const OneCorner<T> at{x, i};
    WheelForces<T> wheel = CalcWheel(w, SeeFromWheel(at, CalcSineCosine(at.Axle(wheelset::kPhi)), V / w.r0), settings);
    Mirror(at.Side(), &wheel.total);

    const CornerPlace<double> place = PlaceOf(w, i);
    const CornerDeflection<T> d = CalcDeflection(w.body.h, at, place);
    T P_x = CalcLink(w.longitudinal[i], links.longitudinal[i], d.dx, d.vx);
    T P_y = CalcLink(w.lateral[i], links.lateral[i], d.dy, d.vy);
    if (w.options.guidance) {
      P_x += CalcStopForce(w.guidance.longitudinal, d.dx);
      P_y += CalcStopForce(w.guidance.lateral, d.dy);
    }
    T spring(0.0), leaf_rate(0.0);
    CalcSpring(w.options.suspension, w, d.s, d.vs, at.Leaf(), &spring, &leaf_rate);
    const CornerTotals<T> corner = CalcCorner(w.body.h, at, place, P_x, P_y, T(-spring));
    (*rate)[kLeafForces + i] = leaf_rate;

    Resultant<T>& axle = axles[AxleOf(i)];
    axle.x += wheel.total.x + corner.on_wheelset.x;
    axle.y += wheel.total.y + corner.on_wheelset.y;
    axle.z += wheel.total.z + corner.on_wheelset.z;
    axle.roll += wheel.total.roll + corner.on_wheelset.roll;
    axle.pitch += wheel.total.pitch;
    axle.yaw += wheel.total.yaw + corner.on_wheelset.yaw;
    on_body.y += corner.body_y;
    on_body.z += corner.body_z;
    on_body.roll += corner.body_roll;
    on_body.yaw += corner.body_yaw;
  }
  Assemble(w.fixed(), w.g, x, axles, on_body, rate);
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
