#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "measurements/rig/rig.h"

/// What the tests of the rig share: links of the thesis, settings without noise, comparison of records.
namespace uiclink::rig {

inline constexpr double kPi = std::numbers::pi;

inline const std::filesystem::path kMeasurements = std::filesystem::path(UICLINK_SOURCE_DIR) / "measurements";

inline std::string ReadFile(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

inline Link LateralSet1() { return {.g = 9.82, .k = 4.2010, .joints = {{.k = 1.4222, .T0 = 0.014}}, .effects = {}}; }
inline Link LateralSet2() { return {.g = 9.82, .k = 3.413, .joints = {{.k = 10.503, .T0 = 0.018}}, .effects = {}}; }
inline Link LongitudinalSet2() {
  return {.g = 9.82,
          .k = 5.50,
          .joints = {{.k = 3.44, .T0 = 6.98e-3},
                     {.k = 2.00, .T0 = 5.11e-3},
                     {.k = 0.33, .T0 = 0.91e-3},
                     {.k = 1.90, .T0 = 7.16e-3}},
          .effects = {}};
}

/// No scatter, no noise, and a converter of 2^32 codes (1.5e-8 mm): y_mm is the true motion with the measurement
/// effects.
inline Settings IdealSettings(const Link& link) {
  Settings settings;
  settings.name = "test";
  settings.direction = "lateral";
  settings.link = link;
  settings.push.first = Push::First::kPositive;
  settings.sensor.noise = 0;
  settings.sensor.bits = 32;
  settings.sensor.range = 0.064;
  return settings;
}

inline double LargestDifference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

inline Settings Shipped(const std::string& direction) {
  return ReadSettings(kMeasurements / "rig/settings" / (direction + ".toml"));
}

inline double HalvingError_mm(Settings settings) {
  settings.sensor.noise = 0;
  settings.sensor.bits = 32;
  const RigRecord coarse = MakeRecord(settings, 1);
  settings.steps_per_sample *= 2;
  return LargestDifference(coarse.y_mm, MakeRecord(settings, 1).y_mm);
}

}  // namespace uiclink::rig
