#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace uiclink::track {

/// A place in a picture [pixel]: x to the right, y downwards, the centre of the first pixel at (0, 0).
struct Point {
  double x = 0;
  double y = 0;
};

inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(double s, Point a) { return {s * a.x, s * a.y}; }
inline double Dot(Point a, Point b) { return a.x * b.x + a.y * b.y; }

/// Whole pixels x .. x + width - 1, y .. y + height - 1.
struct Box {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;

  bool operator==(const Box&) const = default;
  Point Centre() const { return {x + 0.5 * (width - 1), y + 0.5 * (height - 1)}; }
  bool Contains(const Box& other) const {
    return other.x >= x && other.y >= y && other.x + other.width <= x + width && other.y + other.height <= y + height;
  }
  bool Overlaps(const Box& other) const {
    return other.x < x + width && x < other.x + other.width && other.y < y + height && y < other.y + other.height;
  }
};

/// The box with `margin` pixels more on every side.
inline Box Grown(const Box& box, int margin) {
  return {box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin};
}

/// Eight-bit grey pixels that somebody else owns.
struct GrayView {
  const std::uint8_t* data = nullptr;
  int width = 0;
  int height = 0;
  std::ptrdiff_t stride = 0;  ///< bytes from row to row

  Box Bounds() const { return {0, 0, width, height}; }
};

/// Covariance of a place [pixel^2].
struct PlaceCovariance {
  double xx = 0;
  double xy = 0;
  double yy = 0;

  /// Variance along a unit vector.
  double Along(Point axis) const { return axis.x * axis.x * xx + 2 * axis.x * axis.y * xy + axis.y * axis.y * yy; }
};

inline PlaceCovariance operator+(const PlaceCovariance& a, const PlaceCovariance& b) {
  return {a.xx + b.xx, a.xy + b.xy, a.yy + b.yy};
}

}  // namespace uiclink::track
