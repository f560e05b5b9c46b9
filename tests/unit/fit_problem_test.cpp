#include "identify/fit_problem.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/event_solver.h"

namespace uiclink {
namespace {

Oscillator<double> MakeLink(int sliders) {
  const Slider<double> all[] = {{1.5, 0.0045}, {1.1, 0.0043}, {0.9, 0.0044}, {0.8, 0.0047}};
  Oscillator<double> link;
  link.k = 5.5;
  if (sliders == 1) {
    link.k = 3.41;
    link.Add({2.21, 0.018});
    return link;
  }
  for (int i = 0; i < sliders; ++i) link.Add(all[i]);
  return link;
}

/// A decay from an extremum at 0.3 s, read with a sensor whose zero is off by 0.4 mm.
Record MakeRecord(const Oscillator<double>& link, double noise, bool uniform, double y0 = -0.025) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  Record record;
  record.sampling_hz = 200;
  record.uniform = uniform;
  Trajectory<double> run;
  Solve(link, AtExtremum(link, y0), 12, &run);
  for (int i = 0; i < 2300; ++i) {
    double t = 0.302 + i / 200.0;
    if (!uniform) t += 0.0012 * std::sin(0.7 * i);
    record.t.push_back(t);
    record.y.push_back(0.0004 + run.y(t - 0.3) + noise * normal(random));
  }
  return record;
}

FitData MakeData(const Record& record, double sigma) {
  return {.record = &record, .first = 0, .size = record.t.size(), .sigma = sigma, .centre = 0.0004, .swing = 0.025};
}

FitState MakeState(const Oscillator<double>& link, const Start& start) {
  FitState state;
  state.levels.resize(1);
  FromOscillator(link, &state.levels[0], &state.shape);
  state.starts = {start};
  return state;
}

class ForSliders : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(OneToFour, ForSliders, testing::Values(1, 2, 3, 4));

TEST_P(ForSliders, CoordinatesComeBack) {
  const Oscillator<double> link = MakeLink(GetParam());
  Levels levels;
  Shape shape;
  FromOscillator(link, &levels, &shape);
  EXPECT_EQ(CountSliders(shape), GetParam());
  const Oscillator<double> back = ToOscillator(levels, shape, link.g);
  for (int q = 0; q < CountQuantities(GetParam()) + 2 * GetParam(); ++q)
    EXPECT_NEAR(CalcQuantity(back, q), CalcQuantity(link, q), 1e-14 * CalcQuantity(link, q)) << q;
}

TEST_P(ForSliders, LogGradientsAreThoseOfDifferences) {
  Levels levels;
  Shape shape;
  FromOscillator(MakeLink(GetParam()), &levels, &shape);
  const Oscillator<double> link = ToOscillator(levels, shape, 1);
  constexpr double h = 1e-5;
  for (int q = 0; q < CountQuantities(GetParam()) + 2 * GetParam(); ++q) {
    const Eigen::RowVectorXd gradient = CalcLogGradient(link, q);
    for (std::size_t c = 0; c < 3 + shape.size(); ++c) {
      Levels up = levels, down = levels;
      Shape shape_up = shape, shape_down = shape;
      (c < 3 ? up[c] : shape_up[c - 3]) += h;
      (c < 3 ? down[c] : shape_down[c - 3]) -= h;
      const double difference = (std::log(CalcQuantity(ToOscillator(up, shape_up, 1), q)) -
                                 std::log(CalcQuantity(ToOscillator(down, shape_down, 1), q))) /
                                (2 * h);
      EXPECT_NEAR(gradient(static_cast<Eigen::Index>(c)), difference, 1e-9) << q << " by " << c;  // h^2 and rounding/h
    }
  }
}

TEST_P(ForSliders, DualsCarryTheDerivativesOfTheParameters) {
  Levels levels;
  Shape shape;
  FromOscillator(MakeLink(GetParam()), &levels, &shape);
  const Oscillator<double> link = ToOscillator(levels, shape, 1);
  const Oscillator<Dual<12>> dual = ToOscillator<Dual<12>>(levels.data(), shape.data(), GetParam(), 1);
  const Eigen::MatrixXd expected = CalcNaturalDerivatives(link);
  std::vector<Dual<12>> parameters = {dual.k};
  for (const Slider<Dual<12>>& slider : dual.sliders()) parameters.push_back(slider.k);
  for (const Slider<Dual<12>>& slider : dual.sliders()) parameters.push_back(slider.T0);
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    EXPECT_DOUBLE_EQ(parameters[p].a, CalcQuantity(link, static_cast<int>(p)));  // duals divide by way of 1/x
    for (Eigen::Index c = 0; c < 12; ++c)                                        // a few roundings of numbers below 10
      EXPECT_NEAR(parameters[p].v(c), c < expected.cols() ? expected(static_cast<Eigen::Index>(p), c) : 0, 1e-14);
  }
}

