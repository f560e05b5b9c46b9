#include "identify/uncertainty.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace uiclink {
namespace {

constexpr double kWhitenessLevel = 1e-3;  // residuals count as structured below this p-value,
constexpr double kRmsLevel = 1.03;        // or from this rms in noise levels on: two deviations of an estimated noise
constexpr double kUnknown = 1.0;          // a standard deviation of a factor e: the value is not determined
constexpr int kNeighbours = 1;            // blocks (periods) over which scores may be correlated
constexpr double kAbsorbed = 3;           // blocks' worth of a direction's scores that the fit has made vanish

/// Share of the variance that is left in the sums over blocks of residuals that a fit has made small. At the minimum
/// the scores of every unknown sum to zero; the unknowns that turn the phase (k, sum k_i, t0) or change the amplitude
/// (T0, y0) see each other's as well, so some three blocks' worth of a direction is gone, and from neighbours as much
/// again.
double CalcShareLeft(Eigen::Index blocks) {
  const double size = static_cast<double>(blocks);
  double counted = 1;
  for (int lag = 1; lag <= kNeighbours; ++lag)
    counted += 2 * (1 - static_cast<double>(lag) / (kNeighbours + 1)) * std::max(0.0, 1 - lag / size);
  return std::max(0.3, 1 - kAbsorbed * counted / size);
}

/// Variance of the sum of scores over that of white noise, averaged over the determined directions.
double CalcScoreInflation(const Eigen::MatrixXd& projected, const Eigen::VectorXd& residuals,
                          const Eigen::MatrixXd& information, Eigen::Index block_size) {
  const Eigen::Index blocks = std::max<Eigen::Index>(1, projected.rows() / std::max<Eigen::Index>(1, block_size));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  const double largest = eigen.eigenvalues().maxCoeff();
  double sum = 0;
  int directions = 0;
  for (Eigen::Index d = 0; d < information.rows(); ++d) {
    if (eigen.eigenvalues()(d) < 1e-10 * largest) continue;
    const Eigen::VectorXd column = projected * eigen.eigenvectors().col(d);
    Eigen::VectorXd scores(blocks);
    for (Eigen::Index b = 0; b < blocks; ++b) {
      const Eigen::Index from = b * block_size;
      const Eigen::Index size = b + 1 == blocks ? projected.rows() - from : block_size;
      scores(b) = column.segment(from, size).dot(residuals.segment(from, size));
    }
    double variance = scores.squaredNorm();
    for (Eigen::Index lag = 1; lag <= std::min<Eigen::Index>(kNeighbours, blocks - 1); ++lag) {
      const double weight = 1 - static_cast<double>(lag) / (kNeighbours + 1);
      variance += 2 * weight * scores.head(blocks - lag).dot(scores.tail(blocks - lag));
    }
    sum += variance / eigen.eigenvalues()(d);
    ++directions;
  }
  return directions == 0 ? 1 : sum / (directions * CalcShareLeft(blocks));
}

}  // namespace

LinkInformation CalcInformation(const FitData& data, const Levels& levels, const Shape& shape, const Start& start,
                                double period) {
  const Linearisation at = Linearise(data, levels, shape, start);
  const Eigen::Index unknowns = at.jacobian.cols();
  const Eigen::Index link = unknowns - 3;
  const auto by_start = at.jacobian.rightCols(3);
  const auto by_link = at.jacobian.leftCols(link);
  const Eigen::MatrixXd absorbed = (by_start.transpose() * by_start).ldlt().solve(by_start.transpose() * by_link);
  const Eigen::MatrixXd projected = by_link - by_start * absorbed;

  LinkInformation result;
  result.information = projected.transpose() * projected;
  const auto n = static_cast<double>(data.size);
  const double reduced = at.residuals.squaredNorm() / std::max(1.0, n - static_cast<double>(unknowns));
  const std::span<const double> residuals(at.residuals.data(), data.size);
  result.rms = data.sigma * std::sqrt(at.residuals.squaredNorm() / n);
  result.whiteness = TestWhiteness(residuals);
  result.effective_size = n;
  result.variance_factor = reduced;
  result.structured = result.whiteness.p_value < kWhitenessLevel || result.rms > kRmsLevel * data.sigma;
  if (result.structured) {
    result.effective_size = CalcEffectiveSize(residuals);
    const auto block = static_cast<Eigen::Index>(std::lround(period * data.record->sampling_hz));
    result.variance_factor = std::max(reduced, CalcScoreInflation(projected, at.residuals, result.information, block));
  }
  return result;
}

