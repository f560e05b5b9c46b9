#pragma once

#include <cstddef>
#include <vector>

#include "reports/figure.h"

namespace uiclink {

/// What an axis shows: low < high, both > 0 on a logarithmic one.
struct AxisRange {
  double low = 0;
  double high = 1;
};

/// Where a panel stands in the picture, in pixels from its upper left corner: the rectangle inside of the axes.
struct PanelBox {
  double left = 0;
  double right = 0;
  double top = 0;
  double bottom = 0;
  std::size_t legend_columns = 1;   ///< entries beside each other
  bool legend_below_title = false;  ///< the legend has rows of its own; else it shares the line of the title
};

struct PanelLayout {
  PanelBox box;
  AxisRange x;
  AxisRange y;
};

/// From the axis of y to the middle of its title [px]: within the margin, left of tics with seven letters.
inline constexpr double kVerticalTitle = 70;

struct FigureLayout {
  int height = 0;  ///< of the picture [px]
  std::vector<PanelLayout> panels;
};

/// @throws std::invalid_argument as RenderSvg (reports/figure.h).
void CheckFigure(const Figure& figure);

/// Sizes and ranges of everything, for a figure that passes CheckFigure.
FigureLayout CalcLayout(const Figure& figure);

/// "lateral displacement [mm]"
std::string AxisTitle(const FigureAxis& axis);

}  // namespace uiclink
