// What the uncertainty of links makes of a scalar: closed forms for linear functions, critical speeds against searches
// over all speeds, shares of variance, failures.

#include "vehicle/hunting/speed_bounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <stdexcept>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/hunting_bounds.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

std::array<CornerLinks, kCorners> Uncertain(double correlation = -0.9, double scale = 1) {
  CornerLinks links = WagonFixture{}.ReadLinks();
  const double a = 0.03 * scale, b = 0.02 * scale, c = 1e-3 * scale;
  links.lateral.covariance = {
      .order = {"k", "k1", "T01"},
      .matrix = {{a * a, correlation * a * b, 0}, {correlation * a * b, b * b, 0}, {0, 0, c * c}}};
  return {links, links, links, links};
}

const Wagon& TheWagon() {
  static const Wagon wagon = WagonFixture{}.Make();
  return wagon;
}

/// Sum of shares, and one of them.
double Sum(const std::vector<VarianceShare>& shares) {
  return std::accumulate(shares.begin(), shares.end(), 0.0,
                         [](double s, const VarianceShare& v) { return s + v.share; });
}
double ShareOf(const std::vector<VarianceShare>& shares, const std::string& name) {
  for (const VarianceShare& share : shares)
    if (share.name == name) return share.share;
  ADD_FAILURE() << name;
  return 0;
}

// ---------------------------------------------------------------- shares

TEST(VarianceShares, OfIndependentParametersAreTheirVariances) {
  const SetScatter scatter(Uncertain(0), {.draws = 0});
  const VarianceShares shares = CalcVarianceShares(scatter, Eigen::Vector3d(2, 1, 30));
  const double a = 0.06 * 0.06, b = 0.02 * 0.02, c = 0.03 * 0.03;
  EXPECT_NEAR(shares.parameters[0].share, a / (a + b + c), 1e-14);
  EXPECT_NEAR(shares.parameters[2].share, c / (a + b + c), 1e-14);
  EXPECT_NEAR(ShareOf(shares.groups, "lateral k + sum k_i"), (a + b) / (a + b + c), 1e-14);
  EXPECT_NEAR(shares.not_linear, 0, 1e-14);
}

TEST(VarianceShares, OfParametersThatAFitHasBoundTogetherAddUpAndLeaveOthersAlone) {
  // f = x1 + x2 with variances u^2, v^2 and correlation r: (u^2 + r u v) and (v^2 + r u v) of u^2 + v^2 + 2 r u v.
  const double r = -0.95, u = 0.03, v = 0.02, variance = u * u + v * v + 2 * r * u * v;
  const SetScatter scatter(Uncertain(r), {.draws = 0});
  const VarianceShares shares = CalcVarianceShares(scatter, Eigen::Vector3d(1, 1, 0));
  EXPECT_NEAR(shares.parameters[0].share, (u * u + r * u * v) / variance, 1e-12);
  EXPECT_LT(shares.parameters[1].share, 0) << "k1 takes back what k does";
  EXPECT_NEAR(Sum(shares.parameters), 1, 1e-12);
  EXPECT_NEAR(ShareOf(shares.groups, "lateral k + sum k_i"), 1, 1e-12);
  EXPECT_EQ(ShareOf(shares.groups, "lateral T0"), 0);
}

TEST(VarianceShares, OneCombinationExplainsItsSquaredCorrelation) {
  Eigen::Matrix2d C = Eigen::Vector2d(1, 4).asDiagonal();
  EXPECT_NEAR(CalcExplainedBy(C, Eigen::Vector2d(1, 1), Eigen::Vector2d(2, 2)), 1, 1e-15);
  EXPECT_NEAR(CalcExplainedBy(C, Eigen::Vector2d(1, 1), Eigen::Vector2d(1, 0)), 1.0 / 5, 1e-15);
}

// ---------------------------------------------------------------- any scalar

/// A linear function of the links of a wagon: 3 k - 2 k1 + 100 T01, per unit load, lateral, front left.
double Linear(const Wagon& wagon) {
  const Link& link = wagon.lateral[0];
  const double k1 = link.sliders()[0].k;
  return 3 * link.law().k - 2 * k1 + 100 * k1 * link.sliders()[0].y_c;
}

