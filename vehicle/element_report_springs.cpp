#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "reports/text_table.h"
#include "reports/wrap.h"
#include "vehicle/element_report_parts.h"
#include "vehicle/inertia.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

constexpr double kFreightMass = 20000;  // [kg] of the loaded wagon of chapter 5

/// A quarter of the car body with so much freight [kg].
double QuarterMass(const ElementOptions& options, double freight) {
  return (CalcBodyInertia(options.wagon, {}).m + freight) / 4;
}

double MassOf(const ElementOptions& options) { return options.mass > 0 ? options.mass : QuarterMass(options, 0); }

std::vector<LeafSpring> LeafSprings(const ElementOptions& options, std::vector<double> betas) {
  if (!options.betas.empty()) betas = options.betas;
  std::vector<LeafSpring> springs;
  for (const double beta : betas) {
    springs.push_back(options.wagon.leaf);
    springs.back().beta = beta;
  }
  return springs;
}

Json LeafJson(const LeafSpring& spring) {
  return {{"c_N_per_m", spring.c}, {"mu0", spring.mu0}, {"F_r_N", spring.F_r}, {"beta_m", spring.beta}};
}

// --- leaf-harmonic ---

/// Half of the static compression that the thesis took: on the parabolic spring, 25.5 mm for the empty wagon.
double LeafAmplitude(const ElementOptions& options) {
  return CalcStaticCompression(options.wagon.parabolic, MassOf(options) * options.wagon.g) / 2;
}

std::vector<LeafHarmonicRun> RunLeafHarmonics(const ElementOptions& options) {
  std::vector<LeafHarmonicRun> runs;
  const double a = options.amplitude > 0 ? options.amplitude : LeafAmplitude(options);
  for (const LeafSpring& spring : LeafSprings(options, {1e-3, 1e-5}))
    runs.push_back(RunLeafHarmonic({.spring = spring, .amplitude = a}));
  if (options.amplitude > 0) return runs;
  LeafHarmonicOptions smaller = runs.back().options;  // figure 5.8(c); how much smaller is not said
  smaller.amplitude = a / 2;
  runs.push_back(RunLeafHarmonic(smaller));
  return runs;
}

std::string LeafLabel(const LeafHarmonicRun& run) {
  return fmt::format("beta = {:g} m, a = {:.1f} mm", run.options.spring.beta, 1e3 * run.options.amplitude);
}

void AddLeafHarmonic(const ElementOptions& options, const LeafHarmonicRun& run, TextTable* table, Figure* figure,
                     ElementParts* parts) {
  const LeafHarmonicOptions& in = run.options;
  const double friction = CalcFrictionWork(options.mu, MassOf(options) * options.wagon.g, in.amplitude);
  table->AddRow({fmt::format("{:g}", in.spring.beta), fmt::format("{:.2f}", 1e3 * in.amplitude),
                 fmt::format("{:.1f}", run.steady_loss), fmt::format("{:.1f}", run.envelope_loss),
                 fmt::format("{:.1f}", friction), fmt::format("{:+.1f}", 100 * (run.steady_loss / friction - 1))});
  parts->answer += fmt::format(
      "{}Moved by {:.1f} mm to each side, the leaf spring with beta = {:g} mm loses {:.0f} J a "
      "cycle, dry friction between its leaves would take {:.0f} J.",
      parts->answer.empty() ? "" : " ", 1e3 * in.amplitude, 1e3 * in.spring.beta, run.steady_loss, friction);
  parts->runs.push_back(Json{{"spring", LeafJson(in.spring)},
                             {"amplitude_m", in.amplitude},
                             {"loss_J", run.loss},
                             {"steady_loss_J", run.steady_loss},
                             {"envelope_loss_J", run.envelope_loss},
                             {"friction_work_J", friction}});
  // The thesis draws the restoring force -F: then the loop runs counter-clockwise.
  parts->series.push_back(
      {.name = fmt::format("leaf_harmonic_{}", parts->runs.size()),
       .columns = {
           {"phase", "rad", run.phase}, {"compression", "m", run.s}, {"restoring_force", "N", Scaled(run.F, -1)}}});
  figure->panels.push_back({.title = LeafLabel(run),
                            .x = {.label = "compression", .unit = "mm"},
                            .y = {.label = "restoring force", .unit = "kN"},
                            .series = {{.name = "", .x = Scaled(run.s, 1e3), .y = Scaled(run.F, -1e-3)}}});
}

// --- leaf-drop ---

constexpr double kStill = 5e-6;  // a swing that the table shows as 0.00 or 0.01 mm [m]

