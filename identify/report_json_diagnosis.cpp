#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/gain_by_amplitude.h"
#include "identify/report_json.h"

// The diagnosis as JSON.
namespace uiclink {
namespace {

Json ToJson(const EffectEstimate& estimate) {
  Json json = ToJson(static_cast<const Estimate&>(estimate));
  json["unit"] = estimate.unit;
  if (estimate.at_bound) json["at_bound"] = true;
  return json;
}

Json ToJson(const std::vector<EffectEstimate>& estimates) {
  Json json = Json::object();
  for (const EffectEstimate& estimate : estimates) json[estimate.symbol] = ToJson(estimate);
  return json;
}

Json ToJson(const Candidate& candidate) {
  Json json = {{"effect", candidate.effect->id},
               {"score", OrNull(candidate.score)},
               {"visibility", OrNull(candidate.visibility)},
               {"collinearity", OrNull(candidate.collinearity)},
               {"most_alike", candidate.most_alike != nullptr ? Json(candidate.most_alike->id) : Json(nullptr)},
               {"refitted", candidate.refitted},
               {"statistic", OrNull(candidate.statistic)},
               {"unknowns", candidate.unknowns},
               {"p_value", candidate.p_value},
               {"delta_bic", OrNull(candidate.delta_bic)},
               {"rms_over_noise", OrNull(candidate.rms_over_noise)},
               {"parameters", ToJson(candidate.parameters)}};
  if (!candidate.inadmissible.empty()) json["inadmissible"] = candidate.inadmissible;
  return json;
}

Json ToJson(const Cause& cause) {
  Json rivals = Json::array();
  for (const Effect* rival : cause.rivals) rivals.push_back(rival->id);
  return {{"effect", cause.effect->id},
          {"parameters", ToJson(cause.parameters)},
          {"p_value", cause.p_value},
          {"delta_bic", OrNull(cause.delta_bic)},
          {"rms_before_mm", 1e3 * cause.rms_before},
          {"rms_after_mm", 1e3 * cause.rms_after},
          {"held_out_rms_before_mm", cause.held_out.known ? OrNull(1e3 * cause.held_out.rms_before) : Json(nullptr)},
          {"held_out_rms_after_mm", cause.held_out.known ? OrNull(1e3 * cause.held_out.rms_after) : Json(nullptr)},
          {"held_out_gain", cause.held_out.known ? OrNull(cause.held_out.Gain()) : Json(nullptr)},
          {"held_out_by", cause.held_out.by_time ? "time" : "record"},
          {"rivals", rivals},
          {"repairable", cause.repairable},
          {"repaired", cause.repaired}};
}

Json SymptomsToJson(const Diagnosis& diagnosis) {
  const std::vector<Symptom>& left = diagnosis.symptoms_left.list;
  Json list = Json::array();
  for (const Symptom& symptom : diagnosis.symptoms.list) {
    const auto same =
        std::find_if(left.begin(), left.end(), [&](const Symptom& other) { return other.id == symptom.id; });
    list.push_back({{"symptom", symptom.id},
                    {"sentence", symptom.sentence},
                    {"measured", OrNull(symptom.measured)},
                    {"modelled", OrNull(symptom.modelled)},
                    {"unit", symptom.unit},
                    {"z", OrNull(symptom.z)},
                    {"significant", symptom.IsSignificant()},
                    {"of_model", symptom.of_model},
                    {"z_extended", same == left.end() ? Json(nullptr) : OrNull(same->z)}});
  }
  return list;
}

Json GainToJson(const Identification& id, const Diagnosis& diagnosis) {
  std::vector<const RecordResult*> records;
  for (const std::size_t i : id.UsedIndices()) records.push_back(&id.records[i]);
  Json list = Json::array();
  for (const AmplitudeGain& range : CalcGainByAmplitude(records, diagnosis.plain, diagnosis.extended))
    list.push_back({{"low_mm", 1e3 * range.low},
                    {"high_mm", 1e3 * range.high},
                    {"samples", range.samples},
                    {"rms_before_mm", 1e3 * range.rms_before},
                    {"rms_after_mm", 1e3 * range.rms_after},
                    {"noise_mm", 1e3 * range.noise}});
  return list;
}

Json UnseenToJson() {
  Json list = Json::array();
  for (const Effect* effect : Effects())
    if (!effect->unseen.empty()) list.push_back({{"effect", effect->id}, {"reason", effect->unseen}});
  return list;
}

Json ToJson(const std::vector<MissingForce::Bin>& bins, const char* at, double unit) {
  Json list = Json::array();
  for (const MissingForce::Bin& bin : bins)
    list.push_back({{at, unit * bin.at}, {"force", OrNull(bin.f)}, {"error", OrNull(bin.error)}, {"count", bin.count}});
  return list;
}

/// Forces are divided by the load M g.
Json ToJson(const MissingForce& force) {
  Json map = Json::array();
  for (const MissingForce::Cell& cell : force.map)
    map.push_back({{"displacement_mm", 1e3 * cell.y},
                   {"velocity_mm_s", 1e3 * cell.v},
                   {"force", OrNull(cell.f)},
                   {"error", OrNull(cell.error)},
                   {"count", cell.count}});
  return {{"words", force.words},
          {"p_value", OrNull(force.p_value)},
          {"shares",
           {{"displacement", OrNull(force.share_of_y)},
            {"velocity", OrNull(force.share_of_v)},
            {"sign_of_velocity", OrNull(force.share_of_sign_v)},
            {"time", OrNull(force.share_of_t)},
            {"stiffness_in_time", OrNull(force.share_of_stiffness_in_t)},
            {"modulated_stiffness", OrNull(force.share_of_modulated_stiffness)}}},
          {"map", map},
          {"over_y", ToJson(force.over_y, "displacement_mm", 1e3)},
          {"over_v", ToJson(force.over_v, "velocity_mm_s", 1e3)},
          {"over_t", ToJson(force.over_t, "time_s", 1)},
          {"smallest_seen", OrNull(force.smallest_seen)}};
}

}  // namespace

Json DiagnosisToJson(const Identification& id, const Diagnosis& diagnosis) {
  Json json = {{"verdict", Name(diagnosis.verdict)}};
  json["symptoms"] = SymptomsToJson(diagnosis);
  json["causes"] = Json::array();
  for (const Cause& cause : diagnosis.causes) json["causes"].push_back(ToJson(cause));
  json["candidates"] = Json::array();
  for (const Candidate& candidate : diagnosis.candidates) json["candidates"].push_back(ToJson(candidate));
  Json shifts = Json::object(), in_std = Json::object();
  for (const ParameterShift& shift : CalcParameterShifts(id, diagnosis)) {
    shifts[shift.symbol] = OrNull(shift.shift);
    in_std[shift.symbol] = OrNull(shift.in_std);
  }
  json["parameter_shift"] = shifts;
  json["parameter_shift_in_std"] = in_std;
  json["rms_over_noise"] = OrNull(diagnosis.extended.structure.RmsOverNoise());
  json["gain_by_amplitude"] = GainToJson(id, diagnosis);
  json["unseen"] = UnseenToJson();
  if (diagnosis.missing_force) json["missing_force"] = ToJson(*diagnosis.missing_force);
  if (!diagnosis.notices.empty()) json["notices"] = diagnosis.notices;
  json["evaluations"] = diagnosis.evaluations;
  json["wall_s"] = diagnosis.wall_s;
  return json;
}

Json ExtendedToJson(const Identification& id, const ExtendedResult& extended) {
  Json parameters;
  for (std::size_t q = 0; q < extended.quantities.size(); ++q)
    parameters[QuantityName(id.sliders, static_cast<int>(q))] = ToJson(extended.quantities[q]);
  for (const EffectEstimate& e : extended.effects) parameters[std::string(e.effect->id) + "." + e.symbol] = ToJson(e);
  return {{"shared", extended.sharing == Sharing::kLink},
          {"parameters", parameters},
          {"rms_mm", 1e3 * extended.structure.rms},
          {"noise_mm", 1e3 * extended.structure.noise},
          {"rms_over_noise", OrNull(extended.structure.RmsOverNoise())}};
}

}  // namespace uiclink
