// wagon spectrum: spectra of a run, phase locking, impacts, and where the energy goes.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>

#include "vehicle/commands.h"
#include "vehicle/hunting/history_file.h"
#include "vehicle/hunting/running_spectrum_report.h"
#include "vehicle/page/pages.h"
#include "vehicle/report_json.h"
#include "vehicle/simulation.h"
#include "vehicle/start_state.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  Output output;
  std::optional<double> speed;  // [m/s]
  std::string start = "front_lateral=5mm";
  double settle = 60;  // [s]
  double window = 60;  // [s]
  double output_hz = 200;
  std::size_t segments = 1;
  bool through_wheel_lift = false;
  double tolerance = IntegratorOptions{}.tolerance;
  std::string histories;
};

constexpr double kDefaultSpeed = 20;
constexpr double kMostSamples = 1e6;
/// At least, in a piece of the window: below it a spectrum has too few lines to have a peak.
constexpr double kLeastSamples = 64;

double SpeedOf(const Arguments& arguments) { return arguments.speed.value_or(kDefaultSpeed); }

/// @param samples  in the window.
void CheckSamples(const Arguments& arguments, double samples) {
  if (samples > kMostSamples)
    throw UsageError(
        fmt::format("--output-rate: expected at most {:g} samples in the window, found {:g} Hz over {:g} s",
                    kMostSamples, arguments.output_hz, arguments.window));
  if (2 * std::floor(samples) / (static_cast<double>(arguments.segments) + 1) >= kLeastSamples) return;
  throw UsageError(
      fmt::format("--window: expected at least {:g} samples in each piece of a spectrum, found {:.0f} samples for {} "
                  "(longer --window, higher --output-rate or fewer --segments)",
                  kLeastSamples, samples, arguments.segments));
}

SimulationOptions MakeOptions(const Arguments& arguments, double duration, const std::string& what,
                              const Progress& progress) {
  SimulationOptions options;
  options.duration = duration;
  options.window = duration;
  options.end_at_wheel_lift = !arguments.through_wheel_lift;
  options.on_progress = [&progress, what](double t) {
    progress.Show(fmt::format("{} {:.1f} s", what, t));
    return true;
  };
  return options;
}

/// The state after the time to settle. @throws std::runtime_error where the run ends in it.
WagonState Settle(Integrator* integrator, const Arguments& arguments, const WagonState& start,
                  const Progress& progress) {
  if (!(arguments.settle > 0)) return start;
  const SimulationResult settled =
      Simulate(*integrator, SpeedOf(arguments), start, MakeOptions(arguments, arguments.settle, "settling", progress));
  if (settled.end != SimulationEnd::kDuration)
    throw std::runtime_error("the run ended before its window: " + settled.end_reason +
                             " (--start, --speed, or --through-wheel-lift)");
  return settled.state;
}

/// Samples at equal distances: the last one begins the next period, and is left out.
std::vector<SimulationSample> TakeSamples(SimulationResult* result, const Arguments& arguments) {
  const auto most = static_cast<std::size_t>(std::lround(arguments.window * arguments.output_hz));
  if (result->samples.size() > most) result->samples.resize(most);
  return std::move(result->samples);
}

/// Over whole cycles, so that what is stored comes out as it went in; once more, by finer steps (MeasureLosses).
/// @param duration  that was run [s].
void AddLosses(const Arguments& arguments, const Wagon& wagon, const WagonState& from, double duration,
               SpectrumRun* run) {
  constexpr double kFinest = 1e-8;
  const double base = run->spectrum.base_hz;
  if (base > 0) run->cycles = std::floor(duration * base);
  if (run->cycles > 0) duration = run->cycles / base;
  run->losses =
      MeasureLosses(wagon, run->V, from, duration, {.tolerance = std::min(arguments.tolerance, kFinest), .method = {}});
  run->loss_parts = ListLosses(wagon, run->losses);
}

