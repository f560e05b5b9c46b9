// Runs of the wagon: samples, summaries, how they end, and how they go on.

#include "vehicle/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "data/input_error.h"
#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/spectrum_peaks.h"
#include "vehicle/state_file.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

constexpr Perturbation kPush{.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3};

struct OnTrack {
  Wagon wagon = WagonFixture{}.Make();
  WagonState start = Perturb(wagon, FindEquilibrium(wagon, 20), kPush);
};
const OnTrack& Track() {
  static const OnTrack track;
  return track;
}

SimulationOptions Seconds(double duration) {
  SimulationOptions options;
  options.duration = duration;
  return options;
}

TEST(Simulation, DoesNotDependOnTheOutputRate) {
  const WagonState silent = Simulate(Track().wagon, 20, Track().start, Seconds(4)).state;
  for (double hz : {7.0, 100.0, 3000.0}) {
    SimulationOptions options = Seconds(4);
    options.output_hz = hz;
    options.output_forces = true;
    const SimulationResult result = Simulate(Track().wagon, 20, Track().start, options);
    EXPECT_EQ(result.state.x, silent.x) << hz;
    ASSERT_EQ(result.samples.size(), static_cast<std::size_t>(4 * hz) + 1);
    ASSERT_EQ(result.forces.size(), result.samples.size());
    EXPECT_EQ(result.samples.front().x, Track().start.x);
    EXPECT_EQ(result.samples.back().x, result.state.x);
    EXPECT_DOUBLE_EQ(result.samples[1].t, 1 / hz);
  }
}

TEST(Simulation, ResumedIsUninterruptedBitByBit) {
  const WagonState whole = Simulate(Track().wagon, 20, Track().start, Seconds(6)).state;
  WagonState half = Simulate(Track().wagon, 20, Track().start, Seconds(3)).state;
  const std::string text = FormatState(Track().wagon, {.state = half, .V = 20, .identity = "set1, hand-made"});
  const SavedState read = ParseState(text, "state.txt", Track().wagon, "set1, hand-made");
  EXPECT_EQ(read.V, 20);
  EXPECT_EQ(read.state.t, half.t);
  const SimulationResult rest = Simulate(Track().wagon, 20, read.state, Seconds(3));
  EXPECT_EQ(rest.state.t, whole.t);
  EXPECT_EQ(rest.state.x, whole.x);
  for (std::size_t i = 0; i < kCorners; ++i) {
    EXPECT_EQ(rest.state.links.lateral[i].slides, whole.links.lateral[i].slides);
    EXPECT_EQ(rest.state.links.lateral[i].joints[0].p, whole.links.lateral[i].joints[0].p);
    EXPECT_EQ(rest.state.links.longitudinal[i].C, whole.links.longitudinal[i].C);
  }
}

TEST(Simulation, CheckpointsComeAtTheirTimesAndCanBeResumed) {
  std::vector<WagonState> checkpoints;
  SimulationOptions options = Seconds(2.5);
  options.on_checkpoint = [&](const WagonState& state) { checkpoints.push_back(state); };
  const SimulationResult result = Simulate(Track().wagon, 20, Track().start, options);
  ASSERT_EQ(checkpoints.size(), 3u);
  EXPECT_EQ(checkpoints[0].t, 1);
  EXPECT_EQ(checkpoints[1].t, 2);
  EXPECT_EQ(checkpoints[2].t, 2.5);
  EXPECT_EQ(Simulate(Track().wagon, 20, checkpoints[0], Seconds(1.5)).state.x, result.state.x);
}

