#pragma once

#include <optional>
#include <vector>

#include "identify/track/image.h"

namespace uiclink::track {

/// An ArUco or AprilTag marker in a picture.
struct Tag {
  int id = 0;
  std::array<Point, 4> corners;  ///< of its black square, in order around it
};

/// All markers of the known dictionaries (4x4 to 7x7 with 1000 markers each, the original ArUco, AprilTag 36h11); of
/// the first dictionary that has any in the picture.
std::vector<Tag> FindTags(const GrayView& picture);

/// The whole pixels of a tag with a narrow rim, which has the outer edges.
Box TagBox(const Tag& tag, const Box& picture);

/// Length of one millimetre in a tag's plane, from the lengths of its sides.
struct TagScale {
  double mm_per_pixel = 0;  ///< along the axis
  double tilt = 0;          ///< largest difference of two sides over their mean [-]: 0 for a camera that looks straight
};

/// Scale along a direction of the picture from a square of known side: the affine map of the square onto the picture.
TagScale CalcTagScale(const Tag& tag, double side_mm, Point axis);

}  // namespace uiclink::track
