#pragma once

#include <optional>
#include <vector>

#include "identify/track/image.h"

namespace uiclink::track {

/// Patches of the reference picture by which the camera's own motion may be told: strong texture in both directions,
/// far apart from each other, none on the target. Whether they stand still is judged later, from all pictures.
///
/// @param within  where to look; empty: the whole picture.
/// @param avoid   places to keep clear of.
/// @param most    patches.
std::vector<Box> ChooseBackground(const GrayView& reference, const std::optional<Box>& within,
                                  const std::vector<Box>& avoid, int most);

}  // namespace uiclink::track
