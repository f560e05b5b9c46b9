#include "vehicle/rate_slopes.h"

#include <span>

#include "vehicle/corner_force.h"
#include "vehicle/dual_lanes.h"
#include "vehicle/guidance.h"
#include "vehicle/processors.h"
#include "vehicle/wheel_force.h"

namespace uiclink {
namespace {

// ---------------------------------------------------------------------------------------------------------------------
// Wheels. A wheel depends on ten motions of its wheelset, which it sees as the left one does (wheel_force.h).

/// In the order of the state, without x.
enum WheelInput : std::size_t { kVx, kY, kVy, kZ, kVz, kPhi, kVphi, kSpin, kPsi, kVpsi, kWheelInputs };
using WheelDual = DualLanes<static_cast<int>(kWheelInputs)>;

/// Which inputs change their sign for the right wheel.
constexpr std::array<bool, kWheelInputs> kIsOddInput{false, true, true, false, false, true, true, false, true, true};

[[gnu::always_inline]] inline WheelsetMotion<WheelDual> SeeFromWheels(const StateVector<double>& x, double pitch_rate) {
  const auto axle = [&](std::size_t i) { return Lanes(x[i], x[i], x[kRearWheelset + i], x[kRearWheelset + i]); };
  const Lanes side(1, -1, 1, -1);
  const SineCosine<Lanes> roll = CalcSineCosine(axle(wheelset::kPhi));
  const Lanes sine = side * roll.sine;
  return {.vx = WheelDual(axle(wheelset::kXRate), kVx),
          .y = WheelDual(side * axle(wheelset::kY), kY),
          .vy = WheelDual(side * axle(wheelset::kYRate), kVy),
          .z = WheelDual(axle(wheelset::kZ), kZ),
          .vz = WheelDual(axle(wheelset::kZRate), kVz),
          .phi = WheelDual(side * axle(wheelset::kPhi), kPhi),
          .vphi = WheelDual(side * axle(wheelset::kPhiRate), kVphi),
          .sin_phi = WheelDual(sine, kPhi, roll.cosine),
          .cos_phi = WheelDual(roll.cosine, kPhi, -sine),
          .pitch_rate = WheelDual(pitch_rate + axle(wheelset::kBeta), kSpin),
          .psi = WheelDual(side * axle(wheelset::kPsi), kPsi),
          .vpsi = WheelDual(side * axle(wheelset::kPsiRate), kVpsi)};
}

/// Where the four contacts are in their cells. Beyond the table nothing changes with y any more.
struct FourPlaces {
  std::array<ContactCurve::Place, kCorners> at;
  std::array<double, kCorners> by_y;

  [[gnu::always_inline]] FourPlaces(const ContactCurve& curve, const Lanes& y) {
    for (std::size_t i = 0; i < kCorners; ++i) {
      at[i] = curve.Find(y[i]);
      by_y[i] = y[i] < curve.y_min() || y[i] > curve.y_max() ? 0 : 1 / curve.width();
    }
  }
};

/// Four quantities of a wheel from `first` on, and their slopes by y, from its cubic.
template <typename Cubic>
[[gnu::always_inline]] inline void Evaluate(const Cubic& cubic, std::size_t first, double t, double by_y, Lanes* value,
                                            Lanes* slope) {
  const Lanes c0(&cubic[0][first]), c1(&cubic[1][first]), c2(&cubic[2][first]), c3(&cubic[3][first]);
  *value = ((c3 * t + c2) * t + c1) * t + c0;
  *slope = ((c3 * (3 * t) + c2 * 2.0) * t + c1) * by_y;
}

/// @param cubics  by wheel.
[[gnu::always_inline]] inline WheelContact<WheelDual> EvaluateContacts(
    const std::array<const ContactCurve::Cubic*, kCorners>& cubics, const FourPlaces& places) {
  Lanes q[2][kCorners], by_y[2][kCorners];
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < kCorners; ++i)
      Evaluate(*cubics[i], 4 * half, places.at[i].t, places.by_y[i], &q[half][i], &by_y[half][i]);
    Lanes::Transpose(&q[half][0], &q[half][1], &q[half][2], &q[half][3]);
    Lanes::Transpose(&by_y[half][0], &by_y[half][1], &by_y[half][2], &by_y[half][3]);
  }
  const auto at = [&](std::size_t half, std::size_t i) { return WheelDual(q[half][i], kY, by_y[half][i]); };
  return {at(0, 0), at(0, 1), at(0, 2), at(0, 3), at(1, 0), at(1, 1), at(1, 2), at(1, 3)};
}

