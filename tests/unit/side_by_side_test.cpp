// Runs side by side: the results of Simulate(), whatever runs beside them.

#include "vehicle/side_by_side.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

std::shared_ptr<const Wagon> MakeWagon(Suspension suspension = Suspension::kParabolic,
                                       const std::string& freight = "empty") {
  WagonFixture fixture;
  fixture.freight = freight;
  fixture.options.suspension = suspension;
  return std::make_shared<const Wagon>(fixture.Make());
}
const std::shared_ptr<const Wagon>& Empty() {
  static const std::shared_ptr<const Wagon> wagon = MakeWagon();
  return wagon;
}

SimulationTask MakeTask(const std::shared_ptr<const Wagon>& wagon, double V, double duration) {
  SimulationTask task{
      .wagon = wagon,
      .V = V,
      .start = Perturb(*wagon, FindEquilibrium(*wagon, V), {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3}),
      .options = {},
      .on_end = nullptr};
  task.options.duration = duration;
  return task;
}

/// Hunting of different wagons, at different speeds, for different times: seven runs in four lanes.
std::vector<SimulationTask> MakeTasks() {
  const auto water = MakeWagon(Suspension::kParabolic, "water");
  std::vector<SimulationTask> tasks;
  for (int i = 0; i < 7; ++i)
    tasks.push_back(MakeTask(i % 3 == 2 ? water : Empty(), 20 + 0.5 * i, 1.5 + 0.7 * (i % 4)));
  tasks[1].options.output_hz = 50;
  tasks[1].options.output_forces = true;
  return tasks;
}

template <typename T>
void ExpectSameBytes(const T& a, const T& b, const std::string& what) {
  EXPECT_EQ(std::memcmp(&a, &b, sizeof a), 0) << what;
}

/// All figures, bit by bit.
void ExpectSame(const SimulationResult& a, const SimulationResult& b) {
  EXPECT_EQ(a.end, b.end);
  EXPECT_EQ(a.end_reason, b.end_reason);
  EXPECT_EQ(a.state.t, b.state.t);
  ExpectSameBytes(a.state.x, b.state.x, "state");
  ExpectSameBytes(a.counts, b.counts, "counts");
  EXPECT_EQ(a.minimum_wheel_load, b.minimum_wheel_load);
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    EXPECT_EQ(a.motions[i].amplitude, b.motions[i].amplitude) << kMotionNames[i];
    EXPECT_EQ(a.motions[i].frequencies, b.motions[i].frequencies) << kMotionNames[i];
  }
  for (std::size_t i = 0; i < kAxles; ++i) {
    EXPECT_EQ(a.lateral[i].clearance_used, b.lateral[i].clearance_used);
    EXPECT_EQ(a.lateral[i].impacts.peak_N, b.lateral[i].impacts.peak_N);
    EXPECT_EQ(a.lateral[i].impacts.count, b.lateral[i].impacts.count);
  }
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) ExpectSameBytes(a.samples[i], b.samples[i], "sample");
}

/// A wagon whose axle boxes hit their guides at every turn: 8 mm and 4 mm of clearance.
std::shared_ptr<const Wagon> MakeTightWagon(Suspension suspension) {
  WagonFixture fixture;
  fixture.options.suspension = suspension;
  WagonData data = fixture.ReadData();
  data.guidance.lateral.clearance = 8e-3;
  data.guidance.longitudinal.clearance = 4e-3;
  const CornerLinks links = fixture.ReadLinks();
  return std::make_shared<const Wagon>(data, fixture.ReadBody(), false, std::array{links, links, links, links},
                                       MakeHandMadeTable(), fixture.options);
}

