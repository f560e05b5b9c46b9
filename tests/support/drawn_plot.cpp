#include "tests/support/drawn_plot.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace uiclink {
namespace {

using digitise::Picture;

cv::Scalar Scalar(const std::array<int, 3>& c) { return {double(c[0]), double(c[1]), double(c[2])}; }

/// Draws on a canvas `scale` times as fine as the picture.
class Canvas {
 public:
  Canvas(int width, int height, int scale, int paper)
      : scale_(scale), canvas_(height * scale, width * scale, CV_8UC3, cv::Scalar::all(paper)) {}

  void Line(double x0, double y0, double x1, double y1, const cv::Scalar& colour, double width) {
    Path({{x0, y0}, {x1, y1}}, colour, width);
  }
  void Path(const std::vector<cv::Point2d>& points, const cv::Scalar& colour, double width) {
    std::vector<cv::Point> places;
    for (const cv::Point2d& p : points) places.push_back(Place(p));
    const int thickness = std::max(1, static_cast<int>(std::lround(width * scale_)));
    cv::polylines(canvas_, places, false, colour, thickness, cv::LINE_AA, kShift);
  }
  void Text(const std::string& text, double x, double y, double size, const cv::Scalar& colour) {
    cv::putText(canvas_, text, {int(x * scale_), int(y * scale_)}, cv::FONT_HERSHEY_SIMPLEX, size * scale_ / 22, colour,
                std::max(1, static_cast<int>(size * scale_ / 12)), cv::LINE_8);
  }
  cv::Mat Small() const {
    cv::Mat small;
    cv::resize(canvas_, small, {canvas_.cols / scale_, canvas_.rows / scale_}, 0, 0, cv::INTER_AREA);
    return small;
  }

