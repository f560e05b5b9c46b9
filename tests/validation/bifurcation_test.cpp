// Hopf point, folds and multipliers of hunting, each against long runs or differences: set 1, empty, on
// thesis-equivalent, whose diagram is one curve (tests/validation/bifurcations.md).

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

#include "dynamics/continuation.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/fold_bounds.h"
#include "vehicle/hunting/hopf.h"
#include "vehicle/hunting/wagon_flow.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr int kFront = static_cast<int>(TrackedMotion::kFrontLateral);

WagonInputs ReadInputs() {
  WagonChoice choice;
  choice.sets = {"set1"};
  choice.geometry = "thesis-equivalent";
  choice.inertia = InertiaOptions::Printed();
  return ReadWagonInputs(choice);
}

SimulationResult RunFrom(const Wagon& wagon, double V, const WagonState& start, double duration) {
  SimulationOptions options;
  options.duration = duration;
  options.window = 5;
  options.end_at_wheel_lift = false;
  return Simulate(wagon, V, start, options);
}

class BifurcationTest : public testing::Test {
 protected:
  WagonInputs inputs = ReadInputs();
  Wagon wagon = MakeWagon(inputs);

  Crossing FindCrossing() {
    StabilityOptions options;
    options.from = 15;
    options.to = 20;
    options.first_only = true;
    return FindCrossings(wagon, options).crossings.at(0);
  }

  /// The cycle on which both wheelsets meet their guidance, at 14 m/s.
  Cycle FindLargeCycle(WagonFlow& flow) {
    constexpr double V = 14;
    // One of the starts that lead there; wheelsets to opposite sides.
    const WagonState start = Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = 6e-3, .rear_y = -6e-3});
    const auto guess = flow.GuessCycle(start, V, 40);
    if (!guess) throw std::runtime_error("no hunting at 14 m/s");
    return FindCycle(flow, V, guess->state, guess->period, {.tolerance = 1e-6});
  }
};

TEST_F(BifurcationTest, TheHopfPointIsSubcriticalAboveMicrometres) {
  const HopfPoint hopf = ExamineHopf(wagon, FindCrossing());
  ASSERT_TRUE(hopf.type) << hopf.reason;
  EXPECT_EQ(*hopf.type, HopfType::kSubcritical);
  ASSERT_TRUE(hopf.other_below);       // the thesis: supercritical, with folds close by
  EXPECT_LE(*hopf.other_below, 3e-5);  // of the body; its wheelsets move a third of that
  // Normal form: the speed of small cycles goes with the square of their size. Between 0.3 and 1 mm the exponent that
  // the pieces of the contact curve leave is 2 to a tenth.
  const double small = hopf.born.at(5).speed - hopf.crossing.V, large = hopf.born.at(6).speed - hopf.crossing.V;
  EXPECT_NEAR(std::log(large / small) / std::log(hopf.born[6].size / hopf.born[5].size), 2, 0.1);
  for (const BornCycle& born : hopf.born)
    EXPECT_EQ(born.cycle.multipliers_one, 20) << "all 20 joints stick, so all that they remember stays";
}

/// A micrometre of rolling radius within half a millimetre of the middle decides the type: all joints stick there, so
/// that nothing but the contact is not linear. Its odd third power leaves the conicity in the middle as it is.
TEST_F(BifurcationTest, AMicrometreOfRollingRadiusDecidesTheType) {
  const double linear = FindCrossing().V;
  for (const double micrometre : {-1e-6, 1e-6}) {
    WagonInputs changed = inputs;
    for (ContactRow& row : changed.table.rows) {
      const double u = row.y / 0.5e-3;
      row.r += micrometre * u * u * u * std::exp(-u * u);
    }
    wagon = MakeWagon(changed);
    const Crossing crossing = FindCrossing();
    EXPECT_NEAR(crossing.V, linear, 1e-3);
    const HopfPoint hopf = ExamineHopf(wagon, crossing);
    ASSERT_TRUE(hopf.type) << hopf.reason;
    EXPECT_EQ(*hopf.type, micrometre < 0 ? HopfType::kSupercritical : HopfType::kSubcritical);
  }
}