/// What a scalar function of y gives for four wheels.
template <typename F>
[[gnu::always_inline]] inline WheelDual CallForEach(const F& f) {
  double value[kCorners], slope[kCorners];
  for (std::size_t i = 0; i < kCorners; ++i) {
    const Dual<1> one = f(i);
    value[i] = one.a;
    slope[i] = one.v[0];
  }
  return {Lanes(value), kY, Lanes(slope)};
}

[[gnu::always_inline]] inline WheelDual CalcApproach(const Wagon& w, const WheelsetMotion<WheelDual>& m,
                                                     const WheelContact<WheelDual>& contact, const FourPlaces& places) {
  const ContactCurve& curve = w.contact;
  if (w.options.penetration == Penetration::kPrinted) {
    const auto y = [&](std::size_t i) { return Dual<1>(m.y.a[i], 0); };
    return CalcPrintedApproach(m, contact, CallForEach([&](std::size_t i) { return curve.CalcStaticApproach(y(i)); }),
                               CallForEach([&](std::size_t i) { return curve.CalcRailDistance(y(i)); }));
  }
  const auto pose = [&](std::size_t quantity) {
    return CallForEach([&](std::size_t i) {
      const ContactCurve::PoseCubic& c = curve.pose_cubic(places.at[i].cell);
      const double t = places.at[i].t;
      Dual<1> one(((c[3][quantity] * t + c[2][quantity]) * t + c[1][quantity]) * t + c[0][quantity]);
      one.v[0] = ((3 * c[3][quantity] * t + 2 * c[2][quantity]) * t + c[1][quantity]) * places.by_y[i];
      return one;
    });
  };
  return uiclink::CalcApproach(m, contact, KinematicPose<WheelDual>{pose(0), pose(1)});
}

/// Share of the contact after a jump; none for wheels whose contact does not jump.
WheelDual CalcShareAfter(const ContactCurve& curve, const FourPlaces& places) {
  return CallForEach([&](std::size_t i) {
    Dual<1> t(places.at[i].t);
    t.v[0] = places.by_y[i];
    return curve.after_jump(places.at[i].cell) == nullptr ? Dual<1>(0.0) : ContactCurve::ShareAfter(t);
  });
}

using FourCubics = std::array<const ContactCurve::Cubic*, kCorners>;

[[gnu::always_inline]] inline WheelForces<WheelDual> CalcWheels(const Wagon& w, const WheelsetMotion<WheelDual>& motion,
                                                                const FourCubics& cubics, const FourPlaces& places,
                                                                const WheelSettings& settings) {
  const WheelContact<WheelDual> contact = EvaluateContacts(cubics, places);
  return CalcWheel(motion, contact, CalcApproach(w, motion, contact, places), settings);
}

[[gnu::always_inline]] inline Resultant<WheelDual> CalcWheels(const Wagon& w, const WheelsetMotion<WheelDual>& motion,
                                                              const WheelSettings& settings) {
  const FourPlaces places(w.contact, motion.y.a);
  FourCubics before, after;
  bool jumps = false;
  for (std::size_t i = 0; i < kCorners; ++i) {
    before[i] = &w.contact.cubic(places.at[i].cell);
    const ContactCurve::Cubic* jump = w.contact.after_jump(places.at[i].cell);
    after[i] = jump == nullptr ? before[i] : jump;
    jumps |= jump != nullptr;
  }
  WheelForces<WheelDual> forces = CalcWheels(w, motion, before, places, settings);
  if (jumps) [[unlikely]]
    Blend(CalcShareAfter(w.contact, places), CalcWheels(w, motion, after, places, settings), &forces);
  return forces.total;
}

