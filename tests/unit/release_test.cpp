#include "identify/release.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "identify/noise.h"
#include "tests/unit/pushed_record.h"

namespace uiclink {
namespace {

constexpr double kMm = 1e-3;

Oscillator<double> Lateral() {
  Oscillator<double> link;
  link.k = 3.41;
  link.Add({2.21, 0.018});
  return link;
}

Oscillator<double> Longitudinal() {
  Oscillator<double> link;
  link.k = 5.5;
  for (const Slider<double>& slider : {Slider<double>{1.55, 0.0044}, {1.20, 0.0052}, {0.95, 0.0050}, {0.65, 0.0038}})
    link.Add(slider);
  return link;
}

/// The experiment of the thesis: noise and 12-bit steps over +-32 mm, sensor zero off by some mm.
PushedRecord LateralSetup(unsigned seed) {
  return {.link = Lateral(),
          .rest_s = 0.4 + 0.0017 * (seed % 7),
          .push = 0.0268,
          .half_swings = 5,
          .release_phase = 1.3,
          .side = seed % 2 ? 1.0 : -1.0,
          .zero = (seed % 5 - 2.0) * kMm,
          .noise = 0.0122 * kMm,
          .quantum = 64 * kMm / 4096,
          .range = 32 * kMm,
          .seed = seed};
}

PushedRecord LongitudinalSetup(unsigned seed) {
  PushedRecord setup = LateralSetup(seed);
  setup.link = Longitudinal();
  setup.push = 0.0315;
  setup.half_swings = 7;
  return setup;
}

Phases Find(const Record& record) { return FindPhases(record, EstimateNoise(record.t, record.y)); }

/// The reason of a record that must not be usable.
std::string Reason(const Record& record) {
  const Phases phases = Find(record);
  EXPECT_FALSE(phases.usable);
  return phases.reason;
}

/// A record from displacements [m], with noise.
Record FromDisplacements(const std::vector<double>& y, double rate_hz = 200, double noise = 0.013 * kMm) {
  PushedRecord setup{.link = Lateral()};
  setup.rate_hz = rate_hz;
  setup.noise = noise;
  return Measure(setup, y);
}

/// Free motion from the extremum y0, from time `from` on.
std::vector<double> FreeDecay(const Oscillator<double>& link, double y0, double from, double duration,
                              double rate_hz = 200) {
  Trajectory<double> run;
  EXPECT_EQ(Solve(link, AtExtremum(link, y0), from + duration, &run), SolveStatus::kOk);
  std::vector<double> y;
  for (double t = from; t <= from + duration; t += 1 / rate_hz) y.push_back(run.y(t));
  return y;
}

/// Part of a record.
Record Cut(const Record& record, double from_s, double to_s, std::size_t keep_every = 1) {
  Record part = record;
  part.t.clear();
  part.y.clear();
  for (std::size_t i = 0; i < record.t.size(); i += keep_every)
    if (record.t[i] >= from_s && record.t[i] <= to_s) part.t.push_back(record.t[i]), part.y.push_back(record.y[i]);
  part.sampling_hz = record.sampling_hz / static_cast<double>(keep_every);
  return part;
}

class PushedRingDown : public testing::TestWithParam<unsigned> {
 protected:
  void Check(const PushedRecord& setup) {
    const SimulatedRecord truth = Simulate(setup);
    const Phases phases = Find(truth.record);
    ASSERT_TRUE(phases.usable) << phases.reason;
    // Rest: less a tenth for a soft start, and the mean within four of its own standard deviations (a step of the
    // converter may hide a twentieth of it).
    EXPECT_LE(static_cast<double>(phases.rest_size), setup.rest_s * setup.rate_hz + 1);
    EXPECT_GE(static_cast<double>(phases.rest_size), 0.85 * setup.rest_s * setup.rate_hz);
    EXPECT_NEAR(phases.rest_level, setup.zero, 4 * truth.noise / std::sqrt(phases.rest_size) + 0.05 * setup.quantum);
    // Release: 3.3 ms rms on 400 records of each kind, 11 ms at most: three samples.
    EXPECT_NEAR(phases.release_s, truth.release_s, 0.015);
    ASSERT_GE(phases.extrema.size(), 10u);
    for (std::size_t i = 0; i < 10; ++i) {
      // Value: 1.5 sigma/sqrt(33 samples) = 3.5 um, here five of them (200 are compared) and 1 um of the fit's bias.
      // Time: sigma sqrt(3/33)/(80 ms w^2 A) is 0.1 ms at 10 mm, and 0.12 ms of bias where joints stop sliding.
      const double amplitude = std::abs(truth.extremum_y[i]);
      EXPECT_NEAR(phases.extrema[i].y - setup.zero, truth.extremum_y[i], 18.5e-6) << i;
      EXPECT_NEAR(phases.extrema[i].t, truth.extremum_t[i], 0.12e-3 + 5 * 0.1e-3 * 0.010 / amplitude) << i;
    }
    EXPECT_EQ(phases.fit_start, static_cast<std::size_t>(std::ceil(phases.extrema[0].t * setup.rate_hz)));
    EXPECT_FALSE(phases.clipped);
  }
};

TEST_P(PushedRingDown, LateralIsTakenApart) { Check(LateralSetup(GetParam())); }
TEST_P(PushedRingDown, LongitudinalIsTakenApart) { Check(LongitudinalSetup(GetParam())); }

INSTANTIATE_TEST_SUITE_P(Seeds, PushedRingDown, testing::Range(1u, 11u));

TEST(FindPhases, FindsWhereTheJointsOnlyRoll) {
  // k1 < k: the amplitude tends to T0/k1 = 8.14 mm, from above by a factor (k - k1)/(k + k1) = 0.21 each half swing.
  const Phases phases = Find(Simulate(LateralSetup(3)).record);
  ASSERT_TRUE(phases.usable);
  ASSERT_LT(phases.rolling_start, phases.extrema.size());
  const double limit = 0.018 / 2.21, at_start = std::abs(phases.extrema[phases.rolling_start].y - phases.centre);
  EXPECT_GT(at_start, limit);
  EXPECT_LT(at_start, 1.1 * limit);  // 10 % of the strongest loss, 12 mm, leave 0.3-0.8 mm to lose
  // Two extrema of 4 um each; after ten periods nothing is left of the excess.
  EXPECT_NEAR(phases.late_amplitude, limit, 15e-6);
  EXPECT_NEAR(phases.centre, (3 % 5 - 2.0) * kMm, 15e-6);
}

TEST(FindPhases, IgnoresAZeroThatIsFarOffAndDrifts) {
  PushedRecord setup = LateralSetup(4);
  const Phases plain = Find(Simulate(setup).record);
  setup.zero -= 5 * kMm;
  setup.drift = 20e-6;  // 0.3 mm in all
  const Phases shifted = Find(Simulate(setup).record);
  ASSERT_TRUE(plain.usable && shifted.usable);
  ASSERT_EQ(shifted.extrema.size(), plain.extrema.size());
  EXPECT_EQ(shifted.rolling_start, plain.rolling_start);
  // The readings fall on other steps of the converter: two estimates with the errors given above.
  EXPECT_NEAR(shifted.release_s, plain.release_s, 0.015);
  EXPECT_NEAR(shifted.extrema[0].y - plain.extrema[0].y, -5 * kMm + 20e-6 * plain.extrema[0].t, 25e-6);
}

TEST(FindPhases, DoesNotStartAtALargestExtremumThatIsStillPushed) {
  // The hand goes on through one more half swing, against the friction but not all of it: the amplitude falls already,
  // by a sixth of what it should.
  PushedRecord setup = LateralSetup(5);
  setup.late_push = 0.015;
  const SimulatedRecord truth = Simulate(setup);
  const Phases phases = Find(truth.record);
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 0.5e-3);
  EXPECT_NEAR(phases.extrema[0].y - setup.zero, truth.extremum_y[0], 18.5e-6);
  EXPECT_NEAR(phases.release_s, truth.release_s, 0.02);
}

TEST(FindPhases, TakesARecordThatStartsInFreeMotion) {
  for (const double from : {0.1, 0.25, 0.4}) {  // stuck, sliding, shortly before the extremum at 0.52 s
    const Phases phases = Find(FromDisplacements(FreeDecay(Lateral(), -25 * kMm, from, 12)));
    ASSERT_TRUE(phases.usable) << phases.reason;
    EXPECT_EQ(phases.rest_size, 0u);
    EXPECT_EQ(phases.release_s, 0.0);
    const HalfCycle half = CalcHalfCycle(Lateral(), 25 * kMm);
    EXPECT_NEAR(phases.extrema[0].y, half.next_amplitude, 18.5e-6);
    EXPECT_NEAR(phases.extrema[0].t, half.duration - from, 0.5e-3);
  }
}

TEST(FindPhases, DoesNotTakeAHandThatHoldsForRest) {
  std::vector<double> y(600, -25 * kMm);  // held for three periods
  const std::vector<double> free = FreeDecay(Lateral(), -25 * kMm, 0, 12);
  y.insert(y.end(), free.begin(), free.end());
  PushedRecord sensor{.link = Lateral()};
  for (const double quantum : {0.0, 0.05 * kMm}) {  // coarse steps and little noise: held readings are all the same
    sensor.quantum = quantum;
    sensor.noise = quantum > 0 ? 0.001 * kMm : 0.013 * kMm;
    const Phases phases = Find(Measure(sensor, y));
    ASSERT_TRUE(phases.usable) << phases.reason;
    EXPECT_EQ(phases.rest_size, 0u);
    // From rest the reading leaves five noise levels, or a step and a half, after sqrt(2 * 75 um / 0.8 m/s^2) = 14 ms.
    EXPECT_NEAR(phases.release_s, 3.0, 0.02);
    // 14 um of rounding do as noise does.
    EXPECT_NEAR(phases.extrema[0].y, CalcHalfCycle(Lateral(), 25 * kMm).next_amplitude, 18.5e-6);
  }
}

TEST(FindPhases, StopsCountingExtremaWhenTheMotionHasStopped) {
  // A nearly rigid slider: the amplitude falls by 2 T0/k = 3 mm each half swing until it stops off centre.
  Oscillator<double> link;
  link.k = 4;
  link.Add({4000, 0.006});
  const Phases phases = Find(FromDisplacements(FreeDecay(link, 31 * kMm, 0.2, 14)));
  ASSERT_TRUE(phases.usable) << phases.reason;
  ASSERT_EQ(phases.extrema.size(), 9u);  // 28, 25, ... 4 mm; at 1 mm T0 holds it, and nothing turns
  for (std::size_t i = 0; i < 9; ++i)    // 2 T0/k1 = 3 um each half swing is the slider's own give
    EXPECT_NEAR(std::abs(phases.extrema[i].y), (28 - 3.0 * static_cast<double>(i)) * kMm, 18.5e-6 + 3e-6 * 10) << i;
  EXPECT_EQ(phases.rolling_start, phases.extrema.size());
}

TEST(FindPhases, TakesAMotionThatNeverSlides) {
  PushedRecord setup = LateralSetup(6);
  setup.push = 0.0025;
  const Phases phases = Find(Simulate(setup).record);
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_LT(phases.late_amplitude, 0.018 / 2.21);
  EXPECT_EQ(phases.rolling_start, 0u);
}

TEST(FindPhases, TakesFastAndLongRecords) {
  PushedRecord setup = LateralSetup(7);
  setup.rate_hz = 1000;
  setup.duration_s = 55;
  const SimulatedRecord truth = Simulate(setup);
  const Phases phases = Find(truth.record);
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_NEAR(phases.release_s, truth.release_s, 0.010);  // more samples than at 200 Hz
  EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 0.3e-3);
  EXPECT_EQ(phases.extrema.size(), truth.extremum_t.size());
}

