#include "vehicle/contact/profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "vehicle/contact/contact_search.h"
#include "vehicle/contact/profile_file.h"

namespace uiclink {
namespace {

/// Where pieces meet, without the two ends.
std::vector<double> Joints(const Profile& profile) {
  std::vector<double> joints;
  for (std::size_t i = 1; i < profile.pieces().size(); ++i) joints.push_back(profile.pieces()[i].y_begin());
  return joints;
}

/// Those of them where height or slope steps by more than rounding (1e-10 m, 1e-9).
std::vector<double> Kinks(const Profile& profile) {
  std::vector<double> kinks = Joints(profile);
  std::erase_if(kinks, [&](double y) {
    const ProfilePoint below = profile.Eval(y, JointSide::kBelow), above = profile.Eval(y, JointSide::kAbove);
    return std::abs(below.z - above.z) <= 1e-10 && std::abs(below.slope - above.slope) <= 1e-9;
  });
  return kinks;
}

using testing::HasSubstr;

constexpr double kMm = 1e-3;

TrackGeometry NominalTrack() {
  TrackGeometry geometry;
  geometry.gauge = 1.435;
  geometry.gauge_depth = 0.014;
  geometry.cant = 1.0 / 40;
  return geometry;
}

TEST(ProfilePiece, PolynomialAndArcsHaveTheirDerivatives) {
  const ProfilePiece parabola = ProfilePiece::Polynomial(0, 1, 0.5, std::array{1.0, 2.0, 3.0});
  const ProfilePoint p = parabola.Eval(0.75);
  EXPECT_DOUBLE_EQ(p.z, 1 + 2 * 0.25 + 3 * 0.0625);
  EXPECT_DOUBLE_EQ(p.slope, 2 + 6 * 0.25);
  EXPECT_DOUBLE_EQ(p.second, 6);

  // A circle of radius 0.5 at 3-4-5: slope -+3/4, curvature -+1/R.
  const ProfilePoint upper = ProfilePiece::UpperArc(0.5, 1.5, 1, 2, 0.5).Eval(1.3);
  EXPECT_NEAR(upper.z, 2.4, 1e-15);
  EXPECT_NEAR(upper.slope, -0.75, 1e-14);
  EXPECT_NEAR(upper.Curvature(), -2, 1e-13);
  const ProfilePoint lower = ProfilePiece::LowerArc(0.5, 1.5, 1, 2, 0.5).Eval(1.3);
  EXPECT_NEAR(lower.z, 1.6, 1e-15);
  EXPECT_NEAR(lower.slope, 0.75, 1e-14);
  EXPECT_NEAR(lower.Curvature(), 2, 1e-13);
}

TEST(ProfilePiece, HermiteTakesUpAQuinticExactly) {
  const ProfilePiece quintic = ProfilePiece::Polynomial(0, 1, 0.2, std::array{1.0, -2.0, 3.0, -4.0, 5.0, -6.0});
  const ProfilePiece hermite = ProfilePiece::Hermite(0.1, quintic.Eval(0.1), 0.9, quintic.Eval(0.9));
  for (double y = 0.1; y <= 0.9; y += 0.05) {  // rounding of terms of size 10
    EXPECT_NEAR(hermite.Eval(y).z, quintic.Eval(y).z, 1e-13);
    EXPECT_NEAR(hermite.Eval(y).slope, quintic.Eval(y).slope, 1e-12);
    EXPECT_NEAR(hermite.Eval(y).second, quintic.Eval(y).second, 1e-11);
  }
}

TEST(ProfilePiece, ALineCanBeAddedToEitherKind) {
  const ProfilePiece parabola = ProfilePiece::Polynomial(1, 3, 0.5, std::array{1.0, 2.0, 3.0});
  const ProfilePiece arc = ProfilePiece::UpperArc(1, 3, 2.5, 0, 4);
  for (const ProfilePiece& piece : {parabola, arc}) {
    const ProfilePiece tilted = piece.WithLine(0.1, 0.5);  // slope 0.2
    for (const double y : {1.0, 1.7, 3.0}) {
      EXPECT_NEAR(tilted.Eval(y).z, piece.Eval(y).z + 0.1 + 0.2 * (y - 1), 1e-14);
      EXPECT_NEAR(tilted.Eval(y).slope, piece.Eval(y).slope + 0.2, 1e-14);
      EXPECT_DOUBLE_EQ(tilted.Eval(y).second, piece.Eval(y).second);
      EXPECT_NEAR(tilted.CalcSlope(y), tilted.Eval(y).slope, 1e-14);
      EXPECT_NEAR(tilted.Mirrored().Eval(-y).z, tilted.Eval(y).z, 1e-14);
      EXPECT_NEAR(tilted.Mirrored().Eval(-y).slope, -tilted.Eval(y).slope, 1e-14);
    }
  }
}

TEST(Profile, KnowsBothSidesOfAJoint) {
  const Profile profile("corner", {ProfilePiece::Polynomial(-1, 0, 0, std::array{0.0, -0.5}),
                                   ProfilePiece::Polynomial(0, 1, 0, std::array{0.25, 0.5, 2.0}),
                                   ProfilePiece::Polynomial(1, 2, 1, std::array{2.75, 4.5})});
  EXPECT_THAT(Joints(profile), testing::ElementsAre(0, 1));
  EXPECT_THAT(Kinks(profile), testing::ElementsAre(0));  // at 1 only the curvature jumps
  EXPECT_DOUBLE_EQ(profile.Eval(0, JointSide::kBelow).slope, -0.5);
  EXPECT_DOUBLE_EQ(profile.Eval(0, JointSide::kBelow).z, 0);
  EXPECT_DOUBLE_EQ(profile.Eval(0).slope, 0.5);
  EXPECT_DOUBLE_EQ(profile.Eval(0).z, 0.25);
  EXPECT_DOUBLE_EQ(profile.Eval(1, JointSide::kBelow).second, 4);
  EXPECT_DOUBLE_EQ(profile.Eval(1).second, 0);
  EXPECT_TRUE(std::isnan(profile.Eval(2.0001).z));
  EXPECT_TRUE(std::isnan(profile.Eval(-1.0001).slope));

  const Profile closed = profile.WithoutSteps();
  EXPECT_DOUBLE_EQ(closed.Eval(0, JointSide::kBelow).z, 0.125);
  EXPECT_DOUBLE_EQ(closed.Eval(0).z, 0.125);
  EXPECT_DOUBLE_EQ(closed.Eval(-1).z, profile.Eval(-1).z);  // the line ends where there is no step
}

TEST(Profile, RefusesPiecesWithGaps) {
  const auto line = [](double from, double to) { return ProfilePiece::Polynomial(from, to, 0, std::array{0.0}); };
  EXPECT_THROW(Profile("gap", {line(0, 1), line(1.5, 2)}), std::invalid_argument);
  EXPECT_THROW(Profile("backward", {line(1, 0)}), std::invalid_argument);
  EXPECT_THROW(Profile("nothing", {}), std::invalid_argument);
  EXPECT_THROW(Profile("line", {line(0, 1)}).Cut(2, 3), std::invalid_argument);
}

TEST(Profile, TurnsEveryKindOfPiece) {
  const double angle = 0.05;
  const Profile profile("three kinds", {ProfilePiece::Polynomial(-0.02, 0, 0, std::array{0.0, 0.1}),
                                        ProfilePiece::Polynomial(0, 0.02, 0, std::array{0.0, 0.1, -8.0, 90.0}),
                                        ProfilePiece::UpperArc(0.02, 0.03, 0.025, -0.08, 0.08)});
  const Profile moved = profile.Moved(angle, 0.7, 0.3);
  for (double y = -0.0199; y < 0.03; y += 0.0003) {
    const ProfilePoint p = profile.Eval(y);
    const ProfilePoint q = moved.Eval(y * std::cos(angle) - p.z * std::sin(angle) + 0.7);
    // A quintic over 0.5 mm of this cubic leaves f^(6) h^6 / 46080, about 1e-16 m; a step of the profile where its
    // pieces meet (y = 0.02) is not turned with them.
    if (std::abs(y - 0.02) < 0.0005) continue;
    EXPECT_NEAR(q.z, y * std::sin(angle) + p.z * std::cos(angle) + 0.3, 2e-16 + 1e-15) << y;
    EXPECT_NEAR(std::atan(q.slope), std::atan(p.slope) + angle, 1e-11) << y;
    EXPECT_NEAR(q.Curvature(), p.Curvature(), 1e-6) << y;
  }
}

TEST(StandardProfiles, S1002HasTheMeasuresOfEn13715) {
  const Profile& wheel = WheelS1002();
  // Characteristic points D1, C1, B1, E1, F1, G1, H1 (F positive downward), printed to 0.001 mm.
  const std::vector<std::array<double, 2>> points{{-35, 6.867},      {-26, 2.741},      {32.158, -0.780},
                                                  {-38.427, 12.000}, {-39.765, 15.675}, {-49.663, 26.748},
                                                  {-62.765, 25.149}};
  for (const auto& [y, f] : points) EXPECT_NEAR(wheel.Eval(y * kMm).z, -f * kMm, 0.002 * kMm) << y;
  EXPECT_NEAR(wheel.Eval(0).z, 0, 1e-15);
  EXPECT_NEAR(wheel.Eval(-55 * kMm).z, -28 * kMm, 2e-8);    // flange height; closing the steps: 1e-8
  EXPECT_NEAR(wheel.Eval(-37.5 * kMm).z, -10 * kMm, 1e-6);  // flange thickness 32.5 at z = 10, to 0.001 mm
  EXPECT_NEAR(wheel.Eval(-39 * kMm).slope, std::tan(70 * M_PI / 180), 1e-4);
  EXPECT_NEAR(wheel.Eval(50 * kMm).slope, 1.0 / 15, 1e-8);
  for (const double y : Joints(wheel)) {
    const ProfilePoint below = wheel.Eval(y, JointSide::kBelow);
    const ProfilePoint above = wheel.Eval(y);
    EXPECT_NEAR(below.z, above.z, 1e-16) << y;
    EXPECT_NEAR(below.slope, above.slope, 6e-5) << y;  // the printed polynomials: 3e-5, closing their steps: 2e-5
  }
}

TEST(StandardProfiles, RailHeadsAreSmoothAndHaveTheirMeasures) {
  struct Measures {
    const Profile& rail;
    double top, shoulder, corner, corner_depth;  // ends of the arcs [mm]
  };
  // UIC 861-3 drawing 21.0 / 52.0; EN 13674-1:2017, 60E1 (fitted arcs of both: 1e-6 mm).
  for (const Measures& m : {Measures{RailUic60(), 10.5, 25.988023, 36.0, 14.259738},
                            Measures{Rail60E1(), 10.228, 26.0265, 35.999811, 14.299958}}) {
    SCOPED_TRACE(m.rail.name());
    ASSERT_EQ(Joints(m.rail).size(), 6u);
    EXPECT_NEAR(Joints(m.rail)[3], m.top * kMm, 1e-9);
    EXPECT_NEAR(Joints(m.rail)[4], m.shoulder * kMm, 1e-9);
    EXPECT_NEAR(Joints(m.rail)[5], m.corner * kMm, 1e-9);
    EXPECT_NEAR(m.rail.Eval(Joints(m.rail)[5]).z, -m.corner_depth * kMm, 1e-9);
    EXPECT_TRUE(Kinks(m.rail).empty());
    EXPECT_NEAR(m.rail.Eval(0).z, 0, 1e-16);
    for (double y = 0; y < 0.036; y += 0.0007) EXPECT_DOUBLE_EQ(m.rail.Eval(y).z, m.rail.Eval(-y).z);
    EXPECT_NEAR(m.rail.Eval(0.036001).slope, -20, 1e-9);
  }
}

TEST(StandardProfiles, AreFoundByName) {
  EXPECT_EQ(FindStandardProfile("S1002"), &WheelS1002());
  EXPECT_EQ(FindStandardProfile("UIC60"), &RailUic60());
  EXPECT_EQ(FindStandardProfile("60E1"), &Rail60E1());
  EXPECT_EQ(FindStandardProfile("54E1"), nullptr);
}

TEST(PlaceRail, CantsTheHeadAndMeasuresTheGaugeBelowItsHighestPoint) {
  const Profile rail = PlaceRail(RailUic60(), NominalTrack());
  // Ends of the arcs of the canted head by trigonometry, and the highest point above the R 300 arc's centre [mm].
  const std::array<double, 6> joints{717.408508, 727.117287, 742.548755, 763.542196, 779.077099, 789.386019};
  ASSERT_EQ(Joints(rail).size(), joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) EXPECT_NEAR(Joints(rail)[i], joints[i] * kMm, 1e-9);
  EXPECT_NEAR(rail.Eval(0.760538539).z, 0, 1e-15);
  EXPECT_NEAR(rail.Eval(0.760538539).slope, 0, 1e-8);
  EXPECT_NEAR(rail.Eval(0.7175).z, -0.014, 1e-14);  // gauge face: half of 1435 mm, 14 mm down
  EXPECT_TRUE(Kinks(rail).empty());

  TrackGeometry wider = NominalTrack();
  wider.rail_offset = 0.0016;
  EXPECT_NEAR(PlaceRail(RailUic60(), wider).Eval(0.7191).z, -0.014, 1e-14);
}

TEST(PlaceRail, RefusesAHeadThatEndsAboveTheGaugeFace) {
  EXPECT_THROW(PlaceRail(RailUic60().Cut(-0.03, 0.03), NominalTrack()), std::invalid_argument);
}

/// Points of a curve in a format of two columns [mm].
std::string Text(const Profile& profile, double y_from, double y_to, double step, double y_sign, double z_sign) {
  std::string text = "# points\n";
  for (double y = y_from; y <= y_to; y += step) {
    text += std::to_string(y_sign * y * 1e3) + "\t" + std::to_string(z_sign * profile.Eval(y).z * 1e3) + "\r\n";
  }
  return text;
}

TEST(ProfileFile, FindsTheAxesOfAWheel) {
  for (const double y_sign : {1.0, -1.0}) {
    for (const double z_sign : {1.0, -1.0}) {
      const std::string text = Text(WheelS1002(), -0.069, 0.06, 2e-4, y_sign, z_sign);
      const ProfilePoints points = ParseProfilePoints(text, "wheel.dat", ProfileKind::kWheel);
      EXPECT_EQ(points.size(), 646u);
      for (const auto& [y, z] : points) EXPECT_NEAR(z, WheelS1002().Eval(y).z, 3e-9);  // six decimals, slope up to 4
    }
  }
}

TEST(ProfileFile, TakesPointsThatStandTwiceAndAByteOrderMark) {
  const std::string text = Text(WheelS1002(), -0.069, 0.06, 2e-4, 1, 1);
  std::string twice = "\xef\xbb\xbf";
  for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
    end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin + 1);
    twice += line + line;
  }
  EXPECT_EQ(ParseProfilePoints(twice, "wheel.dat", ProfileKind::kWheel),
            ParseProfilePoints(text, "wheel.dat", ProfileKind::kWheel));
}

