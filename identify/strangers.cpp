#include "identify/strangers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace uiclink {
namespace {

constexpr double kStrange = 0.2;      // difference of log(k + sum k_i), ten times the scatter of re-seated links
constexpr double kFarBeyond = 6;      // times the median absolute deviation: four standard deviations
constexpr std::size_t kMajority = 3;  // records that agree

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

/// Rolling stiffness of a record by the frequency method.
struct Rolling {
  RecordResult* record = nullptr;
  double log_stiffness = 0;
};

std::vector<Rolling> FindRolling(Identification* result) {
  std::vector<Rolling> rolling;
  for (RecordResult& r : result->records)
    if (r.used && r.sine && r.sine->omega_rolling > 0)
      rolling.push_back({&r, 2 * std::log(r.sine->omega_rolling) - std::log(r.record.g)});
  return rolling;
}

}  // namespace

void LeaveOutStrangers(Identification* result) {
  const std::vector<Rolling> rolling = FindRolling(result);
  if (rolling.size() < 2) return;
  std::vector<double> values, deviations;
  for (const Rolling& r : rolling) values.push_back(r.log_stiffness);
  const double median = Median(values);
  for (const double value : values) deviations.push_back(std::abs(value - median));
  const double limit = std::max(kStrange, kFarBeyond * Median(deviations));
  const auto strange = [&](const Rolling& r) { return std::abs(r.log_stiffness - median) > limit; };
  const auto strangers = static_cast<std::size_t>(std::count_if(rolling.begin(), rolling.end(), strange));
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  if (rolling.size() - strangers < kMajority || (strangers == 0 && *high - *low > 2 * kStrange)) {
    if (*high - *low > kStrange)
      result->warnings.push_back(fmt::format(
          "k + sum k_i of the records is between {:.3g} and {:.3g} 1/m (from their rolling frequency): are they all of "
          "one link and one direction?",
          std::exp(*low), std::exp(*high)));
    return;
  }
  const char* other =
      result->direction == Direction::kLateral ? Name(Direction::kLongitudinal) : Name(Direction::kLateral);
  for (const Rolling& r : rolling) {
    if (!strange(r)) continue;
    r.record->used = false;
    r.record->reason = fmt::format(
        "expected the link of the other {} records, k + sum k_i about {:.3g} 1/m, found {:.3g} 1/m from the rolling "
        "frequency; is it a {} record, or of another link?",
        Name(result->direction), std::exp(median), std::exp(r.log_stiffness), other);
  }
}

}  // namespace uiclink
