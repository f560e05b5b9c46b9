#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "vehicle/wagon.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {

// Energy and power of the wagon in the frame that moves with it at the constant V. That frame is inertial: the rails
// run backwards through it, and what a locomotive gives is the power -V X of the contact forces. Wheelsets turn with
// chi' = V/r0 + beta.
//
// Rotations are of first order (appendix C: R = 1 + theta x). The equations of motion use R on both sides of a force,
// v + R(w x p), while the deflections of links, springs and guidance have w x p alone. What is between,
// P . theta x (w x p), is no error of a run but a work of the forces that no spring knows: the inverted pendulum of the
// body on its springs, m_c g h phi phi', and terms of its size with yaw.

/// A sum with the sum of the sizes of its terms, for a bound on its rounding.
struct TermSum {
  double value = 0, size = 0;
  void Add(double term) {
    value += term;
    size += std::abs(term);
  }
  void Add(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    for (int i = 0; i < 3; ++i) Add(a[i] * b[i]);
  }
};

/// A wheelset or the body: velocity [m/s], angles [rad], angular velocity with the rolling of a wheelset [rad/s].
struct RigidMotion {
  Eigen::Vector3d v, theta, omega;
};
RigidMotion MotionOfWheelset(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t axle);
RigidMotion MotionOfBody(const StateVector<double>& x);

/// The rate of the kinetic energy [W]. @param rate  of the state x (CalcRate).
TermSum CalcKineticPower(const Wagon& wagon, double V, const StateVector<double>& x, const StateVector<double>& rate);
/// Kinetic energy [J], without that of wheelsets rolling at V/r0.
double CalcKineticEnergy(const Wagon& wagon, double V, const StateVector<double>& x);

/// Power of one wheel's contact forces on its wheelset [W].
TermSum CalcContactPower(const Wagon& wagon, double V, const StateVector<double>& x, const WagonForces& forces,
                         std::size_t wheel);
/// Force of link, guidance and spring of a corner on the wheelset [N].
Eigen::Vector3d CalcCornerForce(const WagonForces& forces, std::size_t corner);
/// Rates of dx, dy, s of a corner [m/s].
Eigen::Vector3d CalcDeflectionRate(const Wagon& wagon, const StateVector<double>& x, std::size_t corner);
/// What the first-order rotations of wheelset and body add to them: theta x (w x p) of one less that of the other.
Eigen::Vector3d CalcSecondOrderDeflectionRate(const Wagon& wagon, double V, const StateVector<double>& x,
                                              std::size_t corner);

/// Energy in the spring of a joint [J].
double CalcJointEnergy(const Link& link, const LinkState& state, std::size_t joint, double d, double v);
/// Energy of main spring, joints and stops of a link [J]; what its further effects store is not in it.
double CalcLinkEnergy(const Link& link, const LinkState& state, double d, double v);
/// What a joint loses while the link moves from d0 to d1 in one mode [J]: |T| x way of slip. For a joint whose sliding
/// force does not depend on speed.
double CalcSlipLoss(const Link& link, const LinkState& state, std::size_t joint, double d0, double d1);

/// What springs, links, guidance and height store [J]. Of a leaf spring: by its mean line c s; the rest is friction.
double CalcStoredEnergy(const Wagon& wagon, const StateVector<double>& x, const LinkStates& links);

/// Power that the vertical spring of a corner takes from the motion beside what it stores [W].
double CalcSpringLoss(const Wagon& wagon, const WagonForces& forces, const CornerDeflection<double>& at,
                      std::size_t corner);

}  // namespace uiclink
