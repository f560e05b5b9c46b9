// Pictures that must not be read as if nothing were: every message whole or in its telling part.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"
#include "identify/digitise/digitise.h"
#include "tests/support/drawn_plot.h"
#include "tests/support/shipped_record.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

class RefusesToRead : public testing::Test {
 protected:
  PlotStyle style_{.name = "plot", .width = 800, .height = 560, .line_width = 2, .colour = {180, 119, 31}};
  digitise::DigitiseOptions options_{.time = digitise::AxisRange{0, 15}, .displacement = digitise::AxisRange{-35, 35}};
  Record record_ = ShippedLateral(1);
  std::vector<double> y_ = InMillimetres(record_);
  std::vector<double> other_ = InMillimetres(ShippedLateral(5));

  DrawnPlot Draw() const { return DrawPlot(record_.t, y_, other_, style_); }

  std::string Fault(const digitise::Picture& picture) const {
    try {
      digitise::Digitise(picture, "plot.png", options_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "read";
  }
  std::string Fault() const { return Fault(Draw().picture); }
};

TEST_F(RefusesToRead, TwoCurvesWithoutAChoice) {
  style_.second = true;
  EXPECT_THAT(Fault(), AllOf(StartsWith("plot.png: expected one curve, found 2: "), HasSubstr("blue (#1f77b4)"),
                             HasSubstr("2 red (#d"), HasSubstr("say which one with --curve COLOUR or --curve N")));
  options_.curve = "green";
  EXPECT_THAT(Fault(), StartsWith("plot.png: expected a green curve, found 1 "));
  options_.curve = "3";
  EXPECT_THAT(Fault(), StartsWith("plot.png: expected a curve 3, found 1 "));
  options_.curve = "bluish";
  EXPECT_THAT(Fault(), HasSubstr("expected a colour (#rrggbb, black, "));
}

TEST_F(RefusesToRead, TwoCurvesOfOneColour) {
  style_.second = true;
  style_.second_colour = style_.colour;
  for (double& y : other_) y = -0.8 * y;
  EXPECT_THAT(Fault(), StartsWith("plot.png: expected "));
  for (double& y : other_) y = 0.2 * y - 30;  // below, not touching
  EXPECT_THAT(Fault(), HasSubstr("a second curve of the same colour"));
}

TEST_F(RefusesToRead, NoFrame) {
  style_.no_frame = true;
  EXPECT_EQ(
      Fault(),
      "plot.png: expected a frame of four unbroken lines around the plot, found none; give two or more calibration "
      "points instead: --point PX,PY=T,Y");
}

TEST_F(RefusesToRead, TwoFrames) {
  const digitise::Picture one = Draw().picture;
  digitise::Picture two{1600, 560, std::vector<std::uint8_t>(3 * 1600 * 560)};
  for (std::size_t row = 0; row < 560; ++row)
    for (std::size_t i = 0; i < 2400; ++i)
      two.bgr[row * 4800 + i] = two.bgr[row * 4800 + 2400 + i] = one.bgr[row * 2400 + i];
  EXPECT_THAT(Fault(two), StartsWith("plot.png: expected one frame, found two, about "));
}

TEST_F(RefusesToRead, NoRanges) {
  options_.time.reset();
  EXPECT_THAT(Fault(), StartsWith("plot.png: expected what the axes show: --x-range and --y-range"));
  options_.time = digitise::AxisRange{15, 0};
  EXPECT_EQ(Fault(), "plot.png: expected --x-range LOW,HIGH with LOW below HIGH, found 15,0");
}

TEST_F(RefusesToRead, NoCurve) {
  for (double& y : y_) y = 1000;  // outside
  style_.t_high = -1, style_.t_low = -2;
  options_.time = digitise::AxisRange{-2, -1};
  EXPECT_EQ(Fault(), "plot.png: expected a curve that runs through the plot in one colour, found none");
}

TEST_F(RefusesToRead, CutOffCurve) {
  style_.y_low = -15, style_.y_high = 15;
  options_.displacement = digitise::AxisRange{-15, 15};
  for (double& y : y_) y = std::clamp(y, -15.0, 15.0);
  EXPECT_THAT(Fault(), HasSubstr("expected a curve inside the frame, found it cut off at the "));
}

TEST_F(RefusesToRead, SwingsThatAreNotResolved) {
  // Four copies of the record in a row: 100 swings on 430 px, drawn 3 px thick.
  const Record once = record_;
  for (int i = 1; i < 7; ++i) {
    for (std::size_t k = 0; k < once.t.size(); k += 2) {
      record_.t.push_back(once.t[k] + 15.005 * i);
      y_.push_back(1e3 * once.y[k]);
      other_.push_back(0);
    }
  }
  style_.width = 500, style_.height = 400, style_.line_width = 3;
  style_.t_high = 105;
  options_.time = digitise::AxisRange{0, 105};
  EXPECT_THAT(Fault(), StartsWith("plot.png: expected "));
}

TEST_F(RefusesToRead, RangesThatTicksContradictAreWarnedOf) {
  options_.time = digitise::AxisRange{0, 14};
  options_.displacement = digitise::AxisRange{-33, 37};
  const digitise::Digitised read = digitise::Digitise(Draw().picture, "plot.png", options_);
  ASSERT_EQ(read.warnings.size(), 2u);
  EXPECT_THAT(read.warnings[0],
              AllOf(StartsWith("the time axis has ticks at 2.33"), HasSubstr("no round numbers: is its range right?")));
  EXPECT_THAT(read.warnings[1], HasSubstr("the displacement axis has ticks at"));
}

TEST_F(RefusesToRead, WhatIsNoPicture) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "uiclink_no_picture.png";
  for (const std::string content : {"", "0.0 1.0\n", "\x89PNG\r\n\x1a\n"}) {
    WriteFileWhole(file, content);
    EXPECT_THROW(
        {
          try {
            digitise::ReadPicture(file);
          } catch (const InputError& error) {
            EXPECT_THAT(error.what(), HasSubstr("expected a picture (PNG, JPEG, TIFF, BMP, WebP), found none"));
            throw;
          }
        },
        InputError);
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace uiclink
