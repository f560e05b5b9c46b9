#include "identify/thinning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace uiclink {
namespace {

/// Means of `group` neighbours; a last group that is not full is dropped.
std::vector<double> Average(const std::vector<double>& values, std::size_t group) {
  std::vector<double> means(values.size() / group);
  for (std::size_t i = 0; i < means.size(); ++i) {
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(i * group);
    means[i] = std::accumulate(first, first + static_cast<std::ptrdiff_t>(group), 0.0) / static_cast<double>(group);
  }
  return means;
}

}  // namespace

void ThinRecord(Record* record) {
  const std::size_t samples = record->t.size();
  if (samples <= kManySamples || !record->uniform) return;
  const auto slowest = static_cast<std::size_t>(std::max(1.0, std::floor(record->sampling_hz / kThinnedRate)));
  const std::size_t group = std::min((samples + kManySamples - 1) / kManySamples, slowest);
  if (group < 2) return;
  record->t = Average(record->t, group);
  record->y = Average(record->y, group);
  if (!record->uncertainty.empty()) record->uncertainty = Average(record->uncertainty, group);
  record->sampling_hz /= static_cast<double>(group);
  record->notices.push_back(fmt::format("{} samples, averaged in groups of {} to {} at {:g} Hz", samples, group,
                                        record->t.size(), record->sampling_hz));
}

}  // namespace uiclink