TEST(ProfileFile, TakesStatedAxes) {
  // A rail whose gauge side is lower: stated to run the other way, it comes back mirrored.
  const Profile rail("tilted", {ProfilePiece::Polynomial(-0.03, 0.03, 0, std::array{0.0, 0.1, -5.0})});
  const std::string text = Text(rail, -0.03, 0.03, 1e-3, 1, 1);
  const ProfilePoints detected = ParseProfilePoints(text, "rail.dat", ProfileKind::kRail);
  const ProfilePoints mirrored =
      ParseProfilePoints(text, "rail.dat", ProfileKind::kRail,
                         {.lateral = ProfileAxes::Lateral::kGauge, .vertical = ProfileAxes::Vertical::kUp});
  EXPECT_NEAR(detected.front().second, rail.Eval(-0.03).z, 1e-9);
  EXPECT_NEAR(mirrored.back().second, rail.Eval(-0.03).z, 1e-9);
}

TEST(ProfileFile, LeavesOutAnOverhang) {
  // A flange back that runs vertically and then under itself.
  std::string text = "-69.0 0\n-70.2 -5\n-70.1 -10\n-70.0 -15\n-69.0 -20\n";
  text += Text(WheelS1002(), -0.0685, 0.06, 5e-4, 1, 1);
  const ProfilePoints points = ParseProfilePoints(text, "wheel.dat", ProfileKind::kWheel);
  EXPECT_NEAR(points.front().first, -0.0702, 1e-12);
}

