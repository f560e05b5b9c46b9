#include "vehicle/hunting/branch_start.h"

#include <algorithm>
#include <cmath>
#include <exception>

namespace uiclink {
namespace {

/// Amplitudes of the nearest point of a branch that differ by so many times the share that makes motions the same: the
/// branch is corrected there, to see.
constexpr double kWorthALook = 5;

bool IsOnBranch(Flow& flow, const Branch& branch, const Cycle& cycle, const DiagramOptions& options) {
  CycleOptions at_value;
  at_value.tolerance = options.tolerance;
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
    const Cycle &a = branch.points[i], &b = branch.points[i + 1];
    if ((cycle.lambda - a.lambda) * (cycle.lambda - b.lambda) > 0) continue;
    const Cycle& nearest = std::abs(cycle.lambda - a.lambda) < std::abs(cycle.lambda - b.lambda) ? a : b;
    if (!MovesAlike(HalfWidthsOf(nearest), HalfWidthsOf(cycle), kWorthALook * options.same_share, options.same_motion))
      continue;
    try {
      const Cycle there = FindCycle(flow, cycle.lambda, nearest.state, nearest.period, at_value);
      if (MovesAlike(HalfWidthsOf(there), HalfWidthsOf(cycle), options.same_share, options.same_motion)) return true;
    } catch (const std::exception&) {  // no cycle near that point at this value
    }
  }
  return false;
}

}  // namespace

ContinuationOptions MakeContinuationOptions(const DiagramOptions& options) {
  ContinuationOptions continuation;
  continuation.from = options.from;
  continuation.to = options.to;
  continuation.max_points = options.max_points;
  continuation.max_step = options.max_step;
  continuation.min_step = 1e-4;  // twenty times what a cycle closes to: corners are turned at this distance
  continuation.first_step = 0.02;
  continuation.cycle.tolerance = options.tolerance;
  continuation.least_extent = kLeastHunting;
  return continuation;
}

std::array<double, kMotionCount> HalfWidthsOf(const Cycle& cycle) {
  std::array<double, kMotionCount> half_width;
  for (std::size_t i = 0; i < kMotionCount; ++i) half_width[i] = cycle.Amplitude(static_cast<int>(i));
  return half_width;
}

bool IsOnABranch(Flow& flow, std::span<const HuntingBranch> branches, const Cycle& cycle,
                 const DiagramOptions& options) {
  return std::ranges::any_of(
      branches, [&](const HuntingBranch& hunting) { return IsOnBranch(flow, hunting.branch, cycle, options); });
}

std::optional<Branch> FollowBornBranch(const WagonFamily& family, const HopfPoint& hopf, const DiagramOptions& options,
                                       ContinuationOptions continuation) {
  const auto larger =
      std::ranges::find_if(hopf.born, [&](const BornCycle& born) { return born.size > options.hopf.type_size; });
  const auto first = std::ranges::find(hopf.born, options.hopf.type_size, &BornCycle::size);
  if (first == hopf.born.end() || larger == hopf.born.end()) return std::nullopt;
  WagonFlow flow(family, hopf.crossing.V, options.flow);
  // The closure of the small cycle is finer than the branch asks for.
  continuation.first_step = 0.5 * (larger->size - first->size) / options.flow.unit;
  return FollowBranch(flow, first->cycle, continuation, &larger->cycle);
}

}  // namespace uiclink
