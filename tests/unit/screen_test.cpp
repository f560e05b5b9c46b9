// Score tests of a linear screen against brute force, and against the full refits that they stand for.

#include "identify/screen.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Linear {
  MatrixXd jacobian;
  VectorXd residuals;

  Normal MakeNormal() const {
    return {.gram = jacobian.transpose() * jacobian,
            .gradient = jacobian.transpose() * residuals,
            .chi2 = residuals.squaredNorm()};
  }
  /// Least sum of squares with the columns of `kept` free.
  double Minimise(const std::vector<Index>& kept, VectorXd* step = nullptr) const {
    const MatrixXd columns = jacobian(Eigen::all, kept);
    const VectorXd x = columns.colPivHouseholderQr().solve(-residuals);
    if (step != nullptr) *step = x;
    return (residuals + columns * x).squaredNorm();
  }
};

Linear MakeLinear(Index rows, Index columns, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Linear linear{.jacobian = MatrixXd(rows, columns), .residuals = VectorXd(rows)};
  for (Index j = 0; j < columns; ++j)
    for (Index i = 0; i < rows; ++i)
      linear.jacobian(i, j) = normal(random) * std::pow(10.0, static_cast<double>(j % 3) * 3 - 3);  // unlike units
  for (Index i = 0; i < rows; ++i) linear.residuals(i) = normal(random);
  return linear;
}

TEST(TestScore, IsTheFallOfALinearProblem) {
  const Linear linear = MakeLinear(60, 8, 1);
  const std::vector<Index> tested = {6, 2}, others = {0, 1, 3, 4, 5, 7};
  const Score score = TestScore(linear.MakeNormal(), tested);
  std::vector<Index> all = others;
  all.insert(all.end(), tested.begin(), tested.end());
  VectorXd step;
  const double fall = linear.Minimise(others) - linear.Minimise(all, &step);
  // Normal equations of a well conditioned problem, after scaling.
  EXPECT_NEAR(score.statistic, fall, 1e-10 * fall);
  ASSERT_EQ(score.step.size(), 2);
  EXPECT_NEAR(score.step(0), step(6), 1e-10 * std::abs(step(6)));
  EXPECT_NEAR(score.step(1), step(7), 1e-10 * std::abs(step(7)));
}

TEST(TestScore, SeesTheShareThatIsNotAbsorbed) {
  Linear linear = MakeLinear(60, 5, 2);
  const VectorXd tested = linear.jacobian.col(4);
  const MatrixXd others = linear.jacobian.leftCols(4);
  const VectorXd left = tested - others * others.colPivHouseholderQr().solve(tested);
  const Score score = TestScore(linear.MakeNormal(), std::vector<Index>{4});
  EXPECT_NEAR(score.visibility, left.norm() / tested.norm(), 1e-10);
  EXPECT_NEAR(score.statistic, std::pow(left.dot(linear.residuals) / left.norm(), 2), 1e-10);
  EXPECT_NEAR(score.step(0), -left.dot(linear.residuals) / left.squaredNorm(), 1e-10 / tested.norm());
}

TEST(TestScore, GivesNothingForWhatIsAbsorbed) {
  // A tested column that the others make up, exactly: what is left is rounding, and rounding promises nothing.
  for (unsigned seed = 0; seed < 200; ++seed) {
    Linear linear = MakeLinear(60, 5, 100 + seed);
    linear.jacobian.col(4) = linear.jacobian.leftCols(4) * VectorXd::LinSpaced(4, -1, 2);
    linear.residuals *= 100;
    const Score score = TestScore(linear.MakeNormal(), std::vector<Index>{4});
    EXPECT_TRUE(std::isfinite(score.statistic) && score.step.allFinite()) << seed;
    EXPECT_LT(score.visibility, 1e-6) << seed;  // the square root of rounding
    EXPECT_LT(score.statistic, 1e-3) << seed;   // of a sum of squares of 6e5
    EXPECT_GE(score.statistic, -1e-9) << seed;
  }
}

TEST(TestScore, BearsOthersThatAreCollinearAmongThemselves) {
  Linear linear = MakeLinear(60, 6, 3);
  linear.jacobian.col(1) = 2 * linear.jacobian.col(0);
  const Score score = TestScore(linear.MakeNormal(), std::vector<Index>{5});
  const double fall = linear.Minimise({0, 2, 3, 4}) - linear.Minimise({0, 2, 3, 4, 5});
  EXPECT_NEAR(score.statistic, fall, 1e-8 * fall);
}

