// Extended models as fits see them: derivatives of every unknown, and fits that end where they should.

#include "identify/extended_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "identify/extended_columns.h"
#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

/// All unknowns of one record in the order of the columns of LineariseExtended().
std::vector<double*> Unknowns(ExtendedState* state, std::size_t r) {
  std::vector<double*> x;
  for (double& v : state->link.levels[state->link.levels.size() == 1 ? 0 : r]) x.push_back(&v);
  for (double& v : state->link.shape) x.push_back(&v);
  for (double& v : state->link.starts[r]) x.push_back(&v);
  for (double& v : state->shared) x.push_back(&v);
  for (double& v : state->own[r]) x.push_back(&v);
  return x;
}

/// Residuals to the integrator's best: a difference of two such runs must say something.
constexpr double kFine = 1e-12;

Eigen::VectorXd Residuals(const SyntheticRecords& made, const ExtendedState& state, std::size_t r, std::size_t stride,
                          bool derivatives, Eigen::MatrixXd* jacobian) {
  ExtendedColumns columns(made.extension, CountSliders(state.link.shape));
  columns.SetTolerance(kFine);
  const FitData& data = made.data[r];
  EXPECT_TRUE(columns.Evaluate(data, data.size, stride, state.link.LevelsOf(r).data(), state.link.shape.data(),
                               state.link.starts[r].data(), state.shared.data(), state.own[r].data(), derivatives));
  if (derivatives) *jacobian = columns.Map().leftCols(columns.CountUnknowns());
  return columns.Map().col(columns.CountUnknowns());
}

/// Columns below this [m per unit] are nothing: a coordinate would have to move by 1e3 to show in a reading.
constexpr double kNothing = 1e-8;

/// A step that changes the readings by about `change` [m], by an exact column.
double FindStep(const Eigen::VectorXd& column, double change) {
  const double largest = column.cwiseAbs().maxCoeff();
  return largest > kNothing ? change / largest : 1e-3;
}

struct Comparison {
  double worst = 0;   ///< largest difference of a column's elements, as a share of the column's largest element
  double kinks = 0;   ///< share of samples at which the readings have no derivative
  std::string where;  ///< the column
};

/// Columns against differences.  A reading has no derivative where a sample is at the edge of clipping: differences to
/// either side disagree there, and such samples are counted instead.
/// @param one_sided  of the shared and own unknowns: they are at the end of what is physical.
Comparison CompareWithDifferences(const SyntheticRecords& made, std::size_t r, std::size_t stride, bool one_sided) {
  Eigen::MatrixXd exact;
  const Eigen::VectorXd at = Residuals(made, made.truth, r, stride, true, &exact);
  EXPECT_LT((at - Residuals(made, made.truth, r, stride, false, nullptr)).cwiseAbs().maxCoeff(), 1e-12);
  Comparison comparison;
  ExtendedState state = made.truth;
  const std::vector<double*> unknowns = Unknowns(&state, r);
  EXPECT_EQ(exact.cols(), static_cast<Eigen::Index>(unknowns.size()));
  const std::size_t link = unknowns.size() - state.shared.size() - state.own[r].size();
  for (std::size_t c = 0; c < unknowns.size(); ++c) {
    const Eigen::VectorXd column = exact.col(static_cast<Eigen::Index>(c));
    const double largest = std::max(column.cwiseAbs().maxCoeff(), kNothing);
    const double h = FindStep(column, 2e-7), x = *unknowns[c];
    const auto run = [&](double step) {
      *unknowns[c] = x + step;
      Eigen::VectorXd y = Residuals(made, state, r, stride, false, nullptr);
      *unknowns[c] = x;
      return y;
    };
    Eigen::VectorXd forward, backward;
    if (one_sided && c >= link) {
      forward = (-3 * at + 4 * run(h) - run(2 * h)) / (2 * h);
      backward = forward;
    } else {
      const Eigen::VectorXd above = run(h), below = run(-h);
      forward = (above - at) / h;
      backward = (at - below) / h;
    }
    std::size_t kinks = 0;
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      if (std::abs(forward(i) - backward(i)) > 0.02 * largest) {
        ++kinks;
        continue;
      }
      const double off = std::abs(0.5 * (forward(i) + backward(i)) - column(i)) / largest;
      if (off <= comparison.worst) continue;
      comparison.worst = off;
      comparison.where = "unknown " + std::to_string(c) + ", sample " + std::to_string(i);
    }
    comparison.kinks = std::max(comparison.kinks, static_cast<double>(kinks) / static_cast<double>(at.size()));
  }
  return comparison;
}

