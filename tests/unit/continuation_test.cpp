#include "dynamics/continuation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "tests/support/test_flows.h"

namespace uiclink {
namespace {

using Eigen::Vector2cd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using std::numbers::pi;
using std::complex_literals::operator""i;

std::vector<BranchEvent> EventsOf(const Branch& branch, BranchEventKind kind) {
  std::vector<BranchEvent> events;
  std::copy_if(branch.events.begin(), branch.events.end(), std::back_inserter(events),
               [kind](const BranchEvent& event) { return event.kind == kind; });
  return events;
}

/// theta' = 1, r' = r g(r^2, lambda).
template <typename Growth>
struct RadialFlow {
  Growth growth;
  template <typename T>
  void operator()(double /*t*/, const T* z, const T& lambda, T* rate) const {
    const T g = growth(T(z[0] * z[0] + z[1] * z[1]), lambda);
    rate[0] = g * z[0] - z[1];
    rate[1] = g * z[1] + z[0];
  }
};

template <typename Growth>
SmoothFlow MakeRadialFlow(Growth growth) {
  return SmoothFlow(MakeModel<2>(RadialFlow<Growth>{growth}));
}

SmoothFlow MakeSubcriticalHopf() {
  return MakeRadialFlow([](const auto& square, const auto& lambda) { return lambda + square - square * square; });
}

SmoothFlow MakeSupercriticalHopf() {
  return MakeRadialFlow([](const auto& square, const auto& lambda) { return lambda - square; });
}

ContinuationOptions MakeOptions(double from, double to) {
  ContinuationOptions options;
  options.from = from;
  options.to = to;
  options.first_step = 0.05;
  options.max_step = 0.2;
  options.fold_tolerance = 1e-9;
  options.cycle.tolerance = 1e-11;
  return options;
}

const Vector2cd kCircle(1, -1i);  // of x = cos t, y = sin t

// r' = lambda r + r^3 - r^5: born at lambda = 0 as lambda = r^4 - r^2, turns round at lambda = -1/4, r^2 = 1/2.
TEST(Continuation, FollowsANormalFormFromItsBirthThroughItsFold) {
  SmoothFlow flow = MakeSubcriticalHopf();
  const ContinuationOptions options = [] {
    ContinuationOptions o = MakeOptions(-0.4, 0.5);
    o.direction = -1;
    return o;
  }();
  const double size = 0.1;
  const Cycle born = FindBornCycle(flow, 0, 1, Vector2d::Zero(), kCircle, size, options.cycle);
  EXPECT_NEAR(born.lambda, std::pow(size, 4) - size * size, 1e-10);  // tolerance / (2 pi size)
  EXPECT_NEAR(born.Amplitude(0), size, 1e-11);
  EXPECT_EQ(born.unstable, 1);

  const Branch branch = FollowBranch(flow, born, options);
  EXPECT_EQ(branch.end, BranchEnd::kRange);
  EXPECT_EQ(branch.points.back().lambda, options.to);
  for (const Cycle& cycle : branch.points) {
    const double square = cycle.state.squaredNorm();
    EXPECT_NEAR(cycle.lambda, square * square - square, 1e-10);
    EXPECT_NEAR(cycle.period, 2 * pi, 1e-9);
    const double exponent = 2 * pi * (2 * square - 4 * square * square);
    EXPECT_NEAR(cycle.multipliers[1].real() / std::exp(exponent), 1, 1e-8);
    EXPECT_LT(cycle.trivial_error, 1e-9);
    EXPECT_EQ(cycle.unstable, square < 0.5 - 1e-4 ? 1 : 0);
  }
  ASSERT_EQ(branch.events.size(), 1u);
  const BranchEvent& fold = branch.events[0];
  EXPECT_EQ(fold.kind, BranchEventKind::kFold);
  EXPECT_NEAR(fold.lambda, -0.25, options.fold_tolerance);
  // lambda + 1/4 = (r^2 - 1/2)^2, so the place along the branch is known to the root of the tolerance, 3e-5; the
  // exponent of the multiplier has the slope 4 pi in r^2.
  EXPECT_NEAR(fold.cycle.multipliers[1].real(), 1, 4 * pi * std::sqrt(options.fold_tolerance));
  EXPECT_LT(branch.points[fold.point].state.norm(), std::sqrt(0.5));
  EXPECT_GT(branch.points[fold.point + 1].state.norm(), std::sqrt(0.5));
  EXPECT_LT(branch.passages_with_derivatives, 4 * static_cast<long>(branch.points.size()));
}

TEST(Continuation, JoinsBothWaysInOneBranch) {
  SmoothFlow flow = MakeSubcriticalHopf();
  ContinuationOptions options = MakeOptions(-0.4, 0.3);
  options.least_extent = 0.02;
  const double square = 0.5 * (1 - std::sqrt(0.6));
  const Cycle start = FindCycle(flow, -0.1, Vector2d(std::sqrt(square), 0), 6.3, {.tolerance = 1e-11, .settle = 0});
  const Branch branch = FollowBothWays(flow, start, options);
  // Down in the parameter through the fold and up to the end of the range; up until the cycle is gone at lambda = 0.
  EXPECT_EQ(branch.begin, BranchEnd::kRange);
  EXPECT_EQ(branch.end, BranchEnd::kEquilibrium);
  EXPECT_EQ(branch.points.front().lambda, 0.3);
  for (std::size_t i = 1; i < branch.points.size(); ++i) {
    EXPECT_LT(branch.points[i].state.norm(), branch.points[i - 1].state.norm());
  }
  ASSERT_EQ(EventsOf(branch, BranchEventKind::kFold).size(), 1u);
  const BranchEvent fold = EventsOf(branch, BranchEventKind::kFold)[0];
  EXPECT_NEAR(fold.lambda, -0.25, options.fold_tolerance);
  EXPECT_GT(branch.points[fold.point].state.norm(), std::sqrt(0.5));
  EXPECT_LT(branch.points[fold.point + 1].state.norm(), std::sqrt(0.5));
}

// x'' - (mu - x^2) x' + x = 0: born at mu = 0 with amplitude 2 sqrt(mu), on the side where rest is unstable.
TEST(Continuation, SeesOnWhichSideACycleIsBorn) {
  const auto rate = [](double, const auto* z, const auto& mu, auto* out) {
    out[0] = z[1];
    out[1] = (mu - z[0] * z[0]) * z[1] - z[0];
  };
  SmoothFlow flow(MakeModel<2>(rate));
  for (const double size : {0.05, 0.1}) {
    // The mode is (1, i) e^(i t): x = cos t, x' = -sin t.
    const Cycle born = FindBornCycle(flow, 0, 1, Vector2d::Zero(), Vector2cd(1, 1i), size, {.tolerance = 1e-12});
    // Van der Pol's expansion in amplitude: mu = size^2/4 (1 + O(size^2)).
    EXPECT_NEAR(born.lambda / (size * size / 4), 1, size * size);
    EXPECT_TRUE(born.stable());
  }
}

TEST(Continuation, EndsWhereTheCycleShrinksToAPoint) {
  SmoothFlow flow = MakeSupercriticalHopf();
  const Cycle start = FindCycle(flow, 0.5, Vector2d(0.7, 0), 6, {.tolerance = 1e-11});
  ContinuationOptions options = MakeOptions(-1, 1);
  options.direction = -1;
  for (const double least_extent : {0.0, 0.1}) {  // without it the branch is seen to come out on the other side
    options.least_extent = least_extent;
    const Branch branch = FollowBranch(flow, start, options);
    EXPECT_EQ(branch.end, BranchEnd::kEquilibrium);
    EXPECT_TRUE(branch.events.empty());
    EXPECT_GT(branch.points.back().lambda, 0);
    EXPECT_LT(branch.points.back().lambda, 0.2 * 0.2);  // one longest step before the radius zero, lambda = r^2
  }
}

// r' = r (h^2 - lambda^2 - (r^2 - 1)^2): cycles (r^2 - 1)^2 + lambda^2 = h^2, a closed curve with folds at lambda =
// +-h.
TEST(Continuation, GoesRoundAnIsola) {
  const double h = 0.4;
  SmoothFlow flow = MakeRadialFlow([h](const auto& square, const auto& lambda) {
    return h * h - lambda * lambda - (square - 1.0) * (square - 1.0);
  });
  const Cycle start = FindCycle(flow, 0.1, Vector2d(1.17, 0), 6.3, {.tolerance = 1e-11});
  const Branch branch = FollowBothWays(flow, start, MakeOptions(-1, 1));
  EXPECT_EQ(branch.end, BranchEnd::kClosed);
  const std::vector<BranchEvent> folds = EventsOf(branch, BranchEventKind::kFold);
  ASSERT_EQ(folds.size(), 2u);
  ASSERT_EQ(branch.events.size(), 2u);
  EXPECT_NEAR(folds[0].lambda, -h, 1e-9);
  EXPECT_NEAR(folds[1].lambda, h, 1e-9);
  EXPECT_NEAR(branch.points.back().state.norm(), start.state.norm(), 1e-9);
}

/// A circle of radius 1 with two directions beside it, in which a vector q moves by  q' = M(theta, lambda) q - q |q|^2:
/// the place where its multiplier passes the unit circle is lambda = 0 by construction.
enum class Beside { kPeriodDoubling, kTorus, kPitchfork };

struct BesideACircle {
  Beside kind;
  template <typename T>
  void operator()(double /*t*/, const T* z, const T& lambda, T* rate) const {
    const T growth = 1.0 - z[0] * z[0] - z[1] * z[1], damp = z[2] * z[2] + z[3] * z[3];
    rate[0] = growth * z[0] - z[1];
    rate[1] = growth * z[1] + z[0];
    if (kind == Beside::kPeriodDoubling) {
      // Axes that turn half a turn a period: q along the first grows by -exp(2 pi lambda), the other by -exp(-2 pi).
      const T mean = 0.5 * (lambda - 1.0), half = 0.5 * (lambda + 1.0);
      rate[2] = (mean + half * z[0]) * z[2] + (half * z[1] - 0.5) * z[3];
      rate[3] = (half * z[1] + 0.5) * z[2] + (mean - half * z[0]) * z[3];
    } else if (kind == Beside::kTorus) {
      rate[2] = lambda * z[2] - 0.3 * z[3];
      rate[3] = 0.3 * z[2] + lambda * z[3];
    } else {
      rate[2] = lambda * z[2];
      rate[3] = -1.0 * z[3];
    }
    rate[2] -= damp * z[2];
    rate[3] -= damp * z[3];
  }
};

class FlaggedEvent : public testing::TestWithParam<std::pair<Beside, BranchEventKind>> {};

TEST_P(FlaggedEvent, LiesWhereItWasPut) {
  SmoothFlow flow(MakeModel<4>(BesideACircle{GetParam().first}));
  const Cycle start = FindCycle(flow, -0.11, Eigen::Vector4d(1, 0, 0, 0), 6, {.tolerance = 1e-11});
  ContinuationOptions options = MakeOptions(-0.2, 0.2);
  options.max_step = 0.07;
  const Branch branch = FollowBranch(flow, start, options);
  EXPECT_EQ(branch.end, BranchEnd::kRange);
  ASSERT_EQ(branch.events.size(), 1u);
  EXPECT_EQ(branch.events[0].kind, GetParam().second);
  EXPECT_NEAR(branch.events[0].lambda, 0, options.fold_tolerance);
  EXPECT_EQ(branch.points.front().unstable, 0);
  EXPECT_EQ(branch.points.back().unstable, GetParam().first == Beside::kTorus ? 2 : 1);
}
INSTANTIATE_TEST_SUITE_P(Kinds, FlaggedEvent,
                         testing::Values(std::pair{Beside::kPeriodDoubling, BranchEventKind::kPeriodDoubling},
                                         std::pair{Beside::kTorus, BranchEventKind::kTorus},
                                         std::pair{Beside::kPitchfork, BranchEventKind::kBranchPoint}));

/// A flow that cannot go on above a parameter.
class BlockedFlow : public SmoothFlow {
 public:
  BlockedFlow(SmoothFlow flow, double most) : SmoothFlow(std::move(flow)), most_(most) {}
  Passage Pass(const VectorXd& start, double T, double lambda, Derivatives wanted) override {
    if (lambda > most_) throw std::runtime_error("derailed");
    return SmoothFlow::Pass(start, T, lambda, wanted);
  }

