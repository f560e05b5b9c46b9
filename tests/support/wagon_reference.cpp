#include "tests/support/wagon_reference.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Position and velocity of a rigid body, angles and their rates.
struct RigidMotion {
  Vector3d u = Vector3d::Zero();
  Vector3d v = Vector3d::Zero();
  Vector3d theta = Vector3d::Zero();  ///< roll, 0, yaw
  Vector3d omega = Vector3d::Zero();  ///< without the rolling of a wheelset
  double pitch_rate = 0;              ///< chi' of a wheelset

  Vector3d PointDisplacement(const Vector3d& p) const { return u + theta.cross(p); }
  Vector3d PointVelocity(const Vector3d& p) const { return v + omega.cross(p); }
};

RigidMotion WheelsetMotion(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t axle) {
  const auto at = [&](wheelset::Index i) { return x[axle * wheelset::kSize + i]; };
  RigidMotion m;
  m.u = {at(wheelset::kX), at(wheelset::kY), at(wheelset::kZ)};
  m.v = {at(wheelset::kXRate), at(wheelset::kYRate), at(wheelset::kZRate)};
  m.theta = {at(wheelset::kPhi), 0, at(wheelset::kPsi)};
  m.omega = {at(wheelset::kPhiRate), 0, at(wheelset::kPsiRate)};
  m.pitch_rate = V / wagon.r0 + at(wheelset::kBeta);
  return m;
}

RigidMotion BodyMotion(const StateVector<double>& x) {
  const auto at = [&](body::Index i) { return x[kBody + i]; };
  RigidMotion m;
  m.u = {0, at(body::kY), at(body::kZ)};
  m.v = {0, at(body::kYRate), at(body::kZRate)};
  m.theta = {at(body::kPhi), 0, at(body::kPsi)};
  m.omega = {at(body::kPhiRate), 0, at(body::kPsiRate)};
  return m;
}

// --- appendix C, the complete list ---

/// w_M_r and b_M_r: from the rail's frame to that of a wheelset or of the body.
Matrix3d FromRail(const RigidMotion& m) {
  const double phi = m.theta.x();
  const double psi = m.theta.z();
  Matrix3d R;
  R << 1, psi, 0,    //
      -psi, 1, phi,  //
      0, -phi, 1;
  return R;
}

/// w_M_cl and w_M_cr.
Matrix3d WheelsetFromContact(bool left, double sin_delta, double cos_delta) {
  Matrix3d R;
  if (left) {
    R << 1, 0, 0,                  //
        0, cos_delta, -sin_delta,  //
        0, sin_delta, cos_delta;
  } else {
    R << 1, 0, 0,                 //
        0, cos_delta, sin_delta,  //
        0, -sin_delta, cos_delta;
  }
  return R;
}

/// r_M_cl and r_M_cr.
Matrix3d RailFromContact(bool left, double sin_delta, double cos_delta, const RigidMotion& m) {
  const double sin_phi = std::sin(m.theta.x());
  const double cos_phi = std::cos(m.theta.x());
  const double psi = m.theta.z();
  Matrix3d R;
  if (left) {
    const double sin_sum = sin_delta * cos_phi + cos_delta * sin_phi;
    const double cos_sum = cos_delta * cos_phi - sin_delta * sin_phi;
    R << 1, -psi * cos_delta, psi * sin_delta,  //
        psi, cos_sum, -sin_sum,                 //
        0, sin_sum, cos_sum;
  } else {
    const double sin_difference = sin_delta * cos_phi - cos_delta * sin_phi;
    const double cos_difference = cos_delta * cos_phi + sin_delta * sin_phi;
    R << 1, -psi * cos_delta, -psi * sin_delta,  //
        psi, cos_difference, sin_difference,     //
        0, -sin_difference, cos_difference;
  }
  return R;
}

// --- forces and moments on a body ---

struct Wrench {
  Vector3d force = Vector3d::Zero();   ///< in R
  Vector3d moment = Vector3d::Zero();  ///< about the centre of mass, in the body's own frame
  Vector3d largest_force = Vector3d::Zero();
  Vector3d largest_moment = Vector3d::Zero();

