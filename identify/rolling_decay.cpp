#include "identify/rolling_decay.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/significance.h"

namespace uiclink {
namespace {

constexpr std::size_t kFewestTurns = 6;  // four unknowns of its own, and the exponent
constexpr double kModelledShare = 0.1;   // of the loss of a record that the model's own may be
constexpr double kHidden = 0.1;          // of the error of a turn: hidden in any number of records
constexpr double kLowestExponent = -1, kHighestExponent = 7, kExponentStep = 0.25;
constexpr double kResolution = 1e-3;  // of the exponent
constexpr double kGolden = 0.6180339887498949;
constexpr double kChiSquareBound = 3.84;  // 95 % of one degree of freedom
constexpr int kMaxSteps = 40;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Amplitude after n half cycles, in units of the first one.
double CalcAmplitude(double a0, double c, double p, double n) {
  const double q = 2 - p;
  if (std::abs(q) < 1e-6) return a0 * std::exp(-c * n);
  const double base = std::pow(a0, q) - q * c * n;
  if (base <= 0) return q > 0 ? 0 : kInfinity;  // at rest; or a growth that no loss has
  return std::pow(base, 1 / q);
}

/// One tail for one exponent: unknowns a0, c, z, z'.
class TailFit {
 public:
  explicit TailFit(const RollingTail& tail) : turns_(tail.turns) {
    scale_ = 0.5 * Span(turns_, 0);
    side_ = turns_[0].y > turns_[1].y ? 1 : -1;
    const auto n = static_cast<double>(turns_.size());
    const double last = 0.5 * Span(turns_, turns_.size() - 2) / scale_;
    x_ << 1, (1 - last) / n, 0.5 * (turns_[0].y + turns_[1].y) / scale_, 0;
  }

  /// Least chi-square for the exponent p; starts where the last call ended.
  double Fit(double p, bool lossless = false) {
    if (lossless) x_[1] = 0;
    Eigen::Vector4d x = x_;
    Eigen::VectorXd residual = CalcResiduals(x, p);
    double chi2 = residual.squaredNorm(), damping = 1e-6;
    for (int i = 0; i < kMaxSteps && damping < 1e8; ++i) {
      Eigen::MatrixXd jacobian = CalcJacobian(x, p, residual);
      if (lossless) jacobian.col(1).setZero();
      Eigen::Matrix4d normal = jacobian.transpose() * jacobian;
      normal.diagonal() *= 1 + damping;
      if (lossless) normal(1, 1) = 1;
      const Eigen::Vector4d trial = x - normal.ldlt().solve(jacobian.transpose() * residual);
      const Eigen::VectorXd trial_residual = CalcResiduals(trial, p);
      const double trial_chi2 = trial_residual.squaredNorm();
      if (!(trial_chi2 < chi2)) {
        damping = std::max(1e-4, 10 * damping);
        continue;
      }
      const bool done = chi2 - trial_chi2 < 1e-8 * chi2;
      x = trial, residual = trial_residual, chi2 = trial_chi2, damping *= 0.1;
      if (done) break;
    }
    if (std::isfinite(chi2) && !lossless) x_ = x;
    return chi2;
  }

 private:
  Eigen::VectorXd CalcResiduals(const Eigen::Vector4d& x, double p) const {
    Eigen::VectorXd residual(static_cast<Eigen::Index>(turns_.size()));
    double side = side_;
    for (Eigen::Index i = 0; i < residual.size(); ++i, side = -side) {
      const auto n = static_cast<double>(i);
      const Turn& turn = turns_[static_cast<std::size_t>(i)];
      const double amplitude = x[0] > 0 ? CalcAmplitude(x[0], x[1], p, n) : kInfinity;
      residual[i] = (x[2] + x[3] * n + side * amplitude - turn.y / scale_) * scale_ / turn.error;
    }
    return residual;
  }

  Eigen::MatrixXd CalcJacobian(const Eigen::Vector4d& x, double p, const Eigen::VectorXd& residual) const {
    Eigen::MatrixXd jacobian(residual.size(), 4);
    for (Eigen::Index j = 0; j < 4; ++j) {
      Eigen::Vector4d moved = x;
      const double step = 1e-6 * std::max(0.01, std::abs(x[j]));
      moved[j] += step;
      jacobian.col(j) = (CalcResiduals(moved, p) - residual) / step;
    }
    return jacobian;
  }

