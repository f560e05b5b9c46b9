#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "vehicle/simulation.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// A run among others.
struct SimulationTask {
  std::shared_ptr<const Wagon> wagon;
  double V = 0;  ///< [m/s]
  WagonState start;
  SimulationOptions options;
  /// Given the result, once. May be null; what it throws ends all.
  std::function<void(SimulationResult)> on_end;
};

/// How many runs share the lanes of a thread.
inline constexpr std::size_t kSideBySide = 4;

/// Runs wagons side by side in the lanes of the processor (FourIntegrators): for sweeps, more runs a second and core
/// than Simulate() makes one after the other (tests/bench). A run that ends leaves its lane to the next one.
///
/// Results are those of Simulate() up to the integration's tolerance. They depend on the task alone, bit by bit: not on
/// what runs beside it, nor on the lane. Runs that cannot have a lane (another Runge-Kutta pair, Penetration::kPrinted)
/// are done by Simulate() meanwhile. A run that cannot begin or that the solver gives up ends with
/// SimulationEnd::kFailed and the reason. SimulationResult::wall_s is the run's share of the time.
///
/// @param next  asked when a lane is free, and while others run now and then again. Ends when there is none and nothing
/// runs.  What it gives together need not fit: springs of another kind wait until the lanes are free.
void SimulateSideBySide(const std::function<std::optional<SimulationTask>()>& next);

/// All of them; results in their order.
std::vector<SimulationResult> SimulateSideBySide(const std::vector<SimulationTask>& tasks);

}  // namespace uiclink
