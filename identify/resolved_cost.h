#pragma once

#include <array>
#include <span>

#include "identify/fit_problem.h"

namespace ceres {
class CostFunction;
}

namespace uiclink {

inline constexpr int kLevels = 3;

/// Limits of the logarithms: stiffnesses between 1e-3 and 1e4 1/m, friction between 1e-7 and 1 of the load. A thousand
/// times beyond every link; they only keep a fit without information from running away.
inline constexpr std::array<double, kLevels> kLowest = {-6.9, -6.9, -16.1};
inline constexpr std::array<double, kLevels> kHighest = {9.2, 9.2, 0.0};
/// A slider of less than exp(-12) of the largest is not there.
inline constexpr double kWidestShape = 12;

/// Walls at critical displacements below what the record resolves and above its first amplitude; nothing between them.
/// Blocks: levels, and the shape where there is one.
/// @param smallest, largest  [m]; 0 for no wall on that side.
ceres::CostFunction* MakeResolvedCost(int sliders, double smallest, double largest);

/// The record that resolves most, among those that have one link.
FitData WidestLimits(std::span<const FitData> data);

}  // namespace uiclink
