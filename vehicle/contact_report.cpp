#include "vehicle/contact_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "reports/text_table.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

constexpr double kPerDegree = std::numbers::pi / 180;

/// Second contacts of neighbouring rows at one place, told as one.
struct TwoPointRange {
  double y_from = 0;
  double y_to = 0;
  bool root = false;          ///< one of the points is in the flange root or on the flange
  TwoPointContact narrowest;  ///< where the second point is least open
};

/// Steeper than any tread: the S1002 reaches 7 degrees where its root begins.
bool InRoot(const TwoPointContact& two) {
  constexpr double kSteepestTread = 12 * kPerDegree;
  return std::max(two.touching.delta, two.second.delta) > kSteepestTread;
}

std::vector<TwoPointRange> CollectRanges(const std::vector<TwoPointContact>& contacts, double spacing) {
  std::vector<TwoPointRange> ranges;
  for (const TwoPointContact& two : contacts) {
    const bool root = InRoot(two);
    if (ranges.empty() || two.y - ranges.back().y_to > 1.5 * spacing || root != ranges.back().root) {
      ranges.push_back({.y_from = two.y, .y_to = two.y, .root = root, .narrowest = two});
    }
    TwoPointRange& range = ranges.back();
    range.y_to = two.y;
    if (two.gap < range.narrowest.gap) range.narrowest = two;
  }
  return ranges;
}

std::vector<TwoPointRange> CollectRanges(const WagonInputs& inputs) {
  return CollectRanges(inputs.contact_notes->two_point, 2 * inputs.geometry->y_max / (inputs.geometry->rows - 1));
}

const char* NameOf(const TwoPointRange& range) { return range.root ? "flange root" : "tread"; }

/// Rows of a table near round displacements, for a person to read.
std::vector<ContactRow> PickRows(const ContactTable& table) {
  std::vector<ContactRow> picked;
  for (const double y_mm : {-8, -6, -4, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8}) {
    const auto nearest =
        std::ranges::min_element(table.rows, {}, [&](const ContactRow& row) { return std::abs(row.y - y_mm / 1e3); });
    const bool known = !picked.empty() && picked.back().y == nearest->y;
    if (!known && std::abs(nearest->y - y_mm / 1e3) < 0.5e-3) picked.push_back(*nearest);
  }
  return picked;
}

/// The least is that of "centre_conicity" [m].
std::vector<double> Amplitudes() {
  std::vector<double> amplitudes{0.1e-3, 0.5e-3};
  for (int mm = 1; mm <= 8; ++mm) amplitudes.push_back(mm / 1e3);
  return amplitudes;
}

/// As EN 15302 wants it: rigid contact, no roll. Empty where the geometry has no contact there.
RollingRadiusDifference CalcRigidDifference(const TrackGeometry& geometry) {
  constexpr double kStep = 0.05e-3;
  return CalcRollingRadiusDifference(WheelsetOnRails(geometry), geometry.y_max, kStep, {.roll = false});
}

// --- text ---

std::string FormatGeometry(const WagonInputs& inputs) {
  const ContactTable& table = inputs.table;
  if (!inputs.geometry)
    return fmt::format("{}: a table of {} rows, r0 {:g} mm\n", table.name, table.rows.size(), 1e3 * table.r0);
  const TrackGeometry& g = *inputs.geometry;
  std::string text = fmt::format(
      "{}: {} on {} 1:{:g}, gauge {:g} mm at {:g} mm below the top, back-to-back {:g} mm, r0 {:g} mm", g.name, g.wheel,
      g.rail, 1 / g.cant, 1e3 * g.gauge, 1e3 * g.gauge_depth, 1e3 * g.back_to_back, 1e3 * g.r0);
  if (g.rail_offset != 0) text += fmt::format(", each rail {:g} mm further out", 1e3 * g.rail_offset);
  return text + fmt::format("\n{} contact under {:g} N on each wheel, {} rows\n", Name(g.contact), g.wheel_load,
                            table.rows.size());
}

std::string FormatRatio(double value) { return std::isfinite(value) ? fmt::format("{:.4f}", value) : "-"; }

std::string FormatJumps(const ContactNotes& notes) {
  std::string text;
  for (const Jump& jump : notes.jumps) {
    text += fmt::format("  at y = {:.4f} mm from {:.2f} to {:.2f} mm on the wheel, rolling radius by {:+.3f} mm\n",
                        1e3 * jump.y, 1e3 * jump.before.y_wheel, 1e3 * jump.after.y_wheel,
                        1e3 * (jump.after.r - jump.before.r));
  }
  return text.empty() ? "The contact does not jump.\n"
                      : "Jumps of the contact (left wheel; from the tape circle, flange negative):\n" + text;
}

