#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "identify/record.h"

namespace uiclink {

/// A shipped lateral record, 1 to 10.
inline Record ShippedLateral(int number) {
  const std::string name = "lateral_" + std::string(number < 10 ? "0" : "") + std::to_string(number) + ".txt";
  return ReadRecord(std::filesystem::path(UICLINK_SOURCE_DIR) / "measurements" / name);
}

inline std::vector<double> InMillimetres(const Record& record) {
  std::vector<double> y;
  for (const double v : record.y) y.push_back(1e3 * v);
  return y;
}

}  // namespace uiclink