TEST(PropagateScalar, OfALinearFunctionHasItsStandardDeviationAndShares) {
  const SetScatter scatter(Uncertain(0), {.draws = 4000});
  const ScalarBounds bounds = PropagateScalar("linear", "-", Linear, scatter, TheWagon());
  const std::array<double, 3> parts{0.09 * 0.09, 0.04 * 0.04, 0.1 * 0.1};
  const double variance = parts[0] + parts[1] + parts[2], std = std::sqrt(variance);
  ASSERT_TRUE(bounds.nominal);
  EXPECT_EQ(bounds.failed, 0u);
  // Five standard errors of 4000 independent draws; a Latin hypercube has less. The quantile's: sqrt(p
  // (1-p)/n)/density.
  EXPECT_NEAR(bounds.mean.value, *bounds.nominal, 5 * std / std::sqrt(4000.0));
  EXPECT_NEAR(bounds.std.value, std, 5 * std / std::sqrt(8000.0));
  EXPECT_NEAR(bounds.low.value, *bounds.nominal - 1.96 * std, 5 * 2.67 * std / std::sqrt(4000.0));
  EXPECT_NEAR(bounds.high.value, *bounds.nominal + 1.96 * std, 5 * 2.67 * std / std::sqrt(4000.0));
  // That the stated errors are those.
  EXPECT_NEAR(bounds.mean.error, std / std::sqrt(4000.0), 0.1 * std / std::sqrt(4000.0));
  EXPECT_NEAR(bounds.std.error, std / std::sqrt(8000.0), 0.2 * std / std::sqrt(8000.0));
  EXPECT_NEAR(bounds.low.error, 2.67 * std / std::sqrt(4000.0), 0.5 * 2.67 * std / std::sqrt(4000.0));
  // A regression finds a linear function exactly, but for rounding.
  EXPECT_NEAR(bounds.shares.not_linear, 0, 1e-10);
  // Those of these draws: variances and covariances to five of their standard errors.
  const double slack = 5 / std::sqrt(4000.0);
  EXPECT_NEAR(ShareOf(bounds.shares.parameters, "lateral k"), parts[0] / variance, slack);
  EXPECT_NEAR(ShareOf(bounds.shares.parameters, "lateral T01"), parts[2] / variance, slack);
  EXPECT_NEAR(ShareOf(bounds.shares.groups, "lateral k + sum k_i"), (parts[0] + parts[1]) / variance, slack);
}

TEST(PropagateScalar, SharesOfANoisyFunctionAndTheRestAddUpToOne) {
  const SetScatter scatter(Uncertain(), {.draws = 1000});
  int draw = 0;
  // A third of the variance does not come from the parameters.
  const auto noisy = [&](const Wagon& wagon) {
    return Linear(wagon) + 0.0707 * std::sqrt(3.0) * (2 * ((draw++ * 7919) % 1001) / 1000.0 - 1);
  };
  const ScalarBounds bounds = PropagateScalar("noisy", "-", noisy, scatter, TheWagon(), {.threads = 1});
  EXPECT_NEAR(Sum(bounds.shares.groups) + bounds.shares.not_linear, 1, 1e-12);
  EXPECT_NEAR(Sum(bounds.shares.parameters) + bounds.shares.not_linear, 1, 1e-12);
  const double variance = bounds.std.value * bounds.std.value;
  EXPECT_NEAR(bounds.shares.not_linear, 0.005 / variance, 0.05);
}

TEST(PropagateScalar, FailuresAreKeptWithTheirReasonAndCounted) {
  const SetScatter scatter(Uncertain(), {.draws = 100});
  const double middle = TheWagon().lateral[0].law().k;
  const auto half = [&](const Wagon& wagon) {
    if (wagon.lateral[0].law().k > middle) throw std::runtime_error("too stiff");
    return wagon.lateral[0].law().k;
  };
  const ScalarBounds bounds = PropagateScalar("half", "1/m", half, scatter, TheWagon());
  ASSERT_EQ(bounds.values.size(), 100u);
  // One value in each half of the first variable would be exact; k is made of all three.
  EXPECT_NEAR(static_cast<double>(bounds.failed), 50, 15);
  std::size_t counted = 0;
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(std::isfinite(bounds.values[i]), bounds.reasons[i].empty());
    if (!bounds.reasons[i].empty()) {
      EXPECT_EQ(bounds.reasons[i], "too stiff");
      ++counted;
    }
  }
  EXPECT_EQ(counted, bounds.failed);
  EXPECT_LE(bounds.high.value, middle) << "statistics are of those with a value";
}

TEST(PropagateScalar, WhereEveryDrawFailsNothingIsClaimed) {
  const SetScatter scatter(Uncertain(), {.draws = 10});
  const auto fail = [](const Wagon&) -> double { throw std::runtime_error("never"); };
  const ScalarBounds bounds = PropagateScalar("none", "-", fail, scatter, TheWagon());
  EXPECT_FALSE(bounds.nominal);
  EXPECT_EQ(bounds.nominal_reason, "never");
  EXPECT_FALSE(bounds.exists());
  EXPECT_EQ(bounds.failed, 10u);
}

