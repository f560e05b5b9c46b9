#pragma once

#include "reports/figure.h"

namespace uiclink {

/// Leaves out what nobody sees at the figure's size: points of lines that are within less than half a pixel of the line
/// through those left (Douglas and Peucker, Cartographica 10, 1973, pp. 112-122), and marks that lie on one another.
/// Long oscillations are brought to their outline before (reports/figure.h). Gaps stay.
/// @param magnified  by how much the figure may be enlarged before what was left out could be seen, > 0.
void ThinToPixels(Figure* figure, double magnified = 1);

}  // namespace uiclink
