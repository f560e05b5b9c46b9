#include "identify/track/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink::track {
namespace {

// Okabe and Ito's colours, blue-green-red.
const cv::Scalar kBlue(178, 114, 0), kVermilion(0, 94, 213), kGreen(115, 158, 0), kGrey(150, 150, 150);
const cv::Scalar kWhite(255, 255, 255), kBlack(0, 0, 0);
constexpr int kStrip = 200;  // height of the record below the picture [pixel]
constexpr int kMargin = 44;

cv::Rect ToRect(const Box& box) { return {box.x, box.y, box.width, box.height}; }
cv::Point ToPixel(Point p) { return {static_cast<int>(std::lround(p.x)), static_cast<int>(std::lround(p.y))}; }

/// With a rim of the other brightness, to be seen on any picture.
void Write(cv::Mat* picture, const std::string& text, cv::Point at, const cv::Scalar& colour) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, kWhite, 3, cv::LINE_AA);
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
}

cv::Mat ReadFirst(const std::string& film) {
  cv::VideoCapture video(film, cv::CAP_FFMPEG);
  cv::Mat picture;
  if (!video.read(picture)) throw InputError(film, 0, "expected a film, found no picture in it");
  if (picture.channels() == 1) cv::cvtColor(picture, picture, cv::COLOR_GRAY2BGR);
  return picture.clone();
}

void DrawScene(const TrackResult& result, cv::Mat* picture) {
  for (const Box& box : result.camera.unsteady) cv::rectangle(*picture, ToRect(box), kGrey, 1);
  for (const Box& box : result.camera.used) cv::rectangle(*picture, ToRect(box), kGreen, 2);
  std::vector<cv::Point> way;
  for (const Point& p : result.places) way.push_back(ToPixel(p));
  cv::polylines(*picture, way, false, kVermilion, 1, cv::LINE_AA);
  const Point centre = result.roi.Centre();
  cv::arrowedLine(*picture, ToPixel(centre), ToPixel(centre + 60.0 * result.axis), kBlue, 2, cv::LINE_AA, 0, 0.15);
  cv::rectangle(*picture, ToRect(result.roi), kVermilion, 2);
  Write(picture, result.tag_id ? fmt::format("tag {}", *result.tag_id) : "patch", {result.roi.x, result.roi.y - 6},
        kVermilion);
  Write(picture, "+", ToPixel(centre + 72.0 * result.axis), kBlue);
  int line = 18;
  Write(picture, fmt::format("{:.5g} mm/pixel, camera: {}", result.mm_per_pixel, Name(result.camera.model)), {8, line},
        kBlack);
  if (!result.camera.used.empty()) Write(picture, "green: still background", {8, line += 18}, kGreen);
  if (!result.camera.unsteady.empty()) Write(picture, "grey: not used (moves, or was lost)", {8, line += 18}, kBlack);
}

/// The record over time; where a picture is missing the line is broken.
cv::Mat DrawRecord(const TrackResult& result, int width) {
  cv::Mat strip(kStrip, width, CV_8UC3, kWhite);
  const auto [low, high] = std::minmax_element(result.y.begin(), result.y.end());
  const double begin = result.t.front(), duration = std::max(1e-9, result.t.back() - begin);
  const double range = std::max(1e-9, *high - *low);
  const auto at = [&](std::size_t i) {
    return cv::Point(
        kMargin + static_cast<int>(std::lround((width - 2 * kMargin) * (result.t[i] - begin) / duration)),
        kStrip - kMargin / 2 - static_cast<int>(std::lround((kStrip - kMargin) * (result.y[i] - *low) / range)));
  };
  for (std::size_t i = 1; i < result.t.size(); ++i) {
    const bool next = result.picture[i] == result.picture[i - 1] + 1 &&
                      result.t[i] - result.t[i - 1] < 1.5 * std::max(1e-9, result.times.step);
    if (next || !result.times.even) cv::line(strip, at(i - 1), at(i), kVermilion, 1, cv::LINE_AA);
  }
  Write(&strip, fmt::format("{:.1f} mm", 1e3 * *high), {2, 16}, kBlack);
  Write(&strip, fmt::format("{:.1f} mm", 1e3 * *low), {2, kStrip - 6}, kBlack);
  Write(&strip, fmt::format("{:.2f} s", result.t.back()), {width - 70, kStrip - 6}, kBlack);
  return strip;
}

}  // namespace

void WriteOverlay(const TrackResult& result, const std::filesystem::path& file) {
  cv::Mat picture = ReadFirst(result.file), whole;
  DrawScene(result, &picture);
  cv::vconcat(picture, DrawRecord(result, picture.cols), whole);
  std::vector<std::uint8_t> bytes;
  try {
    if (!cv::imencode(file.extension().string(), whole, bytes)) bytes.clear();
  } catch (const cv::Exception&) {
    bytes.clear();
  }
  if (bytes.empty())
    throw InputError(file.string(), 0, "expected a picture's name that ends in .png or .jpg, found another ending");
  WriteFileWhole(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace uiclink::track
