#pragma once

#include <cstddef>

#include "vehicle/contact/contact_search.h"
#include "vehicle/contact/hertz.h"

namespace uiclink {

/// Where the left wheel is: displacement, and roll and lift at which wheel and rail just touch.
struct WheelPose {
  double y = 0;       ///< of the wheelset, positive left [m]
  double phi = 0;     ///< roll, positive left side up [rad]
  double z_lift = 0;  ///< of its centre above r0 over the rail tops [m]
};

/// One wheel pressed on its rail by virtual penetration. Points are means over the contact, weighted with the load that
/// each strip across rolling carries, so that they change continuously where rigid profiles would jump.
struct ElasticContact {
  double a_wheel = 0;  ///< lateral distance from the wheelset's centre, wheelset frame [m]
  double a_rail = 0;   ///< from the track centre, track frame [m]
  double z_rail = 0;   ///< height of the rail there, under the lift [m]
  double r = 0;        ///< rolling radius [m]
  double delta = 0;    ///< contact angle, wheelset frame [rad]: direction of the resultant of the pressure
  double a = 0;        ///< semi-axes of the equivalent ellipse [m]
  double b = 0;
  double approach = 0;      ///< along the normal, from touching [m]
  double normal_force = 0;  ///< [N]; its vertical component is the load
  int patches = 0;          ///< separate intervals of interpenetration
};

/// Virtual penetration after Kik and Piotrowski (1996; Piotrowski and Kik, Vehicle System Dynamics 46, 2008):
///
/// The profiles are lowered onto each other by delta_0 = 0.55 times the approach (vertically, since the wheelset keeps
/// its y); where they overlap by g(s) > 0 they touch, over the half length  x_l = sqrt(2 r g)  along rolling, under
/// the pressure  p = p' sqrt(x_l^2 - x^2).  The line load is pi p' r g.  p' follows from the deflection of a
/// half-space,
///   u(s) = 1/(pi E*) int int p / rho dx ds' = approach - gap(s),
/// which the original demands at the first point of contact. That point jumps between two minima of the gap, so the
/// condition is here the mean over s weighted with the line load; for a round contact both agree within 1 %.
/// The integral over x is closed (int sqrt(x_l^2-x^2)/sqrt(x^2+d^2) dx = 2 x_l^2 D(m)/sqrt(x_l^2+d^2),
/// m = x_l^2/(x_l^2+d^2)); that over s' has its logarithm taken out. 16 Gauss points for each interval of contact,
/// or between two ridges of the gap in it.
///
/// The contact angle is that of the resultant: tan(delta + phi) is the mean slope of the wheel, to which that of the
/// rail is equal, since a load that depends on the gap alone has no mean slope of the gap. At constant load the wheel
/// follows this angle: dz/dy = tan(delta + phi) within 2.5 % on the tread (the method is not derived from an energy).
///
/// The equivalent ellipse is that of Hertz, at this approach, for the quadratic gap whose overlap has the same area and
/// the same ratio of length and width (widths of several intervals are added). The overlap itself is no ellipse of
/// contact: on a quadratic gap it is 10 to 25 % too large, and too slim (shape correction of 2008).
/// Against Hertz on quadratic gaps with a/b = 0.15 ... 11, approach and area are 3 % low to 4 % high, a/b is the same
/// (tests/unit/elastic_contact_test.cpp). Where a profile ends within the overlap (the side of the rail above 89
/// degrees), the contact ends there, too.
///
/// @param minima  local minima of the gap of the left wheel at this pose; those within reach begin the intervals.
/// @param load    vertical [N], > 0.
/// @param approach_guess vertical approach to start from [m], > 0, for example that of the neighbouring row.
/// @throws std::domain_error when no minimum is within reach or the approach is not found; std::invalid_argument unless
///         load and guess are > 0.
ElasticContact CalcElasticContact(const WheelsetOnRails& wheelset, const WheelPose& pose, const CandidateList& minima,
                                  double load, const ElasticMaterial& material, double approach_guess = 1e-5);

}  // namespace uiclink
