#include "identify/track/tag.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>

namespace uiclink::track {
namespace {

constexpr std::array kDictionaries{cv::aruco::DICT_4X4_1000,       cv::aruco::DICT_5X5_1000,
                                   cv::aruco::DICT_6X6_1000,       cv::aruco::DICT_7X7_1000,
                                   cv::aruco::DICT_ARUCO_ORIGINAL, cv::aruco::DICT_APRILTAG_36h11};

Tag MakeTag(int id, const std::vector<cv::Point2f>& corners) {
  Tag tag{.id = id, .corners = {}};
  for (std::size_t i = 0; i < 4; ++i)
    tag.corners[i] = {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)};
  return tag;
}

double Length(Point a) { return std::hypot(a.x, a.y); }

}  // namespace

std::vector<Tag> FindTags(const GrayView& picture) {
  const cv::Mat grey(picture.height, picture.width, CV_8U, const_cast<std::uint8_t*>(picture.data),
                     static_cast<std::size_t>(picture.stride));
  const cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  parameters->cornerRefinementMethod = cv::aruco::CORNER_REFINE_SUBPIX;
  parameters->cornerRefinementMinAccuracy = 0.005;
  for (const auto dictionary : kDictionaries) {
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(grey, cv::aruco::getPredefinedDictionary(dictionary), corners, ids, parameters);
    if (ids.empty()) continue;
    std::vector<Tag> tags;
    for (std::size_t i = 0; i < ids.size(); ++i) tags.push_back(MakeTag(ids[i], corners[i]));
    return tags;
  }
  return {};
}

Box TagBox(const Tag& tag, const Box& picture) {
  double left = tag.corners[0].x, right = left, top = tag.corners[0].y, bottom = top;
  for (const Point& corner : tag.corners) {
    left = std::min(left, corner.x), right = std::max(right, corner.x);
    top = std::min(top, corner.y), bottom = std::max(bottom, corner.y);
  }
  constexpr double kRim = 3;  // [pixel]
  const int x0 = std::max(picture.x, static_cast<int>(std::floor(left - kRim)));
  const int y0 = std::max(picture.y, static_cast<int>(std::floor(top - kRim)));
  const int x1 = std::min(picture.x + picture.width, static_cast<int>(std::ceil(right + kRim)) + 1);
  const int y1 = std::min(picture.y + picture.height, static_cast<int>(std::ceil(bottom + kRim)) + 1);
  return {x0, y0, x1 - x0, y1 - y0};
}

TagScale CalcTagScale(const Tag& tag, double side_mm, Point axis) {
  const std::array<Point, 4>& c = tag.corners;
  // Mean of opposite sides: what perspective does to one it undoes in the other, to first order.
  const Point across = 0.5 * ((c[1] - c[0]) + (c[2] - c[3])), down = 0.5 * ((c[3] - c[0]) + (c[2] - c[1]));
  Eigen::Matrix2d to_picture;  // from millimetres in the tag's plane
  to_picture << across.x, down.x, across.y, down.y;
  to_picture /= side_mm;
  const Eigen::Vector2d millimetres = to_picture.inverse() * Eigen::Vector2d(axis.x, axis.y);
  const std::array lengths{Length(c[1] - c[0]), Length(c[2] - c[3]), Length(c[3] - c[0]), Length(c[2] - c[1])};
  const auto [least, most] = std::minmax_element(lengths.begin(), lengths.end());
  return {.mm_per_pixel = millimetres.norm(), .tilt = 2 * (*most - *least) / (*most + *least)};
}

}  // namespace uiclink::track
