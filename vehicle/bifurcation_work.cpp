// The work of wagon bifurcation: what takes long, and can go on where it was.

#include "vehicle/bifurcation_work.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "data/file.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/parameter_diagram.h"
#include "vehicle/hunting/progress_file.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Arguments = BifurcationArguments;

/// Between two savings of what is done.
constexpr std::chrono::seconds kSaveInterval{5};

double SecondsSince(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

constexpr const char* kTraceProgress = "trace.progress";
constexpr const char* kSurveyProgress = "attractors.progress";

/// Empty without a folder.
fs::path ProgressPath(const Arguments& arguments, const char* name) {
  return arguments.output.folder.empty() ? fs::path() : fs::path(arguments.output.folder) / name;
}

/// Once all is done.
void RemoveProgress(const Arguments& arguments, const char* name) {
  std::error_code ignored;
  if (const fs::path path = ProgressPath(arguments, name); !path.empty()) fs::remove(path, ignored);
}

/// A file in the folder of the results with what is done so far; none without a folder.
class ProgressFile {
 public:
  ProgressFile(const Arguments& arguments, const char* name, const WagonInputs& inputs, Json options)
      : path_(ProgressPath(arguments, name)),
        restart_(arguments.restart),
        of_{{"version", UICLINK_VERSION}, {"inputs", InputsToJson(inputs)}, {"options", std::move(options)}} {}

  /// What an earlier call has left of the same computation.
  template <typename Result>
  std::optional<Result> Read(const Wagon& wagon, std::optional<Result> (*parse)(const std::string&, const std::string&,
                                                                                const Wagon&, const Json&)) const {
    if (path_.empty() || restart_ || !fs::exists(path_)) return std::nullopt;
    std::optional<Result> result = parse(ReadFileWhole(path_), path_.string(), wagon, of_);
    if (!result) PrintNotices({path_.string() + " is of something else: begun anew"});
    return result;
  }
  /// From time to time, or at once.
  template <typename Format>
  void Save(const Format& format, bool now) {
    if (path_.empty() || (!now && Clock::now() - saved_ < kSaveInterval)) return;
    WriteFileWhole(path_, format());
    saved_ = Clock::now();
  }
  const Json& of() const { return of_; }

 private:
  fs::path path_;
  bool restart_;
  Json of_;
  Clock::time_point saved_ = Clock::now();
};

Json TraceOptionsToJson(const TraceOptions& options) {
  Json legs = Json::array();
  for (const TraceLeg& leg : options.legs) legs.push_back({leg.to, leg.step});
  return {{"from", options.from},
          {"legs", legs},
          {"hold", options.hold},
          {"window", options.window},
          {"disturbance", options.disturbance},
          {"tolerance", options.integrator.tolerance}};
}

TraceRun RunTrace(const Arguments& arguments, const WagonInputs& inputs, const Wagon& wagon, const Progress& progress) {
  const TraceOptions& options = arguments.trace;
  ProgressFile file(arguments, kTraceProgress, inputs, TraceOptionsToJson(options));
  std::optional<TraceProgress> earlier = file.Read<TraceProgress>(wagon, ParseTraceProgress);
  TraceProgress done = earlier ? std::move(*earlier) : TraceProgress{{0, FindEquilibrium(wagon, options.from)}, {}, 0};
  const std::size_t before = done.at.rows;
  const double wall_before = done.wall_s;
  const Clock::time_point begin = Clock::now();
  const auto format = [&] { return FormatTraceProgress(wagon, file.of(), done); };
  const Trace trace =
      TraceBifurcation(wagon, done.at, options, [&](const TraceRow& row, const TracePoint& at, std::size_t rows) {
        done.rows.push_back(row);
        done.at = at;
        const double wall = SecondsSince(begin);
        done.wall_s = wall_before + wall;
        const double left = wall / static_cast<double>(at.rows - before) * static_cast<double>(rows - at.rows);
        progress.Show(
            fmt::format("trace: {:.2f} m/s, {} of {} speeds, {} left", row.V, at.rows, rows, FormatDuration(left)));
        file.Save(format, false);
        return !InterruptGuard::Interrupted();
      });
  progress.Clear();
  // A trace that derailed is not gone on with; a complete one is kept until all is done.
  if (trace.complete || trace.end_reason == "stopped") {
    file.Save(format, true);
  } else {
    RemoveProgress(arguments, kTraceProgress);
  }
  return {options, std::move(done.rows), trace.complete, trace.end_reason, wall_before + trace.wall_s};
}

Json SurveyOptionsToJson(double V, const AttractorOptions& options) {
  return {{"speed", V}, {"seed", options.seed}, {"settle", options.settle}, {"longest", options.longest}};
}

/// None where it was interrupted.
std::optional<AttractorSurvey> RunSurvey(const Arguments& arguments, const WagonInputs& inputs, const Wagon& wagon,
                                         const Progress& progress) {
  AttractorOptions options = arguments.attractors;
  ProgressFile file(arguments, kSurveyProgress, inputs, SurveyOptionsToJson(*arguments.speed, options));
  KnownRuns known = file.Read<KnownRuns>(wagon, ParseRunProgress).value_or(KnownRuns{});
  std::erase_if(known, [&](const auto& run) { return run.first >= options.starts; });
  options.known = known;
  const auto format = [&] { return FormatRunProgress(wagon, file.of(), known); };
  const Clock::time_point begin = Clock::now();
  const std::size_t before = known.size();
  options.on_run = [&](std::size_t number, const RunOutcome& run) {
    known.emplace(number, run);
    const auto made = static_cast<double>(known.size() - before);
    const double left = SecondsSince(begin) / made * static_cast<double>(options.starts - known.size());
    progress.Show(fmt::format("{} of {} start states, {} left", known.size(), options.starts, FormatDuration(left)));
    file.Save(format, false);
    return !InterruptGuard::Interrupted();
  };
  const AttractorSurvey survey = FindAttractors(wagon, *arguments.speed, options);
  progress.Clear();
  if (!survey.stopped) return survey;
  file.Save(format, true);
  return std::nullopt;
}

BifurcationDiagram FollowBranches(const Arguments& arguments, const WagonInputs& inputs, const Wagon& wagon,
                                  const Progress& progress) {
  DiagramOptions options = arguments.diagram;
  const Clock::time_point begin = Clock::now();
  options.on_progress = [&](const std::string& what) {
    progress.Show(fmt::format("{} ({})", what, FormatDuration(SecondsSince(begin))));
    return !InterruptGuard::Interrupted();
  };
  BifurcationDiagram diagram;
  if (arguments.by_parameter()) {
    const ChosenParameter chosen = FindChosenParameter(arguments, inputs);
    diagram = CalcParameterDiagram(chosen.family, chosen.parameter.value, options);
  } else {
    diagram = CalcDiagram(wagon, options);
  }
  progress.Clear();
  return diagram;
}

/// The speeds at which the equilibrium changes over; for methods that do not look at it.
void FindLinear(const Arguments& arguments, const Wagon& wagon, BifurcationDiagram* diagram) {
  StabilityOptions search;
  search.from = arguments.diagram.from;
  search.to = arguments.diagram.to;
  diagram->linear = FindCrossings(wagon, search);
}

}  // namespace

