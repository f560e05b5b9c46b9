#pragma once

#include <memory>
#include <optional>

#include "identify/track/image.h"

namespace uiclink::track {

/// A place that looks like the patch, to about a pixel.
struct Lookalike {
  Point place;       ///< of the patch's centre
  double score = 0;  ///< normalised correlation [-], at most 1
};

/// The two best places of a search.
struct Lookalikes {
  Lookalike best;
  std::optional<Lookalike> rival;  ///< the best one that is not part of the same peak
};

/// Looks for a patch in a wide neighbourhood: normalised cross-correlation (cv::matchTemplate) on pictures that are
/// reduced until the patch is about kReduced pixels wide or high.
class CoarseSearch {
 public:
  CoarseSearch(const GrayView& reference, const Box& box);
  ~CoarseSearch();
  CoarseSearch(CoarseSearch&&) noexcept;
  CoarseSearch& operator=(CoarseSearch&&) noexcept;

  /// Best places with their centre within `radius` pixels of `around`, along x and along y; empty where the picture has
  /// no room for one.
  std::optional<Lookalikes> Find(const GrayView& picture, Point around, double radius) const;

  static constexpr int kReduced = 14;  ///< [reduced pixel]

 private:
  struct Patch;
  std::unique_ptr<Patch> patch_;
};

}  // namespace uiclink::track
