#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "identify/track/image.h"

namespace uiclink::track {

/// Something that swings.
struct MovingRegion {
  Box box;           ///< in the first picture
  double swing = 0;  ///< half of its way along its axis, from one end to the other [pixel]
  int patches = 0;   ///< that move together
};

/// The region that swings most in the first seconds of a film: small patches of texture are looked for in picture
/// after picture, reduced to 320 pixels, and those that move together are one region. Reads on until the strongest has
/// turned kTurns times, at most kLongest.
///
/// @param progress  called with the number of pictures read.
/// @throws InputError when nothing swings, or a second region swings as far but otherwise ("two candidates").
MovingRegion FindMovingRegion(const std::filesystem::path& film, const std::function<void(int)>& progress = {});

inline constexpr int kTurns = 3;               ///< reversals of the motion that make an oscillation
inline constexpr int kLongest = 1500;          ///< pictures that are read in search of them
inline constexpr double kSmallestSwing = 2;    ///< of a region that counts [pixel]
inline constexpr double kEquallyStrong = 0.7;  ///< of the strongest region's swing: a rival

}  // namespace uiclink::track
