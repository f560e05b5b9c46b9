// wagon element: one element of the wagon alone on its test bench.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "data/checksum.h"
#include "data/data_path.h"
#include "data/file.h"
#include "data/parameter_set_file.h"
#include "vehicle/commands.h"
#include "vehicle/element_report.h"
#include "vehicle/report_json.h"

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

void ReadSet(const Arguments& arguments, ElementOptions* options, WagonInputs* inputs) {
  const std::filesystem::path path = FindDataFile("parameter_sets", arguments.set);
  const std::string text = ReadFileWhole(path);
  options->set = ParseParameterSet(text, path.string());
  inputs->files.push_back(
      {.role = "set", .name = options->set.name, .path = path.string(), .sha256 = CalcSha256(text)});
}

int RunElement(const Arguments& arguments) {
  const ElementBench bench = FindElementBench(arguments.bench);
  WagonInputs inputs;
  ReadWagonBody(arguments.choice, &inputs);
  std::erase_if(inputs.files, [](const InputFile& file) { return file.role == "cargo"; });  // no bench carries freight
  ElementOptions options = arguments.options;
  options.wagon = inputs.data;
  options.amplitude = 1e-3 * arguments.amplitude_mm;
  options.pull = 1e-3 * arguments.pull_mm;
  options.perturbation = 1e-3 * arguments.perturbation_mm;
  for (const double beta_mm : arguments.betas_mm) options.betas.push_back(1e-3 * beta_mm);
  options.direction = arguments.direction == "lateral" ? Direction::kLateral : Direction::kLongitudinal;
  options.exaggerated = arguments.clearances != "true";
  options.true_clearances = arguments.clearances != "exaggerated";
  if (bench == ElementBench::kDryFriction) ReadSet(arguments, &options, &inputs);
  const Json files = {{"files", InputsToJson(inputs)["files"]}};
  const ElementReport report = MakeElementReport(bench, options, files.dump());
  FigureWriter writer(arguments.output);
  for (const ElementSeries& series : report.series) writer.WriteText(series.name + ".csv", FormatCsv(series.columns));
  for (const auto& [name, figure] : report.figures) writer.Write(name, figure, false);
  writer.WriteText("element_" + arguments.bench + ".json", report.json);
  PrintNotices(writer.notices());
  Emit(arguments.output, report.text + writer.Written(), report.json);
  return writer.complete() ? kAllDone : kSomeLeftOut;
}

void AddLeafOptions(CLI::App* app, Arguments* arguments) {
  app->add_option(
         "--beta", arguments->betas_mm,
         "leaf springs: displacements over which the force goes over to the envelope [mm] (default: the thesis's)")
      ->type_name("BETA ...")
      ->check(CheckPositive)
      ->expected(1, -1)
      ->group("Benches");
  app->add_option("--amplitude", arguments->amplitude_mm,
                  "leaf-harmonic: [mm] (default: the static compression's half, and its half)")
      ->type_name("A")
      ->check(CheckPositive)
      ->group("Benches");
  app->add_option("--mass", arguments->options.mass, "springs: load [kg] (default: a quarter of the body)")
      ->type_name("M")
      ->check(CheckPositive)
      ->group("Benches");
  app->add_option("--frequency", arguments->options.frequency, "parabolic: [Hz]")
      ->type_name("F")
      ->check(CheckPositive)
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--mu", arguments->options.mu, "parabolic: friction of the leaves")
      ->type_name("MU")
      ->check(CheckPositive)
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
      ->capture_default_str()
      ->group("Benches");
  app->add_option("--time", arguments->options.duration,
                  "leaf-drop, guidance, dry-friction: [s] (default: each its own)")
      ->type_name("T")
      ->check(CheckPositive)
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
  return {app, [arguments] { return RunElement(*arguments); }};
}

}  // namespace uiclink
