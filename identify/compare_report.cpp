// How a comparison of parameter sets looks: text for the terminal, JSON.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "identify/compare.h"
#include "identify/report_wagon.h"
#include "model/effect.h"
#include "reports/text_table.h"

namespace uiclink {
namespace {

using Align = TextTable::Align;

// ---------------------------------------------------------------- text

std::string Number(double value, int decimals) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, decimals) : "-";
}

void AddSetColumns(const CompareResult& result, TextTable* table) {
  for (const ComparedSet& set : result.sets) table->AddColumn(set.label);
}

std::string FormatSets(const CompareResult& result) {
  TextTable table;
  table.AddColumn("set", Align::kLeft);
  table.AddColumn("file", Align::kLeft);
  table.AddColumn("load\n[N]");
  table.AddColumn("g\n[m/s^2]");
  table.AddColumn("source", Align::kLeft);
  for (const ComparedSet& set : result.sets)
    table.AddRow({set.label, set.file, fmt::format("{:g}", set.load_N), fmt::format("{:g}", set.g), set.source});
  return table.Format(2);
}

std::string WithStd(const DirectionParameters& parameters, const std::string& symbol, double value) {
  const auto std = parameters.std.find(symbol);
  return std == parameters.std.end() ? fmt::format("{:g}", value) : fmt::format("{:.5g} ± {:.2g}", value, std->second);
}

/// Value of a symbol of ParameterSymbols, with its standard deviation where known; "" where the set has no such slider.
std::string FormatValue(const DirectionParameters& parameters, const std::string& symbol) {
  if (parameters.k == 0) return "-";
  if (symbol == "k") return WithStd(parameters, symbol, parameters.k);
  const std::size_t n = parameters.sliders.size();
  for (std::size_t i = 0; i < n; ++i) {
    if (symbol == fmt::format("k{}", i + 1)) return WithStd(parameters, symbol, parameters.sliders[i].k);
    if (symbol == fmt::format("T0{}", i + 1)) return WithStd(parameters, symbol, parameters.sliders[i].T0);
  }
  return "";
}

/// "rolling_friction.T_r" and its unit, of every set; an effect without parameters of its own stands by its name.
std::vector<std::pair<std::string, std::string>> ListEffectRows(const Comparison& comparison) {
  std::vector<std::pair<std::string, std::string>> rows;
  const auto add = [&rows](const std::string& name, std::string_view unit) {
    if (std::none_of(rows.begin(), rows.end(), [&](const auto& row) { return row.first == name; }))
      rows.emplace_back(name, unit);
  };
  for (const DirectionParameters& parameters : comparison.parameters)
    for (const EffectValues& values : parameters.effects) {
      const Effect* effect = FindEffect(values.id);
      if (values.parameters.empty()) add(values.id, "");
      for (const auto& [symbol, value] : values.parameters) {
        std::string_view unit;  // of a set that is listed only nothing has been checked
        if (effect != nullptr)
          for (const EffectParameter& p : effect->parameters)
            if (p.symbol == symbol) unit = p.unit;
        add(values.id + "." + symbol, unit);
      }
    }
  return rows;
}

/// Value of a row of ListEffectRows; "-" where the set has no such effect.
std::string FormatEffectValue(const DirectionParameters& parameters, const std::string& name) {
  for (const EffectValues& values : parameters.effects) {
    if (values.id == name) return "yes";
    for (const auto& [symbol, value] : values.parameters)
      if (values.id + "." + symbol == name) return WithStd(parameters, name, value);
  }
  return "-";
}