/// Below the crossing an unstable cycle parts what dies from what grows; above it everything grows.
TEST_F(BifurcationTest, RunsOnBothSidesOfTheHopfPointAgree) {
  const Crossing crossing = FindCrossing();
  HopfOptions options;
  options.sizes = {1e-3};
  const HopfPoint hopf = ExamineHopf(wagon, crossing, options);
  const BornCycle& born = hopf.born.back();
  ASSERT_LT(born.speed, crossing.V);
  WagonFlow flow(FamilyBySpeed(wagon), born.speed);
  const Eigen::VectorXd middle = flow.FromWagonState(FindEquilibrium(wagon, born.speed));
  const auto growth = [&](double V, double factor) {
    const WagonState start = flow.ToWagonState(middle + factor * (born.cycle.state - middle), V);
    const SimulationResult early = RunFrom(wagon, V, start, 10);
    const SimulationResult late = RunFrom(wagon, V, early.state, 60);
    return late.motions[kFront].amplitude / early.motions[kFront].amplitude;
  };
  // Its multiplier is 1.018 a period of 1.14 s: a deviation grows by e in 64 s.
  EXPECT_LT(growth(born.speed, 0.7), 0.95);
  EXPECT_GT(growth(born.speed, 1.3), 1.05);
  EXPECT_GT(growth(crossing.V + 0.1, 0.1), 1.5);   // real part 0.0106/s, 60 s: 1.9
  EXPECT_LT(growth(crossing.V - 0.1, 0.05), 0.7);  // the same downwards
}

/// Down the branch of the large cycle; past its fold nothing is left, before it the cycle lives on.
TEST_F(BifurcationTest, RunsOnBothSidesOfTheFoldsAgree) {
  WagonFlow flow(FamilyBySpeed(wagon), 14);
  const Cycle start = FindLargeCycle(flow);
  ContinuationOptions options;
  options.from = 8;
  options.to = 17;
  options.direction = -1;
  options.max_step = 0.5;
  options.cycle.tolerance = 1e-6;
  options.max_points = 120;
  int folds = 0;
  double before = start.lambda;
  int way = -1;
  options.on_point = [&](const Cycle& cycle) {
    if ((cycle.lambda - before) * way < 0) ++folds, way = -way;
    before = cycle.lambda;
    return folds < 3;
  };
  const Branch branch = FollowBranch(flow, start, options);
  std::vector<const BranchEvent*> at;
  for (const BranchEvent& event : branch.events)
    if (event.kind == BranchEventKind::kFold) at.push_back(&event);
  ASSERT_GE(at.size(), 3U) << branch.reason;
  // Two folds close together, where the motion changes its shape, and the last one, where hunting ends for good.
  // Regression values; what joints that do not slip remember moves them by some 0.005 m/s.
  EXPECT_NEAR(at[0]->lambda, 11.595, 0.01);
  EXPECT_NEAR(at[1]->lambda, 11.616, 0.01);
  EXPECT_NEAR(at[2]->lambda, 9.633, 0.02);
  for (const BranchEvent* fold : at) {
    const auto near_one = std::ranges::min(fold->cycle.multipliers, {}, [&](const std::complex<double>& m) {
      return &m == &fold->cycle.multipliers[0] ? 9 : std::abs(m - 1.0);
    });
    EXPECT_NEAR(std::abs(near_one), 1, 0.02) << "the second multiplier at one, to the root of the fold's tolerance";
  }

  const double end = at[2]->lambda;
  const Cycle* last = nullptr;  // the last stable cycle before the fold
  for (const Cycle& cycle : branch.points)
    if (cycle.stable() && cycle.lambda > end + 0.02 && cycle.lambda < 11) last = &cycle;
  ASSERT_NE(last, nullptr);
  const SimulationResult lives = RunFrom(wagon, end + 0.03, flow.ToWagonState(last->state, last->lambda), 300);
  EXPECT_GT(lives.motions[kFront].amplitude, 5e-3);
  // Past a fold the ghost of the cycle holds a motion for a time that goes with 1/sqrt of the distance.
  const SimulationResult dies = RunFrom(wagon, end - 0.1, flow.ToWagonState(last->state, last->lambda), 600);
  EXPECT_LT(dies.motions[kFront].amplitude, 1e-4);
}

