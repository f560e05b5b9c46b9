#include "vehicle/hunting/trace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/window_watch.h"
#include "vehicle/stability.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

const Wagon& Knives() {
  static const Wagon wagon = WagonFixture{}.Make();
  return wagon;
}

TracePoint Pushed(double V) {
  const WagonState rest = FindEquilibrium(Knives(), V);
  return {0, Perturb(Knives(), rest, {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3})};
}

TEST(TraceSpeeds, LegsJoinWithoutASpeedTwice) {
  const std::vector<TraceSpeed> speeds = ListTraceSpeeds({.from = 15, .legs = {{15.2, 0.1}, {15, 0.15}}});
  std::vector<double> V;
  std::vector<std::size_t> legs;
  for (const TraceSpeed& speed : speeds) {
    V.push_back(speed.V);
    legs.push_back(speed.leg);
  }
  EXPECT_THAT(V, testing::Pointwise(testing::DoubleEq(), {15.0, 15.1, 15.2, 15.05, 15.0}));
  EXPECT_THAT(legs, testing::ElementsAre(0u, 0u, 0u, 1u, 1u));
}

TEST(TraceSpeeds, OfFigure10_1AreItsSpeeds) {
  const std::vector<TraceSpeed> speeds = ListTraceSpeeds({});
  EXPECT_EQ(speeds.size(), 1u + 160 + 300);
  EXPECT_NEAR(speeds[80].V, 19, 1e-12);
  EXPECT_EQ(speeds[160].V, 23);
  EXPECT_EQ(speeds.back().V, 8);
}

TEST(TraceSpeeds, RefusesOptionsOutOfRange) {
  EXPECT_THROW(ListTraceSpeeds({.from = 0}), std::invalid_argument);
  EXPECT_THROW(ListTraceSpeeds({.legs = {{20, 0}}}), std::invalid_argument);
  EXPECT_THROW(ListTraceSpeeds({.legs = {{-1, 0.1}}}), std::invalid_argument);
  EXPECT_THROW(ListTraceSpeeds({.hold = 2, .window = 3}), std::invalid_argument);
  EXPECT_THROW(ListTraceSpeeds({.disturbance = -1}), std::invalid_argument);
}

/// The rear wheelset at its guidance: hunting after 60 s from the push.
TracePoint Hunting(double V) {
  SimulationOptions options;
  options.duration = 60;
  TracePoint point = Pushed(V);
  point.state = Simulate(Knives(), V, point.state, options).state;
  return point;
}

/// Every figure of a row beside the run that it belongs to.
TEST(Trace, RowsAreWhatASimulationOfTheSameSecondsSays) {
  const TraceOptions options{.from = 20, .legs = {{19.8, 0.1}}, .hold = 8, .disturbance = 0};
  const TracePoint start = Hunting(20);
  const Trace trace = TraceBifurcation(Knives(), start, options);
  ASSERT_TRUE(trace.complete) << trace.end_reason;
  ASSERT_EQ(trace.rows.size(), 3u);
  WagonState state = start.state;
  for (const TraceRow& row : trace.rows) {
    SimulationOptions run;
    run.duration = options.hold;
    run.window = options.window;
    run.checkpoint_interval = 100;
    state.t = 0;
    const SimulationResult result = Simulate(Knives(), row.V, state, run);
    state = result.state;
    for (std::size_t i = 0; i < kMotionCount; ++i) {
      const MotionFigures& motion = result.motions[i];
      // The trace ends a step at the beginning of its window, the run does not, and knows it to 5 ms only: 1e-6 of the
      // motion for the step's error, and what a motion at most does in 5 ms where the window begins at an extreme.
      EXPECT_NEAR(row.half_width[i], motion.amplitude, 2e-3 * motion.amplitude + 1e-9) << kMotionNames[i];
      EXPECT_NEAR(row.largest[i], motion.amplitude + std::abs(motion.mean), 2e-3 * motion.amplitude + 1e-9);
    }
    const GuidanceUse& rear = row.lateral[1];
    EXPECT_NEAR(rear.clearance_used, result.lateral[1].clearance_used_in_window, 1e-5);
    EXPECT_NEAR(rear.impacts.count, result.lateral[1].impacts_in_window.count, 1);
    EXPECT_GT(rear.impacts.count, 3);
    EXPECT_NEAR(rear.impacts.peak_N, result.lateral[1].impacts_in_window.peak_N, 50);
    EXPECT_EQ(row.longitudinal[0].impacts.count, 0);
    EXPECT_NEAR(row.longitudinal[1].clearance_used, result.longitudinal[1].clearance_used_in_window, 1e-5);
    EXPECT_GE(row.minimum_wheel_load, 0.98 * result.minimum_wheel_load);
    EXPECT_LT(row.minimum_wheel_load, 38e3);
    EXPECT_FALSE(row.wheel_lift);
  }
}

TEST(Trace, ResumedIsUninterruptedBitByBit) {
  const TraceOptions options{.from = 20, .legs = {{20.2, 0.1}, {20.1, 0.1}}, .hold = 4};
  std::vector<TracePoint> points;
  const Trace whole =
      TraceBifurcation(Knives(), Pushed(20), options, [&](const TraceRow&, const TracePoint& at, std::size_t rows) {
        EXPECT_EQ(rows, 4u);
        points.push_back(at);
        return true;
      });
  ASSERT_EQ(points.size(), 4u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Trace rest = TraceBifurcation(Knives(), points[i], options);
    ASSERT_EQ(rest.rows.size(), 3 - i);
    EXPECT_TRUE(rest.complete);
    EXPECT_EQ(rest.end.state.x, whole.end.state.x) << i;
    EXPECT_EQ(rest.rows.back().half_width, whole.rows.back().half_width) << i;
  }
}

