#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "identify/digitise/inks.h"
#include "identify/digitise/spline.h"
#include "identify/digitise/trace.h"

namespace uiclink::digitise {

inline constexpr double kArcStep = 0.7;  ///< length of a step along the curve [px]

/// A step along the read curve, about 0.7 px long.
struct ArcStep {
  double x = 0, y = 0;  ///< its start [px]
  double slope = 0;     ///< dy/dx
  int branch = 0;       ///< counts the turning points passed
  bool known = true;    ///< the picture says something here
  bool inked = true;    ///< it says that the line is drawn here
};

/// Walks the curve in steps of equal length and numbers its branches.
std::vector<ArcStep> Walk(const UniformSpline& curve);

/// Nearest points of up to two branches to a pixel.
struct Cell {
  float d1 = 1e9F, d2 = 1e9F;  ///< squared distance [px^2]
  int step1 = -1, step2 = -1;  ///< index into the arc
};

/// Cells of the columns, each from its own first row: only what is near the line is kept.
class Band {
 public:
  Band(const Trace& trace, const Inks& inks, const std::vector<double>& start, double margin)
      : x0_(inks.x0), first_row_(start.size()), begin_(start.size() + 1) {
    std::vector<double> low = start, high = start;
    for (const Stroke& s : trace.strokes) {
      const auto i = static_cast<std::size_t>(s.x - x0_);
      low[i] = std::min(low[i], s.low), high[i] = std::max(high[i], s.high);
    }
    for (std::size_t i = 0; i < start.size(); ++i) {
      const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, start.size() - 1);
      const double from = std::min({low[before], low[i], low[after]}) - margin;
      const double to = std::max({high[before], high[i], high[after]}) + margin;
      first_row_[i] = std::clamp(static_cast<int>(from), inks.y0, inks.y1);
      begin_[i + 1] =
          begin_[i] + static_cast<std::size_t>(std::clamp(static_cast<int>(to), inks.y0, inks.y1) - first_row_[i] + 1);
    }
    cells_.resize(begin_.back());
  }

  void Clear() { std::fill(cells_.begin(), cells_.end(), Cell{}); }

  template <typename Use>
  void ForEach(Use use) {
    for (std::size_t i = 0; i + 1 < begin_.size(); ++i)
      for (std::size_t k = begin_[i]; k < begin_[i + 1]; ++k)
        use(x0_ + static_cast<int>(i), first_row_[i] + static_cast<int>(k - begin_[i]), cells_[k]);
  }

  Cell* Find(int x, int y) {
    const auto i = static_cast<std::size_t>(x - x0_);
    if (x < x0_ || i + 1 >= begin_.size() || y < first_row_[i]) return nullptr;
    const std::size_t k = begin_[i] + static_cast<std::size_t>(y - first_row_[i]);
    return k < begin_[i + 1] ? &cells_[k] : nullptr;
  }

 private:
  int x0_;
  std::vector<int> first_row_;
  std::vector<std::size_t> begin_;
  std::vector<Cell> cells_;
};

/// Finds for every cell within `reach` of the curve the nearest steps of two branches; distances are squared.
void Splat(const std::vector<ArcStep>& arc, double reach, Band* band);

}  // namespace uiclink::digitise
