#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "model/closed_form.h"
#include "reports/text_table.h"
#include "reports/wrap.h"
#include "vehicle/element_report_parts.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

// --- guidance ---

struct GuidanceCase {
  std::string name;  ///< of files
  std::string title;
  WheelsetBetweenGuides wheelset;
};

std::vector<GuidanceCase> GuidanceCases(const ElementOptions& options) {
  std::vector<GuidanceCase> clearances, cases;
  if (options.exaggerated) clearances.push_back({"exaggerated", "exaggerated (figure 6.4)", Table61()});
  if (options.true_clearances) clearances.push_back({"true", "true (figure 6.5)", TrueClearances()});
  for (const GuidanceLaw law : {GuidanceLaw::kPrinted, GuidanceLaw::kConservative}) {
    const std::string word = law == GuidanceLaw::kPrinted ? "printed" : "conservative";
    for (GuidanceCase c : clearances) {
      c.wheelset.law = law;
      cases.push_back({c.name + "_" + word, c.title + ", " + word, c.wheelset});
    }
  }
  if (cases.empty()) throw std::invalid_argument("MakeElementReport: no clearances asked for, must be at least one");
  return cases;
}

std::vector<double> Component(const GuidanceRun& run, std::size_t index, double factor) {
  std::vector<double> values;
  for (const GuidanceState& state : run.states) values.push_back(factor * state[index]);
  return values;
}

Json GuidanceJson(const GuidanceCase& c, const GuidanceBenchRun& run) {
  const auto last = [&](std::size_t i) { return run.largest_difference[i].back(); };
  return {{"name", c.name},
          {"law", c.wheelset.law == GuidanceLaw::kPrinted ? "printed" : "conservative"},
          {"clearance_m", {{"longitudinal", c.wheelset.b}, {"lateral", c.wheelset.c}}},
          {"stiffness_N_per_m", {{"longitudinal", c.wheelset.k_x}, {"lateral", c.wheelset.k_y}}},
          {"perturbation_m", run.options.perturbation[2]},
          {"duration_s", run.options.duration},
          {"largest_difference", {{"x_m", last(0)}, {"y_m", last(1)}, {"psi_rad", last(2)}}},
          {"relative_difference",
           {{"x", run.relative_difference[0]}, {"y", run.relative_difference[1]}, {"psi", run.relative_difference[2]}}},
          {"growth_rate_per_s", run.growth_rate},
          {"growth_until_s", run.growth_until},
          {"impacts", {{"longitudinal", run.plain.impacts_longitudinal}, {"lateral", run.plain.impacts_lateral}}},
          {"energy_error", run.plain.energy_error},
          {"steps", run.plain.steps}};
}

ElementSeries GuidanceColumns(const GuidanceCase& c, const GuidanceBenchRun& run) {
  static constexpr const char* kNames[] = {"x", "x_rate", "y", "y_rate", "psi", "psi_rate"};
  static constexpr const char* kUnits[] = {"m", "m/s", "m", "m/s", "rad", "rad/s"};
  ElementSeries series{.name = "guidance_" + c.name, .columns = {{"time", "s", run.t}}};
  for (std::size_t i = 0; i < 6; ++i) series.columns.push_back({kNames[i], kUnits[i], Component(run.plain, i, 1)});
  for (std::size_t i = 0; i < 6; ++i)
    series.columns.push_back({std::string("perturbed_") + kNames[i], kUnits[i], Component(run.perturbed, i, 1)});
  return series;
}

Figure GuidanceFigure(const GuidanceCase& c, const GuidanceBenchRun& run) {
  Figure figure{.title = "wheelset between its guides, clearances " + c.title, .columns = 2};
  const auto panel = [&](const char* title, std::size_t index, const char* unit) {
    figure.panels.push_back({.title = title,
                             .x = {.label = "time", .unit = "s"},
                             .y = {.label = title, .unit = unit},
                             .series = {{.name = "as started", .x = run.t, .y = Component(run.plain, index, 1e3)},
                                        {.name = "perturbed",
                                         .x = run.t,
                                         .y = Component(run.perturbed, index, 1e3),
                                         .line = FigureLine::kDashed}}});
  };
  panel("longitudinal", 0, "mm");
  panel("lateral", 2, "mm");
  panel("yaw", 4, "mrad");
  FigurePanel growth{.title = "difference so far",
                     .x = {.label = "time", .unit = "s"},
                     .y = {.label = "largest difference", .unit = "m or rad", .log = true, .low = 1e-10}};
  static constexpr const char* kNames[] = {"x", "y", "yaw"};
  for (std::size_t i = 0; i < 3; ++i)
    growth.series.push_back({.name = kNames[i], .x = run.t, .y = run.largest_difference[i]});
  figure.panels.push_back(std::move(growth));
  const auto trace = [&](const char* title, const GuidanceRun& states) {
    figure.panels.push_back({.title = title,
                             .x = {.label = "longitudinal", .unit = "mm"},
                             .y = {.label = "lateral", .unit = "mm"},
                             .series = {{.name = "", .x = Component(states, 0, 1e3), .y = Component(states, 2, 1e3)}}});
  };
  trace("centre of mass, as started", run.plain);
  trace("centre of mass, perturbed", run.perturbed);
  return figure;
}

