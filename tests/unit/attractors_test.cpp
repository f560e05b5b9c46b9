#include "vehicle/hunting/attractors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/section_watch.h"

namespace uiclink {
namespace {

const Wagon& Knives() {
  static const Wagon wagon = WagonFixture{}.Make();
  return wagon;
}

constexpr std::size_t kBodyLateralMotion = static_cast<std::size_t>(TrackedMotion::kBodyLateral);

TEST(DrawStart, DependsOnSeedAndNumberAlone) {
  const StartBox box;
  std::set<double> seen;
  for (const std::uint64_t seed : {1u, 2u}) {
    for (std::size_t i = 0; i < 50; ++i) {
      EXPECT_EQ(DrawStart(box, seed, i).body_y, DrawStart(box, seed, i).body_y);
      seen.insert(DrawStart(box, seed, i).body_y);
    }
  }
  EXPECT_EQ(seen.size(), 100u);
}

TEST(DrawStart, FillsItsBoxEvenlyWithoutAFactor) {
  StartBox box;
  box.least_factor = 1;
  double sum = 0, squares = 0, largest = 0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double y = DrawStart(box, 3, static_cast<std::size_t>(i)).rear_y / box.wheelset_y;
    sum += y;
    squares += y * y;
    largest = std::max(largest, std::abs(y));
  }
  // Uniform on -1 .. 1: mean 0, mean square 1/3, whose standard errors are 0.0091 and 0.0047; four of each.
  EXPECT_NEAR(sum / n, 0, 0.037);
  EXPECT_NEAR(squares / n, 1.0 / 3, 0.019);
  EXPECT_LE(largest, 1);
  EXPECT_GT(largest, 0.99);
}

TEST(DrawStart, FactorsAreSpreadOverTheirDecades) {
  const StartBox box;  // least factor 0.02
  int small = 0;
  const int n = 2000;
  for (int i = 0; i < n; ++i)
    small += std::abs(DrawStart(box, 5, static_cast<std::size_t>(i)).body_y) < std::sqrt(0.02) * box.body_y;
  // |u| f < m with log f uniform on log(m^2) .. 0: half of the f are below m, and of the others u < m/f:
  // 1/2 + (1 - m)/(2 log(1/m)) = 0.719 for m = sqrt(0.02). Standard error 0.010, four of it.
  const double m = std::sqrt(0.02);
  EXPECT_NEAR(small / static_cast<double>(n), 0.5 + (1 - m) / (-2 * std::log(m)), 0.04);
}

TEST(ShareBounds, AreWilsons) {
  // Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3: 81/263, 15/148, 0/20, 1/29.
  const auto expect = [](std::size_t count, std::size_t of, double low, double high) {
    EXPECT_NEAR(CalcShareBounds(count, of).low, low, 5e-5);
    EXPECT_NEAR(CalcShareBounds(count, of).high, high, 5e-5);
  };
  expect(81, 263, 0.2553, 0.3662);
  expect(15, 148, 0.0624, 0.1605);
  expect(0, 20, 0, 0.1611);
  expect(1, 29, 0.0061, 0.1718);
  EXPECT_EQ(CalcShareBounds(7, 7).high, 1);
  EXPECT_EQ(CalcShareBounds(0, 0).high, 1);
}

TEST(SectionWatch, PointsAreOnTheSectionAndBetweenThemIsOneCycle) {
  Integrator integrator(Knives());
  const WagonState rest = FindEquilibrium(Knives(), 20);
  integrator.Start(20, Perturb(Knives(), rest, {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3}));
  const std::size_t place = kMotionIndex[static_cast<std::size_t>(TrackedMotion::kFrontLateral)];
  SectionWatch watch(place, 1e-4, 1e-3);
  int passages = 0;
  double before = integrator.state().x[place];
  while (integrator.state().t < 10) {
    integrator.Step(10);
    watch.Add(integrator);
    const double now = integrator.state().x[place];
    passages += before < 1e-4 && now >= 1e-4;
    before = now;
  }
  EXPECT_EQ(watch.times().size(), static_cast<std::size_t>(passages));
  ASSERT_GT(passages, 5);
  const Eigen::MatrixXd points = watch.Points();
  // The first coordinate is the front wheelset's: found by bisection to 1e-14 of the time at 0.03 m/s.
  for (Eigen::Index i = 0; i < points.cols(); ++i) EXPECT_NEAR(points(0, i), 1e-4, 1e-13);
  EXPECT_GT(watch.CalcHalfWidths()[0], 1e-3);
}

AttractorOptions Quick() {
  AttractorOptions options;
  options.settle = 20;
  options.observe = 20;
  options.longest = 160;
  options.lyapunov.intervals = 0;
  return options;
}

TEST(RunToAttractor, HuntingIsPeriodicAndItsMirrorImageIsTheSame) {
  const WagonState rest = FindEquilibrium(Knives(), 20);
  Integrator integrator(Knives());
  const auto run = [&](double side) {
    return RunToAttractor(
        integrator, 20,
        Perturb(Knives(), rest, {.front_y = side * 4e-3, .rear_y = side * 3e-3, .body_y = side * 15e-3}), Quick());
  };
  const RunOutcome left = run(1), right = run(-1);
  EXPECT_EQ(left.end, RunEnd::kSettled);
  EXPECT_EQ(left.motion.kind, MotionKind::kPeriodic);
  EXPECT_NEAR(left.frequency * left.motion.period, left.motion.k, 1e-6);
  EXPECT_GT(left.half_width[kBodyLateralMotion], 5e-3);
  EXPECT_EQ(right.motion.kind, left.motion.kind);
  EXPECT_EQ(right.motion.k, left.motion.k);
  // Periodic means within 1e-3 of the motion.
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    if (IsLongitudinal(i)) continue;
    EXPECT_NEAR(right.half_width[i], left.half_width[i], 2e-3 * left.half_width[i]) << kMotionNames[i];
  }
}

