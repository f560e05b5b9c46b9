#pragma once

#include <span>
#include <vector>

namespace uiclink {

/// Probability that a chi-square variable of `dof` degrees of freedom exceeds x [-].
double CalcChiSquareTail(double x, double dof);

/// The value that a Student variable of `dof` degrees of freedom exceeds with probability (1 - confidence)/2 [-];
/// dof = infinity gives the normal one.
double CalcStudentBound(double confidence, double dof);

/// Autocorrelation of residuals, as a portmanteau test of whiteness (Ljung and Box 1978): sum over the first lags.
struct Whiteness {
  double statistic = 0;  ///< n (n+2) sum rho_l^2/(n-l)
  int lags = 0;
  double p_value = 1;  ///< small: the residuals have structure
};
Whiteness TestWhiteness(std::span<const double> residuals);

/// Number of independent observations in n correlated ones: n / (1 + 2 sum rho_l), summed until the correlation first
/// vanishes. Between 1 and n.
double CalcEffectiveSize(std::span<const double> residuals);

/// Mean of a population of which each member was measured with its own error (random effects).
struct Population {
  double mean = 0;
  double std = 0;         ///< standard deviation of the mean
  double spread = 0;      ///< standard deviation between members, without the measurement errors
  double half_width = 0;  ///< half of the 95 % interval of the mean (Student, n - 1 degrees of freedom)
};

/// Between-member variance by Paule and Mandel (1982): the weighted sum of squares equals its expectation n - 1;
/// interval of the mean by Hartung and Knapp (2001). One value: its own error and nothing about a spread.
Population EstimatePopulation(std::span<const double> values, std::span<const double> errors);

}  // namespace uiclink
