#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "identify/digitise/digitise.h"
#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

constexpr int kShift = 4;  // places to a sixteenth of a pixel

cv::Point Place(Pixel p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))), static_cast<int>(std::lround(p.y * (1 << kShift)))};
}

}  // namespace

Picture DrawOverlay(const Picture& picture, const Digitised& read) {
  // The picture pale, so that what was read stands out whatever its colours are.
  cv::Mat pale = View(picture) * 0.45 + cv::Scalar(140, 140, 140);
  const cv::Scalar seen(40, 0, 230), bridged(230, 120, 0), frame(0, 150, 0);
  for (std::size_t i = 1; i < read.trail.size(); ++i) {
    const auto& [p, inked] = read.trail[i];
    const Pixel& before = read.trail[i - 1].first;
    if (std::hypot(p.x - before.x, p.y - before.y) > 4) continue;
    cv::line(pale, Place(before), Place(p), inked ? seen : bridged, 1, cv::LINE_AA, kShift);
  }
  for (std::size_t i = 1; i < read.outline.size(); ++i)
    cv::line(pale, Place(read.outline[i - 1]), Place(read.outline[i]), frame, 1, cv::LINE_AA, kShift);
  return ToPicture(pale);
}

}  // namespace uiclink::digitise