 private:
  static constexpr int kShift = 8;
  /// Pixel centres are whole numbers on both canvases: (x + 1/2) scale - 1/2.
  cv::Point Place(const cv::Point2d& p) const {
    const auto place = [this](double v) {
      return static_cast<int>(std::lround(((v + 0.5) * scale_ - 0.5) * (1 << kShift)));
    };
    return {place(p.x), place(p.y)};
  }
  int scale_;
  cv::Mat canvas_;
};

/// The parts of a path that a dashed line shows.
std::vector<std::vector<cv::Point2d>> Dashes(const std::vector<cv::Point2d>& path, double dash, double hole) {
  std::vector<std::vector<cv::Point2d>> parts{{path.front()}};
  double left = dash;
  bool on = true;
  for (std::size_t i = 1; i < path.size(); ++i) {
    cv::Point2d a = path[i - 1];
    const cv::Point2d b = path[i];
    double length = cv::norm(b - a);
    while (length > left) {
      a += (b - a) * (left / length);
      length -= left;
      if (on) {
        parts.back().push_back(a);
      } else {
        parts.push_back({a});
      }
      on = !on;
      left = on ? dash : hole;
    }
    left -= length;
    if (on) parts.back().push_back(b);
  }
  return parts;
}

std::vector<cv::Point2d> PathOf(const std::vector<double>& t, const std::vector<double>& y, const DrawnPlot& plot,
                                const PlotStyle& style) {
  std::vector<cv::Point2d> path;
  for (std::size_t i = 0; i < t.size(); ++i)
    if (t[i] >= style.t_low && t[i] <= style.t_high) path.emplace_back(plot.X(style, t[i]), plot.Y(style, y[i]));
  return path;
}

void DrawCurve(const std::vector<cv::Point2d>& path, const PlotStyle& style, const cv::Scalar& colour, Canvas* canvas) {
  if (style.dash <= 0) {
    canvas->Path(path, colour, style.line_width);
    return;
  }
  for (const auto& part : Dashes(path, style.dash, style.hole))
    if (part.size() > 1) canvas->Path(part, colour, style.line_width);
}

void DrawAxes(const PlotStyle& style, const DrawnPlot& plot, const cv::Scalar& ink, Canvas* canvas) {
  const double size = std::max(9.0, style.height / 50.0), tick = std::max(4.0, style.width / 160.0);
  const double way = style.ticks_inside ? -1 : 1;
  const auto grid = [&](double x0, double y0, double x1, double y1) {
    const cv::Scalar grey = cv::Scalar::all(style.dark ? 255 - style.grid_grey : style.grid_grey);
    const double dash = style.grid == PlotStyle::Grid::kDotted ? 1.5 : 6,
                 hole = style.grid == PlotStyle::Grid::kDotted ? 3 : 4;
    if (style.grid == PlotStyle::Grid::kNone) return;
    if (style.grid == PlotStyle::Grid::kSolid) return canvas->Line(x0, y0, x1, y1, grey, 1);
    for (const auto& part : Dashes({{x0, y0}, {x1, y1}}, dash, hole))
      if (part.size() > 1) canvas->Path(part, grey, 1);
  };
  for (double t = std::ceil(style.t_low); t <= style.t_high + 1e-9; t += 2.5 * (style.t_high - style.t_low) / 15) {
    const double x = plot.X(style, t);
    if (t > style.t_low && t < style.t_high) grid(x, plot.top, x, plot.bottom);
    canvas->Line(x, plot.bottom, x, plot.bottom + way * tick, ink, style.frame_width);
    char label[16];
    std::snprintf(label, sizeof label, "%g", t);
    canvas->Text(label, x - size, plot.bottom + tick + 1.5 * size, size, ink);
  }
  for (double y = std::ceil(style.y_low / 10) * 10; y <= style.y_high + 1e-9; y += 10) {
    const double row = plot.Y(style, y);
    if (y > style.y_low && y < style.y_high) grid(plot.left, row, plot.right, row);
    canvas->Line(plot.left, row, plot.left - way * tick, row, ink, style.frame_width);
    char label[16];
    std::snprintf(label, sizeof label, "%g", y);
    canvas->Text(label, plot.left - 3.2 * size, row + 0.4 * size, size, ink);
  }
  canvas->Text("displacement [mm] over time [s]", 0.35 * style.width, plot.top - 0.6 * size, size, ink);
  if (style.zero_line) canvas->Line(plot.left, plot.Y(style, 0), plot.right, plot.Y(style, 0), ink, 1);
}

void DrawFrame(const PlotStyle& style, const DrawnPlot& plot, Canvas* canvas) {
  const cv::Scalar ink = cv::Scalar::all(style.dark ? 255 - style.frame_grey : style.frame_grey);
  if (style.no_frame) {
    canvas->Path({{plot.left, plot.top}, {plot.left, plot.bottom}, {plot.right, plot.bottom}}, ink, style.frame_width);
    return;
  }
  canvas->Path({{plot.left, plot.top},
                {plot.right, plot.top},
                {plot.right, plot.bottom},
                {plot.left, plot.bottom},
                {plot.left, plot.top}},
               ink, style.frame_width);
}

void DrawLegend(const PlotStyle& style, const DrawnPlot& plot, const cv::Scalar& ink, Canvas* canvas) {
  const double size = std::max(9.0, style.height / 50.0);
  const double x = plot.right - 14 * size, y = plot.top + 2 * size;
  canvas->Text("lateral, record", x, y + 0.4 * size, size, ink);
  canvas->Line(x + 9.5 * size, y, x + 13 * size, y, Scalar(style.colour), style.line_width);
  if (!style.second) return;
  canvas->Text("model", x, y + 2 * size, size, ink);
  canvas->Line(x + 9.5 * size, y + 1.6 * size, x + 13 * size, y + 1.6 * size, Scalar(style.second_colour),
               style.line_width);
}

cv::Mat DrawByOpenCv(const std::vector<double>& t, const std::vector<double>& y, const std::vector<double>& other,
                     const PlotStyle& style, const DrawnPlot& plot) {
  Canvas canvas(style.width, style.height, style.width > 1600 ? 2 : 4, style.dark ? 20 : 255);
  const cv::Scalar ink = cv::Scalar::all(style.dark ? 235 : 0);
  DrawAxes(style, plot, ink, &canvas);
  if (style.second) canvas.Path(PathOf(t, other, plot, style), Scalar(style.second_colour), style.line_width);
  DrawCurve(PathOf(t, y, plot, style), style, Scalar(style.colour), &canvas);
  DrawFrame(style, plot, &canvas);
  if (style.legend) DrawLegend(style, plot, ink, &canvas);
  return canvas.Small();
}

std::string Hex(const std::array<int, 3>& c) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", c[2], c[1], c[0]);
  return text;
}

