// wagon bifurcation: where hunting begins, lives and dies.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "data/input_error.h"
#include "vehicle/bifurcation_work.h"
#include "vehicle/commands.h"
#include "vehicle/hunting/attractor_report.h"
#include "vehicle/hunting/bounds_report.h"
#include "vehicle/hunting/diagram_report.h"
#include "vehicle/hunting/fold_bounds.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using Arguments = BifurcationArguments;

/// A trivial multiplier farther from 1 than this says that the cycle's other multipliers are worth nothing.
constexpr double kTrustedTrivial = 1e-2;
/// Speeds of a trace: more of them take weeks.
constexpr double kMostSpeeds = 1e6;
// ---------------------------------------------------------------- what was asked for

/// "15:23:8": from 15 up to 23 and down to 8 [m/s].
std::vector<double> ParseLegs(const std::string& text) {
  std::vector<double> speeds;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(':', begin), text.size());
    double V = 0;
    const auto [rest, error] = std::from_chars(text.data() + begin, text.data() + end, V);
    if (error != std::errc() || rest != text.data() + end || !(V >= kLowestSpeed && V <= kHighestSpeed))
      throw UsageError(
          fmt::format("--legs: expected speeds from {:g} to {:g} m/s with ':' between them, such as "
                      "15:23:8, found \"{}\"",
                      kLowestSpeed, kHighestSpeed, text));
    if (!speeds.empty() && speeds.back() == V)
      throw UsageError(
          fmt::format("--legs: expected different speeds beside each other, found {:g} twice in \"{}\"", V, text));
    speeds.push_back(V);
    begin = end + 1;
  }
  if (speeds.size() < 2) throw UsageError(fmt::format("--legs: expected at least two speeds, found \"{}\"", text));
  return speeds;
}

/// The legs of the trace, and its range where nothing else has one.
void SetTrace(Arguments* arguments) {
  DiagramOptions& diagram = arguments->diagram;
  const std::vector<double> speeds = arguments->legs.empty()
                                         ? std::vector<double>{diagram.from, diagram.to, diagram.from}
                                         : ParseLegs(arguments->legs);
  TraceOptions& trace = arguments->trace;
  trace.from = speeds[0];
  trace.legs.clear();
  double way = 0;
  for (std::size_t i = 1; i < speeds.size(); ++i) {
    trace.legs.push_back({speeds[i], arguments->trace_step});
    way += std::abs(speeds[i] - speeds[i - 1]);
  }
  if (way / arguments->trace_step > kMostSpeeds)
    throw UsageError(fmt::format("--step: expected at most {:g} speeds, found {:g} m/s in steps of {:g}", kMostSpeeds,
                                 way, arguments->trace_step));
  if (trace.window > trace.hold)
    throw UsageError(
        fmt::format("--window: expected at most the {:g} s of --hold, found {:g}", trace.hold, trace.window));
  if (arguments->method != "trace") return;
  const auto [low, high] = std::ranges::minmax(speeds);
  diagram.from = low;
  diagram.to = high;
}

/// "3.5,5": the range of another parameter than the speed.
void SetRange(Arguments* arguments) {
  const std::string& text = arguments->range;
  const std::size_t comma = std::min(text.find(','), text.size());
  double low = 0, high = 0;
  const auto parse = [](const char* begin, const char* end, double* value) {
    const auto [rest, error] = std::from_chars(begin, end, *value);
    return error == std::errc() && rest == end && std::isfinite(*value);
  };
  const bool good = comma < text.size() && parse(text.data(), text.data() + comma, &low) &&
                    parse(text.data() + comma + 1, text.data() + text.size(), &high) && low < high;
  if (!good)
    throw UsageError(fmt::format("--range: expected two numbers LOW,HIGH with LOW < HIGH, found \"{}\"", text));
  arguments->diagram.from = low;
  arguments->diagram.to = high;
}

/// A diagram by another parameter than the speed.
void CheckParameter(Arguments* arguments) {
  if (!arguments->by_parameter()) {
    if (!arguments->range.empty()) throw UsageError("--range: expected --parameter NAME beside it, found none");
    return;
  }
  if (arguments->method != "continuation")
    throw UsageError("--parameter: expected --method continuation beside it, found " + arguments->method);
  if (!arguments->speed) throw UsageError("--parameter: expected --speed V beside it, found none");
  if (arguments->range.empty()) throw UsageError("--parameter: expected --range LOW,HIGH beside it, found none");
  if (arguments->bounds.asked)
    throw UsageError("--draws: they are of the nonlinear critical speed, not of a parameter");
  SetRange(arguments);
}

