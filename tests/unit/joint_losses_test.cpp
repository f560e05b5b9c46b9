// Where the energy of a run goes.

#include "vehicle/hunting/joint_losses.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <map>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/guidance_history.h"
#include "vehicle/simulation.h"

namespace uiclink {
namespace {

constexpr double kSpeed = 20;
constexpr Perturbation kPush{.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3};

WagonState Pushed(const Wagon& wagon) { return Perturb(wagon, FindEquilibrium(wagon, kSpeed), kPush); }

/// A wagon on the knife edges with further effects in its lateral and longitudinal links.
Wagon MakeExtended(const std::vector<EffectValues>& effects, Suspension suspension = Suspension::kParabolic) {
  WagonFixture fixture;
  fixture.options.suspension = suspension;
  CornerLinks links = fixture.ReadLinks();
  links.lateral.effects = effects;
  links.longitudinal.effects = effects;
  return Wagon(fixture.ReadData(), fixture.ReadBody(), false, {links, links, links, links}, MakeHandMadeTable(),
               fixture.options);
}

struct Case {
  const char* name;
  std::vector<EffectValues> effects;
  Suspension suspension = Suspension::kParabolic;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

class Balance : public testing::TestWithParam<Case> {};

TEST_P(Balance, ClosesToTheToleranceOfTheRun) {
  const Wagon wagon = MakeExtended(GetParam().effects, GetParam().suspension);
  SimulationOptions settle;
  settle.duration = 5;
  const WagonState start = Simulate(wagon, kSpeed, Pushed(wagon), settle).state;
  double coarse = 0, fine = 0;
  EnergyLosses losses;
  for (const double tolerance : {1e-6, 1e-10}) {
    losses = MeasureLosses(wagon, kSpeed, start, 3, {.tolerance = tolerance, .method = {}});
    (tolerance > 1e-8 ? coarse : fine) = std::abs(losses.Residual()) / losses.Lost();
  }
  std::cout << "[ MEASURED ] " << GetParam().name << ": balance off by " << coarse << " at 1e-6, " << fine
            << " at 1e-10, of " << losses.Lost() << " J\n";
  EXPECT_GT(losses.LostInLinks(), 10);  // J
  EXPECT_GT(losses.drive, 50);
  // The residual is the run's own error (wagon_energy_test): from 1e-8 on it falls in proportion to the tolerance, with
  // micro-slip by 0.16, 0.013, 0.0012, 0.00014 J. What the accounts would miss would stay.
  EXPECT_LT(coarse, 2e-2);
  EXPECT_LT(fine, 1e-4);
  EXPECT_LT(fine, coarse / 50);
  EXPECT_DOUBLE_EQ(losses.t1 - losses.t0, 3);
}

EffectValues Effect(const char* id, std::map<std::string, double> parameters) {
  return {.id = id, .parameters = {parameters.begin(), parameters.end()}};
}
INSTANTIATE_TEST_SUITE_P(Wagons, Balance,
                         testing::Values(Case{"plain", {}}, Case{"leaf", {}, Suspension::kLeaf},
                                         Case{"viscous", {Effect("viscous_damping", {{"c", 0.02}})}},
                                         Case{"drag", {Effect("quadratic_drag", {{"d", 0.3}})}},
                                         Case{"cubic", {Effect("cubic_stiffness", {{"k3", 50}})}},
                                         Case{"clearance", {Effect("clearance", {{"gap", 5e-4}})}},
                                         Case{"strengthening", {Effect("velocity_strengthening", {{"b", 1}})}},
                                         Case{"stribeck", {Effect("stribeck_friction", {{"s", 0.3}, {"v_s", 0.05}})}},
                                         Case{"rolling", {Effect("rolling_friction", {{"T_r", 1e-3}})}},
                                         Case{"micro_slip", {Effect("micro_slip", {{"k", 2.0}, {"y_max", 1e-3}})}}),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(JointLosses, OfACycleIsFourTimesForceTimesSlip) {
  // A joint that is swung by +-a sticks over 2 y_c after each turn, and slips over the rest: 4 T0 (a - y_c).
  const Wagon wagon = WagonFixture{}.Make();
  SimulationOptions options;
  options.duration = 60;
  const WagonState start = Simulate(wagon, kSpeed, Pushed(wagon), options).state;
  options.duration = 4;
  options.output_hz = 1000;
  const SimulationResult result = Simulate(wagon, kSpeed, start, options);
  const GuidanceHistory history = CalcGuidanceHistory(wagon, result.samples);
  // From one upper turn of the rear axle boxes to the last: whole cycles of this joint, be the motion what it may.
  const std::vector<double>& d = history.lateral[1].displacement;
  std::vector<std::size_t> upper;
  double slip = 0, low = 0;
  const double y_c = wagon.lateral[2].sliders()[0].y_c;
  for (std::size_t i = 1; i + 1 < d.size(); ++i) {
    low = std::min(low, d[i]);
    if (!(d[i] > d[i - 1] && d[i] >= d[i + 1])) continue;
    if (!upper.empty()) slip += d[upper.back()] + d[i] - 2 * low - 4 * y_c;
    upper.push_back(i);
    low = d[i];
  }
  ASSERT_GE(upper.size(), 3u);
  const double force = wagon.lateral[2].load() * wagon.lateral[2].CalcSlidingForce(0, 1, 0);
  const double t0 = history.t[upper.front()], t1 = history.t[upper.back()];
  const EnergyLosses to_first = MeasureLosses(wagon, kSpeed, start, t0 - start.t, {});
  const EnergyLosses to_last = MeasureLosses(wagon, kSpeed, start, t1 - start.t, {});
  const double measured = to_last.lateral[2].sliders[0] - to_first.lateral[2].sliders[0];
  // Turns are seen to 0.5 a (pi f dt)^2, some 1e-5 of a.
  EXPECT_NEAR(measured, force * slip, 1e-3 * force * slip);
  EXPECT_GT(measured, 1);
}

TEST(JointLosses, AtRestAreNothing) {
  const Wagon wagon = WagonFixture{}.Make();
  const EnergyLosses losses = MeasureLosses(wagon, 5, FindEquilibrium(wagon, 5), 2, {});
  EXPECT_EQ(losses.LostInLinks(), 0);
  EXPECT_NEAR(losses.Lost(), 0, 1e-9);
  EXPECT_NEAR(losses.drive, 0, 1e-6);
}

TEST(JointLosses, AreListedByName) {
  const Wagon wagon =
      MakeExtended({Effect("viscous_damping", {{"c", 0.02}}), Effect("rolling_friction", {{"T_r", 1e-3}}),
                    Effect("micro_slip", {{"k", 2.0}, {"y_max", 1e-3}})});
  const EnergyLosses losses = MeasureLosses(wagon, kSpeed, Pushed(wagon), 1, {});
  const std::vector<LossPart> parts = ListLosses(wagon, losses);
  double sum = 0;
  std::vector<std::string> lateral;
  for (const LossPart& part : parts) {
    sum += part.lost;
    if (part.where == "lateral" && part.corner == 3) lateral.push_back(part.what);
  }
  EXPECT_NEAR(sum, losses.Lost(), 1e-12 * std::abs(sum));
  EXPECT_THAT(lateral, testing::ElementsAre("slider_1", "micro_slip", "rolling_friction", "viscous"));
  for (const LossPart& part : parts) {
    if (part.what != "viscous" && part.what != "rolling_friction") continue;
    EXPECT_GT(part.lost, 0) << part.where;
  }
}

}  // namespace
}  // namespace uiclink
