// The integrator of the wagon and its running equilibrium.

#include "vehicle/integrator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <iostream>
#include <numbers>

#include "tests/support/allocation_counter.h"
#include "tests/support/wagon_fixture.h"
#include "tests/support/wagon_implicit.h"
#include "vehicle/equilibrium.h"
#include "vehicle/runge_kutta.h"
#include "vehicle/simulation.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

/// Hunting at 20 m/s that has settled, with impacts of the rear wheelset and flange contact.
struct Hunting {
  Wagon wagon = WagonFixture{}.Make();
  double V = 20;
  WagonState state;

  Hunting() {
    SimulationOptions options;
    options.duration = 40;
    const Perturbation push{.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3};
    state = Simulate(wagon, V, Perturb(wagon, FindEquilibrium(wagon, V), push), options).state;
  }
};
const Hunting& SettledHunting() {
  static const Hunting hunting;
  return hunting;
}

WagonState RunTo(const Wagon& wagon, double V, const WagonState& start, double t, const IntegratorOptions& options = {},
                 IntegratorCounts* counts = nullptr) {
  Integrator integrator(wagon, options);
  integrator.Start(V, start);
  while (integrator.state().t < t) integrator.Step(t);
  if (counts != nullptr) *counts = integrator.counts();
  return integrator.state();
}

/// Largest difference of the lateral motions [m].
double LateralDifference(const WagonState& a, const WagonState& b) {
  double difference = 0;
  for (std::size_t i : {wheelset::kY + 0, kRearWheelset + wheelset::kY, kBody + body::kY})
    difference = std::max(difference, std::abs(a.x[i] - b.x[i]));
  return difference;
}

// --- Runge-Kutta pairs -----------------------------------------------------------------------------------------------

struct Tableau {
  Eigen::MatrixXd A;
  Eigen::VectorXd b, d, c;
};
Tableau MakeTableau(const RungeKuttaPair& pair) {
  const auto s = static_cast<Eigen::Index>(pair.stages());
  Tableau t{Eigen::MatrixXd::Zero(s, s), Eigen::VectorXd::Zero(s), Eigen::VectorXd(s), {}};
  for (std::size_t i = 0; i < pair.rows.size(); ++i)
    for (std::size_t j = 0; j < pair.rows[i].size(); ++j)
      t.A(static_cast<Eigen::Index>(i + 1), static_cast<Eigen::Index>(j)) = pair.rows[i][j];
  t.b = t.A.row(s - 1).transpose();
  for (Eigen::Index i = 0; i < s; ++i) t.d(i) = pair.embedded[static_cast<std::size_t>(i)];
  t.c = t.A.rowwise().sum();
  return t;
}

class EveryPair : public testing::TestWithParam<const char*> {};

TEST_P(EveryPair, HasOrderFourWithOrderThreeEmbedded) {
  const RungeKuttaPair* pair = FindRungeKuttaPair(GetParam());
  ASSERT_NE(pair, nullptr);
  const Tableau t = MakeTableau(*pair);
  const Eigen::VectorXd c2 = t.c.cwiseProduct(t.c), c3 = c2.cwiseProduct(t.c), Ac = t.A * t.c;
  constexpr double rounding = 1e-14;  // sums of eight products of the order of one
  for (const Eigen::VectorXd& w : {t.b, t.d}) {
    EXPECT_NEAR(w.sum(), 1, rounding);
    EXPECT_NEAR(w.dot(t.c), 1.0 / 2, rounding);
    EXPECT_NEAR(w.dot(c2), 1.0 / 3, rounding);
    EXPECT_NEAR(w.dot(Ac), 1.0 / 6, rounding);
  }
  EXPECT_NEAR(t.b.dot(c3), 1.0 / 4, rounding);
  EXPECT_NEAR(t.b.dot(t.c.cwiseProduct(Ac)), 1.0 / 8, rounding);
  EXPECT_NEAR(t.b.dot(t.A * c2), 1.0 / 12, rounding);
  EXPECT_NEAR(t.b.dot(t.A * Ac), 1.0 / 24, rounding);
  EXPECT_GT(std::abs(t.d.dot(t.A * Ac) - 1.0 / 24), 1e-3) << "the embedded solution has to differ";
}

