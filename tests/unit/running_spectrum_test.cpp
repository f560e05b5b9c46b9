// Power spectra, lines and phase locking of runs.

#include "vehicle/hunting/running_spectrum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "tests/support/wagon_fixture.h"

namespace uiclink {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kHz = 100;
constexpr double kBase = 1.0603;  // no multiple of the distance of lines

double Hann(std::size_t i, std::size_t n) {
  const double s = std::sin(std::numbers::pi * static_cast<double>(i) / static_cast<double>(n));
  return s * s;
}

std::vector<double> MakeNoise(std::size_t n, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<double> noise(n);
  for (double& x : noise) x = 3 + 0.5 * normal(random);
  return noise;
}

double Integrate(const PowerSpectrum& spectrum) {
  return spectrum.line_hz * std::accumulate(spectrum.density.begin(), spectrum.density.end(), 0.0);
}

// ---------------------------------------------------------------------------------------------------------------------

class PowerOf : public testing::TestWithParam<std::size_t> {};

TEST_P(PowerOf, AllLinesIsTheVarianceUnderTheWindow) {
  const std::vector<double> x = MakeNoise(GetParam(), 7);
  double weight = 0, mean = 0, squares = 0, variance = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    weight += Hann(i, x.size());
    mean += Hann(i, x.size()) * x[i];
  }
  mean /= weight;
  for (std::size_t i = 0; i < x.size(); ++i) {
    squares += Hann(i, x.size()) * Hann(i, x.size());
    variance += std::pow(Hann(i, x.size()) * (x[i] - mean), 2);
  }
  variance /= squares;
  // Rounding of a transform of some thousand samples.
  EXPECT_NEAR(Integrate(CalcPowerSpectrum(x, kHz)), variance, 1e-12 * variance);
}
INSTANTIATE_TEST_SUITE_P(Lengths, PowerOf, testing::Values(16, 17, 1000, 1001, 4096));

TEST(PowerSpectrum, OfASineIsHalfItsSquareAtItsLine) {
  std::vector<double> x(4000);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = 1 + 0.3 * std::sin(kTurn * 4.2 * static_cast<double>(i) / kHz);
  const PowerSpectrum spectrum = CalcPowerSpectrum(x, kHz);
  EXPECT_DOUBLE_EQ(spectrum.line_hz, 0.025);
  // 4.2 Hz is line 168, so that the window leaves three lines and no more.
  const double three = spectrum.line_hz * (spectrum.density[167] + spectrum.density[168] + spectrum.density[169]);
  EXPECT_NEAR(three, 0.5 * 0.3 * 0.3, 1e-12);
  EXPECT_NEAR(Integrate(spectrum), three, 1e-12);
}

TEST(PowerSpectrum, OfWhiteNoiseIsFlatAndWelchMakesItSmooth) {
  const std::vector<double> x = MakeNoise(100000, 11);
  const auto scatter = [&](std::size_t segments) {
    const PowerSpectrum spectrum = CalcPowerSpectrum(x, kHz, segments);
    const double level = 2 * 0.25 / kHz;
    double mean = 0, square = 0;
    for (std::size_t i = 2; i + 2 < spectrum.density.size(); ++i) {
      mean += spectrum.density[i] / level;
      square += std::pow(spectrum.density[i] / level, 2);
    }
    const double n = static_cast<double>(spectrum.density.size()) - 4;
    mean /= n;
    EXPECT_NEAR(mean, 1, 0.03) << segments;  // the variance of 100 000 numbers is known to 0.5 %
    return square / n - mean * mean;
  };
  // The square of an exponentially distributed density; pieces that overlap by half are hardly correlated (1/36).
  EXPECT_NEAR(scatter(1), 1, 0.1);
  EXPECT_NEAR(scatter(39), 1.06 / 39, 0.2 / 39);
}

TEST(PowerSpectrum, SaysWhatItCannotDo) {
  const std::vector<double> x(100);
  EXPECT_THROW(CalcPowerSpectrum(x, 0), std::invalid_argument);
  EXPECT_THROW(CalcPowerSpectrum(x, kHz, 0), std::invalid_argument);
  EXPECT_THROW(CalcPowerSpectrum(x, kHz, 12), std::invalid_argument);
  EXPECT_NO_THROW(CalcPowerSpectrum(x, kHz, 11));
}

