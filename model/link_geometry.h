#pragma once

#include <numbers>

namespace uiclink {

/// Stiffnesses of a link suspension per unit load: what Piotrowski's model calls k and sum k_i.
struct Stiffnesses {
  double k = 0;       ///< all joints slide [1/m]
  double sum_ki = 0;  ///< what rolling in all joints adds; k + sum_ki is the stiffness while every joint rolls [1/m]
};

/// A double link across the track: each link is a ring of round bar whose ends (radius r) lie in grooves (radius R) of
/// the end bearings, which do not turn about the track's direction. Defaults: new UIC double link (thesis, 4.3.3).
struct LateralLinkGeometry {
  double L = 0.165;                              ///< distance between the centres of a link's two ends [m], > 2 r
  double R = 0.0135;                             ///< radius of the groove [m], > r
  double r = 0.0125;                             ///< radius of the bar [m], > 0
  double alpha = 25.9 / 180 * std::numbers::pi;  ///< inclination of the links to the vertical [rad], in [0, pi/2)
};

/// Lateral stiffnesses (thesis, 4.3.3, after Piotrowski):
///   k = 1/(2 L cos a),   k + k1 = (L + 2 r^2/(R - r)) / (2 (L - 2r)^2 cos a).
///
/// Wear opens R - r: k1 falls steeply, k not at all. A derivation, and what k leaves out, is in model/LINK_GEOMETRY.md.
/// @throws std::invalid_argument outside the ranges above (NaN included).
Stiffnesses CalcLateralStiffness(const LateralLinkGeometry& geometry);

/// Which of two mating bodies is the convex one.
enum class LinkEnds {
  kHoles,  ///< the links have holes; pins belong to bracket, middle and beam
  kPins,   ///< the links end in pins; holes belong to bracket, middle and beam
};

/// What all joints do.
enum class JointMotion {
  kPivot,  ///< turn freely about coinciding centres: sliding with the clearance R - r neglected, as the lateral k does
  kSlide,  ///< turn freely, the pin resting at the lowest point of its hole: clearance counted, no friction
  kRoll,   ///< pin rolls in its hole without slip
};

/// The suspension along the track, mirror-symmetric: a rigid beam (the leaf spring) carries the load and hangs by its
/// two ends on double links, two links and a middle pin in series at either end, inclined at alpha to the vertical.
///
/// Defaults: L, alpha and the beam are the thesis's (4.2, 4.3.3), r is half its 35 mm pivot. R, load_height and
/// link_ends are NOT in any source at hand: they are assumptions, see model/LINK_GEOMETRY.md for what each of them does
/// to the result.
struct LongitudinalLinkGeometry {
  double L = 0.165;   ///< distance between the centres of a link's two ends [m], > 0; > 2 r where links end in pins
  double R = 0.0185;  ///< radius of the holes [m], > r. Assumed: 1 mm of clearance in the radius, as laterally
  double r = 0.0175;  ///< radius of the pins [m], > 0
  double alpha =
      25.9 / 180 * std::numbers::pi;  ///< inclination [rad], |alpha| < pi/2; > 0: brackets lie outside the beam
  double beam_length = 1.22;          ///< between the joints at its ends [m], > 0
  double load_height = 0;  ///< of the load's centre, where x is measured too, above the line of the beam's joints [m]
  LinkEnds link_ends = LinkEnds::kHoles;
  bool middle_turns = true;  ///< the middle pin is free to turn about its axis; false: held, as two parallel links do
};

/// The suspension at rest under a horizontal force that holds its load at x.
struct LinkEquilibrium {
  enum class Status {
    kFound,         ///< a minimum of the potential energy
    kNotConverged,  ///< x is beyond the links' reach, or the load sits where the beam turns about
    kNotAMinimum,   ///< stationary, but the links would leave it
  };
  Status status = Status::kNotConverged;
  double x = 0;          ///< displacement of the load [m], positive to the right
  double height = 0;     ///< potential energy per unit load, V/(M g): rise of the load above x = 0 [m]
  double force = 0;      ///< dV/dx/(M g): force that holds the load, positive to the right [-]
  double stiffness = 0;  ///< d2V/dx2/(M g) [1/m], exact (implicit derivative of the equilibrium)
  double pitch = 0;      ///< of the beam, positive when its right end rises [rad]
};

/// Finds the equilibrium at displacement x [m]: the least potential energy M g height over all angles of links, middle
/// pins and beam that keep the suspension closed. Bodies are rigid, links and pins weightless, friction only as joints
/// prescribe.
///
/// Angles of real joints are limited by friction: rolling holds over a few millimetres only, and this does not say
/// where it ends. Status, not exception, tells about the search.
/// @throws std::invalid_argument outside the geometry's ranges, or unless x is finite.
LinkEquilibrium FindLinkEquilibrium(const LongitudinalLinkGeometry& geometry, JointMotion motion, double x);

/// Longitudinal stiffnesses at x = 0:  k = V''/(M g) with pivots,  k + sum_ki = V''/(M g) with rolling joints.
///
/// With pivots  k = (1/(2 L cos^3 a) + (tan^3 a)/b - h (tan^2 a)/b^2) / (1 + h tan(a)/b)^2,  with b half the beam's
/// length and h the load's height: 1/(2 L cos^3 a) is the links' swing, the rest the beam's pitch. Rolling has no
/// closed form here.
/// @throws std::invalid_argument outside the geometry's ranges, or if x = 0 is no minimum of the potential energy.
Stiffnesses CalcLongitudinalStiffness(const LongitudinalLinkGeometry& geometry);

}  // namespace uiclink