TEST_P(EveryPair, IsStableAsFarAsItSays) {
  const RungeKuttaPair* pair = FindRungeKuttaPair(GetParam());
  ASSERT_NE(pair, nullptr);
  const Tableau t = MakeTableau(*pair);
  const auto R = [&](std::complex<double> z) {
    Eigen::VectorXd p = Eigen::VectorXd::Ones(t.c.size());
    std::complex<double> sum = 1, power = 1;
    for (Eigen::Index k = 0; k < t.c.size(); ++k) {
      power *= z;
      sum += power * t.b.dot(p);
      p = t.A * p;
    }
    return std::abs(sum);
  };
  for (int i = 1; i <= 100; ++i) {
    EXPECT_LE(R({-0.01 * i * pair->real_extent, 0}), 1 + 1e-3) << i;
    // Hertz contact is damped by 2 % and more.
    const double w = 0.01 * i * pair->imaginary_extent;
    EXPECT_LE(R({-0.024 * w, w}), 1 + 1e-3) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Pairs, EveryPair,
                         testing::Values("UICLINK_RUNGE_KUTTA_5_3_4", "UICLINK_STABLE_7_3_4", "UICLINK_STABLE_8_3_4"),
                         [](const auto& test) { return std::string(test.param); });

// --- Equilibrium -----------------------------------------------------------------------------------------------------

TEST(Equilibrium, CarriesTheWeightAndStandsStraight) {
  const Wagon wagon = WagonFixture{}.Make();
  EquilibriumStats stats;
  const WagonState state = FindEquilibrium(wagon, 20, &stats);
  EXPECT_LT(stats.residual, 1e-10);  // m/s^2: 1e-16 of Hertz forces of 4e4 N on wheelsets of a tonne is 1e-14
  StateVector<double> rate;
  WagonForces forces;
  CalcForces(wagon, 20, state.links, state.x, &rate, &forces);
  double sum = 0;
  for (const auto& wheel : forces.wheels) sum += wheel.Q;
  const double weight = (wagon.body.m + 2 * wagon.wheelset.m) * wagon.g;
  EXPECT_NEAR(sum / weight, 1, 1e-12);
  for (std::size_t i : {wheelset::kX, wheelset::kY, wheelset::kPhi, wheelset::kPsi}) EXPECT_NEAR(state.x[i], 0, 1e-12);
}

ContactTable MakeTable(const std::string& geometry) {
  return CalcContactTable(ReadTrackGeometry(WagonFixture::Data() / "geometry" / (geometry + ".toml")));
}

TEST(Equilibrium, CarriesTheWeightOnRealGeometriesWithEveryFreightAndSuspension) {
  double worst_sum = 0, worst_balance = 0;
  for (const char* geometry : {"nominal-1435", "nominal-1435-rigid", "thesis-equivalent", "thesis-equivalent-rigid"}) {
    const ContactTable table = MakeTable(geometry);
    for (const char* freight : {"empty", "water", "gold", "packed"}) {
      for (const Suspension suspension : {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf}) {
        SCOPED_TRACE(std::string(geometry) + ", " + freight + ", suspension " +
                     std::to_string(static_cast<int>(suspension)));
        WagonFixture fixture{.set = "set1", .freight = freight, .options = {}};
        fixture.options.suspension = suspension;
        const Wagon wagon = fixture.Make(table);
        const WagonState state = FindEquilibrium(wagon, 20);
        StateVector<double> rate;
        WagonForces forces;
        CalcForces(wagon, 20, state.links, state.x, &rate, &forces);
        const double wheel = (0.25 * wagon.body.m + 0.5 * wagon.wheelset.m) * wagon.g;
        double sum = 0;
        for (const auto& w : forces.wheels) sum += w.Q;
        // Forces are right to rounding of the approach, 1e-19 m of 1e-4 m, and sums of four: 1e-14.
        EXPECT_NEAR(sum / (4 * wheel), 1, 1e-13);
        worst_sum = std::max(worst_sum, std::abs(sum / (4 * wheel) - 1));
        for (std::size_t i = 0; i < kCorners; ++i) {
          // The freight lies evenly: each wheel carries a quarter, each spring what it was made for. Newton's method
          // stops at 1e-11 m and rad, one step before the last: 1e-13 m on k = 1e6 N/m is 1e-7 N.
          EXPECT_NEAR(forces.wheels[i].Q / wheel, 1, 1e-9) << i;
          EXPECT_NEAR(forces.spring[i] / wagon.corners[i].load, 1, 1e-9) << i;
          worst_balance = std::max(worst_balance, std::abs(forces.wheels[i].Q / wheel - 1));
        }
        EXPECT_NEAR(forces.wheels[0].Y, -forces.wheels[1].Y, 1e-6 * std::abs(forces.wheels[0].Y));
        for (const std::size_t axle : {std::size_t{0}, kRearWheelset})
          for (std::size_t i : {wheelset::kY, wheelset::kPhi, wheelset::kPsi}) EXPECT_NEAR(state.x[axle + i], 0, 1e-11);
      }
    }
  }
  std::cout << "[ MEASURED ] wheel loads: sum within " << worst_sum << ", each within " << worst_balance
            << " of the weight\n";
}

TEST(Equilibrium, OfEverySuspensionAndUnevenFreight) {
  for (const Suspension suspension : {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf}) {
    WagonFixture fixture;
    fixture.options.suspension = suspension;
    const CornerLinks links = fixture.ReadLinks();
    BodyInertia body = fixture.ReadBody();
    body.y = 0.05;
    body.x = 0.2;
    const Wagon wagon(fixture.ReadData(), body, true, {links, links, links, links}, MakeHandMadeTable(),
                      fixture.options);
    EquilibriumStats stats;
    const WagonState state = FindEquilibrium(wagon, 15, &stats);
    EXPECT_LT(stats.residual, 1e-8);
    // Nothing moves from it; growth of rounding in 2 s is far below.
    const WagonState later = RunTo(wagon, 15, state, 2);
    for (std::size_t i = 0; i < kMotions; ++i) EXPECT_NEAR(later.x[i], state.x[i], 1e-9) << kStateNames[i];
  }
}

TEST(Equilibrium, RefusesSpeedsThatAreNone) {
  const Wagon wagon = WagonFixture{}.Make();
  EXPECT_THROW(FindEquilibrium(wagon, 0), std::invalid_argument);
  EXPECT_THROW(FindEquilibrium(wagon, std::nan("")), std::invalid_argument);
}

// --- Integrator ------------------------------------------------------------------------------------------------------

TEST(WagonIntegrator, DoesNotMoveFromTheEquilibrium) {
  const Wagon wagon = WagonFixture{}.Make();
  const WagonState start = FindEquilibrium(wagon, 20);
  const WagonState end = RunTo(wagon, 20, start, 60);
  // The fastest growing mode has 0.17 1/s: 60 s make 3e4 of a rounding, 1e-17 m at first.
  for (std::size_t i = 0; i < kMotions; ++i) EXPECT_NEAR(end.x[i], start.x[i], 1e-10) << kStateNames[i];
}

TEST(WagonIntegrator, HuntingWithImpactsIsRightToAMillionthOfItsAmplitude) {
  const Hunting& h = SettledHunting();
  const double t = h.state.t + 3;
  IntegratorCounts counts;
  const WagonState usual = RunTo(h.wagon, h.V, h.state, t, {}, &counts);
  IntegratorOptions tight;
  tight.tolerance = 1e-2 * IntegratorOptions{}.tolerance;
  const WagonState exact = RunTo(h.wagon, h.V, h.state, t, tight);
  EXPECT_GT(counts.events, 20);
  EXPECT_LT(LateralDifference(usual, exact), 5.8e-3 * 1e-6);  // amplitude of the wheelsets 5.8 mm
}

TEST(WagonIntegrator, ErrorFallsWithTheTolerance) {
  const Hunting& h = SettledHunting();
  const double t = h.state.t + 2;
  const auto run = [&](double tolerance) {
    IntegratorOptions options;
    options.tolerance = tolerance;
    return RunTo(h.wagon, h.V, h.state, t, options);
  };
  const WagonState exact = run(1e-11);
  const double coarse = LateralDifference(run(1e-6), exact), fine = LateralDifference(run(1e-9), exact);
  // In proportion it would fall by 1000; the corners of the contact curves take some of it.
  EXPECT_LT(fine, coarse / 100);
}

/// Hunting at 20 m/s on S1002 on UIC60, settled: rigid contact jumps, elastic contact does not.
class OnRealProfiles : public testing::TestWithParam<const char*> {};

TEST_P(OnRealProfiles, ErrorAtTheUsualToleranceIsSmallAllTheWay) {
  const Wagon wagon = WagonFixture{}.Make(MakeTable(GetParam()));
  const double V = 20;
  SimulationOptions options;
  options.duration = 40;
  const SimulationResult settled = Simulate(
      wagon, V, Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3}), options);
  ASSERT_EQ(settled.end, SimulationEnd::kDuration) << settled.end_reason;
  const double amplitude = settled.motions[static_cast<std::size_t>(TrackedMotion::kFrontLateral)].amplitude;
  options = {};
  options.duration = 3;
  options.output_hz = 100;
  const auto run = [&](double tolerance) {
    options.integrator.tolerance = tolerance;
    return Simulate(wagon, V, settled.state, options);
  };
  const double usual_tolerance = IntegratorOptions{}.tolerance;
  const SimulationResult usual = run(usual_tolerance), tight = run(1e-2 * usual_tolerance);
  double largest = 0;
  for (std::size_t i = 0; i < usual.samples.size(); ++i)
    largest = std::max(largest, LateralDifference({.t = 0, .x = usual.samples[i].x, .links = {}},
                                                  {.t = 0, .x = tight.samples[i].x, .links = {}}));
  const double at_end = LateralDifference(usual.state, tight.state);
  std::cout << "[ MEASURED ] amplitude " << 1e3 * amplitude << " mm, " << usual.lateral[1].impacts.count << " impacts, "
            << static_cast<double>(usual.counts.rhs_calls) / options.duration << " right-hand sides a second ("
            << static_cast<double>(tight.counts.rhs_calls) / options.duration
            << " tight); error of the amplitude: largest in 3 s " << largest / amplitude << ", at the end "
            << at_end / amplitude << '\n';
  EXPECT_GT(amplitude, 1e-3);
  // The default promises some 1e-6 (IntegratorOptions). Seen from several moments of the hunting: rigid 0.4e-6 to
  // 1.3e-6, elastic 0.6e-6 to 4.4e-6. It scatters because an error of a step counts by where in the flange it is made.
  EXPECT_LT(at_end / amplitude, 1e-5);
  EXPECT_LT(largest / amplitude, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Contact, OnRealProfiles, testing::Values("thesis-equivalent-rigid", "thesis-equivalent"),
                         [](const auto& test) {
                           return std::string(test.param).ends_with("rigid") ? "rigid" : "elastic";
                         });

