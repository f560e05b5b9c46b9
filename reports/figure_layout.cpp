#include "reports/figure_layout.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "reports/text_table.h"

namespace uiclink {
namespace {

constexpr double kTitleHeight = 34;   // of the figure [px]
constexpr double kLineHeight = 19;    // of a panel's title and of a row of its legend [px]
constexpr double kLetterWidth = 7.2;  // of the 13 px font, on average [px]
constexpr double kSampleWidth = 66;   // of a line in the legend with the blanks around it [px]
constexpr double kLeft = 84, kRight = 22, kTop = 10, kBottom = 54;  // margins of a panel [px]

bool IsShown(const FigureAxis& axis, double value) { return std::isfinite(value) && (!axis.log || value > 0); }

/// Smallest and largest of what is to be seen; low > high where there is nothing.
struct Extent {
  double low = INFINITY;
  double high = -INFINITY;
  void Add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// `margin`: share of the range left free at either end that no bound fixes.
AxisRange CalcRange(const FigureAxis& axis, Extent extent, double margin) {
  if (axis.low) extent.low = *axis.low;
  if (axis.high) extent.high = *axis.high;
  if (!(extent.low <= extent.high)) {  // no data, or all of them beyond the one bound that is given
    const double unit = 1;
    if (axis.low) return {*axis.low, axis.log ? 10 * *axis.low : *axis.low + unit};
    if (axis.high) return {axis.log ? *axis.high / 10 : *axis.high - unit, *axis.high};
    return axis.log ? AxisRange{1, 10} : AxisRange{0, 1};
  }
  const auto map = [&](double v) { return axis.log ? std::log10(v) : v; };
  const auto back = [&](double v) { return axis.log ? std::pow(10, v) : v; };
  double low = map(extent.low), high = map(extent.high);
  double room = margin * (high - low);
  // A constant, as far as an axis can tell.
  const double size = std::max(std::abs(low), std::abs(high));
  if (high - low <= 1e-12 * size || high == low) room = axis.log || size == 0 ? 1 : 0.1 * size;
  if (!axis.low) low -= room;
  if (!axis.high) high += room;
  if (!(low < high)) high = low + room;
  return {axis.low ? *axis.low : back(low), axis.high ? *axis.high : back(high)};
}

/// A pixel of x becomes as much as one of y: the axis that shows less shows more, on both sides.
void MakeScalesEqual(const PanelBox& box, AxisRange* x, AxisRange* y) {
  const double per_x = (x->high - x->low) / (box.right - box.left);
  const double per_y = (y->high - y->low) / (box.bottom - box.top);
  const auto widen = [](AxisRange* range, double factor) {
    const double middle = 0.5 * (range->low + range->high), half = 0.5 * (range->high - range->low) * factor;
    *range = {middle - half, middle + half};
  };
  if (per_x < per_y) widen(x, per_y / per_x);
  if (per_y < per_x) widen(y, per_x / per_y);
}

double TextWidth(const std::string& text) { return kLetterWidth * static_cast<double>(DisplayWidth(text)); }

/// The legend shares the title's line where both fit, else it has as many rows as it takes.
PanelBox CalcBox(const FigurePanel& panel, double left, double top, double width, double height) {
  PanelBox box{
      .left = left + kLeft, .right = left + width - kRight, .top = top + kTop, .bottom = top + height - kBottom};
  double widest = 0;
  std::size_t entries = 0;
  for (const FigureSeries& series : panel.series) {
    if (series.name.empty()) continue;
    widest = std::max(widest, kSampleWidth + TextWidth(series.name));
    ++entries;
  }
  box.legend_columns = std::max<std::size_t>(entries, 1);
  if (entries > 0 || !panel.title.empty()) box.top += kLineHeight;
  if (entries == 0) return box;
  const double line = box.right - box.left;
  if (TextWidth(panel.title) + widest * static_cast<double>(entries) <= line) return box;
  box.legend_below_title = true;
  box.legend_columns = std::clamp<std::size_t>(static_cast<std::size_t>(line / widest), 1, entries);
  const std::size_t rows = (entries + box.legend_columns - 1) / box.legend_columns;
  box.top += kLineHeight * static_cast<double>(panel.title.empty() ? rows - 1 : rows);
  return box;
}

PanelLayout CalcPanel(const FigurePanel& panel, const PanelBox& box) {
  Extent x, y;
  for (const FigureSeries& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!IsShown(panel.x, series.x[i]) || !IsShown(panel.y, series.y[i])) continue;
      x.Add(series.x[i]);
      y.Add(series.y[i]);
    }
  }
  for (const FigureGuide& guide : panel.vertical_guides) {
    if (IsShown(panel.x, guide.value)) x.Add(guide.value);
  }
  for (const FigureGuide& guide : panel.horizontal_guides) {
    if (IsShown(panel.y, guide.value)) y.Add(guide.value);
  }
  // Lines over time end at the edges of the panel; points and curves that turn back keep clear of them.
  const bool to_the_edges = !panel.equal_scales && std::ranges::all_of(panel.series, [](const FigureSeries& series) {
    return series.mark == FigureMark::kNone && std::ranges::is_sorted(series.x);
  });
  PanelLayout layout{.box = box, .x = CalcRange(panel.x, x, to_the_edges ? 0 : 0.03), .y = CalcRange(panel.y, y, 0.06)};
  if (panel.equal_scales) MakeScalesEqual(box, &layout.x, &layout.y);
  return layout;
}

void CheckAxis(const FigureAxis& axis, const std::string& panel) {
  const std::string name = "RenderFigure: axis \"" + axis.label + "\" of panel \"" + panel + "\": ";
  for (const std::optional<double>& bound : {axis.low, axis.high}) {
    if (!bound) continue;
    if (!std::isfinite(*bound)) throw std::invalid_argument(name + "a bound is not finite");
    if (axis.log && !(*bound > 0)) throw std::invalid_argument(name + "a bound of a logarithmic axis must be > 0");
  }
  if (axis.low && axis.high && !(*axis.low < *axis.high)) {
    throw std::invalid_argument(name + "low = " + std::to_string(*axis.low) +
                                " must be below high = " + std::to_string(*axis.high));
  }
}

}  // namespace

