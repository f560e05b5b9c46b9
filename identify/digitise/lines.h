#pragma once

#include <vector>

#include "identify/digitise/picture.h"

namespace uiclink::digitise {

/// A long unbroken line, nearly level and nearly straight, for x from `first` to `last` [px]:
/// y = at + slope (x - middle) + bow (x - middle)^2.
struct LongLine {
  double middle = 0;  ///< of the picture
  double at = 0;
  double slope = 0;
  double bow = 0;
  double first = 0;
  double last = 0;

  double Y(double x) const { return at + (slope + bow * (x - middle)) * (x - middle); }
  double Length() const { return last - first; }
};

/// Darkness of thin dark lines above their surroundings, 0 to 255: what a closing fills. Broad dark areas and slow
/// changes of the light count nothing.
Plane LineDarkness(const Picture& picture);

/// Rows and columns exchanged.
Plane Transposed(const Plane& plane);

/// Nearly level lines (within 8 degrees) that are unbroken over at least a quarter of the plane's width.
/// @param threshold  darkness from which a pixel counts as ink
std::vector<LongLine> FindLevelLines(const Plane& darkness, double threshold);

}  // namespace uiclink::digitise
