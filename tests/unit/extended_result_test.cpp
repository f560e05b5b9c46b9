// What is said about an extended fit: is noise called noise, structure structure, and are the bounds true?

#include "identify/extended_result.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "identify/extended_covariance.h"
#include "identify/identification.h"
#include "measurements/rig/rig.h"
#include "tests/support/rig_records.h"
#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

constexpr Reading kNoisy{.noise = 1.3e-5};

/// Noise of its own for each seed, on the readings of the same records.
void Redraw(unsigned seed, const std::vector<Reading>& readings, SyntheticRecords* made) {
  std::mt19937_64 random(seed);
  for (std::size_t r = 0; r < readings.size(); ++r) ReadModel(readings[r], r, &random, made);
}

TEST(CalcStructure, CallsNoiseNoise) {
  const std::vector<Reading> readings(3, kNoisy);
  SyntheticRecords made = MakeSynthetic({}, readings);
  constexpr int kSeeds = 300;
  int structured = 0;
  double size = 0;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    Redraw(seed, readings, &made);
    const Structure s = CalcStructure(made.data, made.extension, made.truth);
    structured += s.structured ? 1 : 0;
    size += s.effective_size / kSeeds;
    EXPECT_NEAR(s.RmsOverNoise(), 1, 4 / std::sqrt(2 * 3 * 1780.0)) << seed;  // four deviations
  }
  std::printf("white noise: structured in %d of %d\n", structured, kSeeds);
  EXPECT_LE(structured, kSeeds / 100);
  EXPECT_NEAR(size, 3 * 1780, 0.01 * 3 * 1780);
}

TEST(CalcStructure, SeesATone) {
  const std::vector<Reading> readings(3, kNoisy);
  SyntheticRecords made = MakeSynthetic({}, readings);
  for (const double hz : {0.7, 5.0, 17.0}) {
    int structured = 0;
    for (unsigned seed = 0; seed < 20; ++seed) {
      Redraw(seed, readings, &made);
      for (Record& record : made.records)
        for (std::size_t i = 0; i < record.y.size(); ++i)
          record.y[i] += 0.4 * 1.3e-5 * std::cos(2 * std::numbers::pi * hz * record.t[i]);
      structured += CalcStructure(made.data, made.extension, made.truth).structured ? 1 : 0;
    }
    EXPECT_EQ(structured, 20) << hz;  // rho = 0.074, whiteness 20 x 1780 x 0.074^2 / 2 = 97 on 20 lags in each record
  }
}

TEST(CalcStructure, CountsIndependentObservations) {
  SyntheticRecords made = MakeSynthetic({}, {Reading{}});
  // Noise of a first-order filter with rho per sample: n (1 - rho)/(1 + rho) independent observations.
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  double x = 0;
  for (double& y : made.records[0].y) {
    x = 0.8 * x + 0.6 * normal(random);
    y += 1.3e-5 * x;
  }
  const Structure s = CalcStructure(made.data, made.extension, made.truth);
  EXPECT_TRUE(s.structured);
  EXPECT_NEAR(s.effective_size, 1780 * 0.2 / 1.8, 0.4 * 1780 * 0.2 / 1.8);  // the sum of rho is known to some 20 %
}

TEST(CalcStructure, EstimatesTheFloorAnewWhereAToneWasNoise) {
  // A tone of 60 Hz counts as noise at first: 13 um of noise and 30 um of tone look like 25 um of noise.
  const Effect* hum = FindEffect("mains_hum");
  const std::vector<Reading> readings(3, Reading{.sigma = 2.5e-5, .noise = 1.3e-5});
  SyntheticRecords made = MakeSynthetic({hum}, readings);
  made.truth.shared[0] = std::log(60.0);
  Redraw(1, readings, &made);
  const Structure with = CalcStructure(made.data, made.extension, made.truth);
  EXPECT_NEAR(with.noise, 1.3e-5, 0.05 * 1.3e-5);  // three deviations of three records' estimates (1.7 % each: noise.h)
  EXPECT_NEAR(with.RmsOverNoise(), 1, 0.05);
  ASSERT_EQ(with.noise_of_record.size(), 3u);
  const ExtendedState plain = Convert(made.extension, made.truth, Extension());
  const Structure without = CalcStructure(made.data, Extension(), plain);
  EXPECT_EQ(without.noise, 2.5e-5);  // no effect on the reading, so no other floor
  // Bounds must be those of the true noise.
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, made.truth);
  const ExtendedResult loud = Describe(made.data, Sharing::kLink, made.extension, outcome);
  for (FitData& d : made.data) d.sigma = 1.3e-5;
  const ExtendedOutcome right = FitExtended(made.data, Sharing::kLink, made.extension, made.truth);
  const ExtendedResult quiet = Describe(made.data, Sharing::kLink, made.extension, right);
  for (std::size_t q = 0; q < 3; ++q)
    EXPECT_NEAR(loud.quantities[q].std, quiet.quantities[q].std, 0.01 * quiet.quantities[q].std);
}

