// A run in time: amplitudes, frequencies, impacts, wheel loads (vehicle/simulation.h).

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <utility>

#include "vehicle/equilibrium.h"
#include "vehicle/side_by_side.h"
#include "vehicle/simulation.h"
#include "vehicle/start_state.h"
#include "vehicle/sweep/run_kind.h"

namespace uiclink {
namespace {

constexpr std::array<const char*, kAxles> kAxleNames{"front", "rear"};

std::vector<ResultColumn> MakeColumns() {
  std::vector<ResultColumn> columns;
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    const bool angle = kMotionIndex[i] == kBody + body::kPsi || kMotionIndex[i] == kBody + body::kPhi;
    columns.push_back({fmt::format("amplitude_{}_{}", kMotionNames[i], angle ? "mrad" : "mm")});
  }
  for (const char* const motion : kMotionNames) columns.push_back({fmt::format("frequency_{}_hz", motion)});
  for (const char* const direction : {"lateral", "longitudinal"}) {
    for (const char* const axle : kAxleNames) {
      const std::string place = fmt::format("{}_{}", axle, direction);
      columns.push_back({"clearance_used_" + place + "_mm"});
      columns.push_back({"impacts_" + place, true});
      columns.push_back({"impact_peak_" + place + "_N"});
      columns.push_back({"impacts_in_window_" + place, true});
    }
  }
  columns.push_back({"minimum_wheel_load_N"});
  columns.push_back({"simulated_s"});
  for (const char* const count : {"steps", "rhs_calls", "events"}) columns.push_back({count, true});
  return columns;
}

std::vector<double> ListFigures(const SimulationResult& result) {
  std::vector<double> values;
  for (const MotionFigures& motion : result.motions) values.push_back(1e3 * motion.amplitude);
  for (const MotionFigures& motion : result.motions) {
    values.push_back(motion.frequencies.empty() ? std::numeric_limits<double>::quiet_NaN() : motion.frequencies[0]);
  }
  for (const auto* const direction : {&result.lateral, &result.longitudinal}) {
    for (const GuidanceUse& use : *direction) {
      values.insert(values.end(), {1e3 * use.clearance_used, static_cast<double>(use.impacts.count), use.impacts.peak_N,
                                   static_cast<double>(use.impacts_in_window.count)});
    }
  }
  values.insert(values.end(),
                {result.minimum_wheel_load, result.simulated, static_cast<double>(result.counts.steps),
                 static_cast<double>(result.counts.rhs_calls), static_cast<double>(result.counts.events)});
  return values;
}

RunStatus StatusOf(SimulationEnd end) {
  switch (end) {
    case SimulationEnd::kWheelLift:
      return RunStatus::kWheelLift;
    case SimulationEnd::kDerailed:
      return RunStatus::kDerailed;
    case SimulationEnd::kFailed:
      return RunStatus::kFailed;
    case SimulationEnd::kStopped:
      throw RunGivenUp();
    case SimulationEnd::kDuration:
      break;
  }
  return RunStatus::kDone;
}

Perturbation Add(const Perturbation& a, const Perturbation& b) {
  return {.front_y = a.front_y + b.front_y,
          .rear_y = a.rear_y + b.rear_y,
          .body_y = a.body_y + b.body_y,
          .body_phi = a.body_phi + b.body_phi,
          .body_psi = a.body_psi + b.body_psi,
          .front_psi = a.front_psi + b.front_psi,
          .rear_psi = a.rear_psi + b.rear_psi};
}

WagonState FindStart(const Wagon& wagon, const RunSetup& setup) {
  const Perturbation text = setup.start == "equilibrium" ? Perturbation{} : ParsePerturbation(setup.start);
  const WagonState start = Perturb(wagon, FindEquilibrium(wagon, setup.speed), Add(text, setup.by));
  const double reach = FindTrackLimit(wagon.contact);
  for (const double y : {start.x[wheelset::kY], start.x[kRearWheelset + wheelset::kY]}) {
    if (std::abs(y) < reach) continue;
    throw UsageError(fmt::format("start: expected wheelsets on the rails, {:g} mm to either side, found one at {:g} mm",
                                 1e3 * reach, 1e3 * y));
  }
  return start;
}

SweepOutcome Conclude(const SimulationResult& result, const std::string& when) {
  const RunStatus status = StatusOf(result.end);
  if (status == RunStatus::kFailed) return {.status = status, .reason = result.end_reason + when};
  return {status, result.end_reason.empty() ? "" : result.end_reason + when, ListFigures(result)};
}

/// The runs of one thread, side by side. Those that have settled come before new ones.
class Runs {
 public:
  Runs(RunSource& source, double settle, const SimulationOptions& options)
      : source_(source), settle_(settle), options_(options) {}

