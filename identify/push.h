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

/// Whether the hand still helps on the way from extrema[0] to extrema[1]: the amplitude falls by much less than in the
/// half swing after it, which dry friction does not do.  Amplitudes count from the zero of the sliding arcs; where
/// those do not give it, or are no sines, the answer is no.
bool IsFirstSwingPushed(const Record& record, const Noise& noise, const Phases& phases);

}  // namespace uiclink
