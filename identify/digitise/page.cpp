#include "identify/digitise/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "data/input_error.h"
#include "identify/digitise/views.h"

namespace uiclink::digitise {
namespace {

constexpr int kMargin = 24;        // around the frame, for tick marks [px]
constexpr double kUpright = 0.12;  // a frame whose corners are that close to a rectangle is not resampled [px]
constexpr double kStraight = 0.2;  // a bow below this is not worth a correction [px]

void RequireRange(const AxisRange& range, const char* option, const std::string& name) {
  const bool finite = std::isfinite(range.low) && std::isfinite(range.high);
  if (finite && range.high > range.low && std::abs(range.high) < 1e9 && std::abs(range.low) < 1e9) return;
  throw InputError(
      name, 0, fmt::format("expected {} LOW,HIGH with LOW below HIGH, found {:g},{:g}", option, range.low, range.high));
}

Pixel Apply(const cv::Mat& h, Pixel p) {
  const double* m = h.ptr<double>();
  const double w = m[6] * p.x + m[7] * p.y + m[8];
  return {(m[0] * p.x + m[1] * p.y + m[2]) / w, (m[3] * p.x + m[4] * p.y + m[5]) / w};
}

double Distance(Pixel a, Pixel b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// How far a side bows inside the rectangle, seen across it, as a cubic of u in [-1, 1] that vanishes at both ends.
struct Bow {
  double square = 0, cube = 0;  ///< (1 - u^2) (square + cube u)

  double At(double u) const { return (1 - u * u) * (square + cube * u); }
  double Largest() const {
    double largest = 0;
    for (double u = -1; u <= 1; u += 0.05) largest = std::max(largest, std::abs(At(u)));
    return largest;
  }
};

/// @param to_rectangle  homography from the picture
/// @param edge          where the side lies in the rectangle
Bow FindBow(const FrameSide& side, const cv::Mat& to_rectangle, double edge, double first, double last) {
  double a = 0, b = 0, d = 0, p = 0, q = 0;  // normal equations
  for (double v = -0.97; v <= 0.97; v += 0.02) {
    const double along = side.middle + v * side.half;
    const double across = side.Across(along);
    const Pixel in = Apply(to_rectangle, side.upright ? Pixel{across, along} : Pixel{along, across});
    const double u = 2 * ((side.upright ? in.y : in.x) - first) / (last - first) - 1;
    const double off = (side.upright ? in.x : in.y) - edge;
    const double f = 1 - u * u, g = f * u;
    a += f * f, b += f * g, d += g * g, p += f * off, q += g * off;
  }
  const double determinant = a * d - b * b;
  return {(p * d - q * b) / determinant, (a * q - b * p) / determinant};
}

/// From the rectangle to the picture: first the bow (Coons' blend of the four sides), then the homography.
struct FrameMap {
  cv::Matx33d from_rectangle;
  double left, right, top, bottom;
  std::array<Bow, 4> bows;

  Pixel operator()(Pixel p) const {
    const double u = (p.x - left) / (right - left), v = (p.y - top) / (bottom - top);
    const double dy = (1 - v) * bows[0].At(2 * u - 1) + v * bows[2].At(2 * u - 1);
    const double dx = (1 - u) * bows[3].At(2 * v - 1) + u * bows[1].At(2 * v - 1);
    return Apply(cv::Mat(from_rectangle, false), {p.x + dx, p.y + dy});
  }
};

Picture Resample(const Picture& picture, int width, int height, const std::function<Pixel(Pixel)>& to_picture) {
  cv::Mat map(height, width, CV_32FC2);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Pixel p = to_picture({double(x), double(y)});
      map.at<cv::Vec2f>(y, x) = {static_cast<float>(p.x), static_cast<float>(p.y)};
    }
  }
  cv::Mat target;
  cv::remap(View(picture), target, map, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return ToPicture(target);
}

void Scale(const AxisRange& x, const AxisRange& y, Page* page) {
  page->t_per_px = (x.high - x.low) / (page->right - page->left);
  page->t0 = x.low - page->t_per_px * page->left;
  page->y_per_px = (y.low - y.high) / (page->bottom - page->top);
  page->y0 = y.high - page->y_per_px * page->top;
}

/// Cuts the frame out as it is; false when its corners are no upright rectangle.
bool CutOut(const Picture& picture, const Frame& frame, Page* page) {
  const auto& [a, b, c, d] = frame.corners;
  page->left = 0.5 * (a.x + d.x), page->right = 0.5 * (b.x + c.x);
  page->top = 0.5 * (a.y + b.y), page->bottom = 0.5 * (c.y + d.y);
  const double off = std::max({std::abs(a.x - d.x), std::abs(b.x - c.x), std::abs(a.y - b.y), std::abs(c.y - d.y)});
  if (off > 2 * kUpright || page->bow > kStraight) return false;
  const int x0 = std::max(0, static_cast<int>(page->left) - kMargin);
  const int y0 = std::max(0, static_cast<int>(page->top) - kMargin);
  const int x1 = std::min(picture.width, static_cast<int>(page->right) + kMargin + 2);
  const int y1 = std::min(picture.height, static_cast<int>(page->bottom) + kMargin + 2);
  page->picture = ToPicture(View(picture)(cv::Rect(x0, y0, x1 - x0, y1 - y0)).clone());
  page->left -= x0, page->right -= x0, page->top -= y0, page->bottom -= y0;
  page->to_picture = [x0, y0](Pixel p) { return Pixel{p.x + x0, p.y + y0}; };
  return true;
}

/// Least squares of value = a + b x + c y through the points that have it. With two points (or points along a line)
/// only the axis' own direction counts.
std::array<double, 3> FitPlane(const std::vector<Pixel>& pixels, const std::vector<double>& values, bool of_time,
                               const char* what, const std::string& name) {
  const auto n = static_cast<int>(pixels.size());
  if (n < 2) {
    throw InputError(name, 0,
                     fmt::format("expected two or more points with a {} (--point PX,PY=T,Y), found {}", what, n));
  }
  const auto solve = [&](bool affine) {
    cv::Mat left(n, affine ? 3 : 2, CV_64F), right(n, 1, CV_64F), solution;
    for (int i = 0; i < n; ++i) {
      const Pixel p = pixels[std::size_t(i)];
      left.at<double>(i, 0) = 1;
      left.at<double>(i, 1) = of_time ? p.x : p.y;
      if (affine) left.at<double>(i, 2) = of_time ? p.y : p.x;
      right.at<double>(i) = values[std::size_t(i)];
    }
    cv::solve(left, right, solution, cv::DECOMP_SVD);
    const double other = affine ? solution.at<double>(2) : 0, own = solution.at<double>(1);
    return std::array<double, 3>{solution.at<double>(0), of_time ? own : other, of_time ? other : own};
  };
  // Spread of the points along and across their main direction decides what they can say.
  cv::Mat places(n, 2, CV_64F);
  for (int i = 0; i < n; ++i) {
    places.at<double>(i, 0) = pixels[std::size_t(i)].x;
    places.at<double>(i, 1) = pixels[std::size_t(i)].y;
  }
  const cv::PCA spread(places, {}, cv::PCA::DATA_AS_ROW);
  const bool affine = n >= 3 && std::sqrt(spread.eigenvalues.at<double>(1)) > 8;
  const auto plane = solve(affine);
  const auto [low, high] = std::minmax_element(
      pixels.begin(), pixels.end(), [&](const Pixel& a, const Pixel& b) { return of_time ? a.x < b.x : a.y < b.y; });
  const double apart = of_time ? high->x - low->x : high->y - low->y;
  if (apart < 20 || std::hypot(plane[1], plane[2]) * apart < 1e-12) {
    throw InputError(name, 0,
                     fmt::format("expected points at different {}s, at least 20 px apart along that axis, found them "
                                 "within {:.0f} px",
                                 what, apart));
  }
  return plane;
}

}  // namespace

Page MakePage(const Picture& picture, const Frame& frame, const AxisRange& x, const AxisRange& y,
              const std::string& name) {
  RequireRange(x, "--x-range", name);
  RequireRange(y, "--y-range", name);
  const auto& [a, b, c, d] = frame.corners;
  const double width = 0.5 * (Distance(a, b) + Distance(d, c)), height = 0.5 * (Distance(a, d) + Distance(b, c));
  FrameMap map{{}, kMargin, kMargin + width, kMargin, kMargin + height, {}};
  const std::vector<cv::Point2d> from{
      {map.left, map.top}, {map.right, map.top}, {map.right, map.bottom}, {map.left, map.bottom}};
  const std::vector<cv::Point2d> to{{a.x, a.y}, {b.x, b.y}, {c.x, c.y}, {d.x, d.y}};
  const cv::Mat homography = cv::findHomography(from, to);
  map.from_rectangle = homography;
  const cv::Mat inverse = homography.inv();
  map.bows = {FindBow(frame.sides[0], inverse, map.top, map.left, map.right),
              FindBow(frame.sides[1], inverse, map.right, map.top, map.bottom),
              FindBow(frame.sides[2], inverse, map.bottom, map.left, map.right),
              FindBow(frame.sides[3], inverse, map.left, map.top, map.bottom)};
  Page page;
  for (Bow& bow : map.bows) {
    page.bow = std::max(page.bow, bow.Largest());
    if (bow.Largest() < kStraight) bow = {};
  }
  if (page.bow > 0.04 * std::min(width, height)) {
    throw InputError(
        name, 0,
        fmt::format("expected a flat page, found a side of the frame bowed by {:.0f} px; flatten the page", page.bow));
  }
  page.border = frame.line_width;
  page.scale_residual = frame.closure;
  page.tilt = std::atan2(b.y - a.y, b.x - a.x);
  if (!CutOut(picture, frame, &page)) {
    page.resampled = true;
    page.left = map.left, page.right = map.right, page.top = map.top, page.bottom = map.bottom;
    page.to_picture = map;
    page.picture = Resample(picture, static_cast<int>(width) + 2 * kMargin + 2,
                            static_cast<int>(height) + 2 * kMargin + 2, page.to_picture);
  }
  Scale(x, y, &page);
  return page;
}

namespace {

struct Axes {
  std::array<double, 3> t, y;  ///< value = [0] + [1] x + [2] y
};

/// rms distance between the points and where the axes put their values [px].
double Residual(const std::vector<CalibrationPoint>& points, const Axes& axes) {
  double sum = 0;
  int count = 0;
  const auto add = [&](const std::array<double, 3>& plane, Pixel p, const std::optional<double>& value) {
    if (!value) return;
    const double off = (plane[0] + plane[1] * p.x + plane[2] * p.y - *value) / std::hypot(plane[1], plane[2]);
    sum += off * off;
    ++count;
  };
  for (const CalibrationPoint& point : points) {
    add(axes.t, point.pixel, point.t);
    add(axes.y, point.pixel, point.y);
  }
  return std::sqrt(sum / std::max(1, count));
}

Axes FitAxes(const std::vector<CalibrationPoint>& points, const std::string& name) {
  std::vector<Pixel> t_pixels, y_pixels;
  std::vector<double> times, values;
  for (const CalibrationPoint& point : points) {
    if (point.t) t_pixels.push_back(point.pixel), times.push_back(*point.t);
    if (point.y) y_pixels.push_back(point.pixel), values.push_back(*point.y);
  }
  return {FitPlane(t_pixels, times, true, "time", name), FitPlane(y_pixels, values, false, "displacement", name)};
}

}  // namespace

Page MakePage(const Picture& picture, const std::vector<CalibrationPoint>& points, const std::string& name) {
  const Axes axes = FitAxes(points, name);
  Page page;
  page.scale_residual = Residual(points, axes);
  if (page.scale_residual > 1.5) {
    throw InputError(name, 0,
                     fmt::format("expected calibration points on one linear scale, found them {:.1f} px (rms) off it; "
                                 "is one of them mistyped, an axis logarithmic, or the page photographed at an angle?",
                                 page.scale_residual));
  }
  page.t_per_px = std::hypot(axes.t[1], axes.t[2]);
  page.y_per_px = -std::hypot(axes.y[1], axes.y[2]);
  if (axes.t[1] < 0 || axes.y[2] > 0)
    throw InputError(name, 0,
                     "expected time to grow to the right and displacement upwards, found points that say otherwise");
  // Rectified (X, Y), in pixels of the same size: X = (t - t0)/t_per_px, Y = (y - y0)/y_per_px.
  const cv::Matx22d turn(axes.t[1] / page.t_per_px, axes.t[2] / page.t_per_px, axes.y[1] / page.y_per_px,
                         axes.y[2] / page.y_per_px);
  page.tilt = std::atan2(turn(1, 0), turn(1, 1)) * -1;
  page.resampled = std::abs(turn(0, 1)) * picture.height > kUpright || std::abs(turn(1, 0)) * picture.width > kUpright;
  page.picture = picture;
  page.t0 = axes.t[0], page.y0 = axes.y[0];
  page.to_picture = [](Pixel p) { return p; };
  if (page.resampled) {
    double low_x = 1e9, low_y = 1e9, high_x = -1e9, high_y = -1e9;
    for (const double x : {0.0, picture.width - 1.0}) {
      for (const double y : {0.0, picture.height - 1.0}) {
        const cv::Vec2d p = turn * cv::Vec2d(x, y);
        low_x = std::min(low_x, p[0]), high_x = std::max(high_x, p[0]);
        low_y = std::min(low_y, p[1]), high_y = std::max(high_y, p[1]);
      }
    }
    const cv::Matx22d back = turn.inv();
    const cv::Vec2d origin(std::floor(low_x), std::floor(low_y));
    page.to_picture = [back, origin](Pixel p) {
      const cv::Vec2d q = back * (cv::Vec2d(p.x, p.y) + origin);
      return Pixel{q[0], q[1]};
    };
    page.picture = Resample(picture, static_cast<int>(high_x - origin[0]) + 2, static_cast<int>(high_y - origin[1]) + 2,
                            page.to_picture);
    page.t0 += page.t_per_px * origin[0];
    page.y0 += page.y_per_px * origin[1];
  }
  page.left = 0, page.top = 0;
  page.right = page.picture.width - 1, page.bottom = page.picture.height - 1;
  return page;
}

}  // namespace uiclink::digitise
