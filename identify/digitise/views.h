#pragma once

// Between our pictures and OpenCV's matrices; for sources of this folder that include <opencv2/core.hpp> first.

#include "identify/digitise/picture.h"

namespace cv {
class Mat;
}

namespace uiclink::digitise {

/// The same pixels as a matrix of OpenCV, not copied; valid as long as the picture.
cv::Mat View(const Picture& picture);
cv::Mat View(const Plane& plane);

/// A copy of an 8-bit matrix of three channels.
Picture ToPicture(const cv::Mat& bgr);

}  // namespace uiclink::digitise
