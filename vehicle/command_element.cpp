// wagon element: one element of the wagon alone on its test bench.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "vehicle/commands.h"
#include "vehicle/element_report.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  Output output;
  std::string bench;
  std::string set = "set1";
  std::string direction = "lateral";
  std::string clearances = "both";
  std::vector<double> betas_mm;
  double amplitude_mm = 0;
  double pull_mm = 45;
  double perturbation_mm = 1e-3;
  ElementOptions options;
};

/// Benches that an option belongs to; the others take no notice of it.
const std::vector<std::pair<const char*, std::vector<std::string>>>& OptionBenches() {
  static const std::vector<std::pair<const char*, std::vector<std::string>>> benches{
      {"--beta", {"leaf-harmonic", "leaf-drop"}},
      {"--amplitude", {"leaf-harmonic"}},
      {"--mass", {"leaf-harmonic", "leaf-drop", "parabolic"}},
      {"--frequency", {"parabolic"}},
      {"--mu", {"parabolic"}},
      {"--clearances", {"guidance"}},
      {"--perturbation", {"guidance"}},
      {"--set", {"dry-friction"}},
      {"--direction", {"dry-friction"}},
      {"--pull", {"dry-friction"}},
      {"--time", {"leaf-drop", "guidance", "dry-friction"}}};
  return benches;
}

/// Options that were given in vain.
std::vector<std::string> FindUnused(const CLI::App& app, const std::string& bench) {
  std::vector<std::string> notices;
  for (const auto& [option, benches] : OptionBenches()) {
    if (app.get_option(option)->count() > 0 && std::ranges::find(benches, bench) == benches.end())
      notices.push_back(fmt::format("{} means nothing to {}; it is for {}", option, bench, fmt::join(benches, ", ")));
  }
  return notices;
}

int RunElement(const Arguments& arguments) {
  const ElementBench bench = FindElementBench(arguments.bench);
  CheckWritable(arguments.output);
  WagonInputs inputs;
  ReadWagonFile(arguments.choice, &inputs);
  ElementOptions options = arguments.options;
  options.wagon = inputs.data;
  options.amplitude = 1e-3 * arguments.amplitude_mm;
  options.pull = 1e-3 * arguments.pull_mm;
  options.perturbation = 1e-3 * arguments.perturbation_mm;
  for (const double beta_mm : arguments.betas_mm) options.betas.push_back(1e-3 * beta_mm);
  options.direction = arguments.direction == "lateral" ? Direction::kLateral : Direction::kLongitudinal;
  options.exaggerated = arguments.clearances != "true";
  options.true_clearances = arguments.clearances != "exaggerated";
  if (bench == ElementBench::kDryFriction) options.set = ReadSet(arguments.set, &inputs);
  const ElementReport report = MakeElementReport(bench, options, inputs);
  FigureWriter writer(arguments.output);
  for (const ElementSeries& series : report.series) writer.WriteText(series.name + ".csv", FormatCsv(series.columns));
  for (const auto& [name, figure] : report.figures) writer.Write(name, figure, false);
  writer.WriteText("element_" + arguments.bench + ".json", report.json);
  writer.WriteReport("element_" + arguments.bench + "_report.html",
                     [&](const PageOrigin& origin) { return ComposeElementPage(report, inputs, origin); });
  PrintNotices(writer.notices());
  Emit(arguments.output, report.text + writer.Written(), report.json);
  return writer.complete() ? kAllDone : kSomeLeftOut;
}

void AddLeafOptions(CLI::App* app, Arguments* arguments) {
  app->add_option(
         "--beta", arguments->betas_mm,
         "leaf springs: displacements over which the force goes over to the envelope [mm] (default: the thesis's)")
      ->type_name("BETA ...")
      ->check(CheckBetween(1e-3, 1e3, "mm"))
      ->expected(1, -1)
      ->group("Benches");
  app->add_option("--amplitude", arguments->amplitude_mm,
                  "leaf-harmonic: [mm] (default: the static compression's half, and its half)")
      ->type_name("A")
      ->check(CheckBetween(1e-3, 1e3, "mm"))
      ->group("Benches");
  app->add_option("--mass", arguments->options.mass, "springs: load [kg] (default: a quarter of the body)")
      ->type_name("M")
      ->check(CheckBetween(1, 1e6, "kg"))
      ->group("Benches");
  app->add_option("--frequency", arguments->options.frequency, "parabolic: [Hz]")
      ->type_name("F")
      ->check(CheckBetween(1e-3, 1e3, "Hz"))
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--mu", arguments->options.mu, "parabolic: friction of the leaves")
      ->type_name("MU")
      ->check(CheckBetween(1e-6, 10, ""))
      ->capture_default_str()
      ->group("Benches");
}

void AddOtherOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--clearances", arguments->clearances, "guidance: those of table 6.1, true ones, or both")
      ->check(CLI::IsMember({"exaggerated", "true", "both"}))
      ->type_name("exaggerated|true|both")
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--perturbation", arguments->perturbation_mm, "guidance: of the second run's start [mm]")
      ->type_name("Y")
      ->check(CheckBetween(-100, 100, "mm"))
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--set", arguments->set, "dry-friction: parameter set")
      ->type_name("NAME|FILE")
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--direction", arguments->direction, "dry-friction: of the set")
      ->check(CLI::IsMember({"lateral", "longitudinal"}))
      ->type_name("lateral|longitudinal")
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--pull", arguments->pull_mm, "dry-friction: released from here [mm]")
      ->type_name("Y")
      ->check(CheckBetween(-1e3, 1e3, "mm"))
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--time", arguments->options.duration,
                  "leaf-drop, guidance, dry-friction: [s] (default: each its own)")
      ->type_name("T")
      ->check(CheckBetween(1e-3, 1e4, "s"))
      ->group("Benches");
}

}  // namespace

Command AddElementCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app =
      program->add_subcommand("element", "an element alone on its test bench: springs, guidance, dry friction");
  std::vector<std::string> names;
  for (const auto& [name, bench] : ElementBenches()) names.push_back(name);
  app->add_option("bench", arguments->bench, fmt::format("{}", fmt::join(names, ", ")))
      ->required()
      ->check(CLI::IsMember(names))
      ->type_name("BENCH");
  AddOutputOptions(app, &arguments->output, "out");
  app->add_option("--wagon", arguments->choice.wagon, "whose springs: a name or a file")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  AddLeafOptions(app, arguments.get());
  AddOtherOptions(app, arguments.get());
  app->footer(
      "Examples:\n"
      "  wagon element leaf-drop --beta 0.01 1 5\n"
      "  wagon element guidance --clearances true --time 10\n"
      "  wagon element dry-friction --set set2 --direction longitudinal --pull 30");
  return {app, [arguments, app] {
            PrintNotices(FindUnused(*app, arguments->bench));
            return RunElement(*arguments);
          }};
}

}  // namespace uiclink