TEST(CalcStructure, CallsAModelWithoutSolutionStructured) {
  SyntheticRecords made = MakeSynthetic({}, {kNoisy});
  made.truth.link.starts[0][0] = std::numeric_limits<double>::quiet_NaN();
  const Structure s = CalcStructure(made.data, made.extension, made.truth);
  EXPECT_TRUE(s.structured);
  EXPECT_TRUE(std::isinf(s.rms));
}

// ---------------------------------------------------------------------------------------------------------------------

TEST(Describe, TellsEveryParameterOfEveryEffect) {
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping"), FindEffect("rig_mode"),
                                               FindEffect("sensor_drift"), FindEffect("pendulum_geometry")},
                                              {kNoisy, kNoisy}, {.share = 5});
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, made.truth);
  const ExtendedResult result = Describe(made.data, Sharing::kLink, made.extension, outcome);
  std::vector<std::string> symbols;
  for (const EffectEstimate& e : result.effects) {
    symbols.push_back(e.symbol);
    EXPECT_LE(e.low, e.value) << e.symbol;
    EXPECT_GE(e.high, e.value) << e.symbol;
    EXPECT_FALSE(e.at_bound) << e.symbol;
    EXPECT_TRUE(std::isfinite(e.value) && std::isfinite(e.std)) << e.symbol;
  }
  EXPECT_EQ(symbols, (std::vector<std::string>{"c", "f", "zeta", "A", "rate", "l"}));
}

TEST(Describe, NamesAParameterAtItsBound) {
  const Effect* effect = FindEffect("sensor_nonlinearity");
  SyntheticRecords made = MakeSynthetic({effect}, {kNoisy, kNoisy});
  made.truth.shared[0] = 13;  // beyond 10
  std::mt19937_64 random(1);
  for (std::size_t r = 0; r < 2; ++r) ReadModel(kNoisy, r, &random, &made);
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, made.truth);
  const ExtendedResult result = Describe(made.data, Sharing::kLink, made.extension, outcome);
  ASSERT_EQ(result.effects.size(), 1u);
  EXPECT_TRUE(result.effects[0].at_bound);
}

TEST(Describe, DoesNotCallTheNeutralValueABound) {
  const SyntheticRecords made = MakeSynthetic({FindEffect("viscous_damping")}, {kNoisy, kNoisy}, {.share = 0});
  ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, made.truth);
  outcome.state.shared[0] = 0;
  const ExtendedResult result = Describe(made.data, Sharing::kLink, made.extension, outcome);
  EXPECT_FALSE(result.effects[0].at_bound);
  EXPECT_EQ(result.effects[0].low, 0);  // not below the physical bound
  EXPECT_GT(result.effects[0].high, 0);
}

