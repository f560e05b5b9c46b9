#pragma once

#include "reports/figure.h"

namespace uiclink::reproduce {

/// Leaves out what nobody sees at the figure's size: points of lines that are within less than half a pixel of the line
/// through those left (Douglas and Peucker, Cartographica 10, 1973, pp. 112-122), and marks that lie on one another.
/// Long oscillations are brought to their outline before (reports/figure.h). Gaps stay.
void ThinToPixels(Figure* figure);

}  // namespace uiclink::reproduce
