// wagon simulate: a run in time, with its histories, figures and summary.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "vehicle/command_bounds.h"
#include "vehicle/commands.h"
#include "vehicle/hunting/bounds_report.h"
#include "vehicle/hunting/hunting_bounds.h"
#include "vehicle/mat_file.h"
#include "vehicle/page/pages.h"
#include "vehicle/report_json.h"
#include "vehicle/simulation.h"
#include "vehicle/simulation_report.h"
#include "vehicle/start_state.h"
#include "vehicle/state_file.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  Output output;
  double speed = 20;  // [m/s]
  double until = 60;  // [s]
  std::string start = "equilibrium";
  double output_hz = 100;
  bool no_forces = false;
  bool through_wheel_lift = false;
  double window = 10;  // [s]
  double tolerance = IntegratorOptions{}.tolerance;
  std::string state_file;
  bool resume = false;
  BoundsArguments bounds;
};

/// What a saved run must have in common with the one that goes on from it.
std::string Identity(const WagonInputs& inputs, const Arguments& arguments) {
  const WagonOptions& options = inputs.choice.options;
  constexpr std::size_t kDigits = 16;
  std::string identity = fmt::format(
      "speed={} tolerance={} com={} partitions={} suspension={} guidance={} penetration={} friction={} "
      "roll={}",
      arguments.speed, arguments.tolerance, Name(inputs.choice.inertia.com), Name(inputs.choice.inertia.partitions),
      Name(options.suspension), options.guidance ? "yes" : "no", Name(options.penetration), options.mu,
      options.printed_roll ? "printed" : "corrected");
  for (const InputFile& file : inputs.files) {
    identity += fmt::format(" {}={}", file.role, file.sha256.substr(0, kDigits));
    if (file.role == "set") identity += fmt::format("({})", fmt::join(file.used_for, ","));
  }
  std::string start = arguments.start;
  std::erase(start, ' ');  // words of an identity are apart by blanks
  return identity + " start=" + start;
}

/// Samples stay in memory: 3 kB each with their forces and the text of the file.
void CheckSampleCount(const Arguments& arguments, const WagonState& start) {
  constexpr double kMost = 1e6;
  const double samples = (arguments.until - start.t) * arguments.output_hz;
  if (samples <= kMost) return;
  throw UsageError(fmt::format("--output-rate: expected at most {:g} samples, {:g} Hz over {:g} s, found {:g} Hz",
                               kMost, kMost / (arguments.until - start.t), arguments.until - start.t,
                               arguments.output_hz));
}

/// From the saved run if there is one, with --resume; else as --start says.
RunStart FindStart(const Arguments& arguments, const Wagon& wagon, const std::string& identity) {
  if (arguments.resume && std::filesystem::exists(arguments.state_file)) {
    const SavedState saved = ReadStateFile(arguments.state_file, wagon, identity);
    return {saved.state, fmt::format("resumed from {} at {:g} s", arguments.state_file, saved.state.t)};
  }
  return MakeRunStart(arguments.start, wagon, arguments.speed);
}

/// Keeps the last state from which a run can go on bit by bit, and writes it from time to time.
class Checkpoints {
 public:
  Checkpoints(const Arguments& arguments, const Wagon& wagon, std::string identity)
      : file_(arguments.state_file), speed_(arguments.speed), wagon_(wagon), identity_(std::move(identity)) {}

  /// @param interval  of the states that a run may go on from [s]; the last one of a run may lie between.
  void Take(const WagonState& state, double interval) {
    if (file_.empty()) return;
    const bool exact = std::abs(std::remainder(state.t, interval)) < 1e-9 * interval;
    if (!exact && last_) return;
    last_ = state;
    const auto now = std::chrono::steady_clock::now();
    if (now - written_ < std::chrono::seconds(5)) return;
    written_ = now;
    Write();
  }
  void Write() const {
    if (last_) WriteStateFile(file_, wagon_, {.state = *last_, .V = speed_, .identity = identity_});
  }

