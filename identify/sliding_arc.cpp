#include "identify/sliding_arc.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace uiclink {
namespace {

constexpr int kMaxSteps = 30;
constexpr double kConverged = 1e-10;  // relative step of w; its standard deviation is above 1e-5 in any record

/// Sums of products over one arc of  c = cos ws, s = sin ws, tau c, tau s, 1, y  with s = t - t_j.
using Gram = Eigen::Matrix<double, 6, 6>;
enum { kC, kS, kTC, kTS, kOne, kY };

/// `level` is subtracted from the readings.
Gram CalcGram(std::span<const double> t, std::span<const double> y, const ArcWindow& arc, double w, double level) {
  std::array<double, 21> sums{};
  for (std::size_t i = arc.first; i < arc.last; ++i) {
    const double tau = t[i] - arc.t, c = std::cos(w * tau), s = std::sin(w * tau);
    const std::array<double, 6> v = {c, s, tau * c, tau * s, 1.0, y[i] - level};
    std::size_t k = 0;
    for (std::size_t p = 0; p < 6; ++p)
      for (std::size_t q = p; q < 6; ++q) sums[k++] += v[p] * v[q];
  }
  Gram gram;
  std::size_t k = 0;
  for (int p = 0; p < 6; ++p)
    for (int q = p; q < 6; ++q) gram(p, q) = gram(q, p) = sums[k++];
  return gram;
}

/// One arc with its own amplitude and phase eliminated.
struct Reduced {
  Eigen::Matrix<double, 2, 2> local_inverse;
  Gram gram;

  explicit Reduced(const Gram& g) : local_inverse(g.topLeftCorner<2, 2>().inverse()), gram(g) {}

  /// Product of two combinations of the six series after what a_j and b_j can follow is taken out.
  double operator()(const Eigen::Matrix<double, 6, 1>& u, const Eigen::Matrix<double, 6, 1>& v) const {
    const Eigen::Matrix<double, 6, 1> gv = gram * v;
    const Eigen::Matrix<double, 6, 1> gu = gram * u;
    return u.dot(gv) - gu.head<2>().dot(local_inverse * gv.head<2>());
  }
};

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1>;

/// Linear problem at one w, and its Gauss-Newton step in w.
struct Step {
  SmallVector centre;  // zero (less the level), and the shift where both sides are there
  Small normal;        // of w, zero, shift
  double dw = 0, rss = 0;
};

/// How the centre of an arc depends on zero and shift.
SmallVector CentreRow(const ArcWindow& arc, bool both_sides) {
  SmallVector row(both_sides ? 2 : 1);
  row[0] = 1;
  if (both_sides) row[1] = -arc.side;
  return row;
}

Step Solve(const std::vector<Reduced>& arcs, std::span<const ArcWindow> windows, bool both_sides) {
  const Vector6 one = Vector6::Unit(kOne), y = Vector6::Unit(kY);
  const int n = both_sides ? 2 : 1;
  Small m = Small::Zero(n, n);
  SmallVector rhs = SmallVector::Zero(n);
  for (std::size_t j = 0; j < arcs.size(); ++j) {
    const SmallVector row = CentreRow(windows[j], both_sides);
    m += arcs[j](one, one) * row * row.transpose();
    rhs += arcs[j](one, y) * row;
  }
  Step step;
  step.centre = m.ldlt().solve(rhs);

  step.normal = Small::Zero(n + 1, n + 1);
  SmallVector gradient = SmallVector::Zero(n + 1);
  for (std::size_t j = 0; j < arcs.size(); ++j) {
    const SmallVector row = CentreRow(windows[j], both_sides);
    Vector6 residual = y - row.dot(step.centre) * one;
    const Eigen::Vector2d ab = arcs[j].local_inverse * (arcs[j].gram * residual).head<2>();
    const Vector6 by_w = -ab[0] * Vector6::Unit(kTS) + ab[1] * Vector6::Unit(kTC);
    const double cross = arcs[j](by_w, one);
    step.normal(0, 0) += arcs[j](by_w, by_w);
    step.normal.block(0, 1, 1, n) += cross * row.transpose();
    step.normal.block(1, 0, n, 1) += cross * row;
    step.normal.block(1, 1, n, n) += arcs[j](one, one) * row * row.transpose();
    gradient[0] += arcs[j](by_w, residual);
    gradient.tail(n) += arcs[j](one, residual) * row;
    step.rss += arcs[j](residual, residual);
  }
  step.dw = step.normal.ldlt().solve(gradient)[0];
  return step;
}

}  // namespace

std::optional<ArcFit> FitSlidingArcs(std::span<const double> t, std::span<const double> y,
                                     std::span<const ArcWindow> arcs, double omega) {
  std::size_t samples = 0;
  bool maxima = false, minima = false;
  for (const ArcWindow& arc : arcs) {
    samples += arc.last - arc.first;
    (arc.side > 0 ? maxima : minima) = true;
  }
  const bool both_sides = maxima && minima;
  const std::size_t unknowns = 2 * arcs.size() + (both_sides ? 3 : 2);
  if (samples <= unknowns) return std::nullopt;

  const double level = y[arcs[0].first];
  std::vector<Reduced> reduced;
  reduced.reserve(arcs.size());
  double w = omega;
  Step step;
  for (int i = 0;; ++i) {
    reduced.clear();
    for (const ArcWindow& arc : arcs) reduced.emplace_back(CalcGram(t, y, arc, w, level));
    step = Solve(reduced, arcs, both_sides);
    if (!std::isfinite(step.dw) || i == kMaxSteps) return std::nullopt;
    if (std::abs(step.dw) < kConverged * w) break;
    w += std::clamp(step.dw, -0.15 * w, 0.15 * w);
    if (w < omega / 3 || w > 3 * omega) return std::nullopt;
  }

  const double variance = std::max(0.0, step.rss) / static_cast<double>(samples - unknowns);
  const Small covariance = variance * step.normal.inverse();
  ArcFit fit{.both_sides = both_sides,
             .omega = w,
             .omega_std = std::sqrt(covariance(0, 0)),
             .zero = level + step.centre[0],
             .zero_std = std::sqrt(covariance(1, 1)),
             .rms = std::sqrt(std::max(0.0, step.rss) / static_cast<double>(samples))};
  if (both_sides) {
    fit.shift = step.centre[1];
    fit.shift_std = std::sqrt(covariance(2, 2));
    fit.covariance_omega_shift = covariance(0, 2);
  }
  return fit;
}

ArcWindow FindSlidingArc(std::span<const double> t, std::span<const double> y, std::size_t from_index, double from,
                         std::size_t index, double t_extremum, double travel) {
  ArcWindow arc{.first = index, .last = index + 1, .t = t_extremum, .side = y[index] > from ? 1.0 : -1.0};
  if (t[index] > t_extremum) --arc.last;  // what lies behind the extremum sticks
  while (arc.first > from_index && arc.side * (y[arc.first - 1] - from) > travel) --arc.first;
  arc.first = std::min(arc.first, arc.last);
  return arc;
}

}  // namespace uiclink