// ---------------------------------------------------------------- the linear critical speed

KnownCrossing FindKnown(const Wagon& wagon) {
  StabilityOptions options;
  options.to = 80;
  options.first_only = true;
  options.tolerance = 1e-10;
  const StabilityResult result = FindCrossings(wagon, options);
  return {result.linear_critical_speed.value(), result.crossings.front().mode.lambda};
}

TEST(SpeedBounds, ACriticalSpeedThatIsFollowedIsTheOneThatIsSearched) {
  const KnownCrossing known = FindKnown(TheWagon());
  const SetScatter scatter(Uncertain(-0.9, 5), {.draws = 12, .corner = {.k = 0.1, .slider_k = 0.1}});
  for (std::size_t i = 0; i < scatter.size(); ++i) {
    const Wagon wagon = WithLinks(TheWagon(), scatter.Draw(i));
    EXPECT_NEAR(FindCriticalSpeedNear(wagon, known), FindKnown(wagon).V, 2e-8) << i;  // both to 1e-8
  }
}

TEST(SpeedBounds, GradientIsThatOfSearchedSpeeds) {
  const KnownCrossing known = FindKnown(TheWagon());
  const SetScatter scatter(Uncertain(), {.draws = 0});
  const Eigen::VectorXd gradient = CalcSpeedGradient(scatter, TheWagon(), known);
  for (const Eigen::Index i : {0, 1}) {
    const auto at = [&](double change) {
      Eigen::VectorXd values = scatter.centre();
      values[i] += change;
      return FindKnown(WithLinks(TheWagon(), scatter.LinksAt(values))).V;
    };
    const double h = 0.1, slope = (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
    EXPECT_NEAR(gradient[i], slope, 1e-4 * slope);  // truncation of either difference
  }
  EXPECT_EQ(gradient[2], 0) << "stuck joints do not know where they would slide";
}

TEST(SpeedBounds, TheSumOfStiffnessMovesTheLinearSpeed) {
  const SetScatter scatter(Uncertain(), {.draws = 400});
  const SpeedBounds bounds = CalcSpeedBounds(scatter, TheWagon());
  const ScalarBounds& speed = bounds.speed;
  ASSERT_TRUE(speed.nominal && speed.linear_low);
  EXPECT_EQ(speed.failed, 0u);
  EXPECT_NEAR(bounds.by_lateral_stiffness, 1, 1e-9);
  EXPECT_NEAR(ShareOf(speed.shares.groups, "lateral k + sum k_i"), 1, 1e-3);  // curvature: 1 % of a relative change
  EXPECT_EQ(ShareOf(speed.shares.groups, "lateral T0"), 0);
  EXPECT_NEAR(Sum(speed.shares.groups) + speed.shares.not_linear, 1, 1e-12);
  EXPECT_EQ(bounds.by_longitudinal_stiffness, 0);
  // Nearly linear, so quantiles are those of the first order within their own error.
  EXPECT_NEAR(speed.low.value, *speed.linear_low, 4 * speed.low.error);
  EXPECT_NEAR(speed.high.value, *speed.linear_high, 4 * speed.high.error);
}

TEST(SpeedBounds, CornersCountAsMuchTogetherAsTheSet) {
  // The same relative deviation of k: of all corners at once, or of each by itself.
  std::array<CornerLinks, kCorners> links = Uncertain();
  const double k = links[0].lateral.k, std = 0.02;
  for (CornerLinks& corner : links) corner.lateral.covariance = {.order = {"k"}, .matrix = {{std * std * k * k}}};
  const SetScatter together(links, {.draws = 2});
  for (CornerLinks& corner : links) corner.lateral.covariance.reset();
  const SetScatter apart(links, {.draws = 2, .corner = {.k = std}});
  const KnownCrossing known = FindKnown(TheWagon());
  const Eigen::VectorXd g = CalcSpeedGradient(together, TheWagon(), known);
  const Eigen::VectorXd h = CalcSpeedGradient(apart, TheWagon(), known);
  ASSERT_EQ(h.size(), 8);  // longitudinal, too
  EXPECT_NEAR(h.head(4).sum(), g[0] * k, 1e-5 * g[0] * k) << "all corners together are the set";
  for (const Eigen::Index front_or_rear : {0, 2})
    EXPECT_NEAR(h[front_or_rear], h[front_or_rear + 1], 1e-6 * h.norm()) << "left and right";
  // Half where all corners count the same; here the rear wheelset's links count eight times as much as the front ones'.
  EXPECT_GT(h.head(4).norm(), 0.5 * g[0] * k);
}

TEST(SpeedBounds, TheNumberOfThreadsDoesNotChangeThem) {
  const SetScatter scatter(Uncertain(), {.draws = 40});
  const SpeedBounds one = CalcSpeedBounds(scatter, TheWagon(), {}, {.threads = 1});
  const SpeedBounds two = CalcSpeedBounds(scatter, TheWagon(), {}, {.threads = 2});
  EXPECT_EQ(one.speed.values, two.speed.values);
  EXPECT_EQ(one.speed.low.value, two.speed.low.value);
  EXPECT_EQ(one.speed.shares.not_linear, two.speed.shares.not_linear);
}

TEST(SpeedBounds, AWagonWithoutACriticalSpeedSaysSo) {
  const SpeedBounds bounds = CalcSpeedBounds(SetScatter(Uncertain(), {.draws = 3}), TheWagon(), {.to = 2});
  EXPECT_FALSE(bounds.speed.nominal);
  EXPECT_EQ(bounds.speed.nominal_reason, "stable up to 2 m/s");
}

// ---------------------------------------------------------------- hunting

TEST(HuntingBounds, AStateIsCarriedOverToTheSameWagonAsItIs) {
  SimulationOptions options;
  options.duration = 2.3;
  const WagonState start = Perturb(TheWagon(), FindEquilibrium(TheWagon(), 20), {.front_y = 3e-3, .rear_y = 3e-3});
  const WagonState state = Simulate(TheWagon(), 20, start, options).state;
  const WagonState carried = CarryOver(TheWagon(), state, TheWagon());
  options.duration = 0.5;
  const SimulationResult a = Simulate(TheWagon(), 20, state, options), b = Simulate(TheWagon(), 20, carried, options);
  // Forces are taken apart and put together again: rounding, which half a second does not make large.
  for (std::size_t i = 0; i < kMotions; ++i) EXPECT_NEAR(a.state.x[i], b.state.x[i], 1e-9) << kStateNames[i];
}

TEST(HuntingBounds, CarriedJointsKeepTheirShareOfTheLimit) {
  SimulationOptions options;
  options.duration = 2.3;
  const WagonState start = Perturb(TheWagon(), FindEquilibrium(TheWagon(), 20), {.front_y = 3e-3, .rear_y = 3e-3});
  const WagonState state = Simulate(TheWagon(), 20, start, options).state;
  const Wagon other = WithLinks(TheWagon(), SetScatter(Uncertain(0, 10), {.draws = 1}).Draw(0));
  const WagonState carried = CarryOver(TheWagon(), state, other);
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const CornerDeflection<double> at = CalcDeflection(other, state.x, corner);
    const auto share = [&](const Wagon& wagon, const WagonState& of) {
      return of.links.lateral[corner].CalcJointForce(wagon.lateral[corner], 0, at.dy, at.vy) /
             wagon.lateral[corner].CalcBreakoutForce(0, 1, at.vy);
    };
    EXPECT_NEAR(share(other, carried), share(TheWagon(), state), 1e-9 * std::abs(share(TheWagon(), state)));
  }
}