  void AddForce(const Vector3d& f_R) {
    force += f_R;
    largest_force = largest_force.cwiseMax(f_R.cwiseAbs());
  }
  /// p x f, both in the body's frame.
  void AddMoment(const Vector3d& p, const Vector3d& f) {
    moment += p.cross(f);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3;
      const int k = (i + 2) % 3;
      largest_moment[i] = std::max({largest_moment[i], std::abs(p[j] * f[k]), std::abs(p[k] * f[j])});
    }
  }
  void Add(const Wrench& other, double share) {
    force += share * other.force;
    moment += share * other.moment;
    largest_force = largest_force.cwiseMax(share * other.largest_force);
    largest_moment = largest_moment.cwiseMax(share * other.largest_moment);
  }
};

// --- wheel on rail ---

/// A wheel and the contact that it is on.
struct WheelOnRail {
  const Wagon& wagon;
  double V;
  const RigidMotion& motion;  ///< of the wheelset
  bool left;
  const WheelContact<double>& contact;

  double Side() const { return left ? 1 : -1; }
  /// Displacement that the left wheel's contact curve has for this wheel.
  double TableDisplacement() const { return Side() * motion.u.y(); }
  Vector3d ContactPoint() const { return {0, Side() * contact.a, -contact.r}; }  ///< p_WC_W
  Matrix3d R_WC() const { return WheelsetFromContact(left, contact.sin_delta, contact.cos_delta); }
  Matrix3d R_RC() const { return RailFromContact(left, contact.sin_delta, contact.cos_delta, motion); }
};

/// Displacement of the wheel's contact point into the rail, from the pose in which both wheels touch.
double CalcApproachFromTouching(const WheelOnRail& wheel) {
  const ContactCurve& curve = wheel.wagon.contact;
  const double y = wheel.TableDisplacement();
  const ContactCurve::Place place = curve.Find(y);
  const KinematicPose<double> pose = ContactCurve::Evaluate(curve.pose_cubic(place.cell), curve.Local(y, place));
  const Vector3d normal_W = wheel.R_WC().col(2);
  const Vector3d normal_R = wheel.R_RC().col(2);
  const Vector3d roll_W(wheel.motion.theta.x() - wheel.Side() * pose.phi, 0, 0);
  const Vector3d rise_R(0, 0, wheel.motion.u.z() - pose.z);
  return -normal_W.dot(roll_W.cross(wheel.ContactPoint())) - normal_R.dot(rise_R);
}

/// Appendix E: q0 + component along the normal of the vector from the wheel's contact point to the rail's.
double CalcApproachAsPrinted(const WheelOnRail& wheel) {
  const ContactCurve& curve = wheel.wagon.contact;
  const double at = wheel.TableDisplacement();
  const Matrix3d R_RW = FromRail(wheel.motion).transpose();
  const Vector3d p_WC_W = wheel.ContactPoint();
  const Vector3d p_RC_R = wheel.motion.u + R_RW * p_WC_W;
  const Vector3d across(0, p_WC_W.y(), 0);
  // Lengthwise the gap is of second order; of its height "we exclude the term z_R + r".
  const Vector3d gap(0, wheel.Side() * curve.CalcRailDistance(at) - p_RC_R.y(),
                     -wheel.motion.u.z() - (R_RW * across).z());
  return curve.CalcStaticApproach(at) + wheel.R_RC().col(2).dot(gap);
}

/// (3.2), appendix D: velocity of the wheel's material point at the contact over V, and spin over V.
Vector3d CalcCreepage(const WheelOnRail& wheel) {
  const RigidMotion& m = wheel.motion;
  const Vector3d omega_W(m.omega.x(), m.pitch_rate, m.omega.z());
  const Vector3d v_W = FromRail(m) * Vector3d(wheel.V, 0, 0) + m.v + omega_W.cross(wheel.ContactPoint());
  const Matrix3d R_CW = wheel.R_WC().transpose();
  const Vector3d v_C = R_CW * v_W;
  const Vector3d omega_C = R_CW * omega_W;
  return Vector3d(v_C.x(), v_C.y(), omega_C.z()) / wheel.V;
}

/// (3.1): force over that of the linear theory. @param u  force of the linear theory over mu N.
double CalcSaturation(double u) { return u < 3 ? 1 - u / 3 + u * u / 27 : 1 / u; }

