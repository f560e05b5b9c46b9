#include "identify/write_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "identify/upper_median.h"

namespace uiclink {
namespace {

void Check(const WrittenRecord& record) {
  const std::size_t samples = record.t.size();
  if (record.y.size() != samples || (!record.uncertainty.empty() && record.uncertainty.size() != samples))
    throw std::invalid_argument("FormatRecord: columns of different length");
  const auto finite = [](const std::vector<double>& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  };
  if (!finite(record.t) || !finite(record.y) || !finite(record.uncertainty))
    throw std::invalid_argument("FormatRecord: a value is not finite");
  if (std::adjacent_find(record.t.begin(), record.t.end(), [](double a, double b) { return b <= a; }) != record.t.end())
    throw std::invalid_argument("FormatRecord: times do not increase");
}

/// Fewest decimals, at most 9, that keep every time to 1 ns.
int TimeDecimals(const std::vector<double>& t) {
  int decimals = 0;
  for (double scale = 1; decimals < 9; ++decimals, scale *= 10) {
    const auto kept = [=](double time) { return std::abs(time - std::round(time * scale) / scale) < 1e-9; };
    if (std::all_of(t.begin(), t.end(), kept)) break;
  }
  return decimals;
}

/// Decimals of a hundredth of the median uncertainty.
int ValueDecimals(const std::vector<double>& uncertainty) {
  const double median = UpperMedian(uncertainty);
  if (!(median > 0)) return 6;
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(median))), 0, 9);
}

/// Samples that are missing where steps are otherwise even; none where the rate varies.
long CountMissing(const std::vector<double>& t) {
  if (t.size() < 3) return 0;
  std::vector<double> steps(t.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = t[i + 1] - t[i];
  const double median = UpperMedian(steps);
  long missing = 0;
  for (const double step : steps) missing += std::max(0L, std::lround(step / median) - 1);
  return missing;
}

std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

std::string FormatRecord(const WrittenRecord& record) {
  Check(record);
  std::string text;
  if (record.direction) text += fmt::format("# direction: {}\n", Name(*record.direction));
  if (record.mass_kg) text += fmt::format("# mass_kg: {}\n", *record.mass_kg);
  if (record.g) text += fmt::format("# g: {}\n", *record.g);
  text += fmt::format("# displacement_unit: {}\n", record.unit);
  if (!record.source.empty()) text += fmt::format("# source: {}\n", OneLine(record.source));
  if (const long missing = CountMissing(record.t); missing > 0) text += fmt::format("# missing_samples: {}\n", missing);
  const bool uncertain = !record.uncertainty.empty();
  text += fmt::format("time_s\tdisplacement_{0}{1}\n", record.unit, uncertain ? "\tuncertainty_" + record.unit : "");
  const int time_decimals = TimeDecimals(record.t);
  const int decimals = ValueDecimals(record.uncertainty);
  for (std::size_t i = 0; i < record.t.size(); ++i) {
    text += fmt::format("{:.{}f}\t{:.{}f}", record.t[i], time_decimals, record.y[i], decimals);
    if (uncertain) text += fmt::format("\t{:.2g}", record.uncertainty[i]);
    text += '\n';
  }
  return text;
}

}  // namespace uiclink