TEST(Trace, CanBeStopped) {
  const Trace trace = TraceBifurcation(Knives(), Pushed(20), {.from = 20, .hold = 3},
                                       [](const TraceRow&, const TracePoint& at, std::size_t) { return at.rows < 2; });
  EXPECT_EQ(trace.rows.size(), 2u);
  EXPECT_FALSE(trace.complete);
  EXPECT_EQ(trace.end_reason, "stopped");
}

TEST(Trace, EndsWhereTheWagonDerails) {
  TracePoint thrown = Pushed(20);
  thrown.state.x[wheelset::kYRate] = 3;  // over the flange
  const Trace trace = TraceBifurcation(Knives(), thrown, {.from = 20, .legs = {{19, 0.1}}, .hold = 5});
  ASSERT_EQ(trace.rows.size(), 1u);
  EXPECT_TRUE(trace.rows[0].derailed);
  EXPECT_FALSE(trace.complete);
  EXPECT_THAT(trace.end_reason, HasSubstr("derailed at 20 m/s after"));
}

TEST(Trace, GoesOnThroughAWheelLift) {
  TracePoint thrown{0, FindEquilibrium(Knives(), 20)};
  thrown.state.x[wheelset::kPhiRate] = 0.2;
  const Trace trace = TraceBifurcation(Knives(), thrown, {.from = 20, .legs = {{20.1, 0.1}}, .hold = 4});
  ASSERT_EQ(trace.rows.size(), 2u);
  EXPECT_TRUE(trace.rows[0].wheel_lift);
  EXPECT_FALSE(trace.rows[1].wheel_lift);
  EXPECT_TRUE(trace.complete);
}

/// The delay of a trace: a motion that grows from the disturbance needs time, so that the longer a speed is held, the
/// nearer to the linear critical speed it is seen. Onset never comes before it.
TEST(Trace, ShowsOnsetBehindTheLinearCriticalSpeedAndHysteresis) {
  StabilityOptions search;
  search.first_only = true;
  const std::vector<Crossing> crossings = FindCrossings(Knives(), search).crossings;
  ASSERT_FALSE(crossings.empty());
  const double hopf = crossings[0].V;
  std::vector<double> onsets;
  for (const double hold : {4.0, 8.0}) {
    const TraceOptions options{
        .from = hopf - 0.4, .legs = {{hopf + 4, 0.2}, {hopf - 5, 0.4}}, .hold = hold, .disturbance = 1e-5};
    const TracePoint start{0, FindEquilibrium(Knives(), options.from)};
    const TraceJumps found = FindTraceJumps(TraceBifurcation(Knives(), start, options).rows);
    ASSERT_GE(found.jumps.size(), 1u) << hold;
    EXPECT_EQ(found.jumps[0].kind, TraceJump::Kind::kOnset);
    EXPECT_EQ(found.jumps[0].leg, 0u);
    EXPECT_NEAR(found.jumps[0].V - found.jumps[0].before, 0.2, 1e-9);
    EXPECT_GT(found.jumps[0].V, hopf);
    onsets.push_back(found.jumps[0].V);
  }
  EXPECT_LT(onsets[1], onsets[0]);
}

TraceRow RowOf(double V, std::size_t leg, double half_width) {
  TraceRow row{.V = V, .leg = leg};
  row.half_width[0] = half_width;
  return row;
}

TEST(TraceJumps, AreFoundAtAThresholdOfTheTraceItself) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 20; ++i) rows.push_back(RowOf(15 + i, 0, i < 12 ? 1e-7 * (1 + i) : 2e-3 + 1e-5 * i));
  for (int i = 1; i < 30; ++i) rows.push_back(RowOf(34 - i, 1, i < 25 ? 2e-3 + 1e-4 * i : 5e-5));
  const TraceJumps found = FindTraceJumps(rows);
  EXPECT_GT(found.threshold, 5e-5);
  EXPECT_LT(found.threshold, 2e-3);
  ASSERT_EQ(found.jumps.size(), 2u);
  EXPECT_EQ(found.jumps[0].kind, TraceJump::Kind::kOnset);
  EXPECT_EQ(found.jumps[0].V, 27);
  EXPECT_EQ(found.jumps[0].before, 26);
  EXPECT_EQ(found.jumps[1].kind, TraceJump::Kind::kDeath);
  EXPECT_EQ(found.jumps[1].V, 9);
  EXPECT_EQ(found.jumps[1].leg, 1u);
  EXPECT_EQ(found.jumps[1].amplitude, 5e-5);
}

TEST(TraceJumps, ATraceOfOneSortHasNone) {
  std::vector<TraceRow> rows;
  for (int i = 0; i < 20; ++i) rows.push_back(RowOf(15 + i, 0, 2e-3 + 1e-4 * i));
  EXPECT_EQ(FindTraceJumps(rows).threshold, 0);
  EXPECT_TRUE(FindTraceJumps(rows).jumps.empty());
  EXPECT_TRUE(FindTraceJumps({}).jumps.empty());
}

TEST(WindowWatch, TakesNoMemory) {
  Integrator integrator(Knives());
  integrator.Start(20, Pushed(20).state);
  WindowWatch watch(Knives());
  watch.Begin(integrator);
  const std::size_t before = CountAllocations();
  for (int i = 0; i < 2000; ++i) {
    integrator.Step(10);
    watch.Add(integrator);
  }
  EXPECT_EQ(CountAllocations() - before, 0u);
}

}  // namespace
}  // namespace uiclink