void CalcContactForces(const WheelOnRail& wheel, ReferenceRate::Wheel* at) {
  at->q = wheel.wagon.options.penetration == Penetration::kTouching ? CalcApproachFromTouching(wheel)
                                                                    : CalcApproachAsPrinted(wheel);
  const Vector3d xi = CalcCreepage(wheel);
  at->xi_x = xi[0];
  at->xi_y = xi[1];
  at->xi_s = xi[2];
  if (at->q <= 0) return;
  at->N = wheel.contact.n * std::pow(at->q, 1.5);
  const Eigen::Vector2d linear(-wheel.contact.f11 * at->q * xi[0],
                               -wheel.contact.f22 * at->q * xi[1] - wheel.contact.f23 * std::pow(at->q, 1.5) * xi[2]);
  at->saturation = linear.norm() / (wheel.wagon.mu * at->N);
  const Eigen::Vector2d creep = CalcSaturation(at->saturation) * linear;
  at->F_x = creep[0];
  at->F_y = creep[1];
}

Wrench CalcContactWrench(const WheelOnRail& wheel, ReferenceRate::Wheel* at) {
  CalcContactForces(wheel, at);
  const Vector3d f_C(at->F_x, at->F_y, at->N);
  const Vector3d f_W = wheel.R_WC() * f_C;
  Wrench wrench;
  wrench.AddForce(wheel.R_RC() * f_C);
  wrench.AddMoment(wheel.ContactPoint(), f_W);
  if (wheel.wagon.options.printed_roll) wrench.moment.x() -= wheel.contact.r * f_W.y();  // which (2.4) lacks
  return wrench;
}

Wrench CalcWheelWrench(const Wagon& wagon, double V, const RigidMotion& motion, bool left, ReferenceRate::Wheel* at) {
  const ContactCurve& curve = wagon.contact;
  const double y = left ? motion.u.y() : -motion.u.y();
  const ContactCurve::Place place = curve.Find(y);
  const double t = curve.Local(y, place);
  const ContactCurve::Cubic* after = curve.after_jump(place.cell);
  const double share = after == nullptr ? 0 : ContactCurve::ShareAfter(t);

  Wrench wrench;
  const WheelContact<double> first = ContactCurve::Evaluate(curve.cubic(place.cell), t);
  wrench.Add(CalcContactWrench({wagon, V, motion, left, first}, at), 1 - share);
  if (after != nullptr) {
    ReferenceRate::Wheel unused;
    const WheelContact<double> second = ContactCurve::Evaluate(*after, t);
    wrench.Add(CalcContactWrench({wagon, V, motion, left, second}, &unused), share);
  }
  at->force = wrench.force;
  return wrench;
}

// --- between axle box and body ---

/// Compressed springs push: (5.1), Fancher, or spring and damper.
double CalcVerticalForce(const Wagon& wagon, std::size_t corner, double s, double s_rate,
                         const StateVector<double>& x) {
  switch (wagon.options.suspension) {
    case Suspension::kLinear:
      return wagon.linear.k * s + wagon.linear.d * s_rate;
    case Suspension::kParabolic: {
      const ParabolicSpring& spring = wagon.parabolic;
      const double bent = s < spring.s0 ? spring.F0 / spring.s0 * s : spring.F0 + spring.k2 * (s - spring.s0);
      return bent + wagon.parabolic_damping * s_rate;
    }
    case Suspension::kLeaf:
      return x[kLeafForces + corner];
  }
  return 0;
}

/// Rate of Fancher's spring force and its largest term.
std::array<double, 2> CalcLeafRate(const LeafSpring& spring, double F, double s, double s_rate) {
  const double sign = s_rate > 0 ? 1 : -1;
  const double envelope = spring.c * (1 + sign * spring.mu0) * s + sign * spring.F_r;
  const double per_force = std::abs(s_rate) / spring.beta;
  return {(envelope - F) * per_force, std::max(std::abs(envelope), std::abs(F)) * per_force};
}

double CalcGuideForce(const GuidanceStop& stop, double d) {
  if (d > stop.clearance) return -stop.k * (d - stop.clearance);
  if (d < -stop.clearance) return -stop.k * (d + stop.clearance);
  return 0;
}