/// Differences of 0.2 um in the readings: the third derivative leaves some 1e-5 of a column where phases turn by
/// 50 rad, the integrator's 1e-12 of a step some 1e-4 after some thousand steps with events between.
constexpr double kDifferences = 1e-3;

class EveryEffect : public testing::TestWithParam<const Effect*> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(Effects().begin(), Effects().end()),
                         [](const auto& effect) { return std::string(effect.param->id); });

TEST_P(EveryEffect, HasExactColumns) {
  for (const int sliders : {1, 2}) {
    const SyntheticRecords made = MakeSynthetic({GetParam()}, {{.seconds = 6}}, {.sliders = sliders});
    const Comparison comparison = CompareWithDifferences(made, 0, 3, false);
    EXPECT_LT(comparison.worst, kDifferences) << sliders << " sliders: " << comparison.where;
    EXPECT_LT(comparison.kinks, 0.01) << sliders << " sliders";
  }
}

TEST_P(EveryEffect, HasExactColumnsWhereItVanishes) {
  // What the screen stands on. A clipping level at infinity is left out: nothing depends on it there.
  if (std::isinf(GetParam()->neutral) && GetParam()->parameters[0].coordinate == Coordinate::kLinear) return;
  // Later, slips of such a link become as small as the differences, and any loss ends them for good: see below.
  const SyntheticRecords made = MakeSynthetic({GetParam()}, {{.seconds = 2.5}}, {.share = 0});
  const Comparison comparison = CompareWithDifferences(made, 0, 3, true);
  EXPECT_LT(comparison.worst, kDifferences) << comparison.where;
  EXPECT_LT(comparison.kinks, 0.01);
}

TEST_P(EveryEffect, IsThePlainModelWhereItVanishes) {
  const SyntheticRecords made = MakeSynthetic({GetParam()}, {{.seconds = 9}}, {.share = 0});
  const std::vector<double> plain =
      CalcResiduals(made.data[0], made.truth.link.levels[0], made.truth.link.shape, made.truth.link.starts[0]);
  const std::vector<double> extended = CalcExtendedResiduals(made.data[0], made.extension, made.truth, 0);
  ASSERT_EQ(plain.size(), extended.size());
  double worst = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) worst = std::max(worst, std::abs(plain[i] - extended[i]));
  EXPECT_LT(worst, 1e-8);  // kFitTolerance, for effects that are integrated: nanometres add up
}

TEST_P(EveryEffect, HasASolutionWhereTheSearchLeavesItUnused) {
  // Convert() puts a new effect into a model as the search returns it when it found no use for it.
  const SyntheticRecords made = MakeSynthetic({}, {{.seconds = 4}});
  const Extension extension({GetParam()});
  const ExtendedState state = Convert(Extension(), made.truth, extension);
  const std::vector<double> residuals = CalcExtendedResiduals(made.data[0], extension, state, 0);
  ASSERT_FALSE(residuals.empty());
  for (const double x : residuals) ASSERT_LT(std::abs(x), 1e-8);
  const Linearisation at = LineariseExtended(made.data[0], extension, state, 0);
  EXPECT_TRUE(at.jacobian.allFinite());
  EXPECT_TRUE(at.residuals.allFinite());
}