TEST_P(ForSliders, JacobianIsThatOfDifferences) {
  const Record record = MakeRecord(MakeLink(GetParam()), 0, true);
  const FitData data = MakeData(record, 1e-5);
  // Away from the truth, so that residuals are not small.
  FitState at = MakeState(MakeLink(GetParam()), {-0.0247, 0.3005, 0.0002});
  at.levels[0][0] += 0.01;
  at.levels[0][2] -= 0.02;
  const Linearisation exact = Linearise(data, at.levels[0], at.shape, at.starts[0]);
  const auto unknowns = static_cast<std::size_t>(exact.jacobian.cols());
  const auto residuals_at = [&](std::size_t c, double step) {
    FitState moved = at;
    const std::size_t shape = moved.shape.size();
    (c < 3 ? moved.levels[0][c] : c < 3 + shape ? moved.shape[c - 3] : moved.starts[0][c - 3 - shape]) += step;
    return CalcResiduals(data, moved.levels[0], moved.shape, moved.starts[0]);
  };
  for (std::size_t c = 0; c < unknowns; ++c) {
    const double h = 2e-6;  // small enough that few samples lie where an event passes, large beside rounding
    const auto p1 = residuals_at(c, h), m1 = residuals_at(c, -h), p2 = residuals_at(c, h / 2),
               m2 = residuals_at(c, -h / 2);
    double scale = 0, error = 0;
    for (std::size_t i = 0; i < data.size; ++i) {
      const double extrapolated = (4 * (p2[i] - m2[i]) / h - (p1[i] - m1[i]) / (2 * h)) / 3;
      scale = std::max(scale, std::abs(extrapolated));
      error = std::max(error, std::abs(extrapolated - data.sigma * exact.jacobian(static_cast<Eigen::Index>(i),
                                                                                  static_cast<Eigen::Index>(c))));
    }
    // Rounding 1e-17 m over 2e-6, and the kinks that an event leaves in the third derivative.
    EXPECT_LT(error, 2e-5 * scale + 1e-10) << "unknown " << c;
  }
}

TEST_P(ForSliders, EvenAndUnevenSamplesGiveTheSameResiduals) {
  const Oscillator<double> link = MakeLink(GetParam());
  const FitState truth = MakeState(link, {-0.025, 0.3, 0.0004});
  for (const bool uniform : {true, false}) {
    const Record record = MakeRecord(link, 0, uniform);
    const FitData data = MakeData(record, 1e-5);
    for (const double residual : CalcResiduals(data, truth.levels[0], truth.shape, truth.starts[0]))
      ASSERT_NEAR(residual, 0, 1e-14);  // rounding of the coordinates (1e-16), a hundred arcs on
  }
}

