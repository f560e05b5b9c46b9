#include "vehicle/report_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace uiclink {
namespace {

Json FilesToJson(const std::vector<InputFile>& files) {
  Json json = Json::array();
  for (const InputFile& file : files) {
    Json entry = {{"role", file.role}, {"name", file.name}, {"file", file.path}, {"sha256", file.sha256}};
    if (!file.used_for.empty()) entry["used_for"] = file.used_for;
    json.push_back(std::move(entry));
  }
  return json;
}

/// Of what was read: the options of a part that was not are no part of the result.
Json OptionsToJson(const WagonInputs& inputs) {
  const WagonChoice& choice = inputs.choice;
  Json json = Json::object();
  if (!inputs.data.parts.empty()) {
    json["com"] = Name(choice.inertia.com);
    json["partitions"] = Name(choice.inertia.partitions);
  }
  if (std::ranges::any_of(inputs.files, [](const InputFile& file) { return file.role == "set"; })) {
    json["suspension"] = Name(choice.options.suspension);
    json["guidance"] = choice.options.guidance;
    json["penetration"] = Name(choice.options.penetration);
    json["wheel_rail_friction"] = choice.options.mu;
    json["wheelset_roll"] = choice.options.printed_roll ? "printed" : "corrected";
  }
  return json;
}

Json BodyToJson(const WagonInputs& inputs) {
  const BodyInertia& body = inputs.body;
  return {{"mass_kg", body.m},
          {"roll_inertia_kg_m2", body.I_x},
          {"yaw_inertia_kg_m2", body.I_z},
          {"centre_of_mass_m", {{"ahead", body.x}, {"left", body.y}, {"above_underframe", body.h}}},
          {"loaded", inputs.loaded}};
}

}  // namespace

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json InputsToJson(const WagonInputs& inputs) {
  Json json = {{"files", FilesToJson(inputs.files)}, {"options", OptionsToJson(inputs)}};
  if (inputs.body.m > 0) json["body"] = BodyToJson(inputs);
  if (!inputs.table.rows.empty()) {
    json["contact"] = {{"table", inputs.table.name}, {"rows", inputs.table.rows.size()}};
    if (inputs.geometry) json["contact"]["model"] = Name(inputs.geometry->contact);
  }
  json["notices"] = inputs.notices;
  return json;
}

Json BeginResult(const std::string& command, const WagonInputs& inputs) {
  return {{"schema", "wagon-" + command + "/1"}, {"version", UICLINK_VERSION}, {"inputs", InputsToJson(inputs)}};
}

std::string FormatSets(const WagonInputs& inputs) {
  std::string text;
  for (const InputFile& file : inputs.files) {
    if (file.role != "set") continue;
    text += fmt::format("links: {} ({})", file.name, file.path);
    if (file.used_for.size() < 2 * kCorners) text += fmt::format(": {}", fmt::join(file.used_for, ", "));
    text += '\n';
  }
  return text;
}

std::string FormatJson(const Json& json) {
  // File names need not be UTF-8; what is not becomes a replacement character.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

const char* Name(Suspension suspension) {
  switch (suspension) {
    case Suspension::kLinear:
      return "linear";
    case Suspension::kParabolic:
      return "parabolic";
    case Suspension::kLeaf:
      return "leaf";
  }
  return "?";
}

const char* Name(Penetration penetration) { return penetration == Penetration::kTouching ? "touching" : "printed"; }
const char* Name(CentreOfMass com) { return com == CentreOfMass::kPrinted ? "printed" : "corrected"; }
const char* Name(Partitions partitions) { return partitions == Partitions::kAtEnds ? "at-ends" : "spread"; }
const char* Name(ContactModel contact) { return contact == ContactModel::kRigid ? "rigid" : "elastic"; }

}  // namespace uiclink
