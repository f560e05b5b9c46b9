#pragma once

#include <array>
#include <cstddef>

#include "vehicle/four_wagons.h"

namespace uiclink {

/// Stages of Zonneveld's pair 4(3), first same as last: the fifth serves the embedded solution alone, the sixth is the
/// rate at the end of the step.
inline constexpr std::size_t kFourStages = 6;
using FourStages = std::array<FourStates, kFourStages>;

/// to = x + h sum_j a_j k_j: where stage number `stage` (1 to 5) is evaluated. h: step sizes by lane [s].
void CombineStages(const FourStates& x, const FourStages& k, std::size_t stage, const Lanes& h, FourStates* to);
/// Errors of the steps: root mean square of what the embedded solution differs by, times the weights.
void CalcErrors(const FourStages& k, const FourStates& weights, const Lanes& h, Lanes* errors);
/// to = from in the lanes where share is 1, not where it is 0.
void CopyLanes(const Lanes& share, const FourStates& from, FourStates* to);

/// A coarse look at the guards of four wagons: whose least value is above zero has no event.
struct FourGuards {
  struct Bounds {
    std::array<Lanes, kCorners> lower, upper, travel;  ///< LinkState
  };
  Bounds longitudinal, lateral;
  // +1 or -1: the side of a guard; 0 where the wagon has none.
  std::array<Lanes, kCorners> longitudinal_stop, lateral_stop, stage, leaf;
  std::array<Lanes, kCorners> leaf_rest;
  Lanes longitudinal_clearance, lateral_clearance, stage_compression, track;
};
void CalcLeastGuards(const FourWagons& four, const FourGuards& guards, const FourStates& x, Lanes* least);

}  // namespace uiclink
