#pragma once

#include <string>

#include "identify/track/track.h"

namespace uiclink::track {

/// What was tracked and how well, for a terminal: about ten lines.
std::string FormatTrack(const TrackResult& result);

/// The same with all samples' pictures as JSON, schema "track/1".
std::string FormatTrackJson(const TrackResult& result);

/// Comment lines ("# ...") for the head of the record: what is missing, where and why. Empty where nothing is.
std::string FormatTrackComments(const TrackResult& result);

}  // namespace uiclink::track
