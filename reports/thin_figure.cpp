#include "reports/thin_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace uiclink {
namespace {

constexpr double kNear = 0.4;   // [px], of lines
constexpr double kApart = 2;    // [px], of marks: less than their size
constexpr double kMost = 1500;  // points of a line: three to a pixel of half a page

/// Pixels per unit of an axis, roughly: frames and labels are taken for part of the panel.
class PixelScale {
 public:
  PixelScale(const FigureAxis& axis, double size) : log_(axis.log), size_(size), low_(axis.low), high_(axis.high) {}

  void Include(const std::vector<double>& values) {
    for (const double value : values) {
      if (!IsDrawn(value)) continue;
      if (!(value >= least_)) least_ = value;
      if (!(value <= greatest_)) greatest_ = value;
    }
  }
  bool IsDrawn(double value) const { return std::isfinite(value) && (!log_ || value > 0); }
  double operator()(double value) const {
    const double low = Bend(low_.value_or(least_)), high = Bend(high_.value_or(greatest_));
    return high > low ? size_ * (Bend(value) - low) / (high - low) : 0;
  }

 private:
  double Bend(double value) const { return log_ ? std::log10(value) : value; }

  bool log_;
  double size_;
  std::optional<double> low_, high_;
  double least_ = std::numeric_limits<double>::quiet_NaN(), greatest_ = least_;
};

struct Pixels {
  std::vector<double> x, y;
  std::size_t size() const { return x.size(); }
};

double Distance(const Pixels& at, std::size_t point, std::size_t from, std::size_t to) {
  const double dx = at.x[to] - at.x[from], dy = at.y[to] - at.y[from];
  const double px = at.x[point] - at.x[from], py = at.y[point] - at.y[from];
  const double length = std::hypot(dx, dy);
  return length > 0 ? std::abs(dx * py - dy * px) / length : std::hypot(px, py);
}

/// Marks those of [first, last] that a line needs.
void KeepCorners(const Pixels& at, std::size_t first, std::size_t last, std::vector<char>* kept) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{first, last}};
  (*kept)[first] = (*kept)[last] = 1;
  while (!open.empty()) {
    const auto [from, to] = open.back();
    open.pop_back();
    std::size_t farthest = from;
    double distance = kNear;
    for (std::size_t i = from + 1; i < to; ++i) {
      if (const double here = Distance(at, i, from, to); here > distance) {
        distance = here;
        farthest = i;
      }
    }
    if (farthest == from) continue;
    (*kept)[farthest] = 1;
    open.insert(open.end(), {{from, farthest}, {farthest, to}});
  }
}

std::vector<char> KeepLine(const Pixels& at) {
  std::vector<char> kept(at.size(), 0);
  const auto is_gap = [&](std::size_t i) { return std::isnan(at.x[i]); };
  for (std::size_t i = 0; i < at.size();) {
    std::size_t end = i;
    while (end < at.size() && !is_gap(end)) ++end;
    if (end > i) KeepCorners(at, i, end - 1, &kept);
    if (end < at.size()) kept[end] = 1;
    i = end + 1;
  }
  return kept;
}

/// One mark in each square of kApart pixels.
std::vector<char> KeepMarks(const Pixels& at) {
  std::vector<char> kept(at.size(), 0);
  std::set<std::pair<long, long>> taken;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (std::isnan(at.x[i])) continue;
    kept[i] = taken.emplace(std::lround(at.x[i] / kApart), std::lround(at.y[i] / kApart)).second ? 1 : 0;
  }
  return kept;
}

template <typename Keep>
void Select(Keep keep, FigureSeries* series) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < series->x.size(); ++i) {
    if (!keep(i)) continue;
    series->x[count] = series->x[i];
    series->y[count++] = series->y[i];
  }
  series->x.resize(count);
  series->y.resize(count);
}

/// @param most  points of a line, about: more are brought to their outline.
void ThinSeries(const PixelScale& x, const PixelScale& y, std::size_t most, FigureSeries* series) {
  const bool line = series->line != FigureLine::kNone;
  if (line && series->mark != FigureMark::kNone) return;  // marks that stand for something each
  if (line) {
    std::vector<char> outline(series->x.size(), 0);
    for (const std::size_t i : ThinForDrawing(series->x, series->y, most)) outline[i] = 1;
    Select([&](std::size_t i) { return outline[i] != 0; }, series);
  }
  Pixels at;
  for (std::size_t i = 0; i < series->x.size(); ++i) {
    const bool drawn = x.IsDrawn(series->x[i]) && y.IsDrawn(series->y[i]);
    at.x.push_back(drawn ? x(series->x[i]) : std::numeric_limits<double>::quiet_NaN());
    at.y.push_back(drawn ? y(series->y[i]) : 0);
  }
  const std::vector<char> kept = line ? KeepLine(at) : KeepMarks(at);
  Select([&](std::size_t i) { return kept[i] != 0; }, series);
}

}  // namespace

void ThinToPixels(Figure* figure, double magnified) {
  const auto most = static_cast<std::size_t>(magnified * kMost);
  for (FigurePanel& panel : figure->panels) {
    PixelScale x(panel.x, magnified * figure->width / static_cast<double>(figure->columns));
    PixelScale y(panel.y, magnified * figure->panel_height);
    for (const FigureSeries& series : panel.series) {
      x.Include(series.x);
      y.Include(series.y);
    }
    for (FigureSeries& series : panel.series) ThinSeries(x, y, most, &series);
  }
}

}  // namespace uiclink
