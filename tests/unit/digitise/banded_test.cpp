#include "identify/digitise/banded.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "identify/digitise/spline.h"

namespace uiclink::digitise {
namespace {

/// Two diagonals beside the main one: diagonally dominant, so positive definite.
double Element(std::size_t i, std::size_t j) {
  const std::size_t apart = i > j ? i - j : j - i;
  return apart == 0 ? 4.0 + 0.1 * double(i) : apart == 1 ? -1.0 : apart == 2 ? 0.5 : 0.0;
}

BandedEquations Make(std::size_t size) {
  BandedEquations equations(size, 2);
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = i >= 2 ? i - 2 : 0; j <= i; ++j) equations.Add(i, j, Element(i, j));
  return equations;
}

TEST(BandedEquations, SolutionGivesTheRightSideBack) {
  BandedEquations equations = Make(30);
  for (std::size_t i = 0; i < 30; ++i) equations.AddRight(i, std::sin(double(i)));
  ASSERT_TRUE(equations.Factor());
  const std::vector<double> x = equations.Solve();
  for (std::size_t i = 0; i < 30; ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < 30; ++j) sum += Element(i, j) * x[j];
    EXPECT_NEAR(sum, std::sin(double(i)), 1e-14);  // rounding of 30 terms of size 1
  }
}

TEST(BandedEquations, InverseInBandIsThatOfUnitRightSides) {
  BandedEquations factored = Make(12);
  ASSERT_TRUE(factored.Factor());
  const std::vector<double> inverse = factored.InverseInBand();
  for (std::size_t j = 0; j < 12; ++j) {
    BandedEquations unit = Make(12);
    unit.AddRight(j, 1);
    ASSERT_TRUE(unit.Factor());
    const std::vector<double> column = unit.Solve();
    for (std::size_t i = j; i < std::min<std::size_t>(12, j + 3); ++i)
      EXPECT_NEAR(inverse[i * 3 + (i - j)], column[i], 1e-14) << i << ' ' << j;
  }
}

TEST(BandedEquations, RefusesWhatIsNotPositiveDefinite) {
  BandedEquations equations(2, 1);
  equations.Add(0, 0, 1);
  equations.Add(1, 0, 2);
  equations.Add(1, 1, 1);
  EXPECT_FALSE(equations.Factor());
}

TEST(UniformSpline, BasisSumsToOneAndSlopesAreDerivatives) {
  UniformSpline spline(3, 20, 2.5);
  for (std::size_t i = 0; i < spline.coefficients.size(); ++i) spline.coefficients[i] = std::cos(double(i));
  for (double x = 3.01; x < 19.9; x += 0.37) {
    const UniformSpline::Basis basis = spline.At(x);
    EXPECT_NEAR(basis.value[0] + basis.value[1] + basis.value[2] + basis.value[3], 1, 1e-14);
    const double h = 1e-5;  // central difference: h^2 y'''/6 = 2e-11, rounding 1e-16/h = 1e-11
    EXPECT_NEAR(spline.Slope(basis), (spline(x + h) - spline(x - h)) / (2 * h), 1e-9);
  }
}

}  // namespace
}  // namespace uiclink::digitise
