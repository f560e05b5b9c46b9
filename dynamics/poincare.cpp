#include "dynamics/poincare.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace uiclink {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kLeastPoints = 12;

/// rms |p_(i+k) - p_i| / sqrt(2): what the points are known to, if every k-th is the same.
double CalcStep(const MatrixXd& p, Index k) {
  const Index n = p.cols() - k;
  return std::sqrt((p.rightCols(n) - p.leftCols(n)).squaredNorm() / static_cast<double>(2 * n));
}

/// The points less the mean of every k-th.
MatrixXd SubtractMeans(const MatrixXd& p, Index k) {
  MatrixXd deviations = p;
  for (Index r = 0; r < k; ++r) {
    VectorXd sum = VectorXd::Zero(p.rows());
    Index count = 0;
    for (Index i = r; i < p.cols(); i += k, ++count) sum += p.col(i);
    for (Index i = r; i < p.cols(); i += k) deviations.col(i) -= sum / static_cast<double>(count);
  }
  return deviations;
}

double CalcRms(const MatrixXd& p) { return std::sqrt(p.squaredNorm() / static_cast<double>(p.cols())); }

/// The smallest k whose step is near the least; `least` keeps rounding from being compared with rounding.
Index FindReturns(const MatrixXd& p, const SectionOptions& options) {
  const Index most = std::min<Index>(options.most_returns, p.cols() / 4);
  std::vector<double> steps;
  for (Index k = 1; k <= most; ++k) steps.push_back(CalcStep(p, k) + 0.1 * options.least);
  const double best = *std::ranges::min_element(steps);
  const auto first = std::ranges::find_if(steps, [&](double step) { return step <= 2 * best; });
  return first - steps.begin() + 1;
}

/// Slope of log(values) over evenly spaced times.
double CalcLogSlope(const std::array<double, 4>& values, double spacing) {
  const auto log = [&](std::size_t i) { return std::log(values[i]); };
  return (1.5 * (log(3) - log(0)) + 0.5 * (log(2) - log(1))) / (5 * spacing);
}

/// Growth or decay of four values, one a quarter of the series; 0 where they have no trend.
double FindTrend(const std::array<double, 4>& quarters, double quarter_s, double least, double factor) {
  if (std::ranges::max(quarters) < least || std::ranges::min(quarters) <= 0) return 0;
  const bool rises = std::ranges::is_sorted(quarters);
  const bool falls = std::ranges::is_sorted(quarters, std::greater<>());
  if (!rises && !falls) return 0;
  const double change = quarters[3] / quarters[0];
  if (change < factor && change > 1 / factor) return 0;
  return CalcLogSlope(quarters, quarter_s);
}

MatrixXd Quarter(const MatrixXd& p, Index quarter) {
  const Index size = p.cols() / 4;
  return p.middleCols(p.cols() - (4 - quarter) * size, size);
}

/// The sequence along its direction of largest variance.
VectorXd CalcPrincipal(const MatrixXd& deviations) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(deviations * deviations.transpose());
  return deviations.transpose() * solver.eigenvectors().rightCols(1);
}

/// How many times a sequence goes from beyond a half of its rms on one side of its mean to the other side.
int CountTurns(const VectorXd& z) {
  const double mean = z.mean();
  const double level = 0.5 * std::sqrt((z.array() - mean).square().mean());
  int side = 0, turns = 0;
  for (const double value : z) {
    const int now = value - mean > level ? 1 : (value - mean < -level ? -1 : 0);
    if (now == 0 || now == side) continue;
    turns += side != 0;
    side = now;
  }
  return turns;
}

/// The strongest line of a sequence, in cycles per point, 0 < f <= 1/2: Hann window, on a grid eight times finer than
/// the lines, refined by a parabola. Sequences are short (hundreds of points): no fast transform is needed.
double FindStrongestLine(const VectorXd& z) {
  const auto n = static_cast<double>(z.size());
  const double mean = z.mean();
  const auto power = [&](double f) {
    std::complex<double> sum = 0;
    const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * f);
    std::complex<double> at = 1;
    for (Index i = 0; i < z.size(); ++i, at *= turn) {
      const double hann = 1 - std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / n);
      sum += (z[i] - mean) * hann * at;
    }
    return std::norm(sum);
  };
  const double grid = 1 / (8 * n);
  const auto most = static_cast<int>(4 * n);
  int best = 8;
  double highest = 0;
  for (int i = 8; i <= most; ++i) {  // from one cycle in all on
    const double here = power(i * grid);
    if (here > highest) {
      highest = here;
      best = i;
    }
  }
  const double left = std::log(power((best - 1) * grid)), right = std::log(power((best + 1) * grid));
  const double bend = left - 2 * std::log(highest) + right;
  const double shift = bend < 0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0;
  return std::min((best + shift) * grid, 0.5);
}

/// Largest correlation of the deviations with themselves at lags from a quarter to half of the series.
double FindLongCorrelation(const MatrixXd& deviations) {
  const Index n = deviations.cols();
  double best = 0;
  for (Index lag = n / 4; lag <= n / 2; ++lag) {
    const auto early = deviations.leftCols(n - lag).array();
    const auto late = deviations.rightCols(n - lag).array();
    const double size = std::sqrt(early.square().sum() * late.square().sum());
    if (size > 0) best = std::max(best, (early * late).sum() / size);
  }
  return best;
}

