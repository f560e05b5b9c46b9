#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/extended_result.h"

namespace uiclink {

/// Covariance of the natural parameters of an extended fit: k, k1..kn, T01..T0n, then the parameters of the effects
/// that belong to the link ("rolling_friction.T_r"), in the order of the fit.
///
/// Correlations are those of the linear problem at the fit, everything else eliminated; variances are the squares of
/// the stated standard deviations, so that both tell the same. A parameter without a finite value or standard deviation
/// (a length that may be infinite) is left out.
struct ExtendedCovariance {
  std::vector<std::string> order;
  Eigen::MatrixXd matrix;
};
ExtendedCovariance CalcExtendedCovariance(std::span<const FitData> data, const ExtendedResult& result);

}  // namespace uiclink