Eigen::MatrixXd CalcCovariance(const Eigen::MatrixXd& information, double variance_factor) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  Eigen::VectorXd variances(information.rows());
  for (Eigen::Index i = 0; i < variances.size(); ++i) {
    const double value = eigen.eigenvalues()(i);
    const double variance = value > 0 ? variance_factor / value : kUndetermined * kUndetermined;
    variances(i) = std::min(variance, kUndetermined * kUndetermined);
  }
  return eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
}

double CalcLogStd(const Oscillator<double>& link, const Eigen::MatrixXd& covariance, int quantity) {
  const Eigen::RowVectorXd gradient = CalcLogGradient(link, quantity);
  return std::sqrt((gradient * covariance * gradient.transpose())(0, 0));
}

Eigen::MatrixXd CalcNaturalCovariance(const Oscillator<double>& link, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd d = CalcNaturalDerivatives(link);
  return d * covariance * d.transpose();
}

std::vector<std::string> NameUnidentifiable(const Oscillator<double>& link, const Eigen::MatrixXd& covariance,
                                            double limit) {
  const std::vector<std::string> symbols = ParameterSymbols(link.size());
  const auto size = static_cast<Eigen::Index>(symbols.size());
  Eigen::VectorXd scale(size);
  for (Eigen::Index i = 0; i < size; ++i) scale(i) = 1 / CalcQuantity(link, static_cast<int>(i));
  const Eigen::MatrixXd logs = scale.asDiagonal() * CalcNaturalCovariance(link, covariance) * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(logs);
  std::vector<std::string> names;
  for (Eigen::Index d = size - 1; d >= 0; --d) {
    if (eigen.eigenvalues()(d) < limit * limit) break;
    const Eigen::VectorXd direction = eigen.eigenvectors().col(d);
    Eigen::Index largest = 0;
    const double peak = direction.cwiseAbs().maxCoeff(&largest);
    std::string name;
    for (Eigen::Index i = 0; i < size; ++i) {
      if (std::abs(direction(i)) < 0.4 * peak) continue;  // small parts would only blur the sentence
      const bool minus = direction(i) * direction(largest) < 0;
      if (!name.empty()) name += minus ? " - " : " + ";
      if (name.empty() && minus) name += "-";
      name += symbols[static_cast<std::size_t>(i)];
    }
    names.push_back(name);
  }
  return names;
}

namespace {

/// Walks one side of a profile: everything but one quantity is refitted while that moves away from its best value.
/// Distances are in the logarithm of the quantity; heights are square roots of the rise of the sum of squares, which
/// grow nearly in proportion to the distance.
class ProfileSide {
 public:
  /// @param direction  how (levels, shape) move with the logarithm of the quantity, to first order.
  /// @param weight     with which the quantity is held where it is wanted.
  ProfileSide(std::span<const FitData> data, const FitOutcome& best, int quantity, Eigen::VectorXd direction,
              double threshold, double weight)
      : data_(data),
        best_(best),
        quantity_(quantity),
        direction_(std::move(direction)),
        threshold_(threshold),
        weight_(weight),
        goal_(std::sqrt(threshold)),
        log_best_(LogQuantity(best.state)) {}

  /// Logarithm of the bound; *open where the profile does not rise to the threshold within kFarthest.
  double Find(double first_step, bool* open, int* evaluations) {
    Point inside{.state = best_.state};
    std::optional<Point> outside;
    double distance = first_step;
    for (int i = 0; i < kMaxSteps && std::abs(distance) <= kFarthest; ++i) {
      Point point = Evaluate(distance, Predict(distance, inside, outside), evaluations);
      if (std::abs(point.height - goal_) < kGoalTolerance * goal_) return log_best_ + point.distance;
      (point.height > goal_ ? outside.emplace() : inside) = std::move(point);
      distance = outside ? Interpolate(inside, *outside) : Extrapolate(inside);
      if (outside && std::abs(outside->distance - inside.distance) < kGoalTolerance * std::abs(distance))
        return log_best_ + distance;
    }
    if (outside) return log_best_ + distance;
    *open = true;
    return log_best_ + inside.distance;
  }

 private:
  static constexpr double kFarthest = 7;  // a factor of a thousand either way
  static constexpr int kMaxSteps = 12;
  static constexpr double kGoalTolerance = 0.01;  // of the half width: far below the interval's own error

  struct Point {
    double distance = 0;
    double height = 0;
    FitState state;
  };

  double LogQuantity(const FitState& state) const {
    return std::log(CalcQuantity(ToOscillator(state.levels[0], state.shape, 1.0), quantity_));
  }

