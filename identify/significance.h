#pragma once

namespace uiclink {

/// Logarithm of the probability that a chi-square variable of `dof` degrees of freedom exceeds x [-]; also where the
/// probability itself is below the smallest number (leading terms of the asymptotic series, relative error below 1 % of
/// the logarithm).
double CalcLogChiSquareTail(double x, double dof);

/// The |z| of a standard normal variable that is exceeded, on either side, with the probability exp(log_p) [-].
/// Tests of different kinds become comparable by it. log_p >= 0 gives 0.
double CalcNormalEquivalent(double log_p);

}  // namespace uiclink
