#include "identify/digitise/trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace uiclink::digitise {
namespace {

/// A sine wave as wide as a disc of that radius, sampled at pixel centres.
InkLayer DrawSine(int width, int height, double amplitude, double period, double radius) {
  InkLayer layer{Plane(width, height), Plane(width, height, 1)};
  for (double s = -10; s < width + 10; s += 0.002) {
    const double y = 0.5 * height + amplitude * std::sin(2 * M_PI * s / period);
    for (int dx = -static_cast<int>(radius) - 1; dx <= static_cast<int>(radius) + 1; ++dx) {
      const int x = static_cast<int>(std::lround(s)) + dx;
      if (x < 0 || x >= width || std::abs(x - s) > radius) continue;
      const double rise = std::sqrt(radius * radius - (x - s) * (x - s));
      for (int row = static_cast<int>(std::ceil(y - rise)); row <= y + rise; ++row)
        if (row >= 0 && row < height) layer.share.At(x, row) = 1;
    }
  }
  return layer;
}

Inks Whole(const InkLayer& layer) {
  Inks inks;
  inks.x1 = layer.share.width - 1, inks.y1 = layer.share.height - 1;
  return inks;
}

TEST(Trace, FollowsSteepSwingsAndFindsTheWidth) {
  const InkLayer layer = DrawSine(400, 300, 110, 40, 2.5);  // slopes up to 17
  const Trace trace = FindTrace(layer, Whole(layer));
  EXPECT_EQ(trace.strokes.size(), 400u);
  EXPECT_DOUBLE_EQ(trace.ink, trace.total_ink);
  EXPECT_NEAR(HalfWidth(trace, layer), 2.5, 0.5);  // in whole pixels
}

TEST(Trace, TheDiscFindsTheSineInsideItsOwnWidth) {
  const InkLayer layer = DrawSine(400, 300, 110, 40, 2.5);
  const Inks inks = Whole(layer);
  const std::vector<double> rows = RollDisc(FindTrace(layer, inks), 2.5, inks.x0, inks.x1);
  double largest = 0;
  for (std::size_t i = 10; i < 390; ++i) {
    // Distance across the line, from the row's error and the slope.
    const double phase = 2 * M_PI * double(i) / 40, slope = 110 * 2 * M_PI / 40 * std::cos(phase);
    largest = std::max(largest, std::abs(rows[i] - 150 - 110 * std::sin(phase)) / std::hypot(1, slope));
  }
  EXPECT_LT(largest, 1.0);  // whole pixels, half a pixel each side
}

TEST(Trace, BridgesDashesButNoFurtherThanNeeded) {
  InkLayer layer = DrawSine(400, 300, 110, 200, 1.5);
  EXPECT_EQ(FindTrace(layer, Whole(layer)).bridged, 3);
  for (int y = 0; y < 300; ++y)  // holes of six rows in steep parts
    for (int x = 0; x < 400; ++x)
      if (y % 16 < 6) layer.share.At(x, y) = 0;
  const Trace trace = FindTrace(layer, Whole(layer));
  EXPECT_EQ(trace.bridged, 8);
  EXPECT_GT(trace.ink, 0.99 * trace.total_ink);
}

TEST(Trace, LeavesTextBesideTheCurveAlone) {
  InkLayer layer = DrawSine(400, 300, 40, 200, 1.5);
  for (int x = 250; x < 330; ++x)  // a word in the upper corner
    for (int y = 20; y < 30; ++y)
      if (x % 4 < 2) layer.share.At(x, y) = 1;
  const Trace trace = FindTrace(layer, Whole(layer));
  EXPECT_EQ(trace.strokes.size(), 400u);
  for (const Stroke& stroke : trace.strokes) EXPECT_GT(stroke.low, 100) << stroke.x;
}

}  // namespace
}  // namespace uiclink::digitise