TEST(TestScore, BearsTestedOnesThatAreCollinearAmongThemselves) {
  Linear linear = MakeLinear(60, 6, 4);
  linear.jacobian.col(5) = -3 * linear.jacobian.col(4);
  const Score score = TestScore(linear.MakeNormal(), std::vector<Index>{4, 5});
  const double fall = linear.Minimise({0, 1, 2, 3}) - linear.Minimise({0, 1, 2, 3, 4});
  EXPECT_NEAR(score.statistic, fall, 1e-8 * fall);
  EXPECT_TRUE(score.step.allFinite());
}

TEST(TestScore, LeavesOutWhatHasNoSensitivity) {
  Linear linear = MakeLinear(60, 6, 5);
  linear.jacobian.col(5).setZero();
  const Score score = TestScore(linear.MakeNormal(), std::vector<Index>{5, 4});
  const Score alone = TestScore(linear.MakeNormal(), std::vector<Index>{4});
  EXPECT_EQ(score.step.size(), 2);
  EXPECT_EQ(score.step(0), 0);
  // The order of the unknowns differs, and with it the rounding.
  EXPECT_NEAR(score.step(1), alone.step(0), 1e-12 * std::abs(alone.step(0)));
  EXPECT_NEAR(score.statistic, alone.statistic, 1e-10 * alone.statistic);
  linear.jacobian.col(2).setZero();  // one of the others
  EXPECT_TRUE(std::isfinite(TestScore(linear.MakeNormal(), std::vector<Index>{4}).statistic));
  linear.jacobian.col(4).setZero();
  const Score nothing = TestScore(linear.MakeNormal(), std::vector<Index>{4, 5});
  EXPECT_EQ(nothing.statistic, 0);
  EXPECT_EQ(nothing.step.norm(), 0);
}

TEST(TestScore, IsChiSquareOfItsUnknownsForNoise) {
  double sum = 0;
  constexpr int kDraws = 500;
  for (unsigned seed = 0; seed < kDraws; ++seed)
    sum += TestScore(MakeLinear(60, 7, 1000 + seed).MakeNormal(), std::vector<Index>{2, 4, 6}).statistic / kDraws;
  EXPECT_NEAR(sum, 3, 4 * std::sqrt(6.0 / kDraws));  // variance 2 x 3 of a draw, four deviations
}

TEST(UnknownMap, GivesEveryUnknownOnePlace) {
  const Extension extension({FindEffect("viscous_damping"), FindEffect("rig_mode")});
  for (const Sharing sharing : {Sharing::kLink, Sharing::kShape})
    for (const int sliders : {1, 3})
      for (const std::size_t records : {1u, 4u}) {
        const UnknownMap map(extension, sharing, sliders, records);
        const auto levels = sharing == Sharing::kLink ? 3 : 3 * static_cast<int>(records);
        EXPECT_EQ(map.size(), levels + 2 * (sliders - 1) + 3 + (3 + 2) * static_cast<int>(records));
        std::vector<int> used(static_cast<std::size_t>(map.size()));
        for (std::size_t r = 0; r < records; ++r) {
          const std::vector<Index> columns = map.Columns(r);
          ASSERT_EQ(columns.size(), static_cast<std::size_t>(3 + 2 * (sliders - 1) + 3 + 3 + 2));
          for (const Index c : columns) {
            ASSERT_TRUE(0 <= c && c < map.size());
            ++used[static_cast<std::size_t>(c)];
          }
        }
        const auto common = static_cast<std::ptrdiff_t>(2 * (sliders - 1) + 3 + (sharing == Sharing::kLink ? 3 : 0));
        EXPECT_EQ(std::count(used.begin(), used.end(), 0), 0);
        if (records > 1) {
          EXPECT_EQ(std::count(used.begin(), used.end(), static_cast<int>(records)), common);
        }
      }
}

TEST(CalcNormal, IsTheSumOfTheRecords) {
  const SyntheticRecords made =
      MakeSynthetic({FindEffect("viscous_damping"), FindEffect("sensor_drift")},
                    {{.seconds = 3, .noise = 1.3e-5}, {.seconds = 4, .noise = 1.3e-5}}, {.sharing = Sharing::kShape});
  const Normal normal = CalcNormal(made.data, made.sharing, made.extension, made.truth, 2);
  const UnknownMap map(made.extension, made.sharing, 1, 2);
  MatrixXd stacked = MatrixXd::Zero(0, map.size());
  VectorXd residuals(0);
  for (std::size_t r = 0; r < 2; ++r) {
    const Linearisation at = LineariseExtended(made.data[r], made.extension, made.truth, r, 2);
    const Index before = stacked.rows();
    stacked.conservativeResizeLike(MatrixXd::Zero(before + at.jacobian.rows(), map.size()));
    const std::vector<Index> columns = map.Columns(r);
    for (std::size_t c = 0; c < columns.size(); ++c)
      stacked.col(columns[c]).tail(at.jacobian.rows()) = at.jacobian.col(static_cast<Index>(c));
    residuals.conservativeResize(stacked.rows());
    residuals.tail(at.residuals.size()) = at.residuals;
  }
  EXPECT_LT((normal.gram - stacked.transpose() * stacked).norm(), 1e-12 * normal.gram.norm());
  EXPECT_LT((normal.gradient - stacked.transpose() * residuals).norm(), 1e-10 * normal.gradient.norm());
  EXPECT_NEAR(normal.chi2, residuals.squaredNorm(), 1e-12 * normal.chi2);
}