void AddGuidanceRow(const GuidanceCase& c, const GuidanceBenchRun& run, TextTable* table) {
  table->AddRow({c.title, fmt::format("{:.2e}", run.largest_difference[0].back()),
                 fmt::format("{:.2e}", run.largest_difference[1].back()),
                 fmt::format("{:.2e}", run.largest_difference[2].back()),
                 fmt::format("{:.2f}", run.relative_difference[0]), fmt::format("{:.2f}", run.relative_difference[1]),
                 fmt::format("{:.2f}", run.relative_difference[2]), fmt::format("{:.2f}", run.growth_rate),
                 fmt::format("{}/{}", run.plain.impacts_longitudinal, run.plain.impacts_lateral),
                 fmt::format("{:.1e}", run.plain.energy_error)});
}

std::string Capital(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

std::string GuidanceRemarks(const ElementOptions& options) {
  return fmt::format(
      "d: the greatest difference of a second run whose y starts {:g} m further. Relative: its root mean square "
      "over the last "
      "fifth of the run over that of the motion; about 1.4 means that the runs have nothing in common. Growth: "
      "of the difference while it is below a tenth of a clearance. Printed: the forces of chapter 6, where a "
      "longitudinal contact pushes along x alone whatever its slope. They are no gradient of an energy, so "
      "energy is not conserved although nothing damps. Conservative: along the gradient.",
      options.perturbation);
}

// --- dry-friction ---

const DirectionParameters& ElementOf(const ElementOptions& options) {
  const std::optional<DirectionParameters>& element = options.set[options.direction];
  if (!element)
    throw std::invalid_argument(fmt::format("dry-friction: parameter set \"{}\" has no {} direction", options.set.name,
                                            Name(options.direction)));
  return *element;
}

Json DryFrictionJson(const ElementOptions& options, const DryFrictionRun& run) {
  Json sliders = Json::array();
  for (const Slider<double>& slider : run.options.element.sliders)
    sliders.push_back({{"k_per_m", slider.k}, {"T0", slider.T0}});
  return {{"set", options.set.name},
          {"direction", Name(options.direction)},
          {"k_per_m", run.options.element.k},
          {"sliders", sliders},
          {"pull_m", run.options.pull},
          {"duration_s", run.options.duration},
          {"extremum_s", run.extremum_t},
          {"extremum_m", run.extremum_y},
          {"locked", run.locked},
          {"amplitude_m", run.amplitude},
          {"offset_m", run.offset},
          {"frequency_hz", run.frequency},
          {"energy_error", run.energy_error}};
}

void TellDryFriction(const ElementOptions& options, const DryFrictionRun& run, ElementParts* parts) {
  const Oscillator<double> oscillator = MakeOscillator(run.options.element, run.options.g);
  TextTable& table = parts->table;
  table.AddColumn("half swing");
  table.AddColumn("time\ns");
  table.AddColumn("extremum\nmm");
  table.AddColumn("shorter by\nmm");
  double before = std::abs(run.options.pull);
  const std::size_t shown = std::min<std::size_t>(12, run.extremum_y.size());
  for (std::size_t i = 0; i < shown; ++i) {
    const double after = std::abs(run.extremum_y[i]);
    table.AddRow({fmt::format("{}", i + 1), fmt::format("{:.3f}", run.extremum_t[i]),
                  fmt::format("{:.3f}", 1e3 * run.extremum_y[i]), fmt::format("{:.3f}", 1e3 * (before - after))});
    before = after;
  }
  if (shown < run.extremum_y.size()) parts->below = fmt::format("  and {} more\n", run.extremum_y.size() - shown);
  const std::string end =
      run.locked
          ? fmt::format(
                "Every slider sticks at the end: it swings harmonically, {:.3f} mm about {:+.3f} mm at {:.3f} Hz.",
                1e3 * run.amplitude, 1e3 * run.offset, run.frequency)
          : fmt::format("Sliders still slide at the end; the last arc swings {:.3f} mm about {:+.3f} mm.",
                        1e3 * run.amplitude, 1e3 * run.offset);
  const double two_pi = 2 * std::numbers::pi;
  parts->title = fmt::format("Dry-friction element, {} {}, released at {:.1f} mm (figures 8.2 to 8.5)",
                             options.set.name, Name(options.direction), 1e3 * run.options.pull);
  parts->answer = fmt::format(
      "Pulled out by {:.1f} mm and let go, the {} link of {} turns round {} times in {:g} s. {}",
      1e3 * run.options.pull, Name(options.direction), options.set.name, run.extremum_y.size(), run.t.back(), end);
  parts->remarks = {end +
                    fmt::format(" All sliding {:.3f} Hz, all sticking {:.3f} Hz. Energy and friction work balance to "
                                "{:.0e} of the start.",
                                CalcSlidingFrequency(oscillator) / two_pi, CalcRollingFrequency(oscillator) / two_pi,
                                run.energy_error)};
}

/// Force of the whole element at the samples, per unit load.
std::vector<double> ElementForce(const DryFrictionRun& run) {
  std::vector<double> force;
  for (std::size_t i = 0; i < run.y.size(); ++i) {
    force.push_back(-run.options.element.k * run.y[i]);
    for (const std::vector<double>& T : run.T) force.back() += T[i];
  }
  return force;
}

/// Sum of the sliders' forces at the samples.
std::vector<double> SliderForce(const DryFrictionRun& run) {
  std::vector<double> force(run.y.size(), 0);
  for (const std::vector<double>& T : run.T)
    for (std::size_t i = 0; i < force.size(); ++i) force[i] += T[i];
  return force;
}

Figure DryFrictionFigure(const DryFrictionRun& run) {
  const std::vector<double> mm = Scaled(run.y, 1e3);
  const FigureAxis x{.label = "displacement", .unit = "mm"};
  const FigureAxis force{.label = "slider force over load", .unit = ""};
  // Figure 8.5 shows force over displacement and velocity in space; here its projections.
  return {.title = "dry-friction element (figures 8.2 to 8.5)",
          .panels = {{.title = "displacement",
                      .x = {.label = "time", .unit = "s"},
                      .y = x,
                      .series = {{.name = "", .x = run.t, .y = mm}}},
                     {.title = "whole element",
                      .x = x,
                      .y = {.label = "force over load", .unit = ""},
                      .series = {{.name = "", .x = mm, .y = ElementForce(run)}}},
                     {.title = "sliders over displacement",
                      .x = x,
                      .y = force,
                      .series = {{.name = "", .x = mm, .y = SliderForce(run)}}},
                     {.title = "sliders over velocity",
                      .x = {.label = "velocity", .unit = "m/s"},
                      .y = force,
                      .series = {{.name = "", .x = run.v, .y = SliderForce(run)}}}},
          .columns = 2};
}

}  // namespace

