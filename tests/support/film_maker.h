#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "identify/track/image.h"

namespace uiclink {

/// A plane picture, a mosaic of tiles of 1/kFine pixel, each of one grey level: a scene whose image on a sensor is
/// known exactly, since a pixel sees the mean of its square and the integral of a mosaic is a sum.
class Mosaic {
 public:
  static constexpr int kFine = 4;  ///< tiles a pixel, in both directions

  /// @param shade  grey level (0..255) at a place [pixel]; called at the middle of every tile.
  Mosaic(int width, int height, const std::function<double(double x, double y)>& shade);

  /// Integral over the square of side 1 about a place [pixel], (0, 0) being the middle of the first pixel; dark beyond
  /// the mosaic.
  double PixelAt(double x, double y) const {
    return Integral(x, y) + Integral(x + 1, y + 1) - Integral(x + 1, y) - Integral(x, y + 1);
  }
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  double Integral(double x, double y) const;

  int width_, height_;        // [pixel]
  std::vector<double> sums_;  // of all tiles above and to the left, rows of tiles + 1
};

/// Random soft spots: a smooth texture with details of about `size` pixels, around `mean` +- `contrast`.
std::function<double(double, double)> SoftSpots(int width, int height, double size, double mean, double contrast,
                                                unsigned seed);

/// An ArUco marker of the 4 x 4 dictionary with a white rim of one module, its middle at `centre`.
std::function<double(double, double)> TagShade(int id, double side_pixels, track::Point centre);

/// What the camera itself does at a time.
struct CameraShake {
  track::Point shift;  ///< by which the scene moves in the picture [pixel]
  double turn = 0;     ///< of the scene about the picture's middle [rad]
};

/// How a film is made.
struct FilmSettings {
  int width = 640, height = 360;
  double rate_hz = 50;
  int pictures = 250;
  int object_width = 90, object_height = 60;              ///< [pixel]
  track::Point object_at{320, 180};                       ///< its middle at displacement 0 [pixel]
  std::function<track::Point(double t)> motion = {};      ///< displacement of the object in the scene [pixel]
  std::function<CameraShake(double t)> shake = {};        ///< none where empty
  std::function<track::Point(double t)> second = {};      ///< place of a second object in the scene [pixel]; none
  std::function<double(double, double)> object = {};      ///< its texture; SoftSpots where empty
  std::function<double(double, double)> background = {};  ///< SoftSpots where empty
  bool plain_background = false;                          ///< an even wall
  double noise = 0;                                       ///< standard deviation of each pixel [grey levels]
  double exposure_s = 0;                                  ///< the shutter is open about the picture's time; 0: a flash
  std::string codec = "FFV1";                             ///< four letters: FFV1 (without loss), MJPG, mp4v, avc1
  std::vector<double> times = {};                         ///< of the pictures [s]; even where empty
  unsigned seed = 1;
};

/// Renders a film. Every picture is written, in order; leave_out and repeat change what is written.
struct FilmFaults {
  std::vector<int> dropped = {};   ///< pictures that are not written (the container's stamps go on evenly)
  std::vector<int> repeated = {};  ///< pictures that are replaced by the one before
};

/// @throws std::runtime_error where OpenCV has no such encoder.
void MakeFilm(const FilmSettings& settings, const std::filesystem::path& file, const FilmFaults& faults = {});

/// Place of the object's middle in the picture at a time [pixel]: what a tracker should find.
track::Point TruePlace(const FilmSettings& settings, double t);

/// Gives the pictures of an MP4 file (without B-pictures) other durations [s]: its time stamps become their sums.
/// @throws std::runtime_error where the file is not laid out as OpenCV writes it.
void Restamp(const std::filesystem::path& file, const std::vector<double>& durations);

}  // namespace uiclink
