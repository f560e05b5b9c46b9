#pragma once

#include <memory>
#include <optional>

#include "identify/track/image.h"

namespace uiclink::track {

/// Where a patch was found in a picture.
struct PatchFit {
  Point place = {};                 ///< of the patch's centre
  double angle = 0;                 ///< turned against the reference [rad], from x towards y
  PlaceCovariance covariance = {};  ///< of `place`, from the residual of this very picture
  double gain = 1;                  ///< contrast against the reference [-]
  double score = 0;                 ///< correlation with the reference over all pixels [-], at most 1
  double residual = 0;              ///< rms of what the reference does not explain [grey levels], outliers weighed down
  double inliers = 0;               ///< mean weight of the pixels [-]: 1 where none is an outlier
};

/// A patch of the reference picture, found in others to a small part of a pixel.
///
/// Minimises  sum_i w_i (I(c + R(angle) x_i) - a T(x_i) - b)^2  over place c, angle, contrast a and brightness b by
/// inverse-compositional Gauss-Newton steps (Baker and Matthews, Int. J. Computer Vision 56, 2004): the gradient is
/// the reference's. The reference is never replaced, so nothing adds up from picture to picture. Both pictures are
/// smoothed by a Gaussian of kSmoothing before, so that the cubic interpolation between pixels has hardly any error of
/// its own ("pixel locking"; measured in tests/unit/track). Weights w_i = (1 + (e_i / c)^2)^-2 take out pixels that
/// follow something else, such as a background within the box.
///
/// The covariance is H^-1 (sum_b s_b s_b') H^-1 with s_b the score of a block of 8 x 8 pixels: the Cramer-Rao bound
/// where noise is white, and still right where it is correlated within blocks, as after compression. To it comes the
/// error of the interpolation, 0.004 pixel. It holds the noise of both pictures; the reference's share is the same in
/// all samples, so the scatter of a clean film's samples is up to sqrt(2) smaller.
class PatchTracker {
 public:
  struct Options {
    bool turns = true;       ///< estimate the angle as well
    int most_pixels = 6000;  ///< larger patches use every second, third, ... pixel
    int most_iterations = 25;
  };

  /// @param box  within the picture, at least kSmallest wide and high.
  PatchTracker(const GrayView& reference, const Box& box, const Options& options);

  /// The fit nearest to `start`; empty where it does not converge within the reach of a step, leaves the picture, or
  /// shows no contrast.
  std::optional<PatchFit> Find(const GrayView& picture, Point start, double angle) const;

  const Box& box() const { return box_; }
  /// Standard deviation of the place along its worst axis for noise of one grey level [pixel]; infinite without
  /// texture.
  double PixelsPerGreyLevel() const { return pixels_per_grey_level_; }

  static constexpr int kSmallest = 12;       ///< [pixel]
  static constexpr int kBorder = 4;          ///< that a patch must keep from the picture's edge [pixel]
  static constexpr double kSmoothing = 0.8;  ///< [pixel]

 private:
  struct Pixels;  // of the reference

  Box box_;
  Options options_;
  std::shared_ptr<const Pixels> pixels_;
  double reach_ = 0;  // half diagonal
  double pixels_per_grey_level_ = 0;
};

}  // namespace uiclink::track
