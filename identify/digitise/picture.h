#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace uiclink::digitise {

/// A place in a picture [px]: x to the right, y down, (0, 0) the centre of the first pixel.
struct Pixel {
  double x = 0;
  double y = 0;
};

/// Eight bits of blue, green and red a pixel, row by row.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bgr;

  const std::uint8_t* At(int x, int y) const {
    return bgr.data() +
           3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

/// One number a pixel.
struct Plane {
  int width = 0;
  int height = 0;
  std::vector<float> value;

  Plane() = default;
  Plane(int w, int h, float fill = 0)
      : width(w), height(h), value(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), fill) {}
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
  float At(int x, int y) const { return value[Index(x, y)]; }
  float& At(int x, int y) { return value[Index(x, y)]; }
};

/// Reads PNG, JPEG, TIFF, BMP, PBM or WebP; transparent parts become white.
/// @throws InputError when the file cannot be read, is no picture, or is smaller than 64x64 or larger than 100 Mpx.
Picture ReadPicture(const std::filesystem::path& path);

/// Dark pictures (light lines on black) with their colours inverted, others as they are.
Picture WithLightPaper(Picture picture);

/// Evens out the light on a photographed page: the brightness of the paper, a cubic surface through the bright quantile
/// of blocks, is divided out. A picture whose paper is even to 3 % stays as it is.
Picture WithEvenPaper(Picture picture);

/// PNG file of the picture. @throws InputError when it cannot be written.
void WritePicture(const std::filesystem::path& path, const Picture& picture);

}  // namespace uiclink::digitise