void CheckArguments(Arguments* arguments) {
  CheckParameter(arguments);
  if (!(arguments->diagram.from < arguments->diagram.to))
    throw UsageError(fmt::format("--to: expected more than --from, {:g} m/s, found {:g}", arguments->diagram.from,
                                 arguments->diagram.to));
  if (arguments->traces()) SetTrace(arguments);
  if (!arguments->traces() && !arguments->legs.empty())
    throw UsageError("--legs: expected --method trace or both beside it, found " + arguments->method);
  if ((arguments->surveys() || arguments->by_parameter()) != arguments->speed.has_value())
    throw UsageError(arguments->surveys() ? "--method attractors: expected --speed V beside it, found none"
                                          : "--speed: expected --method attractors or --parameter beside it, found " +
                                                arguments->method);
  if (arguments->starts && !arguments->surveys())
    throw UsageError("--attractors: expected --method attractors beside it, found " + arguments->method);
  if (arguments->starts) arguments->attractors.starts = *arguments->starts;
  arguments->diagram.threads = arguments->attractors.threads = arguments->threads;
  arguments->attractors.seed = arguments->bounds.seed;
}

/// What there is to be said beside the page, and what makes the exit code 1.
std::vector<std::string> ListFaults(const BifurcationRun& run) {
  std::vector<std::string> faults = run.diagram.notices;
  for (std::size_t i = 0; i < run.diagram.branches.size(); ++i) {
    const Branch& branch = run.diagram.branches[i].branch;
    const auto tell = [&](BranchEnd end, const std::string& reason) {
      if (end == BranchEnd::kLost || end == BranchEnd::kPoints)
        faults.push_back(
            fmt::format("branch {} goes on farther than it was followed: {}", i + 1, DescribeEnd(end, reason)));
    };
    if (branch.begin) tell(*branch.begin, branch.begin_reason);
    tell(branch.end, branch.reason);
  }
  if (const double worst = CalcWorstTrivialError(run.diagram); worst > kTrustedTrivial)
    faults.push_back(fmt::format("a trivial multiplier is {:.1e} from 1: stability is not to be trusted there", worst));
  if (run.trace && !run.trace->complete) faults.push_back("the trace ended early: " + run.trace->end_reason);
  return faults;
}

void WriteFiles(const BifurcationRun& run, const std::string& json, FigureWriter* files) {
  const std::vector<TraceRow>& rows = run.trace ? run.trace->rows : run.diagram.trace;
  if (run.continued) files->WriteText("bifurcation.csv", FormatCsv(BranchColumns(run)));
  if (!rows.empty()) files->WriteText("trace.csv", FormatCsv(TraceColumns(rows)));
  if (run.survey) files->WriteText("attractors.csv", FormatCsv(SurveyColumns(*run.survey)));
  if (run.continued || run.trace) files->Write("bifurcation", DiagramFigure(run), false);
  if (const Figure multipliers = MultiplierFigure(run); !multipliers.panels.empty())
    files->Write("multipliers", multipliers, false);
  files->WriteText("bifurcation.json", json);
}

/// Now rather than after a long computation.
void MakeFolder(const Output& output) {
  if (output.folder.empty()) return;
  std::error_code error;
  fs::create_directories(output.folder, error);
  if (error) throw InputError(output.folder, 0, "expected a folder that can be made, found: " + error.message());
}

/// The nonlinear critical speed of the draws, where it is a fold; else a notice says why there is none.
std::optional<FoldBounds> FindBounds(const SetScatter& scatter, const Wagon& wagon, const BifurcationRun& run,
                                     const Progress& progress) {
  const std::optional<NonlinearCritical>& critical = run.diagram.nonlinear;
  const auto refuse = [](const std::string& why) {
    PrintNotices({"no bounds of the nonlinear critical speed: " + why});
    return std::nullopt;
  };
  if (!critical || critical->by != "fold") return refuse("it is no fold of a branch here");
  const Branch& branch = run.diagram.branches.at(critical->branch).branch;
  const auto fold = std::ranges::find_if(branch.events, [&](const BranchEvent& event) {
    return event.kind == BranchEventKind::kFold && event.lambda == critical->speed;
  });
  if (fold == branch.events.end()) return refuse("its branch has no fold there");
  try {
    return CalcFoldBounds(scatter, wagon, *fold, branch.points, MakePropagateOptions(progress, "folds of the draws"));
  } catch (const CycleError& error) {  // hunting is not stable far enough above the fold
    return refuse(error.what());
  }
}

