#include "vehicle/side_by_side.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <deque>
#include <exception>
#include <string>
#include <utility>

#include "vehicle/four_integrators.h"
#include "vehicle/runge_kutta.h"
#include "vehicle/watched_run.h"

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;
using NextTask = std::function<std::optional<SimulationTask>()>;

static_assert(kSideBySide == FourIntegrators::kWagons);

bool FitsALane(const SimulationTask& task) {
  const std::string& method = task.options.integrator.method;
  return (method.empty() || method == kDefaultMethod) && CanShareLanes(task.wagon->options, task.wagon->options);
}

void Tell(const SimulationTask& task, SimulationResult result) {
  if (task.on_end) task.on_end(std::move(result));
}

SimulationResult MakeFailure(const SimulationTask& task, const std::exception& fault) {
  SimulationResult result;
  result.end = SimulationEnd::kFailed;
  result.end_reason = fault.what();
  result.state = task.start;
  result.V = task.V;
  return result;
}

class SideBySide {
 public:
  explicit SideBySide(const NextTask& next) : next_(next) {
    for (std::size_t i = 0; i < kSideBySide; ++i) slots_[i].mover.emplace(four_, i);
  }

  void Run() {
    constexpr int kAskAgain = 4096;  // steps: some milliseconds
    for (;;) {
      FillLanes();
      if (running_ == 0) return;
      bool ended = false;
      for (int n = 0; n < kAskAgain && !ended; ++n) ended = Step();
    }
  }

 private:
  /// A lane and its run.
  struct Slot {
    std::optional<MovingLane> mover;
    std::optional<SimulationTask> task;
    std::optional<WatchedRun> run;
    IntegratorCounts before;
    double wall_s = 0;
  };

  void FillLanes() {
    for (std::size_t i = 0; i < kSideBySide; ++i) {
      // A run that fails at once leaves its lane to the next.
      while (!slots_[i].run) {
        std::optional<SimulationTask> task = Choose();
        if (!task) return;
        Begin(i, std::move(*task));
      }
    }
  }

  /// The next run that fits beside those that are on their way; the others wait.
  std::optional<SimulationTask> Choose() {
    constexpr std::size_t kMostWaiting = 2 * kSideBySide;
    const auto fit = std::ranges::find_if(waiting_, [this](const SimulationTask& task) { return Fits(task); });
    if (fit != waiting_.end()) {
      SimulationTask task = std::move(*fit);
      waiting_.erase(fit);
      return task;
    }
    while (waiting_.size() < kMostWaiting) {
      std::optional<SimulationTask> task = next_();
      if (!task || (FitsALane(*task) && Fits(*task))) return task;
      if (FitsALane(*task)) {
        waiting_.push_back(std::move(*task));
      } else {
        DoAlone(*task);
      }
    }
    return std::nullopt;
  }

  bool Fits(const SimulationTask& task) const {
    return std::ranges::all_of(slots_, [&](const Slot& slot) {
      return !slot.run || CanShareLanes(task.wagon->options, slot.task->wagon->options);
    });
  }

  void DoAlone(const SimulationTask& task) {
    ShareTime();
    SimulationResult result;
    try {
      result = Simulate(*task.wagon, task.V, task.start, task.options);
    } catch (const std::exception& fault) {
      result = MakeFailure(task, fault);
    }
    shared_ = Clock::now();
    Tell(task, std::move(result));
  }

  void Begin(std::size_t lane, SimulationTask task) {
    ShareTime();
    Slot& slot = slots_[lane];
    slot.task = std::move(task);
    slot.before = four_.counts(lane);
    slot.wall_s = 0;
    try {
      CheckOptions(slot.task->options);
      four_.Start(lane, *slot.task->wagon, slot.task->V, slot.task->start, slot.task->options.integrator);
    } catch (const std::exception& fault) {
      const SimulationTask failed = std::move(*std::exchange(slot.task, std::nullopt));
      return Tell(failed, MakeFailure(failed, fault));
    }
    slot.run.emplace(*slot.mover, slot.task->options);
    stop_[lane] = slot.run->stop_time();
    ++running_;
    if (slot.run->ended()) End(lane);  // a wheel is in the air from the beginning
  }

  /// Whether a run has ended.
  bool Step() {
    const FourIntegrators::Advances advances = four_.Step(stop_);
    bool ended = false;
    for (std::size_t i = 0; i < kSideBySide; ++i) {
      Slot& slot = slots_[i];
      if (!slot.run) continue;
      if (advances[i]) slot.run->AfterStep(*advances[i]);
      if (four_.failed(i)) slot.run->End(SimulationEnd::kFailed, DescribeFailure(i));
      stop_[i] = slot.run->stop_time();
      ended |= slot.run->ended();
    }
    if (!ended) return false;
    for (std::size_t i = 0; i < kSideBySide; ++i)
      if (slots_[i].run && slots_[i].run->ended()) End(i);
    return true;
  }

  std::string DescribeFailure(std::size_t lane) const {
    return "the integration stopped at " + std::to_string(four_.state(lane).t) +
           " s: the error of a step stays too large, however short it is";
  }

  void End(std::size_t lane) {
    ShareTime();
    Slot& slot = slots_[lane];
    SimulationResult result = slot.run->Finish();
    result.counts = four_.counts(lane) - slot.before;
    result.wall_s = slot.wall_s;
    four_.Stop(lane);
    slot.run.reset();
    --running_;
    const SimulationTask task = std::move(*std::exchange(slot.task, std::nullopt));
    Tell(task, std::move(result));
  }

  /// The time since it was shared last belongs to those that run, each as much.
  void ShareTime() {
    const Clock::time_point now = Clock::now();
    const double share = std::chrono::duration<double>(now - shared_).count() / static_cast<double>(running_);
    for (Slot& slot : slots_)
      if (slot.run) slot.wall_s += share;
    shared_ = now;
  }

  const NextTask& next_;
  FourIntegrators four_;
  std::array<Slot, kSideBySide> slots_;
  std::array<double, kSideBySide> stop_{};
  std::deque<SimulationTask> waiting_;
  std::size_t running_ = 0;
  Clock::time_point shared_ = Clock::now();
};

}  // namespace

void SimulateSideBySide(const NextTask& next) { SideBySide(next).Run(); }

std::vector<SimulationResult> SimulateSideBySide(const std::vector<SimulationTask>& tasks) {
  std::vector<SimulationResult> results(tasks.size());
  std::size_t begun = 0;
  SimulateSideBySide([&]() -> std::optional<SimulationTask> {
    if (begun == tasks.size()) return std::nullopt;
    SimulationTask task = tasks[begun];
    task.on_end = [&result = results[begun], tell = std::move(task.on_end)](SimulationResult ended) {
      result = std::move(ended);
      if (tell) tell(result);
    };
    ++begun;
    return task;
  });
  return results;
}

}  // namespace uiclink
