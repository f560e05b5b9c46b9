#include "dynamics/poincare.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kInterval = 0.8;  // [s] between passages

/// Points from a function of their number, one passage every 0.8 s.
SectionMotion Classify(int n, const std::function<VectorXd(int)>& point, const SectionOptions& options = {}) {
  std::vector<double> times;
  MatrixXd points(point(0).size(), n);
  for (int i = 0; i < n; ++i) {
    times.push_back(3 + kInterval * i);
    points.col(i) = point(i);
  }
  return ClassifySection(times, points, VectorXd::Ones(points.rows()), options);
}

/// The logistic map x -> r x (1 - x) after 1000 passages.
SectionMotion ClassifyLogistic(double r, int n = 200) {
  double x = 0.4;
  for (int i = 0; i < 1000; ++i) x = r * x * (1 - x);
  return Classify(n, [&](int) {
    x = r * x * (1 - x);
    return VectorXd{{x}};
  });
}

TEST(Poincare, CountsReturnsOfTheLogisticMap) {
  const std::vector<std::pair<double, int>> known{{2.9, 1}, {3.2, 2}, {3.5, 4}, {3.55, 8}, {3.83, 3}};
  for (const auto& [r, k] : known) {
    const SectionMotion motion = ClassifyLogistic(r);
    EXPECT_EQ(motion.kind, MotionKind::kPeriodic) << r;
    EXPECT_EQ(motion.k, k) << r;
    EXPECT_NEAR(motion.period, kInterval * k, 1e-9) << r;
    EXPECT_LE(motion.scatter, 1e-6) << r;
  }
}

TEST(Poincare, ChaosIsIrregular) {
  for (const double r : {3.7, 3.9, 4.0}) {
    for (const int n : {60, 200, 600}) {
      const SectionMotion motion = ClassifyLogistic(r, n);
      EXPECT_EQ(motion.kind, MotionKind::kIrregular) << r << ", " << n;
      EXPECT_LT(motion.correlation, 0.9) << r << ", " << n;
    }
  }
}

/// Points on a closed curve that is no circle, `per_turn` of them a turn, with shares of growth a point.
VectorXd TorusPoint(int i, double per_turn, double growth = 0) {
  const double phase = 2 * std::numbers::pi * i / per_turn;
  const double size = 0.1 * std::exp(growth * i);
  return VectorXd{{1 + size * (std::cos(phase) + 0.3 * std::cos(2 * phase)), size * std::sin(phase)}};
}

TEST(Poincare, FindsThePeriodOfAModulation) {
  for (const double per_turn : {7.3, 10.37, 31.25, 33.3}) {
    const SectionMotion motion = Classify(200, [&](int i) { return TorusPoint(i, per_turn); });
    EXPECT_EQ(motion.kind, MotionKind::kModulated) << per_turn;
    // A line is found to some 2 % of the resolution of the series (one cycle in 200 points).
    EXPECT_NEAR(motion.modulation_period / (kInterval * per_turn), 1, 0.02 * per_turn / 200 + 1e-3) << per_turn;
  }
}

TEST(Poincare, AModulationOfLessThanFourPeriodsIsTooShort) {
  EXPECT_EQ(Classify(100, [](int i) { return TorusPoint(i, 33.3); }).kind, MotionKind::kTooShort);
  EXPECT_EQ(Classify(8, [](int) { return VectorXd{{1.0}}; }).kind, MotionKind::kTooShort);
}

TEST(Poincare, NoiseUpToTheLimitIsNoMotion) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  for (const double sigma : {1e-6, 1e-4, 2e-3}) {
    const SectionMotion motion =
        Classify(200, [&](int i) { return VectorXd{{(i % 3 == 0 ? 1.0 : 0.2) + sigma * normal(random)}}; });
    EXPECT_EQ(motion.kind, MotionKind::kPeriodic) << sigma;
    EXPECT_EQ(motion.k, 3) << sigma;
    EXPECT_NEAR(motion.scatter, sigma, 0.2 * sigma) << sigma;  // 100 points: 7 %
    EXPECT_EQ(motion.rate, 0) << sigma;
  }
  EXPECT_EQ(Classify(200, [&](int) { return VectorXd{{1 + 0.05 * normal(random)}}; }).kind, MotionKind::kIrregular);
}

TEST(Poincare, SlowDecayAndGrowthAreSettlingWithTheirRate) {
  for (const double rate : {-0.02, -0.005, 0.005, 0.02}) {  // [1/s]
    const SectionMotion motion =
        Classify(200, [&](int i) { return VectorXd{{0.3 + 0.1 * std::exp(rate * kInterval * (i - 100))}}; });
    EXPECT_EQ(motion.kind, MotionKind::kSettling) << rate;
    EXPECT_NEAR(motion.rate, rate, 1e-3 * std::abs(rate)) << rate;
    EXPECT_NEAR(motion.e_folding(), 1 / std::abs(rate), 1e-3 / std::abs(rate)) << rate;
  }
}

TEST(Poincare, ASpiralOntoACycleIsSettling) {
  for (const double growth : {-0.01, 0.01}) {  // a point
    const SectionMotion motion = Classify(240, [&](int i) { return TorusPoint(i, 10.37, growth); });
    EXPECT_EQ(motion.kind, MotionKind::kSettling) << growth;
    // Quarters hold 5.8 turns: the spread within them is right to a few per cent, the slope of its logarithm too.
    EXPECT_NEAR(motion.rate, growth / kInterval, 0.05 * std::abs(growth) / kInterval) << growth;
  }
}

TEST(Poincare, WhatHasSettledSaysHowFastItDid) {
  // Down to 0.1 exp(-0.1 150) = 3e-8 in the middle: periodic, with the rate of the last steps.
  const SectionMotion motion = Classify(300, [](int i) { return VectorXd{{1 + 0.1 * std::exp(-0.05 * i)}}; });
  EXPECT_EQ(motion.kind, MotionKind::kPeriodic);
  EXPECT_NEAR(motion.rate, -0.05 / kInterval, 0.01 * 0.05 / kInterval);
}

TEST(Poincare, NothingThatPassesIsAnEquilibrium) {
  EXPECT_EQ(ClassifySection({}, MatrixXd(2, 0), VectorXd::Ones(2)).kind, MotionKind::kEquilibrium);
}

TEST(Poincare, ScalesAreWhatCountsAsOne) {
  std::vector<double> times;
  MatrixXd points(1, 100);
  for (int i = 0; i < 100; ++i) {
    times.push_back(i);
    points(0, i) = i % 2 == 0 ? 1e-3 : 1.1e-3;
  }
  EXPECT_EQ(ClassifySection(times, points, VectorXd{{1e-3}}).k, 2);
  EXPECT_EQ(ClassifySection(times, points, VectorXd{{10.0}}).k, 1);
  EXPECT_THROW(ClassifySection(times, points, VectorXd{{0.0}}), std::invalid_argument);
  EXPECT_THROW(ClassifySection(times, points.leftCols(99), VectorXd{{1.0}}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
