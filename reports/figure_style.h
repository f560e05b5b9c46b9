#pragma once

#include <vector>

#include "reports/figure.h"

namespace uiclink {

/// "#0072b2"
const char* ColourCode(FigureColour colour);

/// How a series looks once the palette has been dealt out.
struct SeriesStyle {
  FigureColour colour = FigureColour::kBlue;
  FigureLine line = FigureLine::kSolid;
};

/// Of each series of a panel: see FigureColour (reports/figure.h).
std::vector<SeriesStyle> CalcStyles(const FigurePanel& panel);

}  // namespace uiclink
