#pragma once

#include <optional>

#include "dynamics/branch_point.h"

namespace uiclink {

/// A branch round a corner: where a joint begins to slip or a stop is met, the flow's derivative jumps, and with it the
/// direction of the branch, by any angle. What lies ahead along the tangent is then no cycle, however short the step.
struct Corner {
  BranchPoint beyond;   ///< the first point behind it; its tangent leads away from it
  double distance = 0;  ///< from it to `beyond`, in the norm
  double lambda = 0;    ///< where the two tangents come closest to each other
  double period = 0;
};

/// The other side of the corner just ahead of a point. The flow's derivative on the other side is that of a passage
/// begun a little beyond the corner; the kernel of its equations is the direction of the branch there. Of the points to
/// both sides in that direction, that one counts which does not lie on the branch behind `here`, and whose tangent
/// leads back to where the tangent of `here` leads.
/// @param reach  how far beyond the corner the first passage is begun; farther ones up to `most`.
/// @return nothing where there is no such point.
std::optional<Corner> TurnCorner(Flow& flow, BranchStepper* stepper, const BranchPoint& here, double reach,
                                 double most);

}  // namespace uiclink