/// 4 s of hunting with impacts. Both engines have errors of some 1e-6 of the amplitude (tests/bench), and were found to
/// differ by 4e-7 of amplitudes and peaks of force. The least wheel load is that at the ends of steps, which are others
/// (found: 8e-5), and so is their number (1 %).
TEST(SideBySide, ResultsAreThoseOfSimulate) {
  for (const Suspension suspension : {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf}) {
    const auto wagon = MakeTightWagon(suspension);
    std::vector<SimulationTask> tasks;
    for (int i = 0; i < 5; ++i) tasks.push_back(MakeTask(wagon, 24 + i, 4));
    tasks[0].options.output_hz = 20;
    tasks[0].options.output_forces = true;
    const std::vector<SimulationResult> results = SimulateSideBySide(tasks);
    int impacts = 0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      const SimulationResult one = Simulate(*wagon, tasks[i].V, tasks[i].start, tasks[i].options);
      const SimulationResult& lane = results[i];
      SCOPED_TRACE(testing::Message() << "run " << i << " suspension " << static_cast<int>(suspension));
      ASSERT_EQ(lane.end, one.end) << lane.end_reason << " / " << one.end_reason;
      EXPECT_EQ(lane.V, one.V);
      EXPECT_NEAR(lane.simulated, one.simulated, 1e-6);
      for (std::size_t m = 0; m < kMotionCount; ++m) {
        EXPECT_NEAR(lane.motions[m].amplitude, one.motions[m].amplitude, 5e-6 * one.motions[m].amplitude + 1e-9)
            << kMotionNames[m];
      }
      for (std::size_t axle = 0; axle < kAxles; ++axle) {
        EXPECT_EQ(lane.lateral[axle].impacts.count, one.lateral[axle].impacts.count);
        EXPECT_EQ(lane.longitudinal[axle].impacts.count, one.longitudinal[axle].impacts.count);
        EXPECT_NEAR(lane.lateral[axle].impacts.peak_N, one.lateral[axle].impacts.peak_N,
                    1e-5 * one.lateral[axle].impacts.peak_N);
        impacts += one.lateral[axle].impacts.count;
      }
      EXPECT_NEAR(lane.minimum_wheel_load, one.minimum_wheel_load, 1e-3 * std::abs(one.minimum_wheel_load));
      EXPECT_NEAR(static_cast<double>(lane.counts.steps), static_cast<double>(one.counts.steps),
                  0.05 * static_cast<double>(one.counts.steps));
      ASSERT_EQ(lane.samples.size(), one.samples.size());
      ASSERT_EQ(lane.forces.size(), one.forces.size());
      for (std::size_t n = 0; n < one.samples.size(); ++n) {
        EXPECT_EQ(lane.samples[n].t, one.samples[n].t);
        EXPECT_NEAR(lane.samples[n].x[kBody + body::kY], one.samples[n].x[kBody + body::kY], 5e-8);
      }
    }
    EXPECT_GT(impacts, 50);
  }
}

TEST(SideBySide, ARunDoesNotDependOnWhatRunsBesideIt) {
  std::vector<SimulationTask> tasks = MakeTasks();
  const std::vector<SimulationResult> together = SimulateSideBySide(tasks);
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(SimulateSideBySide({tasks[i]})[0], together[i]);
  }
  std::ranges::reverse(tasks);
  const std::vector<SimulationResult> backwards = SimulateSideBySide(tasks);
  for (std::size_t i = 0; i < tasks.size(); ++i) ExpectSame(backwards[tasks.size() - 1 - i], together[i]);
}

TEST(SideBySide, AnEmptyLaneTakesTheNextRun) {
  // One long run and many short ones: the short ones pass it on the other lanes.
  std::vector<SimulationTask> tasks{MakeTask(Empty(), 21, 4)};
  for (int i = 0; i < 8; ++i) tasks.push_back(MakeTask(Empty(), 22, 0.25));
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < tasks.size(); ++i)
    tasks[i].on_end = [&order, i](const SimulationResult& result) {
      order.push_back(i);
      EXPECT_GT(result.wall_s, 0);
    };
  SimulateSideBySide(tasks);
  ASSERT_EQ(order.size(), tasks.size());
  EXPECT_EQ(order.back(), 0u);
}

TEST(SideBySide, GoesOnWithWhatARunHasLeft) {
  // 2 s after 2 s, by a queue that grows, are 4 s bit by bit.
  std::vector<SimulationTask> queue{MakeTask(Empty(), 20, 2)};
  SimulationResult last;
  queue[0].on_end = [&](const SimulationResult& half) {
    SimulationTask rest = MakeTask(Empty(), 20, 2);
    rest.start = half.state;
    rest.on_end = [&](const SimulationResult& result) { last = result; };
    queue.push_back(rest);
  };
  SimulateSideBySide([&]() -> std::optional<SimulationTask> {
    if (queue.empty()) return std::nullopt;
    SimulationTask task = queue.back();
    queue.pop_back();
    return task;
  });
  const SimulationResult whole = SimulateSideBySide({MakeTask(Empty(), 20, 4)})[0];
  EXPECT_EQ(last.state.t, whole.state.t);
  ExpectSameBytes(last.state.x, whole.state.x, "state");
}

