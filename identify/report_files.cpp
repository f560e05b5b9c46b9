#include <fmt/core.h>
#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "identify/report.h"

namespace uiclink {
namespace {

DirectionParameters MakeDirection(const Identification& id) {
  DirectionParameters parameters;
  parameters.k = id.link.k;
  for (const Slider<double>& slider : id.link.sliders()) parameters.sliders.push_back(slider);
  const std::vector<std::string> symbols = ParameterSymbols(id.sliders);
  Covariance covariance{.order = symbols, .matrix = {}};
  for (std::size_t i = 0; i < symbols.size(); ++i) {
    parameters.std[symbols[i]] = id.quantities[i].std;
    covariance.matrix.emplace_back();
    for (std::size_t j = 0; j < symbols.size(); ++j) {
      // Exactly symmetric: rounding must not make the file contradict itself.
      const auto row = static_cast<Eigen::Index>(std::min(i, j));
      const auto column = static_cast<Eigen::Index>(std::max(i, j));
      covariance.matrix.back().push_back(id.covariance(row, column));
    }
  }
  parameters.covariance = covariance;
  return parameters;
}

/// A field of comma-separated values, in quotes where it needs them (RFC 4180).
std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace

ParameterSet MakeParameterSet(const RunResult& run) {
  ParameterSet set;
  set.name = "identified";
  for (const Identification& id : run.directions) {
    if (id.CountUsed() == 0) continue;
    (id.direction == Direction::kLateral ? set.lateral : set.longitudinal) = MakeDirection(id);
    std::string files;
    for (const RecordResult& r : id.records) {
      if (!r.used) continue;
      files += (files.empty() ? "" : ", ") + r.record.file;
      set.load_N = r.record.mass_kg * r.record.g;
      set.g = r.record.g;
    }
    if (!set.source.empty()) set.source += "; ";
    set.source += fmt::format("uiclink identify {}, {}, {} of {}", UICLINK_VERSION, Name(id.direction),
                              id.shared ? "one joint fit" : "means over the fits", files);
  }
  return set;
}

std::string FormatResiduals(const RunResult& run) {
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "file,time_s,measured_mm,modelled_mm,residual_mm\n");
  for (const Identification& id : run.directions)
    for (const RecordResult& r : id.records) {
      if (!r.used) continue;
      Levels levels;
      Shape shape;
      FromOscillator(r.link, &levels, &shape);
      const FitData data = r.Data();
      const std::string file = CsvField(r.record.file);
      const std::vector<double> model_minus_reading = CalcResiduals(data, levels, shape, r.start);
      for (std::size_t i = 0; i < data.size; ++i) {
        const double reading = 1e3 * r.record.y[data.first + i];
        const double residual = -1e3 * model_minus_reading[i];
        fmt::format_to(std::back_inserter(text), "{},{:.9g},{:.5f},{:.5f},{:.5f}\n", file, r.record.t[data.first + i],
                       reading, reading - residual, residual);
      }
    }
  return fmt::to_string(text);
}

}  // namespace uiclink
