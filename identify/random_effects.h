#pragma once

#include <Eigen/Core>
#include <vector>

namespace uiclink {

/// Mean of vectors of which each was measured with its own, correlated errors, while the members of the population
/// differ (random effects):
///   value_r = mean + scatter_r + error_r,   error_r ~ N(0, C_r),   scatter_r ~ N(0, sum_g s_g^2 S_g).
/// It is the several-dimensional counterpart of Population: what a member hardly determines is learned from all.
struct VectorPopulation {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;        ///< of the mean
  Eigen::MatrixXd error_covariance;  ///< the part of it that the errors C_r alone would give
  Eigen::VectorXd spread;            ///< s_g
};

/// Weighted mean with variances s_g^2 by restricted maximum likelihood (expectation maximisation; Laird and Ware 1982).
/// @param values      one vector per member; two members at least.
/// @param errors      their covariances C_r, positive definite.
/// @param structures  S_g, symmetric positive semidefinite, on subspaces that do not overlap.
VectorPopulation EstimateVectorPopulation(const std::vector<Eigen::VectorXd>& values,
                                          const std::vector<Eigen::MatrixXd>& errors,
                                          const std::vector<Eigen::MatrixXd>& structures);

}  // namespace uiclink