  /// Where the height reaches the goal, if it is straight between the two points; not too near to either of them.
  double Interpolate(const Point& inside, const Point& outside) const {
    const double share = (goal_ - inside.height) / (outside.height - inside.height);
    return inside.distance + std::clamp(share, 0.1, 0.9) * (outside.distance - inside.distance);
  }

  /// Where it reaches the goal, if it goes on straight; trusted no further than three times the way so far.
  double Extrapolate(const Point& inside) const {
    return inside.distance * std::min(3.0, inside.height > 0 ? goal_ / inside.height : 3.0);
  }

  /// Between known points of the profile the unknowns are nearly straight lines too.
  FitState Predict(double distance, const Point& inside, const std::optional<Point>& outside) const {
    if (outside) {
      const double share = (distance - inside.distance) / (outside->distance - inside.distance);
      return Mix(inside.state, outside->state, share);
    }
    if (inside.distance != 0) return Mix(best_.state, inside.state, distance / inside.distance);
    FitState state = best_.state;
    for (std::size_t j = 0; j < 3; ++j) state.levels[0][j] += distance * direction_(static_cast<Eigen::Index>(j));
    for (std::size_t j = 0; j < state.shape.size(); ++j)
      state.shape[j] += distance * direction_(static_cast<Eigen::Index>(3 + j));
    return state;
  }

  static FitState Mix(const FitState& from, const FitState& to, double share) {
    FitState mixed = from;
    for (std::size_t j = 0; j < 3; ++j) mixed.levels[0][j] += share * (to.levels[0][j] - from.levels[0][j]);
    for (std::size_t j = 0; j < mixed.shape.size(); ++j) mixed.shape[j] += share * (to.shape[j] - from.shape[j]);
    for (std::size_t r = 0; r < mixed.starts.size(); ++r)
      for (std::size_t j = 0; j < 3; ++j) mixed.starts[r][j] += share * (to.starts[r][j] - from.starts[r][j]);
    return mixed;
  }

  Point Evaluate(double distance, const FitState& from, int* evaluations) const {
    FitControl control;
    control.held = {quantity_, log_best_ + distance};
    control.held_weight = weight_;
    control.max_iterations = 30;
    control.function_tolerance = 0.1 * kGoalTolerance * threshold_ / best_.chi2;  // the last steps add up
    FitOutcome outcome = Fit(data_, Sharing::kLink, from, control);
    *evaluations += outcome.evaluations;
    return {.distance = LogQuantity(outcome.state) - log_best_,
            .height = std::sqrt(std::max(0.0, outcome.chi2 - best_.chi2)),
            .state = std::move(outcome.state)};
  }

  std::span<const FitData> data_;
  const FitOutcome& best_;
  int quantity_;
  Eigen::VectorXd direction_;
  double threshold_;
  double weight_;  ///< of holding the quantity
  double goal_;
  double log_best_;
};

}  // namespace

Estimate ProfileQuantity(std::span<const FitData> data, const FitOutcome& best, int quantity,
                         const Eigen::MatrixXd& covariance, double variance_factor, int* evaluations) {
  constexpr double kChiSquare95 = 3.841458820694124;  // 95 % quantile, one degree of freedom
  const double bound = std::sqrt(kChiSquare95);
  const Oscillator<double> link = ToOscillator(best.state.levels[0], best.state.shape, 1.0);
  const double log_std = CalcLogStd(link, covariance, quantity);
  Estimate estimate;
  estimate.value = CalcQuantity(link, quantity);
  estimate.std = estimate.value * log_std;
  if (log_std > kUnknown) {  // a walk would only find the limits of the fit
    estimate.low_open = estimate.high_open = true;
    estimate.low = estimate.value * std::exp(-bound * log_std);
    estimate.high = estimate.value * std::exp(bound * log_std);
    return estimate;
  }
  const Eigen::VectorXd direction =
      covariance * CalcLogGradient(link, quantity).transpose() / std::max(log_std * log_std, 1e-30);
  const double weight = 30 * std::sqrt(variance_factor) / std::max(log_std, 1e-8);
  ProfileSide side(data, best, quantity, direction, kChiSquare95 * variance_factor, weight);
  const double step = std::clamp(bound * log_std, 1e-8, 1.0);
  estimate.low = std::exp(side.Find(-step, &estimate.low_open, evaluations));
  estimate.high = std::exp(side.Find(step, &estimate.high_open, evaluations));
  return estimate;
}

}  // namespace uiclink
