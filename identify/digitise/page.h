#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/digitise/frame.h"
#include "identify/digitise/picture.h"

namespace uiclink::digitise {

/// Values at the two ends of an axis: left and right, or bottom and top.
struct AxisRange {
  double low = 0;
  double high = 0;
};

/// A place in the picture whose values are known; one of the two may be missing.
struct CalibrationPoint {
  Pixel pixel;
  std::optional<double> t;  ///< [s]
  std::optional<double> y;  ///< in the record's unit
};

/// The plot upright: time runs along the rows, displacement up the columns, both linearly.
struct Page {
  Picture picture;
  double left = 0, right = 0, top = 0, bottom = 0;  ///< of the area to read: the frame's centre lines, or all [px]
  double border = 0;                                ///< width of the frame's lines, 0 without a frame [px]
  double t0 = 0, t_per_px = 1;                      ///< time [s] = t0 + t_per_px x
  double y0 = 0, y_per_px = -1;                     ///< displacement = y0 + y_per_px y
  bool resampled = false;                           ///< turned, or its perspective removed
  double scale_residual = 0;                        ///< frame: its closure; points: rms distance of the fit [px]
  double bow = 0;                                   ///< largest bow of a frame's side [px]
  double tilt = 0;                                  ///< of the top or the first axis in the picture [rad]
  std::function<Pixel(Pixel)> to_picture;           ///< place in the picture that was given

  double T(double x) const { return t0 + t_per_px * x; }
  double Y(double y) const { return y0 + y_per_px * y; }
};

/// The inside of a frame: its four corners become a rectangle (homography); the bow of its sides is spread over the
/// inside (Coons). An upright, straight frame is cut out as it is, without resampling.
/// @throws InputError when a side bows by more than 4 % of the frame, or the ranges are none.
Page MakePage(const Picture& picture, const Frame& frame, const AxisRange& x, const AxisRange& y,
              const std::string& name);

/// The picture with axes from points: two per axis give upright axes, three or more that are not in a line any affine
/// map, more of them by least squares.
/// @throws InputError when they are too few, coincide, or fit worse than 1.5 px rms.
Page MakePage(const Picture& picture, const std::vector<CalibrationPoint>& points, const std::string& name);

}  // namespace uiclink::digitise