TEST(FindPhases, TakesTwelveSamplesAPeriod) {
  // 200 Hz and a shortest period of 0.845 s: every 14th sample leaves 12.1 a period.
  const Phases phases = Find(Cut(Simulate(LateralSetup(8)).record, 0, 15, 14));
  EXPECT_TRUE(phases.usable) << phases.reason;
}

struct RealRecord {
  const char* file;
  double first_t_s, first_mm;  // first sample at the first extremum, read off the file
  std::size_t extrema;         // counted in the file
};

class RealDecay : public testing::TestWithParam<RealRecord> {};

// Measured free decays of other friction oscillators; the hand is off before the record starts.
TEST_P(RealDecay, IsFreeFromTheFirstSample) {
  const std::filesystem::path file = std::filesystem::path(UICLINK_SOURCE_DIR) / "../shared/real" / GetParam().file;
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is not there";
  const Phases phases = Find(ReadRecord(file));
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_EQ(phases.rest_size, 0u);
  EXPECT_EQ(phases.release_s, 0.0);
  EXPECT_EQ(phases.extrema.size(), GetParam().extrema);
  EXPECT_NEAR(phases.extrema[0].t, GetParam().first_t_s, 0.010);  // tops are flat for 15 ms
  EXPECT_NEAR(phases.extrema[0].y / kMm, GetParam().first_mm, 0.002 * std::abs(GetParam().first_mm));
  for (std::size_t i = 0; i + 2 < phases.extrema.size(); ++i)
    EXPECT_GT(std::abs(phases.extrema[i].y - phases.extrema[i + 1].y),
              std::abs(phases.extrema[i + 1].y - phases.extrema[i + 2].y))
        << i;
}

