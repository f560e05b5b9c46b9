#include "identify/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

namespace uiclink {
namespace {

TEST(Statistics, KnowsTheTablesOfChiSquareAndStudent) {
  // Printed tables of quantiles (any handbook), rounded in the last digit shown; the tail at a rounded quantile is off
  // by the density times the rounding, below 2e-5 here.
  EXPECT_NEAR(CalcChiSquareTail(3.8415, 1), 0.05, 2e-5);
  EXPECT_NEAR(CalcChiSquareTail(18.307, 10), 0.05, 2e-5);
  EXPECT_NEAR(CalcChiSquareTail(46.963, 27), 0.01, 2e-5);
  EXPECT_EQ(CalcChiSquareTail(0, 3), 1);
  EXPECT_NEAR(CalcStudentBound(0.95, 1), 12.706, 5e-4);
  EXPECT_NEAR(CalcStudentBound(0.95, 3), 3.182, 5e-4);
  EXPECT_NEAR(CalcStudentBound(0.95, 9), 2.262, 5e-4);
  EXPECT_NEAR(CalcStudentBound(0.99, 9), 3.250, 5e-4);
  EXPECT_NEAR(CalcStudentBound(0.95, std::numeric_limits<double>::infinity()), 1.959964, 5e-7);
}

std::vector<double> AutoregressiveNoise(double phi, std::size_t n, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  std::vector<double> x(n);
  double last = normal(*random) / std::sqrt(1 - phi * phi);
  for (double& value : x) value = last = phi * last + normal(*random);
  return x;
}

TEST(Statistics, WhitenessErrsAsOftenAsItSays) {
  std::mt19937_64 random(1);
  int alarms = 0;
  constexpr int kTrials = 2000;
  for (int i = 0; i < kTrials; ++i)
    alarms += TestWhiteness(AutoregressiveNoise(0, 1000, &random)).p_value < 0.05 ? 1 : 0;
  // 100 expected, standard deviation 9.7; the chi-square is asymptotic, so five of these.
  EXPECT_NEAR(alarms, 100, 49);
}

TEST(Statistics, WhitenessSeesASineOfAThirdOfTheNoise) {
  std::mt19937_64 random(2);
  std::vector<double> x = AutoregressiveNoise(0, 2500, &random);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] += 0.33 * std::sin(2 * std::numbers::pi * static_cast<double>(i) / 170);
  EXPECT_LT(TestWhiteness(x).p_value, 1e-3);
}

TEST(Statistics, EffectiveSizeIsThatOfAnAutoregressiveProcess) {
  std::mt19937_64 random(3);
  for (const double phi : {0.5, 0.9}) {
    double sum = 0;
    constexpr int kTrials = 40;
    for (int i = 0; i < kTrials; ++i) sum += CalcEffectiveSize(AutoregressiveNoise(phi, 20000, &random)) / kTrials;
    const double expected = 20000 * (1 - phi) / (1 + phi);
    // Summing to the first zero of an estimated correlation scatters by some ten per cent; the mean of 40 by 2 %, and
    // the sum stops early as often as late only on average.
    EXPECT_NEAR(sum, expected, 0.08 * expected) << phi;
  }
  EXPECT_EQ(CalcEffectiveSize(std::vector<double>(100, 1.0)), 100);  // a constant has no variance to correlate
}

TEST(Statistics, PopulationOfOneIsItsMember) {
  const double value[] = {3.4}, error[] = {0.1};
  const Population p = EstimatePopulation(value, error);
  EXPECT_EQ(p.mean, 3.4);
  EXPECT_EQ(p.std, 0.1);
  EXPECT_EQ(p.spread, 0);
  EXPECT_NEAR(p.half_width, 0.196, 1e-4);
}

TEST(Statistics, PopulationWithoutErrorsIsTheSample) {
  // Errors that vanish beside the scatter: mean, sample standard deviation, and the t interval of the mean.
  const double values[] = {1, 2, 3, 4, 5}, errors[] = {1e-9, 1e-9, 1e-9, 1e-9, 1e-9};
  const Population p = EstimatePopulation(values, errors);
  EXPECT_NEAR(p.mean, 3, 1e-9);
  EXPECT_NEAR(p.spread, std::sqrt(2.5), 1e-9);
  EXPECT_NEAR(p.std, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(p.half_width, 2.776 * std::sqrt(0.5), 5e-4);  // t(0.975, 4), rounded
}

TEST(Statistics, PopulationWithoutSpreadIsTheWeightedMean) {
  // Values closer to each other than their errors: no spread, weights 1/error^2, and no smaller an error than theirs.
  const double values[] = {1.0, 1.1}, errors[] = {1.0, 2.0};
  const Population p = EstimatePopulation(values, errors);
  EXPECT_EQ(p.spread, 0);
  EXPECT_NEAR(p.mean, (1.0 + 1.1 / 4) / 1.25, 1e-12);
  EXPECT_NEAR(p.std, std::sqrt(1 / 1.25), 1e-12);
}

TEST(Statistics, BoundsOfAMeanHoldIt) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  for (const int members : {3, 5, 10}) {
    constexpr int kTrials = 4000;
    int inside = 0;
    for (int i = 0; i < kTrials; ++i) {
      std::vector<double> values, errors;
      for (int m = 0; m < members; ++m) {
        errors.push_back(m % 2 == 0 ? 0.3 : 0.6);
        values.push_back(normal(random) + errors.back() * normal(random));
      }
      const Population p = EstimatePopulation(values, errors);
      inside += std::abs(p.mean) <= p.half_width ? 1 : 0;
    }
    // 95 % with a standard deviation of 0.34 %; Hartung and Knapp's interval is not exact for unequal errors and few
    // members, where it is known to stray by about one per cent.
    EXPECT_NEAR(inside / static_cast<double>(kTrials), 0.95, 0.02) << members;
  }
}

}  // namespace
}  // namespace uiclink