std::string FormatParameters(const CompareResult& result, const Comparison& comparison) {
  TextTable table;
  table.AddColumn("parameter", Align::kLeft);
  table.AddColumn("unit", Align::kLeft);
  AddSetColumns(result, &table);
  std::size_t sliders = 0;
  for (const DirectionParameters& p : comparison.parameters) sliders = std::max(sliders, p.sliders.size());
  const auto add_row = [&](const std::string& name, const std::string& unit, auto cell_of) {
    std::vector<std::string> row = {name, unit};
    for (const DirectionParameters& p : comparison.parameters) row.push_back(cell_of(p));
    table.AddRow(row);
  };
  for (const std::string& symbol : ParameterSymbols(static_cast<int>(sliders)))
    add_row(symbol, symbol[0] == 'T' ? "-" : "1/m", [&](const auto& p) { return FormatValue(p, symbol); });
  const auto sum = [](const DirectionParameters& p, double value) {
    return p.k == 0 ? std::string("-") : fmt::format("{:g}", value);
  };
  if (sliders > 1) {
    add_row("sum ki", "1/m", [&](const auto& p) { return sum(p, p.SumOfSliderStiffness()); });
    add_row("sum T0i", "-", [&](const auto& p) { return sum(p, p.SumOfSliderForce()); });
  }
  for (const auto& [name, unit] : ListEffectRows(comparison))
    add_row(name, unit, [&](const auto& p) { return FormatEffectValue(p, name); });
  return table.Format(2);
}

std::string FormatObstacles(const CompareResult& result, const Comparison& comparison) {
  std::string text;
  for (std::size_t s = 0; s < result.sets.size(); ++s)
    if (!comparison.why_not[s].empty()) text += fmt::format("  {}: {}\n", result.sets[s].file, comparison.why_not[s]);
  return text;
}

/// A table over amplitudes: the measured column where there is one, then the sets.
template <typename Point>
std::string FormatOverAmplitude(const CompareResult& result, const std::vector<Point>& points, int decimals,
                                double unit, const std::vector<double> Point::*by_set,
                                double Point::*measured = nullptr) {
  TextTable table;
  table.AddColumn("amplitude [mm]");
  if (measured != nullptr) table.AddColumn("measured");
  AddSetColumns(result, &table);
  for (const Point& point : points) {
    std::vector<std::string> row = {Number(1e3 * point.amplitude, 1)};
    if (measured != nullptr) row.push_back(Number(unit * (point.*measured), decimals));
    for (const double value : point.*by_set) row.push_back(Number(unit * value, decimals));
    table.AddRow(row);
  }
  return table.Format(2);
}

std::string FormatBackbone(const CompareResult& result, const Comparison& comparison) {
  return "  Frequency [Hz] of the half cycle that starts at an amplitude:\n" +
         FormatOverAmplitude(result, comparison.backbone, 3, 1, &BackbonePoint::frequency) +
         "\n  Energy lost in a steady cycle, divided by M g [mm]:\n" +
         FormatOverAmplitude(result, comparison.backbone, 4, 1e3, &BackbonePoint::loss);
}

std::string FormatMeasured(const CompareResult& result, const Comparison& comparison) {
  return "  Frequency [Hz] against amplitude, means of the free cycles of all records:\n" +
         FormatOverAmplitude(result, comparison.points, 3, 1, &AmplitudePoint::frequency,
                             &AmplitudePoint::measured_frequency) +
         "\n  Amplitude lost in a half cycle [mm] (twice that in a cycle) against amplitude:\n" +
         FormatOverAmplitude(result, comparison.points, 3, 1e3, &AmplitudePoint::loss, &AmplitudePoint::measured_loss);
}

std::string FormatRms(const SetOnRecord& on_record, double noise) {
  if (!on_record.used) return "-";
  return fmt::format("{}{:.3f} ({:.1f})", on_record.converged ? "" : "<= ", 1e3 * on_record.rms, on_record.rms / noise);
}

std::string FormatRmsTable(const CompareResult& result, const Comparison& comparison) {
  TextTable table;
  table.AddColumn("record", Align::kLeft);
  table.AddColumn("noise [mm]");
  AddSetColumns(result, &table);
  const auto add_row = [&](const std::string& name, double noise, const std::vector<SetOnRecord>& results) {
    std::vector<std::string> row = {name, Number(1e3 * noise, 4)};
    for (const SetOnRecord& on_record : results) row.push_back(FormatRms(on_record, noise));
    table.AddRow(row);
  };
  for (const ComparedRecord& record : comparison.records)
    add_row(std::filesystem::path(record.file).filename().string(), record.noise, record.results);
  table.AddRule();
  add_row("all", comparison.noise, comparison.overall);
  return "  rms [mm] with only the start of each record fitted (in brackets: in noise levels):\n" + table.Format(2);
}

