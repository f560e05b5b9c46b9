#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "identify/record.h"
#include "measurements/rig/rig.h"

namespace uiclink {

/// A lateral link with one joint and nothing that the plain model lacks: k = 3.41/m, k1 = 2.21/m, T01 = 0.018. The
/// records differ in their push and in the zero of the sensor.
inline rig::Settings PlainLateral(std::uint64_t seed) {
  rig::Settings settings;
  settings.name = "plain";
  settings.direction = "lateral";
  settings.link.k = 3.41;
  settings.link.joints = {{.k = 2.21, .T0 = 0.018}};
  settings.push.first_extremum_scatter = 0.0005;
  settings.sensor.zero_scatter = 0.0003;
  settings.seed = seed;
  return settings;
}

/// Scatter of a link that re-seats between records.
inline constexpr rig::Scatter kReseating{.k = 0.022, .joint_k = 0.028, .joint_T0 = 0.025};

/// A record of the rig as `identify` would read it from its file: millimetres printed with three decimals.
inline Record ToRecord(const rig::RigRecord& made, Direction direction) {
  Record record;
  record.file = std::string(Name(direction)) + "_rig.txt";
  record.direction = direction;
  record.sampling_hz = 200;
  record.t = made.t;
  for (const double y : made.y_mm) record.y.push_back(1e-3 * std::round(1e3 * y) / 1e3);
  return record;
}

/// Records 1 to `count` of the rig.
inline std::vector<Record> MakeRecords(const rig::Settings& settings, int count, Direction direction) {
  std::vector<Record> records;
  for (int i = 1; i <= count; ++i) records.push_back(ToRecord(rig::MakeRecord(settings, i), direction));
  return records;
}

/// Is the long form of the studies asked for (`./run tests --long`)?
inline bool IsLong() {
  const char* is_long = std::getenv("UICLINK_LONG");
  return is_long != nullptr && std::string(is_long) == "1";
}

}  // namespace uiclink
