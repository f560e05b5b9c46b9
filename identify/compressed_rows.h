#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace uiclink {

/// Many residuals as p + 1.  A Gauss-Newton step sees residuals r and their derivatives J (N x p) only through J'J,
/// J'r and r'r, so the N rows can be replaced by rows that have the same products:
///   R'R = J'J,  R'z = J'r,  z'z + s^2 = r'r,   R p x p,  z of length p,  s scalar without derivatives.
/// Whoever minimises then works on a dozen rows instead of thousands, at every step.
template <int p>
struct CompressedRows {
  Eigen::Matrix<double, p, p> jacobian = Eigen::Matrix<double, p, p>::Zero();   ///< R
  Eigen::Matrix<double, p, 1> residuals = Eigen::Matrix<double, p, 1>::Zero();  ///< z
  double rest = 0;                                                              ///< s, >= 0
};

/// Compresses rows of which the products are known.  Combinations of unknowns that the products determine only to
/// their rounding get rows of zeros: as any solution of normal equations, this one has half the digits of J.
/// @param gram  [J r]'[J r]; the lower triangle is read.
template <int p>
CompressedRows<p> Compress(const Eigen::Matrix<double, p + 1, p + 1>& gram) {
  constexpr double kRounding = 1e-13;  // of a sum of 1e5 products, and its way through the factors
  using Square = Eigen::Matrix<double, p, p>;
  const Square normal = gram.template topLeftCorner<p, p>();
  const Eigen::Matrix<double, p, 1> gradient = gram.template bottomLeftCorner<1, p>().transpose();
  const Eigen::LDLT<Square, Eigen::Lower> factors(normal);  // normal = P' L D L' P
  CompressedRows<p> rows;
  rows.jacobian = factors.transpositionsP() * Square::Identity();
  rows.jacobian = factors.matrixU() * rows.jacobian;
  rows.residuals = factors.matrixL().solve(factors.transpositionsP() * gradient);
  const Eigen::Matrix<double, p, 1> sizes = factors.transpositionsP() * Eigen::Matrix<double, p, 1>(normal.diagonal());
  for (int i = 0; i < p; ++i) {
    const double pivot = factors.vectorD()(i);
    const bool determined = pivot > kRounding * sizes(i);
    const double root = determined ? std::sqrt(pivot) : 0;
    rows.jacobian.row(i) *= root;
    rows.residuals(i) = determined ? rows.residuals(i) / root : 0;
  }
  rows.rest = std::sqrt(std::max(0.0, gram(p, p) - rows.residuals.squaredNorm()));
  return rows;
}

}  // namespace uiclink