ElementParts ReportGuidance(const ElementOptions& options) {
  ElementParts parts;
  TextTable& table = parts.table;
  table.AddColumn("clearances, forces", TextTable::Align::kLeft);
  table.AddColumn("largest dx\nm");
  table.AddColumn("dy\nm");
  table.AddColumn("dyaw\nrad");
  table.AddColumn("relative\ndx");
  table.AddColumn("\ndy");
  table.AddColumn("\ndyaw");
  table.AddColumn("growth\n1/s");
  table.AddColumn("impacts\nlong./lat.");
  table.AddColumn("energy\nerror");
  for (const GuidanceCase& c : GuidanceCases(options)) {
    GuidanceBenchOptions bench{.wheelset = c.wheelset, .perturbation = {0, 0, options.perturbation, 0, 0, 0}};
    if (options.duration > 0) bench.duration = options.duration;
    const GuidanceBenchRun run = RunGuidanceBench(bench);
    AddGuidanceRow(c, run, &table);
    parts.answer +=
        fmt::format("{}{}: two runs that begin {:g} mm apart are {:.3g} mm apart after {:g} s and {} impacts.",
                    parts.answer.empty() ? "" : " ", Capital(c.title), 1e3 * options.perturbation,
                    1e3 * run.largest_difference[1].back(), run.t.back(),
                    run.plain.impacts_longitudinal + run.plain.impacts_lateral);
    parts.runs.push_back(GuidanceJson(c, run));
    parts.series.push_back(GuidanceColumns(c, run));
    parts.figures.emplace_back("guidance_" + c.name, GuidanceFigure(c, run));
  }
  parts.title = "Impacts of a free wheelset in its guides (chapter 6)";
  parts.remarks = {GuidanceRemarks(options)};
  return parts;
}

ElementParts ReportDryFriction(const ElementOptions& options) {
  DryFrictionOptions bench{.element = ElementOf(options), .g = options.set.g, .pull = options.pull};
  if (options.duration > 0) bench.duration = options.duration;
  const DryFrictionRun run = RunDryFriction(bench);
  ElementParts parts;
  TellDryFriction(options, run, &parts);
  parts.runs.push_back(DryFrictionJson(options, run));
  ElementSeries series{.name = "dry_friction",
                       .columns = {{"time", "s", run.t}, {"displacement", "m", run.y}, {"velocity", "m/s", run.v}}};
  for (std::size_t i = 0; i < run.T.size(); ++i)
    series.columns.push_back({fmt::format("slider_{}", i + 1), "-", run.T[i]});
  parts.series.push_back(std::move(series));
  parts.figures.emplace_back("dry_friction", DryFrictionFigure(run));
  return parts;
}

}  // namespace uiclink
