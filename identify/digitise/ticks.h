#pragma once

#include <string>
#include <vector>

#include "identify/digitise/page.h"

namespace uiclink::digitise {

/// Tick marks along one side of the frame.
struct Ticks {
  std::vector<double> places;  ///< along the axis [px], equally spaced as found
  double spacing = 0;          ///< [px]; 0: no even ticks found
  double first = 0;            ///< value at the first one
  double step = 0;             ///< value between two of them
  bool round = false;          ///< step is 1, 2, 2.5 or 5 times a power of ten, and the values are multiples of it
};

/// Major ticks of the time axis (bottom) and of the displacement axis (left), inside or outside of the frame; equally
/// spaced ones, four or more; those at the corners do not count.
Ticks FindTimeTicks(const Page& page);
Ticks FindDisplacementTicks(const Page& page);

}  // namespace uiclink::digitise