class Classifier {
 public:
  Classifier(std::span<const double> times, const MatrixXd& p, const SectionOptions& options)
      : p_(p), options_(options), interval_((times.back() - times.front()) / static_cast<double>(times.size() - 1)) {}

  SectionMotion Run() {
    const MatrixXd late = p_.rightCols(p_.cols() / 2);
    k_ = FindReturns(late, options_);
    motion_.k = static_cast<int>(k_);
    motion_.period = static_cast<double>(k_) * interval_;
    motion_.scatter = CalcRms(SubtractMeans(late, k_));
    motion_.tolerance = std::clamp(3 * CalcStep(late, k_), options_.least, options_.most);
    if (motion_.scatter <= motion_.tolerance) {
      motion_.rate = FindStepTrend();
      const bool moves = motion_.rate > 0 || (motion_.rate < 0 && motion_.scatter > options_.least);
      motion_.kind = moves ? MotionKind::kSettling : MotionKind::kPeriodic;
    } else {
      ClassifyWandering();
    }
    return motion_;
  }

 private:
  double quarter_s() const { return static_cast<double>(p_.cols() / 4) * interval_; }

  /// Of the steps from one return to the next: they shrink and grow as the distance to what is approached does.
  double FindStepTrend() const {
    std::array<double, 4> steps{};
    for (Index q = 0; q < 4; ++q) {
      const MatrixXd quarter = Quarter(p_, q);
      if (quarter.cols() <= k_) return 0;
      steps[static_cast<std::size_t>(q)] = CalcStep(quarter, k_);
    }
    return FindTrend(steps, quarter_s(), kRounding, options_.trend);
  }

  /// Of the distance from the means, quarter by quarter.
  double FindSpreadTrend() const {
    std::array<double, 4> spread{};
    for (Index q = 0; q < 4; ++q) spread[static_cast<std::size_t>(q)] = CalcRms(SubtractMeans(Quarter(p_, q), k_));
    return FindTrend(spread, quarter_s(), kRounding, options_.trend);
  }

  /// Every k-th point is near, but a torus with a turn of nearly k points has that too: k counts where the k means say
  /// most about the points.
  void KeepReturns() {
    if (CalcRms(SubtractMeans(p_, k_)) < 0.5 * CalcRms(SubtractMeans(p_, 1))) return;
    k_ = motion_.k = 1;
    motion_.period = interval_;
    motion_.scatter = CalcRms(SubtractMeans(p_.rightCols(p_.cols() / 2), 1));
  }

  void ClassifyWandering() {
    KeepReturns();
    const MatrixXd deviations = SubtractMeans(p_, k_);
    const VectorXd z = CalcPrincipal(deviations);
    const int turns = CountTurns(z);
    if (turns <= 1) {  // one way, from one side of the mean to the other
      motion_.kind = MotionKind::kSettling;
      motion_.rate = FindStepTrend();
      return;
    }
    const double line = FindStrongestLine(z);
    const double lines = line * static_cast<double>(p_.cols());  // cycles of the modulation within the series
    const double trend = FindSpreadTrend();
    if (trend != 0 && (lines >= 4 || turns <= 3)) {  // else a quarter is no whole modulation and its spread no trend
      motion_.kind = MotionKind::kSettling;
      motion_.rate = trend;
      return;
    }
    if (lines < 4) return;  // too short
    motion_.modulation_period = interval_ / line;
    motion_.correlation = FindLongCorrelation(deviations);
    motion_.kind = motion_.correlation >= options_.recurrence ? MotionKind::kModulated : MotionKind::kIrregular;
  }

  static constexpr double kRounding = 1e-9;  ///< steps below this are rounding [units of the scales]

  const MatrixXd& p_;
  const SectionOptions& options_;
  double interval_;  ///< between passages, on average [s]
  Index k_ = 1;
  SectionMotion motion_;
};

}  // namespace

SectionMotion ClassifySection(std::span<const double> times, const MatrixXd& points, const VectorXd& scales,
                              const SectionOptions& options) {
  if (points.cols() != static_cast<Index>(times.size()) || (points.cols() > 0 && points.rows() != scales.size()))
    throw std::invalid_argument("ClassifySection: times, points and scales do not agree in number");
  if (!(scales.array() > 0).all()) throw std::invalid_argument("ClassifySection: scales must be positive");
  if (times.empty()) return {.kind = MotionKind::kEquilibrium};
  if (points.cols() < kLeastPoints) return {};
  const MatrixXd scaled = scales.cwiseInverse().asDiagonal() * points;
  return Classifier(times, scaled, options).Run();
}

const char* MotionKindName(MotionKind kind) {
  switch (kind) {
    case MotionKind::kEquilibrium:
      return "equilibrium";
    case MotionKind::kPeriodic:
      return "periodic";
    case MotionKind::kModulated:
      return "modulated";
    case MotionKind::kIrregular:
      return "irregular";
    case MotionKind::kSettling:
      return "settling";
    case MotionKind::kTooShort:
      return "too short";
  }
  return "";
}

}  // namespace uiclink
