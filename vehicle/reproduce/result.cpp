#include "vehicle/reproduce/result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "data/checksum.h"
#include "data/file.h"
#include "data/input_error.h"
#include "vehicle/report_json.h"

namespace uiclink::reproduce {
namespace {

constexpr const char* kSchema = "wagon-reproduce-item/1";

Json ToJson(const Value& value) {
  if (const double* number = std::get_if<double>(&value)) return NumberOrNull(*number);
  if (const std::string* word = std::get_if<std::string>(&value)) return *word;
  return nullptr;
}

Value ToValue(const Json& json) {
  if (json.is_number()) return json.get<double>();
  if (json.is_string()) return json.get<std::string>();
  return {};
}

Json ToJson(const ItemResult& result) {
  Json values = Json::object(), pictures = Json::array();
  for (const auto& [name, value] : result.values) values[name] = ToJson(value);
  for (const Picture& picture : result.pictures)
    pictures.push_back({{"title", picture.title}, {"svg", picture.svg}, {"chart", picture.chart}});
  return {{"values", values},          {"pictures", pictures},  {"notices", result.notices},
          {"failure", result.failure}, {"drawn", result.drawn}, {"wall_s", result.wall_s}};
}

ItemResult ToResult(const Json& json) {
  ItemResult result;
  for (const auto& [name, value] : json.at("values").items()) result.values[name] = ToValue(value);
  for (const Json& picture : json.at("pictures"))
    result.pictures.push_back({picture.at("title"), picture.at("svg"), picture.value("chart", "")});
  json.at("notices").get_to(result.notices);
  json.at("failure").get_to(result.failure);
  json.at("drawn").get_to(result.drawn);
  json.at("wall_s").get_to(result.wall_s);
  return result;
}

bool Agrees(const Row& row, const Value& value) {
  if (const std::string* word = std::get_if<std::string>(&value))
    return std::ranges::any_of(row.met_words, [&](const std::string& met) { return word->starts_with(met); });
  const double* number = std::get_if<double>(&value);
  if (number == nullptr) return false;
  if (row.met_range) return *number >= (*row.met_range)[0] && *number <= (*row.met_range)[1];
  return row.published && std::abs(*number - *row.published) <= row.met_within;
}

std::string Format(const Row& row, const Value& value) {
  if (const double* number = std::get_if<double>(&value)) return fmt::format("{:.{}f}", *number, row.digits);
  if (const std::string* word = std::get_if<std::string>(&value)) return *word;
  return "none";
}

constexpr const char* kNominalWhy =
    "Critical speeds are a third of theirs (page on the method), so that this speed lies elsewhere in its diagram.";

}  // namespace

std::string CalcKey(const Item& item, const Task& task, const WagonInputs& inputs) {
  std::string text = fmt::format("{} {} {} {}", kSchema, UICLINK_VERSION, item.id, Describe(task));
  if (const auto* stability = std::get_if<StabilityTask>(&task)) text += fmt::format(" {}", stability->picture_around);
  text += " " + InputsToJson(inputs).dump();
  return CalcSha256(text);
}

std::filesystem::path ResultStore::PathOf(const std::string& geometry, const std::string& id) const {
  return folder_ / "results" / geometry / (id + ".json");
}

std::optional<ItemResult> ResultStore::Read(const std::string& geometry, const std::string& id,
                                            const std::string& key) const {
  const std::filesystem::path path = PathOf(geometry, id);
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const Json json = Json::parse(ReadFileWhole(path));
    if (json.at("schema") != kSchema || json.at("key") != key) return std::nullopt;
    ItemResult result = ToResult(json.at("result"));
    if (!result.drawn) return std::nullopt;
    return result;
  } catch (const Json::exception&) {  // somebody else's file of that name: it is replaced
    return std::nullopt;
  }
}

void ResultStore::Write(const std::string& geometry, const std::string& id, const std::string& key,
                        const ItemResult& result) const {
  WriteFileWhole(
      PathOf(geometry, id),
      FormatJson({{"schema", kSchema}, {"key", key}, {"id", id}, {"geometry", geometry}, {"result", ToJson(result)}}));
}

const char* VerdictName(Verdict verdict) {
  switch (verdict) {
    case Verdict::kMet:
      return "met";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kUnexplained:
      return "unexplained";
    case Verdict::kOtherGeometry:
      return "other geometry";
    case Verdict::kNotCompared:
      return "-";
    case Verdict::kMissing:
      return "not computed";
  }
  return "?";
}

Comparison Compare(const Row& row, const std::string& geometry, const ItemResult* result) {
  if (result == nullptr) return {};
  if (!result->failure.empty())
    return {.verdict = Verdict::kMissing, .ours = "-", .difference = {}, .why = result->failure};
  const auto found = result->values.find(row.value);
  if (found == result->values.end()) return {};
  const Value& value = found->second;
  Comparison comparison{.verdict = Verdict::kNotCompared, .ours = Format(row, value), .difference = {}, .why = {}};
  const double* const number = std::get_if<double>(&value);
  if (row.published && number != nullptr && *row.published != 0)
    comparison.difference = fmt::format("{:+.1f} %", 100 * (*number - *row.published) / *row.published);
  if (!row.published && !row.met_range && row.met_words.empty()) return comparison;
  if (Agrees(row, value)) {
    comparison.verdict = Verdict::kMet;
  } else if (IsNominal(geometry)) {
    comparison.verdict = Verdict::kOtherGeometry;
    comparison.why = kNominalWhy;
  } else {
    comparison.verdict = row.why.empty() ? Verdict::kUnexplained : Verdict::kExplained;
    comparison.why = row.why.empty() ? row.tried : row.why;
  }
  return comparison;
}

}  // namespace uiclink::reproduce
