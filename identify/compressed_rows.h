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
/// p is a number or Eigen::Dynamic.
template <int p>
struct CompressedRows {
  Eigen::Matrix<double, p, p> jacobian;   ///< R
  Eigen::Matrix<double, p, 1> residuals;  ///< z
  double rest = 0;                        ///< s, >= 0
};

/// p + 1, which Eigen::Dynamic does not know how to count.
template <int p>
inline constexpr int kRowsOf = p == Eigen::Dynamic ? Eigen::Dynamic : p + 1;

/// Compresses rows of which the products are known.  Combinations of unknowns that the products determine only to
/// their rounding get rows of zeros: as any solution of normal equations, this one has half the digits of J.
/// @param gram  [J r]'[J r]; the lower triangle is read.
template <int p>
CompressedRows<p> Compress(const Eigen::Matrix<double, kRowsOf<p>, kRowsOf<p>>& gram) {
  constexpr double kRounding = 1e-13;  // of a sum of 1e5 products, and its way through the factors
  using Square = Eigen::Matrix<double, p, p>;
  const Eigen::Index size = gram.rows() - 1;
  const Square normal = gram.topLeftCorner(size, size);
  const Eigen::Matrix<double, p, 1> gradient = gram.bottomLeftCorner(1, size).transpose();
  const Eigen::LDLT<Square, Eigen::Lower> factors(normal);  // normal = P' L D L' P
  CompressedRows<p> rows;
  rows.jacobian = factors.transpositionsP() * Square::Identity(size, size);
  rows.jacobian = factors.matrixU() * rows.jacobian;
  rows.residuals = factors.matrixL().solve(factors.transpositionsP() * gradient);
  const Eigen::Matrix<double, p, 1> sizes = factors.transpositionsP() * Eigen::Matrix<double, p, 1>(normal.diagonal());
  for (Eigen::Index i = 0; i < size; ++i) {
    const double pivot = factors.vectorD()(i);
    const bool determined = pivot > kRounding * sizes(i);
    const double root = determined ? std::sqrt(pivot) : 0;
    rows.jacobian.row(i) *= root;
    rows.residuals(i) = determined ? rows.residuals(i) / root : 0;
  }
  rows.rest = std::sqrt(std::max(0.0, gram(size, size) - rows.residuals.squaredNorm()));
  return rows;
}

}  // namespace uiclink