TEST(RunToAttractor, BelowAllHuntingEverythingComesToRest) {
  Integrator integrator(Knives());
  const WagonState start = Perturb(Knives(), FindEquilibrium(Knives(), 4), {.front_y = 1e-3, .body_y = 2e-3});
  const RunOutcome outcome = RunToAttractor(integrator, 4, start, Quick());
  EXPECT_EQ(outcome.motion.kind, MotionKind::kEquilibrium);
  EXPECT_EQ(outcome.end, RunEnd::kSettled);
  EXPECT_EQ(outcome.frequency, 0);
}

TEST(FindAttractors, DoesNotDependOnTheNumberOfThreads) {
  AttractorOptions options = Quick();
  options.starts = 6;
  options.threads = 1;
  const AttractorSurvey one = FindAttractors(Knives(), 20, options);
  options.threads = 3;
  const AttractorSurvey three = FindAttractors(Knives(), 20, options);
  ASSERT_EQ(one.runs.size(), 6u);
  for (std::size_t i = 0; i < one.runs.size(); ++i) EXPECT_EQ(one.runs[i].state.x, three.runs[i].state.x) << i;
  ASSERT_EQ(one.attractors.size(), three.attractors.size());
  std::size_t members = one.derailed + one.failed;
  for (std::size_t i = 0; i < one.attractors.size(); ++i) {
    EXPECT_EQ(one.attractors[i].runs, three.attractors[i].runs);
    EXPECT_EQ(one.attractors[i].share, static_cast<double>(one.attractors[i].runs.size()) / 6);
    EXPECT_LT(one.attractors[i].low, one.attractors[i].share);
    EXPECT_GE(one.attractors[i].high, one.attractors[i].share);  // one where all runs agree
    members += one.attractors[i].runs.size();
  }
  EXPECT_EQ(members, 6u);
}

/// At rest (unstable here, but nothing disturbs it), hunting to both sides, derailed: two motions, and one that is
/// none.
TEST(FindAttractors, TellsRestHuntingAndDerailmentApart) {
  const double V = 19;
  const WagonState rest = FindEquilibrium(Knives(), V);
  const auto at = [&](const Perturbation& by) { return Perturb(Knives(), rest, by); };
  WagonState thrown = at({.front_y = 8.5e-3});
  thrown.x[wheelset::kYRate] = 3;
  std::vector<WagonState> starts{rest, rest, thrown};
  for (const double side : {1.0, -1.0})
    starts.push_back(at({.front_y = side * 4e-3, .rear_y = side * 4e-3, .body_y = side * 15e-3}));
  const AttractorSurvey survey = FindAttractors(Knives(), V, starts, Quick());
  EXPECT_EQ(survey.derailed, 1u);
  EXPECT_EQ(survey.runs[2].end, RunEnd::kDerailed);
  EXPECT_THAT(survey.runs[2].reason, testing::HasSubstr("left the track at"));
  ASSERT_EQ(survey.attractors.size(), 2u);
  EXPECT_EQ(survey.attractors[0].typical.motion.kind, MotionKind::kEquilibrium);
  EXPECT_THAT(survey.attractors[0].runs, testing::ElementsAre(0u, 1u));
  EXPECT_THAT(survey.attractors[1].runs, testing::ElementsAre(3u, 4u));
  EXPECT_EQ(survey.attractors[1].typical.motion.kind, MotionKind::kPeriodic);
  EXPECT_NEAR(survey.attractors[1].share, 0.4, 1e-12);
}

TEST(FindAttractors, RefusesOptionsOutOfRange) {
  AttractorOptions options;
  options.longest = 50;
  EXPECT_THROW(FindAttractors(Knives(), 20, options), std::invalid_argument);
  options = {};
  options.box.least_factor = 0;
  EXPECT_THROW(FindAttractors(Knives(), 20, options), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
