#pragma once

#include <optional>
#include <string>
#include <vector>

namespace uiclink::track {

/// Pictures are missing between two that follow each other in the film.
struct Gap {
  std::size_t before = 0;       ///< index of the last picture before the gap
  std::optional<int> pictures;  ///< missing; empty where the rate varies, so that nobody can say
};

/// When the pictures of a film were taken.
struct PictureTimes {
  std::vector<std::optional<double>> t;  ///< [s], increasing; empty: no time stamp, or one that runs backwards
  bool even = true;                      ///< whole numbers of `step`, but for the rounding of the container
  double step = 0;                       ///< [s]; median where not even
  double resolution = 0;                 ///< of the container's time stamps [s]; 0: not coarse
  std::vector<Gap> gaps;
  int backwards = 0;                 ///< pictures whose time stamp does not follow the one before
  int continued = 0;                 ///< last pictures without a time stamp, put on the even grid
  std::vector<std::string> notices;  ///< what was assumed
};

/// Judges the time stamps of a container. Stamps that are whole multiples of one step within their rounding are put on
/// that grid: a time that is rounded to 1 ms is an error of 1 mm at 1 m/s. What is missing on the grid is a gap. Other
/// stamps are taken as they are (variable rate); there a step of more than three medians is a gap.
///
/// @param rate_hz  replaces all stamps by even steps.
/// @throws std::invalid_argument when there are fewer than two pictures.
PictureTimes JudgeTimes(const std::vector<std::optional<double>>& stamps, std::optional<double> rate_hz);

}  // namespace uiclink::track