 private:
  std::string file_;
  double speed_;
  const Wagon& wagon_;
  std::string identity_;
  std::optional<WagonState> last_;
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

SimulationOptions MakeOptions(const Arguments& arguments, const WagonState& start, const Progress& progress) {
  SimulationOptions options;
  options.duration = arguments.until - start.t;
  options.output_hz = arguments.output_hz;
  options.output_forces = !arguments.no_forces;
  options.window = arguments.window;
  options.end_at_wheel_lift = !arguments.through_wheel_lift;
  options.integrator.tolerance = arguments.tolerance;
  options.on_progress = [&progress, until = arguments.until](double t) {
    progress.Show(fmt::format("simulating {:.1f} of {:g} s", t, until));
    return !InterruptGuard::Interrupted();
  };
  return options;
}

/// Names of files of a run that was resumed say from where, so that those of its first part stay.
std::string FileName(const SimulationRun& run) {
  return run.start_s > 0 ? fmt::format("histories_from_{:g}s", run.start_s) : "histories";
}

void WriteFiles(const SimulationRun& run, const std::string& json, FigureWriter* files) {
  if (!run.result.samples.empty()) {
    const std::vector<DataColumn> columns = HistoryColumns(run);
    files->WriteText(FileName(run) + ".csv", FormatCsv(columns));
    files->WriteText(FileName(run) + ".mat", FormatMatFile(columns, std::vector<MatText>{{"result", json}}));
    files->Write(FileName(run), HistoryFigure(run), false);
  }
  files->WriteText(run.start_s > 0 ? fmt::format("simulation_from_{:g}s.json", run.start_s) : "simulation.json", json);
}

/// Every draw runs on from where the run has ended, for as long as it took and at most kDrawDuration.
std::vector<ScalarBounds> FindBounds(const Arguments& arguments, const SetScatter& scatter, const Wagon& wagon,
                                     const SimulationResult& result, const Progress& progress) {
  constexpr double kDrawDuration = 30;  // [s]
  SimulationOptions options;
  options.duration = std::min(result.simulated, std::max(kDrawDuration, arguments.window));
  options.window = arguments.window;
  options.end_at_wheel_lift = !arguments.through_wheel_lift;
  options.integrator.tolerance = arguments.tolerance;
  return CalcHuntingBounds(scatter, wagon, arguments.speed, result.state, options,
                           MakePropagateOptions(progress, "runs of the draws"));
}

int RunSimulate(const Arguments& arguments) {
  if (arguments.resume && arguments.state_file.empty())
    throw UsageError("--resume: expected --save-state FILE beside it, found none");
  CheckRunStart(arguments.start);
  CheckWritable(arguments.output, {arguments.state_file});
  const WagonInputs inputs = ReadWagonInputs(arguments.choice);
  PrintNotices(inputs.notices);
  const Wagon wagon = MakeWagon(inputs);
  const std::string identity = Identity(inputs, arguments);
  const RunStart start = FindStart(arguments, wagon, identity);
  if (!(arguments.until > start.state.t)) {
    throw UsageError(fmt::format("--time: expected more than the {:g} s that {} has run, found {:g}", start.state.t,
                                 arguments.state_file, arguments.until));
  }
  CheckSampleCount(arguments, start.state);
  const Progress progress(arguments.output);
  Checkpoints checkpoints(arguments, wagon, identity);
  SimulationOptions options = MakeOptions(arguments, start.state, progress);
  options.on_checkpoint = [&](const WagonState& state) { checkpoints.Take(state, options.checkpoint_interval); };
  const SimulationResult result = [&] {
    const InterruptGuard guard;  // what was simulated is written
    return Simulate(wagon, arguments.speed, start.state, options);
  }();
  checkpoints.Write();
  const bool whole = result.end == SimulationEnd::kDuration;
  const std::optional<SetScatter> scatter = whole ? MakeScatter(arguments.bounds, inputs) : std::nullopt;
  const std::vector<ScalarBounds> bounds =
      scatter ? FindBounds(arguments, *scatter, wagon, result, progress) : std::vector<ScalarBounds>{};
  progress.Clear();

  const SimulationRun run{inputs, result, start.words, start.state.t, arguments.window};
  std::string json = FormatSimulationJson(run), text = FormatSimulation(run);
  if (scatter) {
    Json told = {{"scatter", ScatterToJson(*scatter)}};
    for (const ScalarBounds& scalar : bounds) told[scalar.name] = BoundsToJson(scalar);
    json = WithKey(json, "bounds", told);
    text += "\n" + FormatBounds(*scatter, bounds);
  }
  FigureWriter files(arguments.output);
  WriteFiles(run, json, &files);
  if (scatter) WriteBounds(fmt::format("{:g} m/s, {}", arguments.speed, inputs.freight.name), *scatter, bounds, &files);
  files.WriteReport(
      run.start_s > 0 ? fmt::format("simulation_report_from_{:g}s.html", run.start_s) : "simulation_report.html",
      [&](const PageOrigin& origin) {
        return ComposeSimulationPage(run, wagon, MakePageBounds(scatter, bounds), origin);
      });
  PrintNotices(files.notices());
  if (result.end != SimulationEnd::kDuration) fmt::print(stderr, "wagon: the run ended early: {}\n", result.end_reason);
  Emit(arguments.output, text + files.Written(), json);
  return whole && files.complete() ? kAllDone : kSomeLeftOut;
}

}  // namespace

