// The link of the wagon, swinging one mass, against the two solvers of the bench: the same law, written and integrated
// another way. Figures in the comments on tolerances are the largest that the links below give.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "model/effect.h"
#include "model/event_solver.h"
#include "model/extended_link.h"
#include "model/extended_solver.h"
#include "model/extremum_deflection.h"
#include "tests/support/effect_values.h"
#include "tests/support/link_swing.h"
#include "vehicle/link.h"

namespace uiclink {
namespace {

constexpr double kG = kThesisGravity;
constexpr double kLoad = 3714;     // of the bench [N]
constexpr double kStart = 0.0253;  // [m]; a round number would put stops on the start itself
const SampleTimes kSamples{.first = 0, .step = 0.01, .size = 1501};

std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

struct NamedLink {
  std::string name;
  DirectionParameters parameters;
};

NamedLink MakeNamed(const std::string& name, double k, const std::vector<Slider<double>>& sliders) {
  NamedLink link{.name = name, .parameters = {}};
  link.parameters.k = k;
  link.parameters.sliders = sliders;
  return link;
}

/// Tables 4.1 and 4.2 of the thesis.
const std::vector<NamedLink>& PlainLinks() {
  static const std::vector<NamedLink> links = {
      MakeNamed("set 1 lateral", 4.2010, {{1.4222, 0.014}}), MakeNamed("set 2 lateral", 3.413, {{10.503, 0.018}}),
      MakeNamed("set 1 longitudinal", 6.4763, {{2.00, 6e-3}, {0.50, 3e-3}, {0.37, 2e-3}, {0.50, 2e-3}}),
      MakeNamed("set 2 longitudinal", 5.50, {{3.44, 6.98e-3}, {2.00, 5.11e-3}, {0.33, 0.91e-3}, {1.90, 7.16e-3}})};
  return links;
}

double MaxDifference(std::span<const double> a, std::span<const double> b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

/// Links far from the published sets: k_i/k from 0.1 to 4, slips from 1 to 12 mm.
struct RandomCases {
  std::mt19937_64 random;
  double LogUniform(double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  }
  DirectionParameters NextLink(int sliders) {
    DirectionParameters parameters;
    parameters.k = LogUniform(2, 10);
    for (int i = 0; i < sliders; ++i) {
      const double k = parameters.k * LogUniform(0.1, 4);
      parameters.sliders.push_back({k, k * LogUniform(1e-3, 12e-3)});
    }
    return parameters;
  }
};

/// The state of a link that all sliders reached sliding at an extremum.
LinkState AtExtremumOf(const Link& link, double y0) {
  const double side = y0 < 0 ? -1 : 1;
  std::vector<double> T;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    const ExtendedSlider<double>& slider = link.sliders()[i];
    const double gap = slider.joint ? link.law().gap : 0;
    T.push_back(-side * link.load() * slider.k * (CalcDeflectionAtExtremum(link.law(), i, y0, 0.0) - gap));
  }
  return LinkState::WithForces(link, y0, 0, T);
}

std::vector<double> Swing(const Link& link, double y0, LinkSwingCounts* counts = nullptr,
                          const LinkSwingOptions& options = {}) {
  std::vector<double> y(kSamples.size);
  LinkState state = AtExtremumOf(link, y0);
  const LinkSwingCounts counted = SwingLink(link, &state, y0, 0, kSamples, y, options);
  if (counts != nullptr) *counts = counted;
  return y;
}

std::vector<double> SolveExtended(const ExtendedOscillator<double>& oscillator, double y0) {
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(oscillator, y0, 0.0, kSamples[kSamples.size - 1], &run), SolveStatus::kOk);
  std::vector<double> y(kSamples.size);
  CalcDisplacements(run, kSamples, y);
  return y;
}

// ---------------------------------------------------------------------------------------------------------------------
// The plain link.

std::vector<double> SolvePlain(const DirectionParameters& parameters, double y0, std::size_t* events = nullptr) {
  const Oscillator<double> oscillator = MakeOscillator(parameters, kG);
  Trajectory<double> run;
  EXPECT_EQ(Solve(oscillator, AtExtremum(oscillator, y0), kSamples[kSamples.size - 1], &run), SolveStatus::kOk);
  std::vector<double> y(kSamples.size);
  CalcDisplacements(run, kSamples, y);
  if (events != nullptr) *events = run.CountEvents();
  return y;
}

TEST(PlainLink, SwingsAsTheEventSolverSays) {
  for (const NamedLink& named : PlainLinks()) {
    for (const double y0 : {kStart, -0.6 * kStart, 0.045}) {
      LinkSwingCounts counts;
      std::size_t events = 0;
      const double difference = MaxDifference(Swing(Link(named.parameters, kG, kLoad), y0, &counts),
                                              SolvePlain(named.parameters, y0, &events));
      // 1e-12 m: events are passed kSlack = 4e-12 m late, some hundred of them one after the other; steps at a relative
      // error of 1e-12 add as much.
      EXPECT_LT(difference, 1e-11) << named.name << ", " << y0;
      // Slips of less than kSlack are none.
      EXPECT_LE(counts.changes, static_cast<long>(events)) << named.name << ", " << y0;
      Measured() << named.name << " from " << y0 << " m: |dy| <= " << difference << " m, " << counts.changes
                 << " changes (solver " << events << "), " << counts.turns << " other reversals\n";
    }
  }
}

TEST(PlainLink, LosesNoSlipInLongSteps) {
  // Slips near a turning point are shorter than any step. The steps are as long as their error allows.
  for (const NamedLink& named : PlainLinks()) {
    LinkSwingCounts counts;
    const double difference =
        MaxDifference(Swing(Link(named.parameters, kG, kLoad), kStart, &counts, {.tolerance = 1e-10, .max_step = 0.1}),
                      SolvePlain(named.parameters, kStart));
    // The interpolation is now off by (w h)^6/46080 with w h about 0.2: 1e-9 of 0.025 m a step, in some hundred events.
    EXPECT_LT(difference, 2e-9) << named.name;
    Measured() << named.name << " in " << counts.steps << " steps: |dy| <= " << difference << " m\n";
  }
}

TEST(PlainLink, SwingsAsTheEventSolverSaysForRandomLinks) {
  RandomCases cases{std::mt19937_64(20260501)};
  double worst = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const DirectionParameters parameters = cases.NextLink(1 + trial % 4);
    const double y0 = (trial % 2 == 0 ? 1 : -1) * cases.LogUniform(0.008, 0.045);
    const double difference =
        MaxDifference(Swing(Link(parameters, kG, cases.LogUniform(1e3, 1e5)), y0), SolvePlain(parameters, y0));
    EXPECT_LT(difference, 1e-10) << "trial " << trial;  // up to a thousand events of kSlack
    worst = std::max(worst, difference);
  }
  Measured() << "random links: |dy| <= " << worst << " m\n";
}