// ---------------------------------------------------------------------------------------------------------------------

/// Front lateral 2 mm at the base; front longitudinal 0.1 mm at `ratio` times it.
std::vector<SimulationSample> MakeMotion(double duration, double ratio, double noise = 0, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<SimulationSample> samples(static_cast<std::size_t>(duration * kHz));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double t = static_cast<double>(i) / kHz;
    samples[i].t = t;
    samples[i].x[wheelset::kY] = 1e-4 + 2e-3 * std::sin(kTurn * kBase * t + 0.4) + noise * normal(random);
    samples[i].x[wheelset::kX] = 3e-3 + 1e-4 * std::sin(kTurn * ratio * kBase * t + 1.1) + noise * normal(random);
  }
  return samples;
}

SpectralLine LineAt(double ratio, double duration = 60) {
  const std::vector<SimulationSample> samples = MakeMotion(duration, ratio);
  const RunningSpectrum spectrum = CalcRunningSpectrum(samples, kHz);
  EXPECT_EQ(spectrum.base_motion, "front_lateral");
  EXPECT_FALSE(spectrum.at_rest);
  const std::vector<SpectralLine>& lines = spectrum.motion("front_longitudinal").lines;
  EXPECT_EQ(lines.size(), 1u);
  return lines.empty() ? SpectralLine{} : lines.front();
}

TEST(RunningSpectrum, FindsBaseAmplitudesAndRms) {
  const std::vector<SimulationSample> samples = MakeMotion(60, 2);
  const RunningSpectrum spectrum = CalcRunningSpectrum(samples, kHz);
  EXPECT_NEAR(spectrum.base_hz, kBase, 1e-7);  // the phase of a pure sine, but for the window's side lobes
  EXPECT_NEAR(spectrum.periods(), 60 * kBase, 1e-5);
  const MotionSpectrum& lateral = spectrum.motion("front_lateral");
  EXPECT_NEAR(lateral.lines.front().amplitude, 2e-3, 0.03 * 2e-3);  // FindSpectrumPeaks
  EXPECT_NEAR(lateral.rms, 2e-3 / std::sqrt(2.0), 1e-2 * 2e-3);     // not a whole number of periods
  EXPECT_NEAR(spectrum.motion("front_longitudinal").mean, 3e-3, 1e-5);
  EXPECT_THROW(spectrum.motion("front_pitch"), std::invalid_argument);
}

struct LockingCase {
  double ratio;
  int p, q;
  Locking locking;
};
class Lines : public testing::TestWithParam<LockingCase> {};
TEST_P(Lines, AreLaidBesideSmallRatios) {
  const auto& [ratio, p, q, locking] = GetParam();
  const SpectralLine line = LineAt(ratio);
  EXPECT_NEAR(line.ratio, ratio, 1e-6);
  EXPECT_EQ(line.p, p);
  EXPECT_EQ(line.q, q);
  EXPECT_EQ(line.locking, locking) << Name(line.locking);
  EXPECT_NEAR(line.slip, (ratio - static_cast<double>(p) / q) * 60 * kBase, 1e-4);
}
INSTANTIATE_TEST_SUITE_P(Ratios, Lines,
                         testing::Values(LockingCase{2, 2, 1, Locking::kLocked}, LockingCase{4, 4, 1, Locking::kLocked},
                                         LockingCase{1.5, 3, 2, Locking::kLocked},
                                         LockingCase{5.0 / 3, 5, 3, Locking::kLocked},
                                         // 63.6 periods: 0.1 turns are 0.00157
                                         LockingCase{2.0012, 2, 1, Locking::kLocked},
                                         LockingCase{2.002, 2, 1, Locking::kFree},
                                         LockingCase{3.672, 11, 3, Locking::kFree}));

TEST(RunningSpectrum, DoesNotJudgeShortRuns) {
  const SpectralLine line = LineAt(2, 12);
  EXPECT_EQ(line.locking, Locking::kUndecided);
  EXPECT_NEAR(line.ratio, 2, 0.02);
}

