// The same for machines and terminals.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "reports/text_table.h"
#include "vehicle/report_json.h"
#include "vehicle/reproduce/pages.h"

namespace uiclink::reproduce {
namespace {

Json ToJson(const Value& value) {
  if (const double* number = std::get_if<double>(&value)) return NumberOrNull(*number);
  if (const std::string* word = std::get_if<std::string>(&value)) return *word;
  return nullptr;
}

Json RowToJson(const Row& row, const std::string& item, const Reproduction& reproduction) {
  Json ours = Json::object();
  for (const std::string& geometry : reproduction.geometries) {
    const ItemResult* const result = reproduction.Find(geometry, item);
    const Comparison comparison = Compare(row, geometry, result);
    const bool known = result != nullptr && result->values.contains(row.value);
    ours[geometry] = {
        {"value", known ? ToJson(result->values.at(row.value)) : Json(nullptr)},
        {"verdict", comparison.verdict == Verdict::kNotCompared ? "not_compared" : VerdictName(comparison.verdict)},
        {"why", comparison.why}};
  }
  return {{"what", row.what},
          {"theirs", row.theirs},
          {"place", row.place},
          {"published", row.published ? Json(*row.published) : Json(nullptr)},
          {"ours", ours}};
}

}  // namespace

std::string FormatReproductionJson(const Reproduction& reproduction) {
  Json json{{"schema", "wagon-reproduce/1"},
            {"version", UICLINK_VERSION},
            {"quick", reproduction.quick},
            {"interrupted", reproduction.interrupted},
            {"computed", reproduction.computed},
            {"wall_s", reproduction.wall_s},
            {"geometries", reproduction.geometry_words}};
  Json items = Json::array();
  for (const Item* item : reproduction.items) {
    Json rows = Json::array();
    for (const Row& row : item->rows) rows.push_back(RowToJson(row, item->id, reproduction));
    items.push_back({{"id", item->id},
                     {"section", item->section},
                     {"title", item->title},
                     {"covers", item->covers},
                     {"rows", rows}});
  }
  json["items"] = std::move(items);
  return FormatJson(json);
}

std::string FormatReproduction(const Reproduction& reproduction) {
  TextTable table;
  table.AddColumn("geometry", TextTable::Align::kLeft);
  for (const char* const head :
       {"met", "explained", "unexplained", "other\ngeometry", "nothing\npublished", "not\ncomputed"})
    table.AddColumn(head);
  for (const std::string& geometry : reproduction.geometries) {
    std::vector<std::string> cells{geometry};
    for (const std::size_t count : CountVerdicts(reproduction, geometry)) cells.push_back(std::to_string(count));
    table.AddRow(cells);
  }
  std::string text = "Chapter 10, ours beside theirs:\n\n" + table.Format();
  if (reproduction.quick) text += "\nQuick: runs were cut short; none of these figures is a result.\n";
  return text + fmt::format("\n{} items computed in {:.1f} s, the others were there.\n", reproduction.computed,
                            reproduction.wall_s);
}

}  // namespace uiclink::reproduce
