#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "identify/track/tag.h"
#include "identify/track/track.h"

namespace uiclink::track {

/// A patch that may be the target: what the user says, a tag, or the region that swings most.
struct Target {
  Box box;
  std::optional<Tag> tag;
};

/// The candidates in the first picture: one, or all tags where the user did not say which.
/// @throws InputError where there is none.
std::vector<Target> FindTargets(const std::filesystem::path& film, const GrayView& first, const TrackOptions& options);

}  // namespace uiclink::track