std::string FormatTwoPointContact(const WagonInputs& inputs) {
  std::string text;
  for (const TwoPointRange& range : CollectRanges(inputs)) {
    const TwoPointContact& two = range.narrowest;
    text += fmt::format("  y = {:.2f} to {:.2f} mm, {}: at {:.2f} and {:.2f} mm on the wheel ({:.1f} and {:.1f} deg)\n",
                        1e3 * range.y_from, 1e3 * range.y_to, NameOf(range), 1e3 * two.touching.y_wheel,
                        1e3 * two.second.y_wheel, two.touching.delta / kPerDegree, two.second.delta / kPerDegree);
  }
  if (text.empty()) return "No contact at two points under this load.\n";
  return "Two points carry load (the second is open by less than the approach of the first):\n" + text;
}

// --- JSON ---

Json RowsToJson(const ContactTable& table) {
  Json rows = Json::array();
  for (const ContactRow& row : PickRows(table)) {
    Json json = Json::object();
    for (const ContactColumn& column : kContactColumns) json[std::string(column.name)] = row.*column.value;
    rows.push_back(std::move(json));
  }
  return rows;
}

Json ConicityToJson(const ContactAnalysis& analysis) {
  Json points = Json::array();
  for (const ConicityPoint& point : analysis.conicity) {
    points.push_back({{"amplitude", point.amplitude},
                      {"equivalent", NumberOrNull(point.equivalent)},
                      {"harmonic", NumberOrNull(point.harmonic)},
                      {"en15302", NumberOrNull(point.en15302)}});
  }
  return points;
}

/// Every tenth point, and both sides of jumps.
Json DifferenceToJson(const RollingRadiusDifference& difference) {
  Json points = Json::array();
  for (std::size_t i = 0; i < difference.y.size(); ++i) {
    const bool jump = (i > 0 && difference.y[i - 1] == difference.y[i]) ||
                      (i + 1 < difference.y.size() && difference.y[i + 1] == difference.y[i]);
    if (jump || i % 10 == 0 || i + 1 == difference.y.size())
      points.push_back({{"y", difference.y[i]}, {"delta_r", difference.delta_r[i]}});
  }
  return points;
}

Json PointToJson(const ContactCandidate& point) {
  return {{"a_wheel", point.a_wheel}, {"a_rail", point.a_rail}, {"r", point.r}, {"delta", point.delta}};
}

Json JumpsToJson(const ContactNotes& notes) {
  Json jumps = Json::array();
  for (const Jump& jump : notes.jumps)
    jumps.push_back({{"y", jump.y}, {"before", PointToJson(jump.before)}, {"after", PointToJson(jump.after)}});
  return jumps;
}

Json TwoPointToJson(const WagonInputs& inputs) {
  Json ranges = Json::array();
  for (const TwoPointRange& range : CollectRanges(inputs)) {
    ranges.push_back({{"y_from", range.y_from},
                      {"y_to", range.y_to},
                      {"where", NameOf(range)},
                      {"touching_a_wheel", range.narrowest.touching.a_wheel},
                      {"second_a_wheel", range.narrowest.second.a_wheel},
                      {"touching_delta", range.narrowest.touching.delta},
                      {"second_delta", range.narrowest.second.delta},
                      {"least_gap", range.narrowest.gap}});
  }
  return ranges;
}

// --- figures ---

/// A quantity of the rows over y; at a jump the line is broken.
FigureSeries SeriesOf(const ContactTable& table, const std::string& name, double ContactRow::*value, double scale) {
  FigureSeries series{.name = name};
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const ContactRow& row = table.rows[i];
    if (i > 0 && table.rows[i - 1].y == row.y) {
      series.x.push_back(1e3 * row.y);
      series.y.push_back(std::numeric_limits<double>::quiet_NaN());
    }
    series.x.push_back(1e3 * row.y);
    series.y.push_back(scale * row.*value);
  }
  return series;
}

FigurePanel PanelOf(const std::string& title, FigureAxis axis, std::vector<FigureSeries> series) {
  return {.title = title,
          .x = {.label = "lateral displacement y", .unit = "mm"},
          .y = std::move(axis),
          .series = std::move(series)};
}

}  // namespace

