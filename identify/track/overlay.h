#pragma once

#include <filesystem>

#include "identify/track/track.h"

namespace uiclink::track {

/// Writes a picture of what was read: the film's first picture with the patch, its way, the axis and the background
/// patches that were used (or were unsteady), and below it the record over time with its gaps.
/// @param file  PNG, JPEG, ... by its ending.
/// @throws InputError when it cannot be written.
void WriteOverlay(const TrackResult& result, const std::filesystem::path& file);

}  // namespace uiclink::track
