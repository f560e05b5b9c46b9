// The patch tracker on still pictures whose places are known exactly.

#include "identify/track/patch_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

#include "identify/track/coarse_search.h"
#include "identify/track/follower.h"
#include "tests/support/film_maker.h"

namespace uiclink::track {
namespace {

constexpr int kWidth = 120, kHeight = 100;
constexpr Box kBox{40, 30, 40, 36};

/// A picture of grey levels with its memory.
struct Picture {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth * kHeight);
  GrayView View() const { return {pixels.data(), kWidth, kHeight, kWidth}; }
};

/// The scene moved by `shift` and turned about the middle of kBox; contrast, brightness and noise in grey levels.
struct Camera {
  Mosaic scene{kWidth + 40, kHeight + 40, SoftSpots(kWidth + 40, kHeight + 40, 5, 128, 90, 11)};
  std::mt19937_64 random{5};

  Picture Shoot(Point shift, double turn = 0, double gain = 1, double offset = 0, double noise = 0) {
    Picture picture;
    std::normal_distribution<double> error(0, 1);
    const Point middle = kBox.Centre();
    const double c = std::cos(turn), s = std::sin(turn);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const double dx = x - middle.x - shift.x, dy = y - middle.y - shift.y;
        const double light = scene.PixelAt(c * dx + s * dy + middle.x + 20, -s * dx + c * dy + middle.y + 20);
        const double level = gain * light + offset + (noise > 0 ? noise * error(random) : 0);
        picture.pixels[static_cast<std::size_t>(y * kWidth + x)] =
            static_cast<std::uint8_t>(std::clamp(std::lround(level), 0l, 255l));
      }
    }
    return picture;
  }
};

Point Error(const PatchFit& fit, Point shift) { return fit.place - kBox.Centre() - shift; }

TEST(PatchTracker, HasHardlyAnyPixelLocking) {
  Camera camera;
  const Picture reference = camera.Shoot({0.3, 0.1});  // a part of a pixel in the reference as well
  const PatchTracker tracker(reference.View(), kBox, {});
  double largest = 0;
  for (int i = 0; i <= 20; ++i) {
    const Point shift{0.05 * i, 2 + 0.05 * i};
    const auto fit = tracker.Find(camera.Shoot(shift + Point{0.3, 0.1}).View(), kBox.Centre() + Point{0, 2}, 0);
    ASSERT_TRUE(fit);
    largest = std::max({largest, std::abs(Error(*fit, shift).x), std::abs(Error(*fit, shift).y)});
  }
  // Rounding to grey levels (0.3) over a thousand pixels of slope 10 is 0.001 pixel; cubic interpolation of a smoothed
  // picture measures 0.004 in all, bilinear would be 0.05.
  EXPECT_LT(largest, 0.008);
  RecordProperty("largest_bias_pixel_1e6", static_cast<int>(1e6 * largest));
}

TEST(PatchTracker, SaysHowFarItIsWrongUnderNoise) {
  Camera camera;
  const PatchTracker tracker(camera.Shoot({0, 0}).View(), kBox, {});
  for (const double noise : {2.0, 8.0}) {
    double squares = 0, said = 0;
    constexpr int kPictures = 150;
    for (int i = 0; i < kPictures; ++i) {
      const Point shift{0.37 + 0.01 * i, -0.2};
      const auto fit = tracker.Find(camera.Shoot(shift, 0, 1, 0, noise).View(), kBox.Centre() + shift, 0);
      ASSERT_TRUE(fit);
      squares += Dot(Error(*fit, shift), Error(*fit, shift));
      said += fit->covariance.xx + fit->covariance.yy;
    }
    // 300 errors know their own standard deviation to 4 %; the correlation across blocks is put in to about as much.
    EXPECT_NEAR(std::sqrt(said / squares), 1, 0.15) << "noise " << noise;
    // The bound for white noise: smoothing by 0.8 pixel costs a tenth of what the
    // patch knows; 0.004 pixel of interpolation along each axis.
    EXPECT_LT(std::sqrt(squares / kPictures),
              std::hypot(0.006, 1.2 * std::sqrt(2) * noise * tracker.PixelsPerGreyLevel()));
  }
}

TEST(PatchTracker, FollowsTurnContrastAndBrightness) {
  Camera camera;
  const PatchTracker tracker(camera.Shoot({0, 0}).View(), kBox, {});
  const auto fit = tracker.Find(camera.Shoot({1.3, -0.7}, 0.05, 0.7, 20).View(), kBox.Centre(), 0);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(Error(*fit, {1.3, -0.7}).x, 0, 0.01);  // the turned mosaic's pixels are squares along the scene's axes
  EXPECT_NEAR(Error(*fit, {1.3, -0.7}).y, 0, 0.01);
  EXPECT_NEAR(fit->angle, 0.05, 1e-3);
  EXPECT_NEAR(fit->gain, 0.7, 0.01);
  EXPECT_GT(fit->score, 0.995);
}