/// Packed, on set 2: the cycle that is born turns round at a corner, where the rear links begin to slip. No run is
/// needed to say at which amplitude: the links stick up to T0/k1.
TEST_F(BifurcationTest, ABranchTurnsRoundWhereLinksBeginToSlip) {
  WagonChoice choice;
  choice.sets = {"set2"};
  choice.cargo = "packed";
  choice.geometry = "thesis-equivalent";
  choice.inertia = InertiaOptions::Printed();
  inputs = ReadWagonInputs(choice);
  wagon = MakeWagon(inputs);
  StabilityOptions search;
  search.from = 30;
  search.to = 40;
  search.first_only = true;
  HopfOptions hopf_options;
  hopf_options.sizes = {1e-4, 2e-4};
  const HopfPoint hopf = ExamineHopf(wagon, FindCrossings(wagon, search).crossings.at(0), hopf_options);
  ASSERT_EQ(hopf.born.size(), 2U) << hopf.reason;
  WagonFlow flow(FamilyBySpeed(wagon), hopf.crossing.V);
  ContinuationOptions options;
  options.from = 25;
  options.to = 36;
  options.min_step = 1e-4;
  options.first_step = 0.05;
  options.max_step = 0.5;
  options.cycle.tolerance = 5e-6;
  const Branch branch = FollowBranch(flow, hopf.born[0].cycle, options, &hopf.born[1].cycle);
  EXPECT_EQ(branch.end, BranchEnd::kRange) << branch.reason;
  EXPECT_EQ(branch.points.back().lambda, options.to) << "hunting goes on behind the Hopf point";
  EXPECT_TRUE(branch.points.back().stable());
  std::vector<const BranchEvent*> folds;
  for (const BranchEvent& event : branch.events)
    if (event.kind == BranchEventKind::kFold) folds.push_back(&event);
  ASSERT_EQ(folds.size(), 1U);
  const BranchEvent& corner = *folds[0];
  EXPECT_TRUE(corner.at_corner);
  const auto& slider = inputs.links[0].lateral.sliders.at(0);
  // The rear links' lateral deflection is watched second after the wagon's motions. The corner is reached to the
  // shortest step, 1e-4 of 1 mm in the norm of the state, of which one displacement is up to sqrt(size) times as large.
  EXPECT_NEAR(corner.cycle.Amplitude(static_cast<int>(kMotionCount) + 1), slider.T0 / slider.k, 2e-6);
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    const Cycle& cycle = branch.points[i];
    if (std::abs(cycle.lambda - corner.lambda) > 0.01) {
      EXPECT_EQ(cycle.stable(), i > corner.point) << cycle.lambda;
    }
  }

  const auto last = std::ranges::find_if(branch.points,
                                         [&](const Cycle& c) { return c.stable() && c.lambda > corner.lambda + 0.03; });
  ASSERT_NE(last, branch.points.end());
  const WagonState start = flow.ToWagonState(last->state, last->lambda);
  EXPECT_GT(RunFrom(wagon, corner.lambda + 0.03, start, 200).motions[kFront].amplitude, 1e-3);
  EXPECT_LT(RunFrom(wagon, corner.lambda - 0.2, start, 400).motions[kFront].amplitude, 1e-4);
}