 private:
  double most_;
};

TEST(Continuation, SaysWhyItLosesTheBranch) {
  BlockedFlow flow(MakeSupercriticalHopf(), 0.613);
  const Cycle start = FindCycle(flow, 0.5, Vector2d(0.7, 0), 6, {.tolerance = 1e-11});
  const Branch branch = FollowBranch(flow, start, MakeOptions(0, 1));
  EXPECT_EQ(branch.end, BranchEnd::kLost);
  EXPECT_THAT(branch.reason, testing::HasSubstr("derailed at parameter 0.61"));
  EXPECT_NEAR(branch.points.back().lambda, 0.613, 1e-4);  // a few shortest steps before
}

TEST(Continuation, StopsWhenTold) {
  SmoothFlow flow = MakeSupercriticalHopf();
  const Cycle start = FindCycle(flow, 0.2, Vector2d(0.5, 0), 6, {.tolerance = 1e-11});
  ContinuationOptions options = MakeOptions(0, 10);
  options.max_points = 5;
  EXPECT_EQ(FollowBranch(flow, start, options).end, BranchEnd::kPoints);
  EXPECT_EQ(FollowBranch(flow, start, options).points.size(), 5u);
  options.on_point = [](const Cycle& cycle) { return cycle.lambda < 0.3; };
  EXPECT_EQ(FollowBranch(flow, start, options).end, BranchEnd::kStopped);
  options.from = 0.2;  // at the bound already
  options.direction = -1;
  EXPECT_EQ(FollowBranch(flow, start, options).end, BranchEnd::kRange);
  EXPECT_EQ(FollowBranch(flow, start, options).points.size(), 1u);
}

TEST(Continuation, TakesItsFirstStepTowardsAState) {
  SmoothFlow flow = MakeSubcriticalHopf();
  const auto at = [&flow](double r) {
    return FindCycle(flow, r * r * r * r - r * r, Vector2d(r, 0), 6.3, {.tolerance = 1e-11, .settle = 0});
  };
  const double fold = std::sqrt(0.5);  // both sides have the same parameter: only the state tells the ways apart
  const Cycle start = at(fold + 0.02), up = at(fold + 0.03), down = at(fold + 0.01);
  EXPECT_GT(FollowBranch(flow, start, MakeOptions(-1, 1), &up).points[1].state.norm(), start.state.norm());
  EXPECT_LT(FollowBranch(flow, start, MakeOptions(-1, 1), &down).points[1].state.norm(), start.state.norm());
}

/// theta' = 1, r' = (lambda - slope (r - 1))/20 with another slope inside than outside of r = 1, in closed form. The
/// cycles lie on two straight lines that meet at lambda = 0, r = 1.
class KinkedFlow : public Flow {
 public:
  KinkedFlow(double inside, double outside) : inside_(inside), outside_(outside) {}
  int size() const override { return 2; }
  const VectorXd& scales() const override { return scales_; }
  const std::vector<std::string>& watched() const override { return names_; }

