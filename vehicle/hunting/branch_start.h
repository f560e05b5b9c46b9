#pragma once

#include <array>
#include <optional>
#include <span>

#include "vehicle/hunting/diagram.h"

namespace uiclink {

// What diagrams by speed and by other parameters have in common.

/// A wheelset that moves less does not hunt [m] (AttractorOptions::least_motion).
inline constexpr double kLeastHunting = 1e-5;
/// Time that hunting is given to settle before a cycle is looked for [s].
inline constexpr double kGuessSettle = 30;

/// Options of a branch of a diagram but for its scales.
ContinuationOptions MakeContinuationOptions(const DiagramOptions& options);

/// Of all motions, by TrackedMotion [m] or [rad].
std::array<double, kMotionCount> HalfWidthsOf(const Cycle& cycle);

/// Whether a cycle lies on a branch of a diagram, by the branch's own cycle at its value of the parameter, which is
/// corrected from the nearest point: between points that are far apart LiesOn interpolates too coarsely.
bool IsOnABranch(Flow& flow, std::span<const HuntingBranch> branches, const Cycle& cycle,
                 const DiagramOptions& options);

/// The branch that begins at a crossing, from the cycle that decides its type on towards the next larger one; none
/// where no such two cycles were found.
std::optional<Branch> FollowBornBranch(const WagonFamily& family, const HopfPoint& hopf, const DiagramOptions& options,
                                       ContinuationOptions continuation);

}  // namespace uiclink