Command AddSimulateCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app =
      program->add_subcommand("simulate", "a run in time: histories, amplitudes, frequencies, impacts");
  app->add_option("--speed", arguments->speed, "speed [m/s]")
      ->type_name("V")
      ->check(CheckBetween(kLowestSpeed, kHighestSpeed, "m/s"))
      ->capture_default_str();
  app->add_option("--time", arguments->until, "until when to simulate [s]")
      ->type_name("T")
      ->check(CheckBetween(1e-6, 1e7, "s"))
      ->capture_default_str();
  app->add_option("--start", arguments->start,
                  "equilibrium, a state file, or displacements from the equilibrium with units: "
                  "front_lateral=5mm,body_roll=1mrad "
                  "(front_lateral, rear_lateral, body_lateral; front_yaw, rear_yaw, body_yaw, body_roll)")
      ->type_name("START")
      ->capture_default_str();
  app->add_option("--window", arguments->window, "amplitudes and frequencies are of the last so many seconds")
      ->type_name("T")
      ->check(CheckBetween(1e-6, 1e7, "s"))
      ->capture_default_str();
  app->add_option("--output-rate", arguments->output_hz, "samples per second in the histories; 0: none")
      ->type_name("HZ")
      ->check(CheckBetween(0, 1e5, "Hz"))
      ->capture_default_str();
  app->add_flag("--no-forces", arguments->no_forces, "histories without forces");
  app->add_flag("--through-wheel-lift", arguments->through_wheel_lift, "go on when a wheel leaves its rail");
  app->add_option("--tolerance", arguments->tolerance, "of a step, relative to 1 mm and 1 mrad")
      ->type_name("TOL")
      ->check(CheckBetween(1e-12, 0.1, ""))
      ->capture_default_str();
  app->add_option("--save-state", arguments->state_file,
                  "write the state from time to time and at the end, to go on from")
      ->type_name("FILE");
  app->add_flag("--resume", arguments->resume,
                "go on from the file of --save-state, if it is there; bit by bit as one run");
  AddBoundsOptions(app, &arguments->bounds, 0);
  AddOutputOptions(app, &arguments->output, "out");
  AddWagonOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon simulate --set set1 --speed 24 --time 60 --start front_lateral=5mm\n"
      "  wagon simulate --set out/parameters.toml --cargo packed --speed 30 --json - --quiet | jq .amplitude_mm\n"
      "  wagon simulate --set lateral=set2 --set longitudinal=set1 --geometry thesis-equivalent --no-guidance\n"
      "  wagon simulate --time 3600 --save-state long.state --resume     # again after an interruption, or for "
      "longer\n\n"
      "Writes histories.csv, histories.mat, histories.svg and simulation.json to the folder of --out. Interrupted "
      "(Ctrl-C), it writes\n"
      "what it has; exit code 1, as after a wheel lift or a derailment.");
  return {app, [arguments] { return RunSimulate(*arguments); }};
}

}  // namespace uiclink