TEST(HuntingBounds, RunsThatEndEarlyAreFailuresAndThreadsDoNotMatter) {
  const SetScatter scatter(Uncertain(), {.draws = 4});
  SimulationOptions options;
  options.duration = 3;
  options.window = 2;
  const WagonState calm = Perturb(TheWagon(), FindEquilibrium(TheWagon(), 20), {.front_y = 3e-3, .rear_y = 3e-3});
  const std::vector<ScalarBounds> one = CalcHuntingBounds(scatter, TheWagon(), 20, calm, options, {.threads = 1});
  const std::vector<ScalarBounds> two = CalcHuntingBounds(scatter, TheWagon(), 20, calm, options, {.threads = 2});
  ASSERT_EQ(one.size(), HuntingScalars().size());
  EXPECT_EQ(one[0].failed, 0u);
  EXPECT_EQ(one[0].values, two[0].values);
  EXPECT_GT(one[0].std.value, 0);

  const WagonState thrown = Perturb(TheWagon(), FindEquilibrium(TheWagon(), 20), {.body_phi = 0.3});
  const std::vector<ScalarBounds> lifted = CalcHuntingBounds(scatter, TheWagon(), 20, thrown, options);
  EXPECT_EQ(lifted[0].failed, 4u);
  EXPECT_THAT(lifted[0].reasons[2], HasSubstr("wheel"));
}

}  // namespace
}  // namespace uiclink
