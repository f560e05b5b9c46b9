#include "tests/support/film_maker.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>

namespace uiclink {

using track::Point;

Mosaic::Mosaic(int width, int height, const std::function<double(double x, double y)>& shade)
    : width_(width), height_(height) {
  const int columns = width * kFine, rows = height * kFine;
  const auto stride = static_cast<std::size_t>(columns) + 1;
  sums_.assign(stride * (static_cast<std::size_t>(rows) + 1), 0.0);
  for (int row = 0; row < rows; ++row) {
    double in_row = 0;
    for (int column = 0; column < columns; ++column) {
      in_row += shade((column + 0.5) / kFine - 0.5, (row + 0.5) / kFine - 0.5);
      const std::size_t at = (static_cast<std::size_t>(row) + 1) * stride + static_cast<std::size_t>(column) + 1;
      sums_[at] = sums_[at - stride] + in_row;
    }
  }
}

double Mosaic::Integral(double x, double y) const {
  const double u = std::clamp(x * kFine, 0.0, width_ * kFine - 1e-9);
  const double v = std::clamp(y * kFine, 0.0, height_ * kFine - 1e-9);
  const auto column = static_cast<std::size_t>(u), row = static_cast<std::size_t>(v);
  const double fx = u - static_cast<double>(column), fy = v - static_cast<double>(row);
  const std::size_t stride = static_cast<std::size_t>(width_ * kFine) + 1, at = row * stride + column;
  return ((1 - fy) * ((1 - fx) * sums_[at] + fx * sums_[at + 1]) +
          fy * ((1 - fx) * sums_[at + stride] + fx * sums_[at + stride + 1])) /
         (kFine * kFine);
}

std::function<double(double, double)> SoftSpots(int width, int height, double size, double mean, double contrast,
                                                unsigned seed) {
  // Values on a lattice of `size` pixels, joined by a cubic blend: continuous with its slope, and quick.
  const int columns = static_cast<int>(width / size) + 5, rows = static_cast<int>(height / size) + 5;
  std::vector<double> values(static_cast<std::size_t>(columns * rows));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> level(mean - contrast, mean + contrast);
  for (double& value : values) value = level(random);
  return [=, values = std::move(values)](double x, double y) {
    const double u = std::clamp(x / size + 2, 0.0, columns - 1.001), v = std::clamp(y / size + 2, 0.0, rows - 1.001);
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const auto blend = [](double s) { return s * s * (3 - 2 * s); };
    const double fx = blend(u - column), fy = blend(v - row);
    const auto at = [&](int dx, int dy) {
      return values[static_cast<std::size_t>((row + dy) * columns + column + dx)];
    };
    return (1 - fy) * ((1 - fx) * at(0, 0) + fx * at(1, 0)) + fy * ((1 - fx) * at(0, 1) + fx * at(1, 1));
  };
}

std::function<double(double, double)> TagShade(int id, double side_pixels, Point centre) {
  constexpr int kModules = 6;  // 4 and a black border
  cv::Mat pattern;
  cv::aruco::drawMarker(cv::aruco::getPredefinedDictionary(cv::aruco::DICT_4X4_50), id, kModules, pattern, 1);
  return [=](double x, double y) {
    const double u = (x - centre.x) / side_pixels * kModules + 0.5 * kModules;
    const double v = (y - centre.y) / side_pixels * kModules + 0.5 * kModules;
    if (u < 0 || v < 0 || u >= kModules || v >= kModules) return 225.0;
    return pattern.at<std::uint8_t>(static_cast<int>(v), static_cast<int>(u)) > 0 ? 225.0 : 30.0;
  };
}

namespace {

constexpr int kMargin = 40;  // of the background beyond the picture, for the shake [pixel]

Point Turned(Point p, double angle) {
  return {std::cos(angle) * p.x - std::sin(angle) * p.y, std::sin(angle) * p.x + std::cos(angle) * p.y};
}

Point Middle(const FilmSettings& s) { return {0.5 * (s.width - 1), 0.5 * (s.height - 1)}; }

CameraShake ShakeAt(const FilmSettings& s, double t) { return s.shake ? s.shake(t) : CameraShake{}; }

Point ToPicture(const FilmSettings& s, Point in_scene, const CameraShake& shake) {
  return Middle(s) + shake.shift + Turned(in_scene - Middle(s), shake.turn);
}

/// Share of [low, high] that the unit interval about x covers.
double Cover(double x, double low, double high) {
  return std::clamp(std::min(x + 0.5, high) - std::max(x - 0.5, low), 0.0, 1.0);
}

/// Scene, camera and sensor.
class Studio {
 public:
  explicit Studio(const FilmSettings& s)
      : s_(s),
        object_(s.object_width, s.object_height,
                s.object ? s.object : SoftSpots(s.object_width, s.object_height, 5, 128, 100, s.seed + 1)),
        second_(s.object_width, s.object_height, SoftSpots(s.object_width, s.object_height, 5, 128, 100, s.seed + 9)),
        background_(s.width + 2 * kMargin, s.height + 2 * kMargin, BackgroundShade()),
        random_(s.seed + 77) {}

