// The wagon as a flow: its derivatives against differences of the run itself, and against what they have to be.

#include "vehicle/hunting/wagon_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/unit/hunting_samples.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

double Norm(const VectorXd& v, const VectorXd& scales) { return v.cwiseQuotient(scales).norm(); }

/// Deviations of free components, some hundredth of their scales each.
VectorXd DrawDirection(const WagonFlow& flow, const Passage& passage, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(-1, 1);
  VectorXd direction = flow.scales();
  for (double& one : direction) one *= share(random);
  for (const auto& set : {passage.slaved_start, passage.held})
    for (const int i : set) direction[i] = 0;
  return direction;
}

struct Hunting : testing::TestWithParam<HuntingSample> {};

const std::vector<HuntingSample>& Samples() {
  static const std::vector<HuntingSample> samples{
      {.name = "free_of_guides", .guidance = false},    {.name = "with_impacts"},
      {.name = "packed", .freight = "packed", .V = 24}, {.name = "leaf_springs", .suspension = Suspension::kLeaf},
      {.name = "extended", .extended = true},
  };
  return samples;
}

// Differences over a share of the scales, 1 mm and 1 mrad. 1e-4 of them: the error of the two runs, of 1e-10 a step,
// times 1e4, and the curvature between them; measured 3e-7 to 9e-6 of the derivative. Leaf springs turn round many
// times in the jitter of their wheelset, at each turn their law has a kink, and the error of differences is
// proportional to the share: measured 6e-3, 4e-4 and 9e-5 for 1e-4, 1e-5 and 1e-6, the last being that of the two runs.
double Share(const HuntingSample& sample) { return sample.suspension == Suspension::kLeaf ? 1e-6 : 1e-4; }
double ErrorOfDifferences(const HuntingSample& sample) { return sample.suspension == Suspension::kLeaf ? 3e-4 : 3e-5; }

TEST_P(Hunting, HasTheDerivativesOfItsOwnRuns) {
  HuntingWagon hunting(GetParam());
  WagonFlow& flow = hunting.flow;
  const double V = hunting.sample.V;
  const Passage passage = flow.Pass(hunting.start, hunting.period, V, Flow::Derivatives::kAll);
  for (const unsigned seed : {1U, 2U}) {
    const VectorXd direction = DrawDirection(flow, passage, seed);
    const double share = Share(hunting.sample);
    VectorXd above = hunting.start + share * direction, below = hunting.start - share * direction;
    flow.Follow(hunting.start, passage.slaved_start, &above);
    flow.Follow(hunting.start, passage.slaved_start, &below);
    const Passage up = flow.Pass(above, hunting.period, V, Flow::Derivatives::kNone);
    const Passage down = flow.Pass(below, hunting.period, V, Flow::Derivatives::kNone);
    ASSERT_EQ(up.character, down.character);
    const VectorXd expected = (up.end - down.end) / (2 * share);
    const VectorXd found = passage.by_start * direction;
    const double error = Norm(found - expected, flow.scales()) / Norm(expected, flow.scales());
    EXPECT_LT(error, ErrorOfDifferences(hunting.sample));
  }
  const double step = 1e-5 * V;
  const VectorXd expected = (flow.Pass(hunting.start, hunting.period, V + step, Flow::Derivatives::kNone).end -
                             flow.Pass(hunting.start, hunting.period, V - step, Flow::Derivatives::kNone).end) /
                            (2 * step);
  const double error = Norm(passage.by_parameter - expected, flow.scales()) / Norm(expected, flow.scales());
  EXPECT_LT(error, ErrorOfDifferences(hunting.sample));
}

// A deviation along the run stays one: by_start f(0) = f(T), for a run of any length, periodic or not. Measured 3e-8 to
// 3e-6: what the run itself is off at its tolerance, and the order 4 of the deviations on its steps.
TEST_P(Hunting, CarriesItsRateAlong) {
  HuntingWagon hunting(GetParam());
  WagonFlow& flow = hunting.flow;
  for (const double T : {0.13, hunting.period}) {
    const Passage passage = flow.Pass(hunting.start, T, hunting.sample.V, Flow::Derivatives::kAll);
    const WagonState state = flow.ToWagonState(hunting.start, hunting.sample.V);
    StateVector<double> rate;
    CalcRate(hunting.wagon, hunting.sample.V, state.links, state.x, &rate);
    VectorXd begin = VectorXd::Zero(flow.size());
    for (std::size_t i = 0; i < hunting.wagon.size(); ++i) begin[static_cast<Index>(i)] = rate[i];
    const double error =
        Norm(passage.by_start * begin - passage.rate, flow.scales()) / Norm(passage.rate, flow.scales());
    EXPECT_LT(error, 1e-5);
  }
}