/// Which set does best, in one sentence.
std::string FormatVerdict(const CompareResult& result, const Comparison& comparison) {
  const int best = comparison.FindBest();
  if (best < 0) return "";
  const auto b = static_cast<std::size_t>(best);
  const SetOnRecord& winner = comparison.overall[b];
  std::string others;
  for (std::size_t s = 0; s < result.sets.size(); ++s) {
    if (s == b || !comparison.overall[s].used) continue;
    others += fmt::format("{}{:.3f} mm of {}", others.empty() ? "" : ", ", 1e3 * comparison.overall[s].rms,
                          result.sets[s].label);
  }
  std::size_t won = 0;
  for (const ComparedRecord& record : comparison.records) {
    bool smallest = true;
    for (const SetOnRecord& other : record.results) smallest &= !other.used || record.results[b].rms <= other.rms;
    won += smallest ? 1 : 0;
  }
  return fmt::format(
      "  {} does best: rms {:.3f} mm = {:.1f} noise levels, against {}; it is the closest on {} of {} records.\n",
      result.sets[b].label, 1e3 * winner.rms, winner.rms / comparison.noise, others, won, comparison.records.size());
}

std::string FormatDirection(const CompareResult& result, const Comparison& comparison) {
  const std::size_t n = comparison.records.size();
  std::string text = n == 0 ? fmt::format("{}\n\n", Name(comparison.direction))
                            : fmt::format("{}: {} record{}\n\n", Name(comparison.direction), n, n == 1 ? "" : "s");
  text += FormatParameters(result, comparison) + FormatObstacles(result, comparison) + "\n";
  if (n == 0) return text + FormatBackbone(result, comparison) + "\n";
  return text + FormatRmsTable(result, comparison) + FormatVerdict(result, comparison) + "\n" +
         FormatMeasured(result, comparison) + "\n";
}

// ---------------------------------------------------------------- JSON

Json ToJson(const std::vector<double>& values, double unit) {
  Json json = Json::array();
  for (const double value : values) json.push_back(OrNull(unit * value));
  return json;
}

Json ToJson(const SetOnRecord& on_record, double noise) {
  if (!on_record.used) return nullptr;
  return {{"rms_mm", OrNull(1e3 * on_record.rms)},
          {"rms_over_noise", OrNull(on_record.rms / noise)},
          {"converged", on_record.converged}};
}

Json ParametersToJson(const DirectionParameters& parameters) {
  if (parameters.k == 0) return nullptr;
  Json json = {{"k", parameters.k}};
  for (std::size_t i = 0; i < parameters.sliders.size(); ++i) json[fmt::format("k{}", i + 1)] = parameters.sliders[i].k;
  for (std::size_t i = 0; i < parameters.sliders.size(); ++i)
    json[fmt::format("T0{}", i + 1)] = parameters.sliders[i].T0;
  json["sum_ki"] = parameters.SumOfSliderStiffness();
  json["sum_T0i"] = parameters.SumOfSliderForce();
  if (parameters.effects.empty()) return json;
  json["effects"] = Json::array();
  for (const EffectValues& effect : parameters.effects) {
    Json values = {{"id", effect.id}};
    for (const auto& [symbol, value] : effect.parameters) values[symbol] = value;
    json["effects"].push_back(values);
  }
  return json;
}

Json RecordToJson(const ComparedRecord& record) {
  Json json = {{"file", record.file}, {"used", true}, {"reason", nullptr}, {"noise_mm", 1e3 * record.noise}};
  json["results"] = Json::array();
  for (const SetOnRecord& on_record : record.results) {
    json["results"].push_back(ToJson(on_record, record.noise));
    if (!on_record.used) continue;
    json["results"].back()["start_amplitude_mm"] = 1e3 * on_record.start[0];
    json["results"].back()["fit_start_s"] = on_record.start[1];
    json["results"].back()["offset_mm"] = 1e3 * on_record.start[2];
  }
  return json;
}

Json Unused(const Rejected& rejected) {
  return {{"file", rejected.file}, {"used", false}, {"reason", rejected.message}};
}