  cv::Mat Shoot(double t) {
    const int moments = s_.exposure_s > 0 ? 8 : 1;
    cv::Mat light = cv::Mat::zeros(s_.height, s_.width, CV_32F);
    for (int i = 0; i < moments; ++i) light += Light(t + ((i + 0.5) / moments - 0.5) * s_.exposure_s);
    light /= moments;
    if (s_.noise > 0) {
      cv::Mat noise(light.size(), CV_32F);
      random_.fill(noise, cv::RNG::NORMAL, 0, s_.noise);
      light += noise;
    }
    cv::Mat grey, picture;
    light.convertTo(grey, CV_8U);
    cv::cvtColor(grey, picture, cv::COLOR_GRAY2BGR);
    return picture;
  }

 private:
  std::function<double(double, double)> BackgroundShade() const {
    if (s_.plain_background) return [](double, double) { return 120.0; };
    const auto shade = s_.background
                           ? s_.background
                           : SoftSpots(s_.width + 2 * kMargin, s_.height + 2 * kMargin, 7, 120, 70, s_.seed + 2);
    return shade;
  }

  cv::Mat Light(double t) {
    const CameraShake shake = ShakeAt(s_, t);
    cv::Mat light = Background(shake).clone();
    Draw(object_, TruePlace(s_, t), shake.turn, &light);
    if (s_.second) Draw(second_, ToPicture(s_, s_.second(t), shake), shake.turn, &light);
    return light;
  }

  void Draw(const Mosaic& object, Point place, double turn, cv::Mat* light) const {
    const double reach = 0.5 * std::hypot(s_.object_width, s_.object_height) + 2;
    const int top = std::max(0, static_cast<int>(place.y - reach)),
              left = std::max(0, static_cast<int>(place.x - reach));
    const int bottom = std::min(s_.height, static_cast<int>(place.y + reach) + 1);
    const int right = std::min(s_.width, static_cast<int>(place.x + reach) + 1);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const Point in_object = Turned({x - place.x, y - place.y}, -turn);
        const double u = in_object.x + 0.5 * s_.object_width, v = in_object.y + 0.5 * s_.object_height;
        const double cover = Cover(u, 0, s_.object_width) * Cover(v, 0, s_.object_height);
        if (cover <= 0) continue;
        // PixelAt integrates over what of the square lies on the object.
        float& pixel = light->at<float>(y, x);
        pixel = static_cast<float>((1 - cover) * static_cast<double>(pixel) + object.PixelAt(u - 0.5, v - 0.5));
      }
    }
  }

  const cv::Mat& Background(const CameraShake& shake) {
    if (!s_.shake && !still_.empty()) return still_;
    still_.create(s_.height, s_.width, CV_32F);
    const Point middle = Middle(s_);
    const double c = std::cos(shake.turn), sine = std::sin(shake.turn);
    for (int y = 0; y < s_.height; ++y) {
      for (int x = 0; x < s_.width; ++x) {
        const double dx = x - middle.x - shake.shift.x, dy = y - middle.y - shake.shift.y;
        still_.at<float>(y, x) = static_cast<float>(
            background_.PixelAt(c * dx + sine * dy + middle.x + kMargin, -sine * dx + c * dy + middle.y + kMargin));
      }
    }
    return still_;
  }