void RunWindow(const Arguments& arguments, const Wagon& wagon, SpectrumRun* run) {
  const Progress progress(arguments.output);
  const double V = SpeedOf(arguments);
  const RunStart start = MakeRunStart(arguments.start, wagon, V);
  Integrator integrator(wagon, {.tolerance = arguments.tolerance, .method = {}});
  const WagonState settled = Settle(&integrator, arguments, start.state, progress);
  SimulationOptions options = MakeOptions(arguments, arguments.window, "window at", progress);
  options.output_hz = arguments.output_hz;
  SimulationResult result = Simulate(integrator, V, settled, options);
  const std::vector<SimulationSample> samples = TakeSamples(&result, arguments);
  CheckSamples(arguments, static_cast<double>(samples.size()));
  run->V = V;
  run->source = start.words;
  run->settle = arguments.settle;
  run->end_reason = result.end_reason;
  run->spectrum = CalcRunningSpectrum(samples, arguments.output_hz, arguments.segments);
  run->guidance = CalcGuidanceHistory(wagon, samples);
  run->uses = {.lateral = result.lateral, .longitudinal = result.longitudinal};
  progress.Show("measuring losses");
  AddLosses(arguments, wagon, settled, result.simulated, run);
}

void ReadWindow(const Arguments& arguments, const Wagon& wagon, SpectrumRun* run) {
  HistoryFile history = ReadHistoryFile(arguments.histories);
  if (const std::string notice = CompareGuides(history, wagon, arguments.histories); !notice.empty())
    PrintNotices({notice});
  std::vector<SimulationSample>& samples = history.samples;
  const auto wanted = static_cast<std::size_t>(std::lround(arguments.window * history.hz));
  if (samples.size() < wanted) {
    PrintNotices(
        {fmt::format("{} has {:.4g} s, less than the window of {:g} s: all of it is taken", arguments.histories,
                     static_cast<double>(samples.size()) / history.hz, arguments.window)});
  } else {
    samples.erase(samples.begin(), samples.end() - static_cast<std::ptrdiff_t>(wanted));
  }
  CheckSamples(arguments, static_cast<double>(samples.size()));
  run->V = arguments.speed.value_or(0);
  run->source = arguments.histories;
  run->from_file = true;
  run->spectrum = CalcRunningSpectrum(samples, history.hz, arguments.segments);
  run->guidance = CalcGuidanceHistory(wagon, samples);
  run->uses = CountGuidanceUse(run->guidance);
}

/// The same wagon with joints that slide for ever, as a large motion sees them: without their springs.
Wagon MakeSlidingWagon(const WagonInputs& inputs) {
  WagonInputs sliding = inputs;
  for (CornerLinks& links : sliding.links) {
    for (DirectionParameters* link : {&links.longitudinal, &links.lateral}) {
      link->sliders.clear();
      std::erase_if(link->effects, [](const EffectValues& effect) {
        return effect.id == "extra_slider" || effect.id == "micro_slip" || effect.id == "rolling_friction";
      });
    }
  }
  return MakeWagon(sliding);
}

void WriteFiles(const SpectrumRun& run, const std::string& json, FigureWriter* files) {
  files->WriteText("spectrum.csv", FormatCsv(SpectrumColumns(run)));
  files->Write("spectrum", SpectrumFigure(run), false);
  files->WriteText("impacts.csv", FormatCsv(GuidanceColumns(run.guidance)));
  files->Write("impacts", ImpactFigure(run), false);
  if (!run.from_file) {
    files->WriteText("losses.csv", FormatLossesCsv(run));
    files->Write("losses", LossFigure(run), false);
  }
  files->WriteText("spectrum.json", json);
}

