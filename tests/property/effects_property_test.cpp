// What holds for every effect of the catalogue. All suites loop over Effects(): a new effect is tested by existing.
// Figures in the comments on tolerances are the largest that the links below give.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "model/effect.h"
#include "model/event_solver.h"
#include "model/extended_solver.h"
#include "model/extremum_deflection.h"
#include "tests/property/effects_fixture.h"

namespace uiclink {
namespace {

// ---------------------------------------------------------------------------------------------------------------------
// The catalogue itself.

TEST(Catalogue, HasTheEffectsOfTheDesignInItsOrder) {
  const std::vector<std::string_view> expected = {"viscous_damping",
                                                  "quadratic_drag",
                                                  "rolling_friction",
                                                  "micro_slip",
                                                  "extra_slider",
                                                  "cubic_stiffness",
                                                  "quadratic_stiffness",
                                                  "stribeck_friction",
                                                  "velocity_strengthening",
                                                  "friction_drift",
                                                  "asymmetric_friction",
                                                  "pendulum_geometry",
                                                  "clearance",
                                                  "end_stop",
                                                  "cross_axis_motion",
                                                  "rig_mode",
                                                  "sensor_drift",
                                                  "sensor_saturation",
                                                  "sensor_nonlinearity",
                                                  "mains_hum"};
  std::vector<std::string_view> ids;
  for (const Effect* effect : Effects()) ids.push_back(effect->id);
  EXPECT_EQ(ids, expected);
  EXPECT_EQ(FindEffect("end_stop")->id, "end_stop");
  EXPECT_EQ(FindEffect("no such effect"), nullptr);
}

class EveryMechanicalEffect : public EveryEffect {};
class EveryReading : public EveryEffect {};
class EveryOddMechanicalEffect : public EveryEffect {};
class EveryLoss : public EveryEffect {};

TEST_P(EveryEffect, IsDescribedInFull) {
  const Effect& e = effect();
  EXPECT_NE(e.IsMechanical(), e.stage != ReadingStage::kNone) << "acts on the motion or on the reading";
  EXPECT_EQ(e.acts_on == ActsOn::kMeasurement, !e.IsMechanical());
  for (const std::string_view text : {e.title, e.equation, e.signature.text, e.confused_with, e.separated_by})
    EXPECT_FALSE(text.empty());
  EXPECT_FALSE(e.repairs.empty());
  EXPECT_EQ(e.loss_per_cycle != nullptr, e.signature.loss_exponent > 0);
  ASSERT_LE(e.parameters.size(), e.IsMechanical() ? kMaxLawParameters : 5u);
  std::set<std::string_view> symbols;
  for (const EffectParameter& p : e.parameters) {
    EXPECT_TRUE(symbols.insert(p.symbol).second) << p.symbol;
    EXPECT_LT(p.low, p.high) << p.symbol;
    EXPECT_TRUE(p.coordinate != Coordinate::kLog || p.low > 0) << p.symbol;
    EXPECT_EQ(p.starts.empty(), p.start_scale == StartScale::kSpectrum) << p.symbol;
    for (const double start : p.starts)
      EXPECT_TRUE(p.start_scale != StartScale::kAbsolute || (p.low <= start && start <= p.high))
          << p.symbol << " " << start;
  }
  const EffectParameter& size = e.parameters.front();
  EXPECT_TRUE(size.low <= e.neutral && e.neutral <= size.high);
  EXPECT_EQ(size.starts.empty(), false);
}

TEST_P(EveryEffect, RepairsSymptomsThatExist) {
  static const std::set<std::string_view> symptoms = {"loss_per_half_cycle",
                                                      "rolling_decay",
                                                      "backbone",
                                                      "backbone_in_time",
                                                      "T0_from_decrement",
                                                      "T0_from_lock",
                                                      "T0_from_centre",
                                                      "mid_line",
                                                      "rest_off_centre",
                                                      "even_harmonics",
                                                      "odd_harmonics",
                                                      "residual_spectrum",
                                                      "residual_against_displacement",
                                                      "residual_against_velocity",
                                                      "residual_against_phase",
                                                      "residual_against_time",
                                                      "readings_clipped",
                                                      "whiteness"};
  for (const std::string_view symptom : effect().repairs) EXPECT_TRUE(symptoms.contains(symptom)) << symptom;
}

TEST_P(EveryEffect, IsConfusedWithOthersThatKnowOfIt) {
  // Words that are identifiers name other effects; such a pair must be found from either side.
  std::stringstream words{std::string(effect().confused_with)};
  for (std::string word; std::getline(words, word, ',');) {
    word.erase(0, word.find_first_not_of(' '));
    if (word.find('_') == std::string::npos) continue;
    const Effect* other = FindEffect(word);
    ASSERT_NE(other, nullptr) << word;
    EXPECT_NE(other->confused_with.find(effect().id), std::string_view::npos) << word << " does not name it";
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Neutral values.

TEST_P(EveryEffect, VanishesAtItsNeutralValue) {
  if (!effect().IsMechanical()) {
    const std::vector<double> values = MakeEffectValues(effect(), 0);
    for (const double input : {-0.03, -1e-5, 0.0, 0.004, 0.2})
      EXPECT_EQ(effect().Read<double>(values, 3.7, 1.2, input), input);
    return;
  }
  double worst = 0;
  for (const Link& link : kLinks) {
    for (const double y0 : {kStart, -0.6 * kStart}) {
      const Oscillator<double> plain = MakePlain(link);
      Trajectory<double> run;
      ASSERT_EQ(Solve(plain, AtExtremum(plain, y0), kRecord, &run), SolveStatus::kOk);
      std::vector<double> y(kSamples.size);
      CalcDisplacements(run, kSamples, y);
      const ExtendedOscillator<double> extended = Extended(link, effect(), 0);
      const double difference = MaxDifference(Displacements(extended, y0), y);
      // Closed forms: rounding of some 60 arcs. Integrated: see ExtendedSolveOptions::tolerance.
      EXPECT_LT(difference, IsIntegrated(extended) ? 1e-9 : 1e-13) << link.name << ", " << y0;
      worst = std::max(worst, difference);
    }
  }
  Measured() << effect().id << " at its neutral value: |dy| <= " << worst << " m\n";
}

TEST_P(EveryEffect, ShowsAtItsFirstStart) {
  // The first start is meant to show clearly: ten times the noise of a good sensor (0.0125 mm), somewhere.
  if (!effect().IsMechanical()) {
    const std::vector<double> values = MakeEffectValues(effect(), 1);
    double largest = 0;
    for (double t = 0; t < 15; t += 0.003)
      for (const double y : {-0.025, 0.025})
        largest = std::max(largest, std::abs(effect().Read<double>(values, t, 0, y) - y));
    EXPECT_GT(largest, 4e-5);
    return;
  }
  for (const Link& link : kLinks)
    EXPECT_GT(MaxDifference(Displacements(Extended(link, effect(), 1), kStart),
                            Displacements(Extended(link, effect(), 0), kStart)),
              1.25e-4)
        << link.name;
}

// ---------------------------------------------------------------------------------------------------------------------
// Symmetry and loss.

TEST_P(EveryEffect, MirrorsWithTheStartUnlessItHasEvenHarmonics) {
  double worst = 0, asymmetry = 0;
  for (const double share : {0.3, 1.0}) {
    if (effect().IsMechanical()) {
      for (const Link& link : kLinks) {
        const ExtendedOscillator<double> extended = Extended(link, effect(), share);
        const std::vector<double> right = Displacements(extended, kStart);
        std::vector<double> left = Displacements(extended, -kStart);
        for (double& y : left) y = -y;
        (effect().signature.even_harmonics ? asymmetry : worst) = MaxDifference(left, right);
        EXPECT_EQ(worst, 0) << link.name;  // every operation is the same but for a sign
      }
      continue;
    }
    // A mirrored record has mirrored values of what belongs to the record.
    const std::vector<double> values = MakeEffectValues(effect(), share);
    std::vector<double> mirrored = values;
    for (std::size_t i = 0; i < values.size(); ++i)
      if (effect().parameters[i].scope == Scope::kRecord) mirrored[i] = -values[i];
    for (const double y : {0.003, 0.02, 0.03}) {
      const double difference = effect().Read<double>(values, 4.1, 1, y) + effect().Read<double>(mirrored, 4.1, 1, -y);
      (effect().signature.even_harmonics ? asymmetry : worst) = std::abs(difference);
      EXPECT_EQ(worst, 0) << y;
    }
  }
  if (!effect().signature.even_harmonics) return;
  EXPECT_GT(asymmetry, 1e-4);  // [m]: else the signature says too much
}

TEST_P(EveryOddMechanicalEffect, HasOddForcesUnlessItHasEvenHarmonics) {
  const ExtendedOscillator<double> extended = Extended(kLinks[1], effect(), 1);
  for (const ForceTerm<double>& term : extended.forces.items())
    for (const double y : {-0.02, 0.0, 0.007})
      for (const double v : {-0.2, 0.0, 0.05})
        EXPECT_EQ(term.force(term.p, {1.0, -y, -v}), -term.force(term.p, {1.0, y, v})) << y << " " << v;
  EXPECT_EQ(extended.asymmetry, 0);
  EXPECT_TRUE(extended.stops.empty());
}

TEST_P(EveryMechanicalEffect, NeverDrivesTheMotion) {
  // From an extremum with all joints loaded outward to the next one of the same side no force of the catalogue does
  // positive work: springs and stops give back what they got, friction and drag take.
  for (const Link& link : kLinks) {
    for (const double share : {0.1, 1.0, 3.0}) {
      for (const double y0 : {kStart, -kStart}) {
        std::vector<double> extrema = FindExtrema(Extended(link, effect(), share), y0, kRecord);
        extrema.insert(extrema.begin(), y0);
        ASSERT_GT(extrema.size(), 4u);
        for (std::size_t i = 2; i < extrema.size(); ++i)
          EXPECT_LE((extrema[i] - extrema[i - 2]) * (i % 2 == 0 ? y0 : -y0), 1e-11 * std::abs(y0))
              << link.name << ", size " << share << ", extremum " << i;
      }
    }
  }
}

/// A link whose joints all roll, as one spring: what is lost is lost by the effect.
ExtendedOscillator<double> MakeRolling() {
  ExtendedOscillator<double> rolling;
  rolling.k = 13.9;
  return rolling;
}

/// Energy lost from an extremum to the next one of the same side, and the mean amplitude [m] of the two half swings.
struct Loss {
  double energy = 0, amplitude = 0;
};

Loss CalcLoss(const ExtendedOscillator<double>& oscillator, double A) {
  const std::vector<double> extrema = FindExtrema(oscillator, A, 3);
  EXPECT_GE(extrema.size(), 2u);
  // The sliders stand at their limits at both ends; what they store is the same.
  return {.energy = 0.5 * oscillator.k * (A * A - extrema[1] * extrema[1]),
          .amplitude = 0.25 * (A - 2 * extrema[0] + extrema[1])};
}

TEST_P(EveryMechanicalEffect, LosesInRollingWhatItsClosedFormSays) {
  constexpr double A = 0.02;
  const double w = std::sqrt(kThesisGravity * MakeRolling().k);
  double before = 0;
  for (const double share : {0.04, 0.02, 0.01}) {
    const std::vector<double> values = MakeEffectValues(effect(), share, {.swing = A, .speed = A * w});
    const ExtendedOscillator<double> oscillator = With<double>(MakeRolling(), effect(), values);
    const Loss loss = CalcLoss(oscillator, A);
    const double energy = 0.5 * oscillator.k * A * A;
    if (effect().loss_per_cycle == nullptr) {
      EXPECT_NEAR(loss.energy / energy, 0, 1e-9);  // the integrator's; conservative forces give back all
      continue;
    }
    // The closed form takes the motion for a cosine; it is one up to the size of the force.
    const double error = loss.energy / effect().loss_per_cycle(values, loss.amplitude, w) - 1;
    EXPECT_LT(std::abs(error), 0.05 * share / 0.04);
    if (before != 0) {
      EXPECT_LT(std::abs(error), std::max(1e-6, 0.6 * std::abs(before))) << "at least of order 1";
    }
    before = error;
  }
  if (effect().loss_per_cycle != nullptr)
    Measured() << effect().id << " loss in rolling at 1 % of its first size: off by " << before << "\n";
}

TEST_P(EveryLoss, LosesWithTheExponentOfItsSignature) {
  const std::vector<double> values = MakeEffectValues(effect(), 1);
  const auto loss = [&](double A) { return effect().loss_per_cycle(values, A, 10); };
  // Distributed slip has its exponent below its largest slip displacement, a single slider far above it.
  const double A = effect().id == "micro_slip"     ? 0.5 * values[1]
                   : effect().id == "extra_slider" ? 50 * values[1]
                                                   : 0.02;
  EXPECT_NEAR(std::log2(loss(1.4142 * A) / loss(0.7071 * A)), effect().signature.loss_exponent, 0.1);
  for (double a = 0; a < 0.05; a += 1e-4) EXPECT_GE(loss(a), 0);
}

// ---------------------------------------------------------------------------------------------------------------------
// Readings.

TEST_P(EveryReading, ReadingsHaveExactDerivatives) {
  constexpr double kFitStart = 1.3;
  const std::vector<double> values = MakeEffectValues(effect(), 1);
  for (const double t : {1.3, 2.11, 9.7}) {
    for (const double input : {-0.0247, -0.01, 0.003, 0.026}) {
      std::vector<Dual<6>> dual;
      for (std::size_t i = 0; i < values.size(); ++i) dual.emplace_back(values[i], static_cast<int>(i) + 1);
      const Dual<6> reading = effect().Read<Dual<6>>(dual, t, kFitStart, Dual<6>(input, 0));
      EXPECT_EQ(reading.a, effect().Read<double>(values, t, kFitStart, input));
      for (std::size_t q = 0; q <= values.size(); ++q) {
        const auto read = [&](double h) {
          std::vector<double> moved = values;
          if (q > 0) moved[q - 1] += h;
          return effect().Read<double>(moved, t, kFitStart, input + (q == 0 ? h : 0));
        };
        const double size = q == 0 ? input : values[q - 1];
        const double h = 1e-6 * (size == 0 ? 1e-3 : std::abs(size));
        // Five points. The fastest phase, 2 pi 39 Hz 8 s = 2000 rad, turns by 2e-3 with h: 1e-12 of the derivative is
        // left out. Readings round to some 1e-17 m, and phases of 2000 rad by as much times 5e-5 m.
        const double quotient = (8 * (read(h) - read(-h)) - (read(2 * h) - read(-2 * h))) / (12 * h);
        EXPECT_NEAR(reading.v[static_cast<int>(q)], quotient, 1e-11 * std::abs(quotient) + 5e-17 / h)
            << "t " << t << ", input " << input << ", quantity " << q;
      }
    }
  }
}

TEST(SensorSaturation, HoldsTheLevelBeyondIt) {
  const Effect& effect = *FindEffect("sensor_saturation");
  const std::array<Dual<6>, 1> level = {Dual<6>(0.02, 1)};
  for (const double side : {1.0, -1.0}) {
    const Dual<6> beyond = effect.Read<Dual<6>>(level, 0, 0, Dual<6>(0.023 * side, 0));
    EXPECT_EQ(beyond.a, 0.02 * side);
    EXPECT_EQ(beyond.v[0], 0);     // whatever the input does
    EXPECT_EQ(beyond.v[1], side);  // +-level
    const Dual<6> below = effect.Read<Dual<6>>(level, 0, 0, Dual<6>(0.019 * side, 0));
    EXPECT_EQ(below.v[0], 1);
    EXPECT_EQ(below.v[1], 0);
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Particular laws.

TEST(AsymmetricFriction, IsExactlyAZeroOffset) {
  // Why it is never named: T0 (1 +- a) is T0 and a constant force -a T0, which moves the whole motion by -a T0/k.
  const Effect& effect = *FindEffect("asymmetric_friction");
  for (const Link& link : kLinks) {
    const double a = 0.3;
    double shift = 0;
    for (const Slider<double>& joint : link.joints) shift -= a * joint.T0 / link.k;
    std::vector<double> offset = Displacements(Extend(MakePlain(link)), kStart - shift);
    for (double& y : offset) y += shift;
    const std::vector<double> asymmetric = Displacements(With<double>(Extend(MakePlain(link)), effect, {a}), kStart);
    EXPECT_LT(MaxDifference(asymmetric, offset), 1e-13) << link.name;  // rounding of some 60 arcs
  }
}

TEST(PendulumGeometry, IsSmoothAtInfiniteLength) {
  // Series and sine meet at y/l = 1; there all derivatives agree. At 1/l^2 = 0 the derivative is k y^3/6.
  const Effect& effect = *FindEffect("pendulum_geometry");
  const auto force = [&](double x, double y) {
    const std::array<Dual<6>, 1> p = {Dual<6>(x, 0)};
    ExtendedOscillator<Dual<6>> oscillator;
    oscillator.k = Dual<6>(4.2, 1);
    effect.Extend<Dual<6>>(p, &oscillator);
    const ForceTerm<Dual<6>>& term = oscillator.forces.items()[0];
    return term.force(term.p, {.t = Dual<6>(0), .y = Dual<6>(y, 2), .v = Dual<6>(0)});
  };
  const Dual<6> at_zero = force(0, 0.03);
  EXPECT_EQ(at_zero.a, 0);
  EXPECT_NEAR(at_zero.v[0], 4.2 * std::pow(0.03, 3) / 6, 1e-19);
  const double l = 0.04;
  const Dual<6> below = force(1 / (l * l), l * (1 - 1e-12)), above = force(1 / (l * l), l * (1 + 1e-12));
  EXPECT_NEAR(below.a, 4.2 * l * (1 - std::sin(1)), 1e-12);  // 1e-12 of the distance, 4.2 0.04 (1 - cos 1)
  EXPECT_NEAR(above.a, below.a, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(above.v[i], below.v[i], 1e-11 * std::abs(below.v[i])) << i;
}

TEST(StribeckFriction, ShareAtTheExtremumIsContinuousAndNeverAboveTheStaticPeak) {
  const Effect& effect = *FindEffect("stribeck_friction");
  const auto share = [&](double s) {
    const ExtendedOscillator<double> extended = With<double>(Extend(MakePlain(kLinks[0])), effect, {s, 0.02});
    return CalcDeflectionAtExtremum(extended, 0, kStart, 0) / extended.sliders.items()[0].y_c - 1;
  };
  bool sticks = false;
  double before = 0;
  for (double s = 1e-3; s < 1.5; s *= 1.01) {
    const double now = share(s);
    EXPECT_LE(now, s * (1 + 1e-12));
    EXPECT_LT(std::abs(now - before), 0.0101 * s + 1e-3);  // no jump where sticking begins
    sticks |= now < 0.9 * s;
    before = now;
  }
  EXPECT_TRUE(sticks);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(Effects().begin(), Effects().end()), IdOf);
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryMechanicalEffect, testing::ValuesIn(Select(IsMechanical)), IdOf);
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryReading,
                         testing::ValuesIn(Select([](const Effect& e) { return !e.IsMechanical(); })), IdOf);
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryOddMechanicalEffect, testing::ValuesIn(Select([](const Effect& e) {
                           return e.IsMechanical() && !e.signature.even_harmonics;
                         })),
                         IdOf);
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryLoss,
                         testing::ValuesIn(Select([](const Effect& e) { return e.loss_per_cycle != nullptr; })), IdOf);

}  // namespace
}  // namespace uiclink
