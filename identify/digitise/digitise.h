#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "identify/digitise/page.h"

namespace uiclink::digitise {

struct DigitiseOptions {
  std::optional<AxisRange> time;              ///< values at the left and right side of the frame [s]
  std::optional<AxisRange> displacement;      ///< at its bottom and top [unit of the record]
  std::vector<CalibrationPoint> points = {};  ///< instead of a frame
  std::string curve = {};                     ///< colour (name or #rrggbb) or number of the curve; empty: the only one
  double rate_hz = 0;                         ///< of the samples; 0: chosen so that nothing is lost
};

/// A curve that was read, and what speaks for it.
struct Digitised {
  std::vector<double> t;            ///< [s], multiples of 1/rate; stretches that could not be read are left out
  std::vector<double> y;            ///< displacement [unit of the record]
  std::vector<double> uncertainty;  ///< standard deviation of each y; grows in dashes and under other lines
  double rate_hz = 0;

  std::string colour;  ///< "blue (#1f77b4)"
  double line_width_px = 0, blur_px = 0;
  double y_per_px = 0;          ///< unit of the record per row
  double s_per_px = 0;          ///< per column
  double frame_closure_px = 0;  ///< scatter of the frame's sides, or of calibration points about their scale
  double tilt_deg = 0, bow_px = 0;
  double columns_read = 0;   ///< part of the columns between first and last sample in which the line was seen
  double ink_explained = 0;  ///< part of the ink of that colour that lies on the line read or in small print
  double line_found = 0;     ///< part of the line read (dashes aside) under which there is ink
  double rms_share = 0;      ///< rms of drawn less seen ink where the line is [-]
  double outliers = 0;       ///< part of those pixels that differ by more than 0.4
  double bridged_px = 0;     ///< longest stretch along the line that was interpolated
  std::vector<std::pair<double, double>> gaps;  ///< left out, from and to [s]
  std::vector<std::string> notes;               ///< what a user should know
  std::vector<std::string> warnings;            ///< why the record should not be trusted as it stands
  std::vector<std::pair<Pixel, bool>> trail;    ///< the curve in the picture's own pixels; true: seen, false: bridged
  std::array<Pixel, 4> frame{};                 ///< corners in the picture; all zero with calibration points
  std::vector<Pixel> outline;  ///< of the frame in the picture, closed, with its bow; empty with points
};

/// Reads the displacement over time that a picture shows.
///
/// Frame or points give the axes (page.h), the colours of the ink the curves (inks.h); the curve is traced column by
/// column (trace.h) and then fitted to the pixels themselves (line_fit.h). What comes out is checked against the
/// picture before it is given: all ink of that colour must be explained, there must be ink all along the curve, and
/// what is drawn again must look like what is seen.
/// @throws InputError naming `name` when frame or curve are missing or ambiguous, the curve is cut off by the frame,
/// its
///         swings are not resolved, or a check fails.
Digitised Digitise(const Picture& picture, const std::string& name, const DigitiseOptions& options);

/// The picture with what was read drawn over it: frame, curve, and bridged parts in another colour.
Picture DrawOverlay(const Picture& picture, const Digitised& read);

}  // namespace uiclink::digitise
