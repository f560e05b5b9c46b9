#include "identify/digitise/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "data/input_error.h"

namespace uiclink::digitise {
namespace {

Picture White(int width, int height) {
  return {width, height, std::vector<std::uint8_t>(3 * std::size_t(width) * std::size_t(height), 255)};
}

std::string FaultOf(const std::vector<CalibrationPoint>& points) {
  try {
    MakePage(White(400, 300), points, "p.png");
  } catch (const InputError& error) {
    return error.what();
  }
  return "none";
}

TEST(CalibrationPoints, TwoPerAxisGiveUprightAxes) {
  const Page page = MakePage(White(400, 300), {{{40, 260}, 0.0, -40.0}, {{340, 20}, 15.0, 40.0}}, "p.png");
  EXPECT_FALSE(page.resampled);
  EXPECT_NEAR(page.T(190), 7.5, 1e-9);  // by symmetry
  EXPECT_NEAR(page.Y(140), 0, 1e-9);
}

TEST(CalibrationPoints, TimeAndDisplacementMayComeFromDifferentPoints) {
  const Page page =
      MakePage(White(400, 300),
               {{{40, 260}, 0.0, {}}, {{340, 260}, 15.0, {}}, {{40, 260}, {}, -40.0}, {{40, 20}, {}, 40.0}}, "p.png");
  EXPECT_NEAR(page.T(190), 7.5, 1e-9);
  EXPECT_NEAR(page.Y(140), 0, 1e-9);
}

TEST(CalibrationPoints, FourTurnedOnesGiveTheTurnedAxesWithTheirResidual) {
  const double a = 2 * M_PI / 180;
  const auto place = [&](double t, double y, double off = 0) {
    const double x = 20 * t, row = -3 * y;
    return CalibrationPoint{
        {200 + x * std::cos(a) - row * std::sin(a) + off, 150 + x * std::sin(a) + row * std::cos(a)}, t, y};
  };
  Page page = MakePage(White(400, 300), {place(-8, -30), place(8, -30), place(8, 30), place(-8, 30)}, "p.png");
  EXPECT_TRUE(page.resampled);
  EXPECT_NEAR(page.tilt, a, 1e-9);
  EXPECT_LT(page.scale_residual, 1e-9);
  for (const double t : {-5.0, 0.0, 3.0}) {  // from axes to the picture and back
    const Pixel in_picture = page.to_picture({(t - page.t0) / page.t_per_px, (10 - page.y0) / page.y_per_px});
    const CalibrationPoint expected = place(t, 10);
    EXPECT_NEAR(in_picture.x, expected.pixel.x, 1e-9);
    EXPECT_NEAR(in_picture.y, expected.pixel.y, 1e-9);
  }
  // One of four off by 2 px along x: an affine map takes up three quarters; what is left, 0.5 px at each of the four
  // points, counts in t (and not in y, which is off by sin 2 degrees of that): rms over eight values 0.5 / sqrt 2.
  page = MakePage(White(400, 300), {place(-8, -30, 2), place(8, -30), place(8, 30), place(-8, 30)}, "p.png");
  EXPECT_NEAR(page.scale_residual, 0.5 / std::sqrt(2.0), 0.01);
}

TEST(CalibrationPoints, SayWhatIsWrong) {
  using testing::HasSubstr;
  EXPECT_THAT(FaultOf({{{40, 260}, 0.0, -40.0}}), HasSubstr("p.png: expected two or more points with a time"));
  EXPECT_THAT(FaultOf({{{40, 260}, 0.0, -40.0}, {{45, 20}, 15.0, 40.0}}), HasSubstr("points at different times"));
  EXPECT_THAT(FaultOf({{{40, 260}, 15.0, -40.0}, {{340, 20}, 0.0, 40.0}}), HasSubstr("time to grow to the right"));
  EXPECT_THAT(
      FaultOf({{{40, 260}, 0.0, -40.0}, {{340, 260}, 15.0, -40.0}, {{340, 20}, 15.0, 40.0}, {{40, 20}, 1.5, 40.0}}),
      HasSubstr("expected calibration points on one linear scale"));
}

}  // namespace
}  // namespace uiclink::digitise
