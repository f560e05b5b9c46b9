#include "identify/noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMm = 1e-3;

struct Readings {
  std::vector<double> t;
  std::vector<double> y;
};

double RoundTo(double value, double step) { return step > 0 ? step * std::round(value / step) : value; }

/// How a motion becomes readings: white noise, the steps of the converter about some zero, the decimals of the print.
struct Sensor {
  double sigma = 0.0125 * kMm;
  double step = 0.015625 * kMm;  // 12 bits over 64 mm
  double zero = 0;
  double print = 1e-3 * kMm;

  /// Standard deviation of a reading: both roundings are uniform and independent of the noise.
  double Total() const { return std::sqrt(sigma * sigma + (step * step + print * print) / 12); }
};

Readings Measure(const std::function<double(double)>& motion, double rate_hz, double seconds, const Sensor& sensor,
                 unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0, 1);
  Readings readings;
  const auto n = static_cast<int>(std::lround(rate_hz * seconds));
  for (int i = 0; i < n; ++i) {
    const double t = i / rate_hz;
    const double level = RoundTo(motion(t) + sensor.sigma * noise(random) - sensor.zero, sensor.step) + sensor.zero;
    readings.t.push_back(t);
    readings.y.push_back(RoundTo(level, sensor.print));
  }
  return readings;
}

/// Free decay of a linear oscillator.
std::function<double(double)> Decay(double amplitude, double frequency_hz, double seconds_to_half, double phase = 0.3) {
  return [=](double t) {
    return amplitude * std::exp2(-t / seconds_to_half) * std::cos(2 * kPi * frequency_hz * t + phase);
  };
}

/// The link of chapter 4 by small steps: y'' = g (T - k y), T' = -k1 y' within +-T0. Its third derivative jumps at each
/// slip, which no polynomial follows.
std::vector<double> SimulateLink(double rate_hz, double seconds) {
  constexpr double k = 3.41, k1 = 2.21, T0 = 0.018, g = 9.82;
  constexpr int kSubsteps = 100;  // of 50 us: the error of the step is smooth, so noise does not see it
  const double dt = 1 / rate_hz / kSubsteps;
  double y = 25 * kMm, v = 0, T = -T0;
  std::vector<double> samples;
  for (int i = 0; i < rate_hz * seconds; ++i) {
    samples.push_back(y);
    for (int s = 0; s < kSubsteps; ++s) {
      v += dt * g * (T - k * y);
      y += dt * v;
      T = std::clamp(T - dt * k1 * v, -T0, T0);
    }
  }
  return samples;
}

struct Statistics {
  double bias = 0;       ///< mean of sigma / truth - 1
  double deviation = 0;  ///< standard deviation of the same
};

Statistics Repeat(int seeds, double truth, const std::function<Readings(unsigned)>& measure) {
  double sum = 0;
  double sum2 = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Readings readings = measure(static_cast<unsigned>(seed));
    const double error = EstimateNoise(readings.t, readings.y).sigma / truth - 1;
    sum += error;
    sum2 += error * error;
  }
  const double bias = sum / seeds;

  return {bias, std::sqrt((sum2 - seeds * bias * bias) / (seeds - 1))};
}

void Print(const char* what, const Statistics& s) {
  std::printf("[          ] %s: bias %+.2f %%, standard deviation %.2f %%\n", what, 100 * s.bias, 100 * s.deviation);
}

// 12 s at 200 Hz are 2400 readings: no estimator of sigma has a standard deviation below 1 / sqrt(2 * 2400) = 1.44 %. A
// polynomial of degree 5 in each block of 21 readings costs 6 of 21: 1.44 / sqrt(15 / 21) = 1.71 %.
constexpr double kLeast = 0.0144;
constexpr double kExpected = 0.0171;
constexpr int kSeeds = 400;

TEST(NoiseTest, IsUnbiasedOnDecaysOfOneAndTwoHertz) {
  const Sensor sensor;
  for (const double frequency : {0.8, 1.0, 1.5, 2.0}) {
    const auto motion = Decay(25 * kMm, frequency, 4);
    const Statistics s =
        Repeat(kSeeds, sensor.Total(), [&](unsigned seed) { return Measure(motion, 200, 12, sensor, seed); });
    Print("decay", s);
    EXPECT_NEAR(s.bias, 0, 0.005) << frequency << " Hz";
    // The deviation of 400 seeds is itself known to 1 / sqrt(800) = 3.5 %; three of these above the expected one.
    EXPECT_LT(s.deviation, 1.11 * kExpected) << frequency << " Hz";
    EXPECT_GT(s.deviation, 0.89 * kLeast) << "less than information theory allows: the test is wrong";
  }
}

TEST(NoiseTest, KinksOfStickAndSlipDoNotCount) {
  const std::vector<double> motion = SimulateLink(200, 12);
  const Sensor sensor;
  const Statistics s = Repeat(kSeeds, sensor.Total(), [&](unsigned seed) {
    return Measure([&](double t) { return motion[static_cast<std::size_t>(std::lround(200 * t))]; }, 200, 12, sensor,
                   seed);
  });
  Print("link", s);
  EXPECT_NEAR(s.bias, 0, 0.005);
  EXPECT_LT(s.deviation, 1.11 * kExpected);
}

