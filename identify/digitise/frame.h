#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "identify/digitise/picture.h"

namespace uiclink::digitise {

/// A side of the frame as it lies in the picture: across = c0 + c1 u + c2 u^2 + c3 u^3, u = (along - middle) / half.
struct FrameSide {
  bool upright = false;  ///< along is y and across is x; else along is x
  double middle = 0;     ///< [px]
  double half = 1;       ///< [px]
  std::array<double, 4> c{};
  double rms = 0;         ///< of the line's measured centre about this curve [px]
  double line_width = 0;  ///< [px]

  double Across(double along) const;
};

/// The closed box that the axes draw.
struct Frame {
  std::array<FrameSide, 4> sides;  ///< top, right, bottom, left
  std::array<Pixel, 4> corners;    ///< top left, top right, bottom right, bottom left: where the sides' centres meet
  double closure = 0;              ///< largest rms of a side [px]
  double line_width = 0;           ///< widest of the sides [px]
};

/// Finds the frame on light paper: four straight (or slightly bowed) unbroken lines, within 8 degrees of upright and
/// level, that meet in four corners and end there, but for tick marks. Of frames inside each other the inner one counts
/// (the outer one is the border of the picture) unless it is below a quarter of the outer one's area (a legend's box).
///
/// Each side's centre is measured every few pixels and fitted by a cubic, robust against tick marks and crossing lines.
/// @throws InputError (file `name`) when there is none, or two beside each other.
Frame FindFrame(const Picture& picture, const std::string& name);

}  // namespace uiclink::digitise
