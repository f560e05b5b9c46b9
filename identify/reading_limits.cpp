#include "identify/reading_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace uiclink {
namespace {

constexpr double kFewest = 3;      // readings at the level
constexpr double kAtLevel = 0.95;  // share of the readings that must be there
constexpr double kBand = 3;        // noise levels within which a reading is there

struct Limit {
  double level = 0;     // reading [m]
  double beyond = 0;    // mean distance of the model from the level [m]
  double farthest = 0;  // [m]
  double z = 0, n = 0;
};

Limit FindLimit(std::span<const SymptomInput> records, double side) {
  Limit limit{.level = -std::numeric_limits<double>::infinity()};  // times side
  for (const SymptomInput& input : records)
    for (const double y : input.y()) limit.level = std::max(limit.level, side * y);
  double there = 0, weighted = 0;
  for (const SymptomInput& input : records)
    for (std::size_t i = 0; i < input.size; ++i) {
      const double beyond = side * input.modelled[i] - limit.level;
      if (beyond <= 0) continue;
      ++limit.n, limit.beyond += beyond, weighted += beyond / input.sigma;
      limit.farthest = std::max(limit.farthest, beyond);
      there += limit.level - side * input.y()[i] <= kBand * input.sigma + input.quantum ? 1 : 0;
    }
  limit.level *= side;
  if (limit.n < kFewest || there < kAtLevel * limit.n) return {.level = limit.level};
  limit.beyond /= limit.n;
  limit.z = weighted / std::sqrt(limit.n);
  return limit;
}

}  // namespace

void FindReadingLimits(std::span<const SymptomInput> records, Symptoms* symptoms) {
  const Limit high = FindLimit(records, 1), low = FindLimit(records, -1);
  const Limit& limit = high.z >= low.z ? high : low;
  symptoms->list.push_back(
      {.id = "readings_clipped",
       .sentence = limit.z > 0
                       ? fmt::format("{:.0f} readings stop at {:.3f} mm, where the model goes {:.3f} mm beyond: "
                                     "clipped{}",
                                     limit.n, 1e3 * limit.level, 1e3 * limit.farthest,
                                     high.z > 0 && low.z > 0 ? ", and so on the other side" : "")
                       : "no reading stops at a level that the model goes beyond",
       .measured = 1e3 * limit.level,
       .modelled = 1e3 * (limit.level + (limit.level > 0 ? 1 : -1) * limit.beyond),
       .unit = "mm",
       .z = limit.z});
}

}  // namespace uiclink
