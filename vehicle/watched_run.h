#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "vehicle/motion_record.h"
#include "vehicle/moving_wagon.h"
#include "vehicle/simulation.h"

namespace uiclink {

/// @throws std::invalid_argument for options out of range.
void CheckOptions(const SimulationOptions& options);

/// Calls on_progress about ten times per second, and looks at the clock only now and then.
class ProgressCalls {
 public:
  explicit ProgressCalls(const std::function<bool(double)>& report) : report_(report) {}
  /// False when the run is to stop.
  bool Report(double t);

 private:
  using Clock = std::chrono::steady_clock;
  const std::function<bool(double)>& report_;
  long steps_ = 0;
  Clock::time_point next_ = Clock::now();
};

/// A run that somebody else makes the steps of: what is watched after each, where it ends, and what comes out.
class WatchedRun {
 public:
  /// @param wagon  has just been started.
  /// @param options  checked; must outlive this, as the wagon must.
  WatchedRun(MovingWagon& wagon, const SimulationOptions& options);

  /// Steps must not go further [s].
  double stop_time() const { return std::min(checkpoint_, end_); }
  /// After every step.
  void AfterStep(Advance advance);
  bool ended() const { return ended_; }
  void End(SimulationEnd end, std::string reason);
  /// Once it has ended. Counts and wall time are left to the caller.
  SimulationResult Finish();

 private:
  double FindNextCheckpoint(double t) const;
  void PassStopTime(double t);
  void EndDerailed();
  void WatchLoads();
  void EndAtLift();
  void Sample();

  MovingWagon& wagon_;
  const SimulationOptions& options_;
  double start_, end_;
  MotionRecord record_;
  ProgressCalls progress_;
  SimulationResult result_;
  double checkpoint_ = 0;
  std::size_t sample_count_ = 0, next_sample_ = 0;
  bool first_look_ = true;
  bool ended_ = false, lift_ = false, reported_end_ = false;
};

}  // namespace uiclink
