// The camera's motion from made-up tracks of background patches.

#include "identify/track/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace uiclink::track {
namespace {

constexpr int kPictures = 200;
constexpr double kSigma = 0.02;

struct Scene {
  std::mt19937_64 random{3};
  std::vector<BackgroundTrack> tracks;
  Point middle{320, 180};

  static Point ShiftAt(int i) { return {3 * std::sin(0.31 * i), 2 * std::cos(0.17 * i)}; }
  static double TurnAt(int i) { return 0.004 * std::sin(0.23 * i); }

  /// What a place of the scene is seen at.
  Point See(Point place, int i, bool shifts, bool turns) const {
    const double a = turns ? TurnAt(i) : 0;
    const Point arm = place - middle, shift = shifts ? ShiftAt(i) : Point{};
    return middle + shift + Point{std::cos(a) * arm.x - std::sin(a) * arm.y, std::sin(a) * arm.x + std::cos(a) * arm.y};
  }

  void Add(Point place, bool shifts, bool turns, Point swing = {}) {
    std::normal_distribution<double> noise(0, kSigma);
    BackgroundTrack track{.box = {static_cast<int>(place.x) - 16, static_cast<int>(place.y) - 16, 33, 33},
                          .sightings = {}};
    for (int i = 0; i < kPictures; ++i) {
      const Point at = See(track.box.Centre() + std::sin(0.13 * i) * swing, i, shifts, turns);
      const PatchFit fit{.place = {at.x + noise(random), at.y + noise(random)},
                         .covariance = {kSigma * kSigma, 0, kSigma * kSigma}};
      track.sightings.push_back({.fit = fit, .why = LeftOut::kNot});
    }
    tracks.push_back(track);
  }
  void AddFour(bool shifts, bool turns) {
    for (const Point p : {Point{60, 50}, Point{580, 60}, Point{70, 300}, Point{560, 310}}) Add(p, shifts, turns);
  }
};

TEST(Camera, StillBackgroundTakesNothingOff) {
  Scene scene;
  scene.AddFour(false, false);
  const CameraMotion camera = FitCamera(scene.tracks, 80, {320, 180});
  EXPECT_EQ(camera.model, CameraModel::kStill);
  PlaceCovariance covariance;
  EXPECT_EQ(camera.ToReference(7, {100, 90}, &covariance)->x, 100);
  EXPECT_EQ(covariance.xx, 0);
  EXPECT_NEAR(camera.disagreement, kSigma, 0.3 * kSigma);
}

TEST(Camera, ShiftAndTurnAreTakenOffWithTheirError) {
  for (const bool turns : {false, true}) {
    Scene scene;
    scene.AddFour(true, turns);
    const CameraMotion camera = FitCamera(scene.tracks, 80, {400, 180});
    ASSERT_EQ(camera.model, turns ? CameraModel::kShiftAndTurn : CameraModel::kShift);
    double squares = 0, said = 0, mean_x = 0, mean_y = 0;
    std::vector<Point> errors;
    for (int i = 0; i < kPictures; ++i) {
      PlaceCovariance covariance;
      const Point error = *camera.ToReference(i, scene.See({400, 190}, i, true, turns), &covariance) - Point{400, 190};
      errors.push_back(error), mean_x += error.x / kPictures, mean_y += error.y / kPictures;
      said += covariance.xx + covariance.yy;
    }
    for (const Point e : errors) squares += std::pow(e.x - mean_x, 2) + std::pow(e.y - mean_y, 2);
    // Four patches of 0.02 pixel: 0.01 each way, a little more with a turn; the small angle's square is 4e-6 of 300.
    EXPECT_LT(std::sqrt(squares / kPictures), 0.025);
    EXPECT_NEAR(std::sqrt(said / squares), 1, 0.25);  // the patches' floor of 0.01 pixel makes it larger by a tenth
  }
}

TEST(Camera, PatchesOnWhatSwingsAreNoBackground) {
  Scene scene;
  scene.AddFour(true, false);
  for (const double x : {250.0, 300.0, 350.0, 400.0, 450.0})
    scene.Add({x, 180}, true, false, {100, 0});  // the majority
  scene.Add({200, 60}, true, false, {1.5, 0});   // a cable that sways
  const CameraMotion camera = FitCamera(scene.tracks, 70, {320, 180});
  EXPECT_EQ(camera.model, CameraModel::kShift);
  EXPECT_EQ(camera.used.size(), 4u);
  EXPECT_EQ(camera.unsteady.size(), 6u);
}

TEST(Camera, WithoutStillBackgroundItIsUnknown) {
  Scene scene;
  for (const double x : {100.0, 300.0, 500.0}) scene.Add({x, 180}, false, false, {100, 0});
  EXPECT_EQ(FitCamera(scene.tracks, 70, {320, 180}).model, CameraModel::kUnknown);
  EXPECT_EQ(FitCamera({}, 70, {320, 180}).model, CameraModel::kUnknown);
  for (BackgroundTrack& track : scene.tracks)
    for (std::size_t i = 0; i < 40; ++i) track.sightings[i] = {.fit = {}, .why = LeftOut::kLost};
  EXPECT_EQ(FitCamera(scene.tracks, 7000, {320, 180}).model, CameraModel::kUnknown);  // quiet enough, but covered
}

}  // namespace
}  // namespace uiclink::track
