// What chapter 10 of the thesis finds by following the hunting motion down in speed: where it dies, which wheelsets hit
// their guidance, what guidance is for. Beside ours in chapter10.md.

#include <map>
#include <optional>
#include <vector>

#include "tests/validation/chapter10_tables.h"
#include "vehicle/integrator.h"

namespace uiclink::chapter10 {
namespace {

struct Descent {
  double from = 30, to = 8;        // [m/s]
  double step = 0.05;              // [m/s]
  double start = 5e-3;             // both wheelsets aside at the start [m]
  double at_first = 60;            // [s] at the first speed
  std::vector<double> stops = {};  // speeds at which 60 s are run beside the trace
  double lost_below = 10e-6;       // amplitude of the body or of the front wheelset where the motion counts as lost [m]
  TrackedMotion watched = TrackedMotion::kFrontLateral;
};

struct Trace {
  std::optional<double> rear_from, front_from, lost;  // [m/s]
  std::map<double, SimulationResult> stops;
  int longitudinal_impacts = 0;
  bool lateral_impact = false;
};

/// The thesis's bifurcation trace: 5 s at each speed, amplitudes of the last 3 s, on from there (10.1).
Trace FollowDown(const Wagon& wagon, const Descent& descent) {
  Integrator integrator(wagon);
  SimulationOptions options;
  options.end_at_wheel_lift = false;
  options.window = 3;
  options.duration = descent.at_first;
  SimulationResult run = Simulate(
      integrator, descent.from,
      Perturb(wagon, FindEquilibrium(wagon, descent.from), {.front_y = descent.start, .rear_y = descent.start}),
      options);
  Trace trace;
  const int steps = static_cast<int>(std::lround((descent.from - descent.to) / descent.step));
  for (int i = 1; i <= steps; ++i) {
    const double V = descent.from - i * descent.step;
    options.duration = 5;
    run = Simulate(integrator, V, run.state, options);
    trace.longitudinal_impacts += CountLongitudinal(run);
    if (!trace.rear_from && run.lateral[1].impacts_in_window.count > 0) trace.rear_from = V;
    if (!trace.front_from && run.lateral[0].impacts_in_window.count > 0) trace.front_from = V;
    for (double stop : descent.stops) {
      if (std::abs(stop - V) > 1e-9) continue;
      SimulationOptions longer = options;
      longer.duration = 60;
      longer.window = 20;
      trace.stops.emplace(stop, Simulate(integrator, V, run.state, longer));
    }
    if (run.derailed || Motion(run, descent.watched).amplitude < descent.lost_below) {
      trace.lost = V;
      break;
    }
  }
  trace.lateral_impact = trace.rear_from || trace.front_from;
  return trace;
}

void Keep(TraceRow row, Geometry geometry, const std::optional<double>& measured) {
  ASSERT_TRUE(measured.has_value()) << kTrace[row].what;
  chapter10::Keep(kTrace[row], geometry, *measured);
  std::printf("%s: %.3f (theirs %s)\n", kTrace[row].what, *measured, kTrace[row].theirs);
}

void KeepImpacts(Geometry geometry, const Trace& trace) {
  EXPECT_EQ(trace.longitudinal_impacts, 0);
  for (const ImpactRow& row : kImpacts) {
    const auto run = trace.stops.find(row.V);
    ASSERT_NE(run, trace.stops.end()) << row.outcome.what;
    EXPECT_STREQ(NameImpacts(run->second), row.outcome.ours[geometry]) << row.outcome.what;
    std::printf("%s, %s: %s, rear %.2f of 20 mm (theirs: %s)\n", kGeometryNames[geometry], row.outcome.what,
                NameImpacts(run->second), 1e3 * run->second.lateral[1].clearance_used_in_window, row.outcome.theirs);
  }
}

std::vector<double> ImpactSpeeds() {
  std::vector<double> speeds;
  for (const ImpactRow& row : kImpacts) speeds.push_back(row.V);
  return speeds;
}

/// On one of the two geometries that have the published critical speed.
class Chapter10Trace : public testing::TestWithParam<Geometry> {
 protected:
  void KeepTrace(TraceRow row, const std::optional<double>& measured) const { Keep(row, GetParam(), measured); }
};
INSTANTIATE_TEST_SUITE_P(On, Chapter10Trace, testing::Values(kThesisEquivalent, kThesisEquivalentRigid),
                         [](const auto& test) {
                           return std::string(test.param == kThesisEquivalent ? "ThesisEquivalent" : "Rigid");
                         });

TEST_P(Chapter10Trace, SetOneEmpty) {
  const Trace trace = FollowDown(MakeWagon(GetParam(), "set1", "empty"), {.stops = ImpactSpeeds()});
  KeepImpacts(GetParam(), trace);
  KeepTrace(kRearFrom, trace.rear_from);
  KeepTrace(kFrontFrom, trace.front_from);
  KeepTrace(kDies, trace.lost);
  KeepTrace(kPeakToPeak, 2e3 * Motion(trace.stops.at(20), TrackedMotion::kRearLateral).amplitude);
}

TEST_P(Chapter10Trace, SetOneWater) {
  const Trace trace = FollowDown(MakeWagon(GetParam(), "set1", "water"), {.from = 26});
  EXPECT_EQ(trace.longitudinal_impacts, 0);
  KeepTrace(kWaterDies, trace.lost);
}

TEST_P(Chapter10Trace, SetOnePackedFromTheSmallPush) {
  // On the motion with the published lines the body sways by 15 mm, on the one that takes over on rigid contact by 3
  // mm.
  const Trace trace = FollowDown(
      MakeWagon(GetParam(), "set1", "packed"),
      {.from = 24, .start = 1e-4, .at_first = 150, .lost_below = 6e-3, .watched = TrackedMotion::kBodyLateral});
  EXPECT_EQ(trace.longitudinal_impacts, 0);
  KeepTrace(kPackedLost, trace.lost);
}

TEST_P(Chapter10Trace, SetTwoEmptyHitsNothing) {
  const Trace trace = FollowDown(MakeWagon(GetParam(), "set2", "empty"), {.from = 38, .to = 15, .step = 0.1});
  EXPECT_FALSE(trace.lateral_impact);
  EXPECT_EQ(trace.longitudinal_impacts, 0);
  KeepTrace(kSet2Dies, trace.lost);
}

TEST_P(Chapter10Trace, WithoutGuidance) {
  WagonChoice choice = Choice(GetParam(), "set1", "empty");
  choice.options.guidance = false;
  const Wagon wagon = uiclink::MakeWagon(ReadWagonInputs(choice));
  for (const auto& [V, row] : {std::pair(20.0, 2), std::pair(19.0, 3), std::pair(15.0, 4)}) {
    const WagonState start = Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = 5e-3, .rear_y = 5e-3});
    SimulationOptions options;
    options.duration = 200;
    const SimulationResult run = Simulate(wagon, V, start, options);
    // The axle boxes go to 28 mm and less where the motion does not grow, to 55 mm where it does.
    const bool grows = run.wheel_lift || run.lateral[1].clearance_used_in_window > 40e-3;
    const char* what = !grows ? "no" : run.wheel_lift ? "until a wheel lifts" : "no wheel lifts";
    EXPECT_STREQ(what, kOtherOutcomes[row].ours[GetParam()]) << run.end_reason;
    std::printf("%s: %s, smallest wheel load %.1f kN, %.1f mm\n", kOtherOutcomes[row].what, what,
                1e-3 * run.minimum_wheel_load, 1e3 * run.lateral[1].clearance_used_in_window);
  }
}