struct Several {
  const char* name;
  std::vector<const char*> effects;
  int sliders = 1;
};
class Combinations : public testing::TestWithParam<Several> {};
INSTANTIATE_TEST_SUITE_P(
    Several, Combinations,
    testing::Values(Several{"mechanical_and_reading", {"viscous_damping", "cross_axis_motion"}},
                    Several{"two_closed_forms", {"rolling_friction", "friction_drift"}},
                    Several{"reading_first", {"mains_hum", "quadratic_drag"}},
                    Several{"two_integrated", {"cubic_stiffness", "stribeck_friction"}},
                    Several{"three_mechanical", {"extra_slider", "clearance", "micro_slip"}},
                    Several{"all_stages", {"sensor_saturation", "mains_hum", "sensor_nonlinearity", "rig_mode"}},
                    Several{"curve_and_clipping", {"sensor_nonlinearity", "sensor_saturation", "viscous_damping"}},
                    Several{"own_between_shared", {"sensor_drift", "viscous_damping", "rig_mode", "end_stop"}},
                    Several{"three_sliders", {"viscous_damping", "sensor_nonlinearity"}, 3},
                    Several{"four_sliders_most_duals", {"extra_slider", "micro_slip", "stribeck_friction"}, 4}),
    [](const auto& several) { return std::string(several.param.name); });

std::vector<const Effect*> Find(const std::vector<const char*>& ids) {
  std::vector<const Effect*> effects;
  for (const char* id : ids) effects.push_back(FindEffect(id));
  return effects;
}

TEST_P(Combinations, HaveExactColumns) {
  const SyntheticRecords made =
      MakeSynthetic(Find(GetParam().effects), {{.seconds = 4}, {.seconds = 4}}, {.sliders = GetParam().sliders});
  const Comparison comparison = CompareWithDifferences(made, 1, 5, false);
  EXPECT_LT(comparison.worst, kDifferences) << comparison.where;
  EXPECT_LT(comparison.kinks, 0.01);
}

TEST(ExtendedColumns, FollowIrregularTimeStamps) {
  const SyntheticRecords made =
      MakeSynthetic(Find({"viscous_damping", "sensor_drift"}), {{.seconds = 4, .irregular = true}});
  const Comparison comparison = CompareWithDifferences(made, 0, 2, false);
  EXPECT_LT(comparison.worst, kDifferences) << comparison.where;
}

TEST(ExtendedColumns, AreReusedForOtherSizesAndStrides) {
  const SyntheticRecords made = MakeSynthetic(Find({"sensor_nonlinearity", "mains_hum"}), {{.seconds = 5}});
  ExtendedColumns used(made.extension, 1);
  const auto evaluate = [&](ExtendedColumns* columns, std::size_t size, std::size_t stride, bool derivatives) {
    return columns->Evaluate(made.data[0], size, stride, made.truth.link.levels[0].data(), nullptr,
                             made.truth.link.starts[0].data(), made.truth.shared.data(), made.truth.own[0].data(),
                             derivatives);
  };
  ASSERT_TRUE(evaluate(&used, made.data[0].size, 1, true));
  ASSERT_TRUE(evaluate(&used, 400, 3, true));
  EXPECT_EQ(used.residuals().size(), 134u);
  ExtendedColumns fresh(made.extension, 1);
  ASSERT_TRUE(evaluate(&fresh, 400, 3, true));
  EXPECT_EQ(Eigen::MatrixXd(used.Map()), Eigen::MatrixXd(fresh.Map()));
  EXPECT_EQ(used.evaluations(), 2);
}