/// A small effect as the screen sees it from the plain fit, and what its full refit gains.
struct Promise {
  double screen = 0, gain = 0, visibility = 0;
};

Promise CompareWithRefit(const char* id, double share, double seconds) {
  const Effect* effect = FindEffect(id);
  const Reading reading{.seconds = seconds, .noise = 1.3e-5};
  const SyntheticRecords made = MakeSynthetic({effect}, {reading, reading}, {.share = share, .seed = 5});
  const ExtendedControl exact{.max_iterations = 100, .function_tolerance = 1e-12};
  const ExtendedState plain_start = Convert(made.extension, made.truth, Extension());
  const ExtendedOutcome plain = FitExtended(made.data, Sharing::kLink, Extension(), plain_start, exact);
  ExtendedState neutral = Convert(Extension(), plain.state, made.extension);
  for (std::size_t i = 0; i < made.truth.shared.size(); ++i)  // all but the size are known
    if (made.extension.shared()[i].parameter > 0) neutral.shared[i] = made.truth.shared[i];
  const ExtendedOutcome with = FitExtended(made.data, Sharing::kLink, made.extension, made.truth, exact);
  const UnknownMap map(made.extension, Sharing::kLink, 1, 2);
  std::vector<Index> sizes;
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t i = 0; i < made.extension.own().size(); ++i)
      sizes.push_back(map.Columns(r)[6 + made.extension.shared().size() + i]);
  if (sizes.empty()) sizes.push_back(map.Columns(0)[6]);
  const Score score = TestScore(CalcNormal(made.data, Sharing::kLink, made.extension, neutral, 1), sizes);
  std::printf("%-20s %g s: the screen promises %.1f, the refit gains %.1f, visibility %.3f\n", id, seconds,
              score.statistic, plain.chi2 - with.chi2, score.visibility);
  return {.screen = score.statistic, .gain = plain.chi2 - with.chi2, .visibility = score.visibility};
}

struct Small {
  const char* id;
  double share;
  double seconds;
};
class SmallEffects : public testing::TestWithParam<Small> {};
INSTANTIATE_TEST_SUITE_P(Kinds, SmallEffects,
                         testing::Values(Small{"viscous_damping", 0.04, 3}, Small{"rolling_friction", 0.08, 3},
                                         Small{"cubic_stiffness", 0.04, 9}, Small{"quadratic_stiffness", 0.04, 9},
                                         Small{"sensor_nonlinearity", 0.04, 9}, Small{"sensor_drift", 0.1, 9},
                                         Small{"cross_axis_motion", 0.015, 9}),
                         [](const auto& small) { return std::string(small.param.id); });

TEST_P(SmallEffects, GainWhatTheScreenPromises) {
  const Promise promise = CompareWithRefit(GetParam().id, GetParam().share, GetParam().seconds);
  EXPECT_GT(promise.gain, 40);
  EXPECT_LT(promise.gain, 2000);
  // Beside the sizes a refit has two nuisance parameters at most, worth 1 each; the model is linear to some per cent.
  EXPECT_NEAR(promise.screen, promise.gain, 0.04 * promise.gain + 4);
  EXPECT_GT(promise.visibility, 0);
  EXPECT_LE(promise.visibility, 1);
}

TEST(Screen, PromisesTooLittleOfALossThatEndsTheSlipping) {
  // With k1 < k the plain link slips in every half-cycle, ever less; each slip takes back most of a small change of
  // amplitude, and so does the tangent at no loss. The least real loss ends the slipping, and from there on changes
  // add up. A screen is therefore a lower bound for losses in records with a tail; how low is held here.
  for (const char* id : {"viscous_damping", "rolling_friction"}) {
    const Promise promise = CompareWithRefit(id, 0.01, 9);
    EXPECT_LT(promise.screen, 1.04 * promise.gain + 4) << id;
    EXPECT_GT(promise.screen, 0.3 * promise.gain) << id;
  }
}

}  // namespace
}  // namespace uiclink