int RunSpectrum(const Arguments& arguments) {
  CheckRunStart(arguments.start);
  if (arguments.histories.empty()) CheckSamples(arguments, arguments.window * arguments.output_hz);
  CheckWritable(arguments.output);
  const auto begin = std::chrono::steady_clock::now();
  const WagonInputs inputs = ReadWagonInputs(arguments.choice);
  PrintNotices(inputs.notices);
  const Wagon wagon = MakeWagon(inputs);
  SpectrumRun run{.inputs = inputs, .source = {}};
  if (arguments.histories.empty()) {
    RunWindow(arguments, wagon, &run);
  } else {
    ReadWindow(arguments, wagon, &run);
  }
  if (run.V > 0) run.vibrations = FindFreeVibrations(wagon, MakeSlidingWagon(inputs), run.V);
  NameFreeLines(run.vibrations, &run.spectrum);
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

  const std::string json = FormatSpectrumJson(run);
  FigureWriter files(arguments.output);
  WriteFiles(run, json, &files);
  files.WriteReport("spectrum_report.html", [&](const PageOrigin& origin) { return ComposeSpectrumPage(run, origin); });
  PrintNotices(files.notices());
  if (!run.end_reason.empty()) fmt::print(stderr, "wagon: the run ended early: {}\n", run.end_reason);
  if (run.spectrum.at_rest) PrintNotices({"the wagon is at rest in the window: no lines, no cycles"});
  Emit(arguments.output, FormatSpectrum(run) + files.Written(), json);
  return run.end_reason.empty() && !run.spectrum.at_rest && files.complete() ? kAllDone : kSomeLeftOut;
}

void AddRunOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--speed", arguments->speed,
                  "speed [m/s]; with --histories, of that run: then lines are laid beside its free vibrations")
      ->type_name("V")
      ->check(CheckBetween(kLowestSpeed, kHighestSpeed, "m/s"))
      ->default_str(fmt::format("{:g}", kDefaultSpeed));
  app->add_option("--start", arguments->start,
                  "equilibrium, a state file, or displacements from the equilibrium with units, as for simulate")
      ->type_name("START")
      ->capture_default_str();
  app->add_option("--settle", arguments->settle, "simulated before the window [s]")
      ->type_name("T")
      ->check(CheckBetween(0, 1e6, "s"))
      ->capture_default_str();
  app->add_option("--window", arguments->window,
                  "that the spectra, impacts and losses are of [s]; of --histories the last")
      ->type_name("T")
      ->check(CheckBetween(1e-3, 1e6, "s"))
      ->capture_default_str();
  app->add_option("--output-rate", arguments->output_hz, "samples per second for spectra and impacts.csv")
      ->type_name("HZ")
      ->check(CheckBetween(20, 1e5, "Hz"))
      ->capture_default_str();
  app->add_option("--segments", arguments->segments,
                  "pieces, each overlapping the next by half, whose power spectra are averaged (Welch)")
      ->type_name("N")
      ->check(CheckBetween(1, 1000, ""))
      ->capture_default_str();
  app->add_flag("--through-wheel-lift", arguments->through_wheel_lift, "go on when a wheel leaves its rail");
  app->add_option("--tolerance", arguments->tolerance, "of a step, relative to 1 mm and 1 mrad")
      ->type_name("TOL")
      ->check(CheckBetween(1e-12, 0.1, ""))
      ->capture_default_str();
}

}  // namespace

Command AddSpectrumCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app = program->add_subcommand(
      "spectrum", "spectra of a run with phase locking, impacts, and the energy lost in each joint");
  AddRunOptions(app, arguments.get());
  CLI::Option* const histories =
      app->add_option(
             "--histories", arguments->histories,
             "a histories.csv that wagon simulate wrote, instead of a run; of the wagon that the options below "
             "describe. Losses are left out")
          ->type_name("FILE");
  for (const char* option : {"--start", "--settle", "--output-rate", "--through-wheel-lift", "--tolerance"})
    histories->excludes(app->get_option(option));
  AddOutputOptions(app, &arguments->output, "out");
  AddWagonOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon spectrum --set set1 --geometry thesis-equivalent --com printed --speed 24\n"
      "  wagon spectrum --set set2 --speed 38 --start front_lateral=0.1mm,rear_lateral=0.1mm --settle 150\n"
      "  wagon spectrum --histories out/histories.csv --window 20 --segments 4\n"
      "  wagon spectrum --json - --quiet | jq '.losses.parts[] | select(.share > 0.05)'\n\n"
      "Writes spectrum.csv, impacts.csv, losses.csv, their pictures and spectrum.json to the folder of --out. Exit "
      "code "
      "1 where the\nwagon rests or the run ended early.");
  return {app, [arguments] { return RunSpectrum(*arguments); }};
}

}  // namespace uiclink