  std::span<const Turn> turns_;
  double scale_ = 1, side_ = 1;
  Eigen::Vector4d x_;
};

/// All tails together; chi-square over the exponent.
class Profile {
 public:
  explicit Profile(std::vector<TailFit> fits) : fits_(std::move(fits)) {
    for (double p = kLowestExponent; p < kHighestExponent + 0.5 * kExponentStep; p += kExponentStep)
      if (const double chi2 = (*this)(p); chi2 < least_) least_ = chi2, best_ = p;
    // Golden section between the neighbours of the least point of the grid.
    double low = best_ - kExponentStep, high = best_ + kExponentStep;
    while (high - low > kResolution) {
      const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
      if ((*this)(a) < (*this)(b)) {
        high = b;
      } else {
        low = a;
      }
    }
    best_ = 0.5 * (low + high), least_ = (*this)(best_);
  }

  double operator()(double p) {
    double chi2 = 0;
    for (TailFit& fit : fits_) chi2 += fit.Fit(p);
    return chi2;
  }
  double best() const { return best_; }
  double least() const { return least_; }

  /// Where chi-square has grown to `level`, going up (side 1) or down; NaN where it does not within the range.
  double FindBound(double level, double side) {
    double inside = best_, outside = best_ + side * kResolution;
    for (double step = kResolution; (*this)(outside) < level; step *= 2, outside += side * step) {
      if (outside < kLowestExponent || outside > kHighestExponent) return std::numeric_limits<double>::quiet_NaN();
      inside = outside;
    }
    while (std::abs(outside - inside) > 0.1 * kResolution) {
      const double middle = 0.5 * (inside + outside);
      ((*this)(middle) < level ? inside : outside) = middle;
    }
    return 0.5 * (inside + outside);
  }

 private:
  std::vector<TailFit> fits_;
  double best_ = kLowestExponent, least_ = kInfinity;
};

double MeanDecrement(std::span<const HalfSwing> swings, std::size_t first, std::size_t last) {
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) sum += swings[i].decrement;
  return sum / static_cast<double>(last - first);
}

}  // namespace

RollingTail FindRollingTail(const Swings& measured, const Swings& modelled) {
  const std::size_t n = std::min(measured.half.size(), modelled.half.size());
  for (std::size_t i = 0; i + kFewestTurns <= n + 2; ++i) {
    const double loss = MeanDecrement(measured.half, i, n), hidden = kHidden * measured.turns[i].error;
    if (modelled.half[i].decrement > std::max(kModelledShare * loss, hidden)) continue;
    return {{measured.turns.begin() + static_cast<std::ptrdiff_t>(i),
             measured.turns.begin() + static_cast<std::ptrdiff_t>(n + 2)},
            MeanDecrement(modelled.half, i, n)};
  }
  return {};
}

DecayExponent FitDecayExponent(std::span<const RollingTail> tails) {
  DecayExponent result;
  std::vector<TailFit> fits;
  double dof = -1, turns = 0;  // one exponent
  for (const RollingTail& tail : tails) {
    if (tail.turns.empty()) continue;
    fits.emplace_back(tail);
    const auto n = static_cast<double>(tail.turns.size());
    const double first = 0.5 * Span(tail.turns, 0), last = 0.5 * Span(tail.turns, tail.turns.size() - 2);
    result.from = std::max(result.from, first);
    result.to = result.to > 0 ? std::min(result.to, last) : last;
    result.largest_ratio = std::max(result.largest_ratio, first / last);
    result.loss += first - last;
    result.modelled_loss += tail.modelled_decrement * (n - 2);
    turns += n - 2;
    dof += n - 4;
  }
  if (fits.empty()) return result;
  result.loss /= turns, result.modelled_loss /= turns;

  double lossless = 0;
  for (TailFit fit : fits) lossless += fit.Fit(1, true);
  Profile profile(fits);
  const double least = profile.least(), scale = std::max(1.0, least / dof);
  const auto losses = static_cast<double>(fits.size());
  result.z = CalcNormalEquivalent(CalcLogChiSquareTail((lossless - least) / scale, losses + 1));
  result.p = profile.best();
  result.low = profile.FindBound(least + kChiSquareBound * scale, -1);
  result.high = profile.FindBound(least + kChiSquareBound * scale, 1);
  result.known =
      result.z > kSymptomThreshold && result.loss > 0 && std::isfinite(result.low) && std::isfinite(result.high);
  return result;
}

}  // namespace uiclink
