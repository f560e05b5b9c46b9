#include "identify/track/motion_blur.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace uiclink::track {
namespace {

constexpr int kMargin = 32;  // half of the longest path [pixel]

/// A line through the middle as weights that sum to 1, each point shared by its four neighbours.
cv::Mat LineKernel(Point path) {
  const int half = static_cast<int>(std::ceil(0.5 * std::max(std::abs(path.x), std::abs(path.y)))) + 1;
  cv::Mat kernel = cv::Mat::zeros(2 * half + 1, 2 * half + 1, CV_32F);
  const int points = 8 * half;
  for (int i = 0; i < points; ++i) {
    const Point p = ((i + 0.5) / points - 0.5) * path + Point{static_cast<double>(half), static_cast<double>(half)};
    const int x = static_cast<int>(p.x), y = static_cast<int>(p.y);
    const auto fx = static_cast<float>(p.x - x), fy = static_cast<float>(p.y - y);
    kernel.at<float>(y, x) += (1 - fx) * (1 - fy), kernel.at<float>(y, x + 1) += fx * (1 - fy);
    kernel.at<float>(y + 1, x) += (1 - fx) * fy, kernel.at<float>(y + 1, x + 1) += fx * fy;
  }
  return kernel / points;
}

}  // namespace

ReferencePicture::ReferencePicture(const GrayView& reference, const Box& box) {
  const Box around = Grown(box, kMargin);
  const int left = std::max(0, around.x), top = std::max(0, around.y);
  width_ = std::min(reference.width, around.x + around.width) - left;
  height_ = std::min(reference.height, around.y + around.height) - top;
  box_ = {box.x - left, box.y - top, box.width, box.height};
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* const row = reference.data + (top + y) * reference.stride + left;
    pixels_.insert(pixels_.end(), row, row + width_);
  }
}

ReferencePicture ReferencePicture::Blurred(Point path) const {
  const double length = std::hypot(path.x, path.y);
  if (length > 2 * (kMargin - 2)) path = (2 * (kMargin - 2) / length) * path;
  ReferencePicture blurred;
  blurred.pixels_.resize(pixels_.size());
  blurred.width_ = width_, blurred.height_ = height_, blurred.box_ = box_;
  const cv::Mat sharp(height_, width_, CV_8U, const_cast<std::uint8_t*>(pixels_.data()));
  cv::Mat result(height_, width_, CV_8U, blurred.pixels_.data());
  cv::filter2D(sharp, result, CV_8U, LineKernel(path), {-1, -1}, 0, cv::BORDER_REPLICATE);
  return blurred;
}

}  // namespace uiclink::track
