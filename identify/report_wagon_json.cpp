// What identified links do on the wagon, told to programs.

#include <nlohmann/json.hpp>

#include "identify/report_wagon.h"

namespace uiclink {
namespace {

Json ValueOrNull(const std::optional<double>& value) { return value ? OrNull(*value) : Json(nullptr); }

Json SpeedToJson(const std::optional<CriticalSpeed>& speed) {
  if (!speed) return {{"value", nullptr}, {"low", nullptr}, {"high", nullptr}};
  Json json = {
      {"value", ValueOrNull(speed->value)}, {"low", ValueOrNull(speed->low)}, {"high", ValueOrNull(speed->high)}};
  json["frequency_hz"] = speed->value ? Json(speed->frequency_hz) : Json(nullptr);
  if (!speed->type.empty() || !speed->type_reason.empty())
    json["type"] = speed->type.empty() ? Json(nullptr) : Json(speed->type);
  if (!speed->type_reason.empty()) json["type_reason"] = speed->type_reason;
  json["searched_to"] = speed->searched_to;
  if (speed->unstable_from_start) json["unstable_from_start"] = true;
  for (const SpeedSensitivity& s : speed->sensitivities)
    json["sensitivities"][Name(s.direction)][s.symbol] = OrNull(s.derivative);
  for (const SpeedShare& s : speed->shares) json["shares"][s.group] = OrNull(s.share);
  return json;
}

Json HuntingToJson(const HuntingRun& run) {
  return {{"amplitude_mm",
           {{"front_lateral", 1e3 * run.wheelset_amplitude[0]},
            {"rear_lateral", 1e3 * run.wheelset_amplitude[1]},
            {"body_lateral", 1e3 * run.body_amplitude}}},
          {"frequency_hz", ValueOrNull(run.frequency_hz)},
          {"impacts",
           {{"front_lateral", run.impacts[0]},
            {"rear_lateral", run.impacts[1]},
            {"longitudinal", run.longitudinal_impacts},
            {"peak_N", run.peak_impact}}},
          {"minimum_wheel_load_N", OrNull(run.minimum_wheel_load)},
          {"wheel_lift", run.wheel_lift},
          {"derailed", run.derailed},
          {"simulated_s", run.simulated},
          {"end_reason", run.end_reason.empty() ? Json(nullptr) : Json(run.end_reason)}};
}

Json RowToJson(const ValidationRow& row) {
  Json json = {{"role", row.set.role},
               {"name", row.set.set.name},
               {"set", row.set.file},
               {"sha256", row.set.sha256},
               {"trustworthy", row.set.doubt.empty()},
               {"linear_critical_speed", SpeedToJson(row.critical_speed)},
               {"hunting", row.hunting ? HuntingToJson(*row.hunting) : Json(nullptr)},
               {"notices", row.notices},
               {"failures", row.failures}};
  if (!row.set.doubt.empty()) json["doubt"] = row.set.doubt;
  for (const HuntingBound& bound : row.hunting_bounds)
    json["hunting_bounds"][bound.name] = {{"value", OrNull(bound.value)},
                                          {"low", OrNull(bound.value - bound.half)},
                                          {"high", OrNull(bound.value + bound.half)},
                                          {"unit", bound.unit}};
  return json;
}

Json CostToJson(const CauseCost& cost) {
  return {{"name", cost.name},
          {"unit", cost.unit},
          {"plain", cost.plain},
          {"extended", cost.extended},
          {"difference", cost.difference()},
          {"low", cost.difference() - cost.half()},
          {"high", cost.difference() + cost.half()},
          {"paired", cost.paired_half.has_value()},
          {"half_if_independent", cost.independent()},
          {"half_if_wholly_correlated", cost.narrowest_half()}};
}

/// Each set against the first.
Json DifferencesToJson(const Validation& validation) {
  Json json = Json::array();
  for (const SpeedDifference& d : CalcSpeedDifferences(validation.rows)) {
    const auto shifted = [&](double sign) { return d.half ? Json(d.difference + sign * *d.half) : Json(nullptr); };
    json.push_back({{"set", validation.rows[d.row].set.file},
                    {"against", validation.rows.front().set.file},
                    {"name", "linear critical speed"},
                    {"unit", "m/s"},
                    {"difference", d.difference},
                    {"low", shifted(-1)},
                    {"high", shifted(1)},
                    {"half_if_wholly_correlated", ValueOrNull(d.half_if_correlated)}});
  }
  return json;
}

Json InputsToJson(const Validation& validation) {
  Json files = Json::array();
  for (const ValidationFile& file : validation.files)
    files.push_back({{"role", file.role}, {"name", file.name}, {"file", file.file}, {"sha256", file.sha256}});
  return {{"files", files}};
}

}  // namespace

Json WagonToJson(const Validation& validation) {
  const ValidationRow* const first = validation.rows.empty() ? nullptr : &validation.rows.front();
  Json json = {{"set", first != nullptr ? Json(first->set.file) : Json(nullptr)},
               {"cargo", validation.options.cargo},
               {"geometry", validation.options.geometry},
               {"linear_critical_speed", SpeedToJson(first != nullptr ? first->critical_speed : std::nullopt)},
               {"trustworthy", first != nullptr && first->set.doubt.empty() && validation.Complete()},
               {"hunting_run",
                {{"speed", validation.options.speed},
                 {"start_mm", {{"front_lateral", 1e3 * kHuntingStart}, {"rear_lateral", 1e3 * kHuntingStart}}},
                 {"duration_s", kHuntingDuration},
                 {"window_s", kHuntingWindow}}},
               {"failure", validation.failure.empty() ? Json(nullptr) : Json(validation.failure)}};
  json["sets"] = Json::array();
  for (const ValidationRow& row : validation.rows) json["sets"].push_back(RowToJson(row));
  json["cause_cost"] = Json::array();
  for (const CauseCost& cost : validation.cause_cost) json["cause_cost"].push_back(CostToJson(cost));
  if (validation.options.side_by_side) json["differences"] = DifferencesToJson(validation);
  json["inputs"] = InputsToJson(validation);
  json["notices"] = validation.notices;
  json["wall_s"] = validation.wall_s;
  return json;
}

}  // namespace uiclink
