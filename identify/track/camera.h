#pragma once

#include <optional>
#include <vector>

#include "identify/track/follower.h"
#include "identify/track/image.h"

namespace uiclink::track {

/// One background patch through all pictures.
struct BackgroundTrack {
  Box box;
  std::vector<Sighting> sightings;  ///< one a picture
};

/// What the camera does, as told by the still background.
enum class CameraModel {
  kUnknown,       ///< there is no background to tell it by
  kStill,         ///< what it does cannot be told from nothing: nothing is taken off
  kShift,         ///< shifts along x and y
  kShiftAndTurn,  ///< and turns about its axis
};

/// "unknown", "still", "shift", "shift and turn".
const char* Name(CameraModel model);

/// The camera's motion in one picture: the background's place there is  c + shift + R(turn) (its place - c).
struct CameraPose {
  Point shift;      ///< [pixel]
  double turn = 0;  ///< [rad]
  PlaceCovariance shift_covariance;
  double turn_variance = 0;
};

/// The camera's motion against the reference picture.
class CameraMotion {
 public:
  CameraModel model = CameraModel::kUnknown;
  std::vector<Box> used;                         ///< background patches that stand still
  std::vector<Box> unsteady;                     ///< that do not, or that were lost
  std::vector<std::optional<CameraPose>> poses;  ///< one a picture, unless kUnknown; empty: no background seen
  double shift_rms = 0;                          ///< of the camera, about its mean [pixel]
  double turn_rms = 0;                           ///< [rad]
  double disagreement = 0;                       ///< rms of what the patches move against each other [pixel]
  Point centre;                                  ///< c, of the patches

  /// The place in the reference picture of what is seen at `place`; the camera's share is added to `covariance`.
  /// Empty where the camera's motion in that picture is not known.
  std::optional<Point> ToReference(std::size_t picture, Point place, PlaceCovariance* covariance) const;
};

/// Finds the camera's motion from background patches, of which some may move, be covered or be lost. The quietest ones
/// that move as one stiff plane count as still. Rotation and shift are kept where they are more than the patches'
/// disagreement explains: a still camera's record gets no noise from the background.
///
/// @param target_rms  of the target's motion [pixel]: a background that moves a quarter as far is none.
/// @param lever       typical place of the target.
CameraMotion FitCamera(const std::vector<BackgroundTrack>& tracks, double target_rms, Point lever);

}  // namespace uiclink::track
