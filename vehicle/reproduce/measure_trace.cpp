// The thesis's bifurcation trace with the branches of cycles laid over: figures 10.1, 10.22, 10.23.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/equilibrium.h"
#include "vehicle/hunting/diagram_report.h"
#include "vehicle/reproduce/measure.h"
#include "vehicle/reproduce/motion.h"

namespace uiclink::reproduce {
namespace {

constexpr double kNear = 2;    // [m/s]: what counts as near the Hopf point
constexpr double kLoop = 0.5;  // [m/s]: hunting this far below it makes a hysteresis loop

std::string Join(const std::vector<std::string>& words) {
  return words.empty() ? "none" : fmt::format("{}", fmt::join(words, "; "));
}

/// The first speed downwards at which a wheelset hits its guide.
Value FirstImpact(const Trace& trace, std::size_t leg, std::size_t axle) {
  const auto row = std::ranges::find_if(
      trace.rows, [&](const TraceRow& r) { return r.leg == leg && r.lateral[axle].impacts.count > 0; });
  return row != trace.rows.end() ? Value(row->V) : Value();
}

void AddTraceValues(const TraceRun& run, const Trace& trace, ItemResult* result) {
  const std::vector<LegFigures> legs = CalcLegFigures(run);
  const std::size_t down = legs.size() - 1;
  result->values["onset"] = ToValue(legs.front().onset);
  result->values["death"] = ToValue(legs[down].death);
  const auto largest = std::ranges::max_element(legs, {}, &LegFigures::largest);
  result->values["largest_mm"] = 1e3 * largest->largest;
  result->values["largest_at"] = largest->at;
  result->values["front_hits_below"] = FirstImpact(trace, down, 0);
  result->values["rear_hits_below"] = FirstImpact(trace, down, 1);
  const auto hits = [&](auto guide, std::size_t axle) {
    return std::ranges::any_of(trace.rows, [&](const TraceRow& r) { return (r.*guide)[axle].impacts.count > 0; });
  };
  result->values["impacts"] = NameImpacts(hits(&TraceRow::lateral, 0), hits(&TraceRow::lateral, 1));
  result->values["longitudinal_impacts"] =
      NameImpacts(hits(&TraceRow::longitudinal, 0), hits(&TraceRow::longitudinal, 1));
  // The equilibrium that is left at the end, where hunting has died.
  const bool dead = legs[down].death && trace.complete;
  result->values["shift_after_lap"] = dead ? Value(1e3 * std::abs(trace.end.state.x[wheelset::kY])) : Value();
}

/// Folds of the branch that begins at the first Hopf point.
void AddFolds(const BifurcationDiagram& diagram, ItemResult* result) {
  const auto born =
      std::ranges::find_if(diagram.branches, [](const HuntingBranch& b) { return b.origin.starts_with("born"); });
  if (born == diagram.branches.end() || diagram.hopfs.empty()) return;
  const double hopf = diagram.hopfs.front().crossing.V;
  std::vector<double> folds;
  for (const BranchEvent& event : born->branch.events)
    if (event.kind == BranchEventKind::kFold) folds.push_back(event.lambda);
  const auto above = std::ranges::find_if(folds, [&](double V) { return V > hopf && V < hopf + kNear; });
  result->values["fold_above_hopf"] = above != folds.end() ? Value(*above) : Value();
  result->values["born_folds"] =
      static_cast<double>(std::ranges::count_if(folds, [&](double V) { return std::abs(V - hopf) < kNear; }));
  std::vector<std::string> words;
  for (const double V : folds) words.push_back(fmt::format("{:.3f}", V));
  result->values["folds_of_born_branch"] = Join(words);
}

/// Stretches of all branches in order along them, and what happens on them.
void AddBranches(const BifurcationDiagram& diagram, ItemResult* result) {
  std::vector<std::string> words, tori;
  Value highest;
  for (const HuntingBranch& hunting : diagram.branches) {
    std::string along;
    for (const BranchStretch& stretch : ListStretches(hunting.branch)) {
      if (stretch.cycles.empty()) continue;
      along += fmt::format("{}{} {:.3f} to {:.3f}{}", along.empty() ? "" : ", ", stretch.stable ? "stable" : "unstable",
                           stretch.cycles.front()->lambda, stretch.cycles.back()->lambda,
                           stretch.end != nullptr ? fmt::format(" ({})", BranchEventName(stretch.end->kind)) : "");
    }
    words.push_back(fmt::format("{}: {}", hunting.origin, along));
    for (const BranchEvent& event : hunting.branch.events) {
      if (event.kind != BranchEventKind::kTorus) continue;
      tori.push_back(fmt::format("{:.2f}", event.lambda));
      const double* const so_far = std::get_if<double>(&highest);
      if (so_far == nullptr || event.lambda > *so_far) highest = event.lambda;
    }
  }
  result->values["highest_torus"] = highest;
  result->values["branches"] = Join(words);
  result->values["torus_points"] = Join(tori);
}

void AddWindows(const BifurcationDiagram& diagram, ItemResult* result) {
  std::vector<std::string> words;
  for (const OpenWindow& window : diagram.windows) {
    const SectionMotion& motion = window.outcome.motion;
    std::string word = fmt::format("{:g} to {:g} m/s ({}: {}", window.from, window.to, window.leg == 0 ? "down" : "up",
                                   MotionKindName(motion.kind));
    if (motion.modulation_period > 0) word += fmt::format(", {:.1f} s", motion.modulation_period);
    if (window.lyapunov) word += fmt::format(", exponent {:.3f}/s", window.lyapunov->exponent);
    words.push_back(word + ")");
  }
  result->values["windows"] = Join(words);
}

void AddDiagramValues(const BifurcationDiagram& diagram, const TraceRun& trace, ItemResult* result) {
  const std::optional<double> hopf = diagram.linear.linear_critical_speed;
  std::optional<double> nonlinear;
  if (diagram.nonlinear) nonlinear = diagram.nonlinear->speed;
  result->values["hopf"] = ToValue(hopf);
  result->values["nonlinear_critical"] = ToValue(nonlinear);
  result->values["nonlinear_by"] = diagram.nonlinear ? Value(diagram.nonlinear->by) : Value();
  if (hopf && nonlinear) result->values["large_loop"] = *nonlinear < *hopf - kLoop ? "yes" : "no";
  const TraceDelay delay = CalcTraceDelay(CalcLegFigures(trace), hopf, nonlinear);
  result->values["onset_delay"] = ToValue(delay.onset);
  result->values["death_delay"] = ToValue(delay.death);
  AddFolds(diagram, result);
  AddBranches(diagram, result);
  AddWindows(diagram, result);
  result->notices.insert(result->notices.end(), diagram.notices.begin(), diagram.notices.end());
}

BifurcationDiagram Continue(const Bench& bench, DiagramOptions* options) {
  options->threads = 1;  // items run side by side
  options->max_points = 200;
  options->on_progress = [&bench](const std::string& /*what*/) { return bench.GoOn(); };
  BifurcationDiagram diagram = CalcDiagram(bench.wagon, *options);
  if (!bench.GoOn()) throw GivenUp();
  return diagram;
}

/// The part of a diagram between two speeds, up to an amplitude.
Figure Zoom(Figure figure, double from, double to, double amplitude, const std::string& title) {
  figure.title = title;
  for (FigurePanel& panel : figure.panels) {
    panel.x.low = from;
    panel.x.high = to;
    panel.y.low = -0.04 * amplitude;  // the line of the equilibrium stands clear of the frame
    panel.y.high = amplitude;
    panel.notes.clear();  // they belong to places that may be outside
  }
  return figure;
}

void DrawDiagram(const BifurcationRun& run, ItemResult* result) {
  constexpr double kBelow = 1, kAbove = 2.5, kSmall = 1.5;  // [m/s], [mm]
  const Figure figure = DiagramFigure(run);
  Draw(figure, fmt::format("half widths against speed, {}: trace and branches of cycles", run.inputs.freight.name),
       result);
  if (run.diagram.hopfs.empty()) return;
  const double hopf = run.diagram.hopfs.front().crossing.V;
  Draw(Zoom(figure, hopf - kBelow, hopf + kAbove, kSmall,
            "near the Hopf point: what is born there, and the delay of the trace"),
       fmt::format("the diagram from {:.1f} to {:.1f} m/s up to {:g} mm", hopf - kBelow, hopf + kAbove, kSmall),
       result);
}

}  // namespace

void Measure(const TraceTask& task, const Bench& bench, ItemResult* result) {
  TraceOptions options;
  options.from = task.from;
  options.legs = task.legs;
  options.hold = task.hold;
  Trace trace = TraceOn(bench, FindEquilibrium(bench.wagon, task.from), options);
  BifurcationRun run{.inputs = bench.inputs, .method = task.continuation ? "both" : "trace"};
  run.trace = TraceRun{.options = options,
                       .rows = trace.rows,
                       .complete = trace.complete,
                       .end_reason = trace.end_reason,
                       .wall_s = trace.wall_s};
  if (!trace.complete) result->notices.push_back("the trace ended early: " + trace.end_reason);
  AddTraceValues(*run.trace, trace, result);
  result->values["trace_wall_s"] = trace.wall_s;
  run.options.from = task.branch_from;
  run.options.to = task.branch_to;
  if (task.continuation) {
    run.diagram = Continue(bench, &run.options);
    run.continued = true;
    AddDiagramValues(run.diagram, *run.trace, result);
    result->values["diagram_wall_s"] = run.diagram.wall_s;
  }
  if (!task.continuation) {
    StabilityOptions linear;
    linear.from = task.branch_from;
    linear.to = task.branch_to;
    run.diagram.linear = FindCrossings(bench.wagon, linear);
  }
  DrawDiagram(run, result);
}

}  // namespace uiclink::reproduce