cv::Mat DrawByGnuplot(const std::vector<double>& t, const std::vector<double>& y, const std::vector<double>& other,
                      const PlotStyle& style, DrawnPlot* plot) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("uiclink_plot_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::string data = (folder / "data.txt").string(), script = (folder / "script.gp").string(),
                    png = (folder / "plot.png").string();
  std::ofstream values(data);
  for (std::size_t i = 0; i < t.size(); ++i) values << t[i] << ' ' << y[i] << ' ' << other[i] << '\n';
  values.close();
  std::ofstream commands(script);
  commands << "set terminal pngcairo size " << style.width << ',' << style.height << " background '#ffffff'\n"
           << "set output '" << png << "'\n"
           << "set lmargin at screen 0.1\nset rmargin at screen 0.95\nset bmargin at screen 0.12\nset tmargin at "
              "screen 0.92\n"
           << "set xrange [" << style.t_low << ':' << style.t_high << "]\nset yrange [" << style.y_low << ':'
           << style.y_high << "]\n"
           << "set border 15 lw " << style.frame_width << "\nset xlabel 'time [s]'\nset ylabel 'displacement [mm]'\n"
           << (style.legend ? "set key top right\n" : "unset key\n")
           << (style.grid == PlotStyle::Grid::kNone ? "" : "set grid\n")
           << (style.ticks_inside ? "set tics in\n" : "set tics out nomirror\n")
           << (style.zero_line ? "set xzeroaxis lt 1 lc rgb 'black'\n" : "") << "plot ";
  if (style.second)
    commands << "'" << data << "' using 1:3 with lines lw " << style.line_width << " lc rgb '"
             << Hex(style.second_colour) << "' title 'model', ";
  commands << "'" << data << "' using 1:2 with lines lw " << style.line_width << " lc rgb '" << Hex(style.colour) << "'"
           << (style.dash > 0 ? " dt 2" : "") << " title 'record'\n"
           << "print GPVAL_TERM_XMIN, GPVAL_TERM_XMAX, GPVAL_TERM_YMIN, GPVAL_TERM_YMAX\n";
  commands.close();
  const bool ran = std::system(("gnuplot '" + script + "' >/dev/null 2>&1").c_str()) == 0;
  cv::Mat picture = ran ? cv::imread(png, cv::IMREAD_COLOR) : cv::Mat();
  std::filesystem::remove_all(folder);
  if (picture.empty()) throw std::runtime_error("gnuplot drew nothing");
  plot->left = 0.1 * style.width, plot->right = 0.95 * style.width;
  plot->top = 0.08 * style.height, plot->bottom = 0.88 * style.height;
  return picture;
}

/// The page as a camera or a crooked scanner sees it.
cv::Mat Distort(const cv::Mat& page, const PlotStyle& style) {
  const double w = page.cols, h = page.rows;
  cv::Mat map(page.size(), CV_32FC2), distorted;
  const double c = std::cos(style.rotation_deg * CV_PI / 180), s = std::sin(style.rotation_deg * CV_PI / 180);
  const std::vector<cv::Point2f> from{{0, 0}, {float(w), 0}, {float(w), float(h)}, {0, float(h)}};
  std::vector<cv::Point2f> to = from;
  if (style.photo)
    to = {{float(0.04 * w), float(0.05 * h)},
          {float(0.97 * w), float(0.03 * h)},
          {float(0.95 * w), float(0.96 * h)},
          {float(0.06 * w), float(0.93 * h)}};
  const cv::Mat back = cv::getPerspectiveTransform(to, from);
  const double* m = back.ptr<double>();
  for (int y = 0; y < page.rows; ++y) {
    for (int x = 0; x < page.cols; ++x) {
      const double dx = x - w / 2, dy = y - h / 2;
      const double rx = c * dx + s * dy + w / 2, ry = -s * dx + c * dy + h / 2;
      const double q = m[6] * rx + m[7] * ry + m[8];
      const double u = (m[0] * rx + m[1] * ry + m[2]) / q;
      const double v = (m[3] * rx + m[4] * ry + m[5]) / q - style.bow * h * (1 - std::pow(2 * u / w - 1, 2));
      map.at<cv::Vec2f>(y, x) = {float(u), float(v)};
    }
  }
  const cv::Scalar around = style.photo ? cv::Scalar(60, 80, 100) : cv::Scalar::all(style.dark ? 20 : 255);
  cv::remap(page, distorted, map, {}, cv::INTER_CUBIC, cv::BORDER_CONSTANT, around);
  if (style.photo) {
    for (int y = 0; y < page.rows; ++y)
      for (int x = 0; x < page.cols; ++x) {
        const double light = 0.95 - 0.25 * x / w - 0.12 * y / h + 0.08 * (x / w) * (y / h);
        distorted.at<cv::Vec3b>(y, x) *= light;
      }
  }
  return distorted;
}

