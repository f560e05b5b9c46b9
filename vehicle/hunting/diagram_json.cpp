// The diagram as JSON and as columns.

#include <algorithm>
#include <nlohmann/json.hpp>

#include "vehicle/hunting/branch_start.h"
#include "vehicle/hunting/diagram_report.h"
#include "vehicle/hunting/hunting_json.h"

namespace uiclink {
namespace {

/// Multipliers that are written for a point; the rest lie well within the unit circle.
constexpr std::size_t kLeading = 8;

/// Where something lies on a diagram: { "speed" }, or { "speed", "value" } of another parameter.
Json PlaceToJson(const DiagramParameter& parameter, double lambda) {
  if (parameter.is_speed()) return {{"speed", lambda}};
  return {{"speed", *parameter.speed}, {"value", lambda}};
}

/// { "name", "unit" }, for another parameter than the speed also "own_value", "speed".
Json ParameterToJson(const DiagramParameter& parameter) {
  Json json{{"name", parameter.name}, {"unit", parameter.unit}};
  if (parameter.is_speed()) return json;
  json["own_value"] = parameter.own;
  json["speed"] = *parameter.speed;
  return json;
}

Json MultipliersToJson(const Cycle& cycle) {
  Json json = Json::array();
  for (std::size_t i = 0; i < std::min(kLeading, cycle.multipliers.size()); ++i)
    json.push_back({cycle.multipliers[i].real(), cycle.multipliers[i].imag()});
  return json;
}

Json PointToJson(const DiagramParameter& parameter, const Cycle& cycle) {
  Json json = PlaceToJson(parameter, cycle.lambda);
  json.update({{"amplitude_mm", AmplitudesToJson(HalfWidthsOf(cycle))},
               {"period_s", cycle.period},
               {"multipliers", MultipliersToJson(cycle)},
               {"unstable", cycle.unstable},
               {"trivial_error", cycle.trivial_error},
               {"character", cycle.passage.character}});
  return json;
}

Json EventNameOrNull(const BranchEvent* event) { return event ? Json(BranchEventName(event->kind)) : Json(nullptr); }

Json StretchToJson(const DiagramParameter& parameter, const BranchStretch& stretch, std::size_t branch,
                   const HuntingBranch& hunting) {
  Json json{{"stable", stretch.stable},
            {"branch", branch + 1},
            {"origin", hunting.origin},
            {"unstable_multipliers", stretch.unstable},
            {"begins_with", EventNameOrNull(stretch.begin)},
            {"ends_with", EventNameOrNull(stretch.end)},
            {"points", Json::array()}};
  for (const Cycle* const cycle : stretch.cycles) json["points"].push_back(PointToJson(parameter, *cycle));
  return json;
}

Json EventToJson(const DiagramParameter& parameter, const BranchEvent& event, std::size_t branch) {
  Json json{{"kind", BranchEventName(event.kind)}};
  json.update(PlaceToJson(parameter, event.lambda));
  json.update({{"branch", branch + 1},
               {"period_s", event.period},
               {"amplitude_mm", AmplitudesToJson(HalfWidthsOf(event.cycle))},
               {"multipliers", MultipliersToJson(event.cycle)},
               {"text", event.text}});
  if (event.kind == BranchEventKind::kFold) json["at_corner"] = event.at_corner;
  return json;
}

Json HopfToJson(const DiagramParameter& parameter, const HopfPoint& hopf, const HopfOptions& options) {
  const CrossingType type = ToCrossingType(hopf, options);
  Json json = PlaceToJson(parameter, hopf.crossing.V);
  json.update({{"frequency_hz", hopf.crossing.frequency_hz},
               {"direction", hopf.crossing.to_unstable ? "unstable" : "stable"},
               {"type", type.type.empty() ? Json(nullptr) : Json(type.type)},
               {"type_decided_at_mm", 1e3 * type.decided_at},
               {"other_type_below_mm", type.other_below > 0 ? Json(1e3 * type.other_below) : Json(nullptr)},
               {"type_unknown_because", type.reason.empty() ? Json(nullptr) : Json(type.reason)},
               {"born", Json::array()}});
  for (const BornCycle& born : hopf.born) {
    Json one{{"size_mm", 1e3 * born.size}};
    one.update(PlaceToJson(parameter, born.speed));
    one["period_s"] = born.cycle.period;
    json["born"].push_back(std::move(one));
  }
  return json;
}

/// As in "wagon-stability/1".
Json LinearToJson(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  if (!diagram.linear.linear_critical_speed) return nullptr;
  Json json{{"value", *diagram.linear.linear_critical_speed}, {"frequency_hz", nullptr}, {"type", nullptr}};
  for (const HopfPoint& hopf : diagram.hopfs) {
    if (hopf.crossing.V != *diagram.linear.linear_critical_speed) continue;
    json = HopfToJson(diagram.parameter, hopf, run.options.hopf);
    json["value"] = hopf.crossing.V;
  }
  return json;
}

Json NonlinearToJson(const BifurcationDiagram& diagram, const DiagramOptions& options) {
  if (!diagram.nonlinear) return nullptr;
  Json json{{"value", diagram.nonlinear->speed}, {"by", diagram.nonlinear->by}, {"branch", nullptr}};
  json["is_upper_bound"] = IsAtBound(*diagram.nonlinear, options);
  if (diagram.nonlinear->by != "trace") json["branch"] = diagram.nonlinear->branch + 1;
  return json;
}

Json WindowToJson(const OpenWindow& window) {
  return {{"from", window.from},
          {"to", window.to},
          {"way", WayName(window.leg)},
          {"why", window.why},
          {"looked_at", window.speed},
          {"motion", MotionToJson(window.outcome.motion)},
          {"amplitude_mm", AmplitudesToJson(window.outcome.half_width)},
          {"lyapunov", LyapunovToJson(window.lyapunov)}};
}

void AddBranches(const BifurcationDiagram& diagram, Json* json) {
  Json branches = Json::array(), folds = Json::array(), events = Json::array(), ends = Json::array();
  for (std::size_t i = 0; i < diagram.branches.size(); ++i) {
    const Branch& branch = diagram.branches[i].branch;
    for (const BranchStretch& stretch : ListStretches(branch))
      branches.push_back(StretchToJson(diagram.parameter, stretch, i, diagram.branches[i]));
    for (const BranchEvent& event : branch.events) {
      events.push_back(EventToJson(diagram.parameter, event, i));
      if (event.kind == BranchEventKind::kFold) folds.push_back(events.back());
    }
    ends.push_back({{"branch", i + 1},
                    {"origin", diagram.branches[i].origin},
                    {"begins", branch.begin ? Json(DescribeEnd(*branch.begin, branch.begin_reason)) : Json(nullptr)},
                    {"ends", DescribeEnd(branch.end, branch.reason)},
                    {"points", branch.points.size()},
                    {"passages", branch.passages},
                    {"passages_with_derivatives", branch.passages_with_derivatives}});
  }
  (*json)["branches"] = std::move(branches);
  (*json)["folds"] = std::move(folds);
  (*json)["events"] = std::move(events);
  (*json)["followed"] = std::move(ends);
}

void AddCoarseTrace(const BifurcationDiagram& diagram, Json* json) {
  (*json)["coarse_trace"] = Json::array();
  for (const TraceRow& row : diagram.trace)
    (*json)["coarse_trace"].push_back(
        {{"speed", row.V}, {"way", row.leg == 0 ? "down" : "up"}, {"amplitude_mm", AmplitudesToJson(row.half_width)}});
}

Json DelayToJson(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  const TraceDelay delay = CalcTraceDelay(CalcLegFigures(*run.trace), diagram.linear.linear_critical_speed,
                                          diagram.nonlinear ? std::optional(diagram.nonlinear->speed) : std::nullopt);
  const auto number = [](const std::optional<double>& x) { return x ? Json(*x) : Json(nullptr); };
  return {{"onset_m_per_s", number(delay.onset)}, {"death_m_per_s", number(delay.death)}};
}

}  // namespace

std::string FormatBifurcationJson(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  Json json = BeginResult("bifurcation", run.inputs);
  json["method"] = run.method;
  json["parameter"] = ParameterToJson(diagram.parameter);
  json["linear_critical_speed"] = LinearToJson(run);
  json["nonlinear_critical_speed"] = NonlinearToJson(diagram, run.options);
  AddBranches(diagram, &json);
  json["searched"] = {{"from", run.options.from}, {"to", run.options.to}};
  json["crossings"] = Json::array();
  for (const HopfPoint& hopf : diagram.hopfs)
    json["crossings"].push_back(HopfToJson(diagram.parameter, hopf, run.options.hopf));
  json["equilibrium"] = Json::array();
  for (const EquilibriumStretch& stretch : ListEquilibriumStretches(diagram, run.options))
    json["equilibrium"].push_back({{"from", stretch.from}, {"to", stretch.to}, {"unstable", stretch.unstable}});
  json["windows"] = Json::array();
  for (const OpenWindow& window : diagram.windows) json["windows"].push_back(WindowToJson(window));
  if (run.continued) {
    if (diagram.parameter.is_speed()) AddCoarseTrace(diagram, &json);
    json["worst_trivial_error"] = CalcWorstTrivialError(diagram);
    json["cycle_tolerance"] = run.options.tolerance;
  }
  if (run.trace) {
    json["trace"] = TraceToJson(*run.trace);
    json["trace_delay"] = DelayToJson(run);
  }
  if (run.survey) json["survey"] = SurveyToJson(*run.survey, run.survey_options);
  json["notices"] = diagram.notices;
  json["interrupted"] = run.interrupted;
  json["wall_s"] = run.wall_s;
  return FormatJson(json);
}

std::vector<DataColumn> BranchColumns(const BifurcationRun& run) {
  std::vector<DataColumn> columns;
  const auto add = [&](const std::string& name, const std::string& unit, const auto& value) {
    columns.push_back({name, unit, {}});
    for (std::size_t i = 0; i < run.diagram.branches.size(); ++i)
      for (const Cycle& cycle : run.diagram.branches[i].branch.points)
        columns.back().values.push_back(static_cast<double>(value(i, cycle)));
  };
  add("branch", "", [](std::size_t i, const Cycle&) { return i + 1; });
  const DiagramParameter& parameter = run.diagram.parameter;
  add("speed", "m/s", [&](std::size_t, const Cycle& cycle) { return parameter.speed.value_or(cycle.lambda); });
  if (!parameter.is_speed())
    add(LabelOf(parameter), parameter.unit, [](std::size_t, const Cycle& cycle) { return cycle.lambda; });
  add("period", "s", [](std::size_t, const Cycle& cycle) { return cycle.period; });
  for (std::size_t m = 0; m < kMotionCount; ++m) {
    const bool angle = m >= static_cast<std::size_t>(TrackedMotion::kBodyYaw);
    add(std::string(kMotionNames[m]) + "_amplitude", angle ? "mrad" : "mm",
        [m](std::size_t, const Cycle& cycle) { return 1e3 * cycle.Amplitude(static_cast<int>(m)); });
  }
  add("stable", "", [](std::size_t, const Cycle& cycle) { return cycle.stable() ? 1 : 0; });
  add("unstable_multipliers", "", [](std::size_t, const Cycle& cycle) { return cycle.unstable; });
  add("multipliers_one", "", [](std::size_t, const Cycle& cycle) { return cycle.multipliers_one; });
  add("multipliers_zero", "", [](std::size_t, const Cycle& cycle) { return cycle.multipliers_zero; });
  add("trivial_error", "", [](std::size_t, const Cycle& cycle) { return cycle.trivial_error; });
  add("residual", "", [](std::size_t, const Cycle& cycle) { return cycle.residual; });
  for (std::size_t k = 0; k < kLeading; ++k) {
    const auto part = [k](const Cycle& cycle) {
      return k < cycle.multipliers.size() ? cycle.multipliers[k] : std::complex<double>(0);
    };
    add("multiplier_" + std::to_string(k + 1) + "_real", "",
        [part](std::size_t, const Cycle& c) { return part(c).real(); });
    add("multiplier_" + std::to_string(k + 1) + "_imaginary", "",
        [part](std::size_t, const Cycle& c) { return part(c).imag(); });
  }
  return columns;
}

}  // namespace uiclink