/// The monodromy matrix against differences of the return map, by their leading eigenvalues.
TEST_F(BifurcationTest, MultipliersAreThoseOfTheReturnMap) {
  constexpr double V = 24;
  WagonFlow flow(FamilyBySpeed(wagon), V, {.tolerance = 1e-10});
  const WagonState start = Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = 5e-3, .rear_y = 5e-3});
  const auto guess = flow.GuessCycle(start, V, 60);
  ASSERT_TRUE(guess);
  const Cycle cycle = FindCycle(flow, V, guess->state, guess->period, {.tolerance = 1e-8});
  EXPECT_TRUE(cycle.stable());
  EXPECT_LT(cycle.trivial_error, 1e-5);
  EXPECT_GT(cycle.multipliers_one, 0) << "longitudinal joints that never slip";
  EXPECT_GT(cycle.multipliers_zero, 0) << "lateral joints that slide where the section is";

  Eigen::MatrixXd differences = cycle.passage.by_start;
  std::vector<Eigen::Index> free;
  for (int i = 0; i < flow.size(); ++i) {
    const auto in = [i](const std::vector<int>& set) { return std::ranges::find(set, i) != set.end(); };
    if (in(cycle.passage.held) || in(cycle.passage.slaved_start)) continue;
    free.push_back(i);
    Eigen::VectorXd above = cycle.state, below = cycle.state;
    const double h = 1e-3 * flow.scales()[i];  // 1 um: its square against the curvature of the contact
    above[i] += h;
    below[i] -= h;
    flow.Follow(cycle.state, cycle.passage.slaved_start, &above);
    flow.Follow(cycle.state, cycle.passage.slaved_start, &below);
    differences.col(i) = (flow.Pass(above, cycle.period, V, Flow::Derivatives::kNone).end -
                          flow.Pass(below, cycle.period, V, Flow::Derivatives::kNone).end) /
                         (2 * h);
  }
  const Eigen::VectorXcd values = Eigen::MatrixXd(differences(free, free)).eigenvalues();
  // The four leading ones; of a pair either will do.
  for (std::size_t i = 0; i < 4; ++i) {
    double nearest = 1;
    for (const std::complex<double>& value : values)
      nearest = std::min(nearest, std::abs(value - cycle.multipliers[i]));
    EXPECT_LT(nearest, 2e-4) << "the differences' own error, " << cycle.multipliers[i];
  }
}

/// The gradient of a fold by what it moves when the wagon is changed and its fold is found anew.
TEST_F(BifurcationTest, AFoldMovesAsItsGradientSays) {
  std::array<CornerLinks, kCorners> links = inputs.links;
  for (CornerLinks& corner : links) {
    DirectionParameters& lateral = corner.lateral;
    const double k = 0.01 * lateral.k, k1 = 0.01 * lateral.sliders[0].k, T01 = 0.01 * lateral.sliders[0].T0;
    Covariance covariance;
    covariance.order = {"k", "k1", "T01"};
    covariance.matrix = {{k * k, 0, 0}, {0, k1 * k1, 0}, {0, 0, T01 * T01}};
    lateral.covariance = covariance;
  }
  ScatterOptions options;
  options.draws = 0;
  const SetScatter scatter(links, options);
  WagonFlow flow(FamilyBySpeed(wagon), 14);
  const Cycle start = FindLargeCycle(flow);
  ContinuationOptions down;
  down.from = 11;
  down.to = 15;
  down.direction = -1;
  down.max_step = 0.5;
  down.cycle.tolerance = 1e-6;
  double before = start.lambda;
  down.on_point = [&](const Cycle& cycle) { return std::exchange(before, cycle.lambda) > cycle.lambda; };
  const Branch branch = FollowBranch(flow, start, down);
  const auto fold = std::ranges::find(branch.events, BranchEventKind::kFold, &BranchEvent::kind);
  ASSERT_NE(fold, branch.events.end());
  const Cycle* beyond = nullptr;
  for (const Cycle& cycle : branch.points)
    if (cycle.stable() && cycle.lambda > fold->lambda + 0.05) beyond = &cycle;
  const Eigen::VectorXd gradient = CalcFoldGradient(scatter, wagon, fold->cycle);
  ASSERT_EQ(gradient.size(), 3);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double std = std::sqrt(scatter.covariance()(i, i));
    Eigen::VectorXd values = scatter.centre();
    values[i] += std;
    const double moved = FindFoldNear(WithLinks(wagon, scatter.LinksAt(values)), *beyond, fold->lambda) - fold->lambda;
    // One per cent of the parameter: curvature and the tolerance of two folds, measured 1 to 4 %.
    EXPECT_NEAR(moved, gradient[i] * std, 0.06 * std::abs(gradient[i] * std) + 2e-5)
        << scatter.parameters()[static_cast<std::size_t>(i)].name;
  }
}

}  // namespace
}  // namespace uiclink