TEST(LineariseExtended, IsTheColumnsInUnitsOfTheNoise) {
  const SyntheticRecords made = MakeSynthetic(Find({"viscous_damping", "rig_mode"}), {{.seconds = 4}, {.seconds = 3}});
  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd residuals = Residuals(made, made.truth, 1, 4, true, &jacobian);
  const Linearisation at = LineariseExtended(made.data[1], made.extension, made.truth, 1, 4);
  // Closed form: the integrator's tolerance does not matter.
  EXPECT_LT((at.jacobian * made.data[1].sigma - jacobian).norm(), 1e-12 * jacobian.norm());
  EXPECT_LT((at.residuals * made.data[1].sigma - residuals).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(LineariseExtended, AgreesWithThePlainOne) {
  for (const int sliders : {1, 2, 4}) {
    const SyntheticRecords made = MakeSynthetic({}, {{.seconds = 9, .noise = 1.3e-5}}, {.sliders = sliders});
    const FitState& s = made.truth.link;
    const Linearisation plain = Linearise(made.data[0], s.levels[0], s.shape, s.starts[0]);
    const Linearisation extended = LineariseExtended(made.data[0], made.extension, made.truth, 0);
    ASSERT_EQ(plain.jacobian.cols(), extended.jacobian.cols());
    // Two solvers in closed form: rounding of some hundred events.
    EXPECT_LT((plain.jacobian - extended.jacobian).norm(), 1e-8 * plain.jacobian.norm()) << sliders;
    EXPECT_LT((plain.residuals - extended.residuals).norm(), 1e-6 * plain.residuals.norm()) << sliders;
  }
}

// ---------------------------------------------------------------------------------------------------------------------

ExtendedState Disturb(const ExtendedState& truth, double share) {
  ExtendedState state = truth;
  for (Levels& levels : state.link.levels)
    for (std::size_t j = 0; j < levels.size(); ++j) levels[j] += share * (j % 2 == 0 ? 1 : -1);
  for (Start& start : state.link.starts) {
    start[0] *= 1 + 0.1 * share;
    start[1] += 0.005 * share;
    start[2] += 1e-3 * share;
  }
  return state;
}

TEST(FitExtended, WithoutEffectsIsThePlainFit) {
  for (const Sharing sharing : {Sharing::kLink, Sharing::kShape})
    for (const int sliders : {1, 2}) {
      const SyntheticRecords made =
          MakeSynthetic({}, {{.noise = 1.3e-5}, {.noise = 1.3e-5}, {.seconds = 6, .noise = 1.3e-5}},
                        {.sliders = sliders, .sharing = sharing, .scatter = 0.02});
      const ExtendedState start = Disturb(made.truth, 0.02);
      const FitOutcome plain = Fit(made.data, sharing, start.link, {.window_s = {2, 5}, .function_tolerance = 1e-12});
      const ExtendedOutcome extended =
          FitExtended(made.data, sharing, Extension(), start,
                      {.window_s = {2, 5}, .max_iterations = 200, .function_tolerance = 1e-12});
      EXPECT_NEAR(extended.chi2, plain.chi2, 1e-9 * plain.chi2) << sliders;
      ASSERT_EQ(extended.chi2_of_record.size(), 3u);
      for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t j = 0; j < 3; ++j)
          // A change of 1e-9 of chi2 ~ 5000 is 2e-3 standard deviations, of some 1e-4 (one slider) to 1e-2 (two).
          EXPECT_NEAR(extended.state.link.LevelsOf(r)[j], plain.state.LevelsOf(r)[j], sliders == 1 ? 1e-6 : 3e-5);
    }
}

TEST(FitExtended, FindsTheTruthOfClosedForms) {
  for (const char* id : {"viscous_damping", "rolling_friction", "extra_slider", "friction_drift", "end_stop",
                         "sensor_drift", "sensor_nonlinearity", "cross_axis_motion", "rig_mode", "mains_hum"}) {
    const SyntheticRecords made = MakeSynthetic({FindEffect(id)}, {{}, {}, {.seconds = 7}});
    ExtendedState start = Disturb(made.truth, 0.1);
    for (const Extension::Unknown& u : made.extension.shared()) {
      const auto i = static_cast<std::size_t>(&u - made.extension.shared().data());
      if (u.parameter == 0 || u.Parameter().symbol == "decay") start.shared[i] *= 0.5;
    }
    for (std::vector<double>& own : start.own)
      for (double& x : own) x *= 0.3;
    const ExtendedOutcome outcome =
        FitExtended(made.data, Sharing::kLink, made.extension, start,
                    {.window_s = {2, 4}, .max_iterations = 200, .function_tolerance = 1e-16});
    // Noise-free: what is left is rounding, far below a nanometre against a stated noise of 13 um.
    EXPECT_LT(outcome.chi2, 1e-8) << id;
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(outcome.state.link.levels[0][j], made.truth.link.levels[0][j], 1e-8) << id << " level " << j;
    for (std::size_t i = 0; i < made.truth.shared.size(); ++i)
      EXPECT_NEAR(outcome.state.shared[i], made.truth.shared[i], 1e-7 * std::max(1.0, std::abs(made.truth.shared[i])))
          << id;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t i = 0; i < made.truth.own[r].size(); ++i)
        EXPECT_NEAR(outcome.state.own[r][i], made.truth.own[r][i], 1e-10) << id;
  }
}