INSTANTIATE_TEST_SUITE_P(Files, RealDecay,
                         testing::Values(RealRecord{"pendulum_small_swing.txt", 0.340, 66.60, 14},
                                         RealRecord{"pendulum_large_swing.txt", 0.440, 1624.5, 133},
                                         RealRecord{"rotary_pendulum_01.txt", 0.232, -135.82, 15},
                                         RealRecord{"rotary_pendulum_02.txt", 0.129, -157.36, 15},
                                         RealRecord{"rotary_pendulum_03.txt", 0.124, -63.91, 17}),
                         [](const auto& file) {
                           const std::string name = file.param.file;
                           return name.substr(0, name.size() - 4);
                         });

TEST(UnusableRecord, IsSampledTooCoarsely) {
  const Record record = Simulate(LateralSetup(8)).record;
  EXPECT_EQ(Reason(Cut(record, 0, 15, 20)), "expected at least 12 samples in a period, found 8.4; sample faster");
}

TEST(UnusableRecord, HasTwoSamplesAPeriod) {
  // What is left looks like noise, and is called so.
  EXPECT_EQ(
      Reason(Cut(Simulate(LateralSetup(8)).record, 0, 15, 84)),
      "expected a ring-down with at least 12 samples in a period, found readings that jump like noise within 45.9 mm, "
      "3.0 samples from peak to peak; sample faster, or check sensor and column");
}