/// Everything at one corner: on the wheelset and the opposite on the body.
void AddCorner(const Wagon& wagon, const LinkStates& links, const StateVector<double>& x, std::size_t i,
               const RigidMotion& axle, const RigidMotion& car, Wrench* on_axle, Wrench* on_car, ReferenceRate* all) {
  const Wagon::Corner& corner = wagon.corners[i];
  const Vector3d p_W(0, SideOf(i) * wagon.b, 0);
  const Vector3d p_B(corner.X, corner.Y, -wagon.body.h);
  const Vector3d d = axle.PointDisplacement(p_W) - car.PointDisplacement(p_B);
  const Vector3d d_rate = axle.PointVelocity(p_W) - car.PointVelocity(p_B);
  const double s = corner.s_eq + d.z();

  const Vector3d suspension(links.longitudinal[i].CalcForce(wagon.longitudinal[i], d.x(), d_rate.x()),
                            links.lateral[i].CalcForce(wagon.lateral[i], d.y(), d_rate.y()),
                            -CalcVerticalForce(wagon, i, s, d_rate.z(), x));
  Vector3d& guide = all->guide[i];
  guide.setZero();
  if (wagon.options.guidance)
    guide = {CalcGuideForce(wagon.guidance.longitudinal, d.x()), CalcGuideForce(wagon.guidance.lateral, d.y()), 0};

  for (const Vector3d& f_R : {suspension, guide}) {
    on_axle->AddForce(f_R);
    on_axle->AddMoment(p_W, FromRail(axle) * f_R);
    on_car->AddForce(-f_R);
    on_car->AddMoment(p_B, FromRail(car) * -f_R);
  }
  if (wagon.options.suspension == Suspension::kLeaf) {
    const auto [rate, largest] = CalcLeafRate(wagon.leaf, x[kLeafForces + i], s, d_rate.z());
    all->rate[kLeafForces + i] = rate;
    all->largest[kLeafForces + i] = largest;
  }
}

// --- equations of motion ---

/// One equation for an acceleration, and that for the position before it.
void SetAcceleration(std::size_t rate_place, double inertia, double load, double largest, ReferenceRate* all) {
  all->rate[rate_place] = load / inertia;
  all->largest[rate_place] = largest / inertia;
}
void SetMotion(std::size_t place, double velocity, double inertia, double load, double largest, ReferenceRate* all) {
  all->rate[place] = velocity;
  all->largest[place] = std::abs(velocity);
  SetAcceleration(place + 1, inertia, load, largest, all);
}

void SetWheelset(const WheelsetInertia& own, const RigidMotion& m, const Wrench& w, std::size_t at,
                 ReferenceRate* all) {
  SetMotion(at + wheelset::kX, m.v.x(), own.m, w.force.x(), w.largest_force.x(), all);
  SetMotion(at + wheelset::kY, m.v.y(), own.m, w.force.y(), w.largest_force.y(), all);
  SetMotion(at + wheelset::kZ, m.v.z(), own.m, w.force.z(), w.largest_force.z(), all);
  SetMotion(at + wheelset::kPhi, m.omega.x(), own.I_x, w.moment.x(), w.largest_moment.x(), all);
  SetAcceleration(at + wheelset::kBeta, own.I_y, w.moment.y(), w.largest_moment.y(), all);
  SetMotion(at + wheelset::kPsi, m.omega.z(), own.I_z, w.moment.z(), w.largest_moment.z(), all);
}

void SetBody(const BodyInertia& own, const RigidMotion& m, const Wrench& w, ReferenceRate* all) {
  SetMotion(kBody + body::kY, m.v.y(), own.m, w.force.y(), w.largest_force.y(), all);
  SetMotion(kBody + body::kZ, m.v.z(), own.m, w.force.z(), w.largest_force.z(), all);
  SetMotion(kBody + body::kPhi, m.omega.x(), own.I_x, w.moment.x(), w.largest_moment.x(), all);
  SetMotion(kBody + body::kPsi, m.omega.z(), own.I_z, w.moment.z(), w.largest_moment.z(), all);
}

}  // namespace

ReferenceRate CalcReferenceRate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x) {
  ReferenceRate all;
  const RigidMotion car = BodyMotion(x);
  Wrench on_car;
  on_car.AddForce({0, 0, -wagon.body.m * wagon.g});
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const RigidMotion motion = WheelsetMotion(wagon, V, x, axle);
    Wrench on_axle;
    on_axle.AddForce({0, 0, -wagon.wheelset.m * wagon.g});
    for (const std::size_t corner : {2 * axle, 2 * axle + 1}) {
      on_axle.Add(CalcWheelWrench(wagon, V, motion, SideOf(corner) > 0, &all.wheels[corner]), 1);
      AddCorner(wagon, links, x, corner, motion, car, &on_axle, &on_car, &all);
    }
    SetWheelset(wagon.wheelset, motion, on_axle, axle * wheelset::kSize, &all);
  }
  SetBody(wagon.body, car, on_car, &all);
  return all;
}

}  // namespace uiclink