  const FilmSettings& s_;
  Mosaic object_, second_, background_;
  cv::Mat still_;
  cv::RNG random_;
};

double TimeOf(const FilmSettings& s, int picture) {
  return s.times.empty() ? picture / s.rate_hz : s.times[static_cast<std::size_t>(picture)];
}

}  // namespace

Point TruePlace(const FilmSettings& s, double t) {
  return ToPicture(s, s.object_at + (s.motion ? s.motion(t) : Point{}), ShakeAt(s, t));
}

void MakeFilm(const FilmSettings& s, const std::filesystem::path& file, const FilmFaults& faults) {
  const std::string& c = s.codec;
  cv::VideoWriter writer(file.string(), cv::CAP_FFMPEG, cv::VideoWriter::fourcc(c[0], c[1], c[2], c[3]), s.rate_hz,
                         {s.width, s.height});
  if (!writer.isOpened()) throw std::runtime_error("no encoder " + c);
  Studio studio(s);
  const auto has = [](const std::vector<int>& list, int i) {
    return std::find(list.begin(), list.end(), i) != list.end();
  };
  cv::Mat before;
  for (int i = 0; i < s.pictures; ++i) {
    if (has(faults.dropped, i)) continue;
    const cv::Mat picture = has(faults.repeated, i) ? before : studio.Shoot(TimeOf(s, i));
    writer.write(picture);
    before = picture;
  }
}

// --- time stamps of an MP4 file ------------------------------------------------------------------------------------

namespace {

using Bytes = std::string;

std::uint32_t Get32(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<std::uint8_t>(bytes[at + i]);
  return value;
}

Bytes Put32(std::uint32_t value) {
  Bytes bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<char>(value >> shift & 0xFF));
  return bytes;
}

/// The first box of a kind among the boxes in [begin, end); its offset. @throws std::runtime_error where there is none.
std::size_t FindBox(const Bytes& bytes, std::size_t begin, std::size_t end, const char* kind) {
  for (std::size_t at = begin; at + 8 <= end; at += Get32(bytes, at)) {
    if (bytes.compare(at + 4, 4, kind) == 0) return at;
    if (Get32(bytes, at) < 8) break;
  }
  throw std::runtime_error(std::string("no box ") + kind);
}

}  // namespace

void Restamp(const std::filesystem::path& file, const std::vector<double>& durations) {
  std::ifstream in(file, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(in), {}};
  in.close();
  std::vector<std::size_t> path;  // boxes that hold the table of durations, outermost first
  std::size_t begin = 0, end = bytes.size(), timescale_at = 0;
  for (const char* kind : {"moov", "trak", "mdia", "minf", "stbl", "stts"}) {
    if (std::string(kind) == "minf") timescale_at = FindBox(bytes, begin, end, "mdhd") + 20;
    const std::size_t at = FindBox(bytes, begin, end, kind);
    path.push_back(at);
    begin = at + 8, end = at + Get32(bytes, at);
  }
  if (path.front() < FindBox(bytes, 0, bytes.size(), "mdat")) throw std::runtime_error("moov before mdat");
  const double timescale = Get32(bytes, timescale_at);
  Bytes table = Put32(static_cast<std::uint32_t>(16 + 8 * durations.size())) + "stts" + Put32(0) +
                Put32(static_cast<std::uint32_t>(durations.size()));
  double sum = 0;
  long long before = 0;
  for (const double duration : durations) {
    sum += duration;
    const long long ticks = std::llround(sum * timescale);
    table += Put32(1) + Put32(static_cast<std::uint32_t>(ticks - before));
    before = ticks;
  }
  const std::size_t old = Get32(bytes, path.back());
  bytes.replace(path.back(), old, table);
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    bytes.replace(path[i], 4, Put32(static_cast<std::uint32_t>(Get32(bytes, path[i]) + table.size() - old)));
  std::ofstream(file, std::ios::binary) << bytes;
}

}  // namespace uiclink
