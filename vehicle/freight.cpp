#include "vehicle/freight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/file.h"
#include "data/table.h"

namespace uiclink {
namespace {

const Range kMass{.unit = "kg", .low = 0, .high = 1e6, .low_included = false};  // a freight train's, not a wagon's

FreightBox ReadBox(Table table, std::size_t number) {
  FreightBox box;
  box.name = table.OptionalString("name").value_or(fmt::format("box {}", number));
  box.mass = table.Number("mass", kMass);
  box.length = table.Number("length", Range::NotNegative("m"));
  box.width = table.Number("width", Range::NotNegative("m"));
  box.height = table.Number("height", Range::NotNegative("m"));
  box.x = table.OptionalNumber("x", Range::Any("m")).value_or(0);
  box.y = table.OptionalNumber("y", Range::Any("m")).value_or(0);
  box.z = table.OptionalNumber("z", Range::NotNegative("m")).value_or(0);
  return box;
}

/// Height under the roof at the distance |y| from the middle: flat in the middle, then straight down to the wall.
double CalcClearHeight(const CargoSpace& cargo, double y) {
  const double flat = cargo.ridge_width / 2, wall = cargo.width / 2;
  if (std::abs(y) <= flat || wall <= flat) return cargo.ridge_height;
  const double down = std::min(1.0, (std::abs(y) - flat) / (wall - flat));
  return cargo.ridge_height + down * (cargo.height - cargo.ridge_height);
}

void CheckBox(const FreightBox& box, const CargoSpace& cargo, std::vector<std::string>* notices) {
  constexpr double kSlack = 1e-3;  // [m], see the header
  const auto say = [&](double excess, const char* where) {
    if (excess > kSlack) notices->push_back(fmt::format("{} stands {:.0f} mm {}", box.name, 1e3 * excess, where));
  };
  const double side = std::abs(box.y) + box.width / 2;
  say(std::abs(box.x) + box.length / 2 - cargo.length / 2, "over the end of the floor");
  say(side - cargo.width / 2, "through a side wall");
  say(box.z + box.height - CalcClearHeight(cargo, side), "through the roof");
}

}  // namespace

Freight ParseFreight(std::string_view text, const std::string& file) {
  Table table = Table::Parse(text, file);
  Freight freight;
  freight.name = table.String("name");
  freight.source = table.String("source");
  if (std::optional<Table> even = table.OptionalTable("even")) {
    freight.even = {.mass = even->Number("mass", kMass), .density = even->Number("density", Range::Positive("kg/m^3"))};
  }
  for (const Table& box : table.OptionalTables("boxes"))
    freight.boxes.push_back(ReadBox(box, freight.boxes.size() + 1));
  table.Finish();
  return freight;
}

Freight ReadFreight(const std::filesystem::path& path) { return ParseFreight(ReadFileWhole(path), path.string()); }

std::vector<FreightBox> PlaceFreight(const Freight& freight, const CargoSpace& cargo) {
  std::vector<FreightBox> boxes;
  if (freight.even) {
    boxes.push_back({.name = freight.name,
                     .mass = freight.even->mass,
                     .length = cargo.length,
                     .width = cargo.width,
                     .height = freight.even->mass / (freight.even->density * cargo.length * cargo.width)});
  }
  boxes.insert(boxes.end(), freight.boxes.begin(), freight.boxes.end());
  return boxes;
}

std::vector<std::string> CheckFreight(const Freight& freight, const CargoSpace& cargo) {
  std::vector<std::string> notices;
  for (const FreightBox& box : PlaceFreight(freight, cargo)) CheckBox(box, cargo, &notices);
  return notices;
}

}  // namespace uiclink
