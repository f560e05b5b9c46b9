#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "dynamics/continuation.h"
#include "vehicle/hunting/propagation.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/hunting/wagon_flow.h"

namespace uiclink {

/// Derivatives of the speed of a fold by the parameters of a scatter [m/s per unit of the parameter].
///
/// At a fold the equations  G(z, T, V, p) = end - start = 0  with their phase condition have a left null vector w by
/// (z, T), so that along the fold  w . (G_V dV + G_p dp) = 0:
///   dV/dp = - (w . G_p) / (w . G_V),
/// G_V from the cycle's own derivatives, G_p by central differences of one passage, two passages a parameter. Steps are
/// a thousandth of the parameter (of its standard deviation where it is zero), one-sided at a bound.
/// @param fold  BranchEvent::cycle of a kFold of a branch by speed of `wagon`.
/// @throws std::runtime_error where the speed does not act on the fold, and what WagonFlow::Pass throws.
Eigen::VectorXd CalcFoldGradient(const SetScatter& scatter, const Wagon& wagon, const Cycle& fold,
                                 const WagonFlowOptions& flow = {});

/// What joints remember that no longer slip, when links are changed: a run of the changed wagon finds it, or it stays
/// as it was, so that what is found changes smoothly with the links.
enum class JointMemory { kSettled, kCarried };

/// The same fold of a wagon that is a little different: from a stable cycle beyond it, carried over and corrected, the
/// branch is followed until it turns round, smoothly or at a corner.
/// @param beyond  a stable cycle of the branch, some tenths of a m/s from the fold.
/// @param fold    speed of the fold of the wagon that `beyond` belongs to [m/s].
/// @throws CycleError when the cycle or the fold is not found.
double FindFoldNear(const Wagon& wagon, const Cycle& beyond, double fold, JointMemory memory = JointMemory::kSettled,
                    const WagonFlowOptions& flow = {});

struct FoldBounds {
  ScalarBounds speed;        ///< "nonlinear critical speed"; from draws where there are any, beside first order
  Eigen::VectorXd gradient;  ///< by the parameters of the scatter
  double wall_s = 0;
};

/// Carries the draws of a scatter to the speed of a fold at the lower end of hunting. Without draws to first order
/// only. The gradient is that of CalcFoldGradient; at a corner it is made of central differences of FindFoldNear.
/// @param fold    a kFold.
/// @param branch  that the fold is of: draws begin from one of its stable cycles above the fold (FindFoldNear).
/// @throws CycleError where it has none far enough from the fold; as CalcFoldGradient.
/// They hold the uncertainty of the links' parameters alone, not that of wagon, wheels or rails.
FoldBounds CalcFoldBounds(const SetScatter& scatter, const Wagon& wagon, const BranchEvent& fold,
                          std::span<const Cycle> branch, const PropagateOptions& options = {},
                          const WagonFlowOptions& flow = {});

}  // namespace uiclink
