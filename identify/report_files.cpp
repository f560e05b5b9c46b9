#include <fmt/core.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "identify/extended_covariance.h"
#include "identify/report.h"

namespace uiclink {
namespace {

/// Half of the 95 % interval over the standard deviation, on the logarithmic scale on which the fit makes both.
double CalcCoverage(const Estimate& estimate) {
  if (!(estimate.std > 0 && estimate.value > 0 && estimate.low > 0)) return 0;
  return 0.5 * std::log(estimate.high / estimate.low) * estimate.value / estimate.std;
}

/// What a covariance does not tell: how wide bounds are, and where records have links of their own, how far these are
/// from each other.
void AddCoverageAndSpread(const std::vector<Estimate>& quantities, int sliders, bool shared, Covariance* covariance) {
  // These two make the stiffness that counts; never less than a fit that knows its errors.
  covariance->coverage = kNormalCoverage;
  for (const int q : {0, SumOfStiffness(sliders)})
    covariance->coverage = std::max(*covariance->coverage, CalcCoverage(quantities[static_cast<std::size_t>(q)]));
  if (shared) return;
  const std::vector<std::string> symbols = ParameterSymbols(sliders);
  for (std::size_t i = 0; i < symbols.size(); ++i)
    if (std::isfinite(quantities[i].spread)) covariance->spread[symbols[i]] = quantities[i].spread;
}

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
  AddCoverageAndSpread(id.quantities, id.sliders, id.shared, &covariance);
  parameters.covariance = covariance;
  return parameters;
}

/// Effects and their parameters that belong to the link, in the units of the catalogue.
std::vector<EffectValues> MakeEffects(const ExtendedResult& extended) {
  std::vector<EffectValues> effects;
  for (const Effect* effect : extended.extension.effects()) {
    effects.push_back({.id = std::string(effect->id), .parameters = {}});
    const Extension::Range range = extended.extension.SharedOf(effect);
    for (std::size_t i = range.first; i < range.first + range.size; ++i) {
      const EffectParameter& parameter = extended.extension.shared()[i].Parameter();
      effects.back().parameters.emplace_back(parameter.symbol,
                                             FromCoordinate(parameter, extended.outcome.state.shared[i]));
    }
  }
  return effects;
}

DirectionParameters MakeExtendedDirection(const Identification& id, const ExtendedResult& extended) {
  DirectionParameters parameters;
  parameters.k = extended.link.k;
  for (const Slider<double>& slider : extended.link.sliders()) parameters.sliders.push_back(slider);
  parameters.effects = MakeEffects(extended);
  std::vector<FitData> data;
  for (const std::size_t i : id.UsedIndices()) data.push_back(id.records[i].Data());
  const ExtendedCovariance joint = CalcExtendedCovariance(data, extended);
  Covariance covariance{.order = joint.order, .matrix = {}};
  for (std::size_t i = 0; i < joint.order.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    parameters.std[joint.order[i]] = std::sqrt(joint.matrix(row, row));
    covariance.matrix.emplace_back();
    for (std::size_t j = 0; j < joint.order.size(); ++j)
      covariance.matrix.back().push_back(joint.matrix(row, static_cast<Eigen::Index>(j)));
  }
  AddCoverageAndSpread(extended.quantities, CountSliders(extended.outcome.state.link.shape),
                       extended.sharing == Sharing::kLink, &covariance);
  parameters.covariance = covariance;
  return parameters;
}

/// "one joint fit of a.txt, b.txt, with rolling_friction"
std::string DescribeOrigin(const Identification& id, const ExtendedResult* extended) {
  const bool shared = extended != nullptr ? extended->sharing == Sharing::kLink : id.shared;
  std::string files, effects;
  for (const RecordResult& r : id.records)
    if (r.used) files += (files.empty() ? "" : ", ") + r.record.file;
  if (extended != nullptr)
    for (const Effect* effect : extended->extension.effects())
      effects += (effects.empty() ? ", with " : ", ") + std::string(effect->id);
  return fmt::format("uiclink identify {}, {}, {} of {}{}", UICLINK_VERSION, Name(id.direction),
                     shared ? "one joint fit" : "means over the fits", files, effects);
}

/// A field of comma-separated values, in quotes where it needs them (RFC 4180).
std::string CsvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace

namespace {

ParameterSet MakeSet(const RunResult& run, bool with_causes) {
  ParameterSet set;
  set.name = with_causes || !HasCauses(run) ? "identified" : "identified, plain model";
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    if (id.CountUsed() == 0) continue;
    const bool has_causes = with_causes && !run.diagnoses.empty() && run.diagnoses[d].HasCauses();
    const ExtendedResult* extended = has_causes ? &run.diagnoses[d].extended : nullptr;
    (id.direction == Direction::kLateral ? set.lateral : set.longitudinal) =
        extended != nullptr ? MakeExtendedDirection(id, *extended) : MakeDirection(id);
    const RecordResult& last = id.records[id.UsedIndices().back()];
    set.load_N = last.record.mass_kg * last.record.g;
    set.g = last.record.g;
    if (!set.source.empty()) set.source += "; ";
    set.source += DescribeOrigin(id, extended);
  }
  return set;
}

}  // namespace

