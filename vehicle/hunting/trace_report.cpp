#include "vehicle/hunting/trace_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "reports/text_table.h"
#include "vehicle/hunting/hunting_json.h"

namespace uiclink {
namespace {

constexpr std::size_t kFront = static_cast<std::size_t>(TrackedMotion::kFrontLateral);

Json SpeedOrNull(const std::optional<double>& speed) { return speed ? Json(*speed) : Json(nullptr); }
std::string SpeedOrDash(const std::optional<double>& speed) { return speed ? fmt::format("{:.2f}", *speed) : "-"; }

DataColumn MakeColumn(const std::string& name, const std::string& unit, const std::vector<TraceRow>& rows,
                      const std::function<double(const TraceRow&)>& value) {
  DataColumn column{name, unit, {}};
  column.values.reserve(rows.size());
  for (const TraceRow& row : rows) column.values.push_back(value(row));
  return column;
}

}  // namespace

std::vector<LegFigures> CalcLegFigures(const TraceRun& run) {
  std::vector<LegFigures> legs(run.options.legs.size());
  double from = run.options.from;
  for (std::size_t leg = 0; leg < legs.size(); ++leg) {
    legs[leg].from = from;
    from = legs[leg].to = run.options.legs[leg].to;
  }
  for (const TraceRow& row : run.rows) {
    LegFigures& leg = legs.at(row.leg);
    if (row.half_width[kFront] <= leg.largest) continue;
    leg.largest = row.half_width[kFront];
    leg.at = row.V;
  }
  for (const TraceJump& jump : FindTraceJumps(run.rows).jumps) {
    LegFigures& leg = legs.at(jump.leg);
    if (jump.kind == TraceJump::Kind::kDeath) leg.death = jump.V;
    if (jump.kind == TraceJump::Kind::kOnset && !leg.onset) leg.onset = jump.V;
  }
  return legs;
}

TraceDelay CalcTraceDelay(const std::vector<LegFigures>& legs, std::optional<double> linear_critical,
                          std::optional<double> nonlinear_critical) {
  TraceDelay delay;
  for (const LegFigures& leg : legs) {
    const bool up = leg.to > leg.from;
    if (up && leg.onset && linear_critical && !delay.onset) delay.onset = *leg.onset - *linear_critical;
    if (!up && leg.death && nonlinear_critical && !delay.death) delay.death = *leg.death - *nonlinear_critical;
  }
  return delay;
}

TextTable MakeTraceTable(const TraceRun& run) {
  TextTable table;
  for (const char* head : {"leg", "from\n[m/s]", "to\n[m/s]", "step\n[m/s]", "hunting sets in\nat [m/s]",
                           "it dies\nat [m/s]", "largest front\n[mm]", "at\n[m/s]"})
    table.AddColumn(head);
  const std::vector<LegFigures> legs = CalcLegFigures(run);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const LegFigures& leg = legs[i];
    table.AddRow({fmt::format("{}", i + 1), fmt::format("{:g}", leg.from), fmt::format("{:g}", leg.to),
                  fmt::format("{:g}", run.options.legs[i].step), SpeedOrDash(leg.onset), SpeedOrDash(leg.death),
                  fmt::format("{:.3f}", 1e3 * leg.largest), leg.at > 0 ? fmt::format("{:.2f}", leg.at) : "-"});
  }
  return table;
}

std::string FormatTraceLegs(const TraceRun& run) {
  std::string text = fmt::format("{:g} s at every speed, the last {:g} s count; {} speeds in {:.1f} s of computing.\n",
                                 run.options.hold, run.options.window, run.rows.size(), run.wall_s) +
                     MakeTraceTable(run).Format();
  if (!run.complete) text += fmt::format("The trace ended early: {}.\n", run.end_reason);
  return text;
}

Json TraceToJson(const TraceRun& run) {
  Json json{{"from", run.options.from},
            {"hold_s", run.options.hold},
            {"window_s", run.options.window},
            {"disturbance_mm", 1e3 * run.options.disturbance},
            {"tolerance", run.options.integrator.tolerance},
            {"complete", run.complete},
            {"end_reason", run.complete ? Json(nullptr) : Json(run.end_reason)},
            {"wall_s", run.wall_s}};
  json["legs"] = Json::array();
  const std::vector<LegFigures> legs = CalcLegFigures(run);
  for (std::size_t i = 0; i < legs.size(); ++i) {
    json["legs"].push_back({{"from", legs[i].from},
                            {"to", legs[i].to},
                            {"step", run.options.legs[i].step},
                            {"onset", SpeedOrNull(legs[i].onset)},
                            {"death", SpeedOrNull(legs[i].death)},
                            {"largest_front_lateral_mm", 1e3 * legs[i].largest},
                            {"largest_at", legs[i].at}});
  }
  json["points"] = Json::array();
  for (const TraceRow& row : run.rows) {
    json["points"].push_back({{"speed", row.V},
                              {"leg", row.leg + 1},
                              {"amplitude_mm", AmplitudesToJson(row.half_width)},
                              {"derailed", row.derailed}});
  }
  return json;
}

std::vector<DataColumn> TraceColumns(const std::vector<TraceRow>& rows) {
  std::vector<DataColumn> columns;
  columns.push_back(MakeColumn("leg", "", rows, [](const TraceRow& row) { return static_cast<double>(row.leg + 1); }));
  columns.push_back(MakeColumn("speed", "m/s", rows, [](const TraceRow& row) { return row.V; }));
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    const std::string unit = i < static_cast<std::size_t>(TrackedMotion::kBodyYaw) ? "mm" : "mrad";
    const std::string name = kMotionNames[i];
    columns.push_back(
        MakeColumn(name + "_amplitude", unit, rows, [i](const TraceRow& row) { return 1e3 * row.half_width[i]; }));
    columns.push_back(
        MakeColumn(name + "_largest", unit, rows, [i](const TraceRow& row) { return 1e3 * row.largest[i]; }));
  }
  constexpr std::array<const char*, kAxles> kAxleNames{"front", "rear"};
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const std::string name = kAxleNames[axle];
    columns.push_back(MakeColumn(name + "_lateral_clearance_used", "mm", rows,
                                 [axle](const TraceRow& row) { return 1e3 * row.lateral[axle].clearance_used; }));
    columns.push_back(MakeColumn(name + "_lateral_impacts", "", rows, [axle](const TraceRow& row) {
      return static_cast<double>(row.lateral[axle].impacts.count);
    }));
    columns.push_back(MakeColumn(name + "_lateral_impact_peak", "N", rows,
                                 [axle](const TraceRow& row) { return row.lateral[axle].impacts.peak_N; }));
    columns.push_back(MakeColumn(name + "_longitudinal_impacts", "", rows, [axle](const TraceRow& row) {
      return static_cast<double>(row.longitudinal[axle].impacts.count);
    }));
  }
  columns.push_back(
      MakeColumn("minimum_wheel_load", "N", rows, [](const TraceRow& row) { return row.minimum_wheel_load; }));
  columns.push_back(MakeColumn("wheel_lift", "", rows, [](const TraceRow& row) { return row.wheel_lift ? 1.0 : 0.0; }));
  return columns;
}

}  // namespace uiclink