TextTable MakeContactRowTable(const ContactTable& table) {
  TextTable text;
  for (const char* head : {"y\nmm", "rolling radius\nmm", "angle\ndeg", "on wheel\nmm", "on rail\nmm", "a\nmm", "b\nmm",
                           "approach\num", "normal force\nN", "lift\nmm", "roll\nmrad"})
    text.AddColumn(head);
  for (const ContactRow& row : PickRows(table)) {
    text.AddRow({fmt::format("{:.2f}", 1e3 * row.y), fmt::format("{:.3f}", 1e3 * row.r),
                 fmt::format("{:.2f}", row.delta / kPerDegree), fmt::format("{:.2f}", 1e3 * row.a_wheel),
                 fmt::format("{:.2f}", 1e3 * row.a_rail), fmt::format("{:.2f}", 1e3 * row.a_e),
                 fmt::format("{:.2f}", 1e3 * row.b_e), fmt::format("{:.1f}", 1e6 * row.q0),
                 fmt::format("{:.0f}", row.n0), fmt::format("{:.3f}", 1e3 * row.z_lift),
                 fmt::format("{:.3f}", 1e3 * row.phi_roll)});
  }
  return text;
}

TextTable MakeConicityTable(const ContactAnalysis& analysis) {
  TextTable text;
  text.AddColumn("amplitude\nmm");
  text.AddColumn("conicity\nthis table");
  text.AddColumn("first\nharmonic");
  text.AddColumn("EN 15302\nrigid, no roll");
  for (const ConicityPoint& point : analysis.conicity) {
    text.AddRow({fmt::format("{:g}", 1e3 * point.amplitude), FormatRatio(point.equivalent), FormatRatio(point.harmonic),
                 FormatRatio(point.en15302)});
  }
  return text;
}

TextTable MakeJumpTable(const ContactNotes& notes) {
  TextTable table;
  for (const char* head : {"jump at y\nmm", "on wheel, from\nmm", "to\nmm", "rolling radius by\nmm"})
    table.AddColumn(head);
  for (const Jump& jump : notes.jumps)
    table.AddRow({fmt::format("{:.4f}", 1e3 * jump.y), fmt::format("{:.2f}", 1e3 * jump.before.y_wheel),
                  fmt::format("{:.2f}", 1e3 * jump.after.y_wheel),
                  fmt::format("{:+.3f}", 1e3 * (jump.after.r - jump.before.r))});
  return table;
}

TextTable MakeTwoPointTable(const WagonInputs& inputs) {
  TextTable table;
  for (const char* head : {"y from\nmm", "to\nmm"}) table.AddColumn(head);
  table.AddColumn("where", TextTable::Align::kLeft);
  for (const char* head : {"on wheel, first\nmm", "second\nmm", "angle, first\ndeg", "second\ndeg"})
    table.AddColumn(head);
  for (const TwoPointRange& range : CollectRanges(inputs)) {
    const TwoPointContact& two = range.narrowest;
    table.AddRow({fmt::format("{:.2f}", 1e3 * range.y_from), fmt::format("{:.2f}", 1e3 * range.y_to), NameOf(range),
                  fmt::format("{:.2f}", 1e3 * two.touching.y_wheel), fmt::format("{:.2f}", 1e3 * two.second.y_wheel),
                  fmt::format("{:.1f}", two.touching.delta / kPerDegree),
                  fmt::format("{:.1f}", two.second.delta / kPerDegree)});
  }
  return table;
}

ContactAnalysis AnalyseContact(const WagonInputs& inputs) {
  ContactAnalysis analysis;
  if (inputs.geometry) analysis.rigid_difference = CalcRigidDifference(*inputs.geometry);
  analysis.difference = CalcRollingRadiusDifference(inputs.table);
  for (const double amplitude : Amplitudes()) {
    if (amplitude >= analysis.difference.y.back()) break;
    analysis.conicity.push_back({.amplitude = amplitude,
                                 .equivalent = CalcEquivalentConicity(analysis.difference, amplitude),
                                 .harmonic = CalcHarmonicConicity(analysis.difference, amplitude),
                                 .en15302 = analysis.rigid_difference
                                                ? CalcEquivalentConicity(*analysis.rigid_difference, amplitude)
                                                : std::numeric_limits<double>::quiet_NaN()});
  }
  return analysis;
}

std::string FormatContact(const WagonInputs& inputs, const ContactAnalysis& analysis) {
  std::string text = FormatGeometry(inputs) + "\nLeft wheel, y > 0 towards its flange:\n" +
                     MakeContactRowTable(inputs.table).Format(2) + "\nEquivalent conicity:\n" +
                     MakeConicityTable(analysis).Format(2) + "\n";
  if (!inputs.contact_notes) return text;
  text += inputs.geometry->contact == ContactModel::kElastic ? "Elastic contact: the table has no jumps.\n"
                                                             : FormatJumps(*inputs.contact_notes);
  return text + FormatTwoPointContact(inputs) + fmt::format("Table in {:.0f} ms.\n", 1e3 * inputs.contact_wall_s);
}