TEST(FitExtended, FitsRecordsOfDifferentLengthAndSampling) {
  const SyntheticRecords made = MakeSynthetic(Find({"viscous_damping", "sensor_drift"}),
                                              {{.sampling_hz = 200, .seconds = 9},
                                               {.sampling_hz = 71.3, .seconds = 5, .sigma = 2e-5},
                                               {.sampling_hz = 120, .seconds = 7, .sigma = 4e-5, .irregular = true}});
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, Disturb(made.truth, 0.05),
                                              {.max_iterations = 200, .function_tolerance = 1e-16});
  EXPECT_LT(outcome.chi2, 1e-8);
  EXPECT_NEAR(outcome.state.shared[0], made.truth.shared[0], 1e-8);
  for (std::size_t r = 0; r < 3; ++r) EXPECT_NEAR(outcome.state.own[r][0], made.truth.own[r][0], 1e-10);
}

TEST(FitExtended, UsesEveryNthSample) {
  const SyntheticRecords made = MakeSynthetic(Find({"viscous_damping"}), {{.noise = 1.3e-5}, {.noise = 1.3e-5}});
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, made.truth, {.stride = 4});
  const double samples = 2 * std::ceil(static_cast<double>(made.data[0].size) / 4);
  // Chi-square of `samples` less 10 unknowns; three deviations.
  EXPECT_NEAR(outcome.chi2, samples - 10, 3 * std::sqrt(2 * samples));
}

TEST(FitExtended, StaysWithinPhysicalBounds) {
  // The records gain energy, or gain friction where the bound says loses: the fit wants a size beyond its bound.
  struct Case {
    const char* id;
    double hidden;
  };
  for (const Case& c :
       {Case{"viscous_damping", -0.004}, Case{"quadratic_drag", -0.05}, Case{"sensor_nonlinearity", 14}}) {
    SyntheticRecords made = MakeSynthetic({FindEffect(c.id)}, {{.seconds = 5}, {.seconds = 5}});
    made.truth.shared[0] = c.hidden;
    std::mt19937_64 random(1);
    for (std::size_t r = 0; r < 2; ++r) ReadModel({.noise = 1e-6}, r, &random, &made);
    ExtendedState start = made.truth;
    start.shared[0] = MakeCoordinates(*FindEffect(c.id), 0.1)[0];
    const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, start);
    const Extension::Unknown& u = made.extension.shared()[0];
    EXPECT_GE(outcome.state.shared[0], u.low) << c.id;
    EXPECT_LE(outcome.state.shared[0], u.high) << c.id;
    const double bound = c.hidden < 0 ? u.low : u.high;
    EXPECT_NEAR(outcome.state.shared[0], bound, 1e-3 * u.scale) << c.id;
  }
}

