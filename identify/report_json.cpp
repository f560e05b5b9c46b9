#include "identify/report_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/report.h"
#include "identify/report_wagon.h"

namespace uiclink {

Json OrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ToJson(const Estimate& estimate) {
  Json json = {{"value", OrNull(estimate.value)},
               {"std", OrNull(estimate.std)},
               {"low", OrNull(estimate.low)},
               {"high", OrNull(estimate.high)}};
  if (estimate.low_open) json["low_open"] = true;
  if (estimate.high_open) json["high_open"] = true;
  if (estimate.spread > 0) json["spread"] = estimate.spread;
  return json;
}

namespace {

Json ToJson(const Population& population) {
  return {{"value", OrNull(population.mean)}, {"spread", OrNull(population.spread)}};
}

Json SineToJson(const RecordResult& r, const Identification& id) {
  const SineFit& sine = *r.sine;
  Json arcs = Json::array();
  for (const SlidingArc& arc : sine.arcs)
    arcs.push_back({{"extremum_s", arc.extremum_t},
                    {"extremum_mm", 1e3 * arc.extremum},
                    {"k", arc.k_published},
                    {"k_expected", id.link.k * (1 + CalcExpectedBias(id, sine, arc))},
                    {"k_corrected", arc.k_corrected}});
  return {{"omega_sliding", sine.omega_sliding},
          {"omega_rolling", sine.omega_rolling},
          {"k", sine.k},
          {"sum_ki", sine.sum_ki},
          {"T0", sine.T0},
          {"cutoff_mm", 1e3 * sine.cutoff},
          {"rolling_periods", sine.rolling_periods},
          {"k_corrected", sine.k_corrected},
          {"sum_ki_corrected", sine.sum_ki_corrected},
          {"T0_corrected", sine.T0_corrected},
          {"arcs", arcs}};
}

Json RecordToJson(const RecordResult& r, const Identification& id) {
  Json json = {{"file", r.record.file},
               {"used", r.used},
               {"reason", r.used ? Json(nullptr) : Json(r.reason)},
               {"samples", r.record.t.size()},
               {"sampling_hz", r.record.sampling_hz},
               {"mass_kg", r.record.mass_kg},
               {"g", r.record.g}};
  if (!r.record.notices.empty()) json["notices"] = r.record.notices;
  if (!r.used) return json;
  json["release_s"] = r.phases.release_s;
  json["fit_start_s"] = r.start[1];
  json["noise_mm"] = 1e3 * r.noise.sigma;
  json["quantum_mm"] = 1e3 * r.noise.quantum;
  json["offset_mm"] = 1e3 * r.start[2];
  if (r.phases.rest_size > 0) json["rest_mm"] = 1e3 * r.phases.rest_level;
  json["extremum_mm"] = 1e3 * (r.phases.extrema[0].y - r.start[2]);
  json["start_amplitude_mm"] = 1e3 * r.start[0];
  if (r.sine) json["sine_fit"] = SineToJson(r, id);
  Json fit;
  for (int q = 0; q < 2 * r.link.size() + 1; ++q) fit[QuantityName(r.link.size(), q)] = CalcQuantity(r.link, q);
  json["fit"] = fit;
  Json own;
  for (std::size_t q = 0; q < r.own_quantities.size(); ++q)
    own[QuantityName(id.sliders, static_cast<int>(q))] = ToJson(r.own_quantities[q]);
  json["own_fit"] = own;
  json["starts"] = {{"tried", r.starts}, {"same_minimum", r.starts_agreeing}};
  json["rms_mm"] = 1e3 * r.rms;
  return json;
}

Json FitToJson(const Identification& id) {
  Json parameters;
  for (std::size_t q = 0; q < id.quantities.size(); ++q)
    parameters[QuantityName(id.sliders, static_cast<int>(q))] = ToJson(id.quantities[q]);
  Json json = {{"shared", id.shared},
               {"sliders", id.sliders},
               {"parameters", parameters},
               {"rms_mm", 1e3 * id.rms},
               {"noise_mm", 1e3 * id.noise},
               {"rms_over_noise", id.rms / id.noise},
               {"unidentifiable", id.unidentifiable},
               {"evaluations", id.evaluations},
               {"wall_s", id.wall_s},
               {"sharing_test",
                {{"statistic", id.sharing.statistic}, {"dof", id.sharing.dof}, {"p_value", id.sharing.p_value}}}};
  if (!id.choices.empty()) {
    Json choices = Json::array();
    for (const SliderChoice& choice : id.choices)
      choices.push_back({{"sliders", choice.sliders},
                         {"penalised", choice.penalised},
                         {"held_out_rms_mm", OrNull(1e3 * choice.held_out_rms)},
                         {"chosen", choice.chosen}});
    json["slider_choice"] = choices;
  }
  if (!id.warnings.empty()) json["warnings"] = id.warnings;
  return json;
}

Json DirectionToJson(const Identification& id, const Diagnosis* diagnosis) {
  Json json = {{"direction", Name(id.direction)}};
  json["records"] = Json::array();
  for (const RecordResult& r : id.records) json["records"].push_back(RecordToJson(r, id));
  if (id.CountUsed() == 0) return json;
  if (id.sine.records > 0)
    json["sine_fit"] = {{"k", ToJson(id.sine.k)},
                        {"sum_ki", ToJson(id.sine.sum_ki)},
                        {"T0", ToJson(id.sine.T0)},
                        {"k_corrected", ToJson(id.sine.k_corrected)},
                        {"sum_ki_corrected", ToJson(id.sine.sum_ki_corrected)},
                        {"T0_corrected", ToJson(id.sine.T0_corrected)}};
  json["fit"] = FitToJson(id);
  if (diagnosis == nullptr) return json;
  json["diagnosis"] = DiagnosisToJson(id, *diagnosis);
  json["extended_fit"] = ExtendedToJson(id, diagnosis->extended);
  return json;
}

}  // namespace

std::string FormatJson(const RunResult& run) {
  Json json = {{"schema", "identify/1"}, {"version", UICLINK_VERSION}};
  const auto diagnosis = [&](std::size_t i) { return run.diagnoses.empty() ? nullptr : &run.diagnoses[i]; };
  if (run.directions.size() == 1) {
    json.update(DirectionToJson(run.directions[0], diagnosis(0)));
  } else {
    json["directions"] = Json::array();
    for (std::size_t i = 0; i < run.directions.size(); ++i)
      json["directions"].push_back(DirectionToJson(run.directions[i], diagnosis(i)));
  }
  Json& unread = run.directions.size() == 1 ? json["records"] : json["unread"];
  for (const Rejected& rejected : run.rejected)
    unread.push_back({{"file", rejected.file}, {"used", false}, {"reason", rejected.message}});
  if (run.wagon) json["wagon"] = WagonToJson(*run.wagon);
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace uiclink