TEST(PlainLink, DoesNotDependOnItsLoadPerUnitLoad) {
  // The load is a factor of every force: a power of two leaves all roundings as they are.
  const DirectionParameters& parameters = PlainLinks()[3].parameters;
  EXPECT_EQ(Swing(Link(parameters, kG, kLoad), kStart), Swing(Link(parameters, kG, 8 * kLoad), kStart));
}

TEST(PlainLink, MirroredStartsGiveMirroredRuns) {
  for (const NamedLink& named : PlainLinks()) {
    const Link link(named.parameters, kG, kLoad);
    std::vector<double> mirrored = Swing(link, -kStart);
    for (double& y : mirrored) y = -y;
    EXPECT_EQ(Swing(link, kStart), mirrored) << named.name;  // rounding is symmetric, too
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Effects.

/// Values as a parameter set has them, within their bounds.
EffectValues ToSet(const Effect& effect, const std::vector<double>& law_values) {
  EffectValues values{.id = std::string(effect.id), .parameters = {}};
  for (std::size_t i = 0; i < law_values.size(); ++i) {
    const bool inverse = effect.parameters[i].coordinate == Coordinate::kInverseSquare;
    const double value = inverse ? 1 / std::sqrt(law_values[i]) : law_values[i];
    values.parameters.emplace_back(effect.parameters[i].symbol,
                                   std::clamp(value, effect.parameters[i].low, effect.parameters[i].high));
  }
  return values;
}

Scales ScalesOf(const DirectionParameters& p, double start) {
  return {.swing = start, .speed = start * std::sqrt(kG * (p.k + p.SumOfSliderStiffness()))};
}

DirectionParameters With(DirectionParameters parameters, const Effect& effect, double share, double start = kStart) {
  parameters.effects.push_back(ToSet(effect, MakeEffectValues(effect, share, ScalesOf(parameters, start))));
  return parameters;
}

bool ActsOnTheWagon(const Effect& effect) {
  DirectionParameters parameters;
  parameters.effects.push_back({.id = std::string(effect.id), .parameters = {}});
  return EffectsLeftOut(parameters).empty();
}

std::vector<const Effect*> WagonEffects() {
  std::vector<const Effect*> effects;
  for (const Effect* effect : Effects())
    if (ActsOnTheWagon(*effect)) effects.push_back(effect);
  return effects;
}

class EveryWagonEffect : public testing::TestWithParam<const Effect*> {
 protected:
  const Effect& effect() const { return *GetParam(); }
};

TEST_P(EveryWagonEffect, SwingsAsTheExtendedSolverSays) {
  double worst = 0;
  long changes = 0;
  for (const NamedLink& named : PlainLinks()) {
    for (const double share : {0.1, 1.0, 3.0}) {
      for (const double y0 : {kStart, -0.6 * kStart}) {
        const Link link(With(named.parameters, effect(), share), kG, kLoad);
        LinkSwingCounts counts;
        // Rolling friction with its own law is the next test's; here the solver gets the slider that the link has.
        const double difference = MaxDifference(Swing(link, y0, &counts), SolveExtended(link.law(), y0));
        // Two integrators, each good to some 2e-10 m in 15 s (effects_solver_test.cpp), and kSlack in each event.
        EXPECT_LT(difference, 1e-9) << named.name << ", size " << share << ", " << y0;
        worst = std::max(worst, difference);
        changes = std::max(changes, counts.changes);
      }
    }
  }
  Measured() << effect().id << ": |dy| <= " << worst << " m, up to " << changes << " changes\n";
}

TEST_P(EveryWagonEffect, IsTheLawOfTheCatalogue) {
  // Built by hand from the law's values.
  for (const NamedLink& named : PlainLinks()) {
    const std::vector<double> values = MakeEffectValues(effect(), 1, ScalesOf(named.parameters, kStart));
    ExtendedOscillator<double> reference = Extend(MakeOscillator(named.parameters, kG));
    if (effect().id == "rolling_friction") {  // a slider on the wagon: see RollingFriction below
      reference.sliders.Add({.k = values[0] / Link::kRollingSlip, .y_c = Link::kRollingSlip, .joint = false});
    } else {
      effect().Extend<double>(values, &reference);
    }
    const double difference = MaxDifference(Swing(Link(With(named.parameters, effect(), 1), kG, kLoad), kStart),
                                            SolveExtended(reference, kStart));
    EXPECT_LT(difference, 1e-9) << named.name;
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Friction of rolling: a slider on the wagon, a sign on the bench.

/// What the slider's push at each reversal can have added up to at the end of a run.
///
/// After a reversal the friction goes from one direction to the other over the way of 2 y_c, instead of at once. With
/// the acceleration a there that takes the time t1 = 2 sqrt(y_c/a), and the excess 2 g T_r (1 - (t/t1)^2) makes the
/// mass faster by dv = 4/3 g T_r t1: it is ahead by dv/w, w the lowest frequency of the link, and stays so. At the end
/// the mass is held somewhere instead of swinging on, by 2 y_c, in the spring of the slider.
double CalcPushAtReversals(const ExtendedTrajectory<double>& run, double T_r, double w, double y_c) {
  double sum = 4 * y_c;
  constexpr double kStep = 1e-3;  // [s], in which reversals are looked for
  for (double t = kStep; t + kStep < 15; t += kStep) {
    if (!(run.v(t) * run.v(t + kStep) < 0)) continue;
    const double a = std::abs(run.v(t + kStep) - run.v(t)) / kStep;
    sum += 4.0 / 3 * kG * T_r * 2 * std::sqrt(y_c / a) / w;
  }
  return sum;
}

TEST(RollingFriction, DiffersFromItsSignByThePushAtReversals) {
  for (const NamedLink& named : PlainLinks()) {
    for (const double share : {0.1, 1.0, 3.0}) {
      const DirectionParameters parameters = With(named.parameters, *FindEffect("rolling_friction"), share);
      const double T_r = parameters.effects[0].parameters[0].second;
      ExtendedTrajectory<double> run;
      ASSERT_EQ(Solve(MakeExtendedOscillator<double>(parameters, kG), kStart, 0.0, 15.0, &run), SolveStatus::kOk);
      std::vector<double> reference(kSamples.size);
      CalcDisplacements(run, kSamples, reference);
      const double difference = MaxDifference(Swing(Link(parameters, kG, kLoad), kStart), reference);
      const double push = CalcPushAtReversals(run, T_r, std::sqrt(kG * parameters.k), Link::kRollingSlip);
      Measured() << named.name << ", T_r " << T_r << ": |dy| <= " << difference << " m, expected below " << push
                 << " m\n";
      EXPECT_LT(difference, push) << named.name << ", size " << share;
    }
  }
}

TEST(RollingFriction, TendsToItsSign) {
  // The push goes with the root of the slip. One decade of it: a factor of 3.2, where the ends differ little.
  for (const NamedLink& named : PlainLinks()) {
    const DirectionParameters parameters = With(named.parameters, *FindEffect("rolling_friction"), 0.1);
    const double T_r = parameters.effects[0].parameters[0].second;
    const std::vector<double> sign = SolveExtended(MakeExtendedOscillator<double>(parameters, kG), kStart);
    std::array<double, 3> difference{};
    for (std::size_t i = 0; i < difference.size(); ++i) {
      const double slip = Link::kRollingSlip * std::pow(10, -static_cast<double>(i));
      ExtendedOscillator<double> slider = Extend(MakeOscillator(named.parameters, kG));
      slider.sliders.Add({.k = T_r / slip, .y_c = slip, .joint = false});
      difference[i] = MaxDifference(SolveExtended(slider, kStart), sign);
    }
    EXPECT_LT(difference[1], difference[0] / 2) << named.name;
    EXPECT_LT(difference[2], difference[1] / 2) << named.name;
    Measured() << named.name << ": " << difference[0] << ", " << difference[1] << ", " << difference[2] << " m\n";
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Where joints break out late, stick early, and everything happens together.

TEST_P(EveryWagonEffect, SwingsAsTheExtendedSolverSaysForRandomLinks) {
  RandomCases cases{std::mt19937_64(20260502)};
  double worst = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const double y0 = (trial % 2 == 0 ? 1 : -1) * cases.LogUniform(0.008, 0.045), share = cases.LogUniform(0.3, 3);
    const DirectionParameters plain = cases.NextLink(1 + trial % 3);
    const Link link(With(plain, effect(), share, std::abs(y0)), kG, kLoad);
    const double difference = MaxDifference(Swing(link, y0), SolveExtended(link.law(), y0));
    EXPECT_LT(difference, 1e-9) << "trial " << trial << ", size " << share << ", " << y0;  // as above
    worst = std::max(worst, difference);
  }
  Measured() << effect().id << ", random links: |dy| <= " << worst << " m\n";
}

TEST(WagonEffects, ActTogetherAsTheExtendedSolverSays) {
  double worst = 0;
  DirectionParameters all = PlainLinks()[2].parameters;
  for (const Effect* a : WagonEffects()) {
    all = With(all, *a, 0.5);
    for (const Effect* b : WagonEffects()) {
      if (b == a) continue;
      const Link link(With(With(PlainLinks()[2].parameters, *a, 0.5), *b, 0.7), kG, kLoad);
      const double difference = MaxDifference(Swing(link, kStart), SolveExtended(link.law(), kStart));
      EXPECT_LT(difference, 1e-9) << a->id << " and " << b->id;  // as above
      worst = std::max(worst, difference);
    }
  }
  const Link link(all, kG, kLoad);
  const double together = MaxDifference(Swing(link, kStart), SolveExtended(link.law(), kStart));
  EXPECT_LT(together, 1e-9);
  Measured() << "pairs: |dy| <= " << worst << " m, all together " << together << " m\n";
}

TEST_P(EveryWagonEffect, NoForceJumpsWhereJointsChangeOver) {
  // Except for the static peak of Stribeck friction: there the force falls by what the peak is higher than the law.
  const bool falls = effect().id == "stribeck_friction";
  double worst = 0, largest_fall = 0;
  for (const NamedLink& named : PlainLinks()) {
    const Link link(With(named.parameters, effect(), 1), kG, kLoad);
    double K = link.law().k;
    for (const ExtendedSlider<double>& slider : link.sliders()) K += slider.k;
    for (const Stop<double>& stop : link.law().stops.items()) K += stop.k;
    // The event is found up to 1.5 kSlack late: that far all springs together are beyond; and rounding of K d.
    const double tolerance = kLoad * K * (1.5 * LinkState::kSlack + 1e-15 * kStart);
    const auto check = [&](const LinkState& before, const LinkState& after, double d, double v) {
      double jump = after.CalcForce(link, d, v) - before.CalcForce(link, d, v);
      for (std::size_t i = 0; falls && i < link.sliders().size(); ++i) {
        if (before.joints[i].slides != 0 || after.joints[i].slides == 0) continue;
        const double side = after.joints[i].slides;
        const double fall = kLoad * (link.CalcBreakoutForce(i, side, v) - link.CalcSlidingForce(i, side, v));
        EXPECT_GT(fall, 0);
        jump -= side * fall;
        largest_fall = std::max(largest_fall, fall);
      }
      worst = std::max(worst, std::abs(jump) / tolerance);
    };
    Swing(link, kStart, nullptr, {.on_switch = check});
  }
  EXPECT_LE(worst, 1);
  EXPECT_EQ(falls, largest_fall > 0.1);
  Measured() << effect().id << ": largest jump " << worst << " of what kSlack explains; falls by the law up to "
             << largest_fall << " N\n";
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryWagonEffect, testing::ValuesIn(WagonEffects()),
                         [](const testing::TestParamInfo<const Effect*>& test) { return std::string(test.param->id); });

}  // namespace
}  // namespace uiclink
