#pragma once

#include <vector>

#include "vehicle/contact/contact_search.h"

namespace uiclink {

/// Rolling radius difference  delta_r = r_left - r_right  [m] over the displacement y [m], positive left; linear
/// between the points, two points at one y where it jumps.
struct RollingRadiusDifference {
  std::vector<double> y;
  std::vector<double> delta_r;
};

/// delta_r from -y_max to y_max at `step` [m], and on both sides of every jump.
/// EN 15302 neglects the roll (options.roll = false).
RollingRadiusDifference CalcRollingRadiusDifference(const WheelsetOnRails& wheelset, double y_max, double step,
                                                    const ContactSearchOptions& options);

/// Equivalent conicity tan gamma [-] of EN 15302, Annex B: the cone whose kinematic motion has the same wavelength.
///   y'' + delta_r(y) / (e r0) = 0  along the track,   tan gamma = e r0 / 2 (2 pi / wavelength)^2  (e, r0 cancel)
/// integrated without error for the polygon delta_r. Pairs need not be symmetric: the motion then goes from y_min to
/// y_max with equal potential, around the zero of delta_r nearest to y = 0.
/// @param amplitude half of the motion from peak to peak [m], > 0
/// @return 0 where delta_r vanishes over the motion (no restoring force); NaN when the wheelset does not swing (delta_r
///         has no rising zero, the motion would leave the data, or delta_r turns against it).
double CalcEquivalentConicity(const RollingRadiusDifference& difference, double amplitude);

/// Conicity by the first harmonic (quasi-linear), tan gamma = 1/(2 pi A) integral_0^2pi delta_r(y_c + A sin t) sin t
/// dt, about the centre y_c where the mean of delta_r over the motion vanishes. NaN as above.
double CalcHarmonicConicity(const RollingRadiusDifference& difference, double amplitude);

}  // namespace uiclink