TEST(Fit, FindsANoiselessLinkToRounding) {
  for (const bool uniform : {true, false}) {
    const Oscillator<double> link = MakeLink(1);
    const Record record = MakeRecord(link, 0, uniform);
    const FitData data = MakeData(record, 1e-5);
    Oscillator<double> guess;
    guess.k = 3.1;
    guess.Add({2.6, 0.016});
    const FitOutcome outcome = Fit({&data, 1}, Sharing::kLink, MakeState(guess, {-0.0245, 0.301, 0.0}),
                                   {.window_s = {1, 2, 4, 8}, .function_tolerance = 1e-16});
    const Oscillator<double> found = ToOscillator(outcome.state.levels[0], outcome.state.shape, link.g);
    // Normal equations see half the digits: 1e-8 of the residual's size at the last step, squared by convergence.
    for (int q = 0; q < 3; ++q)
      EXPECT_NEAR(CalcQuantity(found, q), CalcQuantity(link, q), 1e-9 * CalcQuantity(link, q));
    EXPECT_NEAR(outcome.state.starts[0][0], -0.025, 1e-11);
    EXPECT_NEAR(outcome.state.starts[0][1], 0.3, 1e-9);
    EXPECT_NEAR(outcome.state.starts[0][2], 0.0004, 1e-11);
  }
}

TEST(Fit, EqualRecordsGiveEqualLevelsSharedOrNot) {
  const Oscillator<double> link = MakeLink(2);
  const Record record = MakeRecord(link, 1e-5, true);
  const std::vector<FitData> data(3, MakeData(record, 1e-5));
  FitState shared = MakeState(link, {-0.025, 0.3, 0.0004});
  shared.starts.resize(3, shared.starts[0]);
  FitState own = shared;
  own.levels.resize(3, own.levels[0]);
  const FitOutcome a = Fit(data, Sharing::kLink, shared), b = Fit(data, Sharing::kShape, own);
  EXPECT_NEAR(a.chi2, b.chi2, 1e-6 * a.chi2);
  for (const Levels& levels : b.state.levels)
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_NEAR(levels[j], a.state.levels[0][j], 1e-4);  // flat directions of the shape
}

TEST(Fit, DoesTheSameOnAnyNumberOfThreads) {
  const Oscillator<double> link = MakeLink(1);
  const Record record = MakeRecord(link, 1e-5, true);
  const std::vector<FitData> data(3, MakeData(record, 1e-5));
  FitState start = MakeState(link, {-0.0248, 0.301, 0.0003});
  start.starts.resize(3, start.starts[0]);
  const FitOutcome one = Fit(data, Sharing::kLink, start, {.threads = 1});
  ASSERT_TRUE(one.converged);
  for (const int threads : {0, 2, 1000}) {  // 0: as many as there are; more than these are not taken
    const FitOutcome outcome = Fit(data, Sharing::kLink, start, {.threads = threads});
    EXPECT_TRUE(outcome.converged) << threads << " threads: " << outcome.message;
    // Several threads add the records in the order in which they finish; steps end at 1e-9 of the sum of squares.
    EXPECT_NEAR(outcome.chi2, one.chi2, 1e-8 * one.chi2) << threads << " threads";
  }
}

TEST(Fit, LeavesWhatIsHeld) {
  const Oscillator<double> link = MakeLink(2);
  const Record record = MakeRecord(link, 1e-5, true);
  const FitData data = MakeData(record, 1e-5);
  FitState start = MakeState(link, {-0.0248, 0.301, 0.0003});
  start.levels[0][0] += 0.02;
  const FitOutcome fixed = Fit({&data, 1}, Sharing::kLink, start, {.fix_link = true});
  EXPECT_EQ(fixed.state.levels, start.levels);
  EXPECT_EQ(fixed.state.shape, start.shape);
  EXPECT_NE(fixed.state.starts, start.starts);
  const FitOutcome shape = Fit({&data, 1}, Sharing::kLink, start, {.fix_shape = true});
  EXPECT_EQ(shape.state.shape, start.shape);
  EXPECT_NEAR(shape.state.levels[0][0], std::log(link.k), 1e-3);
}