void AddLeafDrop(const LeafDropRun& run, TextTable* table, Figure* figure, ElementParts* parts) {
  const auto mm = [](double metres) { return fmt::format("{:.2f}", 1e3 * metres); };
  table->AddRow({fmt::format("{:g}", run.options.spring.beta), mm(run.largest), mm(run.s.back()),
                 mm(run.s.back() - run.rest), mm(run.swing), fmt::format("{}", run.rest_crossings),
                 fmt::format("{}", run.reversals)});
  parts->answer += fmt::format(
      "{}With beta = {:g} mm the falling load compresses the spring by up to {:.1f} mm and stands at {:.1f} mm after "
      "{:g} s{}.",
      parts->answer.empty() ? "" : " ", 1e3 * run.options.spring.beta, 1e3 * run.largest, 1e3 * run.s.back(),
      run.options.duration, run.swing > kStill ? fmt::format(", still swinging by {:.2f} mm", 1e3 * run.swing) : "");
  parts->runs.push_back(Json{{"spring", LeafJson(run.options.spring)},
                             {"mass_kg", run.options.m},
                             {"rest_m", run.rest},
                             {"largest_m", run.largest},
                             {"end_m", run.s.back()},
                             {"swing_m", run.swing},
                             {"rest_crossings", run.rest_crossings},
                             {"rest_crossings_linear", run.rest_crossings_linear},
                             {"reversals", run.reversals},
                             {"energy_error", run.energy_error},
                             {"steps", run.steps}});
  parts->series.push_back({.name = fmt::format("leaf_drop_{}", parts->runs.size()),
                           .columns = {{"time", "s", run.t},
                                       {"compression", "m", run.s},
                                       {"velocity", "m/s", run.v},
                                       {"restoring_force", "N", Scaled(run.F, -1)},
                                       {"compression_linear", "m", run.s_linear}}});
  const std::string beta = fmt::format("beta = {:g} m", run.options.spring.beta);
  const std::vector<double> s = Scaled(run.s, 1e3);
  figure->panels.push_back(
      {.title = "fall, " + beta,
       .x = {.label = "time", .unit = "s"},
       .y = {.label = "compression", .unit = "mm", .reversed = true},
       .series = {{.name = "leaf spring", .x = run.t, .y = s},
                  {.name = "linear", .x = run.t, .y = Scaled(run.s_linear, 1e3), .line = FigureLine::kDashed}},
       .horizontal_guides = {{.value = 1e3 * run.rest}}});
  figure->panels.push_back({.title = "force, " + beta,
                            .x = {.label = "compression", .unit = "mm"},
                            .y = {.label = "restoring force", .unit = "kN"},
                            .series = {{.name = "", .x = s, .y = Scaled(run.F, -1e-3)}}});
}

// --- parabolic ---

Json ParabolicJson(const ParabolicLoopRun& run) {
  return {{"mass_kg", run.options.m},
          {"frequency_hz", run.options.frequency},
          {"mu", run.options.mu},
          {"static_compression_m", run.static_compression},
          {"amplitude_m", run.amplitude},
          {"friction_work_J", run.friction_work},
          {"loop_loss_J", run.loop_loss},
          {"damping_N_s_per_m", run.damping},
          {"damping_of_file_N_s_per_m", run.damping_of_file},
          {"loop_loss_of_file_J", run.loop_loss_of_file}};
}

void AddParabolic(const ParabolicLoopRun& run, const std::string& name, TextTable* table, Figure* figure,
                  ElementParts* parts) {
  table->AddRow({name, fmt::format("{:.2f}", 1e3 * run.static_compression), fmt::format("{:.2f}", 1e3 * run.amplitude),
                 fmt::format("{:.1f}", run.friction_work), fmt::format("{:.1f}", run.loop_loss),
                 fmt::format("{:.0f}", run.damping), fmt::format("{:.0f}", run.damping_of_file),
                 fmt::format("{:+.2f}", 100 * (run.damping_of_file / run.damping - 1))});
  parts->answer += fmt::format(
      "{}{}, {:.0f} kg on the spring: dry friction of the leaves takes {:.0f} J a cycle, the damper of the "
      "wagon's "
      "file {:.0f} J.",
      parts->answer.empty() ? "" : " ",
      name == "empty"    ? "Empty wagon"
      : name == "loaded" ? "Loaded wagon"
                         : "Given load",
      run.options.m, run.friction_work, run.loop_loss_of_file);
  Json json = {{"name", name}};
  json.update(ParabolicJson(run));
  parts->runs.push_back(std::move(json));
  parts->series.push_back(
      {.name = "parabolic_" + name,
       .columns = {{"compression", "m", run.s}, {"force", "N", run.F}, {"static_force", "N", run.F_static}}});
  figure->panels.push_back(
      {.title = name,
       .x = {.label = "compression", .unit = "mm"},
       .y = {.label = "force", .unit = "kN"},
       .series = {{.name = "moved harmonically", .x = Scaled(run.s, 1e3), .y = Scaled(run.F, 1e-3)},
                  {.name = "without damping",
                   .x = Scaled(run.s, 1e3),
                   .y = Scaled(run.F_static, 1e-3),
                   .line = FigureLine::kDashed}}});
}

}  // namespace

