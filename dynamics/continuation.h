#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/cycle.h"

namespace uiclink {

/// Places of a branch where something changes.
enum class BranchEventKind {
  kFold,            ///< the branch turns round in the parameter (saddle-node of cycles)
  kPeriodDoubling,  ///< a multiplier passes -1
  kTorus,           ///< a pair of multipliers passes the unit circle
  kBranchPoint,     ///< a multiplier passes +1 although the branch does not turn round (symmetry breaking, crossing)
  kCharacter,       ///< Passage::character changes: a joint begins to slip, a guidance is met
};

struct BranchEvent {
  BranchEventKind kind = BranchEventKind::kFold;
  double lambda = 0;
  double period = 0;
  std::size_t point = 0;   ///< it lies between this point of the branch and the next
  std::string text;        ///< kCharacter: "slips 4 -> slips 8"; else ""
  bool at_corner = false;  ///< kFold: the direction of the branch jumps, as a joint begins to slip or a stop is met
  Cycle cycle;  ///< the cycle there; kCharacter, corner, or where none was found: the nearest point before it
};

/// Why a branch ends.
enum class BranchEnd {
  kRange,        ///< the parameter left its range
  kPoints,       ///< as many points as were allowed
  kEquilibrium,  ///< the cycle shrank to a point
  kLost,         ///< no cycle was found at the shortest step: `reason` says why
  kClosed,       ///< back where it began
  kStopped,      ///< on_point said so
};

struct Branch {
  std::vector<Cycle> points;  ///< in order along the branch
  std::vector<BranchEvent> events;
  BranchEnd end = BranchEnd::kRange;
  std::string reason;  ///< kLost: what went wrong and where
  /// Why it ends at its first point; none where that is the start.
  std::optional<BranchEnd> begin;
  std::string begin_reason;
  long passages = 0;                   ///< that all of it took
  long passages_with_derivatives = 0;  ///< of these
};

struct ContinuationOptions {
  double from = 0, to = 0;     ///< range of the parameter, from < to
  double parameter_scale = 1;  ///< a change of the parameter that counts as much as one of norm one in the state
  double first_step = 0.1;     ///< along the branch, in the norm of (state, parameter/parameter_scale)
  double min_step = 1e-5;
  double max_step = 1;
  std::size_t max_points = 400;
  int direction = 1;             ///< of the first step: +1 or -1 in the parameter, unless `towards` is given
  double fold_tolerance = 1e-6;  ///< of the parameter at a fold or another event
  /// Smallest norm of (greatest - least of the watched) below which a cycle counts as an equilibrium; in the units of
  /// the watched.
  double least_extent = 0;
  CycleOptions cycle;
  /// Called after every new point; false ends the branch. May be null.
  std::function<bool(const Cycle&)> on_point;
};

/// Follows a cycle through the parameter: pseudo-arclength continuation. Unknown start, period and parameter; tangent
/// from the derivatives of the last point, corrected by Newton's method in the plane across it; step by the number of
/// corrections. Where the memory that is held or slaved changes on the way, the unknowns change with it.
/// Folds are located to fold_tolerance by bisection along the branch with full correction.
/// @param towards  null: options.direction; else the tangent of the first step lies in the direction of this state.
Branch FollowBranch(Flow& flow, const Cycle& start, const ContinuationOptions& options, const Cycle* towards = nullptr);

/// Both ways from a cycle: one branch, with the start within it.
Branch FollowBothWays(Flow& flow, const Cycle& start, const ContinuationOptions& options);

/// The small cycle of given size that is born where a pair of eigenvalues +- i w crosses at lambda0.
///   start = equilibrium + size Re(shape),  unknown start, period and parameter, with
///   Re(shape) . (start - equilibrium) = size |Re(shape)|^2  and  Im(shape) . (start - equilibrium) = 0  (in the norm).
/// @param shape  of the mode x = Re(shape e^(i w t)), padded with zeros for memory.
/// @return the cycle; its lambda - lambda0 says on which side it is born: with the side on which the equilibrium is
///         unstable the bifurcation is supercritical.
/// @throws CycleError as FindCycle.
Cycle FindBornCycle(Flow& flow, double lambda0, double omega, const Eigen::VectorXd& equilibrium,
                    const Eigen::VectorXcd& shape, double size, const CycleOptions& options = {});

}  // namespace uiclink
