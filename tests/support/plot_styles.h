#pragma once

#include <vector>

#include "tests/support/drawn_plot.h"

namespace uiclink {

/// Fifty ways to draw a record: widths of 1 to 5 px, grids, colours (black on a black frame among them), dashes, a
/// second curve, legends, 500 to 3000 px, JPEG of quality 30 to 95, 2 degrees of rotation, printed and photographed.
std::vector<PlotStyle> PlotStyles();

}  // namespace uiclink
