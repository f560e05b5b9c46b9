#pragma once

#include <cstddef>

#include "identify/record.h"

namespace uiclink {

/// Samples beyond which more of them cost time and tell nothing new: 60 s at 1000 Hz. A fit uses that many at most.
inline constexpr std::size_t kManySamples = 60'000;
/// The rate below which a record is not thinned [Hz]; the thesis kept 200 of 1000 samples a second.
inline constexpr double kThinnedRate = 200.0;

/// Averages neighbouring samples of an evenly sampled record of more than kManySamples in groups, as many as bring it
/// below that number without falling below kThinnedRate, and adds a notice. Readings and times become the groups'
/// means, so the motion keeps its phase; its amplitude falls by (pi f/rate)^2/6, 1e-4 for a link (1.6 Hz) at the lowest
/// rate.
void ThinRecord(Record* record);

}  // namespace uiclink
