#pragma once

#include <vector>

#include "identify/digitise/arc_band.h"
#include "identify/digitise/inks.h"
#include "identify/digitise/profile.h"
#include "identify/digitise/spline.h"
#include "identify/digitise/trace.h"

namespace uiclink::digitise {

/// The curve that, drawn again, gives the picture.
struct LineFit {
  UniformSpline curve;             ///< row over column [px]
  std::vector<double> deviation;   ///< of each coefficient, see Deviation()
  std::vector<double> covariance;  ///< of the coefficients inside the band, row by row [px^2]
  std::size_t band = 0;
  Profile profile;
  std::vector<ArcStep> arc;
  double rms = 0;       ///< of drawn less seen share, where the line is [-]
  double outliers = 0;  ///< part of the pixels there that differ by more than 0.4
  double floor = 0;     ///< standard deviation across the line that is added to the fit's own [px]

  /// Standard deviation of the row at column x [px]: noise as the pixels show it, and `floor` across the line.
  double Deviation(double x) const;
};

/// Fits a cubic spline y(x) to the picture itself: the line is drawn with its width and blur, and least squares moves
/// the spline's coefficients until drawn and seen shares of ink agree (Gauss-Newton; robust weights; pixels that say
/// nothing do not count). Steep parts and needle-like turns, where two branches of the line merge, need no special
/// care, since every pixel is compared, not one value a column.
/// @param start    row at each column from inks.x0 to inks.x1
/// @param spacing  of the knots [px]
LineFit FitLine(const InkLayer& layer, const Inks& inks, const Trace& trace, const std::vector<double>& start,
                double spacing);

/// Distance of each pixel from the curve where that is below `reach`; else `reach`.
Plane DistanceFromCurve(const LineFit& fit, int width, int height, double reach);

}  // namespace uiclink::digitise