void CheckFigure(const Figure& figure) {
  if (figure.panels.empty()) throw std::invalid_argument("RenderFigure: \"" + figure.title + "\" has no panel");
  if (figure.columns == 0 || figure.width < 200 || figure.panel_height < 100) {
    throw std::invalid_argument("RenderFigure: \"" + figure.title +
                                "\": columns must be > 0, width >= 200, panel_height >= 100");
  }
  for (const FigurePanel& panel : figure.panels) {
    CheckAxis(panel.x, panel.title);
    CheckAxis(panel.y, panel.title);
    if (panel.equal_scales && (panel.x.log || panel.y.log)) {
      throw std::invalid_argument("RenderFigure: panel \"" + panel.title + "\": equal scales need linear axes");
    }
    for (const FigureSeries& series : panel.series) {
      if (series.x.size() == series.y.size()) continue;
      throw std::invalid_argument("RenderFigure: series \"" + series.name + "\": " + std::to_string(series.x.size()) +
                                  " values of x, " + std::to_string(series.y.size()) + " of y");
    }
  }
}

FigureLayout CalcLayout(const Figure& figure) {
  const std::size_t columns = std::min(figure.columns, figure.panels.size());
  const std::size_t rows = (figure.panels.size() + columns - 1) / columns;
  const double title = figure.title.empty() ? 0 : kTitleHeight;
  const double width = static_cast<double>(figure.width) / static_cast<double>(columns);
  FigureLayout layout{.height = static_cast<int>(title) + static_cast<int>(rows) * figure.panel_height, .panels = {}};
  for (std::size_t i = 0; i < figure.panels.size(); ++i) {
    const double left = static_cast<double>(i % columns) * width;
    const double top = title + static_cast<double>(i / columns) * figure.panel_height;
    layout.panels.push_back(
        CalcPanel(figure.panels[i], CalcBox(figure.panels[i], left, top, width, figure.panel_height)));
  }
  return layout;
}

std::string AxisTitle(const FigureAxis& axis) {
  return axis.unit.empty() ? axis.label : axis.label + " [" + axis.unit + "]";
}

}  // namespace uiclink
