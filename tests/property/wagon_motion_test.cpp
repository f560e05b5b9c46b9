// What every run of the wagon has to keep: mirror symmetry, energy, Klingel's wavelength.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"

namespace uiclink {
namespace {

/// The state seen in a mirror along the track: y, phi, psi and their rates change sign, left and right change places.
WagonState Mirror(const Wagon& wagon, const WagonState& state) {
  WagonState mirrored = state;
  for (std::size_t axle = 0; axle < kAxles; ++axle)
    for (std::size_t i :
         {wheelset::kY, wheelset::kYRate, wheelset::kPhi, wheelset::kPhiRate, wheelset::kPsi, wheelset::kPsiRate})
      mirrored.x[axle * wheelset::kSize + i] *= -1;
  for (std::size_t i : {body::kY, body::kYRate, body::kPhi, body::kPhiRate, body::kPsi, body::kPsiRate})
    mirrored.x[kBody + i] *= -1;
  for (std::size_t i = 0; i < kCorners; ++i) {
    mirrored.links.longitudinal[i] = LinkState::AtRest(wagon.longitudinal[i], 0);
    mirrored.links.lateral[i] = LinkState::AtRest(wagon.lateral[i], 0);
  }
  return mirrored;
}

struct Choice {
  const char* set;
  const char* freight;
  const char* geometry;  ///< null: the knife edges of the fixture
};

class WagonMotion : public testing::TestWithParam<Choice> {
 protected:
  Wagon MakeWagon() const {
    const Choice& choice = GetParam();
    WagonFixture fixture{.set = choice.set, .freight = choice.freight, .options = {}};
    return choice.geometry == nullptr ? fixture.Make() : fixture.MakeOn(choice.geometry);
  }
};

TEST_P(WagonMotion, MirroredStartGivesMirroredRun) {
  const Wagon wagon = MakeWagon();
  WagonState start = FindEquilibrium(wagon, 20);
  for (std::size_t i = 0; i < kCorners; ++i) {
    start.links.longitudinal[i] = LinkState::AtRest(wagon.longitudinal[i], 0);
    start.links.lateral[i] = LinkState::AtRest(wagon.lateral[i], 0);
  }
  start = Perturb(wagon, start, {.front_y = 3e-3, .rear_y = -1e-3, .body_y = 12e-3, .body_psi = 1e-3});
  WagonState other = Mirror(wagon, start);
  SimulationOptions options;
  options.duration = 5;
  const WagonState end = Simulate(wagon, 20, start, options).state;
  const WagonState mirrored = Mirror(wagon, Simulate(wagon, 20, other, options).state);
  // Rounding of sums in another order, 1e-17 m, and what 5 s of hunting make of it.
  for (std::size_t i = 0; i < kMotions; ++i) EXPECT_NEAR(end.x[i], mirrored.x[i], 1e-10) << kStateNames[i];
}

/// Energy of body, and of what holds it to the axle boxes: the change of the body's kinetic energy is the power of the
/// forces at its corners and of its weight, all along a run.
TEST_P(WagonMotion, PowerOnTheBodyIsTheRateOfItsEnergy) {
  const Wagon wagon = MakeWagon();
  const WagonState start =
      Perturb(wagon, FindEquilibrium(wagon, 20), {.front_y = 3e-3, .rear_y = -1e-3, .body_y = 18e-3, .body_phi = 5e-3});
  Integrator integrator(wagon);
  integrator.Start(20, start);
  double largest = 0;
  double work = 0, kinetic_start = 0;
  const auto kinetic = [&](const StateVector<double>& x) {
    const auto v = [&](std::size_t i) { return x[kBody + i]; };
    const BodyInertia& b = wagon.body;
    return 0.5 * (b.m * (v(body::kYRate) * v(body::kYRate) + v(body::kZRate) * v(body::kZRate)) +
                  b.I_x * v(body::kPhiRate) * v(body::kPhiRate) + b.I_z * v(body::kPsiRate) * v(body::kPsiRate));
  };
  // Power of the forces at the corners, in the body's frame for the moments, and of the weight.
  const auto power = [&](const StateVector<double>& x, const WagonForces& f) {
    const auto v = [&](std::size_t i) { return x[kBody + i]; };
    double P = -wagon.body.m * wagon.g * v(body::kZRate);
    for (std::size_t i = 0; i < kCorners; ++i) {
      const double Px = f.link_x[i] + f.guide_x[i], Py = f.link_y[i] + f.guide_y[i], Pz = -f.spring[i];
      const double phi = v(body::kPhi), psi = v(body::kPsi);
      const double Bx = -(Px + psi * Py), By = psi * Px - Py - phi * Pz, Bz = phi * Py - Pz;
      P += -Py * v(body::kYRate) - Pz * v(body::kZRate) +
           (wagon.body.h * By + wagon.corners[i].Y * Bz) * v(body::kPhiRate) +
           (wagon.corners[i].X * By - wagon.corners[i].Y * Bx) * v(body::kPsiRate);
    }
    return P;
  };
  kinetic_start = kinetic(start.x);
  double before = power(start.x, integrator.forces());
  while (integrator.state().t < 2) {
    const double t = integrator.state().t;
    integrator.Step(2);
    const double h = integrator.state().t - t;
    // Simpson's rule over the step, with the middle from the interpolant.
    StateVector<double> middle, rate;
    WagonForces forces;
    integrator.Interpolate(t + 0.5 * h, &middle);
    CalcForces(wagon, 20, integrator.step_links(), middle, &rate, &forces);
    const double now = power(integrator.state().x, integrator.forces());
    work += h / 6 * (before + 4 * power(middle, forces) + now);
    before = now;
    const double K = kinetic(integrator.state().x);
    largest = std::max(largest, K);
    ASSERT_NEAR(K - kinetic_start, work, 1e-6 * std::max(largest, 1.0)) << "at " << integrator.state().t << " s";
  }
  EXPECT_GT(largest, 10);  // J: the body moves
}

INSTANTIATE_TEST_SUITE_P(Wagons, WagonMotion,
                         testing::Values(Choice{"set1", "empty", nullptr}, Choice{"set2", "packed", nullptr},
                                         Choice{"set1", "empty", "thesis-equivalent"}),
                         [](const auto& test) {
                           return std::string(test.param.set) + "_" + test.param.freight +
                                  (test.param.geometry == nullptr ? "" : "_profiles");
                         });

/// Every suspension on every geometry, slow and fast, from a small push: runs that stay on the track to their end.
TEST(WagonRuns, OnEveryGeometryWithEverySuspension) {
  for (const char* geometry : {"nominal-1435", "thesis-equivalent"}) {
    for (const Suspension suspension : {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf}) {
      WagonFixture fixture;
      fixture.options.suspension = suspension;
      const Wagon wagon = fixture.MakeOn(geometry);
      for (double V : {8.0, 25.0}) {
        SimulationOptions options;
        options.duration = 3;
        const WagonState start =
            Perturb(wagon, FindEquilibrium(wagon, V), {.front_y = 1e-3, .rear_y = 5e-4, .body_y = 2e-3});
        const SimulationResult result = Simulate(wagon, V, start, options);
        SCOPED_TRACE(std::string(geometry) + ", suspension " + std::to_string(static_cast<int>(suspension)) + ", " +
                     std::to_string(V) + " m/s: " + result.end_reason);
        EXPECT_EQ(result.end, SimulationEnd::kDuration);
        EXPECT_GT(result.minimum_wheel_load, 0);
        for (double x : result.state.x) EXPECT_TRUE(std::isfinite(x));
        RecordProperty(std::string(geometry) + std::to_string(static_cast<int>(suspension)) + "_" +
                           std::to_string(static_cast<int>(V)) + "_times_real_time",
                       static_cast<int>(result.simulated / result.wall_s));
      }
    }
  }
}

/// A wheelset alone on cones: links with hardly any stiffness, slow, so that it rolls without inertia.
TEST(Klingel, WavelengthOnCones) {
  WagonFixture fixture;
  HandMadeProfile cone;
  cone.flange_slope = 0;
  cone.conicity = 0.05;
  CornerLinks links = fixture.ReadLinks();
  for (DirectionParameters* direction : {&links.longitudinal, &links.lateral}) {
    direction->k = 1e-9;
    direction->sliders.clear();
  }
  fixture.options.guidance = false;
  const Wagon wagon(fixture.ReadData(), fixture.ReadBody(), false, {links, links, links, links},
                    MakeHandMadeTable(cone), fixture.options);
  const double V = 1;
  const WagonState rest = FindEquilibrium(wagon, V);
  SimulationOptions options;
  const double wavelength = 2 * std::numbers::pi * std::sqrt(cone.r0 * cone.a0 / cone.conicity);
  options.duration = 3 * wavelength / V;
  options.output_hz = 50;
  const SimulationResult result = Simulate(wagon, V, Perturb(wagon, rest, {.front_y = 1e-3}), options);
  std::vector<double> crossings;
  for (std::size_t i = 1; i < result.samples.size(); ++i) {
    const double a = result.samples[i - 1].x[wheelset::kY], b = result.samples[i].x[wheelset::kY];
    if (a * b <= 0 && a != b) crossings.push_back(result.samples[i - 1].t + a / (a - b) / options.output_hz);
  }
  ASSERT_GE(crossings.size(), 4u);
  const double found = V * 2 * (crossings.back() - crossings[1]) / static_cast<double>(crossings.size() - 2);
  // Klingel's formula is for rolling without creep; gravity on the cones and spin turn it by 0.12 %.
  RecordProperty("wavelength_over_klingel", std::to_string(found / wavelength));
  EXPECT_NEAR(found / wavelength, 1, 0.003);
}

}  // namespace
}  // namespace uiclink