  Passage Pass(const VectorXd& start, double T, double lambda, Derivatives) override {
    const double r = start.norm(), angle = std::atan2(start[1], start[0]);
    Radius radius{r - 1, 1, 0};
    const double here = radius.x < 0 ? inside_ : outside_, there = radius.x < 0 ? outside_ : inside_;
    Radius end = Move(radius, T, lambda, here);
    if (end.x * radius.x < 0) {  // x = 0 is met once; the rate is the same on both sides
      const double crossing = -20 / here * std::log(lambda / (lambda - here * radius.x));
      end = Move(radius, crossing, lambda, here);
      end.x = 0;
      end = Move(end, T - crossing, lambda, there);
    }
    const Vector2d before(std::cos(angle), std::sin(angle)), after(std::cos(angle + T), std::sin(angle + T));
    const Vector2d across_before(-before[1], before[0]), across_after(-after[1], after[0]);
    Passage passage;
    passage.end = (1 + end.x) * after;
    passage.rate = (lambda - (end.x < 0 ? inside_ : outside_) * end.x) / 20 * after + (1 + end.x) * across_after;
    passage.by_start =
        end.by_x * after * before.transpose() + (1 + end.x) / r * across_after * across_before.transpose();
    passage.by_parameter = end.by_lambda * after;
    passage.greatest = VectorXd::Constant(1, 1 + std::max(radius.x, end.x));
    passage.least = -passage.greatest;
    passage.character = radius.x < 0 ? "inside" : "outside";
    return passage;
  }