TEST(Describe, HasCovariancesThatFitItsDeviations) {
  for (const Sharing sharing : {Sharing::kLink, Sharing::kShape}) {
    const SyntheticRecords made =
        MakeSynthetic({FindEffect("viscous_damping")}, {kNoisy, kNoisy, kNoisy}, {.sharing = sharing, .scatter = 0.02});
    const ExtendedOutcome outcome = FitExtended(made.data, sharing, made.extension, made.truth);
    const ExtendedResult result = Describe(made.data, sharing, made.extension, outcome);
    const Eigen::MatrixXd covariance = CalcExtendedCovariance(made.data, result).matrix.topLeftCorner(3, 3);
    for (int q = 0; q < 3; ++q) {
      const double std = result.quantities[static_cast<std::size_t>(q)].std;
      EXPECT_NEAR(std::sqrt(covariance(q, q)), std, 1e-3 * std) << q;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
    EXPECT_GT(eigen.eigenvalues().minCoeff(), 0);
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Coverage.

constexpr double kC = 0.01;

struct Kind {
  const char* name;
  rig::Scatter scatter;
  Sharing sharing;
  double k = 3.41, k1 = 2.21, T01 = 0.018;
};

struct Coverage {
  int studies = 0;
  std::array<int, 4> inside{};           // k, k1, T01; c
  std::array<int, 3> of_records_mean{};  // the mean of the records' own links
  int all = 0, all_of_records_mean = 0;
  std::array<double, 4> z2{};  // mean square of (estimate - truth)/std
};

rig::Settings Damped(const Kind& kind, std::uint64_t seed) {
  rig::Settings settings = PlainLateral(seed);
  settings.link.k = kind.k;
  settings.link.joints = {{.k = kind.k1, .T0 = kind.T01}};
  settings.link.effects.viscous_c = kC;
  settings.scatter = kind.scatter;
  return settings;
}

void RunStudy(const Kind& kind, std::uint64_t seed, Coverage* coverage) {
  constexpr int kRecords = 3;
  const rig::Settings settings = Damped(kind, seed);
  std::vector<RecordResult> results;
  std::array<double, 3> records_mean{};
  for (int i = 1; i <= kRecords; ++i) {
    const rig::RigRecord made = rig::MakeRecord(settings, i);
    const rig::Link& link = made.truth.link;
    const double values[] = {link.k, link.joints[0].k, link.joints[0].T0};
    for (std::size_t q = 0; q < 3; ++q) records_mean[q] += values[q] / kRecords;
    RecordResult& result = results.emplace_back();
    result.record = ToRecord(made, Direction::kLateral);
    PrepareRecord({}, &result);
    ASSERT_TRUE(result.used) << result.reason;
    FitRecord(1, {.count = 0}, &result);
  }
  const Extension extension({FindEffect("viscous_damping")});
  std::vector<FitData> data;
  ExtendedState state;
  for (const RecordResult& result : results) {
    data.push_back(result.Data());
    state.link.starts.push_back(result.own.state.starts[0]);
    if (kind.sharing == Sharing::kShape || state.link.levels.empty())
      state.link.levels.push_back(result.own.state.levels[0]);
  }
  state.shared = {0.5 * kC};
  state.own.resize(kRecords);
  const ExtendedOutcome outcome = FitExtended(data, kind.sharing, extension, state);
  const ExtendedResult result = Describe(data, kind.sharing, extension, outcome);
  const std::array<double, 4> truth = {kind.k, kind.k1, kind.T01, kC};
  ++coverage->studies;
  bool all = true, all_of_records_mean = true;
  for (std::size_t q = 0; q < 4; ++q) {
    const Estimate& e = q < 3 ? result.quantities[q] : result.effects.at(0);
    const bool inside = e.low <= truth[q] && truth[q] <= e.high;
    coverage->inside[q] += inside ? 1 : 0;
    coverage->z2[q] += std::pow((e.value - truth[q]) / e.std, 2);
    if (q == 3) continue;
    all &= inside;
    const bool holds_mean = e.low <= records_mean[q] && records_mean[q] <= e.high;
    coverage->of_records_mean[q] += holds_mean ? 1 : 0;
    all_of_records_mean &= holds_mean;
  }
  coverage->all += all ? 1 : 0;
  coverage->all_of_records_mean += all_of_records_mean ? 1 : 0;
}

void Print(const Kind& kind, const Coverage& c) {
  const double percent = 100.0 / c.studies;
  std::printf(
      "%s: %d studies of 3 records; population inside the 95 %% bounds: k %.1f %%, k1 %.1f %%, T01 %.1f %%, "
      "all three %.1f %%; c %.1f %%; mean of the records' own truths: k %.1f %%, k1 %.1f %%, T01 %.1f %%, all "
      "three %.1f %%; rms of z: %.2f %.2f %.2f, c %.2f\n",
      kind.name, c.studies, percent * c.inside[0], percent * c.inside[1], percent * c.inside[2], percent * c.all,
      percent * c.inside[3], percent * c.of_records_mean[0], percent * c.of_records_mean[1],
      percent * c.of_records_mean[2], percent * c.all_of_records_mean, std::sqrt(c.z2[0] / c.studies),
      std::sqrt(c.z2[1] / c.studies), std::sqrt(c.z2[2] / c.studies), std::sqrt(c.z2[3] / c.studies));
}

class Bounds : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(OfDampedRecords, Bounds,
                         testing::Values(Kind{"one_link", {}, Sharing::kLink},
                                         Kind{"stiff_joint", {}, Sharing::kLink, 3.413, 10.503, 0.018},
                                         Kind{"one_link_as_three", {}, Sharing::kShape},
                                         Kind{"scattered", kReseating, Sharing::kShape}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST_P(Bounds, AreTrue) {
  const int studies = IsLong() ? 1000 : 100;
  Coverage coverage;
  for (int i = 0; i < studies; ++i) RunStudy(GetParam(), 50000 + static_cast<std::uint64_t>(i), &coverage);
  Print(GetParam(), coverage);
  // 95 % of n, less three deviations of a binomial.
  const double least = 0.95 * studies - 3 * std::sqrt(0.95 * 0.05 * studies);
  for (const int inside : coverage.inside) EXPECT_GE(inside, least);
  // Three bounds at once: with one link their errors go together and 90 % hold all; links that scatter independently
  // leave 0.95^3 for the means of their population, while the records' own mean is known far better. Three deviations.
  const bool scattered = GetParam().scatter.k > 0;
  const double share = scattered ? 0.95 * 0.95 * 0.95 : 0.9;
  EXPECT_GE(coverage.all, share * studies - 3 * std::sqrt(share * (1 - share) * studies));
  if (scattered) {
    EXPECT_GE(coverage.all_of_records_mean, 0.97 * studies);
  }
}

}  // namespace
}  // namespace uiclink