TEST(PatchTracker, IsNotPulledByWhatCoversAQuarterOfIt) {
  Camera camera;
  const PatchTracker tracker(camera.Shoot({0, 0}).View(), kBox, {});
  Picture covered = camera.Shoot({1.25, 0.5});
  for (int y = 0; y < kHeight; ++y)
    for (int x = 72; x < kWidth; ++x) covered.pixels[static_cast<std::size_t>(y * kWidth + x)] = 200;
  const auto fit = tracker.Find(covered.View(), kBox.Centre() + Point{1, 0}, 0);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(Error(*fit, {1.25, 0.5}).x, 0, 0.05);
  EXPECT_NEAR(Error(*fit, {1.25, 0.5}).y, 0, 0.05);
  EXPECT_LT(fit->inliers, 0.9);
}

TEST(PatchTracker, FindsNothingWhereThereIsNothing) {
  Camera camera;
  const PatchTracker tracker(camera.Shoot({0, 0}).View(), kBox, {});
  const Picture wall{std::vector<std::uint8_t>(kWidth * kHeight, 120)};
  EXPECT_FALSE(tracker.Find(wall.View(), kBox.Centre(), 0));
  EXPECT_FALSE(tracker.Find(camera.Shoot({0, 0}).View(), {5, 5}, 0));  // half outside of the picture
  EXPECT_TRUE(std::isinf(PatchTracker(wall.View(), kBox, {}).PixelsPerGreyLevel()));
  EXPECT_THROW(PatchTracker(wall.View(), {1, 1, 40, 40}, {}), std::invalid_argument);
  EXPECT_THROW(PatchTracker(wall.View(), {50, 50, 8, 40}, {}), std::invalid_argument);
}

TEST(CoarseSearch, FindsThePatchAndItsTwin) {
  Camera camera;
  const Picture reference = camera.Shoot({0, 0});
  const CoarseSearch search(reference.View(), kBox);
  const auto found = search.Find(camera.Shoot({23, -11}).View(), kBox.Centre(), 30);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->best.place.x, kBox.Centre().x + 23, 0.7);  // reduced by two: half of its pixels and a little
  EXPECT_NEAR(found->best.place.y, kBox.Centre().y - 11, 0.7);
  EXPECT_TRUE(!found->rival || found->rival->score < 0.7);

  Picture twin = reference;  // the patch a second time, 38 pixels to the left
  for (int y = kBox.y; y < kBox.y + kBox.height; ++y)
    for (int x = kBox.x; x < kBox.x + kBox.width; ++x)
      twin.pixels[static_cast<std::size_t>(y * kWidth + x - 38)] =
          twin.pixels[static_cast<std::size_t>(y * kWidth + x)];
  const auto two = search.Find(twin.View(), kBox.Centre(), 45);
  ASSERT_TRUE(two && two->rival);
  EXPECT_GT(std::min(two->best.score, two->rival->score), 0.9);
  EXPECT_NEAR(std::abs(two->best.place.x - two->rival->place.x), 38, 1.5);
}

TEST(Follower, LeavesOutWhatTwoPlacesMayBe) {
  Camera camera;
  const Picture reference = camera.Shoot({0, 0});
  Follower follower(reference.View(), kBox, {});
  ASSERT_TRUE(follower.Follow(reference.View()).fit);
  // The patch jumps, and stands at two places at once.
  Picture two{std::vector<std::uint8_t>(kWidth * kHeight, 128)};
  for (const int shift : {-12, 30})
    for (int y = kBox.y; y < kBox.y + kBox.height; ++y)
      for (int x = kBox.x + 10; x < kBox.x + kBox.width; ++x)
        two.pixels[static_cast<std::size_t>(y * kWidth + x + shift)] =
            reference.pixels[static_cast<std::size_t>(y * kWidth + x)];
  const Picture wall{std::vector<std::uint8_t>(kWidth * kHeight, 120)};
  EXPECT_EQ(follower.Follow(wall.View()).why, LeftOut::kLost);
  EXPECT_EQ(follower.Follow(wall.View()).why, LeftOut::kLost);
  EXPECT_EQ(follower.Follow(two.View()).why, LeftOut::kAmbiguous);
  EXPECT_TRUE(follower.Follow(camera.Shoot({9, 4}).View()).fit);  // found again
}

}  // namespace
}  // namespace uiclink::track
