#include "identify/track/order.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace uiclink::track {
namespace {

constexpr int kSide = 5;            // samples on each side of a jump
constexpr int kDegree = 5;          // of the smooth motion
constexpr int kMostMissing = 8;     // pictures that a jump may hide
constexpr double kLeastJump = 0.3;  // rms of the residual without a shift [pixel]
constexpr double kExplained = 0.2;  // of the residual that may be left

using Window = Eigen::Matrix<double, 2 * kSide, 1>;

/// rms of what a polynomial leaves of the samples about `at`, those from `at` on moved by `shift` [s].
double CalcResidual(const MotionSeries& motion, std::size_t at, double shift, double step) {
  Eigen::Matrix<double, 2 * kSide, kDegree + 1> powers;
  Window x;
  for (int i = 0; i < 2 * kSide; ++i) {
    const std::size_t sample = at - kSide + static_cast<std::size_t>(i);
    const double t = motion.t[sample] + (i >= kSide ? shift : 0) - motion.t[at];
    const double s = t / (kSide * step);
    double power = 1;
    for (int d = 0; d <= kDegree; ++d, power *= s) powers(i, d) = power;
    x(i) = motion.x[sample] - motion.x[at];
  }
  const Window left = x - powers * powers.colPivHouseholderQr().solve(x);
  return std::sqrt(left.squaredNorm() / (2 * kSide - kDegree - 1));
}

struct Candidate {
  HiddenGap gap;
  double explained = 1;  // share of the residual that is left
};

std::optional<Candidate> JudgeAt(const MotionSeries& motion, std::size_t at, double step) {
  double variance = 0;
  for (std::size_t i = at - kSide; i < at + kSide; ++i) variance += motion.sigma[i] * motion.sigma[i];
  const double plain = CalcResidual(motion, at, 0, step);
  if (plain < std::max(kLeastJump, 4 * std::sqrt(variance / (2 * kSide)))) return std::nullopt;
  Candidate best{.gap = {.at = at, .pictures = 0}};
  const int most_doubled = static_cast<int>(std::lround((motion.t[at] - motion.t[at - 1]) / step)) - 1;
  for (int n = -std::min(most_doubled, kMostMissing); n <= kMostMissing; ++n) {
    if (n == 0) continue;
    const double left = CalcResidual(motion, at, n * step, step) / plain;
    if (left < best.explained) best.explained = left, best.gap.pictures = n;
  }
  if (best.explained > kExplained) return std::nullopt;
  return best;
}

}  // namespace

std::vector<double> CalcExcessScatter(const MotionSeries& motion) {
  const std::size_t n = motion.t.size();
  std::vector<double> excess(n, 0.0);
  if (n < 2 * kSide) return excess;
  const double step = (motion.t.back() - motion.t.front()) / static_cast<double>(n - 1);
  std::vector<double> scatter(n - 2 * kSide + 1);  // of the window that starts at a sample, variance
  for (std::size_t i = 0; i < scatter.size(); ++i) {
    const double rms = CalcResidual(motion, i + kSide, 0, step);
    scatter[i] = rms * rms;
  }
  constexpr std::size_t kWindows = 12;
  std::vector<double> some;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t middle = i < kSide ? 0 : std::min(i - kSide, scatter.size() - 1);
    const std::size_t first = middle < kWindows ? 0 : middle - kWindows;
    const std::size_t last = std::min(scatter.size(), middle + kWindows + 1);
    some.assign(scatter.begin() + static_cast<std::ptrdiff_t>(first),
                scatter.begin() + static_cast<std::ptrdiff_t>(last));
    // The median: a kink of the motion (a joint that starts to slip) is in few windows.
    const auto half = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
    std::nth_element(some.begin(), half, some.end());
    excess[i] = std::sqrt(std::max(0.0, *half - motion.sigma[i] * motion.sigma[i]));
  }
  return excess;
}

std::vector<std::size_t> FindRepeated(const MotionSeries& motion) {
  std::vector<std::size_t> repeated;
  const std::vector<double>& x = motion.x;
  for (std::size_t i = 2; i + 2 < x.size(); ++i) {
    const double step = motion.t[i] - motion.t[i - 1], two = motion.t[i + 2] - motion.t[i - 2];
    if (two > 4.5 * step) continue;  // across a gap
    // Cubic through the neighbours.
    const double expected = (4 * (x[i - 1] + x[i + 1]) - x[i - 2] - x[i + 2]) / 6 - x[i - 1];
    const double moved = x[i] - x[i - 1];
    const bool same_way = (x[i - 1] - x[i - 2]) * (x[i + 1] - x[i]) > 0;
    if (same_way && std::abs(expected) > std::max(0.5, 8 * motion.sigma[i]) &&
        std::abs(moved) < std::max(0.1 * std::abs(expected), std::min(3 * motion.sigma[i], 0.3 * std::abs(expected))))
      repeated.push_back(i);
  }
  return repeated;
}

std::vector<HiddenGap> FindHiddenGaps(const MotionSeries& motion, double step) {
  std::vector<HiddenGap> gaps;
  MotionSeries corrected = motion;
  // One after the other, the clearest first: a gap disturbs the judgement of its neighbours.
  for (std::size_t round = 0; round < motion.t.size() / kSide; ++round) {
    std::optional<Candidate> best;
    for (std::size_t at = kSide; at + kSide <= corrected.t.size(); ++at) {
      const std::optional<Candidate> here = JudgeAt(corrected, at, step);
      if (here && (!best || here->explained < best->explained)) best = here;
    }
    if (!best) break;
    gaps.push_back(best->gap);
    for (std::size_t i = best->gap.at; i < corrected.t.size(); ++i) corrected.t[i] += best->gap.pictures * step;
  }
  std::sort(gaps.begin(), gaps.end(), [](const HiddenGap& a, const HiddenGap& b) { return a.at < b.at; });
  return gaps;
}

}  // namespace uiclink::track