  std::optional<SimulationTask> Next() {
    if (!settled_.empty()) {
      SimulationTask task = std::move(settled_.front());
      settled_.pop_front();
      return task;
    }
    while (std::optional<RunJob> job = source_.Next()) {
      const Clock::time_point begin = Clock::now();
      try {
        const WagonState start = FindStart(*job->bench.wagon, job->setup);
        job->prepared_s += std::chrono::duration<double>(Clock::now() - begin).count();
        const auto shared = std::make_shared<const RunJob>(std::move(*job));
        return settle_ > 0 ? ToSettle(shared, start) : ToRun(shared, start, 0);
      } catch (const std::exception& fault) {
        const double wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
        source_.Finish(*job, {.status = RunStatus::kFailed, .reason = fault.what()}, wall_s);
      }
    }
    return std::nullopt;
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Job = std::shared_ptr<const RunJob>;

  SimulationTask Make(const Job& job, const WagonState& start, double duration) const {
    SimulationTask task{
        .wagon = job->bench.wagon, .V = job->setup.speed, .start = start, .options = options_, .on_end = nullptr};
    task.options.duration = duration;
    task.options.on_progress = [job](double) { return job->bench.go_on(); };
    return task;
  }

  SimulationTask ToSettle(const Job& job, const WagonState& start) {
    SimulationTask task = Make(job, start, settle_);
    task.on_end = [this, job](const SimulationResult& result) {
      if (result.end == SimulationEnd::kDuration) {
        settled_.push_back(ToRun(job, result.state, result.wall_s));
      } else {
        source_.Finish(*job, Conclude(result, " while settling"), result.wall_s);
      }
    };
    return task;
  }

  SimulationTask ToRun(const Job& job, const WagonState& start, double settled_s) {
    SimulationTask task = Make(job, start, options_.duration);
    task.on_end = [this, job, settled_s](const SimulationResult& result) {
      source_.Finish(*job, Conclude(result, ""), settled_s + result.wall_s);
    };
    return task;
  }

  RunSource& source_;
  double settle_;
  const SimulationOptions& options_;
  std::deque<SimulationTask> settled_;
};

class SimulateKind : public RunKind {
 public:
  SimulateKind(double settle, const SimulationOptions& options) : settle_(settle), options_(options) {}

  const std::string& name() const override {
    static const std::string name = "simulate";
    return name;
  }
  const std::vector<ResultColumn>& columns() const override {
    static const std::vector<ResultColumn> columns = MakeColumns();
    return columns;
  }
  std::string Identity() const override {
    return fmt::format("kind=simulate duration={} settle={} window={} tolerance={} wheel_lift={}", options_.duration,
                       settle_, options_.window, options_.integrator.tolerance,
                       options_.end_at_wheel_lift ? "end" : "go-on");
  }
  int side_by_side() const override { return static_cast<int>(kSideBySide); }

  /// Also a run that is alone goes through the lanes, which make other last digits than Simulate().
  void Work(RunSource& source) const override {
    Runs runs(source, settle_, options_);
    SimulateSideBySide([&runs] { return runs.Next(); });
  }

 private:
  double settle_;  // [s]
  SimulationOptions options_;
};

}  // namespace

std::shared_ptr<const RunKind> ReadSimulateKind(Table* run) {
  const Range time{.unit = "s", .low = 1e-3, .high = 1e7};
  SimulationOptions options;
  options.duration = run->Number("duration", time);
  options.window = run->OptionalNumber("window", time).value_or(std::min(options.window, options.duration));
  const double settle = run->OptionalNumber("settle", {.unit = "s", .low = 0, .high = 1e7}).value_or(0);
  options.integrator.tolerance =
      run->OptionalNumber("tolerance", {.unit = "-", .low = 1e-12, .high = 0.1}).value_or(options.integrator.tolerance);
  const std::string lift = run->OptionalString("wheel_lift").value_or("end");
  if (lift != "end" && lift != "go-on")
    run->Report("wheel_lift", "wheel_lift = \"end\" or \"go-on\"", "\"" + lift + "\"");
  options.end_at_wheel_lift = lift == "end";
  if (options.window > options.duration)
    run->Report("window", fmt::format("window <= duration = {:g} [s]", options.duration),
                fmt::format("{:g}", options.window));
  return std::make_shared<SimulateKind>(settle, options);
}

}  // namespace uiclink
