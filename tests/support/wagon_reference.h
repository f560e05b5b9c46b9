#pragma once

#include <Eigen/Core>
#include <array>

#include "vehicle/wagon.h"
#include "vehicle/wagon_state.h"

namespace uiclink {

/// The rate of a wagon's state and what it is made of.
struct ReferenceRate {
  StateVector<double> rate{};
  /// Largest term on the right-hand side of each equation, absolute and in the unit of `rate`: what a difference is to
  /// be measured by. A term is one force (weight; at each wheel the contact; at each corner link with spring, guidance)
  /// by mass, or one product of arm and force by moment of inertia. For positions it is the velocity.
  StateVector<double> largest{};
  /// At a wheel. Where the contact jumps, `force` is the whole one, all else belongs to the contact before the jump.
  struct Wheel {
    double q = 0;    ///< approach of wheel and rail beyond touching [m]; <= 0: lifted
    double N = 0;    ///< [N]
    double F_x = 0;  ///< creep forces in the contact frame [N]
    double F_y = 0;
    double xi_x = 0;  ///< creepages [-], [-], [1/m]
    double xi_y = 0;
    double xi_s = 0;
    double saturation = 0;  ///< creep force of the linear theory over mu N [-]; from 3 on the contact slides
    Eigen::Vector3d force = Eigen::Vector3d::Zero();  ///< on the wheelset, track frame [N]
  };
  std::array<Wheel, kCorners> wheels{};
  std::array<Eigen::Vector3d, kCorners> guide{};  ///< of the guidance on the wheelset, track frame [N]
};

/// A second right-hand side of the wagon, written differently from CalcRate() and from the thesis alone, to check it
/// by. It shares data types with it, the forces of the links in a given mode (LinkState::CalcForce) and the values of
/// the contact curve; nothing else. Meant to be read beside chapters 2, 3, 5, 6 and appendices C, D, E: vectors, full
/// transformation matrices, velocities of points as v + w x p and moments as p x f.
///
/// Frames: R rail (track), W wheelset, B car body, C contact; C z is the normal from the rail to the wheel.
/// p_WC_W is the contact point seen from the wheelset's centre, in W; R_WC turns a vector from C to W.
///
/// Newton's law holds in R, Euler's in W and B without their gyroscopic terms (section 2.1.2), which the thesis drops.
///
/// Where an order of approximation has to be chosen, it is this:
///   matrices       appendix C's complete list: R_WR, R_BR are linear in phi and psi; R_RC is linear in psi, but keeps
///                  cos and sin of delta +- phi (they are not small at the flange). As printed, R_RC is not R_WR^T
///                  R_WC.
///   sin, cos       of delta are those of the contact curve, of delta +- phi by the addition theorems.
///   displacements  of points on wheelset and body are linear in their angles: u + theta x p.
///   links, guides  forces along the axes of R, from displacements along them (chapter 6: "parallel to the unit vectors
///                  that define x and y"); for moments they are turned into W and B with the linear matrices, so that
///                  S_z^w contains -phi S_y and S_y^b contains phi S_z. Of the displacement relative to the body,
///                  chapter 6's second-order parts (a1 = (a + y_d)/cos psi, a cos psi) are left out.
///   contact point  of the wheel as the contact curve has it at y; that yaw shifts it along the rail is left out, and
///                  so it is in p_WC_W (0, +-a, -r), although wheel and rail approach.
///   creepages      R_WR acts on the speed V alone: products of psi, phi with x', y', z' are second order (appendix D).
///                  Angular velocity and arm are taken in W as they are. The wheel's V/r0 + beta is not linearised.
///   approach       kTouching: the displaced wheelset stands, just touching, at z_lift(y), phi_roll(y). From there it
///                  rolls by dphi about W x and moves by dz along R z; q is what this moves the contact point against
///                  C z, the rotation seen in W, the translation in R, where the normal is inclined by delta +- phi
///                  (phi the roll itself, not phi_roll). For the right wheel the pose is that at -y in the mirror, as
///                  all of its contact: the same but for what interpolation makes of it within a cell of a jump.
///                  kPrinted: q0 of the table plus appendix E, without its terms in psi, as there.
///   jumps          both contacts are worked out whole, each with its own arms, from the same pose; of the wrenches
///                  the first has the share 1 - s, the second s = ContactCurve::ShareAfter().
///
/// @param V  speed of the wagon [m/s], > 0.
ReferenceRate CalcReferenceRate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x);

}  // namespace uiclink
