// The rig (measurements/rig) is the witness that the solver is judged by, so it is validated by itself: here against
// closed forms, against its own step, and against the records that ship with the project; effect by effect in
// rig_effects_test.cpp.

#include "measurements/rig/rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "tests/validation/rig_fixture.h"

namespace uiclink::rig {
namespace {

using testing::HasSubstr;

// ---------------------------------------------------------------- closed forms

// Half a unit of the last printed digit plus the step's own error, which StepHalving measures below 1e-4 mm.
constexpr double kPrintedDigit_mm = 0.5e-3 + 1e-4;

TEST(RigOracle, LateralSet1FromFortyFiveMillimetres) {
  const std::vector<double> expected_mm{39.881, 34.969, 30.314, 25.980, 22.047, 18.609, 15.762, 13.571};
  const FreeDecay decay = ReleaseFromExtremum(LateralSet1(), 0.045, 40);
  ASSERT_GT(decay.extrema.size(), expected_mm.size());
  for (std::size_t i = 0; i < expected_mm.size(); ++i) {
    const double side = i % 2 == 0 ? -1 : 1;
    EXPECT_NEAR(1e3 * side * decay.extrema[i].y, expected_mm[i], kPrintedDigit_mm) << "extremum " << i + 1;
  }
  // k1 < k: the approach to y_c = T0/k1 is geometric and ends without an offset.
  const std::size_t last = decay.extrema.size() - 1;
  EXPECT_NEAR(1e3 * std::abs(decay.extrema[last].y), 1e3 * 0.014 / 1.4222, 1e-3);
  EXPECT_NEAR(1e3 * (decay.extrema[last].y + decay.extrema[last - 1].y), 0, 1e-3);
}

TEST(RigOracle, LateralSet2LocksWithAnOffset) {
  const std::vector<double> expected_mm{34.905, 24.961, 15.310, 6.426, 0.848};
  const Link link = LateralSet2();
  const FreeDecay decay = ReleaseFromExtremum(link, 0.045, 15);
  ASSERT_GT(decay.extrema.size(), expected_mm.size() + 2);
  for (std::size_t i = 0; i < expected_mm.size(); ++i) {
    const double side = i % 2 == 0 ? -1 : 1;
    EXPECT_NEAR(1e3 * side * decay.extrema[i].y, expected_mm[i], kPrintedDigit_mm) << "extremum " << i + 1;
  }
  const double y1 = decay.extrema[decay.extrema.size() - 2].y;
  const double y2 = decay.extrema[decay.extrema.size() - 1].y;
  const double offset = 0.5 * (y1 + y2), amplitude = 0.5 * std::abs(y1 - y2);
  EXPECT_NEAR(1e3 * offset, 0.653, kPrintedDigit_mm);
  EXPECT_NEAR(1e3 * amplitude, 1.501, kPrintedDigit_mm);
  EXPECT_NEAR(link.joints[0].k * amplitude + link.k * std::abs(offset), 0.018, 1e-6);  // exact; 1e-4 mm times k1
}

/// Exact half-cycle map of one slider (literature.md, section 2.1).
double NextExtremum(const Link& link, double A) {
  const double k = link.k, k1 = link.joints[0].k, T0 = link.joints[0].T0;
  return (std::sqrt((k * A - T0) * (k * A - T0) + 4 * k * T0 * T0 / k1) - T0) / k;
}

TEST(RigOracle, HalfCycleMapAndHalfPeriod) {
  const Link link{.g = 9.82, .k = 3.413, .joints = {{.k = 2.210, .T0 = 0.018}}, .effects = {}};
  const double k = link.k, k1 = link.joints[0].k, T0 = link.joints[0].T0, y_c = T0 / k1;
  for (const double A : {0.015, 0.025, 0.045}) {
    const FreeDecay decay = ReleaseFromExtremum(link, A, 1);
    ASSERT_FALSE(decay.extrema.empty());
    const double next = NextExtremum(link, A);
    EXPECT_NEAR(-decay.extrema[0].y, next, 1e-8);  // a tenth of the 1e-4 mm that a record may be off
    const double stuck = std::acos(1 - 2 * y_c * (k + k1) / (k * A + T0)) / std::sqrt(link.g * (k + k1));
    const double sliding = std::acos((2 * y_c - A + T0 / k) / (next + T0 / k)) / std::sqrt(link.g * k);
    EXPECT_NEAR(decay.extrema[0].t, stuck + sliding, 1e-6);  // 1e-6 s times 0.1 m/s: 1e-4 mm
  }
}

TEST(RigOracle, LockedMotionHasTheFrequencyOfAllSprings) {
  const Link link = LateralSet2();
  const FreeDecay decay = ReleaseFromExtremum(link, 0.045, 15);
  const std::size_t first = 8, last = decay.extrema.size() - 1;  // locked after the sixth extremum
  const double half_period = (decay.extrema[last].t - decay.extrema[first].t) / static_cast<double>(last - first);
  // (w h)^2/24 = 6e-8 is the frequency error of Verlet's method at h = 1e-4 s.
  EXPECT_NEAR(half_period * std::sqrt(link.g * (link.k + link.joints[0].k)) / kPi, 1, 1e-7);
}

TEST(RigOracle, EnergyLostIsWhatFrictionTook) {
  for (const Link& link : {LateralSet1(), LateralSet2(), LongitudinalSet2()}) {
    const FreeDecay decay = ReleaseFromExtremum(link, 0.045, 15);
    double worst = 0;
    for (std::size_t i = 0; i < decay.t.size(); ++i) {
      worst = std::max(worst, std::abs(decay.energy[i] + decay.loss[i] - decay.energy[0]));
    }
    // Verlet's energy ripples by (w h)^2/8 = 2e-7 of what is in motion.
    EXPECT_LT(worst, 1e-6 * decay.energy[0]);
    EXPECT_GT(decay.loss.back(), 0.5 * decay.energy[0]);
  }
}

// ---------------------------------------------------------------- numerics

TEST(RigStep, HalvingMovesTheShippedRecordsByLessThanATenthOfAMicrometre) {
  for (const char* direction : {"lateral", "longitudinal"}) {
    // The noise is 0.013 mm; 1e-4 mm over 3001 samples stays invisible to any test of the residual.
    EXPECT_LT(HalvingError_mm(Shipped(direction)), 1e-4) << direction;
  }
}

TEST(RigStep, ErrorOfThePlainModelIsOfSecondOrder) {
  const auto extremum = [](double step) { return ReleaseFromExtremum(LateralSet1(), 0.045, 4, step).extrema.at(5).y; };
  const double exact = extremum(2e-5);
  const double coarse = std::abs(extremum(4e-3) - exact), fine = std::abs(extremum(1e-3) - exact);
  EXPECT_GT(coarse / fine, 8.0);  // 16 for order 2; slips fall anywhere in a step, hence half an order of margin
}

// ---------------------------------------------------------------- push and sensor

TEST(RigPush, IsAsTheThesisDescribesIt) {
  for (const char* direction : {"lateral", "longitudinal"}) {
    const Settings settings = Shipped(direction);
    for (int index = 1; index <= settings.records; ++index) {
      const RigRecord record = MakeRecord(settings, index);
      const Truth& truth = record.truth;
      SCOPED_TRACE(testing::Message() << direction << " " << index);
      EXPECT_EQ(record.t.size(), 3001u);
      EXPECT_DOUBLE_EQ(record.t.back(), 15);
      EXPECT_GT(truth.push_start_s, 0.4);
      EXPECT_THAT(truth.release_s, testing::AllOf(testing::Gt(2.4), testing::Lt(3.0)));  // "about 2.5 s", "about 3 s"
      EXPECT_GT(truth.first_extremum_s, truth.release_s);
      EXPECT_NEAR(std::abs(truth.first_extremum), 0.025, 0.002);  // four standard deviations of the push
      const auto [low, high] = std::minmax_element(record.y_mm.begin(), record.y_mm.end());
      EXPECT_LT(std::max(-*low, *high), 30) << "the push should stop short of the sensor's range";
    }
  }
}

TEST(RigPush, OneThatCannotReachItsTargetIsRefused) {
  Settings settings = IdealSettings(LateralSet1());
  settings.link.effects.stop_k = 1e5, settings.link.effects.stop_position = 0.01;
  settings.push.first_extremum = 100;
  EXPECT_THROW(MakeRecord(settings, 1), std::invalid_argument);
}

TEST(RigPush, JointsWithAStartForceHoldTheMassOffItsZero) {
  Settings settings = IdealSettings(LateralSet1());
  settings.link.joints[0].T_start = 0.005;
  const RigRecord record = MakeRecord(settings, 1);
  EXPECT_NEAR(record.truth.rest_y, 0.005 / 4.2010, 1e-12);
  EXPECT_NEAR(record.y_mm.front(), 1e3 * record.truth.rest_y, 1e-6);
  EXPECT_EQ(record.y_mm[80], record.y_mm.front());  // 0.4 s: before the push
}

TEST(RigSensor, NoiseWithItsQuantisationIsThatOfTheExperiment) {
  Settings settings = Shipped("lateral");
  settings.scatter = {};
  settings.push.rest_s = 0.45;
  double sum = 0;
  long n = 0;
  for (int index = 1; index <= 40; ++index) {
    const RigRecord record = MakeRecord(settings, index);
    for (int i = 0; i < 90; ++i, ++n) {
      const double error_mm = record.y_mm[static_cast<std::size_t>(i)] - 1e3 * record.truth.zero_offset;
      sum += error_mm * error_mm;
    }
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(n)), 0.013, 0.0005);  // 3 standard errors of 3600 samples
}

TEST(RigSensor, ReadingsAreCodesOfTheConverterAndClip) {
  Settings settings = Shipped("lateral");
  settings.push.first_extremum = 0.045;
  const RigRecord record = MakeRecord(settings, 1);
  const double step_mm = 64.0 / 4096;
  for (const double y : record.y_mm) ASSERT_EQ(y / step_mm, std::round(y / step_mm));
  EXPECT_EQ(*std::max_element(record.y_mm.begin(), record.y_mm.end()), 32 - step_mm);
  EXPECT_EQ(*std::min_element(record.y_mm.begin(), record.y_mm.end()), -32);
}

// ---------------------------------------------------------------- seeds and scatter

TEST(RigSeed, MakesARecordExactlyAgain) {
  const Settings settings = Shipped("longitudinal");
  Settings other = settings;
  other.seed += 1;
  const std::string text = FormatRecord(MakeRecord(settings, 3), settings, 3);
  EXPECT_EQ(text, FormatRecord(MakeRecord(settings, 3), settings, 3));
  EXPECT_NE(MakeRecord(settings, 3).y_mm, MakeRecord(settings, 4).y_mm);
  EXPECT_NE(MakeRecord(settings, 3).y_mm, MakeRecord(other, 3).y_mm);
}

TEST(RigSeed, NoiseAndPushLeaveTheLinkAlone) {
  Settings settings = Shipped("lateral");
  const Truth before = MakeRecord(settings, 2).truth;
  settings.sensor.noise *= 3;
  settings.push.first = Push::First::kPositive;
  const Truth after = MakeRecord(settings, 2).truth;
  EXPECT_EQ(after.link.k, before.link.k);
  EXPECT_EQ(after.link.joints[0].T0, before.link.joints[0].T0);
  EXPECT_EQ(std::abs(after.first_extremum), std::abs(before.first_extremum));
  EXPECT_EQ(after.zero_offset, before.zero_offset);
}

TEST(RigScatter, HasTheSpreadOfTheSettings) {
  Settings settings = IdealSettings(LateralSet1());
  settings.duration_s = 4;
  settings.steps_per_sample = 1;
  settings.scatter = {.k = 0.02, .joint_k = 0.03, .joint_T0 = 0.025};
  const int n = 400;
  double k = 0, k1 = 0, T01 = 0, cross = 0;
  for (int index = 1; index <= n; ++index) {
    const Link link = MakeRecord(settings, index).truth.link;
    const double dk = link.k / 4.2010 - 1, dk1 = link.joints[0].k / 1.4222 - 1, dT = link.joints[0].T0 / 0.014 - 1;
    k += dk * dk, k1 += dk1 * dk1, T01 += dT * dT, cross += dk * dk1;
  }
  const double four_errors = 4 / std::sqrt(2.0 * n);  // of a standard deviation, relative
  EXPECT_NEAR(std::sqrt(k / n) / 0.02, 1, four_errors);
  EXPECT_NEAR(std::sqrt(k1 / n) / 0.03, 1, four_errors);
  EXPECT_NEAR(std::sqrt(T01 / n) / 0.025, 1, four_errors);
  EXPECT_NEAR(cross / std::sqrt(k * k1), 0, 4 / std::sqrt(static_cast<double>(n)));
}

// ---------------------------------------------------------------- shipped records

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Lines that differ. A platform's log, sin and cos may differ in the last bit and move a reading that lies within
/// 1e-15 of the edge between two codes: such a line may differ by one step of the converter, anything else is a
/// failure.
int CountFlippedReadings(const std::string& made, const std::string& shipped) {
  const std::vector<std::string> a = Lines(made), b = Lines(shipped);
  EXPECT_EQ(a.size(), b.size());
  int flipped = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (a[i] == b[i]) continue;
    ++flipped;
    if (a[i][0] == '#' || b[i][0] == '#') {
      ADD_FAILURE() << "line " << i + 1 << ": " << a[i] << " | " << b[i];
      continue;
    }
    double t_a = 0, y_a = 0, t_b = 0, y_b = 0;
    std::istringstream(a[i]) >> t_a >> y_a;
    std::istringstream(b[i]) >> t_b >> y_b;
    EXPECT_EQ(t_a, t_b) << "line " << i + 1;
    EXPECT_NEAR(y_a, y_b, 0.0167) << "line " << i + 1;  // one step of 0.015625 mm, both rounded to three decimals
  }
  return flipped;
}

