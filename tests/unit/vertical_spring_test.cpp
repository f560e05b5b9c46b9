#include "vehicle/vertical_spring.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "vehicle/event_ode.h"

namespace uiclink {
namespace {

/// Table 5.1 and section 5.3.1.
ParabolicSpring Parabolic() {
  return {.F0 = 41.1e3, .s0 = 62.9e-3, .k2 = 1.82e6, .d_unloaded = 34440, .d_loaded = 50652};
}
LeafSpring Leaf(double beta) { return {.c = 0.65e6, .mu0 = 0.2, .F_r = 4350, .beta = beta}; }

// --- linear and parabolic ---

TEST(LinearSpring, HasForceAndSlopes) {
  const LinearSpring spring{.k = 0.65e6, .d = 34440};
  const Dual<2> F = CalcSpringForce(spring, Dual<2>(0.05, 0), Dual<2>(-0.2, 1));
  EXPECT_DOUBLE_EQ(F.a, 0.65e6 * 0.05 - 34440 * 0.2);
  EXPECT_EQ(F.v[0], spring.k);
  EXPECT_EQ(F.v[1], spring.d);
  EXPECT_DOUBLE_EQ(CalcSpringForce(spring, CalcStaticCompression(spring, 33e3), 0.0), 33e3);
}

TEST(ParabolicSpring, IsContinuousWhereTheSupplementaryLeafEngages) {
  const ParabolicSpring spring = Parabolic();
  // F0 = k1 s0 with one rounding of the quotient and one of the product.
  EXPECT_NEAR(CalcStaticForce(spring, SpringStage::kMainLeaf, spring.s0), spring.F0, 2e-16 * spring.F0 * 2);
  EXPECT_EQ(CalcStaticForce(spring, SpringStage::kSupplementary, spring.s0), spring.F0);
  EXPECT_EQ(StageOf(spring, spring.s0), SpringStage::kSupplementary);
  EXPECT_EQ(StageOf(spring, std::nextafter(spring.s0, 0.0)), SpringStage::kMainLeaf);
  EXPECT_EQ(CalcStageGuard(spring, spring.s0), 0);
  EXPECT_GT(CalcStageGuard(spring, 0.0), 0);
}

TEST(ParabolicSpring, SlopesAreThoseOfItsStages) {
  const ParabolicSpring spring = Parabolic();
  for (const double s : {0.02, 0.06, 0.0629, 0.08}) {
    const Dual<2> F = CalcSpringForce(spring, spring.d_loaded, Dual<2>(s, 0), Dual<2>(0.1, 1));
    EXPECT_EQ(F.v[0], s < spring.s0 ? spring.k1() : spring.k2) << s;
    EXPECT_EQ(F.v[1], spring.d_loaded) << s;
  }
}

TEST(ParabolicSpring, CarriesItsLoadAtItsStaticCompression) {
  const ParabolicSpring spring = Parabolic();
  for (const double load : {0.0, 1e3, 33297.0, 41.1e3, 50e3, 82397.0}) {
    // A handful of roundings.
    EXPECT_NEAR(CalcStaticForce(spring, CalcStaticCompression(spring, load)), load, 1e-15 * 1e5) << load;
  }
  EXPECT_EQ(DampingOf(spring, 33297), spring.d_unloaded);
  EXPECT_EQ(DampingOf(spring, 82397), spring.d_loaded);
}

TEST(ParabolicSpring, EnergyIsTheIntegralOfTheForce) {
  const ParabolicSpring spring = Parabolic();
  for (const double s : {0.03, 0.0629, 0.09}) {
    const Dual<1> energy = CalcSpringEnergy(spring, Dual<1>(s, 0));
    EXPECT_NEAR(energy.v[0], CalcStaticForce(spring, s), 1e-15 * 1e5) << s;  // roundings
  }
  EXPECT_NEAR(CalcSpringEnergy(spring, std::nextafter(spring.s0, 0.0)), CalcSpringEnergy(spring, spring.s0), 1e-12);
}

TEST(ParabolicSpring, LosesPiDWASquaredInACycle) {
  const ParabolicSpring spring = Parabolic();
  const double a = 0.0428, w = 2 * std::numbers::pi, mean = 0.0856;  // crosses s0
  // Power F s' over one cycle by the trapezoidal rule; the damper's share is exact for a sine, what is left is that of
  // the static force, whose kinks at s0 make an error of second order in the step: (2 pi/n)^2 k a^2 / 12.
  const int n = 20000;
  double loss = 0;
  for (int i = 0; i < n; ++i) {
    const double phase = 2 * std::numbers::pi * i / n;
    const double v = a * w * std::cos(phase);
    loss +=
        CalcSpringForce(spring, spring.d_loaded, mean + a * std::sin(phase), v) * v / (w * n) * 2 * std::numbers::pi;
  }
  const double expected = std::numbers::pi * spring.d_loaded * w * a * a;
  EXPECT_NEAR(loss, expected, std::pow(2 * std::numbers::pi / n, 2) * spring.k2 * a * a);
}

TEST(EquivalentDamping, LosesWhatDryFrictionDoes) {
  const double mu = 0.13, N = 33297, a = 0.0255;
  for (const double w : {1.0, 2 * std::numbers::pi, 14.0}) {
    const double d = CalcEquivalentDamping(mu, N, a, w);
    EXPECT_DOUBLE_EQ(std::numbers::pi * d * w * a * a, 4 * a * mu * N);
  }
}

// --- Fancher's leaf spring ---

TEST(LeafSpring, RateIsThatOfTheEquation) {
  const LeafSpring spring = Leaf(1e-3);
  const double s = 0.03, F = 20e3;
  EXPECT_DOUBLE_EQ(CalcLeafRate(spring, F, s, 0.2), (0.65e6 * 1.2 * s + 4350 - F) / 1e-3 * 0.2);
  EXPECT_DOUBLE_EQ(CalcLeafRate(spring, F, s, -0.2), (0.65e6 * 0.8 * s - 4350 - F) / 1e-3 * 0.2);
  EXPECT_EQ(CalcLeafRate(spring, F, s, 0.0), 0);
}

TEST(LeafSpring, RateHasExactSlopes) {
  const LeafSpring spring = Leaf(2e-3);
  for (const double v : {0.15, -0.15}) {
    const Dual<3> rate = CalcLeafRate(spring, Dual<3>(21e3, 0), Dual<3>(0.03, 1), Dual<3>(v, 2));
    const double sign = v > 0 ? 1 : -1;
    const double gap = CalcEnvelope(spring, v > 0, 0.03) - 21e3;
    EXPECT_DOUBLE_EQ(rate.v[0], -std::abs(v) / 2e-3);
    EXPECT_DOUBLE_EQ(rate.v[1], EnvelopeSlope(spring, v > 0) * std::abs(v) / 2e-3);
    EXPECT_DOUBLE_EQ(rate.v[2], sign * gap / 2e-3);
  }
}

TEST(LeafSpring, ClosedFormSolvesTheEquation) {
  // dF/ds = (E - F)/beta while loading, -(E - F)/beta while unloading; the derivative is exact, so only rounding is
  // left: 1e-12 of E/beta.
  for (const double beta : {1e-3, 5e-3, 0.05}) {
    const LeafSpring spring = Leaf(beta);
    for (const double s : {0.031, 0.0305, 0.0295, 0.01}) {
      const bool loading = s >= 0.03;
      const Dual<1> F = CalcLeafForce(spring, Dual<1>(0.03), Dual<1>(19e3), Dual<1>(s, 0));
      const double expected = (loading ? 1 : -1) * (CalcEnvelope(spring, loading, s) - F.a) / beta;
      EXPECT_NEAR(F.v[0], expected, 1e-12 * 3e4 / beta) << "beta " << beta << ", s " << s;
    }
    EXPECT_DOUBLE_EQ(CalcLeafForce(spring, 0.03, 19e3, 0.03), 19e3);
  }
}

TEST(LeafSpring, WorkIsTheIntegralOfTheForce) {
  const LeafSpring spring = Leaf(2e-3);
  for (const double s : {0.045, 0.012}) {
    const Dual<1> work = CalcLeafWork(spring, Dual<1>(0.03), Dual<1>(19e3), Dual<1>(s, 0));
    EXPECT_NEAR(work.v[0], CalcLeafForce(spring, 0.03, 19e3, s), 1e-13 * 4e4);  // roundings
  }
  EXPECT_EQ(CalcLeafWork(spring, 0.03, 19e3, 0.03), 0);
}

/// The force along s(t) = mean + a sin wt by the integrator: the form that the wagon uses.
std::vector<double> IntegrateForce(const LeafSpring& spring, double a, std::size_t samples, double step, double rtol) {
  bool loading = true;
  const double w = 2 * std::numbers::pi;
  EventOde ode;
  ode.size = 1;
  ode.guards = 1;
  ode.rate = [&](double t, std::span<const double> F, std::span<double> rate) {
    rate[0] = CalcLeafRate(spring, loading, F[0], a * std::sin(w * t), a * w * std::cos(w * t));
  };
  ode.guard = [&](double t, std::span<const double>, std::span<double> guards) { guards[0] = std::cos(w * t); };
  ode.pass = [&](double, std::span<double>, std::span<const int> crossed) { loading = crossed[0] > 0; };
  std::vector<double> forces;
  const std::array<double, 1> start{0};
  SolveEventOde(ode, start, step, samples,
                [&](std::size_t, double, std::span<const double> F) { forces.push_back(F[0]); },
                {.rtol = rtol, .atol = {rtol * 1e4}, .max_step = step});
  return forces;
}

TEST(LeafSpring, ClosedFormIsWhatTheIntegratorFinds) {
  const LeafSpring spring = Leaf(1e-3);
  const double a = 0.0255, step = 0.005, w = 2 * std::numbers::pi;
  const std::vector<double> forces = IntegrateForce(spring, a, 401, step, 1e-10);
  double s_start = 0, F_start = 0, next_turn = 0.25, side = 1;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const double t = step * static_cast<double>(i);
    while (t > next_turn) {
      F_start = CalcLeafForce(spring, s_start, F_start, side * a);
      s_start = side * a;
      side = -side;
      next_turn += 0.5;
    }
    // The equation damps errors over beta of travel, so the error stays that of some steps: 100 x rtol x 2e4 N.
    ASSERT_NEAR(forces[i], CalcLeafForce(spring, s_start, F_start, a * std::sin(w * t)), 2e-4) << "t = " << t;
  }
}

}  // namespace
}  // namespace uiclink
