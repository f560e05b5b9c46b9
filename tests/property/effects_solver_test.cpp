// The extended solver with every mechanical effect of the catalogue, against its own integrator and against CVODE.
// Figures in the comments on tolerances are the largest that the links below give.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "model/extended_solver.h"
#include "model/extremum_deflection.h"
#include "tests/property/effects_fixture.h"
#include "tests/support/extended_cvode_reference.h"

namespace uiclink {
namespace {

class EffectSolver : public EveryEffect {};

TEST_P(EffectSolver, ClosedFormsAreTheIntegratedMotion) {
  double worst = 0;
  for (const Link& link : kLinks) {
    for (const double share : {0.1, 1.0, 3.0}) {
      const ExtendedOscillator<double> extended = Extended(link, effect(), share);
      const double difference =
          MaxDifference(Displacements(extended, kStart),
                        Displacements(extended, kStart, {.tolerance = 1e-12, .always_integrate = true}));
      // A step's error of 1e-12 of the start, some 3000 steps, and what the link makes of it: a hundredth of the
      // default's. Motions without closed form differ by the error of the default instead.
      EXPECT_LT(difference, IsIntegrated(extended) ? 1e-9 : 1e-10) << link.name << ", size " << share;
      worst = std::max(worst, difference);
    }
  }
  Measured() << effect().id << " closed form - integrated: |dy| <= " << worst << " m\n";
}

double CompareWithCvode(const ExtendedOscillator<double>& extended, double y0) {
  std::vector<double> deflection, stepped(kSamples.size);
  for (std::size_t i = 0; i < extended.sliders.size(); ++i)
    deflection.push_back(CalcDeflectionAtExtremum(extended, i, y0, kClock));
  RunExtendedCvode(extended, y0, deflection, kClock, kSamples, stepped);
  return MaxDifference(Displacements(extended, y0), stepped);
}

TEST_P(EffectSolver, AgreesWithCvode) {
  double worst = 0;
  for (const Link& link : kLinks) {
    for (const double share : {0.1, 1.0, 3.0}) {
      for (const double y0 : {kStart, -0.6 * kStart}) {
        const double difference = CompareWithCvode(Extended(link, effect(), share), y0);
        // CVODE at rtol 1e-12 drifts by up to 2e-10 m; the integrator of the solver by as much.
        EXPECT_LT(difference, 1e-9) << link.name << ", size " << share << ", " << y0;
        worst = std::max(worst, difference);
      }
    }
  }
  Measured() << effect().id << " solver - CVODE: |dy| <= " << worst << " m\n";
}

TEST_P(EffectSolver, AgreesWithCvodeForRandomLinksAndSizes) {
  RandomCases cases{std::mt19937_64(20260401)};
  double worst = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Link link = cases.NextLink();
    const double share = cases.LogUniform(0.3, 3), y0 = (trial % 2 == 0 ? 1 : -1) * cases.LogUniform(0.008, 0.045);
    const double difference =
        CompareWithCvode(With<double>(Extend(MakePlain(link)), effect(),
                                      MakeEffectValues(effect(), share, ScalesOf(link, std::abs(y0)))),
                         y0);
    EXPECT_LT(difference, 1e-9) << "trial " << trial << ": k " << link.k << ", k1 " << link.joints[0].k << ", T0 "
                                << link.joints[0].T0 << ", size " << share << ", y0 " << y0;
    worst = std::max(worst, difference);
  }
  Measured() << effect().id << " solver - CVODE, random: |dy| <= " << worst << " m\n";
}

TEST_P(EffectSolver, IsSolvedAnywhereInsideItsBounds) {
  // What a search may try: no size inside the bounds makes numbers that are not finite without the status saying so.
  RandomCases cases{std::mt19937_64(20260402)};
  std::array<int, 3> statuses{};
  double largest = 0;
  std::size_t events = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Link link = cases.NextLink();
    std::vector<double> values;
    for (const EffectParameter& p : effect().parameters) values.push_back(cases.Inside(p));
    const double y0 = (trial % 2 == 0 ? 1 : -1) * cases.LogUniform(0.008, 0.045);
    ExtendedTrajectory<double> run;
    const SolveStatus status =
        Solve(With<double>(Extend(MakePlain(link)), effect(), values), y0, kClock, kRecord, &run);
    ++statuses[static_cast<std::size_t>(status)];
    events = std::max(events, run.CountEvents());
    if (status != SolveStatus::kOk) continue;
    std::vector<double> y(kSamples.size);
    CalcDisplacements(run, kSamples, y);
    for (const double displacement : y) ASSERT_TRUE(std::isfinite(displacement)) << "trial " << trial;
    largest = std::max(largest, MaxAbs(y) / std::abs(y0));
  }
  // Not solved: what escapes over the hill of a negative stiffness, and motions that sliding overdamps.
  EXPECT_GT(statuses[0], 270);
  EXPECT_EQ(statuses[2], 0);
  Measured() << effect().id << " inside its bounds: " << statuses[0] << " solved, " << statuses[1] << " not finite, "
             << statuses[2] << " with too many events; up to " << events << " events, " << largest << " starts\n";
}

TEST(Effects, ActTogetherAsCvodeSays) {
  // Every pair, and all of them.
  double worst = 0;
  ExtendedOscillator<double> all = Extend(MakePlain(kLinks[1]));
  for (const Effect* a : Effects()) {
    if (!a->IsMechanical()) continue;
    const std::vector<double> values = MakeEffectValues(*a, 0.5, ScalesOf(kLinks[1]));
    a->Extend<double>(values, &all);
    for (const Effect* b : Effects()) {
      if (!b->IsMechanical() || b == a) continue;
      const double difference = CompareWithCvode(With<double>(Extended(kLinks[1], *b, 0.7), *a, values), kStart);
      EXPECT_LT(difference, 1e-9) << a->id << " and " << b->id;
      worst = std::max(worst, difference);
    }
  }
  Measured() << "pairs, solver - CVODE: |dy| <= " << worst << " m\n";
  const double difference = CompareWithCvode(all, kStart);
  Measured() << "all at once: |dy| <= " << difference << " m\n";
  EXPECT_LT(difference, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EffectSolver, testing::ValuesIn(Select(IsMechanical)), IdOf);

}  // namespace
}  // namespace uiclink