TEST(RigShippedRecords, ComeFromTheRigByteForByte) {
  int flipped = 0;
  for (const std::string direction : {"lateral", "longitudinal"}) {
    const Settings settings = Shipped(direction);
    ASSERT_EQ(settings.records, 10);
    for (int index = 1; index <= settings.records; ++index) {
      const std::string file = direction + (index < 10 ? "_0" : "_") + std::to_string(index) + ".txt";
      SCOPED_TRACE(file);
      flipped += CountFlippedReadings(FormatRecord(MakeRecord(settings, index), settings, index),
                                      ReadFile(kMeasurements / file));
    }
  }
  RecordProperty("flipped_readings", flipped);
  EXPECT_LE(flipped, 5) << "of 60020 readings";  // 0 where the records were made
}

TEST(RigShippedRecords, KeepTheTruthToTheSettings) {
  const std::string readme = ReadFile(kMeasurements / "README.md");
  EXPECT_THAT(readme, HasSubstr("synthetic"));
  const std::string header = ReadFile(kMeasurements / "lateral_01.txt").substr(0, 400);
  EXPECT_THAT(header, HasSubstr("# source: synthetic"));
  for (const char* number : {"3.38", "2.25", "0.0176", "5.53", "6.5e-4"}) {
    EXPECT_EQ(readme.find(number), std::string::npos) << number;
    EXPECT_EQ(header.find(number), std::string::npos) << number;
  }
}