std::string FaultOf(const std::string& text, ProfileKind kind = ProfileKind::kWheel) {
  try {
    ParseProfilePoints(text, "bad.prw", kind);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

TEST(ProfileFile, SaysWhereAFileIsWrong) {
  const std::string good = Text(WheelS1002(), -0.06, 0.06, 1e-3, 1, 1);
  EXPECT_EQ(FaultOf("1 2\n3 x\n"), "bad.prw:2: expected a finite number, found \"x\"");
  EXPECT_EQ(FaultOf("1 2\n3\n"), "bad.prw:2: expected two numbers, y and z, found \"3\"");
  EXPECT_EQ(FaultOf("1 nan\n"), "bad.prw:1: expected a finite number, found \"nan\"");
  EXPECT_EQ(FaultOf("1 2\n2 3 # short\n"), "bad.prw: expected at least 10 points, found 2");
  EXPECT_EQ(FaultOf("600 2\n"), "bad.prw:1: expected a length below 500 mm, found 600 mm");
  EXPECT_EQ(FaultOf(Text(WheelS1002(), -6e-5, 6e-5, 1e-6, 1, 1)),
            "bad.prw: expected a profile at least 20 mm wide, found 0.12 mm (lengths are in mm)");
  EXPECT_THAT(FaultOf(good + "57 2.43\n"), HasSubstr("bad.prw:122: expected points along the curve in one direction"));
  const std::string simpack = "header.begin\n type = 0 ! rail\nheader.end\nspline.begin\n";
  EXPECT_EQ(FaultOf(simpack), "bad.prw:2: expected the profile of a wheel, type = 1, found type = 0");
  EXPECT_EQ(FaultOf("spline.begin\n shift.y = 0.5\n"),
            "bad.prw:2: expected shift.y = 0 (points as they shall be used), found \"0.5\"");
  EXPECT_EQ(FaultOf("spline.begin\n units.len.f = 0\n"), "bad.prw:2: expected units.len.f > 0, found \"0\"");
  EXPECT_THROW(ReadProfilePoints("/no/such/file.prw", ProfileKind::kWheel), InputError);
}

TEST(FitProfile, PassesThroughPointsWithoutSmoothing) {
  ProfilePoints points;
  for (double y = -0.02; y <= 0.02; y += 3e-4) points.emplace_back(y, 1e-3 * std::sin(300 * y));
  const Profile profile = FitProfile("sine", points, 0);
  for (const auto& [y, z] : points) EXPECT_NEAR(profile.Eval(y).z, z, 1e-16);
  // Between the points, away from the natural ends: 5/384 h^4 z'''' = 5/384 (3e-4)^4 8e6 = 8e-10 m times 1/6 at the
  // worst for equal steps; for the curvature h^2/12 z'''' = 0.06 1/m of 90.
  for (double y = -0.015; y <= 0.015; y += 1e-4) {
    EXPECT_NEAR(profile.Eval(y).z, 1e-3 * std::sin(300 * y), 4e-10);
    EXPECT_NEAR(profile.Eval(y).second, -90 * std::sin(300 * y), 0.1);
  }
  EXPECT_TRUE(Kinks(profile).empty());
}

TEST(FitProfile, LeavesTheStatedDeviationAndKeepsCurvatureUsable) {
  // An arc of radius 300 mm, heights known to 10 um every 0.2 mm.
  constexpr double kSigma = 10e-6;
  const Profile arc("arc", {ProfilePiece::UpperArc(-0.03, 0.03, 0, -0.3, 0.3)});
  std::mt19937 generator(20240501);
  std::normal_distribution<double> noise(0, kSigma);
  ProfilePoints points;
  for (double y = -0.0299; y < 0.03; y += 2e-4) points.emplace_back(y, arc.Eval(y).z + noise(generator));
  const Profile fitted = FitProfile("noisy arc", points, kSigma);
  double sum = 0;
  double worst_curvature = 0;
  for (const auto& [y, z] : points) {
    if (!fitted.Contains(y)) continue;
    const double d = fitted.Eval(y).z - z;
    sum += d * d;
    if (std::abs(y) < 0.02) worst_curvature = std::max(worst_curvature, std::abs(fitted.Eval(y).Curvature() + 1 / 0.3));
  }
  EXPECT_NEAR(std::sqrt(sum / static_cast<double>(points.size())), kSigma, 0.02 * kSigma);
  EXPECT_LT(worst_curvature, 1.5);  // of 3.33 1/m; differences of the raw points have 600 1/m
}

TEST(FitProfile, KeepsAStraightLineAtAnySmoothing) {
  ProfilePoints points;
  for (double y = -0.02; y <= 0.02; y += 5e-4) points.emplace_back(y, 0.01 + y / 15);
  const Profile line = FitProfile("line", points, 1e-6);
  for (double y = -0.019; y <= 0.019; y += 1e-4) {
    EXPECT_NEAR(line.Eval(y).z, 0.01 + y / 15, 1e-11);  // conditioning of the smoothing matrix at its largest lambda
    EXPECT_NEAR(line.Eval(y).slope, 1.0 / 15, 1e-8);
  }
}

}  // namespace
}  // namespace uiclink