TEST(RunningSpectrum, TellsTheErrorOfARatio) {
  // Noise as large as the longitudinal line: the error of the ratio is that of its phase.
  constexpr int kRuns = 60;
  double square = 0;
  int locked = 0;
  for (unsigned seed = 0; seed < kRuns; ++seed) {
    const std::vector<SimulationSample> samples = MakeMotion(60, 2, 5e-5, seed);
    const RunningSpectrum spectrum = CalcRunningSpectrum(samples, kHz);
    const SpectralLine& line = spectrum.motion("front_longitudinal").lines.front();
    square += std::pow((line.ratio - 2) / line.ratio_error, 2) / kRuns;
    locked += line.locking == Locking::kLocked;
  }
  // Student's t with four degrees of freedom has the variance 2; its mean over 60 runs scatters by some 0.7.
  EXPECT_GT(square, 0.7);
  EXPECT_LT(square, 5);
  EXPECT_GE(locked, kRuns - 2);
}

TEST(RunningSpectrum, AtRestHasNoLines) {
  std::vector<SimulationSample> samples = MakeMotion(60, 2);
  for (SimulationSample& sample : samples)
    for (double& x : sample.x) x *= 1e-5;  // 14 nm
  const RunningSpectrum spectrum = CalcRunningSpectrum(samples, kHz);
  EXPECT_TRUE(spectrum.at_rest);
  EXPECT_EQ(spectrum.base_hz, 0);
  for (const MotionSpectrum& motion : spectrum.motions) EXPECT_TRUE(motion.lines.empty());
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(FreeVibrations, OfSetTwoEmptyAreThoseOfTheThesis) {
  const WagonFixture fixture{.set = "set2", .freight = "empty", .options = {}};
  CornerLinks links = fixture.ReadLinks();
  links.longitudinal.sliders.clear();
  links.lateral.sliders.clear();
  const ContactTable table =
      CalcContactTable(ReadTrackGeometry(WagonFixture::Data() / "geometry" / "thesis-equivalent.toml"));
  const Wagon sliding(fixture.ReadData(), fixture.ReadBody(), false, {links, links, links, links}, table, {});
  const std::vector<FreeVibration> vibrations = FindFreeVibrations(fixture.Make(table), sliding, 38);
  const auto found = std::ranges::find(vibrations, "longitudinal", &FreeVibration::name);
  ASSERT_NE(found, vibrations.end());
  // Table 10.2 has a line at 3.9 Hz; the wagon swings lengthwise at 3.894 with the mass as the thesis prints it.
  EXPECT_NEAR(found->stuck_hz, 3.894, 0.01);
  EXPECT_LT(found->sliding_hz, 0.95 * found->stuck_hz);
  EXPECT_LT(found->decay, 0);
}

TEST(FreeVibrations, NameLinesThatAreNotLocked) {
  const std::vector<FreeVibration> vibrations{{.name = "body_roll", .stuck_hz = 3.9, .sliding_hz = 3.9},
                                              {.name = "longitudinal", .stuck_hz = 3.894, .sliding_hz = 2.9}};
  RunningSpectrum spectrum;
  spectrum.motions[0].lines = {{.frequency = 3.9, .locking = Locking::kFree, .near = {}},
                               {.frequency = 3.2, .locking = Locking::kUndecided, .near = {}},
                               {.frequency = 3.5, .locking = Locking::kLocked, .near = {}},
                               {.frequency = 4.2, .locking = Locking::kFree, .near = {}}};
  spectrum.motions[1].lines = {{.frequency = 3.91, .locking = Locking::kFree, .near = {}}};
  NameFreeLines(vibrations, &spectrum);
  const std::vector<SpectralLine>& lines = spectrum.motions[0].lines;
  EXPECT_EQ(lines[0].near, "longitudinal");
  EXPECT_EQ(lines[1].near, "longitudinal");
  EXPECT_EQ(lines[2].near, "");
  EXPECT_EQ(lines[3].near, "");
  EXPECT_EQ(spectrum.motions[1].lines[0].near, "body_roll");
}

}  // namespace
}  // namespace uiclink
