#include "identify/digitise/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "data/input_error.h"
#include "identify/digitise/lines.h"
#include "identify/digitise/views.h"
#include "identify/upper_median.h"

namespace uiclink::digitise {
namespace {

/// Darkness above its surroundings from which a pixel belongs to a line: below it is the ringing of JPEG.
constexpr double kLineThreshold = 24;

/// Four lines, each an index into level or upright lines.
struct Box {
  LongLine top, bottom, left, right;  // left and right with x and y exchanged
  double area = 0;
};

Pixel Meet(const LongLine& level, const LongLine& upright) {
  double x = upright.at;
  for (int i = 0; i < 12; ++i) x = upright.Y(level.Y(x));  // slopes are below 0.15: contracts by 50 a round
  return {x, level.Y(x)};
}

/// Both lines end where they meet: within 4 px and half a percent short of it, and no more than a tick mark beyond.
bool IsCorner(const LongLine& level, const LongLine& upright, bool right, bool bottom) {
  const Pixel corner = Meet(level, upright);
  const double beyond_x = right ? level.last - corner.x : corner.x - level.first;
  const double beyond_y = bottom ? upright.last - corner.y : corner.y - upright.first;
  const auto ends = [](double beyond, double length) {
    return beyond > -(4 + 0.005 * length) && beyond < 8 + 0.04 * length;
  };
  return ends(beyond_x, level.Length()) && ends(beyond_y, upright.Length());
}

std::vector<Box> FindBoxes(const std::vector<LongLine>& level, const std::vector<LongLine>& upright) {
  std::vector<Box> boxes;
  for (const LongLine& top : level) {
    for (const LongLine& left : upright) {
      if (!IsCorner(top, left, false, false)) continue;
      for (const LongLine& right : upright) {
        if (Meet(top, right).x < Meet(top, left).x + 32 || !IsCorner(top, right, true, false)) continue;
        for (const LongLine& bottom : level) {
          if (Meet(bottom, left).y < Meet(top, left).y + 32) continue;
          if (!IsCorner(bottom, left, false, true) || !IsCorner(bottom, right, true, true)) continue;
          const Pixel a = Meet(top, left), b = Meet(top, right), c = Meet(bottom, right), d = Meet(bottom, left);
          const double area = 0.5 * std::abs((c.x - a.x) * (d.y - b.y) - (d.x - b.x) * (c.y - a.y));
          boxes.push_back({top, bottom, left, right, area});
        }
      }
    }
  }
  std::sort(boxes.begin(), boxes.end(), [](const Box& a, const Box& b) { return a.area > b.area; });
  return boxes;
}

Pixel Centre(const Box& box) {
  const Pixel a = Meet(box.top, box.left), c = Meet(box.bottom, box.right);
  return {0.5 * (a.x + c.x), 0.5 * (a.y + c.y)};
}

bool Contains(const Box& box, const Pixel& p) {
  return p.y > box.top.Y(p.x) && p.y < box.bottom.Y(p.x) && p.x > box.left.Y(p.y) && p.x < box.right.Y(p.y);
}

/// The frame among closed boxes, largest first.
Box ChooseBox(const std::vector<Box>& boxes, const std::string& name) {
  if (boxes.empty()) {
    throw InputError(
        name, 0,
        "expected a frame of four unbroken lines around the plot, found none; give two or more calibration "
        "points instead: --point PX,PY=T,Y");
  }
  Box chosen = boxes.front();
  for (const Box& box : boxes)
    if (box.area > 0.25 * boxes.front().area && Contains(chosen, Centre(box))) chosen = box;
  for (const Box& box : boxes) {
    const bool apart = !Contains(chosen, Centre(box)) && !Contains(box, Centre(chosen));
    if (apart && box.area > 0.3 * chosen.area) {
      const Pixel a = Centre(chosen), b = Centre(box);
      throw InputError(
          name, 0,
          fmt::format("expected one frame, found two, about ({:.0f}, {:.0f}) and ({:.0f}, {:.0f}); cut the "
                      "picture to one of them",
                      a.x, a.y, b.x, b.y));
    }
  }
  return chosen;
}

struct Reading {
  double along, across, width;
};

/// Centres of the line's darkness across it, every `step` pixels.
std::vector<Reading> ReadCentres(const Plane& darkness, const LongLine& line, double first, double last, double reach) {
  std::vector<Reading> readings;
  const int step = std::max(1, static_cast<int>((last - first) / 1500));
  for (int x = static_cast<int>(std::ceil(first)); x <= last; x += step) {
    const double expected = line.Y(x);
    const int low = static_cast<int>(std::lround(expected - reach)),
              high = static_cast<int>(std::lround(expected + reach));
    if (low < 0 || high >= darkness.height) continue;
    double sum = 0, moment = 0, peak = 0;
    for (int y = low; y <= high; ++y) {
      const double value = darkness.At(x, y) > 0.5 * kLineThreshold ? darkness.At(x, y) : 0;
      sum += value, moment += value * y, peak = std::max(peak, value);
    }
    if (peak > kLineThreshold) readings.push_back({double(x), moment / sum, sum / peak});
  }
  return readings;
}

/// Robust cubic through the readings (Tukey's biweight on their own scatter).
void FitCubic(const std::vector<Reading>& readings, FrameSide* side) {
  cv::Mat solution = cv::Mat::zeros(4, 1, CV_64F);
  double scale = 2;
  for (int pass = 0; pass < 12; ++pass) {
    cv::Mat normal = 1e-9 * cv::Mat::eye(4, 4, CV_64F), right = cv::Mat::zeros(4, 1, CV_64F);
    std::vector<double> off;
    double sum = 0, weights = 0;
    for (const Reading& r : readings) {
      const double residual = r.across - side->Across(r.along);
      off.push_back(std::abs(residual));
      const double z = residual / (4.7 * scale);
      const double weight = pass == 0 ? 1 : std::abs(z) < 1 ? (1 - z * z) * (1 - z * z) : 0;
      const double u = (r.along - side->middle) / side->half;
      const cv::Mat row = (cv::Mat_<double>(4, 1) << 1, u, u * u, u * u * u);
      normal += weight * row * row.t();
      right += weight * r.across * row;
      sum += weight * residual * residual;
      weights += weight;
    }
    if (pass > 0) side->rms = std::sqrt(sum / std::max(weights, 1.0));
    cv::solve(normal, right, solution, cv::DECOMP_CHOLESKY);
    for (int i = 0; i < 4; ++i) side->c[static_cast<std::size_t>(i)] = solution.at<double>(i);
    if (pass > 0) scale = std::max(0.02, 1.48 * UpperMedian(off));
  }
}

/// @param line  of the side, with x along it; first and last: the corners' places along it
FrameSide MeasureSide(const Plane& darkness, const LongLine& line, double first, double last, bool upright) {
  FrameSide side{.upright = upright, .middle = 0.5 * (first + last), .half = 0.5 * (last - first), .c = {}};
  const double inset = 0.015 * (last - first) + 2;
  std::vector<double> widths;
  for (const Reading& r : ReadCentres(darkness, line, first + inset, last - inset, 5)) widths.push_back(r.width);
  side.line_width = std::max(1.0, UpperMedian(widths));
  const double a = line.Y(first), b = line.Y(side.middle), c = line.Y(last);
  side.c = {b, 0.5 * (c - a), 0.5 * (a + c) - b, 0};
  FitCubic(ReadCentres(darkness, line, first + inset, last - inset, 0.5 * side.line_width + 2.5), &side);
  return side;
}

Pixel Meet(const FrameSide& level, const FrameSide& upright) {
  Pixel p{upright.Across(level.c[0]), level.c[0]};
  for (int i = 0; i < 20; ++i) p = {upright.Across(p.y), level.Across(p.x)};
  return p;
}

}  // namespace

double FrameSide::Across(double along) const {
  const double u = (along - middle) / half;
  return c[0] + u * (c[1] + u * (c[2] + u * c[3]));
}

Frame FindFrame(const Picture& picture, const std::string& name) {
  const Plane darkness = LineDarkness(picture);
  const Plane turned = Transposed(darkness);
  const Box box =
      ChooseBox(FindBoxes(FindLevelLines(darkness, kLineThreshold), FindLevelLines(turned, kLineThreshold)), name);
  const Pixel a = Meet(box.top, box.left), b = Meet(box.top, box.right);
  const Pixel c = Meet(box.bottom, box.right), d = Meet(box.bottom, box.left);
  Frame frame;
  frame.sides = {MeasureSide(darkness, box.top, a.x, b.x, false), MeasureSide(turned, box.right, b.y, c.y, true),
                 MeasureSide(darkness, box.bottom, d.x, c.x, false), MeasureSide(turned, box.left, a.y, d.y, true)};
  const auto& [top, right, bottom, left] = frame.sides;
  frame.corners = {Meet(top, left), Meet(top, right), Meet(bottom, right), Meet(bottom, left)};
  for (const FrameSide& side : frame.sides) {
    frame.closure = std::max(frame.closure, side.rms);
    frame.line_width = std::max(frame.line_width, side.line_width);
  }
  if (frame.closure > 1.0) {
    throw InputError(
        name, 0,
        fmt::format("expected a frame of smooth lines, found sides that scatter by {:.1f} px; scan the page "
                    "flat, or give calibration points: --point PX,PY=T,Y",
                    frame.closure));
  }
  return frame;
}

}  // namespace uiclink::digitise