TEST(SideBySide, RunsThatEndEarlyLeaveTheOthersRunning) {
  const auto lost = [&] {  // pushed over the flange
    SimulationTask task = MakeTask(Empty(), 20, 5);
    task.start = Perturb(*Empty(), FindEquilibrium(*Empty(), 20), {.front_y = 8.5e-3});
    task.start.x[wheelset::kYRate] = 3;
    task.options.end_at_wheel_lift = false;
    return task;
  }();
  const auto lifted = [&] {
    SimulationTask task = MakeTask(Empty(), 20, 5);
    task.start.x[wheelset::kPhiRate] = 0.2;
    return task;
  }();
  auto stopped = MakeTask(Empty(), 20, 1e4);
  stopped.options.on_progress = [](double t) { return t < 0.5; };
  const SimulationTask whole = MakeTask(Empty(), 20, 1);
  const std::vector<SimulationResult> results = SimulateSideBySide({lost, lifted, stopped, whole, lifted});
  EXPECT_EQ(results[0].end, SimulationEnd::kDerailed);
  EXPECT_TRUE(results[0].derailed);
  EXPECT_THAT(results[0].end_reason, HasSubstr("left the track"));
  EXPECT_EQ(results[1].end, SimulationEnd::kWheelLift);
  EXPECT_THAT(results[1].end_reason, HasSubstr("lifted off its rail"));
  EXPECT_LT(results[1].simulated, 1);
  ExpectSame(results[4], results[1]);
  EXPECT_EQ(results[2].end, SimulationEnd::kStopped);
  EXPECT_LT(results[2].simulated, 1e4);
  EXPECT_EQ(results[3].end, SimulationEnd::kDuration);
  EXPECT_EQ(results[3].state.t, 1);
  for (std::size_t i : {0, 1}) {
    const SimulationTask& task = i == 0 ? lost : lifted;
    const SimulationResult one = Simulate(*task.wagon, task.V, task.start, task.options);
    EXPECT_EQ(one.end, results[i].end);
    EXPECT_EQ(one.end_reason, results[i].end_reason);
    EXPECT_NEAR(one.simulated, results[i].simulated, 1e-6);
  }
}

TEST(SideBySide, WhatGivesUpOrCannotBeginIsAFailedRun) {
  SimulationTask impossible = MakeTask(Empty(), 20, 1), backwards = impossible, endless = impossible;
  impossible.options.integrator.tolerance = 1e-30;
  backwards.V = -20;
  endless.options.duration = -1;
  const SimulationTask whole = MakeTask(Empty(), 20, 1);
  const std::vector<SimulationResult> results =
      SimulateSideBySide({impossible, backwards, endless, whole, whole, whole, whole});
  EXPECT_THAT(results[0].end_reason, HasSubstr("the integration stopped at "));
  EXPECT_THAT(results[1].end_reason, HasSubstr("speed"));
  EXPECT_THAT(results[2].end_reason, HasSubstr("duration"));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(results[i].end, SimulationEnd::kFailed);
  for (std::size_t i = 3; i < results.size(); ++i) EXPECT_EQ(results[i].state.t, 1);
}

TEST(SideBySide, WhatLanesCannotDoIsDoneBySimulate) {
  WagonFixture fixture;
  fixture.options.penetration = Penetration::kPrinted;
  SimulationTask printed = MakeTask(std::make_shared<const Wagon>(fixture.Make()), 20, 1);
  SimulationTask other_pair = MakeTask(Empty(), 20, 1);
  other_pair.options.integrator.method = "UICLINK_STABLE_7_3_4";
  const std::vector<SimulationResult> results =
      SimulateSideBySide({MakeTask(Empty(), 20, 1), printed, other_pair, MakeTask(Empty(), 20, 1)});
  ExpectSame(results[1], Simulate(*printed.wagon, 20, printed.start, printed.options));
  ExpectSame(results[2], Simulate(*Empty(), 20, other_pair.start, other_pair.options));
  ExpectSame(results[3], results[0]);
}

TEST(SideBySide, SpringsOfDifferentKindsTakeTurns) {
  const std::array<std::shared_ptr<const Wagon>, 3> wagons{MakeWagon(Suspension::kLinear), Empty(),
                                                           MakeWagon(Suspension::kLeaf)};
  std::vector<SimulationTask> tasks;
  for (std::size_t i = 0; i < 24; ++i) tasks.push_back(MakeTask(wagons[i % 3], 20, 0.2));
  const std::vector<SimulationResult> results = SimulateSideBySide(tasks);
  for (std::size_t i = 0; i < results.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(results[i], SimulateSideBySide({tasks[i % 3]})[0]);
  }
}

TEST(SideBySide, CheckpointsComeAtTheirTimes) {
  std::vector<double> times;
  SimulationTask task = MakeTask(Empty(), 20, 2.5);
  task.options.on_checkpoint = [&](const WagonState& state) { times.push_back(state.t); };
  SimulateSideBySide({task, MakeTask(Empty(), 21, 0.3)});
  EXPECT_EQ(times, (std::vector<double>{1, 2, 2.5}));
}

}  // namespace
}  // namespace uiclink