TEST(NoiseTest, HoldsForOtherSamplingRates) {
  const Sensor sensor{.sigma = 0.02 * kMm, .step = 0, .print = 0};
  for (const double rate : {50.0, 100.0, 500.0, 1000.0, 4000.0}) {
    const auto motion = Decay(25 * kMm, 1.0, 4);
    const Statistics s =
        Repeat(100, sensor.Total(), [&](unsigned seed) { return Measure(motion, rate, 12, sensor, seed); });
    Print("rate", s);
    // The mean of 100 seeds is known to a tenth of one seed's deviation: 3 sigma, with 15 readings left of 21 at worst
    // half of them, beside the 0.5 % that we allow.
    EXPECT_NEAR(s.bias, 0, 0.005 + 0.3 / std::sqrt(2 * 0.5 * 12 * rate)) << rate << " Hz";
  }
}

TEST(NoiseTest, IrregularSamplesAreNoNoise) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> jitter(-0.4, 0.4);
  std::normal_distribution<double> noise(0, 0.0125 * kMm);
  const auto motion = Decay(25 * kMm, 1.2, 4);
  Readings readings;
  for (int i = 0; i < 24000; ++i) {
    readings.t.push_back((i + jitter(random)) / 200);
    readings.y.push_back(motion(std::fmod(readings.t.back(), 12)) + noise(random));
  }
  // 24000 readings: 0.54 %; four of these. The ten restarts of the motion are kinks, and are cut.
  EXPECT_NEAR(EstimateNoise(readings.t, readings.y).sigma / (0.0125 * kMm), 1, 0.022);
}

TEST(NoiseTest, SpikesAndAnImpactAreLeftOut) {
  const Sensor sensor;
  const auto motion = Decay(25 * kMm, 1.0, 4);
  const Statistics s = Repeat(kSeeds, sensor.Total(), [&](unsigned seed) {
    Readings readings = Measure(motion, 200, 12, sensor, seed);
    for (const std::size_t i : {100, 777, 1500, 2222}) readings.y[i] += 5 * kMm;
    for (std::size_t i = 1000; i < 2400; ++i) readings.y[i] += 2 * kMm;  // the sensor slipped
    return readings;
  });
  Print("spikes", s);
  EXPECT_NEAR(s.bias, 0, 0.005);
}

TEST(NoiseTest, AStandingReadingDoesNotLowerIt) {
  // Half the record stands still on one step of a coarse, quiet converter.
  const Sensor sensor{.sigma = 0.01 * kMm, .step = 0.1 * kMm, .print = 0};
  const auto motion = [](double t) { return t < 6 ? 0.013 * kMm : 25 * kMm * std::sin(2 * kPi * (t - 6)); };
  const Readings readings = Measure(motion, 200, 12, sensor, 3);
  const Noise noise = EstimateNoise(readings.t, readings.y);
  EXPECT_NEAR(noise.quantum, 0.1 * kMm, 1e-9);
  // 1200 readings, 15 of 21 free: 2.4 %; three of these. Rounding errors of a slow motion are not quite white.
  EXPECT_NEAR(noise.sigma / sensor.Total(), 1, 0.075);
}

TEST(NoiseTest, IsNeverBelowTheRoundingAlone) {
  const Sensor sensor{.sigma = 0, .step = 1 * kMm, .print = 0};
  const Readings readings = Measure(Decay(6 * kMm, 0.5, 4), 200, 12, sensor, 1);
  const Noise noise = EstimateNoise(readings.t, readings.y);
  EXPECT_NEAR(noise.quantum, 1 * kMm, 1e-9);
  EXPECT_GE(noise.sigma, 1 * kMm / std::sqrt(12.0));
}

TEST(NoiseTest, AnExactMotionHasNoNoise) {
  const Sensor sensor{.sigma = 0, .step = 0, .print = 0};
  const Readings readings = Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, 1);
  const Noise noise = EstimateNoise(readings.t, readings.y);
  EXPECT_EQ(noise.quantum, 0);
  EXPECT_LT(noise.sigma, 1e-6 * kMm);
}

TEST(NoiseTest, RejectsWhatIsNoRecord) {
  const std::vector<double> t{0, 1, 2};
  EXPECT_THROW(EstimateNoise(t, t), std::invalid_argument);
  std::vector<double> time(32), y(32, 1.0);
  EXPECT_THROW(EstimateNoise(time, y), std::invalid_argument) << "time stands still";
  for (std::size_t i = 0; i < time.size(); ++i) time[i] = static_cast<double>(i);
  y[7] = std::nan("");
  EXPECT_THROW(EstimateNoise(time, y), std::invalid_argument);
}

TEST(NoiseTest, SurvivesAConstantAndAShortRecord) {
  std::vector<double> t(16), y(16, 1.0);
  for (std::size_t i = 0; i < t.size(); ++i) t[i] = static_cast<double>(i);
  const Noise noise = EstimateNoise(t, y);
  EXPECT_EQ(noise.quantum, 0);
  EXPECT_LT(noise.sigma, 1e-12);
}

