#include "vehicle/hunting/branch_start.h"

#include <algorithm>

namespace uiclink {

ContinuationOptions MakeContinuationOptions(const DiagramOptions& options) {
  ContinuationOptions continuation;
  continuation.from = options.from;
  continuation.to = options.to;
  continuation.max_points = options.max_points;
  continuation.max_step = options.max_step;
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
