#include "identify/local_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

// With five samples a parabola still leaves two to average.
constexpr std::size_t kFewest = 5;

/// Newton from the middle of the window; the curve is nearly a parabola (or a line), so few steps are needed.
template <typename F, typename G>
std::optional<double> FindRoot(const F& f, const G& slope, double t0, double half_width) {
  double t = t0;
  for (int i = 0; i < 20; ++i) {
    const double step = f(t) / slope(t);
    if (!std::isfinite(step)) return std::nullopt;
    t -= step;
    if (std::abs(t - t0) > half_width) return std::nullopt;
    if (std::abs(step) < 1e-12) break;
  }
  return t;
}

}  // namespace

double LocalFit::y(double t) const {
  const double s = t - t0;
  return c0 + s * (c1 * (1 - w * w * s * s / 6) + s * c2 * (1 - w * w * s * s / 12));
}

double LocalFit::v(double t) const {
  const double s = t - t0;
  return c1 * (1 - w * w * s * s / 2) + 2 * c2 * s * (1 - w * w * s * s / 6);
}

std::optional<double> LocalFit::FindTurning() const {
  const auto curvature = [this](double time) {
    const double s = time - t0;
    return -c1 * w * w * s + 2 * c2 * (1 - w * w * s * s / 2);
  };
  return FindRoot([this](double time) { return v(time); }, curvature, t0, half_width);
}

std::optional<double> LocalFit::FindCrossing(double level) const {
  return FindRoot([this, level](double time) { return y(time) - level; }, [this](double time) { return v(time); }, t0,
                  half_width);
}

double LocalFit::LevelError(double sigma) const {
  // Middle of a least-squares parabola through many equally spaced samples: variance 9/4 sigma^2/n.
  return 1.5 * sigma / std::sqrt(static_cast<double>(size));
}

std::optional<LocalFit> FitLocally(std::span<const double> t, std::span<const double> y, std::size_t centre,
                                   double half_width, double w) {
  const double t0 = t[centre];
  if (t0 - half_width < t.front() || t0 + half_width > t.back()) return std::nullopt;
  std::size_t first = centre, last = centre;  // last is included
  while (first > 0 && t0 - t[first - 1] <= half_width) --first;
  while (last + 1 < t.size() && t[last + 1] - t0 <= half_width) ++last;
  // A coarse record widens the window rather than losing the extremum.
  while (last - first + 1 < kFewest && first > 0 && last + 1 < t.size()) --first, ++last;
  const std::size_t n = last - first + 1;
  if (n < kFewest) return std::nullopt;

  // Scaled to the window and to the middle reading, so that the normal equations stay well conditioned.
  const double scale = std::max(t[last] - t0, t0 - t[first]);
  const double cubic = w * w * scale * scale / 6, quartic = cubic / 2;
  double s1 = 0, s2 = 0, s1b = 0, sb = 0, sbb = 0, sy = 0, s1y = 0, sby = 0;
  for (std::size_t i = first; i <= last; ++i) {
    const double x = (t[i] - t0) / scale, r = y[i] - y[centre];
    const double s = x * (1 - cubic * x * x), b = x * x * (1 - quartic * x * x);
    s1 += s, s2 += s * s, s1b += s * b, sb += b, sbb += b * b;
    sy += r, s1y += s * r, sby += b * r;
  }
  Eigen::Matrix3d normal;
  normal << static_cast<double>(n), s1, sb, s1, s2, s1b, sb, s1b, sbb;
  const Eigen::Vector3d c = normal.inverse() * Eigen::Vector3d(sy, s1y, sby);
  if (!c.allFinite()) return std::nullopt;
  return LocalFit{.t0 = t0,
                  .c0 = y[centre] + c[0],
                  .c1 = c[1] / scale,
                  .c2 = c[2] / (scale * scale),
                  .w = w,
                  .half_width = scale,
                  .size = n};
}

}  // namespace uiclink