TEST(Simulation, SummaryIsWhatDenseSamplesSay) {
  SimulationOptions options = Seconds(20);
  options.window = 5;
  options.output_hz = 2000;
  options.output_forces = true;
  const Wagon& wagon = Track().wagon;
  const SimulationResult result = Simulate(wagon, 20, Track().start, options);
  ASSERT_EQ(result.end, SimulationEnd::kDuration) << result.end_reason;

  double low = 1, high = -1, clearance = 0, peak = 0, least = 1e9;
  int impacts = 0;
  bool touched = false;
  for (std::size_t i = 0; i < result.samples.size(); ++i) {
    const SimulationSample& s = result.samples[i];
    const double d = std::abs(CalcDeflection(wagon, s.x, 2).dy);
    clearance = std::max(clearance, d);
    peak = std::max(peak, std::abs(result.forces[i].guide_y[2] + result.forces[i].guide_y[3]));
    impacts += result.forces[i].guide_y[2] != 0 && !touched;
    touched = result.forces[i].guide_y[2] != 0;
    for (const auto& wheel : result.forces[i].wheels) least = std::min(least, wheel.Q);
    if (s.t < 15) continue;
    low = std::min(low, s.x[kBody + body::kY]);
    high = std::max(high, s.x[kBody + body::kY]);
  }
  const GuidanceUse& rear = result.lateral[1];
  EXPECT_GT(rear.impacts.count, 5);
  EXPECT_EQ(rear.impacts.count, impacts);
  // Half a sample (0.25 ms) beside an extreme of 20 mm at 1 Hz is 2e-8 m; k = 3e6 N/m makes 0.1 N of it.
  EXPECT_NEAR(rear.clearance_used, clearance, 1e-7);
  EXPECT_NEAR(rear.impacts.peak_N, peak, 0.5);
  EXPECT_NEAR(result.motions[static_cast<std::size_t>(TrackedMotion::kBodyLateral)].amplitude, 0.5 * (high - low),
              1e-7);
  EXPECT_NEAR(result.minimum_wheel_load, least, 0.01 * least);  // Hertz vibration goes on between both kinds of samples
  EXPECT_LE(rear.impacts_in_window.count, rear.impacts.count);
  EXPECT_EQ(result.longitudinal[0].impacts.count, 0);
  EXPECT_FALSE(result.wheel_lift);

  // The wheelsets hunt with the body, and along the track twice as fast (both sides do the same).
  const auto& lateral = result.motions[static_cast<std::size_t>(TrackedMotion::kFrontLateral)].frequencies;
  ASSERT_FALSE(lateral.empty());
  EXPECT_NEAR(lateral[0], result.motions[static_cast<std::size_t>(TrackedMotion::kBodyLateral)].frequencies.at(0),
              0.02);
}

TEST(Simulation, DerailmentEndsARunWithWords) {
  WagonState thrown = Perturb(Track().wagon, FindEquilibrium(Track().wagon, 20), {.front_y = 8.5e-3});
  thrown.x[wheelset::kYRate] = 3.0;  // over what is left of the flange
  SimulationOptions options = Seconds(5);
  options.end_at_wheel_lift = false;
  const SimulationResult result = Simulate(Track().wagon, 20, thrown, options);
  EXPECT_EQ(result.end, SimulationEnd::kDerailed);
  EXPECT_TRUE(result.derailed);
  EXPECT_THAT(result.end_reason, HasSubstr("the front wheelset left the track to the left at"));
  EXPECT_LT(result.simulated, 1);
  EXPECT_NEAR(result.state.x[wheelset::kY], FindTrackLimit(Track().wagon.contact), 1e-12);
}

TEST(Simulation, WheelLiftEndsARunWithWords) {
  WagonState thrown = Track().start;
  thrown.x[wheelset::kPhiRate] = 0.2;  // the left wheel goes up
  SimulationOptions options = Seconds(1);
  const SimulationResult result = Simulate(Track().wagon, 20, thrown, options);
  EXPECT_EQ(result.end, SimulationEnd::kWheelLift);
  EXPECT_TRUE(result.wheel_lift);
  EXPECT_THAT(result.end_reason, HasSubstr("the front left wheel lifted off its rail at"));
  StateVector<double> rate;
  WagonForces forces;
  CalcForces(Track().wagon, 20, result.state.links, result.state.x, &rate, &forces);
  EXPECT_NEAR(forces.wheels[0].q, 0, 1e-11);  // bisection to 1e-12 s at 0.2 m/s
  options.end_at_wheel_lift = false;
  EXPECT_EQ(Simulate(Track().wagon, 20, thrown, options).end, SimulationEnd::kDuration);
}

