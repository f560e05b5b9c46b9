#include "vehicle/contact/kalker_coefficients.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;

struct Node {
  double ratio, nu, c11, c22, c23;
};

// All 171 values are compared in tests/validation/contact_mechanics_test.cpp; here corners, the middle, and the two
// nodes that other listings misprint.
constexpr Node kNodes[] = {
    {0.1, 0, 2.51, 2.51, 0.334},      {0.1, 0.5, 4.85, 2.53, 0.731},     {0.8, 0.25, 3.91, 3.41, 1.25},
    {1, 0, 3.40, 3.40, 1.33},         {1, 0.25, 4.12, 3.67, 1.47},       {1, 0.5, 5.20, 3.98, 1.63},
    {1 / 0.4, 0.5, 6.57, 6.31, 3.70}, {1 / 0.1, 0.25, 11.7, 12.8, 14.6}, {1 / 0.1, 0.5, 12.9, 16.0, 18.0},
};

TEST(KalkerCoefficients, AreTheTableAtItsNodes) {
  for (const Node& node : kNodes) {
    const KalkerCoefficients c = CalcKalkerCoefficients(node.ratio, node.nu);
    // Rounding of two interpolations.
    EXPECT_NEAR(c.c11, node.c11, 1e-13 * node.c11) << node.ratio << ", " << node.nu;
    EXPECT_NEAR(c.c22, node.c22, 1e-13 * node.c22) << node.ratio << ", " << node.nu;
    EXPECT_NEAR(c.c23, node.c23, 1e-13 * node.c23) << node.ratio << ", " << node.nu;
  }
}

TEST(KalkerCoefficients, InterpolateLinearlyInTheSmallerRatio) {
  // nu = 0, between 0.3 and 0.4: g = a/b = 0.36, and g = b/a = 0.36.
  EXPECT_NEAR(CalcKalkerCoefficients(0.36, 0).c11, 0.4 * 2.68 + 0.6 * 2.78, 1e-13);
  EXPECT_NEAR(CalcKalkerCoefficients(1 / 0.36, 0).c23, 0.4 * 3.79 + 0.6 * 2.88, 1e-13);
}

TEST(KalkerCoefficients, InterpolateTheReciprocalsOverPoissonsRatio) {
  // A parabola through 1/3.40, 1/4.12, 1/5.20 at nu = 0, 1/4, 1/2; weights of Lagrange at 0.27.
  const double expected = 1 / (-0.0368 / 3.40 + 0.9936 / 4.12 + 0.0432 / 5.20);
  EXPECT_NEAR(CalcKalkerCoefficients(1, 0.27).c11, expected, 1e-12);
}

/// Greatest relative step of a coefficient from one ratio to a neighbour.
double CalcStep(const KalkerCoefficients& a, const KalkerCoefficients& b) {
  return std::max({std::abs(a.c11 / b.c11 - 1), std::abs(a.c22 / b.c22 - 1), std::abs(a.c23 / b.c23 - 1)});
}

TEST(KalkerCoefficients, AreContinuousOverEighteenDecades) {
  for (const double nu : {0.0, 0.1, 0.25, 0.27, 0.4, 0.5}) {
    // Steepest: c23 at nu = 1/2, linear from 7.89 to 18.0 between g = 0.2 and 0.1: at 0.2 a step of 0.001 in ln(g) is
    // one of 0.001 (18.0 - 7.89)/0.1 0.2/7.89 = 0.00256. A jump by a digit of the table would be 0.003 or more.
    KalkerCoefficients before = CalcKalkerCoefficients(1e-9, nu);
    for (double x = std::log(1e-9) + 1e-3; x < std::log(1e9); x += 1e-3) {
      const KalkerCoefficients here = CalcKalkerCoefficients(std::exp(x), nu);
      ASSERT_LT(CalcStep(here, before), 2.6e-3) << "a/b = " << std::exp(x) << ", nu = " << nu;
      before = here;
    }
    for (const double edge : {0.1, 1.0, 10.0}) {
      const KalkerCoefficients below = CalcKalkerCoefficients(edge * (1 - 1e-12), nu);
      const KalkerCoefficients above = CalcKalkerCoefficients(edge * (1 + 1e-12), nu);
      EXPECT_LT(CalcStep(below, above), 1e-11) << "a/b = " << edge << ", nu = " << nu;
    }
  }
}

TEST(KalkerCoefficients, TendToTheirAsymptotes) {
  const double nu = 0.27;
  const double g = 1e-9;  // the correction is the share g/0.1 of less than a half
  const KalkerCoefficients across = CalcKalkerCoefficients(g, nu);
  EXPECT_NEAR(across.c11, kPi * kPi / 4 / (1 - nu), 1e-7);
  EXPECT_NEAR(across.c22, kPi * kPi / 4, 1e-7);
  const KalkerCoefficients along = CalcKalkerCoefficients(1 / g, nu);
  const double L = std::log(16 / (g * g));
  EXPECT_NEAR(along.c23 * 3 * std::pow(g, 1.5) * ((1 - nu) * L - 2 + 4 * nu) / (2 * kPi), 1, 1e-7);
}

TEST(KalkerCoefficients, RejectWhatIsNoRatio) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double ratio : {0.0, -1.0, nan, infinity})
    EXPECT_THROW(CalcKalkerCoefficients(ratio, 0.27), std::invalid_argument) << ratio;
  for (const double nu : {-0.1, 0.51, nan}) EXPECT_THROW(CalcKalkerCoefficients(1, nu), std::invalid_argument) << nu;
}

}  // namespace
}  // namespace uiclink