TEST(FitExtended, BringsAStartOutsideTheBoundsInside) {
  const SyntheticRecords made = MakeSynthetic(Find({"viscous_damping"}), {{.seconds = 4, .noise = 1.3e-5}});
  ExtendedState start = made.truth;
  start.shared[0] = -1;
  const ExtendedOutcome outcome =
      FitExtended(made.data, Sharing::kLink, made.extension, start, {.max_iterations = 100});
  EXPECT_TRUE(std::isfinite(outcome.chi2));
  EXPECT_NEAR(outcome.state.shared[0], made.truth.shared[0], 2e-3);  // some ten deviations of one short record
}

TEST(FitExtended, KeepsWhatIsFixed) {
  const SyntheticRecords made =
      MakeSynthetic(Find({"viscous_damping", "sensor_drift"}), {{.noise = 1.3e-5}, {.noise = 1.3e-5}}, {.sliders = 2});
  ExtendedState start = Disturb(made.truth, 1e-3);
  start.shared[0] *= 1.1;
  const ExtendedOutcome link = FitExtended(made.data, Sharing::kLink, made.extension, start, {.fix_link = true});
  EXPECT_EQ(link.state.link.levels, start.link.levels);
  EXPECT_EQ(link.state.link.shape, start.link.shape);
  EXPECT_NE(link.state.shared, start.shared);
  EXPECT_NE(link.state.link.starts, start.link.starts);
  EXPECT_NE(link.state.own, start.own);
  const ExtendedOutcome shared = FitExtended(made.data, Sharing::kLink, made.extension, start, {.fix_shared = true});
  EXPECT_EQ(shared.state.shared, start.shared);
  EXPECT_NE(shared.state.link.levels, start.link.levels);
  EXPECT_NE(shared.state.own, start.own);
  const ExtendedOutcome both =
      FitExtended(made.data, Sharing::kLink, made.extension, start, {.fix_link = true, .fix_shared = true});
  EXPECT_EQ(both.state.link.levels, start.link.levels);
  EXPECT_EQ(both.state.shared, start.shared);
  EXPECT_LT(shared.chi2, both.chi2);
}

TEST(FitExtended, DoesNotDependOnTheNumberOfThreads) {
  const SyntheticRecords made =
      MakeSynthetic(Find({"viscous_damping", "rig_mode"}), {{.noise = 1.3e-5}, {.noise = 1.3e-5}, {.noise = 1.3e-5}});
  const ExtendedState start = Disturb(made.truth, 0.02);
  const auto fit = [&](int threads) {
    return FitExtended(made.data, Sharing::kLink, made.extension, start, {.threads = threads});
  };
  const ExtendedOutcome one = fit(1), three = fit(3), all = fit(0);
  for (const ExtendedOutcome* other : {&three, &all}) {   // 0: as many as the machine has, as everywhere
    EXPECT_NEAR(other->chi2, one.chi2, 1e-9 * one.chi2);  // only the order of sums may differ
    for (std::size_t i = 0; i < one.state.shared.size(); ++i)
      EXPECT_NEAR(other->state.shared[i], one.state.shared[i], 1e-9 * std::abs(one.state.shared[i]));
    EXPECT_TRUE(other->converged);
  }
}

TEST(FitExtended, SaysSoWhereTheModelHasNoSolution) {
  const SyntheticRecords made = MakeSynthetic(Find({"viscous_damping"}), {{.seconds = 3}});
  ExtendedState state = made.truth;
  state.link.starts[0][0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(CalcExtendedResiduals(made.data[0], made.extension, state, 0).empty());
  const Linearisation at = LineariseExtended(made.data[0], made.extension, state, 0, 2);
  EXPECT_EQ(at.residuals.size(), static_cast<Eigen::Index>((made.data[0].size + 1) / 2));
  EXPECT_FALSE(at.residuals.allFinite());
  EXPECT_EQ(at.jacobian.norm(), 0);
  const ExtendedOutcome outcome = FitExtended(made.data, Sharing::kLink, made.extension, state);
  EXPECT_FALSE(std::isfinite(outcome.chi2));
  EXPECT_FALSE(outcome.converged);
}

}  // namespace
}  // namespace uiclink