/// Sums the wheels of both wheelsets. @param rows  x, y, z, roll, pitch, yaw with the wheels in their lanes.
[[gnu::always_inline]] inline void StoreColumn(const std::array<Lanes, 6>& rows, bool odd_input,
                                               RateSlopes::AxleColumn* front, RateSlopes::AxleColumn* rear) {
  auto [x, y, z, roll, pitch, yaw] = rows;
  Lanes none_1(0.0), none_2(0.0);
  Lanes::Transpose(&x, &y, &z, &roll);
  Lanes::Transpose(&pitch, &yaw, &none_1, &none_2);
  const Lanes right = odd_input ? Lanes(-1, 1, -1, 1) : Lanes(1, -1, 1, -1);  // y, roll and yaw are odd, too
  const auto store = [](const Lanes& first, const Lanes& second, RateSlopes::AxleColumn* column) {
    first.Store(column->data());
    second.Store(column->data() + 4);
  };
  store(x + right * y, pitch + right * yaw, front);
  store(z + right * roll, none_1 + right * none_2, rear);
}

/// Columns of the wheelsets' motions and of the speed.
///
/// By the speed: creepages are velocities divided by V, so that for the six velocities u_i and V
///   V dF/dV + sum u_i dF/du_i = 0,   and the spin has V/r0 in it.
[[gnu::always_inline]] inline void StoreWheels(const Resultant<WheelDual>& f, const WheelsetMotion<WheelDual>& m,
                                               double per_V, double per_r0, RateSlopes* slopes) {
  for (std::size_t i = 0; i < kWheelInputs; ++i)
    StoreColumn({f.x.v[i], f.y.v[i], f.z.v[i], f.roll.v[i], f.pitch.v[i], f.yaw.v[i]}, kIsOddInput[i],
                &slopes->axles[0][1 + i], &slopes->axles[1][1 + i]);
  const auto by_speed = [&](const WheelDual& row) {
    const Lanes sum = m.vx.a * row.v[kVx] + m.vy.a * row.v[kVy] + m.vz.a * row.v[kVz] + m.vphi.a * row.v[kVphi] +
                      m.pitch_rate.a * row.v[kSpin] + m.vpsi.a * row.v[kVpsi];
    return row.v[kSpin] * per_r0 - sum * per_V;
  };
  StoreColumn({by_speed(f.x), by_speed(f.y), by_speed(f.z), by_speed(f.roll), by_speed(f.pitch), by_speed(f.yaw)},
              false, &slopes->by_speed[0], &slopes->by_speed[1]);
}

// ---------------------------------------------------------------------------------------------------------------------
// Corners: three forces, each a function of one deflection and its rate, turned into rows by angles.

enum CornerInput : std::size_t {
  kForceX,
  kForceY,
  kForceZ,
  kWheelsetPhi,
  kWheelsetPsi,
  kBodyPhi,
  kBodyPsi,
  kCornerInputs
};
using CornerDual = DualLanes<static_cast<int>(kCornerInputs)>;

/// The angles that CalcCorner asks for.
struct CornerAngles {
  using V = CornerDual;
  CornerDual wheelset_phi, wheelset_psi, body_phi, body_psi;

  [[gnu::always_inline]] const V& Axle(std::size_t i) const {
    return i == wheelset::kPhi ? wheelset_phi : wheelset_psi;
  }
  [[gnu::always_inline]] const V& Body(std::size_t i) const { return i == body::kPhi ? body_phi : body_psi; }
};

/// A force with its slopes, four corners at once.
struct ForceSlopes {
  Lanes F, by_d, by_v;
};

[[gnu::always_inline]] inline ForceSlopes CalcLinks(const std::array<Link, kCorners>& links,
                                                    const std::array<LinkState, kCorners>& states, const Lanes& d,
                                                    const Lanes& v) {
  double F[kCorners], by_d[kCorners], by_v[kCorners];
  for (std::size_t i = 0; i < kCorners; ++i) {
    const LinkState::Slopes one = states[i].CalcSlopes(links[i], d[i], v[i]);
    F[i] = one.F;
    by_d[i] = one.F_d;
    by_v[i] = one.F_v;
  }
  return {Lanes(F), Lanes(by_d), Lanes(by_v)};
}

