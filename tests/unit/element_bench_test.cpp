#include "vehicle/element_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "data/parameter_set_file.h"
#include "vehicle/element_report.h"

namespace uiclink {
namespace {

using testing::HasSubstr;

std::filesystem::path DataFolder() { return std::filesystem::path(UICLINK_SOURCE_DIR) / "data"; }
WagonData Hbbills() { return ReadWagonData(DataFolder() / "wagons" / "hbbills311.toml"); }
ParameterSet Set(const std::string& name) {
  return ReadParameterSet(DataFolder() / "parameter_sets" / (name + ".toml"));
}

LeafSpring Leaf(double beta) {
  LeafSpring leaf = Hbbills().leaf;
  leaf.beta = beta;
  return leaf;
}
constexpr double kAmplitude = 0.5 * 0.050959;  // section 5.3.1
constexpr double kMass = 13563.0 / 4;

// --- leaf spring, harmonic (figure 5.8) ---

TEST(LeafHarmonic, HardSpringLosesWhatLiesBetweenItsEnvelopes) {
  const double limit = 4 * kAmplitude * 4350;
  double before = 0;
  for (const double beta : {5e-3, 1e-3, 1e-4, 1e-5, 1e-6}) {
    const double loss = RunLeafHarmonic({.spring = Leaf(beta), .amplitude = kAmplitude}).steady_loss;
    EXPECT_GT(loss, before) << beta;
    before = loss;
    // The corners that a soft spring cuts off: at each reversal the envelopes' distance, 2 F_r +- 2 mu0 c a, times
    // beta, and the lag behind each envelope: first order in beta.
    if (beta <= 1e-4) {
      EXPECT_NEAR(loss, limit, beta * (4 * 4350 + 4 * 0.65e6 * kAmplitude)) << beta;
    }
  }
  EXPECT_NEAR(before / limit, 1, 2e-4);  // 1e-6 / 0.025 m times four corners
}

TEST(LeafHarmonic, ATooSoftSpringGivesEnergyInsteadOfLosingIt) {
  // The force lags by about beta behind the envelopes, which lie 2 F_r apart: loss = 4 a (F_r - c beta) where a >>
  // beta. Beyond beta = F_r/c = 6.7 mm Fancher's equation is no friction any more (vertical_spring.h).
  const double a = 1;  // [m]; no real movement, but >> beta
  for (const double beta : {1e-3, 5e-3, 1e-2}) {
    LeafSpring spring = Leaf(beta);
    spring.mu0 = 0;  // else the envelopes cross
    const double loss = CalcLeafLoopLoss(spring, 0, a), expected = 4 * a * (spring.F_r - spring.c * beta);
    // The corners, where the force goes over from one envelope to the other: 2 beta (2 F_r) + 4 c beta^2.
    EXPECT_NEAR(loss, expected, 2 * beta * 2 * spring.F_r + 4 * spring.c * beta * beta) << beta;
    EXPECT_EQ(loss > 0, beta < spring.F_r / spring.c) << beta;
  }
  EXPECT_LT(CalcLeafLoopLoss(Leaf(1e-2), 0, kAmplitude), 0);
}

TEST(LeafHarmonic, LastCycleIsTheOneThatRepeatsItself) {
  for (const double beta : {1e-5, 1e-3, 5e-3}) {
    const LeafHarmonicRun run = RunLeafHarmonic({.spring = Leaf(beta), .amplitude = kAmplitude, .cycles = 6});
    // What is left of the start: exp(-4 a/beta) a cycle, nothing after six; then rounding.
    EXPECT_NEAR(run.loss, run.steady_loss, 1e-11 * run.steady_loss) << beta;
  }
}

TEST(LeafHarmonic, LossIsTheAreaOfTheSampledLoopAndTheLoopRunsCounterClockwise) {
  const LeafHarmonicRun run =
      RunLeafHarmonic({.spring = Leaf(1e-3), .amplitude = kAmplitude, .cycles = 3, .samples = 20000});
  double area = 0;  // of restoring force -F over s, counter-clockwise positive: - integral of (-F) ds
  for (std::size_t i = run.s.size() - 20000; i < run.s.size(); ++i)
    area += 0.5 * (run.F[i] + run.F[i - 1]) * (run.s[i] - run.s[i - 1]);
  EXPECT_GT(area, 0);
  EXPECT_NEAR(area, run.steady_loss, 1e-5 * run.steady_loss);  // trapezoids: (2 pi/20000)^2 (a/beta)^2 = 6e-5 of a part
}

TEST(LeafHarmonic, HardSpringMatchesDryFrictionAndTheSoftOneDoesNot) {
  // Section 5.3.1 on figure 5.8. F_r = 4350 N there is 0.5 % above mu m g.
  const double friction = CalcFrictionWork(0.13, kMass * 9.82, kAmplitude);
  const double hard = RunLeafHarmonic({.spring = Leaf(1e-5), .amplitude = kAmplitude}).steady_loss;
  const double soft = RunLeafHarmonic({.spring = Leaf(1e-3), .amplitude = kAmplitude}).steady_loss;
  EXPECT_NEAR(hard / friction, 1, 0.005);
  EXPECT_LT(soft / friction, 0.85);  // measured 0.82
  const double hard_small = RunLeafHarmonic({.spring = Leaf(1e-5), .amplitude = kAmplitude / 2}).steady_loss;
  EXPECT_NEAR(hard_small / hard, 0.5, 1e-3);  // loss grows linearly with amplitude; beta/a is the difference
}

TEST(LeafHarmonic, AboutTheWorkingLoadTheEnvelopesAreFurtherApart) {
  // corrections.md E32: 11.0 kN at the working load instead of 4.33 kN.
  const double mean = kMass * 9.82 / 0.65e6;
  const LeafHarmonicRun run = RunLeafHarmonic({.spring = Leaf(1e-6), .mean = mean, .amplitude = 0.01});
  EXPECT_NEAR(run.envelope_loss / (4 * 0.01), 11.0e3, 50);
  EXPECT_NEAR(run.steady_loss, run.envelope_loss, 1e-3 * run.envelope_loss);  // beta/a = 1e-4, some corners
}

// --- leaf spring, drop (figure 5.9) ---

LeafDropRun Drop(double beta, double duration = 2, double rtol = 1e-10) {
  return RunLeafDrop(
      {.spring = Leaf(beta), .linear = Hbbills().linear_vertical, .m = kMass, .duration = duration, .rtol = rtol});
}

TEST(LeafDrop, EnergyBalances) {
  for (const double beta : {1e-5, 1e-3, 5e-3}) {
    const LeafDropRun run = Drop(beta);
    EXPECT_GT(run.reversals, 5) << beta;
    EXPECT_LT(run.energy_error, 1e-9) << beta;  // some steps at 1e-10; measured 3e-12
  }
}

TEST(LeafDrop, ForceIsTheClosedFormOfItsPath) {
  const LeafDropRun run = Drop(1e-3, 0.15);  // before the first reversal
  ASSERT_EQ(run.reversals, 0);
  for (std::size_t i = 0; i < run.s.size(); ++i)
    ASSERT_NEAR(run.F[i], CalcLeafForce(run.options.spring, 0.0, 0.0, run.s[i]), 1e-8 * kMass * 9.82);  // 100 x rtol
}

TEST(LeafDrop, HardSpringSticksWhereItTurnsAndSoftOneSwingsAboutItsRest) {
  const LeafDropRun hard = Drop(1e-5), middle = Drop(1e-3), soft = Drop(5e-3);
  // Figure 5.9: (a) a strong first movement, then slowly, from one side; (c) over-damped too; (e) swings about the
  // rest.
  EXPECT_EQ(hard.rest_crossings, 1);
  EXPECT_EQ(middle.rest_crossings, 1);
  EXPECT_GT(soft.rest_crossings, 5);
  EXPECT_GT(soft.rest_crossings_linear, 5);
  EXPECT_GT(hard.s.back() - hard.rest, 0.015);  // measured 18.9 mm
  EXPECT_LT(std::abs(soft.s.back() - soft.rest), 0.001);
  // All creep towards the middle of the envelopes, the hard one least.
  EXPECT_LT(Drop(1e-3, 4).s.back() - middle.rest, middle.s.back() - middle.rest);
  EXPECT_LT(hard.swing, middle.swing);
  EXPECT_LT(middle.swing, 5e-4);  // settles: the fall was 76 mm
}

TEST(LeafDrop, RestsBetweenTheEnvelopes) {
  for (const double beta : {1e-5, 1e-3}) {
    const LeafDropRun run = Drop(beta);
    EXPECT_LT(run.F.back(), CalcEnvelope(run.options.spring, true, run.s.back()));
    EXPECT_GT(run.F.back(), CalcEnvelope(run.options.spring, false, run.s.back()));
  }
}

TEST(LeafDrop, LinearSpringFollowsItsClosedForm) {
  const LeafDropRun run = Drop(1e-3);
  const LinearSpring spring = run.options.linear;
  const double rest = kMass * 9.82 / spring.k, decay = spring.d / (2 * kMass);
  const double w = std::sqrt(spring.k / kMass - decay * decay);
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    const double t = run.t[i];
    const double s = rest * (1 - std::exp(-decay * t) * (std::cos(w * t) + decay / w * std::sin(w * t)));
    ASSERT_NEAR(run.s_linear[i], s, 1e-8 * rest) << t;  // 100 x rtol
  }
}

TEST(LeafDrop, ConvergesWithItsTolerance) {
  const auto end = [](double rtol) {
    // Samples far apart: a step is never longer than their distance, and shall be bounded by the tolerance alone.
    return RunLeafDrop({.spring = Leaf(5e-3),
                        .linear = Hbbills().linear_vertical,
                        .m = kMass,
                        .duration = 1,
                        .step = 0.1,
                        .rtol = rtol})
        .s.back();
  };
  const double fine = end(1e-12);
  const double rough = std::abs(end(1e-5) - fine), finer = std::abs(end(1e-8) - fine);
  EXPECT_LT(rough, 1e-4);        // metres: some tens of steps of 1e-5 of 0.08 m
  EXPECT_GT(rough, 1e-9);        // the tolerance does decide
  EXPECT_LT(finer, rough / 30);  // three orders of tolerance, one and a half to spare
}

// --- parabolic spring (figures 5.10, 5.11) ---

TEST(ParabolicLoop, AreaIsTheFrictionWorkAndPiDWASquared) {
  for (const double m : {13563.0 / 4, 33563.0 / 4}) {
    const ParabolicLoopRun run = RunParabolicLoop({.spring = Hbbills().parabolic, .m = m});
    const double w = 2 * std::numbers::pi;
    EXPECT_NEAR(run.friction_work, std::numbers::pi * run.damping * w * run.amplitude * run.amplitude,
                1e-14 * run.friction_work);
    // A polygon of 720 corners in an ellipse lacks (2 pi/720)^2/6 = 1.3e-5.
    EXPECT_NEAR(run.loop_loss / run.friction_work, 1, 2e-5);
    EXPECT_DOUBLE_EQ(run.s.front(), run.static_compression);
  }
}

TEST(ParabolicLoop, DampingGoesWithTheInverseOfTheFrequency) {
  const ParabolicLoopRun one = RunParabolicLoop({.spring = Hbbills().parabolic, .m = kMass});
  const ParabolicLoopRun natural = RunParabolicLoop({.spring = Hbbills().parabolic, .m = kMass, .frequency = 2.21});
  EXPECT_DOUBLE_EQ(natural.damping * 2.21, one.damping);
  EXPECT_NEAR(natural.damping, 15.6e3, 100);  // corrections.md E34, three digits
}

// --- dry-friction element (figures 8.2 to 8.5) ---

DryFrictionRun Release(const DirectionParameters& element, double pull = 0.045) {
  return RunDryFriction({.element = element, .pull = pull});
}

TEST(DryFriction, Set1FallsFromExtremumToExtremumAsTheMapSays) {
  const DryFrictionRun run = Release(*Set("set1").lateral);
  const double expected_mm[] = {39.881, 34.969, 30.314, 25.980, 22.047, 18.609, 15.762, 13.571};  // corrections.md 4
  for (std::size_t i = 0; i < std::size(expected_mm); ++i)
    EXPECT_NEAR(std::abs(run.extremum_y[i]), 1e-3 * expected_mm[i], 0.5e-6) << i;  // half of the last digit
  EXPECT_FALSE(run.locked);
  EXPECT_NEAR(run.amplitude, 0.009844, 1e-5);  // approached from above, not reached in 15 s
  EXPECT_NEAR(run.offset, 0, 1e-6);
  EXPECT_LT(run.energy_error, 1e-13);  // some hundred roundings
}

TEST(DryFriction, Set2LocksOffCentre) {
  const DryFrictionRun run = Release(*Set("set2").lateral);
  const double expected_mm[] = {34.905, 24.961, 15.310, 6.426, 0.848};  // corrections.md 4
  for (std::size_t i = 0; i < std::size(expected_mm); ++i)
    EXPECT_NEAR(std::abs(run.extremum_y[i]), 1e-3 * expected_mm[i], 0.5e-6) << i;
  EXPECT_TRUE(run.locked);
  EXPECT_NEAR(run.offset, 0.653e-3, 0.5e-6);
  EXPECT_NEAR(run.amplitude, 1.501e-3, 0.5e-6 + 1e-6);                               // 1.5015 printed as 1.501
  EXPECT_NEAR(10.503 * run.amplitude + 3.413 * std::abs(run.offset), 0.018, 1e-12);  // breaks out no more: T = T0 there
  EXPECT_LT(run.energy_error, 1e-13);
}

TEST(DryFriction, SlidersStayWithinTheirBoundsAndMirror) {
  for (const char* name : {"set1", "set2"}) {
    const DirectionParameters element = *Set(name).longitudinal;
    const DryFrictionRun run = Release(element), mirrored = Release(element, -0.045);
    ASSERT_EQ(run.T.size(), 4u);
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      EXPECT_EQ(mirrored.y[i], -run.y[i]);  // the same roundings
      for (std::size_t j = 0; j < 4; ++j)
        ASSERT_LE(std::abs(run.T[j][i]), element.sliders[j].T0 * (1 + 1e-12)) << name << i << j;  // roundings
    }
  }
}

