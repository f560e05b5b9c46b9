#pragma once

#include <optional>
#include <string>
#include <vector>

#include "identify/track/tag.h"
#include "identify/track/track.h"

namespace uiclink::track {

/// What one pass over a film has seen; one element a picture.
struct FilmObservations {
  std::string file;
  int width = 0, height = 0;
  Box roi;
  std::optional<int> tag_id;
  std::vector<std::optional<double>> stamps;
  std::vector<Sighting> sightings;
  std::vector<BackgroundTrack> background;
  std::optional<double> shutter;  ///< share of the time that it is open, as the blur shows it
  std::vector<Tag> scale_tags;    ///< some pictures' tags, where they give the scale
};

/// rms of a patch's motion about its mean [pixel].
double CalcMotionRms(const std::vector<Sighting>& sightings);

/// From places in pictures to a record: camera's motion, axis, scale, times, what is left out and what is to be said.
/// @throws InputError as TrackFilm.
TrackResult FinishTrack(const FilmObservations& seen, const TrackOptions& options);

}  // namespace uiclink::track
