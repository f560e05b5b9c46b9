#include "dynamics/lyapunov.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/chaotic_flows.h"

namespace uiclink {
namespace {

using Eigen::VectorXd;

class Lyapunov : public testing::TestWithParam<DeviationMethod> {
 protected:
  LyapunovOptions Options(double interval, int intervals) const {
    return {.method = GetParam(), .interval = interval, .intervals = intervals, .discarded = intervals / 10};
  }
};

/// Within four of its own standard errors: one run in 16 000 would be further off by chance.
void ExpectKnown(const LyapunovResult& result, double known, double largest_error) {
  EXPECT_NEAR(result.exponent, known, 4 * result.error);
  EXPECT_LT(result.error, largest_error);
  EXPECT_GT(result.error, 0);
}

TEST_P(Lyapunov, OfLorenzIsThePublishedOne) {
  ExpectKnown(FindLargestExponent(*MakeLorenz(), VectorXd{{1, 1, 20}}, 28, Options(0.5, 4000)), 0.9056, 0.01);
}

TEST_P(Lyapunov, OfRoesslerIsThePublishedOne) {
  ExpectKnown(FindLargestExponent(*MakeRoessler(), VectorXd{{1, 1, 0}}, 5.7, Options(6, 8000)), 0.0714, 0.001);
}

TEST_P(Lyapunov, IsZeroOnACycle) {
  const LyapunovResult result = FindLargestExponent(*MakeSmoothVanDerPol(), VectorXd{{2, 0}}, 1, Options(1, 2000));
  // What is left is the phase in the cycle at both ends: log of the ratio of speeds (under 2) over 2000 s.
  EXPECT_NEAR(result.exponent, 0, 5e-4);
  EXPECT_EQ(result.duration, 2000);
  EXPECT_EQ(result.intervals, 2000);
}

TEST_P(Lyapunov, OfADampedOscillatorIsMinusItsDamping) {
  const double zeta = 0.05;
  // Over whole periods of the damped motion (twice its eigenvalues' -zeta +- i w) the ratio is exp(-zeta T) exactly.
  const double period = 2 * M_PI / std::sqrt(1 - zeta * zeta);
  const LyapunovResult result =
      FindLargestExponent(*MakeDampedOscillator(), VectorXd{{1, 0}}, zeta, Options(period, 40));
  // Runge-Kutta of order 4 at h = 0.01: a rate off by h^4/144 = 7e-11. A neighbour at 1e-5 beside a state that dies
  // away from 1: rounding of 1e-16 over 1e-5 per interval.
  EXPECT_NEAR(result.exponent, -zeta, 1e-9);
  EXPECT_LT(result.error, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(BothMethods, Lyapunov,
                         testing::Values(DeviationMethod::kNeighbour, DeviationMethod::kDerivative),
                         [](const auto& method) {
                           return method.param == DeviationMethod::kNeighbour ? "Neighbour" : "Derivative";
                         });

TEST(LyapunovSearch, GivesTheSameTwice) {
  const LyapunovOptions options{.intervals = 50, .discarded = 5};
  const VectorXd start{{1, 1, 20}};
  EXPECT_EQ(FindLargestExponent(*MakeLorenz(), start, 28, options).exponent,
            FindLargestExponent(*MakeLorenz(), start, 28, options).exponent);
}

TEST(LyapunovSearch, CanBeEndedEarly) {
  LyapunovOptions options{.intervals = 1000, .discarded = 0};
  options.on_interval = [](int done) { return done < 60; };
  EXPECT_EQ(FindLargestExponent(*MakeLorenz(), VectorXd{{1, 1, 20}}, 28, options).intervals, 60);
}

TEST(LyapunovSearch, RefusesOptionsOutOfRange) {
  const VectorXd start{{1, 1, 20}};
  EXPECT_THROW(FindLargestExponent(*MakeLorenz(), start, 28, {.interval = 0}), std::invalid_argument);
  EXPECT_THROW(FindLargestExponent(*MakeLorenz(), start, 28, {.deviation = 0}), std::invalid_argument);
  EXPECT_THROW(FindLargestExponent(*MakeLorenz(), start, 28, {.intervals = 3}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