TEST(WagonIntegrator, AgreesWithCvodeOnTheSameRightHandSide) {
  const Hunting& h = SettledHunting();
  const double t = h.state.t + 1;
  IntegratorOptions tight;
  tight.tolerance = 1e-10;
  const WagonState ours = RunTo(h.wagon, h.V, h.state, t, tight);
  ImplicitCounts counts;
  const WagonState theirs =
      RunImplicit(h.wagon, h.V, h.state, t, {.rtol = 1e-12, .atol = 1e-13, .jacobian = JacobianKind::kExact}, &counts);
  EXPECT_GT(counts.events, 3);
  // BDF of order 5 at 1e-12 per step keeps 1e-9 m over the 1e5 steps that it takes.
  EXPECT_LT(LateralDifference(ours, theirs), 1e-8);
}

TEST(WagonIntegrator, JointsSlideExactlyOnTheirBounds) {
  const Hunting& h = SettledHunting();
  Integrator integrator(h.wagon);
  integrator.Start(h.V, h.state);
  long sliding = 0;
  while (integrator.state().t < h.state.t + 2) {
    integrator.Step(h.state.t + 2);
    const WagonState& now = integrator.state();
    for (std::size_t c = 0; c < kCorners; ++c) {
      const CornerDeflection<double> d = CalcDeflection(h.wagon, now.x, c);
      const Link& link = h.wagon.lateral[c];
      const LinkState& state = now.links.lateral[c];
      for (std::size_t j = 0; j < link.sliders().size(); ++j) {
        const double bound = link.load() * link.sliders()[j].k * link.sliders()[j].y_c;
        const double T = state.CalcJointForce(link, j, d.dy, d.vy);
        if (state.joints[j].slides != 0) {
          ++sliding;
          ASSERT_DOUBLE_EQ(T, -state.joints[j].slides * bound);
        } else {
          // A threshold is taken at most kSlack too far (link.h).
          ASSERT_LE(std::abs(T), bound + link.load() * link.sliders()[j].k * LinkState::kSlack * 2);
        }
      }
    }
  }
  EXPECT_GT(sliding, 100);
}

