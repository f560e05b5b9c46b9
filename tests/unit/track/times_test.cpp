// Time stamps of containers, and what the motion itself says about them.

#include "identify/track/times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

#include "identify/track/order.h"

namespace uiclink::track {
namespace {

using Stamps = std::vector<std::optional<double>>;

TEST(Times, StampsRoundedToMillisecondsAreAnEvenGrid) {
  Stamps stamps;
  for (int i = 0; i < 300; ++i) stamps.push_back(1e-3 * std::round(1e3 * i * 1001 / 30000.0));  // 29.97 Hz in Matroska
  const PictureTimes times = JudgeTimes(stamps, {});
  EXPECT_TRUE(times.even);
  EXPECT_TRUE(times.gaps.empty());
  // 300 roundings of up to 0.5 ms leave 1e-6 s of the step.
  EXPECT_NEAR(times.step, 1001 / 30000.0, 2e-6);
  for (int i = 0; i < 300; ++i) EXPECT_NEAR(*times.t[static_cast<std::size_t>(i)], i * 1001 / 30000.0, 2e-4);
}

TEST(Times, MissingPicturesAreCountedAndNotFilled) {
  Stamps stamps;
  for (int i = 0; i < 100; ++i)
    if (i != 40 && i != 70 && i != 71) stamps.push_back(0.5 + 0.02 * i);
  const PictureTimes times = JudgeTimes(stamps, {});
  EXPECT_TRUE(times.even);
  ASSERT_EQ(times.gaps.size(), 2u);
  EXPECT_EQ(times.gaps[0].before, 39u);
  EXPECT_EQ(times.gaps[0].pictures, 1);
  EXPECT_EQ(times.gaps[1].pictures, 2);
  EXPECT_NEAR(*times.t[40], 0.5 + 0.02 * 41, 1e-9);
}

TEST(Times, VariableRateIsTakenAsItIs) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> step(0.012, 0.028);
  Stamps stamps{0.0};
  for (int i = 1; i < 100; ++i) stamps.push_back(*stamps.back() + (i == 50 ? 0.09 : step(random)));
  const PictureTimes times = JudgeTimes(stamps, {});
  EXPECT_FALSE(times.even);
  for (std::size_t i = 0; i < stamps.size(); ++i) EXPECT_EQ(times.t[i], stamps[i]);
  ASSERT_EQ(times.gaps.size(), 1u);
  EXPECT_EQ(times.gaps[0].before, 49u);
  EXPECT_FALSE(times.gaps[0].pictures);
  EXPECT_EQ(times.notices.size(), 1u);
}

TEST(Times, StampsThatRunBackwardsGiveNoTime) {
  Stamps stamps;
  for (int i = 0; i < 50; ++i) stamps.push_back(0.02 * i);
  stamps[20] = 0.1;
  const PictureTimes times = JudgeTimes(stamps, {});
  EXPECT_EQ(times.backwards, 1);
  EXPECT_FALSE(times.t[20]);
  EXPECT_NEAR(*times.t[21], 0.42, 1e-9);
  EXPECT_TRUE(times.gaps.empty());  // the picture is there, only its time is not
}

TEST(Times, LastPicturesWithoutAStampGoOnEvenly) {
  Stamps stamps;
  for (int i = 0; i < 50; ++i) stamps.push_back(i < 47 ? std::optional(0.02 * i) : std::nullopt);
  const PictureTimes times = JudgeTimes(stamps, {});
  EXPECT_EQ(times.continued, 3);
  EXPECT_NEAR(*times.t[49], 0.98, 1e-9);
  EXPECT_EQ(times.notices.size(), 1u);
  for (int i = 0; i < 47; ++i) *stamps[static_cast<std::size_t>(i)] += 0.004 * std::sin(i);  // now uneven
  EXPECT_FALSE(JudgeTimes(stamps, {}).t[49]);
}

TEST(Times, AGivenRateReplacesThem) {
  const PictureTimes times = JudgeTimes(Stamps(10, std::nullopt), 120.0);
  EXPECT_NEAR(*times.t[9], 9 / 120.0, 1e-15);
  EXPECT_THROW(JudgeTimes(Stamps(1, 0.0), {}), std::invalid_argument);
}

/// A decay of 150 pixels at 1 Hz; samples that are dropped do not move the times of the others.
MotionSeries Swing(double rate, const std::vector<int>& dropped, double noise = 0.03) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> error(0, noise);
  MotionSeries motion;
  for (int i = 0; i < 6 * rate; ++i) {
    if (std::find(dropped.begin(), dropped.end(), i) != dropped.end()) continue;
    const double t = i / rate;
    motion.t.push_back(static_cast<double>(motion.t.size()) / rate);
    motion.x.push_back(150 * std::exp(-0.2 * t) * std::cos(2 * M_PI * t) + error(random));
    motion.sigma.push_back(noise);
  }
  return motion;
}

TEST(Order, MissingPicturesWithoutATraceAreFound) {
  for (const double rate : {25.0, 50.0, 120.0}) {
    EXPECT_TRUE(FindHiddenGaps(Swing(rate, {}), 1 / rate).empty()) << rate;
    const int a = static_cast<int>(1.23 * rate), b = static_cast<int>(3.3 * rate);
    const std::vector<HiddenGap> gaps = FindHiddenGaps(Swing(rate, {a, b, b + 1}), 1 / rate);
    ASSERT_EQ(gaps.size(), 2u) << rate;
    EXPECT_EQ(gaps[0].at, static_cast<std::size_t>(a));
    EXPECT_EQ(gaps[0].pictures, 1);
    EXPECT_EQ(gaps[1].at, static_cast<std::size_t>(b - 1));
    EXPECT_EQ(gaps[1].pictures, 2);
  }
}

TEST(Order, RepeatedPicturesAreFoundAndReversalsAreNone) {
  MotionSeries motion = Swing(50, {});
  EXPECT_TRUE(FindRepeated(motion).empty());
  motion.x[62] = motion.x[61] + 0.01;
  motion.x[140] = motion.x[139];
  EXPECT_THAT(FindRepeated(motion), testing::ElementsAre(62, 140));
}

TEST(Order, ScatterBeyondTheirOwnErrorIsSeen) {
  MotionSeries motion = Swing(50, {}, 0.1);
  for (double& sigma : motion.sigma) sigma = 0.02;
  double squares = 0;
  for (const double e : CalcExcessScatter(motion)) squares += e * e;
  // sqrt(0.1^2 - 0.02^2) = 0.098; the median of a variance with four degrees of freedom is 0.84 of its mean.
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(motion.t.size())), 0.09, 0.02);
}

}  // namespace
}  // namespace uiclink::track