TEST(UnusableRecord, HasTooFewExtrema) {
  const SimulatedRecord truth = Simulate(LateralSetup(9));
  EXPECT_EQ(Reason(Cut(truth.record, 0, truth.extremum_t[2] + 0.2)),
            "expected at least 5 extrema after the push, found 3 from 2.63 s on; let go and record for longer");
  EXPECT_EQ(Reason(FromDisplacements(FreeDecay(Lateral(), 25 * kMm, 0.3, 1.6))),
            "expected at least 5 extrema of a free decay, found 3; record for longer");
}

TEST(UnusableRecord, IsDrivenAllTheTime) {
  std::vector<double> y;
  for (int i = 0; i <= 3000; ++i) y.push_back(12.3 * kMm * std::sin(6.5 * i / 200.0));
  EXPECT_EQ(
      Reason(FromDisplacements(y)),
      "expected a free decay, found the same amplitude of 12.30 mm from the first extremum to the last; record the "
      "motion after letting go");
}

TEST(UnusableRecord, IsPushedToTheEnd) {
  const SimulatedRecord truth = Simulate(LateralSetup(10));
  EXPECT_EQ(Reason(Cut(truth.record, 0, truth.release_s)),
            "expected at least 5 extrema after the push, found 2 from 1.66 s on; let go and record for longer");
}