/// What a run says of its window, beside dense samples of the same seconds.
void ExpectWindowOfSamples(const SimulationResult& result, double window) {
  const Wagon& wagon = Track().wagon;
  const double since = result.state.t - window;
  double low = 1, high = -1, used = 0, peak = 0;
  int begun = 0;
  bool touched = false;
  for (std::size_t i = 0; i < result.samples.size(); ++i) {
    const SimulationSample& s = result.samples[i];
    const double guide = result.forces[i].guide_y[2] + result.forces[i].guide_y[3];
    const bool begins = guide != 0 && !touched;
    touched = guide != 0;
    if (s.t < since) continue;
    begun += begins;
    used = std::max(used, std::abs(CalcDeflection(wagon, s.x, 2).dy));
    peak = std::max(peak, std::abs(guide));
    low = std::min(low, s.x[kBody + body::kY]);
    high = std::max(high, s.x[kBody + body::kY]);
  }
  const GuidanceUse& rear = result.lateral[1];
  EXPECT_EQ(rear.impacts_in_window.count, begun);
  // At 0.3 m/s a window that begins or ends between two samples, 50 us apart, is 15 um off.
  EXPECT_NEAR(rear.clearance_used_in_window, used, 15e-6);
  EXPECT_NEAR(rear.impacts_in_window.peak_N, peak, 2 * wagon.guidance.lateral.k * 15e-6);
  if (window < result.simulated) return;
  // Amplitudes know the window's beginning to 5 ms only, unless it is the start of the run.
  EXPECT_NEAR(result.motions[static_cast<std::size_t>(TrackedMotion::kBodyLateral)].amplitude, 0.5 * (high - low),
              15e-6);
}

TEST(Simulation, WindowOfARunThatEndsEarlyIsItsLastSeconds) {
  // The body is thrown against the guidance of the rear wheelset, and a wheel lifts off soon after.
  WagonState thrown = Perturb(Track().wagon, FindEquilibrium(Track().wagon, 20), {.front_y = 4e-3, .rear_y = 4e-3});
  thrown.x[kBody + body::kYRate] = 0.2;
  thrown.x[kBody + body::kPhiRate] = -0.2;
  SimulationOptions options = Seconds(30);  // whose last seconds this run never sees
  options.output_hz = 20000;
  options.output_forces = true;
  int with_impact = 0, without = 0;
  for (const double window : {0.01, 0.05, 0.1, 0.15, 3.0}) {
    SCOPED_TRACE(window);
    options.window = window;
    const SimulationResult result = Simulate(Track().wagon, 20, thrown, options);
    ASSERT_EQ(result.end, SimulationEnd::kWheelLift);
    ASSERT_LT(result.simulated, 0.3);
    EXPECT_EQ(result.lateral[1].impacts.count, 1);
    ++(result.lateral[1].impacts_in_window.count > 0 ? with_impact : without);
    ExpectWindowOfSamples(result, window);
  }
  EXPECT_GT(with_impact, 0);
  EXPECT_GT(without, 0);
}

/// Hunting that dies out: what the guidance took at the start is not what it takes in the window.
TEST(Simulation, WindowForgetsWhatWasBefore) {
  SimulationOptions options = Seconds(40);
  options.window = 2;
  const WagonState pushed = Perturb(Track().wagon, FindEquilibrium(Track().wagon, 5), {.body_y = 25e-3});
  const SimulationResult result = Simulate(Track().wagon, 5, pushed, options);
  ASSERT_EQ(result.end, SimulationEnd::kDuration) << result.end_reason;
  for (const GuidanceUse& use : result.lateral) {
    EXPECT_GT(use.impacts.count, 0);
    EXPECT_GT(use.impacts.peak_N, 0);
    EXPECT_GT(use.clearance_used, 20e-3);
    EXPECT_EQ(use.impacts_in_window.count, 0);
    EXPECT_EQ(use.impacts_in_window.peak_N, 0);
    EXPECT_LT(use.clearance_used_in_window, 20e-3);
    EXPECT_GT(use.clearance_used_in_window, 0);
  }
}

TEST(Simulation, CanBeStopped) {
  SimulationOptions options = Seconds(1000);
  options.on_progress = [](double t) { return t < 1; };
  const SimulationResult result = Simulate(Track().wagon, 20, Track().start, options);
  EXPECT_EQ(result.end, SimulationEnd::kStopped);
  EXPECT_THAT(result.end_reason, HasSubstr("stopped at"));
}

