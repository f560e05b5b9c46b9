#pragma once

#include <vector>

#include "vehicle/contact/conicity.h"
#include "vehicle/contact/contact_search.h"
#include "vehicle/contact/contact_table.h"
#include "vehicle/contact/geometry.h"
#include "vehicle/contact/hertz.h"

namespace uiclink {

/// At a row of the table the left wheel carries load at a second place, apart from the first: under the static load the
/// first point gives way further than the second one is open.
struct TwoPointContact {
  double y = 0;         ///< lateral displacement [m]
  double gap = 0;       ///< of the second point, along its normal, before the load acts [m]
  double approach = 0;  ///< q0 of the first one [m]
  ContactCandidate touching;
  ContactCandidate second;
};

/// What a contact table does not tell by itself; left wheel, y from -y_max to y_max.
struct ContactNotes {
  std::vector<Jump> jumps;                 ///< of rigid contact, increasing y; none for elastic contact
  std::vector<TwoPointContact> two_point;  ///< by increasing y; at most one for each row
};

/// The contact table of a geometry (geometry.h), with notes.
///
/// Rows stand at equal distances from -y_max to y_max, each with the wheelset in the pose in which both wheels just
/// touch. Rigid contact: one row for the point that touches; at each jump two rows more at the y of the jump, found to
/// rounding. Elastic contact (elastic_contact.h): means over the contact, hence no jumps; the pose is the same.
///
/// The load: every row's normal force has the vertical component wheel_load,  n0 = wheel_load / cos(delta + phi_roll);
/// friction is left out, so that on the flange n0 is three times the wheel load.
/// The ellipse of rigid contact: Hertz with kappa_x = cos(delta)/r, and across rolling the curvature of the gap between
/// the touching point and the ends of the ellipse, kappa_y = (gap(b) + gap(-b))/b^2: solved for together with b. Where
/// the profiles are arcs this is the sum of their curvatures; where the curvature of a profile steps it changes
/// continuously; and it is positive where the curvatures cancel (the crown, rail R 300 in a wheel of R 320), which the
/// local one need not be. Where b would exceed kWidestEllipse, it is set to that.
/// q0 is the approach under n0 from the touching height, along the normal.
///
/// Wheels and track are symmetric; the right wheel at y is the left one at -y. Deterministic.
/// @throws std::invalid_argument when the wheelset does not fit between the rails; InputError for a file of points.
ContactTable CalcContactTable(const TrackGeometry& geometry, ContactNotes& notes);
ContactTable CalcContactTable(const TrackGeometry& geometry);  ///< the same without the notes

inline constexpr double kWidestEllipse = 20e-3;  ///< greatest semi-axis across rolling [m]

/// Ellipse, approach and pressure of rigid contact at a point that touches, by the rule above.
/// @param point of the left wheel at displacement y and roll phi, lifted by z_lift.
HertzContact CalcRigidEllipse(const WheelsetOnRails& wheelset, const ContactCandidate& point, double y, double phi,
                              double z_lift, double normal_force, const ElasticMaterial& material);

/// delta_r(y) = r(y) - r(-y) of a table, at its rows and at those of the right wheel; y from -Y to Y, where the table
/// has both wheels. Includes the roll; EN 15302 leaves it out (conicity.h).
RollingRadiusDifference CalcRollingRadiusDifference(const ContactTable& table);

}  // namespace uiclink
