// Small films of known motions, followed from the file to the record.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "identify/track/overlay.h"
#include "identify/track/track.h"
#include "identify/track/track_report.h"
#include "tests/cli/temporary_folder.h"
#include "tests/support/film_maker.h"

namespace uiclink::track {
namespace {

using testing::HasSubstr;

constexpr double kMmPerPixel = 0.25;

/// A decaying swing of 60 pixels at 1.1 Hz along x.
Point Swing(double t) { return {60 * std::exp(-0.2 * t) * std::cos(2 * std::numbers::pi * 1.1 * t), 0}; }

/// Three seconds at 50 pictures a second, 400 x 240 pixels.
FilmSettings SmallFilm() {
  return {.width = 400,
          .height = 240,
          .rate_hz = 50,
          .pictures = 150,
          .object_width = 70,
          .object_height = 50,
          .object_at = {200.3, 120.2},
          .motion = Swing,
          .noise = 1,
          .codec = "mp4v"};
}

/// The object without its rim in the first picture.
Box Patch(const FilmSettings& s) {
  const Point at = TruePlace(s, s.times.empty() ? 0 : s.times[0]);
  return {static_cast<int>(std::lround(at.x)) - s.object_width / 2 + 4,
          static_cast<int>(std::lround(at.y)) - s.object_height / 2 + 4, s.object_width - 8, s.object_height - 8};
}

CameraShake Shake(double t) {
  return {{2.5 * std::sin(3.1 * t) + 1.2 * std::sin(17 * t + 1), 1.8 * std::cos(2.3 * t)}, 0.003 * std::sin(4 * t)};
}

class TrackFilmTest : public testing::Test {
 protected:
  TrackResult Track(const FilmSettings& s, TrackOptions options, const FilmFaults& faults = {}) {
    const std::filesystem::path film = Film(s, faults);
    if (!options.tag_mm) options.mm_per_pixel = kMmPerPixel;
    return TrackFilm(film, options);
  }
  std::filesystem::path Film(const FilmSettings& s, const FilmFaults& faults = {}) {
    const std::filesystem::path film =
        folder_.path() / (s.codec == "MJPG" || s.codec == "FFV1" ? "film.avi" : "film.mp4");
    MakeFilm(s, film, faults);
    return film;
  }
  std::string Refusal(const FilmSettings& s, const TrackOptions& options) {
    try {
      Track(s, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TemporaryFolder folder_;
};

/// rms of displacement minus truth about its mean, and what the record says of it [pixel].
struct Errors {
  double rms = 0, said = 0, largest = 0;
};

/// @param time_of  true time of each picture of the film [s].
Errors Compare(const TrackResult& result, const FilmSettings& s, const std::function<double(std::size_t)>& time_of) {
  std::vector<double> errors;
  double mean = 0, said = 0;
  const auto n = static_cast<double>(result.t.size());
  for (std::size_t i = 0; i < result.t.size(); ++i) {
    errors.push_back(result.FramePixels(result.y[i]) - Dot(s.motion(time_of(result.picture[i])), result.axis));
    mean += errors.back() / n;
    said += std::pow(result.FramePixels(result.uncertainty[i]), 2) / n;
  }
  Errors all{.rms = 0, .said = std::sqrt(said)};
  for (const double e : errors) {
    all.rms += (e - mean) * (e - mean) / n;
    all.largest = std::max(all.largest, std::abs(e - mean));
  }
  all.rms = std::sqrt(all.rms);
  return all;
}

Errors Compare(const TrackResult& result, const FilmSettings& s) {
  return Compare(result, s, [&](std::size_t i) { return static_cast<double>(i) / s.rate_hz; });
}

TEST_F(TrackFilmTest, CleanFilmIsReadToAHundredthOfAPixel) {
  FilmSettings s = SmallFilm();
  s.codec = "FFV1", s.noise = 0, s.pictures = 80;
  const TrackResult result = Track(s, {.roi = Patch(s)});
  EXPECT_EQ(result.t.size(), 80u);
  EXPECT_TRUE(result.warnings.empty());
  EXPECT_EQ(result.camera.model, CameraModel::kStill);
  const Errors errors = Compare(result, s);
  EXPECT_LT(errors.rms, 0.01);  // measured 0.004: interpolation
  EXPECT_LT(errors.largest, 0.03);
  EXPECT_LT(errors.rms, 1.5 * errors.said);
  EXPECT_EQ(result.shutter, 0.0);  // a flash
  EXPECT_EQ(result.shutter_loss, 0);
}

TEST_F(TrackFilmTest, MotionBlurIsFollowedAndTheShutterTold) {
  FilmSettings s = SmallFilm();
  s.rate_hz = 30, s.pictures = 90, s.exposure_s = 0.5 / 30;  // up to 7 pixels of blur, 14 a step
  s.codec = "MJPG";
  const TrackResult result = Track(s, {.roi = Patch(s)});
  EXPECT_EQ(result.t.size(), 90u);
  EXPECT_TRUE(result.warnings.empty());
  ASSERT_TRUE(result.shutter);
  EXPECT_NEAR(*result.shutter, 0.5, 0.13);                         // told to a quarter
  const double x = std::numbers::pi * 1.1 * *result.shutter / 30;  // w tau / 2
  EXPECT_NEAR(result.shutter_loss, 1 - std::sin(x) / x, 3e-5);
  EXPECT_LT(Compare(result, s).rms, 0.1);  // measured 0.04, half of which is the shutter's own loss
}

TEST_F(TrackFilmTest, FindsWhatSwingsByItself) {
  const FilmSettings s = SmallFilm();
  const TrackResult result = Track(s, {});
  const Point first = TruePlace(s, 0);
  EXPECT_LT(std::hypot(result.roi.Centre().x - first.x, result.roi.Centre().y - first.y), 20);
  EXPECT_LT(Compare(result, s).rms, 0.1);
  EXPECT_TRUE(result.warnings.empty());
}

TEST_F(TrackFilmTest, ShakenNoisyCompressedFilmsStayBelowATenthOfAPixel) {
  for (const char* codec : {"MJPG", "mp4v", "avc1"}) {
    FilmSettings s = SmallFilm();
    s.codec = codec, s.noise = 2, s.shake = Shake, s.pictures = 100;
    const TrackResult result = Track(s, {.roi = Patch(s)});
    EXPECT_EQ(result.camera.model, CameraModel::kShiftAndTurn) << codec;
    const Errors errors = Compare(result, s);
    EXPECT_LT(errors.rms, 0.1) << codec;  // measured 0.02 (MJPG) to 0.06 (H.264); promised 0.2
    EXPECT_GT(errors.said, 0.6 * errors.rms) << codec;
    EXPECT_LT(errors.said, 3 * errors.rms) << codec;
    EXPECT_TRUE(result.warnings.empty()) << codec << ": " << result.warnings[0];
  }
}

TEST_F(TrackFilmTest, TagGivesScaleAndDirections) {
  FilmSettings s = SmallFilm();
  s.object_width = s.object_height = 72;
  constexpr double kSide = 48;  // [pixel], 12 mm
  s.object = TagShade(7, kSide, {35.5, 35.5});
  const TrackResult result = Track(s, {.tag = true, .tag_mm = kSide * kMmPerPixel});
  EXPECT_EQ(result.tag_id, 7);
  // Corners are found to 0.05 pixel, the mean of many to less, of a side of 48.
  EXPECT_NEAR(result.mm_per_pixel, kMmPerPixel, 0.004 * kMmPerPixel);
  EXPECT_LT(Compare(result, s).rms, 0.1);
  EXPECT_THAT(Refusal(s, {.tag = true, .tag_id = 3}), HasSubstr("expected the tag 3 in the first picture, found 7"));

  s.motion = [](double t) { return Point{0, Swing(t).x}; };
  const TrackResult up = Track(s, {.tag = true, .axis = Axis::kY});
  EXPECT_EQ(up.axis.y, -1);
  EXPECT_GT(up.y[23], 0);  // half a period later the tag is above its start
  EXPECT_THAT(Track(s, {.tag = true, .axis = Axis::kX}).warnings, testing::Contains(HasSubstr("across the axis")));
}

TEST_F(TrackFilmTest, VariableTimeStampsAreTheContainers) {
  FilmSettings s = SmallFilm();
  std::vector<double> durations;
  double t = 0;
  for (int i = 0; i < s.pictures; ++i) {
    s.times.push_back(t);
    durations.push_back(1e-3 * std::round(1e3 * (0.02 + 0.006 * std::sin(0.9 * i))));
    t += durations.back();
  }
  const std::filesystem::path film = Film(s);
  Restamp(film, durations);
  const TrackResult result = TrackFilm(film, {.roi = Patch(s), .mm_per_pixel = kMmPerPixel});
  EXPECT_FALSE(result.times.even);
  ASSERT_EQ(result.t.size(), 150u);
  for (std::size_t i = 0; i < result.t.size(); ++i) EXPECT_NEAR(result.t[i], s.times[i], 1e-4);  // the file's ticks
  EXPECT_LT(Compare(result, s, [&](std::size_t i) { return s.times[i]; }).rms, 0.1);
}

TEST_F(TrackFilmTest, DroppedPicturesAreGapsWhetherTheStampsSayItOrNot) {
  const FilmSettings s = SmallFilm();
  const FilmFaults faults{.dropped = {63, 64}, .repeated = {110}};
  const TrackResult result = Track(s, {.roi = Patch(s)}, faults);  // the stamps go on evenly
  EXPECT_EQ(result.missing, 2);
  EXPECT_EQ(result.t.size(), 147u);
  ASSERT_EQ(result.left_out.size(), 1u);
  EXPECT_EQ(result.left_out[0].picture, 108u);
  EXPECT_EQ(result.left_out[0].why, LeftOut::kRepeated);
  for (std::size_t i = 0; i < result.t.size(); ++i) {
    const double truth = static_cast<double>(result.picture[i] + (result.picture[i] >= 63 ? 2 : 0)) / 50;
    EXPECT_NEAR(result.t[i], truth, 1e-9);
  }
  EXPECT_EQ(result.warnings.size(), 3u);  // the jump, the missing pictures, the repeated one
  EXPECT_THAT(FormatTrackComments(result), HasSubstr("# 2 pictures missing after picture 63 (1.24 s)"));

  std::vector<double> durations(148, 0.02);
  durations[62] = 0.06;
  const std::filesystem::path film = Film(s, {.dropped = {63, 64}});
  Restamp(film, durations);
  const TrackResult stamped = TrackFilm(film, {.roi = Patch(s), .mm_per_pixel = kMmPerPixel});
  EXPECT_EQ(stamped.missing, 2);
  EXPECT_NEAR(stamped.t[63], 65 / 50.0, 1e-4);
  EXPECT_EQ(stamped.warnings.size(), 1u);
}

TEST_F(TrackFilmTest, APatchThatLeavesThePictureIsLeftOutThere) {
  FilmSettings s = SmallFilm();
  s.object_at.x = 330;  // 330 + 55 + 35 > 400
  s.motion = [](double t) { return Point{-Swing(t).x, 0}; };
  const TrackResult result = Track(s, {.roi = Patch(s)});
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("the patch left the picture")));
  EXPECT_LT(result.t.size(), 145u);
  EXPECT_LT(Compare(result, s).rms, 0.1);  // what is kept is right
  EXPECT_LT(Compare(result, s).largest, 0.5);
}

TEST_F(TrackFilmTest, RefusesWhatItCannotTell) {
  FilmSettings s = SmallFilm();
  s.motion = [](double) { return Point{}; };
  s.plain_background = true, s.pictures = 60;
  const std::filesystem::path film = Film(s);
  const auto refusal = [&](TrackOptions options) -> std::string {
    options.mm_per_pixel = kMmPerPixel;
    try {
      TrackFilm(film, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal({}), HasSubstr("expected something that swings by more than 2 pixels, found nothing"));
  EXPECT_THAT(refusal({.roi = Box{380, 10, 40, 40}}), HasSubstr("within the picture of 400 x 240"));
  EXPECT_THAT(refusal({.tag = true}), HasSubstr("expected an ArUco or AprilTag marker"));
  EXPECT_THAT(refusal({.roi = Box{20, 20, 40, 40}}), HasSubstr("expected a patch with texture"));
  EXPECT_THAT(refusal({.roi = Patch(s), .background = Box{20, 20, 60, 60}}),
              HasSubstr("expected a still background with texture at --background"));
}

TEST_F(TrackFilmTest, RefusesAFilmWithoutThePatchAndWhatIsNoFilm) {
  FilmSettings s = SmallFilm();
  s.motion = [](double t) { return t < 0.3 ? Point{} : Point{1000, 0}; };
  s.pictures = 60;
  EXPECT_THAT(Refusal(s, {.roi = Patch(s)}), HasSubstr("expected the patch in most of the 60 pictures"));
  folder_.Write("text.mp4", "no film");
  for (const char* name : {"text.mp4", "none.mp4", "."})
    EXPECT_THROW(TrackFilm(folder_.path() / name, {.mm_per_pixel = 0.2}), InputError) << name;
  EXPECT_THROW(TrackFilm(folder_.path() / "none.mp4", {}), std::invalid_argument);
}

TEST_F(TrackFilmTest, TwoRegionsThatSwingAlikeAreRefusedUnlessOneIsChosen) {
  FilmSettings s = SmallFilm();
  s.object_at.y = 60;
  s.second = [](double t) { return Point{200 + 50 * std::cos(2 * std::numbers::pi * 1.4 * t), 180}; };
  EXPECT_THAT(Refusal(s, {}), HasSubstr("expected one region that swings most, found two that move differently"));
  EXPECT_LT(Compare(Track(s, {.roi = Patch(s)}), s).rms, 0.1);
  s.second = [](double t) { return Point{200 + 10 * std::cos(2 * std::numbers::pi * 1.4 * t), 180}; };
  EXPECT_LT(Compare(Track(s, {}), s).rms, 0.1);  // the weaker one does not matter
}

TEST_F(TrackFilmTest, ACameraThatSwingsAsFarAsTheMassIsSaid) {
  FilmSettings s = SmallFilm();
  s.shake = [](double t) { return CameraShake{{20 * std::sin(2 * std::numbers::pi * 0.9 * t), 0}, 0}; };
  s.motion = [](double t) { return Point{20 * std::cos(2 * std::numbers::pi * 1.3 * t), 0}; };
  const TrackResult result = Track(s, {.roi = Patch(s)});
  EXPECT_EQ(result.camera.model, CameraModel::kUnknown);
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("the background is unsteady")));
}

TEST_F(TrackFilmTest, ABackgroundThatSwingsWithTheMassIsSaid) {
  FilmSettings s = SmallFilm();
  s.shake = [](double t) { return CameraShake{0.1 * Swing(t), 0}; };  // the frame that holds camera and link gives way
  const TrackResult result = Track(s, {.roi = Patch(s)});
  EXPECT_THAT(result.warnings, testing::Contains(HasSubstr("the background moves with the patch")));
}

TEST_F(TrackFilmTest, OverlayAndJsonShowWhatWasRead) {
  const FilmSettings s = SmallFilm();
  const TrackResult result = Track(s, {.roi = Patch(s)});
  const std::filesystem::path overlay = folder_.path() / "overlay.png";
  WriteOverlay(result, overlay);
  EXPECT_GT(std::filesystem::file_size(overlay), 10'000u);
  EXPECT_THROW(WriteOverlay(result, folder_.path() / "overlay.xyz"), InputError);
  EXPECT_THAT(FormatTrackJson(result), HasSubstr("\"schema\": \"track/1\""));
  EXPECT_THAT(FormatTrack(result), HasSubstr("150 samples of 150 pictures (400 x 240)"));
}

}  // namespace
}  // namespace uiclink::track
