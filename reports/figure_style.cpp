#include "reports/figure_style.h"

#include <cstddef>
#include <stdexcept>

namespace uiclink {

const char* ColourCode(FigureColour colour) {
  switch (colour) {
    case FigureColour::kBlue:
      return "#0072b2";
    case FigureColour::kVermilion:
      return "#d55e00";
    case FigureColour::kGreen:
      return "#009e73";
    case FigureColour::kPurple:
      return "#cc79a7";
    case FigureColour::kSky:
      return "#56b4e9";
    case FigureColour::kOrange:
      return "#e69f00";
    case FigureColour::kBlack:
      return "#000000";
  }
  throw std::invalid_argument("ColourCode: no such colour");
}

std::vector<SeriesStyle> CalcStyles(const FigurePanel& panel) {
  constexpr std::size_t kColours = 7;
  std::vector<SeriesStyle> styles;
  std::size_t dealt = 0;
  for (const FigureSeries& series : panel.series) {
    SeriesStyle style{.line = series.line};
    if (series.colour) {
      style.colour = *series.colour;
    } else {
      if (dealt >= kColours && series.line == FigureLine::kSolid) style.line = FigureLine::kDashed;
      style.colour = static_cast<FigureColour>(dealt++ % kColours);
    }
    styles.push_back(style);
  }
  return styles;
}

}  // namespace uiclink
