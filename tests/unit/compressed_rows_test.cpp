#include "identify/compressed_rows.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>

namespace uiclink {
namespace {

constexpr int kUnknowns = 6;
constexpr int kSamples = 500;
using Columns = Eigen::Matrix<double, kSamples, kUnknowns + 1>;  // [J r]
using Gram = Eigen::Matrix<double, kUnknowns + 1, kUnknowns + 1>;

Columns MakeColumns(unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Columns columns;
  for (double& value : columns.reshaped()) value = normal(random);
  return columns;
}

Gram Multiply(const Columns& columns) { return columns.transpose() * columns; }

/// The same products from the compressed rows.
Gram Multiply(const CompressedRows<kUnknowns>& rows) {
  Gram matrix = Gram::Zero();
  matrix.topLeftCorner<kUnknowns, kUnknowns>() = rows.jacobian;
  matrix.topRightCorner<kUnknowns, 1>() = rows.residuals;
  matrix(kUnknowns, kUnknowns) = rows.rest;
  return matrix.transpose() * matrix;
}

TEST(CompressedRows, HaveTheSameProducts) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Gram all = Multiply(MakeColumns(seed));
    // Rounding of sums of 7 products of size 500.
    EXPECT_LT((Multiply(Compress<kUnknowns>(all)) - all).cwiseAbs().maxCoeff(), 1e-11) << "seed " << seed;
  }
}

TEST(CompressedRows, ReadTheLowerTriangleOnly) {
  const Gram all = Multiply(MakeColumns(1));
  Gram lower = all.triangularView<Eigen::Lower>();
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_LT((Multiply(Compress<kUnknowns>(lower)) - all).cwiseAbs().maxCoeff(), 1e-11);
}

TEST(CompressedRows, KeepTheirDigitsWhateverTheUnitsOfTheUnknowns) {
  Columns columns = MakeColumns(2);
  for (int i = 0; i < kUnknowns; ++i) columns.col(i) *= std::pow(10.0, 3 * (i % 3) - 4);
  const Gram all = Multiply(columns);
  const Eigen::Matrix<double, kUnknowns + 1, 1> scale = all.diagonal().cwiseSqrt();
  const Gram relative = (Multiply(Compress<kUnknowns>(all)) - all).cwiseQuotient(scale * scale.transpose());
  EXPECT_LT(relative.cwiseAbs().maxCoeff(), 1e-13);  // rounding of a dozen products of size 1
}

TEST(CompressedRows, StayFiniteWhereUnknownsCannotBeToldApart) {
  Columns columns = MakeColumns(3);
  columns.col(3) = columns.col(1) - 2 * columns.col(4);
  columns.col(5).setZero();
  const Gram all = Multiply(columns);
  const CompressedRows<kUnknowns> rows = Compress<kUnknowns>(all);
  EXPECT_TRUE(rows.jacobian.allFinite() && rows.residuals.allFinite() && std::isfinite(rows.rest));
  // A row that is left out is as small as the rounding of a product of size 2500.
  EXPECT_LT((Multiply(rows) - all).cwiseAbs().maxCoeff(), 1e-10);
  int left_out = 0;
  for (int i = 0; i < kUnknowns; ++i) left_out += rows.jacobian.row(i).isZero(0) ? 1 : 0;
  EXPECT_EQ(left_out, 2);
}

TEST(CompressedRows, OfAPerfectFitHaveNoRest) {
  Columns columns = MakeColumns(4);
  columns.col(kUnknowns) = columns.col(0) - columns.col(2);
  const CompressedRows<kUnknowns> rows = Compress<kUnknowns>(Multiply(columns));
  EXPECT_LT(rows.rest, 1e-5);  // the root of the rounding of r'r, 1000
}

}  // namespace
}  // namespace uiclink
