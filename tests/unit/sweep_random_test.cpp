// The counter-based generator, and the distributions that are drawn with it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "vehicle/sweep/campaign.h"
#include "vehicle/sweep/counter_random.h"

namespace uiclink {
namespace {

using testing::ElementsAre;

TEST(Philox, GivesThePublishedWords) {
  // Known answers for philox4x32-10 of the authors' Random123 library (kat_vectors).
  EXPECT_THAT(CalcPhilox({0, 0, 0, 0}, {0, 0}), ElementsAre(0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8));
  EXPECT_THAT(CalcPhilox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
              ElementsAre(0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd));
  EXPECT_THAT(CalcPhilox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
              ElementsAre(0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1));
}

TEST(CounterRandom, DependsOnSeedSampleAndPurposeAlone) {
  const auto first = [](std::uint64_t seed, std::uint32_t sample, const char* purpose) {
    return CounterRandom(seed, sample, purpose).Uniform();
  };
  EXPECT_EQ(first(7, 3, "speed"), first(7, 3, "speed"));
  EXPECT_NE(first(7, 3, "speed"), first(8, 3, "speed"));
  EXPECT_NE(first(7, 3, "speed"), first(7 + (1ull << 32), 3, "speed"));
  EXPECT_NE(first(7, 3, "speed"), first(7, 4, "speed"));
  EXPECT_NE(first(7, 3, "speed"), first(7, 3, "friction"));
}

struct Moments {
  double mean = 0, std = 0, low = 1e300, high = -1e300;
};

Moments Draw(const Distribution& distribution, std::uint32_t samples) {
  Moments moments;
  double squares = 0;
  for (std::uint32_t i = 0; i < samples; ++i) {
    const double value = std::get<double>(distribution.Draw(CounterRandom(1, i, "test")));
    moments.mean += value / samples;
    squares += value * value / samples;
    moments.low = std::min(moments.low, value);
    moments.high = std::max(moments.high, value);
  }
  moments.std = std::sqrt(squares - moments.mean * moments.mean);
  return moments;
}

constexpr std::uint32_t kSamples = 40000;
// Four standard errors of a mean, and of a standard deviation (normal law: std / sqrt(2n); wider for the log-normal).
double MeanError(double std) { return 4 * std / std::sqrt(kSamples); }
double StdError(double std) { return 4 * std / std::sqrt(kSamples); }

TEST(Distribution, HasTheMomentsThatItSays) {
  using Law = Distribution::Law;
  const Moments uniform =
      Draw({.law = Law::kUniform, .a = 10, .b = 14, .low = 0, .high = 100, .choices = {}}, kSamples);
  EXPECT_NEAR(uniform.mean, 12, MeanError(4 / std::sqrt(12)));
  EXPECT_NEAR(uniform.std, 4 / std::sqrt(12), StdError(4 / std::sqrt(12)));
  EXPECT_GE(uniform.low, 10);
  EXPECT_LE(uniform.high, 14);
  const Moments normal = Draw({.law = Law::kNormal, .a = 5, .b = 2, .low = -100, .high = 100, .choices = {}}, kSamples);
  EXPECT_NEAR(normal.mean, 5, MeanError(2));
  EXPECT_NEAR(normal.std, 2, StdError(2));
  const Moments skew = Draw({.law = Law::kLogNormal, .a = 5, .b = 2, .low = 0, .high = 1000, .choices = {}}, kSamples);
  EXPECT_NEAR(skew.mean, 5, MeanError(2));
  EXPECT_NEAR(skew.std, 2, 2 * StdError(2));
  EXPECT_GT(skew.low, 0);
}

TEST(Distribution, KeepsToItsBounds) {
  const Distribution law{.law = Distribution::Law::kNormal, .a = 5, .b = 2, .low = 4, .high = 5, .choices = {}};
  const Moments moments = Draw(law, 1000);
  EXPECT_GE(moments.low, 4);
  EXPECT_LE(moments.high, 5);
  const Distribution nowhere{.law = Distribution::Law::kNormal, .a = 5, .b = 0.1, .low = 50, .high = 60, .choices = {}};
  EXPECT_THROW(nowhere.Draw(CounterRandom(1, 0, "test")), std::runtime_error);
}

TEST(Distribution, ChoosesEveryChoiceEquallyOften) {
  const Distribution law{.law = Distribution::Law::kChoice,
                         .choices = {AxisValue("a"), AxisValue("b"), AxisValue("c")}};
  std::map<AxisValue, int> counts;
  for (std::uint32_t i = 0; i < kSamples; ++i) ++counts[law.Draw(CounterRandom(1, i, "test"))];
  ASSERT_EQ(counts.size(), 3u);
  const double expected = kSamples / 3.0;
  for (const auto& [value, count] : counts) EXPECT_NEAR(count, expected, 4 * std::sqrt(expected)) << FormatValue(value);
}

}  // namespace
}  // namespace uiclink
