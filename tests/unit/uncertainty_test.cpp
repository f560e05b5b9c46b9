#include "identify/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/event_solver.h"

namespace uiclink {
namespace {

constexpr double kSigma = 1.3e-5;

Oscillator<double> Lateral(double k1, double T0) {
  Oscillator<double> link;
  link.k = 3.41;
  link.Add({k1, T0});
  return link;
}

/// A decay from 25 mm, read with white noise and, where asked for, a slow tone that no link makes.
Record MakeRecord(const Oscillator<double>& link, double tone) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  Record record;
  record.sampling_hz = 200;
  Trajectory<double> run;
  Solve(link, AtExtremum(link, 0.025), 12, &run);
  for (int i = 0; i < 2400; ++i) {
    const double t = i / 200.0;
    record.t.push_back(t);
    record.y.push_back(run.y(t) + kSigma * normal(random) + tone * std::sin(2 * std::numbers::pi * 0.6 * t));
  }
  return record;
}

struct Fitted {
  FitData data;
  FitOutcome outcome;
  LinkInformation information;
};

Fitted FitTo(const Record& record, const Oscillator<double>& start) {
  Fitted fitted;
  fitted.data = {.record = &record, .first = 0, .size = record.t.size(), .sigma = kSigma};
  FitState state;
  state.levels.resize(1);
  FromOscillator(start, &state.levels[0], &state.shape);
  state.starts = {{0.025, 0, 0}};
  fitted.outcome = Fit({&fitted.data, 1}, Sharing::kLink, state);
  const FitState& best = fitted.outcome.state;
  fitted.information = CalcInformation(fitted.data, best.levels[0], best.shape, best.starts[0], 0.9);
  return fitted;
}

TEST(Uncertainty, ProfileOfANearlyLinearFitIsNormal) {
  const Record record = MakeRecord(Lateral(2.21, 0.018), 0);
  const Fitted fitted = FitTo(record, Lateral(2.21, 0.018));
  EXPECT_FALSE(fitted.information.structured);
  EXPECT_NEAR(fitted.information.variance_factor, 1, 0.1);  // chi-square of 2400: 3 standard deviations of 2.9 %
  const Eigen::MatrixXd covariance = CalcCovariance(fitted.information.information, fitted.information.variance_factor);
  for (int q = 0; q < 3; ++q) {
    int evaluations = 0;
    const Estimate e = ProfileQuantity({&fitted.data, 1}, fitted.outcome, q, covariance,
                                       fitted.information.variance_factor, &evaluations);
    EXPECT_FALSE(e.low_open || e.high_open);
    // Errors of 1e-4 of the values: the profile is a parabola up to the 1 % to which its bounds are located.
    EXPECT_NEAR((e.high - e.value) / e.std, 1.96, 0.03) << q;
    EXPECT_NEAR((e.value - e.low) / e.std, 1.96, 0.03) << q;
  }
}

TEST(Uncertainty, StructureInTheResidualsWidensTheVariance) {
  const Record record = MakeRecord(Lateral(2.21, 0.018), 4 * kSigma);
  const Fitted fitted = FitTo(record, Lateral(2.21, 0.018));
  EXPECT_TRUE(fitted.information.structured);
  // Mean square 1 + 16/2 in units of the noise; the fit takes some of the tone away, so at least half of it stays.
  EXPECT_GT(fitted.information.variance_factor, 4.5);
  EXPECT_LT(fitted.information.effective_size, 0.2 * 2400);
}

TEST(Uncertainty, WhatTheDataDoNotSayIsNotKnownButNeverInfinite) {
  Eigen::Matrix3d information = Eigen::Vector3d(1e8, 0, 4e6).asDiagonal();
  const Eigen::MatrixXd covariance = CalcCovariance(information, 1);
  EXPECT_NEAR(covariance(0, 0), 1e-8, 1e-20);
  EXPECT_NEAR(covariance(1, 1), kUndetermined * kUndetermined, 1e-9);
  EXPECT_NEAR(covariance(2, 2), 2.5e-7, 1e-18);
}

TEST(Uncertainty, NamesTheSplitThatEqualSlidersLeaveOpen) {
  // Stiffness moved from k1 to k2 with the friction that belongs to it changes nothing: one direction without
  // information.
  Oscillator<double> link;
  link.k = 3.41;
  link.Add({1.105, 0.009});
  link.Add({1.105, 0.009});
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(5, 5) * 1e-8;  // k, sum k_i, sum T0i; then u_2, v_2
  covariance(3, 3) = covariance(3, 4) = covariance(4, 3) = covariance(4, 4) = 4;
  const std::vector<std::string> names = NameUnidentifiable(link, covariance);
  ASSERT_EQ(names.size(), 1u);
  EXPECT_TRUE(names[0] == "k1 - k2 + T01 - T02" || names[0] == "-k1 + k2 - T01 + T02") << names[0];
  EXPECT_TRUE(NameUnidentifiable(link, 1e-8 * Eigen::MatrixXd::Identity(5, 5)).empty());
}

TEST(Uncertainty, ASideWithoutInformationIsOpen) {
  // A link that never slides from 25 mm: T0 could be anything above what would make it slide.
  const Oscillator<double> stuck = Lateral(2.21, 0.08);
  const Record record = MakeRecord(stuck, 0);
  const Fitted fitted = FitTo(record, stuck);
  const Eigen::MatrixXd covariance = CalcCovariance(fitted.information.information, fitted.information.variance_factor);
  int evaluations = 0;
  const Estimate T0 = ProfileQuantity({&fitted.data, 1}, fitted.outcome, 2, covariance,
                                      fitted.information.variance_factor, &evaluations);
  EXPECT_TRUE(T0.high_open);
}

}  // namespace
}  // namespace uiclink