[[gnu::always_inline]] inline void AddGuide(const GuidanceStop& stop, const Lanes& d, ForceSlopes* force) {
  const DualLanes<1> guide = CalcStopForce(stop, DualLanes<1>(d, 0));
  force->F = force->F + guide.a;
  force->by_d = force->by_d + guide.v[0];
}

/// All four corners: forces on the wheelset, what they do to the rows, and the leaves.
struct FourCorners {
  ForceSlopes x, y, z;
  Lanes z_by_leaf;
  CornerTotals<CornerDual> rows;
  DualLanes<3> leaf_rate;  ///< by s, s', force

  [[gnu::always_inline]] FourCorners(const Wagon& w, const LinkStates& links, const StateVector<double>& at,
                                     const CornerPlace<Lanes>& place) {
    const auto axle = [&](std::size_t i) { return Lanes(at[i], at[i], at[kRearWheelset + i], at[kRearWheelset + i]); };
    const auto car = [&](std::size_t i) { return Lanes(at[kBody + i]); };
    const CornerDeflection<Lanes> d = CalcDeflection<Lanes>(place, w.body.h, axle, car);
    x = CalcLinks(w.longitudinal, links.longitudinal, d.dx, d.vx);
    y = CalcLinks(w.lateral, links.lateral, d.dy, d.vy);
    if (w.options.guidance) {
      AddGuide(w.guidance.longitudinal, d.dx, &x);
      AddGuide(w.guidance.lateral, d.dy, &y);
    }
    DualLanes<3> spring(0.0);
    leaf_rate = DualLanes<3>(0.0);
    CalcSpring(w.options.suspension, w, DualLanes<3>(d.s, 0), DualLanes<3>(d.vs, 1),
               DualLanes<3>(Lanes(&at[kLeafForces]), 2), &spring, &leaf_rate);
    z = {-spring.a, -spring.v[0], -spring.v[1]};
    z_by_leaf = -spring.v[2];
    const CornerAngles angles{.wheelset_phi = CornerDual(axle(wheelset::kPhi), kWheelsetPhi),
                              .wheelset_psi = CornerDual(axle(wheelset::kPsi), kWheelsetPsi),
                              .body_phi = CornerDual(car(body::kPhi), kBodyPhi),
                              .body_psi = CornerDual(car(body::kPsi), kBodyPsi)};
    rows = CalcCorner(w.body.h, angles, place, CornerDual(x.F, kForceX), CornerDual(y.F, kForceY),
                      CornerDual(z.F, kForceZ));
  }
};

/// What one input of CalcCorner does to the rows of one corner's wheelset and to those of the body.
struct RowSlopes {
  Lanes axle_first, axle_second, body;
};

/// By corner.
[[gnu::always_inline]] inline std::array<RowSlopes, kCorners> Turn(const CornerTotals<CornerDual>& rows,
                                                                   std::size_t input) {
  const Resultant<CornerDual>& f = rows.on_wheelset;
  Lanes x = f.x.v[input], y = f.y.v[input], z = f.z.v[input], roll = f.roll.v[input];
  const Lanes yaw = f.yaw.v[input];
  Lanes body_y = rows.body_y.v[input], body_z = rows.body_z.v[input];
  Lanes body_roll = rows.body_roll.v[input], body_yaw = rows.body_yaw.v[input];
  Lanes::Transpose(&x, &y, &z, &roll);
  Lanes::Transpose(&body_y, &body_z, &body_roll, &body_yaw);
  return {RowSlopes{x, Lanes(0, yaw[0], 0, 0), body_y}, RowSlopes{y, Lanes(0, yaw[1], 0, 0), body_z},
          RowSlopes{z, Lanes(0, yaw[2], 0, 0), body_roll}, RowSlopes{roll, Lanes(0, yaw[3], 0, 0), body_yaw}};
}

/// Columns of a corner.
struct CornerColumns {
  RateSlopes* slopes;
  std::size_t axle;

