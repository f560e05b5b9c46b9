#include "identify/cause_cost.h"

#include <algorithm>
#include <array>

#include "identify/statistics.h"
#include "identify/validate.h"

namespace uiclink {
namespace {

/// dV/dp by symbol; zero for what the speed does not know.
Eigen::VectorXd GradientOf(const ValidationRow& row, Direction direction, const std::vector<std::string>& order) {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(order.size()));
  for (const SpeedSensitivity& s : row.critical_speed->sensitivities) {
    const auto place = std::ranges::find(order, s.symbol);
    if (s.direction == direction && place != order.end()) gradient[place - order.begin()] = s.derivative;
  }
  return gradient;
}

double Square(double x) { return x * x; }

/// What the records of one direction add to the square of half the interval.
double CalcPairedSquare(const RecordValues& plain, const Eigen::VectorXd& by_plain, const RecordValues& extended,
                        const Eigen::VectorXd& by_extended) {
  Eigen::VectorXd differences = plain.by_record * by_plain - extended.by_record * by_extended;
  const auto n = static_cast<double>(differences.size());
  differences.array() -= differences.mean();
  const double variance = differences.squaredNorm() / (n * (n - 1));
  const double common = std::max(0.0, by_extended.dot(extended.common * by_extended));
  return Square(CalcStudentBound(0.95, n - 1)) * variance + Square(kNormalCoverage) * common;
}

/// The same for a direction that both sets have in common.
double CalcCommonSquare(const Covariance& covariance, const Eigen::VectorXd& gradient) {
  double variance = 0;
  for (Eigen::Index i = 0; i < gradient.size(); ++i)
    for (Eigen::Index j = 0; j < gradient.size(); ++j)
      variance +=
          gradient[i] * gradient[j] * covariance.matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return Square(covariance.coverage.value_or(kNormalCoverage)) * std::max(0.0, variance);
}

/// None where records cannot be paired.
std::optional<double> CalcPairedHalf(const ValidationRow& plain, const ValidationRow& extended) {
  double square = 0;
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
    const auto d = static_cast<std::size_t>(direction);
    const std::optional<DirectionParameters>&a = plain.set.set[direction], &b = extended.set.set[direction];
    const std::optional<RecordValues>&of_a = plain.set.by_record[d], &of_b = extended.set.by_record[d];
    if (!(a && a->covariance) && !(b && b->covariance)) continue;
    if (of_a && of_b && of_a->by_record.rows() == of_b->by_record.rows() && of_a->by_record.rows() > 1) {
      square += CalcPairedSquare(*of_a, GradientOf(plain, direction, of_a->order), *of_b,
                                 GradientOf(extended, direction, of_b->order));
    } else if (a && b && a->covariance && b->covariance && a->covariance->order == b->covariance->order &&
               a->covariance->matrix == b->covariance->matrix) {
      const std::vector<std::string>& order = a->covariance->order;
      square += CalcCommonSquare(*a->covariance,
                                 GradientOf(plain, direction, order) - GradientOf(extended, direction, order));
    } else {
      return std::nullopt;
    }
  }
  return std::sqrt(square);
}

std::optional<double> HalfOf(const CriticalSpeed& speed) {
  return speed.high ? std::optional(*speed.high - *speed.value) : std::nullopt;
}

}  // namespace

std::optional<CauseCost> CalcSpeedCost(const ValidationRow& plain, const ValidationRow& extended) {
  const std::optional<CriticalSpeed>&a = plain.critical_speed, &b = extended.critical_speed;
  if (!a || !b || !a->high || !b->high) return std::nullopt;
  return CauseCost{.name = "linear critical speed",
                   .unit = "m/s",
                   .plain = *a->value,
                   .extended = *b->value,
                   .plain_half = *HalfOf(*a),
                   .extended_half = *HalfOf(*b),
                   .paired_half = CalcPairedHalf(plain, extended)};
}

std::vector<SpeedDifference> CalcSpeedDifferences(const std::vector<ValidationRow>& rows) {
  std::vector<SpeedDifference> differences;
  const auto known = [](const ValidationRow& row) { return row.critical_speed && row.critical_speed->value; };
  if (rows.empty() || !known(rows.front())) return differences;
  const CriticalSpeed& first = *rows.front().critical_speed;
  const std::optional<double> of_first = HalfOf(first);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (!known(rows[i])) continue;
    const CriticalSpeed& speed = *rows[i].critical_speed;
    const std::optional<double> half = HalfOf(speed);
    SpeedDifference difference{
        .row = i, .difference = *speed.value - *first.value, .half = {}, .half_if_correlated = {}};
    if (half || of_first) difference.half = std::hypot(half.value_or(0), of_first.value_or(0));
    if (half && of_first) difference.half_if_correlated = std::abs(*half - *of_first);
    differences.push_back(difference);
  }
  return differences;
}

}  // namespace uiclink
