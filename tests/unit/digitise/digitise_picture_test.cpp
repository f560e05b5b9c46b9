// Eight ways to draw a record, read back; the fifty of tests/support/plot_styles.cpp are in tests/validation.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "identify/digitise/digitise.h"
#include "tests/support/drawn_plot.h"
#include "tests/support/shipped_record.h"

namespace uiclink {
namespace {

using Grid = PlotStyle::Grid;

std::vector<PlotStyle> QuickStyles() {
  return {
      {.name = "thin", .width = 800, .height = 560, .line_width = 1, .colour = {180, 119, 31}},
      {.name = "thick", .width = 800, .height = 560, .line_width = 4, .colour = {40, 39, 214}, .legend = true},
      {.name = "black_grid",
       .width = 800,
       .height = 560,
       .line_width = 1.5,
       .colour = {0, 0, 0},
       .grid = Grid::kSolid,
       .zero_line = true},
      {.name = "dashed", .width = 900, .height = 600, .line_width = 2, .colour = {180, 119, 31}, .dash = 8, .hole = 5},
      {.name = "second", .width = 800, .height = 560, .line_width = 1.5, .colour = {180, 119, 31}, .second = true},
      {.name = "jpeg",
       .width = 800,
       .height = 560,
       .line_width = 2,
       .colour = {0, 0, 0},
       .grid = Grid::kSolid,
       .jpeg = 50},
      {.name = "turned", .width = 800, .height = 560, .line_width = 2, .colour = {44, 160, 44}, .rotation_deg = 2},
      {.name = "photo",
       .width = 1400,
       .height = 1000,
       .line_width = 3,
       .colour = {0, 0, 0},
       .photo = true,
       .bow = 0.01,
       .blur = 1.0,
       .noise = 4,
       .jpeg = 85}};
}

class ReadsBack : public testing::TestWithParam<PlotStyle> {};

TEST_P(ReadsBack, WithinAThirdOfAPixel) {
  const PlotStyle& style = GetParam();
  const Record record = ShippedLateral(4);
  const std::vector<double> y = InMillimetres(record), other = InMillimetres(ShippedLateral(7));
  const DrawnPlot plot = DrawPlot(record.t, y, other, style);
  digitise::DigitiseOptions options{.time = digitise::AxisRange{0, 15}, .displacement = digitise::AxisRange{-35, 35}};
  if (style.second) options.curve = "blue";
  const digitise::Digitised read = digitise::Digitise(plot.picture, style.name, options);
  const ReadingError error = CompareWithDrawn(record.t, y, plot, style, read.t, read.y, read.uncertainty);
  EXPECT_LT(error.rms, 0.3);  // the aim; measured: 0.05 to 0.15
  EXPECT_LT(error.chi, 2);    // the stated uncertainty is that of the errors found; measured: 0.7 to 1.8
  EXPECT_GT(error.chi, 0.4);
  EXPECT_TRUE(read.warnings.empty()) << (read.warnings.empty() ? "" : read.warnings.front());
  EXPECT_TRUE(read.gaps.empty());
  EXPECT_GT(read.t.back() - read.t.front(), 14.7);  // all but the frame's own line
  for (std::size_t i = 1; i < read.t.size(); ++i) ASSERT_NEAR(read.t[i] - read.t[i - 1], 1 / read.rate_hz, 1e-9);
  ASSERT_EQ(read.notes.size(), 2u);  // of both axes
  for (const std::string& note : read.notes) EXPECT_NE(note.find(" ticks on the "), std::string::npos) << note;
}

INSTANTIATE_TEST_SUITE_P(Styles, ReadsBack, testing::ValuesIn(QuickStyles()),
                         [](const auto& style) { return style.param.name; });

TEST(Digitise, PointsReplaceTheFrame) {
  PlotStyle style{.name = "no frame", .width = 800, .height = 560, .line_width = 2, .no_frame = true};
  const Record record = ShippedLateral(2);
  const std::vector<double> y = InMillimetres(record);
  for (const double turn : {0.0, 2.0}) {
    style.rotation_deg = turn;
    const DrawnPlot plot = DrawPlot(record.t, y, y, style);
    const auto point = [&](double t, double value) {
      // As the page was turned, about its middle.
      const double c = std::cos(turn * M_PI / 180), s = std::sin(turn * M_PI / 180);
      const double dx = plot.X(style, t) - 400, dy = plot.Y(style, value) - 280;
      return digitise::CalibrationPoint{{c * dx - s * dy + 400, s * dx + c * dy + 280}, t, value};
    };
    digitise::DigitiseOptions options;
    options.points = {point(0, -30), point(15, -30), point(15, 30), point(0, 30)};
    if (turn == 0) options.points = {point(0, -30), point(15, 30)};
    const digitise::Digitised read = digitise::Digitise(plot.picture, "points", options);
    const ReadingError error = CompareWithDrawn(record.t, y, plot, style, read.t, read.y, read.uncertainty);
    EXPECT_LT(error.rms, 0.3) << turn;
    EXPECT_NEAR(read.tilt_deg, turn, 0.01);
  }
}

TEST(Digitise, AHiddenPartBecomesAGapAndAWarning) {
  const PlotStyle style{.name = "hidden", .width = 800, .height = 560, .line_width = 2};
  const Record record = ShippedLateral(3);
  const std::vector<double> y = InMillimetres(record);
  DrawnPlot plot = DrawPlot(record.t, y, y, style);
  const int from = static_cast<int>(plot.X(style, 6.0)), to = static_cast<int>(plot.X(style, 6.6));
  for (int row = static_cast<int>(plot.top) + 4; row < plot.bottom - 4; ++row)
    for (int x = from; x < to; ++x)
      for (std::size_t c = 0; c < 3; ++c) plot.picture.bgr[3 * (std::size_t(row) * 800 + std::size_t(x)) + c] = 255;
  const digitise::Digitised read = digitise::Digitise(
      plot.picture, "hidden", {.time = digitise::AxisRange{0, 15}, .displacement = digitise::AxisRange{-35, 35}});
  ASSERT_EQ(read.gaps.size(), 1u);
  EXPECT_NEAR(read.gaps[0].first, 6.0, 0.05);  // 2 px of 22 ms
  EXPECT_NEAR(read.gaps[0].second, 6.6, 0.05);
  for (const double t : read.t) EXPECT_FALSE(t > read.gaps[0].first && t < read.gaps[0].second) << t;
  ASSERT_EQ(read.warnings.size(), 1u);
  EXPECT_NE(read.warnings[0].find("1 stretch of the curve could not be read and was left out"), std::string::npos);
}

TEST(Digitise, TheOverlayShowsWhatWasRead) {
  const PlotStyle style{.name = "overlay", .width = 800, .height = 560, .line_width = 2};
  const Record record = ShippedLateral(3);
  const std::vector<double> y = InMillimetres(record);
  const DrawnPlot plot = DrawPlot(record.t, y, y, style);
  const digitise::Digitised read = digitise::Digitise(
      plot.picture, "overlay", {.time = digitise::AxisRange{0, 15}, .displacement = digitise::AxisRange{-35, 35}});
  const digitise::Picture overlay = digitise::DrawOverlay(plot.picture, read);
  ASSERT_EQ(overlay.width, 800);
  int red = 0;
  for (std::size_t i = 100; i + 100 < record.t.size(); i += 50) {  // red where the record was drawn
    const std::uint8_t* p = overlay.At(static_cast<int>(std::lround(plot.X(style, record.t[i]))),
                                       static_cast<int>(std::lround(plot.Y(style, y[i]))));
    red += p[2] > p[0] + 60;
  }
  EXPECT_GT(red, 50);  // of 57
}

}  // namespace
}  // namespace uiclink
