// The search for what a model lacks: lines of a spectrum, and trials of effects that are really there.

#include "identify/effect_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "identify/start_grid.h"
#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

struct Tone {
  double hz = 0, amplitude = 0, decay = 0, phase = 0.4;
};

std::vector<float> MakeSeries(std::size_t size, double rate, const std::vector<Tone>& tones, unsigned seed,
                              double noise = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, noise);
  std::vector<float> x;
  for (std::size_t i = 0; i < size; ++i) {
    const double t = static_cast<double>(i) / rate;
    double sum = noise > 0 ? normal(random) : 0;
    for (const Tone& tone : tones)
      sum += tone.amplitude * std::exp(-tone.decay * t) * std::cos(2 * std::numbers::pi * tone.hz * t + tone.phase);
    x.push_back(static_cast<float>(sum));
  }
  return x;
}

constexpr double kRate = 200;

TEST(FindLines, FindsATone) {
  constexpr std::size_t kSize = 2000;
  const double resolution = kRate / kSize;
  for (const double hz : {3.07, 10.0, 16.667, 37.123, 49.98, 88.8}) {
    const std::vector<std::vector<float>> series = {MakeSeries(kSize, kRate, {{.hz = hz, .amplitude = 1}}, 1)};
    const std::vector<double> lines = FindLines(series, kRate, 3, 95, 0, 4);
    ASSERT_EQ(lines.size(), 4u);
    // Noise moves a line of this size by sqrt(6/n)/pi/amplitude/T, some hundredths of the resolution.
    EXPECT_NEAR(lines[0], hz, 0.1 * resolution);
  }
}

TEST(FindLines, AddsUpTheSeries) {
  // In each series alone the line of 0.09 noise levels is no higher than the noise's own lines.
  std::vector<std::vector<float>> series;
  for (unsigned r = 0; r < 8; ++r)
    series.push_back(MakeSeries(2400, kRate, {{.hz = 23.4, .amplitude = 0.12, .phase = 1.0 * r}}, 10 + r));
  EXPECT_NEAR(FindLines(series, kRate, 3, 95, 0, 1).at(0), 23.4, 0.1 * kRate / 2400 + 0.02);
}

TEST(FindLines, PutsTheStrongestFirst) {
  const std::vector<std::vector<float>> series = {MakeSeries(
      2000, kRate, {{.hz = 20, .amplitude = 1}, {.hz = 35.5, .amplitude = 3}, {.hz = 70, .amplitude = 2}}, 3)};
  const std::vector<double> lines = FindLines(series, kRate, 3, 95, 0, 3);
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_NEAR(lines[0], 35.5, 0.05);  // half the resolution: they are far from each other
  EXPECT_NEAR(lines[1], 70, 0.05);
  EXPECT_NEAR(lines[2], 20, 0.05);
}

TEST(FindLines, FindsALineThatDiesAway) {
  const std::vector<std::vector<float>> series = {
      MakeSeries(2400, kRate, {{.hz = 23.2, .amplitude = 3, .decay = 3}}, 5)};
  EXPECT_NEAR(FindLines(series, kRate, 3, 95, 3, 1).at(0), 23.2, 0.3);  // a line as broad as its decay
}

TEST(FindLines, TakesRecordsOfDifferentLengthAndShortOnes) {
  const std::vector<std::vector<float>> series = {MakeSeries(300, kRate, {{.hz = 31, .amplitude = 2}}, 6),
                                                  MakeSeries(2400, kRate, {{.hz = 31, .amplitude = 2}}, 7),
                                                  {}};
  EXPECT_NEAR(FindLines(series, kRate, 3, 95, 0, 1).at(0), 31, 0.03);
}

// ---------------------------------------------------------------------------------------------------------------------

ExtendedOutcome FitPlain(const SyntheticRecords& made) {
  return FitExtended(made.data, made.sharing, Extension(), Convert(made.extension, made.truth, Extension()));
}

double CountSamples(const SyntheticRecords& made) {
  double samples = 0;
  for (const FitData& d : made.data) samples += static_cast<double>(d.size);
  return samples;
}

struct Hidden {
  const char* id;
  double share = 1;
};
class HiddenEffects : public testing::TestWithParam<Hidden> {};
INSTANTIATE_TEST_SUITE_P(OneOfEachKind, HiddenEffects,
                         testing::Values(Hidden{"viscous_damping"}, Hidden{"rolling_friction"}, Hidden{"extra_slider"},
                                         Hidden{"friction_drift"}, Hidden{"cubic_stiffness", -1}, Hidden{"end_stop"},
                                         Hidden{"stribeck_friction"}, Hidden{"pendulum_geometry", 0.3},
                                         Hidden{"sensor_saturation"}, Hidden{"sensor_nonlinearity"},
                                         Hidden{"sensor_drift"}, Hidden{"cross_axis_motion"}, Hidden{"rig_mode"},
                                         Hidden{"mains_hum"}),
                         [](const auto& hidden) { return std::string(hidden.param.id); });

