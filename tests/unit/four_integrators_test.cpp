#include "vehicle/four_integrators.h"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

constexpr std::size_t kWagons = FourIntegrators::kWagons;
constexpr std::array<double, kWagons> kSpeeds{20, 21.5, 23, 24.5};
const char* const kFreights[kWagons] = {"empty", "water", "empty", "gold"};

bool IsSame(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Four wagons of one suspension, of different freight and speed, displaced.
struct FourCases {
  std::vector<Wagon> wagons;
  std::array<WagonState, kWagons> starts;

  explicit FourCases(Suspension suspension, const std::string& set = "set1") {
    for (std::size_t i = 0; i < kWagons; ++i) {
      WagonFixture fixture;
      fixture.set = set;
      fixture.freight = kFreights[i];
      fixture.options.suspension = suspension;
      fixture.options.guidance = i != 2;
      wagons.push_back(fixture.Make());
    }
    for (std::size_t i = 0; i < kWagons; ++i)
      starts[i] = Perturb(wagons[i], FindEquilibrium(wagons[i], kSpeeds[i]),
                          {.front_y = 4e-3, .rear_y = 2e-3 * static_cast<double>(i), .body_y = 15e-3});
  }
};

std::string NameOf(const testing::TestParamInfo<Suspension>& suspension) {
  return suspension.param == Suspension::kLinear ? "linear"
         : suspension.param == Suspension::kLeaf ? "leaf"
                                                 : "parabolic";
}
class FourWagonsBySuspension : public testing::TestWithParam<Suspension> {};
INSTANTIATE_TEST_SUITE_P(All, FourWagonsBySuspension,
                         testing::Values(Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf), NameOf);

/// Runs all four to the same time, and counts the calls.
void RunTo(double t_end, FourIntegrators* four) {
  std::array<double, kWagons> stop;
  stop.fill(t_end);
  bool any = true;
  for (int n = 0; any; ++n) {
    ASSERT_LT(n, 1'000'000);
    const FourIntegrators::Advances advances = four->Step(stop);
    any = false;
    for (std::size_t i = 0; i < kWagons; ++i) {
      if (advances[i] == Advance::kStopTime) four->Stop(i);
      any = any || four->runs(i);
    }
  }
}

TEST_P(FourWagonsBySuspension, RatesAreThoseOfEachWagonBitByBit) {
  const FourCases cases(GetParam());
  FourWagons four;
  FourStates x, rates;
  for (std::size_t i = 0; i < kWagons; ++i) {
    four.SetWagon(i, cases.wagons[i], kSpeeds[i]);
    four.SetLinks(i, cases.starts[i].links);
  }
  for (int n = 0; n < 200; ++n) {
    std::array<StateVector<double>, kWagons> states;
    for (std::size_t i = 0; i < kWagons; ++i) {
      states[i] = cases.starts[i].x;
      states[i][wheelset::kY] = 1e-4 * (n - 100) + 1e-3 * static_cast<double>(i);  // beyond the flange on both sides
      states[i][wheelset::kX] = 4e-4 * (n - 100);                                  // beyond the guidance
      states[i][kRearWheelset + wheelset::kPsi] = 1e-4 * (n % 17 - 8);
      states[i][kBody + body::kZ] = 1e-3 * (n % 11 - 5);  // both stages of the springs
      for (std::size_t k = 1; k < kMotions; k += 3) states[i][k] += 1e-3 * ((n + static_cast<int>(k)) % 7 - 3);
      for (std::size_t k = 0; k < kMaxState; ++k) x[k].Set(i, states[i][k]);
    }
    FourWheelLoads loads;
    CalcRates(four, x, &rates, &loads);
    for (std::size_t i = 0; i < kWagons; ++i) {
      StateVector<double> rate{};
      WagonForces forces;
      CalcForces(cases.wagons[i], kSpeeds[i], cases.starts[i].links, states[i], &rate, &forces);
      for (std::size_t k = 0; k < kMaxState; ++k)
        ASSERT_TRUE(IsSame(rates[k][i], rate[k])) << kStateNames[k] << " of wagon " << i;
      for (std::size_t c = 0; c < kCorners; ++c) ASSERT_TRUE(IsSame(loads.Q[c][i], forces.wheels[c].Q));
    }
  }
}

TEST_P(FourWagonsBySuspension, RunsAgreeWithThoseOneAtATime) {
  const FourCases cases(GetParam());
  constexpr double kEnd = 4;
  FourIntegrators four;
  for (std::size_t i = 0; i < kWagons; ++i) four.Start(i, cases.wagons[i], kSpeeds[i], cases.starts[i]);
  RunTo(kEnd, &four);
  for (std::size_t i = 0; i < kWagons; ++i) {
    const auto run = [&](double tolerance) {
      IntegratorOptions options;
      options.tolerance = tolerance;
      Integrator integrator(cases.wagons[i], options);
      integrator.Start(kSpeeds[i], cases.starts[i]);
      while (integrator.Step(kEnd) != Advance::kStopTime) {
      }
      return std::pair(integrator.state(), integrator.counts());
    };
    const auto [exact, exact_counts] = run(1e-8);
    const auto [one, counts] = run(1e-6);
    for (std::size_t k : {wheelset::kY + 0UL, kRearWheelset + wheelset::kY, kBody + body::kY}) {
      // Errors of both scatter by a factor of 5 from moment to moment (tests/bench/README.md); 1e-8 m is what is left
      // of them where that of the one run happens to pass zero.
      const double error = std::abs(four.state(i).x[k] - exact.x[k]);
      EXPECT_LE(error, 5 * std::abs(one.x[k] - exact.x[k]) + 1e-8) << kStateNames[k] << " of wagon " << i;
    }
    // Neither more work nor other events.
    EXPECT_NEAR(static_cast<double>(four.counts(i).rhs_calls), static_cast<double>(counts.rhs_calls),
                0.1 * static_cast<double>(counts.rhs_calls));
    EXPECT_NEAR(static_cast<double>(four.counts(i).events), static_cast<double>(counts.events),
                0.02 * static_cast<double>(counts.events) + 2);
    // Wagons on linear springs have no joints, and these do not reach their guides.
    const long least = GetParam() == Suspension::kLinear ? 0 : 5;
    EXPECT_GE(four.counts(i).events, least);
  }
}

TEST(FourIntegrators, ALaneDoesNotDependOnTheOthers) {
  const FourCases cases(Suspension::kParabolic);
  FourIntegrators together, alone;
  for (std::size_t i = 0; i < kWagons; ++i) together.Start(i, cases.wagons[i], kSpeeds[i], cases.starts[i]);
  RunTo(2, &together);
  for (std::size_t i = 0; i < kWagons; ++i) {
    const std::size_t lane = kWagons - 1 - i;  // in another lane, beside nothing
    alone.Start(lane, cases.wagons[i], kSpeeds[i], cases.starts[i]);
    RunTo(2, &alone);
    for (std::size_t k = 0; k < kMaxState; ++k)
      EXPECT_TRUE(IsSame(together.state(i).x[k], alone.state(lane).x[k])) << kStateNames[k] << " of wagon " << i;
  }
}

TEST(FourIntegrators, InterpolatesWithinTheLastStep) {
  const FourCases cases(Suspension::kParabolic);
  FourIntegrators four;
  four.Start(1, cases.wagons[1], kSpeeds[1], cases.starts[1]);
  const std::array<double, kWagons> stop{1, 1, 1, 1};
  StateVector<double> before = cases.starts[1].x;
  for (int n = 0; n < 300; ++n) {
    if (!four.Step(stop)[1]) continue;
    StateVector<double> x;
    four.Interpolate(1, four.step_begin(1), &x);
    // A cubic with weights 1, 0, 0, 0.
    for (std::size_t k = 0; k < kMotions; ++k) ASSERT_DOUBLE_EQ(x[k], before[k]) << n << ' ' << kStateNames[k];
    before = four.state(1).x;
  }
}

TEST(FourIntegrators, OneThatGivesUpLeavesTheOthersRunning) {
  const FourCases cases(Suspension::kParabolic);
  FourIntegrators four;
  IntegratorOptions impossible;
  impossible.tolerance = 1e-30;
  four.Start(0, cases.wagons[0], kSpeeds[0], cases.starts[0], impossible);
  four.Start(3, cases.wagons[3], kSpeeds[3], cases.starts[3]);
  RunTo(0.5, &four);
  EXPECT_TRUE(four.failed(0));
  EXPECT_LT(four.state(0).t, 0.5);
  EXPECT_FALSE(four.failed(3));
  EXPECT_EQ(four.state(3).t, 0.5);
}

TEST(FourIntegrators, RefusesWhatItCannotDo) {
  const FourCases leaf(Suspension::kLeaf), linear(Suspension::kLinear);
  FourIntegrators four;
  IntegratorOptions no_tolerance, another_method;
  no_tolerance.tolerance = 0;
  another_method.method = "UICLINK_STABLE_7_3_4";
  EXPECT_THROW(four.Start(0, leaf.wagons[0], 0, leaf.starts[0]), std::invalid_argument);
  EXPECT_THROW(four.Start(0, leaf.wagons[0], 20, leaf.starts[0], no_tolerance), std::invalid_argument);
  EXPECT_THROW(four.Start(0, leaf.wagons[0], 20, leaf.starts[0], another_method), std::invalid_argument);
  four.Start(0, leaf.wagons[0], 20, leaf.starts[0]);
  EXPECT_THROW(four.Start(1, linear.wagons[1], 20, linear.starts[1]), std::invalid_argument);
  four.Stop(0);
  four.Start(1, linear.wagons[1], 20, linear.starts[1]);
}

}  // namespace
}  // namespace uiclink