Json PointToJson(const AmplitudePoint& point) {
  std::vector<double> per_cycle = point.loss;
  for (double& loss : per_cycle) loss *= 2;
  return {{"amplitude_mm", 1e3 * point.amplitude},
          {"cycles", point.cycles},
          {"frequency_hz", {{"measured", point.measured_frequency}, {"sets", ToJson(point.frequency, 1)}}},
          {"loss_per_half_cycle_mm", {{"measured", 1e3 * point.measured_loss}, {"sets", ToJson(point.loss, 1e3)}}},
          {"loss_per_cycle_mm", {{"measured", 2e3 * point.measured_loss}, {"sets", ToJson(per_cycle, 1e3)}}}};
}

Json DirectionToJson(const CompareResult& result, const Comparison& comparison) {
  Json json = {{"direction", Name(comparison.direction)}};
  json["parameters"] = Json::array();
  for (const DirectionParameters& parameters : comparison.parameters)
    json["parameters"].push_back(ParametersToJson(parameters));
  json["not_simulated"] = Json::array();
  for (const std::string& why : comparison.why_not)
    json["not_simulated"].push_back(why.empty() ? Json(nullptr) : Json(why));
  json["backbone"] = Json::array();
  for (const BackbonePoint& point : comparison.backbone)
    json["backbone"].push_back({{"amplitude_mm", 1e3 * point.amplitude},
                                {"frequency_hz", ToJson(point.frequency, 1)},
                                {"energy_per_cycle_mm", ToJson(point.loss, 1e3)}});
  json["records"] = Json::array();
  for (const ComparedRecord& record : comparison.records) json["records"].push_back(RecordToJson(record));
  for (const Rejected& rejected : comparison.left_out) json["records"].push_back(Unused(rejected));
  if (comparison.records.empty()) return json;
  json["noise_mm"] = 1e3 * comparison.noise;
  json["overall"] = Json::array();
  for (const SetOnRecord& overall : comparison.overall) json["overall"].push_back(ToJson(overall, comparison.noise));
  const int best = comparison.FindBest();
  json["best"] = best < 0 ? Json(nullptr) : Json(result.sets[static_cast<std::size_t>(best)].label);
  json["points"] = Json::array();
  for (const AmplitudePoint& point : comparison.points) json["points"].push_back(PointToJson(point));
  return json;
}

}  // namespace

std::vector<std::string> FormatLeftOut(const CompareResult& result) {
  std::vector<std::string> lines;
  for (const Rejected& rejected : result.rejected) lines.push_back(rejected.message);
  for (const Comparison& comparison : result.comparisons) {
    for (const Rejected& rejected : comparison.left_out) lines.push_back(rejected.file + ": " + rejected.message);
    for (std::size_t s = 0; s < result.sets.size(); ++s)
      if (!comparison.why_not[s].empty()) lines.push_back(result.sets[s].file + ": " + comparison.why_not[s]);
  }
  return lines;
}

std::string FormatComparison(const CompareResult& result) {
  std::string text;
  for (const Comparison& comparison : result.comparisons) {
    for (const Rejected& rejected : comparison.left_out)
      text += fmt::format("Left out: {}: {}\n", rejected.file, rejected.message);
  }
  for (const Rejected& rejected : result.rejected) text += fmt::format("Left out: {}\n", rejected.message);
  if (!text.empty()) text += "\n";
  text += FormatSets(result) + "\n";
  for (const Comparison& comparison : result.comparisons) text += FormatDirection(result, comparison);
  return text + (result.wagon ? FormatWagon(*result.wagon) : "");
}

std::string FormatComparisonJson(const CompareResult& result) {
  Json json = {{"schema", "identify-compare/1"}, {"version", UICLINK_VERSION}};
  json["sets"] = Json::array();
  for (const ComparedSet& set : result.sets)
    json["sets"].push_back(
        {{"label", set.label}, {"file", set.file}, {"source", set.source}, {"g", set.g}, {"load_N", set.load_N}});
  json["directions"] = Json::array();
  for (const Comparison& comparison : result.comparisons)
    json["directions"].push_back(DirectionToJson(result, comparison));
  if (result.wagon) json["wagon"] = WagonToJson(*result.wagon);
  if (!result.rejected.empty()) json["unread"] = Json::array();
  for (const Rejected& rejected : result.rejected) json["unread"].push_back(Unused(rejected));
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace uiclink