cv::Mat Degrade(cv::Mat picture, const PlotStyle& style) {
  if (style.rotation_deg != 0 || style.photo || style.bow != 0) picture = Distort(picture, style);
  if (style.blur > 0) cv::GaussianBlur(picture, picture, {}, style.blur);
  if (style.noise > 0) {
    cv::RNG random(12345);
    cv::Mat noise(picture.size(), CV_16SC3), sum;
    random.fill(noise, cv::RNG::NORMAL, 0, style.noise);
    picture.convertTo(sum, CV_16SC3);
    sum += noise;
    sum.convertTo(picture, CV_8UC3);
  }
  if (style.jpeg > 0) {
    std::vector<std::uint8_t> bytes;
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, style.jpeg});
    picture = cv::imdecode(bytes, cv::IMREAD_COLOR);
  }
  return picture;
}

double DistanceToPath(const cv::Point2d& p, const std::vector<cv::Point2d>& path, double reach) {
  const auto first =
      std::lower_bound(path.begin(), path.end(), p.x - reach, [](const cv::Point2d& q, double x) { return q.x < x; });
  double least = 1e9;
  auto before = first == path.begin() ? first : first - 1;
  for (auto q = before == path.end() ? before : before + 1; q != path.end(); ++q) {
    const cv::Point2d along = *q - *before;
    const double length = along.dot(along);
    const double part = length > 0 ? std::clamp((p - *before).dot(along) / length, 0.0, 1.0) : 0;
    least = std::min(least, cv::norm(*before + part * along - p));
    if (before->x > p.x + reach) break;
    before = q;
  }
  return least;
}

}  // namespace

DrawnPlot DrawPlot(const std::vector<double>& t, const std::vector<double>& y, const std::vector<double>& other,
                   const PlotStyle& style) {
  DrawnPlot plot;
  // Off whole pixels: a frame need not lie on them.
  plot.left = std::round(0.1 * style.width) + 0.25, plot.right = std::round(0.95 * style.width) + 0.5;
  plot.top = std::round(0.08 * style.height) + 0.75, plot.bottom = std::round(0.88 * style.height);
  const cv::Mat page =
      style.gnuplot ? DrawByGnuplot(t, y, other, style, &plot) : DrawByOpenCv(t, y, other, style, plot);
  const cv::Mat picture = Degrade(page, style);
  plot.picture = {picture.cols, picture.rows, {}};
  plot.picture.bgr.assign(picture.datastart, picture.dataend);
  return plot;
}

ReadingError CompareWithDrawn(const std::vector<double>& t, const std::vector<double>& y, const DrawnPlot& plot,
                              const PlotStyle& style, const std::vector<double>& read_t,
                              const std::vector<double>& read_y, const std::vector<double>& read_uncertainty) {
  const std::vector<cv::Point2d> drawn = PathOf(t, y, plot, style), read = PathOf(read_t, read_y, plot, style);
  ReadingError error;
  double square = 0, chi = 0;
  std::size_t count = 0;
  const auto add = [&](double distance, double time) {
    square += distance * distance, ++count;
    if (distance > error.largest) error.largest = distance, error.where = time;
  };
  for (std::size_t i = 0; i < read.size(); ++i) {
    add(DistanceToPath(read[i], drawn, 6), read_t[i]);
    const auto after = std::lower_bound(t.begin(), t.end(), read_t[i]);
    const auto k =
        static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - t.begin(), 1, std::ptrdiff_t(t.size()) - 1));
    const double part = (read_t[i] - t[k - 1]) / (t[k] - t[k - 1]);
    const double off = read_y[i] - (y[k - 1] + part * (y[k] - y[k - 1]));
    chi += off * off / (read_uncertainty[i] * read_uncertainty[i]);
  }
  // Between samples further apart than three times the usual step nothing was read.
  const double step = 3 * (read_t.back() - read_t.front()) / double(read_t.size());
  const auto in_gap = [&](double time) {
    const auto after = std::lower_bound(read_t.begin(), read_t.end(), time);
    return after == read_t.begin() || after == read_t.end() || *after - *(after - 1) > step;
  };
  for (const cv::Point2d& p : drawn)
    if (!in_gap(style.t_low + (p.x - plot.left) / (plot.right - plot.left) * (style.t_high - style.t_low)))
      add(DistanceToPath(p, read, 6),
          style.t_low + (p.x - plot.left) / (plot.right - plot.left) * (style.t_high - style.t_low));
  error.rms = std::sqrt(square / double(std::max<std::size_t>(count, 1)));
  error.chi = std::sqrt(chi / double(std::max<std::size_t>(read.size(), 1)));
  return error;
}

}  // namespace uiclink