TEST(DryFriction, ASmallPullNeverSlides) {
  const DryFrictionRun run = Release(*Set("set1").lateral, 0.9 * 0.014 / 1.4222);
  EXPECT_TRUE(run.locked);
  EXPECT_NEAR(run.amplitude, 0.9 * 0.014 / 1.4222, 1e-15);  // roundings
  EXPECT_NEAR(run.frequency, std::sqrt(9.82 * (4.2010 + 1.4222)) / (2 * std::numbers::pi), 1e-12);
}

TEST(DryFriction, RefusesEffects) {
  DirectionParameters element = *Set("set1").lateral;
  element.effects = {{.id = "viscous_damping", .parameters = {{"c", 0.01}}}};
  EXPECT_THROW(Release(element), std::invalid_argument);
}

// --- options and report ---

TEST(Benches, RefuseOptionsThatMakeNoSense) {
  EXPECT_THROW(RunLeafHarmonic({.spring = Leaf(1e-3), .amplitude = 0}), std::invalid_argument);
  EXPECT_THROW(RunLeafHarmonic({.spring = Leaf(0), .amplitude = 0.01}), std::invalid_argument);
  EXPECT_THROW(RunLeafDrop({.spring = Leaf(1e-3), .linear = Hbbills().linear_vertical, .m = -1}),
               std::invalid_argument);
  EXPECT_THROW(RunParabolicLoop({.spring = Hbbills().parabolic, .m = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(RunGuidance(Table61(), {}, 1e9, 1e-3, 1e-9), std::invalid_argument);
  EXPECT_THROW(RunDryFriction({.element = *Set("set1").lateral, .duration = 0}), std::invalid_argument);
  try {
    FindElementBench("leaf");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), HasSubstr("must be one of leaf-harmonic, leaf-drop, parabolic, guidance, dry-friction"));
  }
}

TEST(ElementReport, EveryBenchGivesTextJsonSeriesAndFigures) {
  for (const auto& [name, bench] : ElementBenches()) {
    ElementOptions options{.wagon = Hbbills()};
    options.set = Set("set2");
    if (bench == ElementBench::kGuidance) options.duration = 1;
    const ElementReport report = MakeElementReport(bench, options);
    EXPECT_FALSE(report.text.empty()) << name;
    const nlohmann::json json = nlohmann::json::parse(report.json);
    EXPECT_EQ(json.at("schema"), "wagon-element/1");
    EXPECT_EQ(json.at("bench"), name);
    EXPECT_EQ(json.at("wagon"), "Hbbills 311");
    EXPECT_FALSE(json.at("runs").empty()) << name;
    EXPECT_FALSE(report.figures.empty()) << name;
    ASSERT_FALSE(report.series.empty()) << name;
    for (const ElementSeries& series : report.series) {
      for (const DataColumn& column : series.columns) {
        EXPECT_GT(column.values.size(), 100) << series.name << ": " << column.name;
        EXPECT_EQ(column.values.size(), series.columns.front().values.size()) << series.name << ": " << column.name;
      }
    }
  }
}

TEST(ElementReport, ParabolicTellsTheDampingOfTable51) {
  const ElementReport report = MakeElementReport(ElementBench::kParabolic, {.wagon = Hbbills()});
  const nlohmann::json runs = nlohmann::json::parse(report.json).at("runs");
  EXPECT_NEAR(runs.at(0).at("damping_N_s_per_m").get<double>(), 34426.5, 0.5);
  EXPECT_THAT(report.text, HasSubstr("34440"));
}

}  // namespace
}  // namespace uiclink
