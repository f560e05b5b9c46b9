#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "identify/fit_problem.h"
#include "identify/statistics.h"

namespace uiclink {

/// A value with its uncertainty.
struct Estimate {
  double value = 0;
  double std = 0;
  double low = 0;  ///< 95 % bounds
  double high = 0;
  bool low_open = false;  ///< the data give no bound on this side within the limits of the fit; `low` is that limit
  bool high_open = false;
  double spread = 0;  ///< standard deviation between records, where they do not share the value; otherwise 0
};

/// What one record says about the link at a fit, the start of the record eliminated. Coordinates: (levels, shape).
struct LinkInformation {
  Eigen::MatrixXd information;  ///< J'J in units of the noise
  double variance_factor = 1;   ///< by how much variances exceed those of white noise of the stated sigma
  Whiteness whiteness;
  bool structured = false;    ///< the residuals are not the noise that the readings have
  double rms = 0;             ///< of the residuals [m]
  double effective_size = 0;  ///< independent observations among the residuals
};

/// Variances are inflated where the residuals have structure, because then samples are not independent: the scores J'r
/// are summed over whole periods, and the variance of these sums, with the correlation of neighbouring ones (Newey and
/// West 1987), replaces that of white noise. White residuals keep the variance of their rms.
/// @param period  [s], length of the blocks.
LinkInformation CalcInformation(const FitData& data, const Levels& levels, const Shape& shape, const Start& start,
                                double period);

/// Covariance of (levels, shape) from the sum of the records' information: the inverse, with directions that the data
/// do not determine given the variance kUndetermined^2 instead of an infinite one. Never fails for a rank-deficient
/// matrix.
inline constexpr double kUndetermined = 3.0;  ///< standard deviation of a logarithm: a factor of 20
Eigen::MatrixXd CalcCovariance(const Eigen::MatrixXd& information, double variance_factor);

/// Standard deviation of the logarithm of a quantity (CountQuantities) for a covariance of (levels, shape).
double CalcLogStd(const Oscillator<double>& link, const Eigen::MatrixXd& covariance, int quantity);

/// Covariance of the natural parameters (k, k1..kn, T01..T0n) for a covariance of (levels, shape).
Eigen::MatrixXd CalcNaturalCovariance(const Oscillator<double>& link, const Eigen::MatrixXd& covariance);

/// Combinations of parameters that the data do not determine, in words: directions (in logarithms) with a standard
/// deviation above `limit`, as "k3 - k4 + T03".
std::vector<std::string> NameUnidentifiable(const Oscillator<double>& link, const Eigen::MatrixXd& covariance,
                                            double limit = 0.5);

/// 95 % bounds of a quantity from its likelihood profile: everything else is refitted on the way; steps adapt until the
/// sum of squares has risen by 3.84 variance factors, on both sides. A side on which it does not rise so far within the
/// limits of the fit is open, and named so.
/// @param best        fit of one link to all of `data`.
/// @param covariance  of (levels, shape): the first guess of the width and of how everything else moves.
Estimate ProfileQuantity(std::span<const FitData> data, const FitOutcome& best, int quantity,
                         const Eigen::MatrixXd& covariance, double variance_factor, int* evaluations);

}  // namespace uiclink