ChosenParameter FindChosenParameter(const BifurcationArguments& arguments, const WagonInputs& inputs) {
  ChosenParameter chosen{.parameter = FindWagonParameter(inputs, arguments.parameter), .family = {}};
  chosen.family =
      FamilyByParameter(inputs, chosen.parameter, *arguments.speed, arguments.diagram.from, arguments.diagram.to);
  return chosen;
}

BifurcationRun ComputeBifurcation(const BifurcationArguments& arguments, const WagonInputs& inputs) {
  const Clock::time_point begin = Clock::now();
  const Wagon wagon = MakeWagon(inputs);
  const Progress progress(arguments.output);
  BifurcationRun run{.inputs = inputs, .method = arguments.method, .options = arguments.diagram};
  run.survey_options = arguments.attractors;
  // The trace first: what it has done is kept, what the continuation has is not.
  if (arguments.traces()) run.trace = RunTrace(arguments, inputs, wagon, progress);
  if (arguments.continues() && !InterruptGuard::Interrupted()) {
    run.diagram = FollowBranches(arguments, inputs, wagon, progress);
    run.continued = true;
  } else if (!arguments.by_parameter()) {
    FindLinear(arguments, wagon, &run.diagram);
  }
  if (arguments.surveys()) run.survey = RunSurvey(arguments, inputs, wagon, progress);
  run.interrupted = InterruptGuard::Interrupted();
  if (!run.interrupted && arguments.traces()) RemoveProgress(arguments, kTraceProgress);
  if (!run.interrupted && arguments.surveys()) RemoveProgress(arguments, kSurveyProgress);
  run.wall_s = SecondsSince(begin);
  return run;
}

bool HasProgress(const BifurcationArguments& arguments) {
  return fs::exists(ProgressPath(arguments, arguments.surveys() ? kSurveyProgress : kTraceProgress));
}

}  // namespace uiclink
