#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/track/camera.h"
#include "identify/track/follower.h"
#include "identify/track/image.h"
#include "identify/track/times.h"

namespace uiclink::track {

/// Direction in the picture that becomes the displacement: positive to the right, or upwards.
enum class Axis {
  kX,
  kY,
  kPrincipal,  ///< of the largest motion; positive to the right, or upwards where it is steeper than 45 degrees
};

struct TrackOptions {
  std::optional<Box> roi = {};        ///< patch of the first picture; else a tag, else the region that swings most
  bool tag = false;                   ///< follow an ArUco or AprilTag marker
  std::optional<int> tag_id = {};     ///< which; else the one that swings most
  std::optional<double> tag_mm = {};  ///< side of its black square [mm], > 0: the scale
  std::optional<double> mm_per_pixel = {};  ///< scale, > 0, unless tag_mm says it
  std::optional<Box> background = {};       ///< where the first picture shows something that stands still
  bool no_background = false;               ///< the camera is known to stand still
  Axis axis = Axis::kPrincipal;
  std::optional<double> rate_hz = {};  ///< pictures a second, > 0; replaces the container's time stamps
  std::function<void(const std::string& what, int done, int of)> progress = {};
};

/// A picture without a sample.
struct LeftOutPicture {
  std::size_t picture = 0;  ///< 0 = first
  LeftOut why = LeftOut::kNot;
};

/// A record from a film, and what is known about how it was read.
struct TrackResult {
  std::string file;
  int width = 0, height = 0;  ///< of the pictures [pixel]
  std::size_t pictures = 0;   ///< of the film

  std::vector<double> t;             ///< [s]
  std::vector<double> y;             ///< displacement from the first picture [m]
  std::vector<double> uncertainty;   ///< standard deviation of y [m]: noise of patch and background, not the scale's
  std::vector<std::size_t> picture;  ///< that a sample belongs to
  std::vector<Point> places;         ///< of the patch as seen, for the overlay [pixel]

  Box roi;                        ///< of the patch in the first picture
  std::optional<int> tag_id;      ///< where a tag was followed
  double mm_per_pixel = 0;        ///< along the axis
  double scale_error = 0;         ///< standard deviation of mm_per_pixel over itself, where a tag gave it [-]
  Point axis{1, 0};               ///< unit vector in the picture
  double cross_share = 0;         ///< rms across the axis over rms along it [-]
  double median_score = 0;        ///< correlation with the reference [-]
  std::optional<double> shutter;  ///< share of the time that it is open, as the patch's blur shows it
  double shutter_loss = 0;        ///< of amplitude by the shutter [-], see TrackFilm; at most, where `shutter` is empty
  CameraMotion camera;
  PictureTimes times;
  std::vector<LeftOutPicture> left_out;
  int missing = 0;  ///< pictures that are missing: by the time stamps, and by jumps of the motion

  std::vector<std::string> notices;   ///< what was assumed
  std::vector<std::string> warnings;  ///< what makes the record less trustworthy, or shorter

  double FramePixels(double metres) const { return 1e3 * metres / mm_per_pixel; }
};

/// Follows a patch through a film.
///
/// The reference is the patch in the first picture, throughout (see PatchTracker), so there is no drift. The camera's
/// motion is taken off by still background (see FitCamera). Each sample carries its standard deviation, from the very
/// picture's residual. Pictures that give no trustworthy sample are left out, never interpolated.
///
/// A shutter that is open for a time tau averages the motion: at angular frequency w the amplitude is multiplied by
/// sin(w tau / 2) / (w tau / 2). A film does not say its tau; the blur of fast pictures does, to a quarter of a step,
/// and it is at most one step. `shutter_loss` is the loss for that; it is said, not taken off. At 1 Hz and 50 pictures
/// a second it is at most 0.07 %; k and k_i do not depend on it, T0 does.
///
/// @throws InputError when the film cannot be read, the patch or scale cannot be found, or hardly any picture gives a
///         sample. @throws std::invalid_argument when an option is out of range.
TrackResult TrackFilm(const std::filesystem::path& film, const TrackOptions& options);

}  // namespace uiclink::track
