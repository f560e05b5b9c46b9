#include "vehicle/wagon_data.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "data/file.h"
#include "data/table.h"

namespace uiclink {
namespace {

using Points = std::vector<std::array<double, 2>>;

/// Array of pairs; faulty rows are noted and come back as no points.
Points ReadPoints(Table& table, const std::string& key, std::size_t least) {
  const std::vector<std::vector<double>> rows = table.Rows(key, Range::Any("m"));
  Points points;
  for (const std::vector<double>& row : rows) {
    if (row.size() != 2) {
      table.Report(key, "pairs [a, b]", fmt::format("{} numbers in one of them", row.size()));
      return {};
    }
    points.push_back({row[0], row[1]});
  }
  if (table.Has(key) && points.size() < least) {
    table.Report(key, fmt::format("at least {} pairs", least), fmt::format("{}", points.size()));
  }
  return points;
}

void ReadSection(Table& table, WagonPart* part) {
  const int given = table.Has("point") + table.Has("line") + table.Has("area");
  if (given != 1) {
    table.Report("", "one of point, line and area", given == 0 ? "none of them" : fmt::format("{} of them", given));
  }
  if (table.Has("point")) {
    part->kind = SectionKind::kPoint;
    const std::vector<double> point = table.Numbers("point", Range::Any("m"));
    if (point.size() == 2) {
      part->section = {{point[0], point[1]}};
    } else {
      table.Report("point", "a pair [y, z]", fmt::format("{} numbers", point.size()));
    }
  }
  if (table.Has("line")) {
    part->kind = SectionKind::kLine;
    part->section = ReadPoints(table, "line", 2);
  }
  if (table.Has("area")) {
    part->kind = SectionKind::kArea;
    part->section = ReadPoints(table, "area", 3);
  }
}

/// A polyline without length or a polygon without area cannot carry mass.
void CheckExtent(Table& table, const WagonPart& part) {
  if (part.section.empty() || part.kind == SectionKind::kPoint) return;
  double twice_area = 0, box = 0;
  for (std::size_t i = 0; i < part.section.size(); ++i) {
    const auto& p = part.section[i];
    const auto& q = part.section[(i + 1) % part.section.size()];
    twice_area += p[0] * q[1] - q[0] * p[1];
    box += std::abs(q[0] - p[0]) + std::abs(q[1] - p[1]);
  }
  if (!(box > 0)) table.Report("line", "corners that differ", "one place");
  // 1e-9 of the square of its size: rounding of the corners' coordinates, no real plate is that thin.
  if (part.kind == SectionKind::kArea && !(std::abs(twice_area) > 1e-9 * box * box)) {
    table.Report("area", "a polygon with an area", "corners in one line");
  }
}

WagonPart ReadPart(Table table) {
  WagonPart part;
  part.name = table.String("name");
  part.mass = table.Number("mass", {.unit = "kg", .low = 1e-3, .high = 1e6});
  ReadSection(table, &part);
  CheckExtent(table, part);
  part.length = table.OptionalNumber("length", Range::NotNegative("m")).value_or(0);
  part.at = ReadPoints(table, "at", 1);
  if (table.Has("at_spread")) {
    part.at_spread = ReadPoints(table, "at_spread", 1);
    if (part.at_spread.size() != part.at.size()) {
      table.Report("at_spread", fmt::format("{} places as in at", part.at.size()),
                   fmt::format("{}", part.at_spread.size()));
    }
  }
  part.printed_com_mass = table.OptionalNumber("printed_com_mass", Range::NotNegative("kg"));
  if (table.Has("printed_yaw_weights")) {
    part.printed_yaw_weights = table.Numbers("printed_yaw_weights", Range::NotNegative("-"));
    const std::size_t pieces = part.kind == SectionKind::kLine && !part.section.empty() ? part.section.size() - 1 : 0;
    if (part.printed_yaw_weights.size() != pieces) {
      table.Report("printed_yaw_weights", fmt::format("one number for each of the {} pieces of line", pieces),
                   fmt::format("{}", part.printed_yaw_weights.size()));
    }
  }
  return part;
}

/// A table that must be there; the stand-in of a missing one reports its keys as missing, too.
std::optional<Table> Required(Table& table, const std::string& key) {
  if (!table.Has(key)) table.Report("", "a table [" + key + "]", "none");
  return table.OptionalTable(key);
}

GuidanceStop ReadStop(Table& table, const std::string& key) {
  GuidanceStop stop;
  if (std::optional<Table> part = Required(table, key)) {
    stop.clearance = part->Number("clearance", Range::NotNegative("m"));
    stop.k = part->Number("k", {.unit = "N/m", .low = 1, .high = 1e12});
  }
  return stop;
}

void ReadSprings(Table& file, WagonData* wagon) {
  if (std::optional<Table> table = Required(file, "linear_vertical")) {
    wagon->linear_vertical.k = table->Number("k", Range::Positive("N/m"));
    wagon->linear_vertical.d = table->Number("d", Range::NotNegative("N s/m"));
  }
  if (std::optional<Table> table = Required(file, "parabolic")) {
    wagon->parabolic.F0 = table->Number("F0", Range::Positive("N"));
    wagon->parabolic.s0 = table->Number("s0", Range::Positive("m"));
    wagon->parabolic.k2 = table->Number("k2", Range::Positive("N/m"));
    wagon->parabolic.d_unloaded = table->Number("d_unloaded", Range::NotNegative("N s/m"));
    wagon->parabolic.d_loaded = table->Number("d_loaded", Range::NotNegative("N s/m"));
  }
  if (std::optional<Table> table = Required(file, "leaf")) {
    wagon->leaf.c = table->Number("c", Range::Positive("N/m"));
    wagon->leaf.mu0 = table->Number("mu0", {.unit = "-", .low = 0, .high = 1, .high_included = false});
    wagon->leaf.F_r = table->Number("F_r", Range::NotNegative("N"));
    wagon->leaf.beta = table->Number("beta", Range::Positive("m"));
  }
}

void ReadBodies(Table& file, WagonData* wagon) {
  if (std::optional<Table> table = Required(file, "wheelset")) {
    // Below, contact vibrates so fast that no run ends.
    const Range inertia{.unit = "kg m^2", .low = 1, .high = 1e6};
    wagon->wheelset.m = table->Number("m", {.unit = "kg", .low = 10, .high = 1e6});
    wagon->wheelset.I_x = table->Number("I_x", inertia);
    wagon->wheelset.I_y = table->Number("I_y", inertia);
    wagon->wheelset.I_z = table->Number("I_z", inertia);
  }
  if (std::optional<Table> table = Required(file, "cargo")) {
    wagon->cargo.floor = table->Number("floor", Range::Any("m"));
    wagon->cargo.length = table->Number("length", Range::Positive("m"));
    wagon->cargo.width = table->Number("width", Range::Positive("m"));
    wagon->cargo.height = table->Number("height", Range::Positive("m"));
    wagon->cargo.ridge_height = table->Number("ridge_height", Range::Positive("m"));
    wagon->cargo.ridge_width = table->Number("ridge_width", Range::NotNegative("m"));
  }
  const std::vector<Table> parts = file.Tables("parts");
  if (file.Has("parts") && parts.empty()) file.Report("parts", "at least one part of the car body", "none");
  for (const Table& part : parts) wagon->parts.push_back(ReadPart(part));
}

}  // namespace

WagonData ParseWagonData(std::string_view text, const std::string& file) {
  Table table = Table::Parse(text, file);
  WagonData wagon;
  wagon.name = table.String("name");
  wagon.source = table.String("source");
  wagon.g = table.Number("g", {.unit = "m/s^2", .low = 0.1, .high = 100});
  wagon.b = table.Number("b", {.unit = "m", .low = 0.1, .high = 10});
  wagon.l = table.Number("l", {.unit = "m", .low = 0.1, .high = 100});
  if (std::optional<Table> guidance = Required(table, "guidance")) {
    wagon.guidance.longitudinal = ReadStop(*guidance, "longitudinal");
    wagon.guidance.lateral = ReadStop(*guidance, "lateral");
  }
  ReadSprings(table, &wagon);
  ReadBodies(table, &wagon);
  table.Finish();
  return wagon;
}

WagonData ReadWagonData(const std::filesystem::path& path) {
  return ParseWagonData(ReadFileWhole(path), path.string());
}

}  // namespace uiclink