 private:
  struct Radius {
    double x, by_x, by_lambda;  ///< r - 1, and its derivatives by its start and by the parameter
  };
  static Radius Move(const Radius& from, double T, double lambda, double slope) {
    const double factor = std::exp(-slope / 20 * T), aim = lambda / slope;
    return {aim + (from.x - aim) * factor, factor * from.by_x, factor * from.by_lambda + (1 - factor) / slope};
  }

  double inside_, outside_;
  VectorXd scales_ = VectorXd::Ones(2);
  std::vector<std::string> names_{"x"};
};

struct Slopes {
  double inside, outside;
};

class CornerOfABranch : public testing::TestWithParam<Slopes> {};

TEST_P(CornerOfABranch, IsTurnedWhateverItsAngle) {
  const auto [inside, outside] = GetParam();
  KinkedFlow flow(inside, outside);
  const double r0 = 0.95, lambda0 = inside * (r0 - 1);
  ContinuationOptions options = MakeOptions(-4, 4);
  options.direction = inside > 0 ? 1 : -1;  // outwards
  options.max_points = 60;
  options.max_step = 0.1;
  const Cycle start = FindCycle(flow, lambda0, Vector2d(r0, 0), 6.3, {.tolerance = 1e-11, .settle = 0});
  const Branch branch = FollowBranch(flow, start, options);
  EXPECT_NE(branch.end, BranchEnd::kLost) << branch.reason;
  EXPECT_GT(branch.points.back().state.norm(), 1.05);
  for (std::size_t i = 1; i < branch.points.size(); ++i) {
    const double r = branch.points[i].state.norm();
    EXPECT_GT(r, branch.points[i - 1].state.norm()) << "the branch has gone back";
    EXPECT_NEAR(branch.points[i].lambda, (r < 1 ? inside : outside) * (r - 1), 1e-10);
  }
  const std::vector<BranchEvent> folds = EventsOf(branch, BranchEventKind::kFold);
  if (inside * outside > 0) {
    EXPECT_TRUE(folds.empty());
  } else {
    ASSERT_EQ(folds.size(), 1u);
    EXPECT_TRUE(folds[0].at_corner);
    // Both sides are straight in r; in the state they are, too, along the ray on which the phase condition holds them.
    EXPECT_NEAR(folds[0].lambda, 0, 1e-8);
    EXPECT_LT(branch.points[folds[0].point].state.norm(), 1);
    EXPECT_GT(branch.points[folds[0].point + 1].state.norm(), 1);
  }
}

// The branch turns by 2.5 to 176.6 degrees in the plane of the norm, (r / sqrt(2), lambda).
INSTANTIATE_TEST_SUITE_P(Continuation, CornerOfABranch,
                         testing::Values(Slopes{1, 1.1}, Slopes{0.5, 5}, Slopes{-1, 1}, Slopes{-1, 0.2},
                                         Slopes{-0.3, 4}, Slopes{2, -3}, Slopes{-5, 10}, Slopes{-30, 20}));

}  // namespace
}  // namespace uiclink
