// Prediction of what was not fitted, and the family-wise false-alarm rate.

#include "identify/held_out.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "identify/family_wise.h"
#include "identify/statistics.h"
#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

constexpr Reading kNoisy{.noise = 1.3e-5};

struct Fits {
  ExtendedOutcome without, with;
};

/// Fits of some records with and without the effects that were given.
Fits FitBoth(const SyntheticRecords& made, const Extension& with) {
  const Extension none;
  ExtendedState plain = Convert(made.extension, made.truth, none);
  Fits fits;
  fits.without = FitExtended(made.data, made.sharing, none, plain);
  const bool is_true = made.extension.Has(with.effects()[0]);
  ExtendedState start = is_true ? made.truth : Convert(none, fits.without.state, with);
  fits.with = FitExtended(made.data, made.sharing, with, start);
  return fits;
}

HeldOut Predict(const SyntheticRecords& made, const Extension& with, int threads = 1) {
  const Fits fits = FitBoth(made, with);
  return PredictHeldOut(made.data, made.sharing, Extension(), fits.without.state, with, fits.with.state, threads);
}

TEST(PredictHeldOut, GainsNearlyAllByABigTrueEffect) {
  for (const Sharing sharing : {Sharing::kLink, Sharing::kShape})
    for (const char* id : {"viscous_damping", "cubic_stiffness", "cross_axis_motion"}) {
      const SyntheticRecords made =
          MakeSynthetic({FindEffect(id)}, std::vector<Reading>(3, kNoisy), {.sharing = sharing, .scatter = 0.02});
      const HeldOut held_out = Predict(made, made.extension);
      ASSERT_TRUE(held_out.known) << id;
      EXPECT_EQ(held_out.folds, 3);
      EXPECT_FALSE(held_out.by_time);
      // What remains is noise, and the error of what was learned from two records: a few per cent.
      EXPECT_NEAR(held_out.rms_after, 1.3e-5, 0.05 * 1.3e-5) << id;
      EXPECT_GT(held_out.Gain(), 0.75) << id;
      EXPECT_NEAR(held_out.Gain(), 1 - held_out.rms_after / held_out.rms_before, 1e-15);
    }
}

TEST(PredictHeldOut, GainsNothingByADecoy) {
  // Clean records: an effect that is not there can only follow noise. Effects with an amplitude for each record are
  // fitted to the record that is held out, too: two of 1780 readings' freedom.
  for (const char* id : {"viscous_damping", "cubic_stiffness", "sensor_nonlinearity", "friction_drift"}) {
    double mean = 0;
    constexpr unsigned kSeeds = 6;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
      const SyntheticRecords made = MakeSynthetic({}, std::vector<Reading>(3, kNoisy), {.seed = seed});
      const HeldOut held_out = Predict(made, Extension({FindEffect(id)}));
      ASSERT_TRUE(held_out.known);
      // One parameter known to one deviation moves the rms by some 1/(2 x 5000), a few times that for the smaller
      // folds and the worst of six.
      EXPECT_LT(std::abs(held_out.Gain()), 3e-3) << id << seed;
      mean += held_out.Gain() / kSeeds;
    }
    EXPECT_LT(mean, 2e-4) << id;
  }
}

TEST(PredictHeldOut, FollowsASingleRecordInTime) {
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, {kNoisy});
  const HeldOut held_out = Predict(made, made.extension);
  EXPECT_TRUE(held_out.known);
  EXPECT_TRUE(held_out.by_time);
  EXPECT_EQ(held_out.folds, 1);
  EXPECT_GT(held_out.Gain(), 0.9);
  EXPECT_LT(held_out.rms_after, 2 * 1.3e-5);  // prediction by parameters from 60 % of the record
}

TEST(PredictHeldOut, HasFiveFoldsAtMost) {
  const Reading brief{.seconds = 4, .noise = 1.3e-5};
  for (const std::size_t records : {2u, 5u, 7u}) {
    const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, std::vector<Reading>(records, brief));
    const HeldOut held_out = Predict(made, made.extension);
    EXPECT_EQ(held_out.folds, static_cast<int>(std::min<std::size_t>(records, 5)));
    EXPECT_NEAR(held_out.rms_after, 1.3e-5, 0.15 * 1.3e-5);  // brief records know little of the damping
  }
}

TEST(PredictHeldOut, DoesNotDependOnTheNumberOfThreads) {
  const Reading brief{.seconds = 4, .noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, std::vector<Reading>(4, brief));
  const HeldOut one = Predict(made, made.extension, 1), two = Predict(made, made.extension, 2);
  EXPECT_NEAR(one.rms_before, two.rms_before, 1e-12 * one.rms_before);  // the order of a sum
  EXPECT_NEAR(one.rms_after, two.rms_after, 1e-12 * one.rms_after);
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(CalcFamilyWiseP, IsAProbabilityThatFallsWithTheStatistic) {
  EXPECT_EQ(CalcFamilyWiseP(0, 1, 1, 3), 1);
  EXPECT_EQ(CalcFamilyWiseP(-3, 2, 5, 3), 1);
  EXPECT_EQ(CalcFamilyWiseP(std::numeric_limits<double>::quiet_NaN(), 2, 5, 3), 1);
  for (const int unknowns : {1, 3, 8}) {
    double last = 1;
    for (double statistic = 0.5; statistic < 200; statistic *= 1.3) {
      const double p = CalcFamilyWiseP(statistic, unknowns, 4, 3);
      EXPECT_GT(p, 0);
      EXPECT_LE(p, last) << statistic;
      last = p;
    }
  }
}

TEST(CalcFamilyWiseP, GrowsWithUnknownsAndAlternatives) {
  EXPECT_LT(CalcFamilyWiseP(20, 1, 1, 3), CalcFamilyWiseP(20, 3, 1, 3));
  EXPECT_LT(CalcFamilyWiseP(20, 1, 1, 3), CalcFamilyWiseP(20, 1, 10, 3));
  EXPECT_EQ(CalcFamilyWiseP(20, 1, 1, 3), CalcFamilyWiseP(20, 1, 0.1, 3));  // one alternative at least
  EXPECT_EQ(CalcFamilyWiseP(20, 1, 1, 3), CalcFamilyWiseP(20, 0, 1, 3));    // one unknown at least
}

TEST(CalcFamilyWiseP, CountsTheCatalogueOnceForSmallTails) {
  // Never less than that of the effect alone, and no more than all effects as if they were independent.
  for (const double statistic : {10.0, 30.0, 300.0}) {
    const double one = CalcChiSquareTail(statistic, 2), all = CalcFamilyWiseP(statistic, 2, 1, 3);
    EXPECT_GE(all, one);
    EXPECT_LE(all, one * static_cast<double>(Effects().size()));
  }
}

}  // namespace
}  // namespace uiclink