std::string FormatFirstOrder(const ScalarBounds& speed) {
  if (!speed.linear_low || !speed.linear_high) return {};
  return fmt::format("To first order: {:.4f} to {:.4f} m/s.\n", *speed.linear_low, *speed.linear_high);
}

int RunBifurcation(Arguments arguments) {
  CheckArguments(&arguments);
  CheckWritable(arguments.output);
  const WagonInputs inputs = ReadWagonInputs(arguments.choice);
  if (arguments.by_parameter()) FindChosenParameter(arguments, inputs);  // before anything is written
  PrintNotices(inputs.notices);
  const InterruptGuard guard;
  MakeFolder(arguments.output);
  const BifurcationRun run = ComputeBifurcation(arguments, inputs);
  std::string json = FormatBifurcationJson(run), text = FormatBifurcation(run);
  FigureWriter files(arguments.output);
  const std::optional<SetScatter> scatter = run.continued && !run.interrupted && !arguments.by_parameter()
                                                ? MakeScatter(arguments.bounds, inputs)
                                                : std::nullopt;
  std::vector<ScalarBounds> shown;
  if (scatter) {
    const Progress progress(arguments.output);
    const std::optional<FoldBounds> bounds = FindBounds(*scatter, MakeWagon(inputs), run, progress);
    progress.Clear();
    if (bounds) {
      json = WithLowAndHigh(json, "nonlinear_critical_speed", bounds->speed);
      json = WithKey(json, "bounds",
                     {{"scatter", ScatterToJson(*scatter)}, {"nonlinear_critical_speed", BoundsToJson(bounds->speed)}});
      text += "\n" + FormatBounds(*scatter, {bounds->speed}) + FormatFirstOrder(bounds->speed);
      shown = {bounds->speed};
      WriteBounds("nonlinear critical speed, " + inputs.freight.name, *scatter, shown, &files);
    }
  }
  WriteFiles(run, json, &files);
  files.WriteReport("bifurcation_report.html", [&](const PageOrigin& origin) {
    return ComposeBifurcationPage(run, MakePageBounds(scatter, shown), origin);
  });
  PrintNotices(files.notices());
  const std::vector<std::string> faults = ListFaults(run);
  PrintNotices(faults);
  Emit(arguments.output, text + files.Written(), json);
  if (run.interrupted) {
    const bool goes_on = HasProgress(arguments);
    fmt::print(stderr, "wagon: interrupted{}\n", goes_on ? "; the same command goes on where it was" : "");
  }
  return files.complete() && faults.empty() && !run.interrupted ? kAllDone : kSomeLeftOut;
}

// ---------------------------------------------------------------- options

CLI::Option* AddNumber(CLI::App* app, const std::string& name, double* value, const std::string& help, double low,
                       double high, const std::string& unit, const std::string& type) {
  return app->add_option(name, *value, help)
      ->type_name(type)
      ->check(CheckBetween(low, high, unit))
      ->capture_default_str();
}

CLI::Option* AddCount(CLI::App* app, const std::string& name, std::size_t* value, const std::string& help,
                      double high) {
  return app->add_option(name, *value, help)->type_name("N")->check(CheckBetween(1, high, ""))->capture_default_str();
}

void AddContinuationOptions(CLI::App* app, DiagramOptions* options) {
  const std::string group = "Continuation";
  AddNumber(app, "--trace-step", &options->trace_step, "of the coarse trace that looks for hunting [m/s]", 1e-3, 100,
            "m/s", "V")
      ->group(group);
  AddNumber(app, "--trace-hold", &options->trace_hold, "seconds at every speed of the coarse trace", 1, 1e5, "s", "T")
      ->group(group);
  AddNumber(app, "--settle", &options->start_settle, "seconds at the highest speed before it", 1e-3, 1e6, "s", "T")
      ->group(group);
  AddCount(app, "--max-points", &options->max_points, "of a branch", 1e6)->group(group);
  AddCount(app, "--max-branches", &options->max_branches, "of the diagram", 1e4)->group(group);
  AddNumber(app, "--max-step", &options->max_step, "along a branch: m/s, or 1 mm and 1 mrad of the state", 1e-3, 100,
            "", "S")
      ->group(group);
  AddNumber(app, "--tolerance", &options->tolerance, "to which a cycle closes, in 1 mm and 1 mrad", 1e-9, 1e-2, "",
            "TOL")
      ->group(group);
}

