#include "vehicle/wagon_energy.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "vehicle/vertical_spring.h"

namespace uiclink {

using Eigen::Vector3d;

RigidMotion MotionOfWheelset(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t axle) {
  const auto at = [&](std::size_t i) { return x[axle * wheelset::kSize + i]; };
  return {.v = {at(wheelset::kXRate), at(wheelset::kYRate), at(wheelset::kZRate)},
          .theta = {at(wheelset::kPhi), 0, at(wheelset::kPsi)},
          .omega = {at(wheelset::kPhiRate), V / wagon.r0 + at(wheelset::kBeta), at(wheelset::kPsiRate)}};
}

RigidMotion MotionOfBody(const StateVector<double>& x) {
  const auto at = [&](std::size_t i) { return x[kBody + i]; };
  return {.v = {0, at(body::kYRate), at(body::kZRate)},
          .theta = {at(body::kPhi), 0, at(body::kPsi)},
          .omega = {at(body::kPhiRate), 0, at(body::kPsiRate)}};
}

namespace {

/// What the first-order rotation adds to the velocity w x p of a point.
Vector3d CalcSecondOrderVelocity(const RigidMotion& motion, const Vector3d& p) {
  return motion.theta.cross(motion.omega.cross(p));
}

double CalcStopEnergy(const GuidanceStop& stop, double d) {
  const double beyond = std::max(std::abs(d) - stop.clearance, 0.0);
  return 0.5 * stop.k * beyond * beyond;
}

double CalcSpringStore(const Wagon& wagon, double s) {
  switch (wagon.options.suspension) {
    case Suspension::kLinear:
      return 0.5 * wagon.linear.k * s * s;
    case Suspension::kParabolic:
      return CalcSpringEnergy(wagon.parabolic, s);
    case Suspension::kLeaf:
      return 0.5 * wagon.leaf.c * s * s;
  }
  return 0;
}

}  // namespace

TermSum CalcKineticPower(const Wagon& wagon, double V, const StateVector<double>& x, const StateVector<double>& rate) {
  TermSum sum;
  const WheelsetInertia& w = wagon.wheelset;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    // Accelerations are the velocities in the rate of the state.
    const RigidMotion m = MotionOfWheelset(wagon, V, x, axle), a = MotionOfWheelset(wagon, 0, rate, axle);
    sum.Add(w.m * m.v, a.v);
    sum.Add(Vector3d(w.I_x, w.I_y, w.I_z).cwiseProduct(m.omega), a.omega);
  }
  const RigidMotion m = MotionOfBody(x), a = MotionOfBody(rate);
  sum.Add(wagon.body.m * m.v, a.v);
  sum.Add(Vector3d(wagon.body.I_x, 0, wagon.body.I_z).cwiseProduct(m.omega), a.omega);
  return sum;
}

double CalcKineticEnergy(const Wagon& wagon, double V, const StateVector<double>& x) {
  const WheelsetInertia& w = wagon.wheelset;
  double twice = 0;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const RigidMotion m = MotionOfWheelset(wagon, V, x, axle);
    // The pitch from that of V/r0 on: the rest is constant, and 1e5 times as large as what changes.
    const double beta = x[axle * wheelset::kSize + wheelset::kBeta];
    twice += w.m * m.v.squaredNorm() + w.I_x * m.omega.x() * m.omega.x() + w.I_z * m.omega.z() * m.omega.z() +
             w.I_y * beta * (2 * V / wagon.r0 + beta);
  }
  const RigidMotion m = MotionOfBody(x);
  return 0.5 * (twice + wagon.body.m * m.v.squaredNorm() + wagon.body.I_x * m.omega.x() * m.omega.x() +
                wagon.body.I_z * m.omega.z() * m.omega.z());
}

TermSum CalcContactPower(const Wagon& wagon, double V, const StateVector<double>& x, const WagonForces& forces,
                         std::size_t wheel) {
  const WagonForces::Wheel& f = forces.wheels[wheel];
  const RigidMotion m = MotionOfWheelset(wagon, V, x, AxleOf(wheel));
  TermSum sum;
  sum.Add({f.X, f.Y, f.Q}, m.v);
  sum.Add({f.roll, f.pitch, f.yaw}, m.omega);
  return sum;
}

Vector3d CalcCornerForce(const WagonForces& forces, std::size_t corner) {
  return {forces.link_x[corner] + forces.guide_x[corner], forces.link_y[corner] + forces.guide_y[corner],
          -forces.spring[corner]};
}

Vector3d CalcDeflectionRate(const Wagon& wagon, const StateVector<double>& x, std::size_t corner) {
  const CornerDeflection<double> d = CalcDeflection(wagon, x, corner);
  return {d.vx, d.vy, d.vs};
}

Vector3d CalcSecondOrderDeflectionRate(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t corner) {
  const Vector3d on_axle(0, SideOf(corner) * wagon.b, 0);
  const Vector3d on_body(wagon.corners[corner].X, wagon.corners[corner].Y, -wagon.body.h);
  return CalcSecondOrderVelocity(MotionOfWheelset(wagon, V, x, AxleOf(corner)), on_axle) -
         CalcSecondOrderVelocity(MotionOfBody(x), on_body);
}

double CalcJointEnergy(const Link& link, const LinkState& state, std::size_t joint, double d, double v) {
  const double spring = d - state.CalcPosition(link, joint, d, v);
  return 0.5 * link.load() * link.sliders()[joint].k * spring * spring;
}

double CalcLinkEnergy(const Link& link, const LinkState& state, double d, double v) {
  double energy = 0.5 * link.load() * link.law().k * d * d;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) energy += CalcJointEnergy(link, state, i, d, v);
  for (const Stop<double>& stop : link.law().stops.items()) {
    const double beyond = std::max(stop.position > 0 ? d - stop.position : stop.position - d, 0.0);
    energy += 0.5 * link.load() * stop.k * beyond * beyond;
  }
  return energy;
}

double CalcSlipLoss(const Link& link, const LinkState& state, std::size_t joint, double d0, double d1) {
  const double side = state.joints[joint].slides;
  return side == 0 ? 0 : link.load() * link.CalcSlidingForce(joint, side, 0) * std::abs(d1 - d0);
}

double CalcStoredEnergy(const Wagon& wagon, const StateVector<double>& x, const LinkStates& links) {
  double energy = wagon.body.m * wagon.g * x[kBody + body::kZ];
  for (std::size_t axle = 0; axle < kAxles; ++axle)
    energy += wagon.wheelset.m * wagon.g * x[axle * wheelset::kSize + wheelset::kZ];
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
    energy += CalcSpringStore(wagon, d.s);
    energy += CalcLinkEnergy(wagon.longitudinal[i], links.longitudinal[i], d.dx, d.vx);
    energy += CalcLinkEnergy(wagon.lateral[i], links.lateral[i], d.dy, d.vy);
    if (!wagon.options.guidance) continue;
    energy += CalcStopEnergy(wagon.guidance.longitudinal, d.dx) + CalcStopEnergy(wagon.guidance.lateral, d.dy);
  }
  return energy;
}

double CalcSpringLoss(const Wagon& wagon, const WagonForces& forces, const CornerDeflection<double>& at,
                      std::size_t corner) {
  switch (wagon.options.suspension) {
    case Suspension::kLinear:
      return wagon.linear.d * at.vs * at.vs;
    case Suspension::kParabolic:
      return wagon.parabolic_damping * at.vs * at.vs;
    case Suspension::kLeaf:
      return (forces.spring[corner] - wagon.leaf.c * at.s) * at.vs;
  }
  return 0;
}

}  // namespace uiclink