TEST_P(HiddenEffects, AreRecovered) {
  const Effect* effect = FindEffect(GetParam().id);
  const Reading reading{.noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({effect}, {reading, reading, reading},
                                              {.sharing = Sharing::kShape, .scatter = 0.02, .share = GetParam().share});
  const ExtendedOutcome plain = FitPlain(made);
  const EffectSearch search(made.data, made.sharing, {.threads = 1, .progress = {}});
  const std::vector<const Effect*> tried = {effect};
  const std::vector<EffectFit> fits = search.Try(Extension(), plain, tried);
  ASSERT_EQ(fits.size(), 1u);
  ASSERT_TRUE(fits[0].refitted);
  EXPECT_EQ(fits[0].effect, effect);
  const double samples = CountSamples(made);
  const double before = std::sqrt(plain.chi2 / samples), after = std::sqrt(fits[0].outcome.chi2 / samples);
  std::printf("%-20s rms/noise %6.2f -> %.4f, %d evaluations, %g alternatives\n", GetParam().id, before, after,
              fits[0].outcome.evaluations, fits[0].alternatives);
  ASSERT_GT(before, 1.05) << "the effect does not show";
  EXPECT_LT(after, 1 + 3 / std::sqrt(2 * samples));  // noise, three deviations
  // Not each unknown by itself: some are hardly determined. The truth must be no better than what was found, beyond
  // the tolerance of the fit.
  const ExtendedOutcome from_truth = FitExtended(made.data, made.sharing, made.extension, made.truth);
  EXPECT_LT(fits[0].outcome.chi2, from_truth.chi2 + 0.5);
  EXPECT_EQ(fits[0].unknowns, static_cast<int>(made.extension.shared().size() + 3 * made.extension.own().size()));
  EXPECT_GE(fits[0].alternatives, 1);
}

TEST(EffectSearch, NeverEndsWorseThanItBegan) {
  const Reading reading{.noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, {reading, reading}, {.share = 0.2});
  const ExtendedOutcome plain = FitPlain(made);
  const EffectSearch search(made.data, made.sharing, {.threads = 2, .progress = {}});
  const std::vector<EffectFit> fits = search.Try(Extension(), plain, Effects());
  ASSERT_EQ(fits.size(), Effects().size());
  for (std::size_t i = 0; i < fits.size(); ++i) {
    EXPECT_EQ(fits[i].effect, Effects()[i]);
    EXPECT_GE(fits[i].visibility, 0) << fits[i].effect->id;
    EXPECT_LE(fits[i].visibility, 1 + 1e-9) << fits[i].effect->id;
    EXPECT_TRUE(std::isfinite(fits[i].score)) << fits[i].effect->id;
    if (!fits[i].refitted) continue;
    EXPECT_LE(fits[i].outcome.chi2, plain.chi2) << fits[i].effect->id;
    // What is said is what its unknowns give.
    double chi2 = 0;
    for (std::size_t r = 0; r < made.data.size(); ++r)
      for (const double x : CalcExtendedResiduals(made.data[r], fits[i].extension, fits[i].outcome.state, r))
        chi2 += x * x / (made.data[r].sigma * made.data[r].sigma);
    EXPECT_NEAR(chi2, fits[i].outcome.chi2, 1e-6 * chi2) << fits[i].effect->id;
  }
}

TEST(EffectSearch, DoesNotDependOnTheNumberOfThreads) {
  const Reading reading{.seconds = 6, .noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({FindEffect("extra_slider")}, {reading, reading});
  const ExtendedOutcome plain = FitPlain(made);
  const std::vector<const Effect*> tried = {FindEffect("extra_slider"), FindEffect("rolling_friction"),
                                            FindEffect("mains_hum"), FindEffect("end_stop")};
  const std::vector<EffectFit> one =
      EffectSearch(made.data, made.sharing, {.threads = 1, .progress = {}}).Try(Extension(), plain, tried);
  const std::vector<EffectFit> two =
      EffectSearch(made.data, made.sharing, {.threads = 2, .progress = {}}).Try(Extension(), plain, tried);
  for (std::size_t i = 0; i < tried.size(); ++i) {
    EXPECT_EQ(one[i].refitted, two[i].refitted);
    EXPECT_EQ(one[i].score, two[i].score);  // nothing is shared between trials
    EXPECT_EQ(one[i].outcome.chi2, two[i].outcome.chi2);
  }
}

TEST(EffectSearch, RefitsWithAsManyThreadsAsTheMachineHas) {
  const Reading reading{.noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({}, {reading, reading});
  ExtendedState start = made.truth;
  start.link.levels[0][0] += 0.02;
  const ExtendedOutcome one =
      EffectSearch(made.data, made.sharing, {.threads = 1, .progress = {}}).Refit(Extension(), start);
  const ExtendedOutcome all =
      EffectSearch(made.data, made.sharing, {.threads = 0, .progress = {}}).Refit(Extension(), start);
  EXPECT_NEAR(all.chi2, one.chi2, 1e-9 * one.chi2);
}

TEST(EffectSearch, TellsProgress) {
  const SyntheticRecords made = MakeSynthetic({}, {{.seconds = 4, .noise = 1.3e-5}});
  int last = 0, of = 0;
  const EffectSearch search(made.data, made.sharing, {.threads = 1, .progress = [&](int done, int all) {
                                                        last = done;
                                                        of = all;
                                                      }});
  const std::vector<const Effect*> tried = {FindEffect("viscous_damping"), FindEffect("sensor_drift")};
  search.Try(Extension(), FitPlain(made), tried);
  EXPECT_EQ(last, 2);
  EXPECT_EQ(of, 2);
}

TEST(CalcCollinearity, IsACosine) {
  EffectFit a, b;
  EXPECT_EQ(CalcCollinearity(a, b), 0);
  a.correction = {1, 0, 2};
  b.correction = {-2, 0, -4};
  EXPECT_NEAR(CalcCollinearity(a, b), 1, 1e-15);
  b.correction = {0, 3, 0};
  EXPECT_EQ(CalcCollinearity(a, b), 0);
  b.correction = {2, 1, 0};
  EXPECT_NEAR(CalcCollinearity(a, b), 0.4, 1e-15);
  b.correction = {2, 1};
  EXPECT_EQ(CalcCollinearity(a, b), 0);
  b.correction = {0, 0, 0};
  EXPECT_EQ(CalcCollinearity(a, b), 0);
}

}  // namespace
}  // namespace uiclink
