#include "vehicle/contact/geometry.h"

#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "data/file.h"
#include "data/table.h"

namespace uiclink {
namespace {

/// A length that the file gives in millimetres.
double Millimetres(Table& file, std::string_view key, const Range& range) { return file.Number(key, range) / 1e3; }

/// One of some words; the first one after a fault.
template <typename Enum, std::size_t n>
Enum Choice(Table& table, std::string_view key, const std::string& found,
            const std::array<std::pair<std::string_view, Enum>, n>& choices) {
  std::string expected;
  for (const auto& [word, value] : choices) {
    if (found == word) return value;
    expected += (expected.empty() ? "\"" : ", \"") + std::string(word) + '"';
  }
  table.Report(key, "one of " + expected, '"' + found + '"');
  return choices[0].second;
}

ProfileAxes ReadAxes(Table table) {
  using Lateral = ProfileAxes::Lateral;
  using Vertical = ProfileAxes::Vertical;
  constexpr std::array<std::pair<std::string_view, Lateral>, 3> kLateral{
      {{"detect", Lateral::kDetect}, {"field", Lateral::kField}, {"gauge", Lateral::kGauge}}};
  constexpr std::array<std::pair<std::string_view, Vertical>, 3> kVertical{
      {{"detect", Vertical::kDetect}, {"up", Vertical::kUp}, {"down", Vertical::kDown}}};
  ProfileAxes axes;
  if (const auto word = table.OptionalString("lateral")) axes.lateral = Choice(table, "lateral", *word, kLateral);
  if (const auto word = table.OptionalString("vertical")) axes.vertical = Choice(table, "vertical", *word, kVertical);
  return axes;
}

/// A standard profile stays a name; a file of points is looked for beside the geometry file.
std::string ResolveProfile(Table& file, std::string_view key, const std::filesystem::path& folder) {
  std::string name = file.String(key);
  if (name.empty() || FindStandardProfile(name) != nullptr) return name;
  const std::filesystem::path path = folder / name;
  if (!std::filesystem::is_regular_file(path))
    file.Report(key, R"("S1002", "UIC60", "60E1" or a file of points beside this file)", '"' + name + '"');
  return path.string();
}

ContactModel ReadContactModel(Table& file) {
  constexpr std::array<std::pair<std::string_view, ContactModel>, 2> kModels{
      {{"rigid", ContactModel::kRigid}, {"elastic", ContactModel::kElastic}}};
  const std::string word = file.String("contact");
  return word.empty() ? ContactModel::kRigid : Choice(file, "contact", word, kModels);
}

int ReadRows(Table& file) {
  const double rows = file.Number("rows", {.unit = "-", .low = 5, .high = 100001});
  if (std::isnan(rows)) return 0;
  if (rows != std::floor(rows)) file.Report("rows", "a whole number", std::to_string(rows));
  return static_cast<int>(rows);
}

}  // namespace

TrackGeometry ReadTrackGeometry(const std::filesystem::path& path) {
  return ParseTrackGeometry(ReadFileWhole(path), path);
}

TrackGeometry ParseTrackGeometry(std::string_view text, const std::filesystem::path& path) {
  Table file = Table::Parse(text, path.string());
  const std::filesystem::path folder = path.parent_path();
  // From the narrowest to the widest tracks that there are, with room; a length in metres or inches is outside.
  const Range across{.unit = "mm", .low = 300, .high = 3000};
  TrackGeometry geometry;
  geometry.name = file.String("name");
  geometry.source = file.String("source");
  geometry.gauge = Millimetres(file, "gauge_mm", across);
  geometry.gauge_depth = Millimetres(file, "gauge_depth_mm", {.unit = "mm", .low = 1, .high = 100});
  geometry.cant = file.Number("cant", {.unit = "-", .low = -0.2, .high = 0.2});
  geometry.rail_offset = Millimetres(file, "rail_offset_mm", {.unit = "mm", .low = -100, .high = 100});
  geometry.back_to_back = Millimetres(file, "back_to_back_mm", across);
  geometry.tape_circle = Millimetres(file, "tape_circle_mm", {.unit = "mm", .low = 10, .high = 200});
  geometry.r0 = Millimetres(file, "r0_mm", {.unit = "mm", .low = 100, .high = 2000});
  geometry.wheel = ResolveProfile(file, "wheel", folder);
  geometry.rail = ResolveProfile(file, "rail", folder);
  if (std::optional<Table> axes = file.OptionalTable("wheel_axes")) geometry.wheel_axes = ReadAxes(*axes);
  if (std::optional<Table> axes = file.OptionalTable("rail_axes")) geometry.rail_axes = ReadAxes(*axes);
  geometry.profile_smoothing = file.OptionalNumber("profile_smoothing_mm", Range::NotNegative("mm")).value_or(0) / 1e3;
  geometry.contact = ReadContactModel(file);
  geometry.wheel_load = file.Number("wheel_load_N", {.unit = "N", .low = 1, .high = 1e7});
  geometry.young = file.Number("young", {.unit = "N/m^2", .low = 1e8, .high = 1e13});
  geometry.poisson = file.Number("poisson", {.unit = "-", .low = 0, .high = 0.5});
  geometry.y_max = Millimetres(file, "y_max_mm", {.unit = "mm", .low = 0.1, .high = 100});
  geometry.rows = ReadRows(file);
  file.Finish();
  return geometry;
}

}  // namespace uiclink
