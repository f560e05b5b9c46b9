#pragma once

#include <cstddef>

#include "identify/noise.h"
#include "identify/record.h"
#include "identify/release.h"

namespace uiclink {

/// End of the push on the way to phases.extrema[0] [s].
///
/// The motion is compared with the free sliding arc to that extremum, whose frequency and centre are those of the arcs
/// after it; the push ends where the departure sets in (rms error about 3 ms with the thesis's noise and rate).
/// @param limit  sample before which nothing is free: end of the rest, or the extremum before; 0: the record starts in
///               motion. Its time is the answer where nothing departs.
double FindPushEnd(const Record& record, const Noise& noise, const Phases& phases, std::size_t limit);

/// Whether the hand still helps on the way from extrema[0] to extrema[1].
///
/// Loss. Amplitudes from the true zero obey  (k/2)(A^2 - A'^2) = T0 (A + A' - 2 y_c),  so what a half swing loses,
/// A - A' = (2 T0/k) (1 - 2 y_c/(A + A')), only falls from swing to swing. Friction that falls with speed stays above
/// 0.8 of that. A half swing that loses much less than the next one does is suspect; so is a cycle, whose loss needs no
/// zero. The zero is that of the sliding arcs and that of the late motion: both must say so, and by more than an uneven
/// sensor or spring shifts the middle of a swing.
///
/// Shape. A stop or a limit of the sensor in extrema[0] looks like that as well, so the arc to extrema[1] is asked: one
/// that follows the later free arcs is free. A hand shows as a force along the velocity that stops on the way, and is
/// at least 0.6 of the friction (the rig's pushes: 2.1 times and more in 95 of 100 records). Where extrema are cut and
/// their losses unknown the shape alone decides.
/// @param later_loss  strongest loss of a later cycle, span less next span [m]; 4 T0/k for large swings.
bool IsFirstSwingDriven(const Record& record, const Noise& noise, const Phases& phases, double later_loss);

}  // namespace uiclink