TEST(Chapter10, SetOneEmptyFollowedDownOnNominalGeometry) {
  const Trace trace = FollowDown(MakeWagon(kNominal, "set1", "empty"), {.from = 21, .to = 4, .stops = ImpactSpeeds()});
  KeepImpacts(kNominal, trace);
  EXPECT_FALSE(trace.lateral_impact);
  Keep(kDies, kNominal, trace.lost);
}

TEST(Chapter10, HuntingFrequenciesOnTheOtherGeometries) {
  for (const HuntingRow& row : kHunting) {
    for (Geometry geometry : {kThesisEquivalentRigid, kNominal}) {
      const SimulationResult run = SimulateHunting(row, geometry);
      EXPECT_EQ(run.end, SimulationEnd::kDuration) << run.end_reason;
      EXPECT_EQ(CountLongitudinal(run), 0);
      chapter10::Keep(row.lateral, geometry, HighestLine(run, TrackedMotion::kBodyLateral));
      if (geometry == kThesisEquivalentRigid)
        chapter10::Keep(row.longitudinal, geometry, LowestLine(run, TrackedMotion::kFrontLongitudinal));
    }
  }
}

TEST(Chapter10, NothingIsHitAtFortyMetresPerSecond) {
  for (Geometry geometry : kAllGeometries) {
    const Wagon wagon = MakeWagon(geometry, "set1", "empty");
    SimulationOptions options;
    options.window = 20;
    const WagonState start = Perturb(wagon, FindEquilibrium(wagon, 40), {.front_y = 5e-3, .rear_y = 5e-3});
    const SimulationResult run = Simulate(wagon, 40, start, options);
    EXPECT_STREQ(NameImpacts(run), kOtherOutcomes[0].ours[geometry]);
    EXPECT_EQ(CountLongitudinal(run), 0);
  }
}

}  // namespace
}  // namespace uiclink::chapter10
