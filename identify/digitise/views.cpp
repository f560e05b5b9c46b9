#include "identify/digitise/views.h"

#include <opencv2/core.hpp>

namespace uiclink::digitise {

cv::Mat View(const Picture& picture) {
  return {picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.bgr.data())};
}

cv::Mat View(const Plane& plane) { return {plane.height, plane.width, CV_32F, const_cast<float*>(plane.value.data())}; }

Picture ToPicture(const cv::Mat& bgr) {
  Picture picture{bgr.cols, bgr.rows, {}};
  picture.bgr.resize(3 * bgr.total());
  bgr.copyTo(View(picture));
  return picture;
}

}  // namespace uiclink::digitise
