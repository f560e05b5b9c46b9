#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "vehicle/hunting/set_scatter.h"

namespace uiclink {

/// What part of a variance comes from where.
struct VarianceShare {
  std::string name;
  double share = 0;  ///< of the variance [-]
};

/// Where the variance of a scalar f of the draws comes from, for the linear part  sum_j b_j x_j  of it:
///   share_j = Cov(f, b_j x_j) / Var(f),      not_linear = 1 - sum_j share_j.
/// They add up to 1 whatever is correlated, and what has no influence (b_j = 0) has no share, however it is bound to
/// what has: T0 never has one in the linear critical speed. Parameters that a fit has bound together can have shares
/// far above 1 and below 0 (k and k1 with a correlation of -0.99: +450 %, -350 %): each by itself would scatter the
/// speed so much, and the other takes it back. In groups (k + sum k_i together) that is gone.
/// Shapley effects (Owen and Prieur 2017) are never negative, but give T0 40 % of the scatter of a linear critical
/// speed where it is correlated with k + sum k_i: they tell what may be learned from a parameter, not what it does.
struct VarianceShares {
  std::vector<VarianceShare> parameters;  ///< each by itself; corner scatter in its groups
  std::vector<VarianceShare> groups;      ///< UncertainParameter::group, in the order of the parameters
  double not_linear = 0;
};

/// @param f     a value per draw; draws where it is not finite are left out.
/// @param b     derivatives of f by the parameters of the scatter.
/// @param keep  factor on the shares: below 1 where b was fitted to the same draws, which chance makes too good.
VarianceShares CalcVarianceShares(const SetScatter& scatter, std::span<const double> f, const Eigen::VectorXd& b,
                                  double keep = 1);
/// To first order, from the covariance alone: share_j = b_j (C b)_j / b' C b. Empty where nothing varies.
VarianceShares CalcVarianceShares(const SetScatter& scatter, const Eigen::VectorXd& b);

/// Share of the variance of f = b' x that the one number  a' x  explains: the square of their correlation.
double CalcExplainedBy(const Eigen::MatrixXd& C, const Eigen::VectorXd& b, const Eigen::VectorXd& a);

}  // namespace uiclink
