// wagon stability: eigenvalues against speed, critical speeds.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "vehicle/command_bounds.h"
#include "vehicle/commands.h"
#include "vehicle/hunting/bounds_report.h"
#include "vehicle/hunting/hopf.h"
#include "vehicle/hunting/speed_bounds.h"
#include "vehicle/page/pages.h"
#include "vehicle/stability.h"
#include "vehicle/stability_report.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  Output output;
  StabilityOptions options;
  BoundsArguments bounds;
  bool no_type = false;
};

/// Cycles of these sizes are looked at [m]: the one that decides, and smaller ones that could contradict it.
constexpr std::array<double, 3> kTypeSizes{1e-5, 3e-5, 1e-4};

std::vector<CrossingType> FindTypes(const Wagon& wagon, const std::vector<Crossing>& crossings) {
  HopfOptions options;
  options.sizes.assign(kTypeSizes.begin(), kTypeSizes.end());
  std::vector<CrossingType> types;
  for (const Crossing& crossing : crossings) {
    const HopfPoint hopf = ExamineHopf(wagon, crossing, options);
    types.push_back({.type = hopf.type ? HopfTypeName(*hopf.type) : "",
                     .decided_at = options.type_size,
                     .other_below = hopf.other_below.value_or(0),
                     .reason = hopf.reason});
  }
  return types;
}

/// The linear critical speed that was found, with what the draws make of it.
SpeedBounds FindBounds(const Arguments& arguments, const SetScatter& scatter, const Wagon& wagon,
                       const StabilityResult& result, const Progress& progress) {
  const auto critical = std::ranges::find_if(
      result.crossings, [&](const Crossing& crossing) { return crossing.V == *result.linear_critical_speed; });
  return CalcSpeedBounds(scatter, wagon, KnownCrossing{critical->V, critical->mode.lambda},
                         {.from = arguments.options.from, .to = std::max(arguments.options.to, 2 * critical->V)},
                         MakePropagateOptions(progress, "critical speeds of the draws"));
}

/// Modes are those at the critical speed, else at the highest one that was searched.
void WriteReport(const StabilityRun& run, const Wagon& wagon, const std::optional<SetScatter>& scatter,
                 const std::optional<SpeedBounds>& bounds, FigureWriter* files) {
  files->WriteReport("stability_report.html", [&](const PageOrigin& origin) {
    const double V = run.result.linear_critical_speed.value_or(run.result.searched_to);
    const std::vector<ScalarBounds> all = bounds ? std::vector{bounds->speed} : std::vector<ScalarBounds>{};
    return ComposeStabilityPage(run, ChooseShownModes(CalcModes(Linearize(wagon, V))), V, MakePageBounds(scatter, all),
                                origin);
  });
}

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
  if (!arguments.no_type) progress.Show("types of the crossings");
  const std::vector<CrossingType> types =
      arguments.no_type ? std::vector<CrossingType>{} : FindTypes(wagon, result.crossings);
  const std::optional<SetScatter> scatter =
      result.linear_critical_speed ? MakeScatter(arguments.bounds, inputs) : std::nullopt;
  std::optional<SpeedBounds> bounds;
  if (scatter) bounds = FindBounds(arguments, *scatter, wagon, result, progress);
  progress.Clear();

  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const StabilityRun run{inputs, result, roots, arguments.options, wall.count(), types};
  std::string json = FormatStabilityJson(run), text = FormatStability(run);
  if (bounds) {
    json = WithLowAndHigh(json, "linear_critical_speed", bounds->speed);
    json = WithKey(json, "bounds",
                   {{"scatter", ScatterToJson(*scatter)}, {"linear_critical_speed", SpeedBoundsToJson(*bounds)}});
    text += "\n" + FormatSpeedBounds(*scatter, *bounds);
  }
  FigureWriter files(arguments.output);
  files.WriteText("eigenvalues.csv", FormatCsv(RootColumns(run)));
  files.Write("root_locus", RootLocusFigure(run), false);
  if (bounds) WriteBounds("linear critical speed, " + inputs.freight.name, *scatter, {bounds->speed}, &files);
  files.WriteText("stability.json", json);
  WriteReport(run, wagon, scatter, bounds, &files);
  PrintNotices(files.notices());
  Emit(arguments.output, text + files.Written(), json);
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
  app->add_flag("--no-type", arguments->no_type, "do not ask whether hunting sets in gently or with a jump");
  AddBoundsOptions(app, &arguments->bounds, 200);
  AddOutputOptions(app, &arguments->output, "out");
  AddWagonOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon stability --set set1 --geometry thesis-equivalent\n"
      "  wagon stability --set set2 --cargo packed --to 60\n"
      "  wagon stability --set out/parameters.toml --draws 1000 --corner-scatter 3     # 95 % bounds\n"
      "  wagon stability --json - --quiet | jq .linear_critical_speed.value\n\n"
      "Writes eigenvalues.csv, root_locus.svg and stability.json to the folder of --out, and where the set has a\n"
      "covariance bounds.svg and bounds_draws.csv.");
  return {app, [arguments] { return RunStability(*arguments); }};
}

}  // namespace uiclink