TEST_P(Hunting, HeldMemoryIsItselfAndSlavedMemoryIsNothing) {
  HuntingWagon hunting(GetParam(), 1e-8);
  const Passage passage = hunting.flow.Pass(hunting.start, hunting.period, hunting.sample.V, Flow::Derivatives::kAll);
  for (const int i : passage.slaved_start) EXPECT_EQ(passage.by_start.col(i).norm(), 0) << i;
  for (const int i : passage.held) {
    EXPECT_EQ(passage.by_start.row(i), Eigen::RowVectorXd::Unit(hunting.flow.size(), i)) << i;
    EXPECT_EQ(passage.end[i], hunting.start[i]);
  }
}

TEST_P(Hunting, StatesComeBackFromBothWaysOfWriting) {
  HuntingWagon hunting(GetParam(), 1e-8);
  VectorXd state = hunting.start;
  for (int i = 0; i < 7; ++i) {
    const VectorXd again = hunting.flow.FromWagonState(hunting.flow.ToWagonState(state, hunting.sample.V));
    // Places of joints that slide follow from a difference of displacements, of some 1e-2 m.
    EXPECT_LT((again - state).cwiseAbs().maxCoeff(), 1e-16) << i;
    state = hunting.flow.Pass(state, 0.11 + 0.01 * i, hunting.sample.V, Flow::Derivatives::kNone).end;
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, Hunting, testing::ValuesIn(Samples()),
                         [](const auto& sample) { return sample.param.name; });

// Deviations too small for any joint to slide.
TEST(WagonFlow, MemoryThatNothingMovesHasMultiplierOne) {
  const Wagon wagon = MakeWagon(HuntingSample{});
  const double V = 15;
  WagonFlow flow(FamilyBySpeed(wagon), V);
  const VectorXd start = flow.FromWagonState(Perturb(wagon, FindEquilibrium(wagon, V), {.body_y = 1e-6}));
  const Passage passage = flow.Pass(start, 0.5, V, Flow::Derivatives::kAll);
  const Index motions = static_cast<Index>(wagon.size()), memory = flow.size() - motions;
  ASSERT_EQ(static_cast<Index>(passage.held.size()), memory);
  EXPECT_TRUE(passage.slaved_start.empty());
  EXPECT_EQ(passage.by_start.bottomRightCorner(memory, memory), Eigen::MatrixXd::Identity(memory, memory));
  EXPECT_EQ(passage.by_start.bottomLeftCorner(memory, motions), Eigen::MatrixXd::Zero(memory, motions));
}

TEST(WagonFlow, FollowsOtherParametersThanTheSpeed) {
  const HuntingSample sample{};
  HuntingWagon hunting(sample, 1e-10);
  WagonFamily family{.name = "lateral stiffness",
                     .unit = "-",
                     .make = [&](double value) { return std::make_shared<const Wagon>(MakeWagon(sample, value)); },
                     .varies_speed = false,
                     .speed = sample.V,
                     .step = 1e-4};
  WagonFlow flow(family, 1.0, {.tolerance = 1e-10});
  const Passage passage = flow.Pass(hunting.start, hunting.period, 1.0, Flow::Derivatives::kAll);
  // Fourth order from steps of the same size and twice that.
  const auto slope = [&](double step) -> VectorXd {
    return (flow.Pass(hunting.start, hunting.period, 1 + step, Flow::Derivatives::kNone).end -
            flow.Pass(hunting.start, hunting.period, 1 - step, Flow::Derivatives::kNone).end) /
           (2 * step);
  };
  const VectorXd expected = (4 * slope(5e-4) - slope(1e-3)) / 3;
  EXPECT_LT(Norm(passage.by_parameter - expected, flow.scales()) / Norm(expected, flow.scales()),
            ErrorOfDifferences(sample));
  const Passage by_speed = hunting.flow.Pass(hunting.start, hunting.period, sample.V, Flow::Derivatives::kAll);
  EXPECT_EQ(passage.by_start, by_speed.by_start);
}

}  // namespace
}  // namespace uiclink