  [[gnu::always_inline]] static void Add(const Lanes& what, double* to) { (Lanes(to) + what).Store(to); }
  [[gnu::always_inline]] void Add(std::size_t axle_input, std::size_t body_input, const RowSlopes& rows,
                                  double factor) const {
    double* const column = slopes->axles[axle][axle_input].data();
    Add(rows.axle_first * factor, column);
    Add(rows.axle_second * factor, column + 4);
    Add(rows.body * factor, slopes->body[body_input].data());
  }
  [[gnu::always_inline]] void AddWheelset(std::size_t i, const RowSlopes& rows, double factor) const {
    Add(i, axle * wheelset::kSize + i, rows, factor);
  }
  [[gnu::always_inline]] void AddBody(std::size_t i, const RowSlopes& rows, double factor) const {
    Add(wheelset::kSize + i, kBody + i, rows, factor);
  }
  /// A deflection that changes with a position by `arm`, its rate as much with the velocity.
  [[gnu::always_inline]] void AddWheelset(std::size_t i, const RowSlopes& rows, double arm, double by_d,
                                          double by_v) const {
    AddWheelset(i, rows, arm * by_d);
    AddWheelset(i + 1, rows, arm * by_v);
  }
  [[gnu::always_inline]] void AddBody(std::size_t i, const RowSlopes& rows, double arm, double by_d,
                                      double by_v) const {
    AddBody(i, rows, arm * by_d);
    AddBody(i + 1, rows, arm * by_v);
  }
};

/// The deflections are those of CalcDeflection (wagon.h).
[[gnu::always_inline]] inline void StoreCorners(const Wagon& w, const FourCorners& corners,
                                                const CornerPlace<Lanes>& place, RateSlopes* slopes) {
  std::array<std::array<RowSlopes, kCorners>, kCornerInputs> rows;
  for (std::size_t input = 0; input < kCornerInputs; ++input) rows[input] = Turn(corners.rows, input);
  const double h = w.body.h;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerColumns add{slopes, AxleOf(i)};
    const double e_b = place.e_b[i], X = place.X[i], Y = place.Y[i];
    const RowSlopes& by_x = rows[kForceX][i];
    const RowSlopes& by_y = rows[kForceY][i];
    const RowSlopes& by_z = rows[kForceZ][i];

    const double x_d = corners.x.by_d[i], x_v = corners.x.by_v[i];
    add.AddWheelset(wheelset::kX, by_x, 1, x_d, x_v);
    add.AddWheelset(wheelset::kPsi, by_x, -e_b, x_d, x_v);
    add.AddBody(body::kPsi, by_x, Y, x_d, x_v);

    const double y_d = corners.y.by_d[i], y_v = corners.y.by_v[i];
    add.AddWheelset(wheelset::kY, by_y, 1, y_d, y_v);
    add.AddBody(body::kY, by_y, -1, y_d, y_v);
    add.AddBody(body::kPsi, by_y, -X, y_d, y_v);
    add.AddBody(body::kPhi, by_y, -h, y_d, y_v);

    const double z_d = corners.z.by_d[i], z_v = corners.z.by_v[i];
    add.AddWheelset(wheelset::kZ, by_z, 1, z_d, z_v);
    add.AddWheelset(wheelset::kPhi, by_z, e_b, z_d, z_v);
    add.AddBody(body::kZ, by_z, -1, z_d, z_v);
    add.AddBody(body::kPhi, by_z, -Y, z_d, z_v);

    add.AddWheelset(wheelset::kPhi, rows[kWheelsetPhi][i], 1);
    add.AddWheelset(wheelset::kPsi, rows[kWheelsetPsi][i], 1);
    add.AddBody(body::kPhi, rows[kBodyPhi][i], 1);
    add.AddBody(body::kPsi, rows[kBodyPsi][i], 1);

    add.Add(RateSlopes::kAxleLinks + i % 2, RateSlopes::kBodyLinks + i, by_x, 1);
    add.Add(RateSlopes::kAxleLinks + 2 + i % 2, RateSlopes::kBodyLinks + kCorners + i, by_y, 1);
    add.Add(RateSlopes::kAxleLeaves + i % 2, kLeafForces + i, by_z, corners.z_by_leaf[i]);

    const double s = corners.leaf_rate.v[0][i], vs = corners.leaf_rate.v[1][i];
    slopes->leaves[i] = {s, vs, e_b * s, e_b * vs, -s, -vs, -Y * s, -Y * vs, corners.leaf_rate.v[2][i]};
  }
}