// --- the lattice ---------------------------------------------------------------------------------------------------

TEST(QuantumTest, FindsTheConverterBehindThreeDecimals) {
  for (const double zero : {0.0, 0.0071, -3.33333}) {
    const Sensor sensor{.zero = zero * kMm};
    for (unsigned seed = 1; seed <= 50; ++seed) {
      const Readings readings = Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, seed);
      // The print is off by up to 0.5e-3 mm over a range of 3000 steps or so.
      EXPECT_NEAR(FindQuantum(readings.y), sensor.step, 1e-6 * kMm) << "seed " << seed << ", zero " << zero;
    }
  }
}

TEST(QuantumTest, FindsStepsThatAreNoMultipleOfThePrint) {
  for (const double step : {0.0031, 0.00488281, 0.0244140625, 0.157079633, 1.0 / 3}) {
    const Sensor sensor{.sigma = 0.3 * step * kMm, .step = step * kMm};
    const Readings readings = Measure(Decay(25 * kMm, 1.0, 3), 200, 12, sensor, 5);
    EXPECT_NEAR(FindQuantum(readings.y) / sensor.step, 1, 1e-4) << step;
  }
}

TEST(QuantumTest, FindsThePrintWhereThereIsNothingElse) {
  for (const double print : {1e-1, 1e-2, 1e-3, 1e-4, 1e-6}) {
    const Sensor sensor{.step = 0, .print = print * kMm};
    const Readings readings = Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, 5);
    EXPECT_NEAR(FindQuantum(readings.y) / sensor.print, 1, 1e-9) << print;
  }
}

TEST(QuantumTest, FindsEncoderCountsInDegreesAndRadians) {
  const double count_deg = 360.0 / 4096;
  for (const double print : {0.01, 1e-4, 0.0}) {  // degrees with two or four decimals, and as computed
    const Sensor sensor{.sigma = 0, .step = count_deg, .print = print};
    Readings readings = Measure(Decay(90, 1.0, 3), 1000, 5, sensor, 5);
    EXPECT_NEAR(FindQuantum(readings.y) / count_deg, 1, 1e-4) << print;
    for (double& y : readings.y) y *= kPi / 180;
    EXPECT_NEAR(FindQuantum(readings.y) / (count_deg * kPi / 180), 1, 1e-4) << print;
  }
}

TEST(QuantumTest, FindsTheEncoderBehindAPrintThatDoublesBlur) {
  // 40000 counts a turn, written in mrad with six decimals, read as mm: a nanometre of 65 mm, and a rest at the end.
  const double count = 2 * kPi / 40000;
  const Sensor sensor{.sigma = 0, .step = count, .print = 1e-9};
  for (const double amplitude : {0.065, 1.6}) {
    const auto motion = [=](double t) { return t < 5 ? amplitude * (1 - t / 5) * std::cos(2 * kPi * t) : 0.0; };
    const Readings readings = Measure(motion, 200, 12, sensor, 1);
    EXPECT_NEAR(FindQuantum(readings.y) / count, 1, 1e-6) << amplitude;
    EXPECT_GE(EstimateNoise(readings.t, readings.y).sigma, count / std::sqrt(12.0) * (1 - 1e-6)) << amplitude;
  }
}

TEST(NoiseTest, ARestOnNoLatticeDoesNotLowerIt) {
  // Unrounded readings, and a logger that repeats the last one when nothing comes any more.
  const Sensor sensor{.step = 0, .print = 0};
  Readings readings = Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, 1);
  std::fill(readings.y.begin() + 800, readings.y.end(), readings.y[800]);
  // 800 readings, 15 of 21 free: 3 %; three of these.
  EXPECT_NEAR(EstimateNoise(readings.t, readings.y).sigma / sensor.Total(), 1, 0.09);
}

TEST(QuantumTest, NoiseMuchSmallerThanTheStepChangesNothing) {
  const Sensor sensor{.sigma = 1e-4 * kMm};
  const Readings readings = Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, 5);
  EXPECT_NEAR(FindQuantum(readings.y), sensor.step, 1e-6 * kMm);
}

TEST(QuantumTest, FindsNoneInUnroundedReadings) {
  const Sensor sensor{.step = 0, .print = 0};
  for (unsigned seed = 1; seed <= 50; ++seed) {
    EXPECT_EQ(FindQuantum(Measure(Decay(25 * kMm, 1.0, 4), 200, 12, sensor, seed).y), 0) << seed;
  }
}

TEST(QuantumTest, NeedsTwoLevels) {
  EXPECT_EQ(FindQuantum({}), 0);
  EXPECT_EQ(FindQuantum(std::vector<double>(5, 0.25)), 0);
  EXPECT_DOUBLE_EQ(FindQuantum(std::vector<double>{0.25, 0.5, 0.25, 0.25}), 0.25);
}

}  // namespace
}  // namespace uiclink
