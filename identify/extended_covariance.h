#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/extended_result.h"

namespace uiclink {

/// Covariance of the natural parameters of an extended fit: k, k1..kn, T01..T0n, then the parameters of the effects
/// that belong to the link ("rolling_friction.T_r"), in the order of the fit.
///
/// Correlations are those of the linear problem at the fit, everything else eliminated, and where records have links of
/// their own of the scatter between them; variances are the squares of the stated standard deviations, so that both
/// tell the same. A parameter without a finite value or standard deviation (a length that may be infinite) is left out.
struct ExtendedCovariance {
  std::vector<std::string> order;
  Eigen::MatrixXd matrix;
  /// Where records have links of their own: their values, a row per record (an effect's is the same in all of them),
  /// and what part of the covariance the means over them have in common, which is that of the effects' errors. Empty
  /// where they share the link.
  Eigen::MatrixXd by_record, common;
};
ExtendedCovariance CalcExtendedCovariance(std::span<const FitData> data, const ExtendedResult& result);

}  // namespace uiclink