TEST(CutRecord, IsUsedAndSaysHowMuchIsCut) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    PushedRecord setup = LateralSetup(seed);
    setup.zero = 0;
    setup.range = 19 * kMm;  // cuts the end of the push and the first two free extrema (26 and 19.4 mm)
    const SimulatedRecord truth = Simulate(setup);
    const Phases phases = Find(truth.record);
    ASSERT_TRUE(phases.usable) << phases.reason;
    EXPECT_TRUE(phases.clipped && phases.extrema[0].cut && !phases.extrema[2].cut);
    EXPECT_GE(phases.cut_count, 1u);  // the flat part of the second is hardly longer than a round one's
    EXPECT_LE(phases.cut_count, 2u);
    EXPECT_NEAR(std::abs(phases.cut_level), setup.range, setup.quantum / 2);
    // Half of 0.2 s that are flat, times the share by which sticking (w^2 + 65 %) comes down sooner than sliding: 10 ms
    // to fourth order, and half a sample from the ends of the flat part.
    EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 0.0125) << seed;
    EXPECT_NEAR(phases.extrema[2].t, truth.extremum_t[2], 0.5e-3) << seed;
    EXPECT_LT(phases.release_s, phases.extrema[0].t) << seed;
    EXPECT_NE(DescribeCut(phases).find(" cut flat at "), std::string::npos) << DescribeCut(phases);
  }
}

TEST(CutRecord, IsUsedWhenOnlyItsLargestExtremaAreCut) {
  PushedRecord setup = LateralSetup(12);
  setup.zero = 0;
  setup.range = 23 * kMm;  // cuts the last pushed extremum, too, at the other side
  const SimulatedRecord truth = Simulate(setup);
  const Phases phases = Find(truth.record);
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_EQ(phases.cut_count, 1u);
  EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 0.010);  // as above, a fourth of it
  EXPECT_EQ(DescribeCut(phases).find("1 extremum is cut flat at -23.00 mm, the last at 2.6"), 0u)
      << DescribeCut(phases);
}

TEST(CutRecord, IsNotUsedWhereHardlyAnyExtremumIsLeft) {
  PushedRecord setup = LateralSetup(12);
  setup.zero = 0;
  setup.range = 7 * kMm;  // below the 8.1 mm at which it rolls for ever
  EXPECT_EQ(Reason(Simulate(setup).record).find("expected a free decay within the sensor's range, found "), 0u);
}

TEST(FindPhases, TellsAPushFromHeavyFriction) {
  // One or two half swings slide, the mass stops within them, and the last pushed swing is the largest.
  Oscillator<double> heavy;
  heavy.k = 2.6;
  heavy.Add({9, 0.0225});
  for (unsigned seed = 1; seed <= 20; ++seed) {
    PushedRecord setup = LateralSetup(seed);
    setup.link = heavy;
    setup.push = 0.037 + 0.0001 * seed;
    setup.release_phase = 0.9;
    const SimulatedRecord truth = Simulate(setup);
    const Phases phases = Find(truth.record);
    ASSERT_TRUE(phases.usable) << phases.reason;
    // The bias of the fit's window goes with k1: 0.12 ms * 9/2.21, and 1.4 for the wider window; 0.2 ms of noise.
    EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 1e-3) << seed;
  }
}

TEST(FindPhases, TellsAPushFromAStop) {
  // The first extremum runs into a stop that gives back what it takes: the next one is larger than the law says.
  const HalfCycle half = CalcHalfCycle(Lateral(), 29 * kMm);
  std::vector<double> y = FreeDecay(Lateral(), 29 * kMm, 0, 12);
  // Harmonic against the stop from 24 mm on: as far as 26 mm, on the way out and on the way back.
  const auto first_inside = std::find_if(y.begin(), y.end(), [](double v) { return v < 24 * kMm; });
  const double v = (first_inside[0] - first_inside[-1]) * 200, w = -v / (2 * kMm);
  std::vector<double> whole;
  for (double t = std::numbers::pi / w; t >= 0; t -= 1.0 / 200) whole.push_back(24 * kMm + 2 * kMm * std::sin(w * t));
  const double top = 0.5 * static_cast<double>(whole.size()) / 200;
  whole.insert(whole.end(), first_inside, y.end());
  std::vector<double> approach;  // a hand brings it there
  for (double t = 0; t < 0.5; t += 1.0 / 200) approach.push_back(24 * kMm * (1 - std::cos(std::numbers::pi * t)) / 1.0);
  for (double& a : approach) a = std::min(a, 24 * kMm);
  whole.insert(whole.begin(), approach.begin(), approach.end());
  const Phases phases = Find(FromDisplacements(whole));
  ASSERT_TRUE(phases.usable) << phases.reason;
  EXPECT_NEAR(phases.extrema[0].t, 0.5 + top, 0.02);
  EXPECT_NEAR(phases.extrema[1].y, half.next_amplitude * -1, 0.1 * kMm);
}