TEST(WagonIntegrator, AllocatesNothingAfterItsConstruction) {
  const Hunting& h = SettledHunting();
  Integrator integrator(h.wagon);
  const std::size_t before = CountAllocations();
  integrator.Start(h.V, h.state);
  for (int i = 0; i < 3000; ++i) integrator.Step(1e9);
  StateVector<double> x;
  integrator.Interpolate(integrator.state().t, &x);
  EXPECT_GT(integrator.forces().wheels[0].N, 0);
  EXPECT_EQ(CountAllocations(), before);
  EXPECT_GT(integrator.counts().events, 10);
}

TEST(WagonIntegrator, WhatFollowsDependsOnTheStateAlone) {
  const Hunting& h = SettledHunting();
  Integrator fresh(h.wagon), used(h.wagon);
  used.Start(31, h.state);
  for (int i = 0; i < 500; ++i) used.Step(1e9);
  fresh.Start(h.V, h.state);
  used.Start(h.V, h.state);
  for (int i = 0; i < 2000; ++i) {
    fresh.Step(1e9);
    used.Step(1e9);
  }
  EXPECT_EQ(fresh.state().t, used.state().t);
  EXPECT_EQ(fresh.state().x, used.state().x);
}

TEST(WagonIntegrator, NamesWhatItCannotDo) {
  const Wagon wagon = WagonFixture{}.Make();
  IntegratorOptions options;
  options.tolerance = 0;
  EXPECT_THROW(Integrator(wagon, options), std::invalid_argument);
  options = {};
  options.method = "MAGIC";
  EXPECT_THAT([&] { Integrator integrator(wagon, options); },
              testing::ThrowsMessage<std::invalid_argument>(HasSubstr("'MAGIC'")));
  Integrator integrator(wagon);
  EXPECT_THROW(integrator.Start(-1, WagonState{}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
