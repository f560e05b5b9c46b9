#pragma once

#include <cstdint>
#include <vector>

#include "identify/track/image.h"

namespace uiclink::track {

/// The surroundings of a patch, with memory of their own.
class ReferencePicture {
 public:
  ReferencePicture(const GrayView& reference, const Box& box);

  /// The same as a shutter sees it that is open while the patch moves along `path` [pixel]: the mean along the path.
  /// The blur lies evenly on both sides, so the patch's place stays where it is.
  ReferencePicture Blurred(Point path) const;

  GrayView view() const { return {pixels_.data(), width_, height_, width_}; }
  const Box& box() const { return box_; }  ///< of the patch in this picture

 private:
  ReferencePicture() = default;

  std::vector<std::uint8_t> pixels_;
  int width_ = 0, height_ = 0;
  Box box_;
};

}  // namespace uiclink::track
