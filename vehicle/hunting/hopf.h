#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dynamics/cycle.h"
#include "vehicle/hunting/wagon_flow.h"
#include "vehicle/stability.h"

namespace uiclink {

/// On which side of the crossing its small cycles live.
enum class HopfType {
  kSupercritical,  ///< where the equilibrium is unstable: hunting sets in gently
  kSubcritical,    ///< where it is stable: an unstable cycle stands around it, hunting sets in with a jump
};
const char* HopfTypeName(HopfType type);  ///< "supercritical", "subcritical"

/// A small cycle near a crossing.
struct BornCycle {
  double size = 0;   ///< largest displacement of the motion [m] or [rad], of the body as a rule
  double speed = 0;  ///< at which it lives [m/s], or value of the family's parameter
  Cycle cycle;
};

struct HopfOptions {
  /// Sizes that are looked at [m]. A contact table is made of cubics 10 um long, so that the smallest ones see its
  /// pieces rather than the profiles.
  std::vector<double> sizes = {1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3};
  double type_size = 1e-4;  ///< the cycle of this size decides the type [m]
  WagonFlowOptions flow;
};

/// A pair of eigenvalues that crosses the imaginary axis, and what is born there.
struct HopfPoint {
  Crossing crossing;
  std::vector<BornCycle> born;   ///< by size
  std::optional<HopfType> type;  ///< of the cycle of type_size; none where none was found
  /// Largest size below type_size whose cycle lives on the other side [m]: the type holds above it only.
  std::optional<double> other_below;
  std::string reason;  ///< why there is no type
};

/// The cycles born at a crossing, found as solutions of the boundary-value problem, not by waiting for them to grow:
/// FindBornCycle (dynamics/continuation.h) about the running equilibrium there, all joints stuck.
/// @throws what FindEquilibrium throws; a cycle that is not found is left out.
HopfPoint ExamineHopf(const Wagon& wagon, const Crossing& crossing, const HopfOptions& options = {});
/// The same by another parameter than the speed; `crossing` of FindCrossings by that.
HopfPoint ExamineHopf(const WagonFamily& family, const Crossing& crossing, const HopfOptions& options = {});

}  // namespace uiclink
