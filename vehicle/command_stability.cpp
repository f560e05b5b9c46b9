// wagon stability: eigenvalues against speed, critical speeds.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "vehicle/commands.h"
#include "vehicle/stability.h"
#include "vehicle/stability_report.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  Output output;
  StabilityOptions options;
};

int RunStability(const Arguments& arguments) {
  if (!(arguments.options.from < arguments.options.to)) {
    throw UsageError(fmt::format("--to: expected more than --from, {:g} m/s, found {:g}", arguments.options.from,
                                 arguments.options.to));
  }
  CheckWritable(arguments.output);
  const auto begin = std::chrono::steady_clock::now();
  const WagonInputs inputs = ReadWagonInputs(arguments.choice);
  PrintNotices(inputs.notices);
  const Wagon wagon = MakeWagon(inputs);
  const Progress progress(arguments.output);
  std::vector<RootsAtSpeed> roots;
  StabilityOptions options = arguments.options;
  options.on_speed = [&](double V, const std::vector<std::complex<double>>& eigenvalues) {
    roots.push_back({V, eigenvalues});
    progress.Show(fmt::format("eigenvalues at {:.2f} of {:g} m/s", V, options.to));
  };
  const StabilityResult result = FindCrossings(wagon, options);
  progress.Clear();

  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const StabilityRun run{inputs, result, roots, arguments.options, wall.count()};
  const std::string json = FormatStabilityJson(run);
  FigureWriter files(arguments.output);
  files.WriteText("eigenvalues.csv", FormatCsv(RootColumns(run)));
  files.Write("root_locus", RootLocusFigure(run), false);
  files.WriteText("stability.json", json);
  PrintNotices(files.notices());
  Emit(arguments.output, FormatStability(run) + files.Written(), json);
  return files.complete() ? kAllDone : kSomeLeftOut;
}

}  // namespace

Command AddStabilityCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app = program->add_subcommand(
      "stability", "eigenvalues against speed, and the speeds at which the wagon becomes unstable");
  StabilityOptions& options = arguments->options;
  app->add_option("--from", options.from, "lowest speed [m/s]")
      ->type_name("V")
      ->check(CheckBetween(kLowestSpeed, kHighestSpeed, "m/s"))
      ->capture_default_str();
  app->add_option("--to", options.to, "highest speed [m/s]")
      ->type_name("V")
      ->check(CheckBetween(kLowestSpeed, kHighestSpeed, "m/s"))
      ->capture_default_str();
  app->add_option("--step", options.step, "of the first search [m/s]; two crossings within a step are not seen")
      ->type_name("V")
      ->check(CheckBetween(1e-3, kHighestSpeed, "m/s"))
      ->capture_default_str();
  app->add_option("--tolerance", options.tolerance, "of a critical speed [m/s]")
      ->type_name("V")
      ->check(CheckBetween(1e-12, 1, "m/s"))
      ->capture_default_str();
  app->add_flag("--first", options.first_only, "stop at the first critical speed");
  AddOutputOptions(app, &arguments->output, "out");
  AddWagonOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon stability --set set1 --geometry thesis-equivalent\n"
      "  wagon stability --set set2 --cargo packed --to 60\n"
      "  wagon stability --json - --quiet | jq .linear_critical_speed.value\n\n"
      "Writes eigenvalues.csv, root_locus.svg and stability.json to the folder of --out.");
  return {app, [arguments] { return RunStability(*arguments); }};
}

}  // namespace uiclink