TEST(FindPhases, BeatsLateInTheRecordAreNoPush) {
  // The other direction: 0.9 mm at 1.15 Hz that hardly decays, beside 2.5 mm of rolling at 1.56 Hz.
  PushedRecord setup = LateralSetup(3);
  setup.link = Oscillator<double>{};
  setup.link.k = 2.9;
  setup.link.Add({7, 0.0175});
  SimulatedRecord truth = Simulate(setup);
  for (std::size_t i = 0; i < truth.record.t.size(); ++i)
    truth.record.y[i] +=
        0.9 * kMm * std::exp(-0.05 * truth.record.t[i]) * std::cos(2 * std::numbers::pi * 1.15 * truth.record.t[i] + 2);
  const Phases phases = Find(truth.record);
  ASSERT_TRUE(phases.usable) << phases.reason;
  // 0.9 mm at another phase shifts an extremum of 15 mm and more by up to 0.9/15/w = 10 ms.
  EXPECT_NEAR(phases.extrema[0].t, truth.extremum_t[0], 0.010);
}

TEST(FindPhases, AToneDoesNotMoveExtrema) {
  for (const double frequency : {18.0, 20.0, 50.0, 59.8}) {
    PushedRecord setup = LateralSetup(2);
    SimulatedRecord truth = Simulate(setup);
    for (std::size_t i = 0; i < truth.record.t.size(); ++i)
      truth.record.y[i] += 0.35 * kMm * std::sin(2 * std::numbers::pi * frequency * truth.record.t[i] + 0.7);
    const Phases phases = Find(truth.record);
    ASSERT_TRUE(phases.usable) << frequency << " Hz: " << phases.reason;
    ASSERT_GE(phases.extrema.size(), 10u) << frequency;
    // A window of 1.8 rad holds five periods of 18 Hz; what the unfinished one leaves is below a twentieth of 0.35 mm
    // times w_tone/w_motion, over w^2 A: 5 ms at 8 mm.
    for (std::size_t i = 0; i < 10; ++i) EXPECT_NEAR(phases.extrema[i].t, truth.extremum_t[i], 0.008) << frequency;
  }
}

TEST(UnusableRecord, HoldsNoMotion) {
  EXPECT_EQ(Reason(FromDisplacements(std::vector<double>(3001, 0.0), 200, 0)),
            "expected a ring-down, found the same reading of 0.000 mm in all samples; check sensor and column");
  EXPECT_EQ(Reason(FromDisplacements(std::vector<double>(3001, 0.0))),
            "expected a ring-down with at least 12 samples in a period, found readings that jump like noise within "
            "0.0902 mm, "
            "7.0 samples from peak to peak; sample faster, or check sensor and column");
  std::vector<double> ramp;
  for (int i = 0; i <= 3000; ++i) ramp.push_back(1e-5 * i);
  EXPECT_EQ(Reason(FromDisplacements(ramp)), "expected at least 5 extrema of a free decay, found 0; record for longer");
}

TEST(UnusableRecord, HasHardlyAnySample) {
  Record record;
  record.t = {0, 0.1, 0.2, 0.3, 0.4};
  record.y = {0, 1, 0, -1, 0};
  record.sampling_hz = 10;
  EXPECT_EQ(FindPhases(record, {}).reason, "expected at least 16 samples, found 5");
}

}  // namespace
}  // namespace uiclink