bool HasCauses(const RunResult& run) {
  return std::any_of(run.diagnoses.begin(), run.diagnoses.end(), [](const Diagnosis& d) { return d.HasCauses(); });
}

ParameterSet MakeParameterSet(const RunResult& run) { return MakeSet(run, /*with_causes=*/true); }
ParameterSet MakePlainParameterSet(const RunResult& run) { return MakeSet(run, /*with_causes=*/false); }

namespace {

/// Of the plain model, model - reading [m].
std::vector<double> CalcPlainResiduals(const RecordResult& r) {
  Levels levels;
  Shape shape;
  FromOscillator(r.link, &levels, &shape);
  return CalcResiduals(r.Data(), levels, shape, r.start);
}

/// Lines of one record.
/// @param extended  null where there is no diagnosis.
void AddResiduals(const RecordResult& r, const std::vector<double>& plain, const std::vector<double>* extended,
                  fmt::memory_buffer* text) {
  const FitData data = r.Data();
  const std::string file = CsvField(r.record.file);
  for (std::size_t i = 0; i < data.size; ++i) {
    const double reading = 1e3 * r.record.y[data.first + i];
    const double residual = -1e3 * plain[i];
    fmt::format_to(std::back_inserter(*text), "{},{:.9g},{:.5f},{:.5f},{:.5f}", file, r.record.t[data.first + i],
                   reading, reading - residual, residual);
    if (extended != nullptr && !extended->empty())
      fmt::format_to(std::back_inserter(*text), ",{:.5f},{:.5f}", reading + 1e3 * (*extended)[i],
                     -1e3 * (*extended)[i]);
    text->push_back('\n');
  }
}

}  // namespace

std::vector<ReadingResiduals> CalcReadingResiduals(const RunResult& run) {
  std::vector<ReadingResiduals> all;
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    const Diagnosis* diagnosis = run.diagnoses.empty() ? nullptr : &run.diagnoses[d];
    ReadingResiduals& residuals = all.emplace_back();
    for (const std::size_t i : id.UsedIndices()) {
      const RecordResult& r = id.records[i];
      residuals.plain.push_back(CalcPlainResiduals(r));
      residuals.extended.push_back(diagnosis != nullptr && diagnosis->HasCauses()
                                       ? CalcExtendedResiduals(r.Data(), diagnosis->extended.extension,
                                                               diagnosis->extended.outcome.state,
                                                               residuals.extended.size())
                                       : residuals.plain.back());
    }
  }
  return all;
}

std::string FormatResiduals(const RunResult& run, std::span<const ReadingResiduals> residuals) {
  fmt::memory_buffer text;
  fmt::format_to(std::back_inserter(text), "file,time_s,measured_mm,modelled_mm,residual_mm{}\n",
                 run.diagnoses.empty() ? "" : ",extended_mm,extended_residual_mm");
  for (std::size_t d = 0; d < run.directions.size(); ++d) {
    const Identification& id = run.directions[d];
    const std::vector<std::size_t> used = id.UsedIndices();
    for (std::size_t u = 0; u < used.size(); ++u)
      AddResiduals(id.records[used[u]], residuals[d].plain[u],
                   run.diagnoses.empty() ? nullptr : &residuals[d].extended[u], &text);
  }
  return fmt::to_string(text);
}

std::string FormatResiduals(const RunResult& run) { return FormatResiduals(run, CalcReadingResiduals(run)); }

}  // namespace uiclink