// ---------------------------------------------------------------- settings

std::string Complaint(const std::string& text) {
  try {
    ParseSettings(text, "some.toml");
  } catch (const SettingsError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(RigSettings, SayEveryFaultWithItsLine) {
  EXPECT_EQ(
      Complaint("direction = \"vertical\"\n"
                "seeed = 3\n"
                "[link]\n"
                "k = -1\n"
                "sliders = [ { k = 1.4, T0 = 0.01, T_start = 0.02 } ]\n"
                "[effects.viscous_damping]\n"
                "d = 1\n"
                "[effects.magic]\n"
                "c = 1\n"
                "[sensor]\n"
                "bits = 12.5\n"),
      "some.toml:1: expected \"lateral\" or \"longitudinal\" for \"direction\" at the top of the file, found "
      "\"vertical\"\n"
      "some.toml:2: expected one of the keys direction, duration_s, effects, g, link, mass_kg, push, records, scatter, "
      "seed, sensor, steps_per_sample at the top of the file, found \"seeed\"\n"
      "some.toml:4: expected a number > 0 for \"k\" in [link], found -1\n"
      "some.toml:5: expected a number in [-0.01, 0.01] for \"T_start\" in [link.sliders], found 0.02\n"
      "some.toml:6: expected \"c\" in [effects.viscous_damping], found no such key\n"
      "some.toml:7: expected one of the keys c in [effects.viscous_damping], found \"d\"\n"
      "some.toml:8: expected one of the keys asymmetric_friction, clearance, cross_axis_motion, cubic_stiffness, "
      "end_stop, extra_slider, force_bump, friction_drift, mains_hum, maxwell_branch, micro_slip, pendulum_geometry, "
      "quadratic_drag, quadratic_stiffness, rig_mode, rolling_friction, sensor_drift, sensor_nonlinearity, "
      "sensor_saturation, stiffness_modulation, stribeck_friction, velocity_strengthening, viscous_damping in "
      "[effects], found \"magic\"\n"
      "some.toml:11: expected a whole number in [2, 32] for \"bits\" in [sensor], found 12.5");
}

TEST(RigSettings, NeedALink) {
  EXPECT_THAT(Complaint("direction = \"lateral\"\n"), HasSubstr("some.toml:1: expected \"link\""));
  EXPECT_THAT(Complaint("direction = \"lateral\"\n[link]\nk = 3\n"), HasSubstr("some.toml:2: expected \"sliders\""));
}

TEST(RigSettings, MustBeToml) { EXPECT_THAT(Complaint("direction = \n"), HasSubstr("some.toml:1: expected TOML")); }

TEST(RigSettings, MissingFileAndFolderAreNamed) {
  for (const std::filesystem::path& path : {kMeasurements / "none.toml", kMeasurements}) {
    try {
      ReadSettings(path);
      ADD_FAILURE() << path;
    } catch (const SettingsError& error) {
      EXPECT_EQ(error.what(), path.string() + ": expected a settings file that can be read, found none");
    }
  }
}

TEST(RigSettings, AreSiInside) {
  const Settings settings = ParseSettings(
      "direction = \"longitudinal\"\nmass_kg = 400\ng = 9.81\nduration_s = 12\nrecords = 3\nseed = 9\n"
      "steps_per_sample = 20\n[link]\nk = 5\nsliders = [{ k = 2, T0 = 0.01, T_start = -0.01 }]\n"
      "[scatter]\nk = 0.01\nslider_k = 0.02\nslider_T0 = 0.03\n"
      "[push]\nrest_s = 1\nhalf_swings = 4\nfirst_extremum_mm = 20\nfirst_extremum_scatter_mm = 1\n"
      "release_before_extremum = 0.1\nfirst_extremum_side = \"negative\"\n"
      "[sensor]\nnoise_mm = 0.01\nzero_offset_mm = 0.2\nzero_scatter_mm = 0.3\nrange_mm = 40\nbits = 16\n"
      "sampling_hz = 500\nkeep_every = 2\n",
      "folder/some.toml");
  EXPECT_EQ(settings.name, "some.toml");
  EXPECT_EQ(settings.direction, "longitudinal");
  EXPECT_EQ(settings.mass_kg, 400);
  EXPECT_EQ(settings.link.g, 9.81);
  EXPECT_EQ(settings.duration_s, 12);
  EXPECT_EQ(settings.records, 3);
  EXPECT_EQ(settings.seed, 9u);
  EXPECT_EQ(settings.steps_per_sample, 20);
  EXPECT_EQ(settings.link.k, 5);
  ASSERT_EQ(settings.link.joints.size(), 1u);
  EXPECT_EQ(settings.link.joints[0].T_start, -0.01);
  EXPECT_EQ(settings.scatter.joint_T0, 0.03);
  EXPECT_EQ(settings.push.half_swings, 4);
  EXPECT_DOUBLE_EQ(settings.push.first_extremum, 0.020);
  EXPECT_EQ(settings.push.first, Push::First::kNegative);
  EXPECT_DOUBLE_EQ(settings.sensor.noise, 1e-5);
  EXPECT_DOUBLE_EQ(settings.sensor.zero_offset, 2e-4);
  EXPECT_DOUBLE_EQ(settings.sensor.range, 0.04);
  EXPECT_EQ(settings.sensor.bits, 16);
  EXPECT_EQ(settings.sensor.keep_every, 2);
}

}  // namespace
}  // namespace uiclink::rig