std::string FormatContactJson(const WagonInputs& inputs, const ContactAnalysis& analysis) {
  Json json = BeginResult("contact", inputs);
  const ContactTable& table = inputs.table;
  json["table"] = {{"name", table.name},
                   {"r0", table.r0},
                   {"shear_modulus", table.shear_modulus},
                   {"contact", inputs.geometry ? Json(Name(inputs.geometry->contact)) : Json(nullptr)},
                   {"rows", table.rows.size()},
                   {"y_max", table.rows.back().y},
                   {"wall_s", inputs.contact_wall_s}};
  json["rows"] = RowsToJson(table);
  json["conicity"] = ConicityToJson(analysis);
  json["centre_conicity"] = analysis.conicity.empty() ? Json(nullptr) : json["conicity"][0]["equivalent"];
  json["rolling_radius_difference"] = DifferenceToJson(analysis.difference);
  json["jumps"] = inputs.contact_notes ? JumpsToJson(*inputs.contact_notes) : Json(nullptr);
  json["two_point_contact"] = inputs.contact_notes ? TwoPointToJson(inputs) : Json(nullptr);
  return FormatJson(json);
}

Figure ContactTableFigure(const WagonInputs& inputs) {
  const ContactTable& table = inputs.table;
  const auto one = [&](const std::string& title, FigureAxis axis, double ContactRow::*value, double scale) {
    return PanelOf(title, std::move(axis), {SeriesOf(table, "", value, scale)});
  };
  return {.title = "contact of the left wheel, " + table.name,
          .panels = {one("Kalker's coefficient C11", {.label = "C11"}, &ContactRow::c11, 1),
                     one("Kalker's coefficient C22", {.label = "C22"}, &ContactRow::c22, 1),
                     one("Kalker's coefficient C23", {.label = "C23"}, &ContactRow::c23, 1),
                     one("contact angle", {.label = "angle", .unit = "deg"}, &ContactRow::delta, 1 / kPerDegree),
                     PanelOf("contact ellipse", {.label = "semi-axis", .unit = "mm"},
                             {SeriesOf(table, "along rolling, a", &ContactRow::a_e, 1e3),
                              SeriesOf(table, "across, b", &ContactRow::b_e, 1e3)}),
                     one("contact point on the wheel, from the wheelset's centre", {.label = "distance", .unit = "mm"},
                         &ContactRow::a_wheel, 1e3),
                     one("contact point on the rail, from the track's centre", {.label = "distance", .unit = "mm"},
                         &ContactRow::a_rail, 1e3),
                     one("rolling radius", {.label = "radius", .unit = "mm"}, &ContactRow::r, 1e3),
                     one("normal force", {.label = "force", .unit = "N"}, &ContactRow::n0, 1),
                     one("static penetration", {.label = "approach", .unit = "um"}, &ContactRow::q0, 1e6),
                     one("height of the contact point on the rail", {.label = "height", .unit = "mm"},
                         &ContactRow::z_rail, 1e3),
                     one("lift of the wheelset", {.label = "lift", .unit = "mm"}, &ContactRow::z_lift, 1e3)},
          .columns = 3,
          .width = 1500};
}

Figure ConicityFigure(const WagonInputs& inputs, const ContactAnalysis& analysis) {
  FigureSeries difference{.name = ""};
  for (std::size_t i = 0; i < analysis.difference.y.size(); ++i) {
    difference.x.push_back(1e3 * analysis.difference.y[i]);
    difference.y.push_back(1e3 * analysis.difference.delta_r[i]);
  }
  FigureSeries table{.name = "this table"};
  FigureSeries standard{.name = "EN 15302: rigid, no roll", .line = FigureLine::kDashed};
  const double least = 0.05e-3;
  const double most = analysis.difference.y.back();
  for (double amplitude = least; amplitude < most; amplitude += least) {
    table.x.push_back(1e3 * amplitude);
    table.y.push_back(CalcEquivalentConicity(analysis.difference, amplitude));
    if (!analysis.rigid_difference) continue;
    standard.x.push_back(1e3 * amplitude);
    standard.y.push_back(CalcEquivalentConicity(*analysis.rigid_difference, amplitude));
  }
  std::vector<FigureSeries> conicity{std::move(table)};
  if (analysis.rigid_difference) conicity.push_back(std::move(standard));
  return {.title = "conicity, " + inputs.table.name,
          .panels = {PanelOf("rolling radius difference", {.label = "left less right", .unit = "mm"},
                             {std::move(difference)}),
                     {.title = "equivalent conicity",
                      .x = {.label = "amplitude", .unit = "mm"},
                      .y = {.label = "tan gamma", .low = 0},
                      .series = std::move(conicity)}},
          .columns = 2,
          .panel_height = 320};
}

}  // namespace uiclink