TEST(Simulation, RefusesOptionsOutOfRange) {
  EXPECT_THROW(Simulate(Track().wagon, 20, Track().start, Seconds(-1)), std::invalid_argument);
  SimulationOptions options;
  options.output_hz = -1;
  EXPECT_THROW(Simulate(Track().wagon, 20, Track().start, options), std::invalid_argument);
  options = {};
  options.checkpoint_interval = 0;
  EXPECT_THROW(Simulate(Track().wagon, 20, Track().start, options), std::invalid_argument);
}

TEST(StateFile, WrittenToDiskReadsBackBitByBit) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("uiclink_state_" + std::to_string(::getpid()) + ".txt");
  const SimulationResult run = Simulate(Track().wagon, 20, Track().start, Seconds(2.7));
  const SavedState saved{.state = run.state, .V = 20, .identity = "set1, hand-made"};
  WriteStateFile(path, Track().wagon, saved);
  const SavedState read = ReadStateFile(path, Track().wagon, saved.identity);
  EXPECT_EQ(read.V, saved.V);
  EXPECT_EQ(read.identity, saved.identity);
  EXPECT_EQ(read.state.t, saved.state.t);
  EXPECT_EQ(read.state.x, saved.state.x);
  // Everything of the links is in the text.
  EXPECT_EQ(FormatState(Track().wagon, read), FormatState(Track().wagon, saved));
  // And the run goes on from it as from the state itself.
  EXPECT_EQ(Simulate(Track().wagon, 20, read.state, Seconds(1)).state.x,
            Simulate(Track().wagon, 20, saved.state, Seconds(1)).state.x);
  WriteStateFile(path, Track().wagon, {.state = Track().start, .V = 11, .identity = "again"});  // in its place
  EXPECT_EQ(ReadStateFile(path, Track().wagon, "").V, 11);
  EXPECT_THROW(ReadStateFile(path, Track().wagon, saved.identity), InputError);
  std::filesystem::remove(path);
  EXPECT_THROW(ReadStateFile(path, Track().wagon, ""), InputError);
}

TEST(StateFile, SaysWhatIsWrongAndWhere) {
  const Wagon& wagon = Track().wagon;
  const std::string text = FormatState(wagon, {.state = Track().start, .V = 20, .identity = "a"});
  const auto parse = [&](const std::string& t, const char* identity) { ParseState(t, "run.state", wagon, identity); };
  EXPECT_NO_THROW(parse(text, "a"));
  EXPECT_NO_THROW(parse(text, ""));
  EXPECT_THAT([&] { parse(text, "b"); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("run.state:2: expected a state of the same inputs, 'b', found one of 'a'")));
  EXPECT_THAT([&] { parse("nonsense", "a"); }, testing::ThrowsMessage<InputError>(HasSubstr("run.state:1: expected")));
  EXPECT_THAT([&] { parse(text.substr(0, text.size() / 2), "a"); },
              testing::ThrowsMessage<InputError>(HasSubstr("run.state")));
  std::string more = text;
  more.insert(more.size() - 1, " 0x1p+0");
  EXPECT_THAT([&] { parse(more, "a"); }, testing::ThrowsMessage<InputError>(HasSubstr("expected the end of the line")));
}

TEST(SpectrumPeaks, FindsSinesAndTheirAmplitudes) {
  std::vector<double> samples(2000);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / 200;
    samples[i] =
        7 + 3 * std::sin(2 * std::numbers::pi * 1.043 * t) + 0.5 * std::sin(2 * std::numbers::pi * 4.31 * t + 1);
  }
  const std::vector<SpectrumPeak> peaks = FindSpectrumPeaks(samples, 200, 4);
  ASSERT_EQ(peaks.size(), 2u);
  // 2 % of a line of 0.1 Hz; the parabola through a Hann window's logarithms is off by up to 3 % in height.
  EXPECT_NEAR(peaks[0].frequency, 1.043, 0.002);
  EXPECT_NEAR(peaks[0].amplitude, 3, 0.09);
  EXPECT_NEAR(peaks[1].frequency, 4.31, 0.002);
  EXPECT_NEAR(peaks[1].amplitude, 0.5, 0.015);
  EXPECT_TRUE(FindSpectrumPeaks(std::vector<double>(100, 2.5), 200, 4).empty());
}

}  // namespace
}  // namespace uiclink
