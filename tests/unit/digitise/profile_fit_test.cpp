#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "identify/digitise/profile.h"

namespace uiclink::digitise {
namespace {

TEST(Profile, AStripeHoldsItsWidthOfInk) {
  for (const Profile profile : {Profile{1, 1, 0.4}, Profile{1, 3, 0.5}, Profile{0.8, 5, 1.2}}) {
    double ink = 0;
    for (double d = -12; d < 12; d += 0.01) ink += 0.01 * ShadeOf(profile, d).share;
    EXPECT_NEAR(ink, profile.amplitude * profile.width, 1e-3 * profile.width);  // tables of 3e-5, over some 10 px
  }
}

TEST(Profile, DerivativesAreThoseOfTheShares) {
  const Profile profile{0.9, 2.5, 0.6};
  const double h = 0.02;  // coarser than the tables' steps (0.6/64 px)
  for (double s1 = -3; s1 < 3; s1 += 0.37) {
    for (double s2 = -4; s2 < 4; s2 += 0.41) {
      if (std::abs(s1 - s2) < 0.1 || std::abs(std::abs(s1 - s2) - profile.width) < 0.1) continue;  // kinks of the union
      const Shade shade = ShadeOf(profile, s1, s2);
      const double by_first = (ShadeOf(profile, s1 + h, s2).share - ShadeOf(profile, s1 - h, s2).share) / (2 * h);
      const double by_second = (ShadeOf(profile, s1, s2 + h).share - ShadeOf(profile, s1, s2 - h).share) / (2 * h);
      EXPECT_NEAR(shade.by_first, by_first, 3e-3) << s1 << ' ' << s2;  // h^2/6 times third derivatives of 20
      EXPECT_NEAR(shade.by_second, by_second, 3e-3) << s1 << ' ' << s2;
    }
  }
}

TEST(Profile, TwoStripesOnEachOtherAreOne) {
  const Profile profile{1, 3, 0.5};
  for (double s = -3; s <= 3; s += 0.25) EXPECT_NEAR(ShadeOf(profile, s, s).share, ShadeOf(profile, s).share, 1e-12);
}

TEST(Profile, FitFindsWidthAndBlurAmongOutliers) {
  const Profile truth{1, 3, 0.7};
  std::vector<std::pair<float, float>> samples;
  for (int i = 0; i < 4000; ++i) {
    const double d = 4.0 * i / 4000;
    const double share = i % 7 == 0 ? 1.0 : ShadeOf(truth, d).share;  // every seventh pixel lies under another line
    samples.emplace_back(static_cast<float>(d), static_cast<float>(share));
  }
  const Profile fit = FitProfile(samples, {1, 2, 0.4});
  EXPECT_NEAR(fit.width, truth.width, 0.05 * truth.width);  // steps of the search: 5 % and 8 %
  EXPECT_NEAR(fit.blur, truth.blur, 0.10 * truth.blur);
}

}  // namespace
}  // namespace uiclink::digitise
