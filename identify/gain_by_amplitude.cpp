#include "identify/gain_by_amplitude.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uiclink {
namespace {

constexpr std::size_t kRanges = 3;

/// A sample of any record: where it belongs, and what both fits leave there.
struct Left {
  double amplitude = 0, before = 0, after = 0, noise = 0;  // [m]
};

std::vector<Left> Collect(std::span<const RecordResult* const> records, const ExtendedResult& before,
                          const ExtendedResult& after) {
  std::vector<Left> all;
  for (std::size_t r = 0; r < records.size(); ++r) {
    const FitData data = records[r]->Data();
    const std::vector<double> amplitudes = CalcLocalAmplitudes(data, records[r]->phases.extrema);
    const std::vector<double> first = CalcExtendedResiduals(data, before.extension, before.outcome.state, r);
    const std::vector<double> then = CalcExtendedResiduals(data, after.extension, after.outcome.state, r);
    if (amplitudes.empty() || first.empty() || then.empty()) continue;
    for (std::size_t i = 0; i < data.size; ++i)
      all.push_back({.amplitude = amplitudes[i],
                     .before = first[i],
                     .after = then[i],
                     .noise = after.structure.noise_of_record[r]});
  }
  return all;
}

}  // namespace

std::vector<double> CalcLocalAmplitudes(const FitData& data, std::span<const Extremum> extrema) {
  if (extrema.size() < 2) return {};
  std::vector<double> amplitudes;
  std::size_t next = 1;  // extremum after the sample
  for (std::size_t i = 0; i < data.size; ++i) {
    while (next + 1 < extrema.size() && data.record->t[data.first + i] > extrema[next].t) ++next;
    amplitudes.push_back(0.5 * std::abs(extrema[next].y - extrema[next - 1].y));
  }
  return amplitudes;
}

std::vector<AmplitudeGain> CalcGainByAmplitude(std::span<const RecordResult* const> records,
                                               const ExtendedResult& before, const ExtendedResult& after) {
  const std::vector<Left> all = Collect(records, before, after);
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const Left& left : all) {
    smallest = std::min(smallest, left.amplitude);
    largest = std::max(largest, left.amplitude);
  }
  if (!(largest > smallest)) return {};
  const double width = (largest - smallest) / kRanges;
  std::vector<AmplitudeGain> ranges(kRanges);
  for (std::size_t i = 0; i < kRanges; ++i) {
    ranges[i].high = largest - static_cast<double>(i) * width;
    ranges[i].low = largest - static_cast<double>(i + 1) * width;
  }
  for (const Left& left : all) {
    AmplitudeGain& range = ranges[std::min(kRanges - 1, static_cast<std::size_t>((largest - left.amplitude) / width))];
    ++range.samples;
    range.rms_before += left.before * left.before;
    range.rms_after += left.after * left.after;
    range.noise += left.noise * left.noise;
  }
  for (AmplitudeGain& range : ranges)
    for (double* mean : {&range.rms_before, &range.rms_after, &range.noise})
      *mean = range.samples > 0 ? std::sqrt(*mean / static_cast<double>(range.samples)) : 0;
  return ranges;
}

}  // namespace uiclink