void AddParameterOptions(CLI::App* app, Arguments* arguments) {
  const std::string group = "Another parameter than the speed";
  app->add_option("--parameter", arguments->parameter,
                  "follow hunting in it, at --speed: lateral.k, longitudinal.T01, rear.lateral.k1, friction, "
                  "lateral_clearance_mm, .. (an unknown name lists all)")
      ->type_name("NAME")
      ->group(group);
  app->add_option("--range", arguments->range, "of the parameter, in its unit; for --from and --to")
      ->type_name("LOW,HIGH")
      ->group(group);
  app->add_option("--speed", arguments->speed, "at which; also of --method attractors [m/s]")
      ->type_name("V")
      ->check(CheckBetween(kLowestSpeed, kHighestSpeed, "m/s"))
      ->group(group);
}

void AddTraceOptions(CLI::App* app, Arguments* arguments) {
  const std::string group = "Trace (section 10.1 of the thesis)";
  app->add_option("--legs", arguments->legs,
                  "speeds from one to the next, such as 15:23:8 (default: from --from to --to and back)")
      ->type_name("V:V[:V...]")
      ->group(group);
  AddNumber(app, "--step", &arguments->trace_step, "of the speed [m/s]", 1e-4, 100, "m/s", "V")->group(group);
  AddNumber(app, "--hold", &arguments->trace.hold, "seconds at every speed; the thesis: 5 or 10", 1e-2, 1e6, "s", "T")
      ->group(group);
  AddNumber(app, "--window", &arguments->trace.window, "the last so many of them count", 1e-2, 1e6, "s", "T")
      ->group(group);
}

void AddSurveyOptions(CLI::App* app, Arguments* arguments) {
  const std::string group = "Attractors";
  app->add_option("--attractors", arguments->starts, "number of start states")
      ->type_name("N")
      ->check(CheckBetween(1, 1e6, ""))
      ->default_str(std::to_string(arguments->attractors.starts))
      ->group(group);
}

}  // namespace

Command AddBifurcationCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app =
      program->add_subcommand("bifurcation", "branches of hunting against speed or another parameter");
  app->add_option("--method", arguments->method,
                  "follow cycles, trace the speed up and down as the thesis did, both, or the attractors at one speed")
      ->type_name("continuation|trace|both|attractors")
      ->check(CLI::IsMember({"continuation", "trace", "both", "attractors"}))
      ->capture_default_str();
  AddNumber(app, "--from", &arguments->diagram.from, "lowest speed [m/s]", kLowestSpeed, kHighestSpeed, "m/s", "V");
  AddNumber(app, "--to", &arguments->diagram.to, "highest speed [m/s]", kLowestSpeed, kHighestSpeed, "m/s", "V");
  app->add_option("--threads", arguments->threads, "(default: all cores)")
      ->type_name("N")
      ->check(CheckBetween(1, 1024, ""));
  app->add_flag("--restart", arguments->restart, "do not go on from an interrupted trace or survey in --out");
  AddContinuationOptions(app, &arguments->diagram);
  AddParameterOptions(app, arguments.get());
  AddTraceOptions(app, arguments.get());
  AddSurveyOptions(app, arguments.get());
  AddBoundsOptions(app, &arguments->bounds, 0);
  AddOutputOptions(app, &arguments->output, "out");
  AddWagonOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon bifurcation --set set1 --geometry thesis-equivalent --com printed --from 8 --to 30\n"
      "  wagon bifurcation --parameter lateral.k --range 3,6 --speed 24 --geometry thesis-equivalent\n"
      "  wagon bifurcation --method trace --legs 15:23:8 --geometry thesis-equivalent\n"
      "  wagon bifurcation --method attractors --speed 24 --attractors 64 --cargo packed\n"
      "  wagon bifurcation --set out/parameters.toml --geometry thesis-equivalent --draws 20   # 95 % bounds\n"
      "  wagon bifurcation --json - --quiet | jq .nonlinear_critical_speed.value\n\n"
      "Writes bifurcation.csv, trace.csv, bifurcation.svg, multipliers.svg and bifurcation.json (attractors.csv) to "
      "the "
      "folder of --out.\n"
      "Interrupted (Ctrl-C), it writes what it has; a trace or a survey goes on with the same command. Exit code 1:\n"
      "a branch was lost or cut off, a trace ended early, or it was interrupted.");
  return {app, [arguments] { return RunBifurcation(*arguments); }};
}

}  // namespace uiclink
