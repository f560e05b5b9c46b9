#include "identify/digitise/arc_band.h"

#include <algorithm>
#include <cmath>

namespace uiclink::digitise {
namespace {

constexpr double kTurn = 1.0;  // a turning point counts when the curve comes back by that much [px]

}  // namespace

std::vector<ArcStep> Walk(const UniformSpline& curve) {
  std::vector<ArcStep> arc;
  for (double x = curve.first(); x < curve.last();) {
    const UniformSpline::Basis basis = curve.At(x);
    const double slope = curve.Slope(basis);
    arc.push_back({x, curve.Value(basis), slope});
    // The slope a step further on counts as well: near a turn it changes fast.
    double dx = kArcStep / std::hypot(1.0, slope);
    const double next = curve.Slope(curve.At(std::min(x + dx, curve.last())));
    dx = std::min(dx, 2 * kArcStep / std::hypot(1.0, std::max(std::abs(slope), std::abs(next))));
    const double rise = std::abs(curve(std::min(x + dx, curve.last())) - arc.back().y);
    if (rise > 1.5 * kArcStep) dx *= kArcStep / rise;
    x += std::max(dx, 1e-4);
  }
  int branch = 0, way = 0;
  double extreme = arc.empty() ? 0 : arc.front().y;
  for (ArcStep& step : arc) {
    const double off = step.y - extreme;
    if (way == 0 && std::abs(off) > kTurn) way = off > 0 ? 1 : -1;
    if (way * off >= 0) extreme = step.y;
    if (way * off < -kTurn) way = -way, extreme = step.y, ++branch;
    step.branch = branch;
  }
  return arc;
}

void Splat(const std::vector<ArcStep>& arc, double reach, Band* band) {
  band->Clear();
  const int r = static_cast<int>(std::ceil(reach + kArcStep));
  for (std::size_t i = 0; i < arc.size(); ++i) {
    const ArcStep& step = arc[i];
    const int cx = static_cast<int>(std::lround(step.x)), cy = static_cast<int>(std::lround(step.y));
    for (int x = cx - r; x <= cx + r; ++x) {
      for (int y = cy - r; y <= cy + r; ++y) {
        Cell* const cell = band->Find(x, y);
        if (cell == nullptr) continue;
        const double dx = x - step.x, dy = y - step.y;
        const auto d = static_cast<float>(dx * dx + dy * dy);
        const int index = static_cast<int>(i);
        if (cell->step1 < 0 || arc[std::size_t(cell->step1)].branch == step.branch) {
          if (d < cell->d1) cell->d1 = d, cell->step1 = index;
        } else if (cell->step2 < 0 || arc[std::size_t(cell->step2)].branch == step.branch) {
          if (d < cell->d2) cell->d2 = d, cell->step2 = index;
        } else {  // a third branch takes the place of the farther one
          if (cell->d1 < cell->d2) std::swap(cell->d1, cell->d2), std::swap(cell->step1, cell->step2);
          if (d < cell->d1) cell->d1 = d, cell->step1 = index;
        }
        if (cell->d2 < cell->d1) std::swap(cell->d1, cell->d2), std::swap(cell->step1, cell->step2);
      }
    }
  }
}

}  // namespace uiclink::digitise