ElementParts ReportLeafHarmonic(const ElementOptions& options) {
  ElementParts parts;
  Figure figure{.title = "leaf spring, moved harmonically (figure 5.8)", .columns = 2, .panel_height = 320};
  TextTable& table = parts.table;
  table.AddColumn("beta\nm");
  table.AddColumn("amplitude\nmm");
  table.AddColumn("loss per cycle\nJ");
  table.AddColumn("between envelopes\nJ");
  table.AddColumn("dry friction\nJ");
  table.AddColumn("difference\n%");
  bool gives_energy = false;
  for (const LeafHarmonicRun& run : RunLeafHarmonics(options)) {
    AddLeafHarmonic(options, run, &table, &figure, &parts);
    gives_energy = gives_energy || run.steady_loss < 0;
  }
  const LeafSpring& leaf = options.wagon.leaf;
  const double weight = MassOf(options) * options.wagon.g;
  parts.title = "Leaf spring, moved harmonically about its unloaded length (figure 5.8)";
  parts.remarks = {
      fmt::format("Dry friction: 4 a mu m g, mu = {:g}. A hard spring (small beta) loses what lies "
                  "between its envelopes, 4 a F_r. Under the load the envelopes are {:.2f} kN from "
                  "their middle, not F_r = {:.2f} kN: the match holds for the unloaded spring alone.",
                  options.mu, 1e-3 * (leaf.F_r + leaf.mu0 * weight), 1e-3 * leaf.F_r)};
  if (gives_energy)
    parts.remarks.push_back(
        fmt::format("A loss below zero: with beta above F_r/c = {:.1f} mm Fancher's equation gives energy instead of "
                    "losing it; such a spring is no model of friction.",
                    1e3 * leaf.F_r / leaf.c));
  parts.figures.emplace_back("leaf_harmonic", std::move(figure));
  return parts;
}

ElementParts ReportLeafDrop(const ElementOptions& options) {
  ElementParts parts;
  Figure figure{.title = "leaf spring under a falling load (figure 5.9)", .columns = 2, .panel_height = 260};
  TextTable& table = parts.table;
  table.AddColumn("beta\nm");
  table.AddColumn("greatest\nmm");
  table.AddColumn("at the end\nmm");
  table.AddColumn("from m g/c\nmm");
  table.AddColumn("still swings\nmm");
  table.AddColumn("passes m g/c\ntimes");
  table.AddColumn("reversals");
  double rest = 0;
  int linear = 0;
  for (const LeafSpring& spring : LeafSprings(options, {1e-5, 1e-3, 5e-3})) {
    const LeafDropRun run = RunLeafDrop({.spring = spring,
                                         .linear = options.wagon.linear_vertical,
                                         .m = MassOf(options),
                                         .g = options.wagon.g,
                                         .duration = options.duration > 0 ? options.duration : 2});
    AddLeafDrop(run, &table, &figure, &parts);
    rest = run.rest;
    linear = run.rest_crossings_linear;
  }
  parts.title =
      fmt::format("Leaf spring under a load of {:.0f} kg that falls from s = 0 (figure 5.9)", MassOf(options));
  parts.remarks = {
      fmt::format("m g/c = {:.2f} mm, the middle of the envelopes under the load. A hard spring stops "
                  "where it first turns back and creeps towards the middle with every small swing; a "
                  "soft one swings about it. The linear spring and damper passes its rest {} times.",
                  1e3 * rest, linear)};
  parts.figures.emplace_back("leaf_drop", std::move(figure));
  return parts;
}

ElementParts ReportParabolic(const ElementOptions& options) {
  ElementParts parts;
  Figure figure{
      .title = "parabolic spring, moved harmonically (figures 5.10, 5.11)", .columns = 2, .panel_height = 320};
  TextTable& table = parts.table;
  table.AddColumn("load", TextTable::Align::kLeft);
  table.AddColumn("compression\nmm");
  table.AddColumn("amplitude\nmm");
  table.AddColumn("dry friction\nJ");
  table.AddColumn("loop\nJ");
  table.AddColumn("d from it\nN s/m");
  table.AddColumn("d of the file\nN s/m");
  table.AddColumn("difference\n%");
  std::vector<std::pair<std::string, double>> loads{{"given", options.mass}};
  if (!(options.mass > 0)) loads = {{"empty", QuarterMass(options, 0)}, {"loaded", QuarterMass(options, kFreightMass)}};
  for (const auto& [name, mass] : loads) {
    AddParabolic(RunParabolicLoop({.spring = options.wagon.parabolic,
                                   .m = mass,
                                   .g = options.wagon.g,
                                   .mu = options.mu,
                                   .frequency = options.frequency}),
                 name, &table, &figure, &parts);
  }
  parts.title = "Parabolic spring, moved harmonically by half of its static compression (figures 5.10, 5.11)";
  parts.remarks = {
      fmt::format("d makes pi d w a² the work of dry friction, 4 a mu m g, at {:g} Hz and mu = {:g}. The thesis "
                  "does not say its frequency; 1 Hz gives table 5.1.",
                  options.frequency, options.mu)};
  parts.figures.emplace_back("parabolic", std::move(figure));
  return parts;
}

}  // namespace uiclink
