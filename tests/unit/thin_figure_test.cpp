// What is left out of a figure because nobody sees it.

#include "reports/thin_figure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace uiclink {
namespace {

/// Value of the line at x, between its points.
double LineAt(const FigureSeries& line, double x) {
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(line.x, x) - line.x.begin());
  if (right == 0) return line.y.front();
  const double t = (x - line.x[right - 1]) / (line.x[right] - line.x[right - 1]);
  return (1 - t) * line.y[right - 1] + t * line.y[right];
}

TEST(ThinToPixels, LinesStayWithinHalfAPixelAndGapsStay) {
  Figure figure{.panels = {{.series = {{}, {.line = FigureLine::kNone, .mark = FigureMark::kDot}}}},
                .width = 600,
                .panel_height = 200};
  FigureSeries &line = figure.panels[0].series[0], &dots = figure.panels[0].series[1];
  constexpr int kPoints = 1000;  // ten periods; fewer than are brought to their outline before
  for (int i = 0; i <= kPoints; ++i) {
    const double x = static_cast<double>(i) / kPoints;
    line.x.push_back(x);
    line.y.push_back(std::sin(20 * std::numbers::pi * x));
    dots.x.push_back(x);
    dots.y.push_back(0);
  }
  const FigureSeries whole = line;
  Figure broken = figure;
  ThinToPixels(&figure);
  EXPECT_LT(line.x.size(), 250u);
  // Half a pixel across the line is more along y where it is steepest: 100 px of amplitude, 10 periods in 600 px.
  const double bound = 0.5 * std::hypot(1, 20 * std::numbers::pi * 100 / 600) / 100;
  for (std::size_t i = 0; i < whole.x.size(); ++i)
    EXPECT_NEAR(LineAt(line, whole.x[i]), whole.y[i], bound) << whole.x[i];
  EXPECT_EQ(*std::ranges::max_element(line.y), *std::ranges::max_element(whole.y));
  EXPECT_NEAR(static_cast<double>(dots.x.size()), 600 / 2.0, 2);  // one in two pixels

  FigureSeries& with_gap = broken.panels[0].series[0];
  with_gap.y[500] = std::numeric_limits<double>::quiet_NaN();
  ThinToPixels(&broken);
  const auto gap = std::ranges::find_if(with_gap.y, [](double y) { return std::isnan(y); }) - with_gap.y.begin();
  ASSERT_LT(static_cast<std::size_t>(gap) + 1, with_gap.x.size());
  EXPECT_EQ(with_gap.x[static_cast<std::size_t>(gap) - 1], 0.499);
  EXPECT_EQ(with_gap.x[static_cast<std::size_t>(gap) + 1], 0.501);
}

/// A long noisy record with one outlier of one sample.
Figure NoisyFigure() {
  FigureSeries series;
  for (int i = 0; i < 100000; ++i) {
    series.x.push_back(0.005 * i);
    series.y.push_back(std::sin(0.005 * i) + 0.01 * std::sin(1.7 * i * i));
  }
  series.y[54321] = 7.5;
  return {.panels = {{.series = {series}}}};
}

TEST(ThinToPixels, ALongRecordKeepsItsExtremes) {
  const Figure whole = NoisyFigure();
  for (const double magnified : {1.0, 4.0}) {
    Figure thin = whole;
    ThinToPixels(&thin, magnified);
    const FigureSeries& kept = thin.panels[0].series[0];
    const FigureSeries& all = whole.panels[0].series[0];
    EXPECT_LE(kept.x.size(), static_cast<std::size_t>(1500 * magnified) + 6);
    EXPECT_EQ(std::ranges::max(kept.y), 7.5);
    EXPECT_EQ(std::ranges::min(kept.y), std::ranges::min(all.y));
    EXPECT_EQ(kept.x.front(), all.x.front());
    EXPECT_EQ(kept.x.back(), all.x.back());
  }
}

TEST(ThinToPixels, MoreIsKeptOfWhatMayBeMagnified) {
  Figure once = NoisyFigure(), magnified = once;
  ThinToPixels(&once);
  ThinToPixels(&magnified, 4);
  EXPECT_GT(magnified.panels[0].series[0].x.size(), 2 * once.panels[0].series[0].x.size());
}

}  // namespace
}  // namespace uiclink