/// From forces to accelerations.
[[gnu::always_inline]] inline void DivideByMasses(const Wagon::Fixed& k, RateSlopes* slopes) {
  const Lanes first(k.per_m_w, k.per_m_w, k.per_m_w, k.per_I_wx);
  const Lanes second(k.per_I_wy, k.per_I_wz, 0, 0);
  const Lanes car(k.per_m_c, k.per_m_c, k.per_I_cx, k.per_I_cz);
  const auto scale = [&](RateSlopes::AxleColumn& column) {
    (Lanes(column.data()) * first).Store(column.data());
    (Lanes(column.data() + 4) * second).Store(column.data() + 4);
  };
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    for (RateSlopes::AxleColumn& column : slopes->axles[axle]) scale(column);
    scale(slopes->by_speed[axle]);
  }
  for (RateSlopes::BodyColumn& column : slopes->body) (Lanes(column.data()) * car).Store(column.data());
}

UICLINK_FOR_EACH_PROCESSOR
void CalcAll(const Wagon& w, double V, const LinkStates& links, const StateVector<double>& x, RateSlopes* slopes) {
  const Wagon::Fixed& fixed = w.fixed();
  const CornerPlace<Lanes> place{.e_b = Lanes(fixed.e_b.data()),
                                 .X = Lanes(fixed.X.data()),
                                 .Y = Lanes(fixed.Y.data()),
                                 .s_eq = Lanes(fixed.s_eq.data())};
  const WheelsetMotion<WheelDual> motion = SeeFromWheels(x, V / w.r0);
  const Resultant<WheelDual> forces =
      CalcWheels(w, motion, {.per_V = 1 / V, .mu = w.mu, .printed_roll = w.options.printed_roll});
  *slopes = {};
  StoreWheels(forces, motion, 1 / V, 1 / w.r0, slopes);
  StoreCorners(w, FourCorners(w, links, x, place), place, slopes);
  DivideByMasses(fixed, slopes);
}

}  // namespace

void CalcRateSlopes(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x,
                    RateSlopes* slopes) {
  CalcAll(wagon, V, links, x, slopes);
}

namespace {

template <typename Column>
void Spread(const Column& column, std::span<const std::size_t> rows, std::size_t begin, std::size_t input,
            StateMatrix* jacobian) {
  for (std::size_t i = 0; i < rows.size(); ++i) (*jacobian)[begin + rows[i]][input] = column[i];
}

}  // namespace

StateMatrix SpreadOut(const RateSlopes& slopes) {
  StateMatrix jacobian{};
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const std::size_t begin = axle * wheelset::kSize;
    for (std::size_t i : RateSlopes::kAxlePosition) jacobian[begin + i][begin + i + 1] = 1;
    const auto& columns = slopes.axles[axle];
    const auto spread = [&](std::size_t from, std::size_t to, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) Spread(columns[from + i], RateSlopes::kAxleRow, begin, to + i, &jacobian);
    };
    spread(0, begin, wheelset::kSize);
    spread(wheelset::kSize, kBody, body::kSize);
    spread(RateSlopes::kAxleLeaves, kLeafForces + 2 * axle, 2);
  }
  for (std::size_t i : RateSlopes::kBodyPosition) jacobian[kBody + i][kBody + i + 1] = 1;
  for (std::size_t i = 0; i < kMaxState; ++i) Spread(slopes.body[i], RateSlopes::kBodyRow, kBody, i, &jacobian);
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    StateVector<double>& row = jacobian[kLeafForces + corner];
    for (std::size_t i = 0; i < 4; ++i) {
      row[AxleOf(corner) * wheelset::kSize + wheelset::kZ + i] = slopes.leaves[corner][i];
      row[kBody + body::kZ + i] = slopes.leaves[corner][4 + i];
    }
    row[kLeafForces + corner] = slopes.leaves[corner][8];
  }
  return jacobian;
}

}  // namespace uiclink