TEST(Fit, HoldsAQuantityOnItsProfile) {
  const Oscillator<double> link = MakeLink(1);
  const Record record = MakeRecord(link, 1e-5, true);
  const FitData data = MakeData(record, 1e-5);
  const FitOutcome best = Fit({&data, 1}, Sharing::kLink, MakeState(link, {-0.025, 0.3, 0.0004}));
  const double log_k = best.state.levels[0][0];
  const FitOutcome held =
      Fit({&data, 1}, Sharing::kLink, best.state, {.held = std::pair<int, double>{0, log_k + 3e-4}});
  // The data pull back with the slope of their sum of squares, some 1e5 per unit of log k here, against 2e12 of the
  // weight.
  EXPECT_NEAR(held.state.levels[0][0], log_k + 3e-4, 2e-7);
  EXPECT_GT(held.chi2, best.chi2);
  EXPECT_NE(held.state.levels[0][1], best.state.levels[0][1]);  // the others follow
}

TEST(Fit, KeepsTheZeroNearTheCentreOfTheLateMotion) {
  const Oscillator<double> link = MakeLink(1);
  const Record record = MakeRecord(link, 0, true);
  FitData data = MakeData(record, 1e-5);
  data.centre = 0.0004 - 0.010;  // a centre that is wrong by more than the reach
  const FitOutcome outcome = Fit({&data, 1}, Sharing::kLink, MakeState(link, {-0.025, 0.3, 0.0004}));
  EXPECT_NEAR(outcome.state.starts[0][2], data.centre + kZeroReach * data.swing, 1e-12);
}

double CriticalOfFirst(const FitOutcome& outcome) {
  const Oscillator<double> link = ToOscillator(outcome.state.levels[0], outcome.state.shape, 1);
  return link.sliders()[0].T0 / link.sliders()[0].k;
}

TEST(Fit, KeepsCriticalDisplacementsBetweenResolutionAndSwing) {
  const Oscillator<double> link = MakeLink(1);  // 8.1 mm
  const Record record = MakeRecord(link, 0, true);
  const FitState start = MakeState(link, {-0.025, 0.3, 0.0004});
  FitData coarse = MakeData(record, 1e-3), small = coarse;
  coarse.smallest = 0.010;
  small.swing = 0.006;
  // The walls give way by a thousandth for a pull of 1e5 sums of squares, some of which a wrong link has at this noise.
  EXPECT_NEAR(CriticalOfFirst(Fit({&coarse, 1}, Sharing::kLink, start)), 0.010, 0.005 * 0.010);
  EXPECT_NEAR(CriticalOfFirst(Fit({&small, 1}, Sharing::kLink, start)), 0.006, 0.005 * 0.006);
  // Records that share a link resolve what the best of them resolves, in whatever order they come.
  FitState shared = start;
  shared.starts.push_back(start.starts[0]);
  const FitData fine = MakeData(record, 1e-3);
  for (const std::vector<FitData>& data : {std::vector<FitData>{coarse, fine}, std::vector<FitData>{fine, coarse}})
    EXPECT_NEAR(CriticalOfFirst(Fit(data, Sharing::kLink, shared)), 0.018 / 2.21, 1e-9);
}

TEST(Fit, SurvivesWhatTheDataDoNotDetermine) {
  // Two equal sliders cannot be told from one: the split is arbitrary, the sums are not.
  Oscillator<double> link;
  link.k = 3.41;
  link.Add({1.105, 0.009});
  link.Add({1.105, 0.009});
  const Record record = MakeRecord(link, 1e-5, true);
  const FitData data = MakeData(record, 1e-5);
  FitState start = MakeState(link, {-0.025, 0.3, 0.0004});
  start.shape = {0.4, 0.4};
  const FitOutcome outcome = Fit({&data, 1}, Sharing::kLink, start);
  const Oscillator<double> found = ToOscillator(outcome.state.levels[0], outcome.state.shape, link.g);
  // A hundred parts per million are the errors of single records of this noise (see plain_model_test).
  EXPECT_NEAR(CalcQuantity(found, SumOfStiffness(2)), 2.21, 1e-3);
  EXPECT_NEAR(CalcQuantity(found, SumOfFriction(2)), 0.018, 1e-5);
}

}  // namespace
}  // namespace uiclink
