#include "identify/digitise/lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

constexpr double kLargestTilt = 8 * std::numbers::pi / 180;
constexpr double kShortest = 0.25;    // of the width
constexpr double kLargestBow = 0.03;  // of the length
constexpr int kMostLines = 60;

/// Ink in blocks of `scale` pixels: a block counts when one of its pixels does, so no thin line is lost.
cv::Mat ReducedMask(const Plane& darkness, double threshold, int scale) {
  cv::Mat mask((darkness.height + scale - 1) / scale, (darkness.width + scale - 1) / scale, CV_8U, cv::Scalar(0));
  for (int y = 0; y < darkness.height; ++y)
    for (int x = 0; x < darkness.width; ++x)
      if (darkness.At(x, y) > threshold) mask.at<std::uint8_t>(y / scale, x / scale) = 255;
  return mask;
}

struct Reading {
  double x, y;
  bool present;
};

/// Where the line is darkest within +-reach rows of where it is expected, every `step` columns.
std::vector<Reading> ReadAlong(const Plane& darkness, double threshold, const LongLine& line, double reach, int step) {
  std::vector<Reading> readings;
  for (int x = 0; x < darkness.width; x += step) {
    const double expected = line.Y(x);
    const int low = std::max(0, static_cast<int>(std::ceil(expected - reach)));
    const int high = std::min(darkness.height - 1, static_cast<int>(std::floor(expected + reach)));
    float darkest = 0;
    int best = -1;
    for (int y = low; y <= high; ++y) {
      // Of equally dark rows the nearest to the line.
      const float value = darkness.At(x, y) - 1e-3F * static_cast<float>(std::abs(y - expected));
      if (best < 0 || value > darkest) {
        darkest = value;
        best = y;
      }
    }
    readings.push_back({double(x), double(best), best >= 0 && darkest > threshold});
  }
  return readings;
}

/// Least-squares parabola through the readings of the run, outliers cut twice.
LongLine FitLine(const std::vector<Reading>& readings, const LongLine& start) {
  LongLine line = start;
  const double half = std::max(1.0, 0.5 * start.Length());
  for (const double cut : {3.0, 1.5}) {
    cv::Matx33d normal = 1e-9 * cv::Matx33d::eye();
    cv::Vec3d right;
    double count = 0;
    for (const Reading& r : readings) {
      if (!r.present || r.x < start.first || r.x > start.last || std::abs(r.y - line.Y(r.x)) > cut) continue;
      const double u = (r.x - line.middle) / half;
      const cv::Vec3d terms(1, u, u * u);
      normal += terms * terms.t();
      right += r.y * terms;
      count += 1;
    }
    if (count < 8) return line;
    const cv::Vec3d c = normal.solve(right, cv::DECOMP_CHOLESKY);
    line.at = c[0], line.slope = c[1] / half, line.bow = c[2] / (half * half);
  }
  return line;
}

/// The unbroken runs of ink along a line that are `shortest` or longer; holes up to `hole` pixels are bridged.
std::vector<LongLine> FindRuns(const std::vector<Reading>& readings, double hole, double shortest,
                               const LongLine& line) {
  std::vector<LongLine> runs;
  LongLine run = line;
  run.first = run.last = -1e9;
  const auto keep = [&] {
    if (run.Length() >= shortest) runs.push_back(run);
  };
  for (const Reading& r : readings) {
    if (!r.present) continue;
    if (r.x - run.last > hole) {
      keep();
      run.first = r.x;
    }
    run.last = r.x;
  }
  keep();
  return runs;
}

/// The run that a line found in one of its parts has after it was fitted again.
void FollowRun(const Plane& darkness, double threshold, double reach, int step, double hole, LongLine* line) {
  const double middle = 0.5 * (line->first + line->last);
  const std::vector<LongLine> runs = FindRuns(ReadAlong(darkness, threshold, *line, reach, step), hole, 1, *line);
  line->last = line->first;
  for (const LongLine& run : runs)
    if (run.first <= middle && run.last >= middle) *line = run;
}

bool IsNew(const LongLine& line, const std::vector<LongLine>& known) {
  return std::none_of(known.begin(), known.end(), [&](const LongLine& other) {
    const double middle = 0.5 * (line.first + line.last);
    return std::abs(line.Y(middle) - other.Y(middle)) < 3 && middle > other.first && middle < other.last;
  });
}

/// Fits the run and follows it beyond: a bowed line is met by Hough in its middle only. False where nothing long enough
/// and straight enough is left.
bool Refine(const Plane& darkness, double threshold, int scale, double hole, LongLine* line) {
  for (int pass = 0; pass < 5; ++pass) {
    *line = FitLine(ReadAlong(darkness, threshold, *line, 2.5 + (pass == 0 ? scale : 0), scale), *line);
    FollowRun(darkness, threshold, 2.5, scale, hole, line);
  }
  const double length = line->Length();
  return length >= kShortest * darkness.width && std::abs(line->bow) * length * length / 4 < kLargestBow * length;
}

}  // namespace

Plane LineDarkness(const Picture& picture) {
  cv::Mat grey, dark;
  cv::cvtColor(View(picture), grey, cv::COLOR_BGR2GRAY);
  const int size = std::max(11, std::max(picture.width, picture.height) / 80) | 1;
  cv::morphologyEx(grey, dark, cv::MORPH_BLACKHAT, cv::getStructuringElement(cv::MORPH_RECT, {size, size}), {-1, -1}, 1,
                   cv::BORDER_REPLICATE);
  Plane plane(picture.width, picture.height);
  cv::Mat target = View(plane);
  dark.convertTo(target, CV_32F);
  return plane;
}

Plane Transposed(const Plane& plane) {
  Plane result(plane.height, plane.width);
  cv::Mat target = View(result);
  cv::transpose(View(plane), target);
  return result;
}

std::vector<LongLine> FindLevelLines(const Plane& darkness, double threshold) {
  const int scale = std::max(1, (std::max(darkness.width, darkness.height) + 999) / 1000);
  const cv::Mat mask = ReducedMask(darkness, threshold, scale);
  const double right_angle = std::numbers::pi / 2;
  std::vector<cv::Vec2f> found;
  cv::HoughLines(mask, found, 1, std::numbers::pi / 900, static_cast<int>(0.6 * kShortest * mask.cols), 0, 0,
                 right_angle - kLargestTilt, right_angle + kLargestTilt);
  const int step = std::max(1, scale);
  const double hole = step - 1 + std::max(2.5, 0.004 * darkness.width);
  std::vector<LongLine> lines;
  std::vector<LongLine> tried;
  for (const cv::Vec2f& polar : found) {
    const double rho = polar[0], sine = std::sin(polar[1]), cosine = std::cos(polar[1]);
    const double middle = 0.5 * darkness.width;
    LongLine line{middle,
                  (rho + 0.5) * scale / sine - 0.5 - cosine / sine * middle,
                  -cosine / sine,
                  0,
                  0,
                  double(darkness.width)};
    if (!IsNew(line, tried) || tried.size() > 400) continue;
    tried.push_back(line);
    for (LongLine& run : FindRuns(ReadAlong(darkness, threshold, line, 1.5 * scale + 2, step), hole,
                                  0.5 * kShortest * darkness.width, line)) {
      if (Refine(darkness, threshold, scale, hole, &run) && IsNew(run, lines)) lines.push_back(run);
    }
    if (lines.size() >= kMostLines) break;
  }
  return lines;
}

}  // namespace uiclink::digitise
