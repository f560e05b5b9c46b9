#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace uiclink {

struct ValidationRow;

/// What each record by itself says of the parameters of one direction, where records do not share their link.
struct RecordValues {
  std::vector<std::string> order;  ///< symbols, as in the covariance
  Eigen::MatrixXd by_record;       ///< a row per record, a column per symbol; the set has the means over them
  /// Covariance of what all records have in common: the errors of effects that they share. Zero for the plain model.
  Eigen::MatrixXd common;
};

/// What it costs not to have named the missing effects: a scalar of the wagon on the plain model's set less the same on
/// the extended one's.
struct CauseCost {
  std::string name;  ///< "linear critical speed", "front lateral amplitude", "front lateral frequency"
  std::string unit;
  double plain = 0, extended = 0;
  double plain_half = 0, extended_half = 0;  ///< of their 95 % intervals
  std::optional<double> paired_half = {};    ///< of the difference, from its records (CalcSpeedCost)

  double difference() const { return plain - extended; }
  /// Half of the 95 % interval of the difference: from the records where these can be paired. Elsewhere independent(),
  /// an upper bound: both models are fitted to the same records, whose scatter they share.
  double half() const { return paired_half.value_or(independent()); }
  double independent() const { return std::hypot(plain_half, extended_half); }
  /// The narrowest that it can be, with errors that are wholly correlated.
  double narrowest_half() const { return std::abs(plain_half - extended_half); }
};

/// The cost in linear critical speed; none where one of the two is not known with its bounds.
///
/// Both models are fitted to the same records, so that the error of the difference is the scatter of each record's own
/// one. To first order, with the gradients g of the two speeds and the records' own parameters p_r, e_r:
///   d_r = g_plain p_r - g_extended e_r,   half^2 = (t s/sqrt(n))^2 + (1.96 c)^2,
/// s the standard deviation of the n values d_r, t Student's bound for n - 1, c^2 = g_extended' C g_extended of what
/// the records have in common. A direction that is the same in both sets counts with the difference of the gradients.
/// paired_half is left out where a direction's records share one link.
std::optional<CauseCost> CalcSpeedCost(const ValidationRow& plain, const ValidationRow& extended);

/// A set's linear critical speed less the first one's.
struct SpeedDifference {
  std::size_t row = 0;    ///< of Validation::rows
  double difference = 0;  ///< [m/s]
  /// Half of the 95 % interval [m/s], as for independent errors; none where neither has bounds. A set without
  /// covariance counts as exact.
  std::optional<double> half;
  /// The same for errors that are wholly correlated, which those of two models of the same records are nearly; none
  /// unless both have bounds.
  std::optional<double> half_if_correlated;
};

/// Every set that has a critical speed against the first one; empty where the first has none.
std::vector<SpeedDifference> CalcSpeedDifferences(const std::vector<ValidationRow>& rows);

}  // namespace uiclink
