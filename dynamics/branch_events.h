#pragma once

#include <vector>

#include "dynamics/branch_point.h"

namespace uiclink {

/// What changes between two neighbouring points of a branch, located to options.fold_tolerance of the parameter where
/// the branch can be corrected on the way.
/// @param distance  of the step from a to b
/// @param index     of a in the branch
std::vector<BranchEvent> FindEvents(BranchStepper* stepper, const BranchPoint& a, const BranchPoint& b, double distance,
                                    std::size_t index, const ContinuationOptions& options);

}  // namespace uiclink
