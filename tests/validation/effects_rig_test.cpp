// Every effect of the catalogue against the rig, which shares no line with it: motions against its small steps,
// readings against its measurement chain. Figures in the comments are the largest that the cases below give.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "measurements/rig/random.h"
#include "measurements/rig/sensor.h"
#include "model/effect.h"
#include "model/extended_solver.h"
#include "tests/support/effect_values.h"
#include "tests/validation/rig_fixture.h"

namespace uiclink {

void PrintTo(const Effect* effect, std::ostream* stream) { *stream << effect->id; }

namespace {

constexpr double kDuration = 12;   // [s]
constexpr double kStep = 2e-4;     // of the rig, halved once [s]
constexpr double kStart = 0.0253;  // [m]

std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

ExtendedOscillator<double> MakePlain(const rig::Link& link) {
  Oscillator<double> plain;
  plain.k = link.k;
  plain.g = link.g;
  for (const rig::Joint& joint : link.joints) plain.Add({joint.k, joint.T0});
  return Extend(plain);
}

Scales ScalesOf(const rig::Link& link) {
  double K = link.k;
  for (const rig::Joint& joint : link.joints) K += joint.k;
  return {.swing = kStart, .speed = kStart * std::sqrt(link.g * K)};
}

/// The rig's parameter of an effect by its symbol.
double& RigValue(rig::EffectSizes* sizes, std::string_view id, std::string_view symbol) {
  for (const rig::Effect& effect : rig::EffectCatalogue())
    for (const rig::EffectParameter& p : effect.parameters)
      if (effect.id == id && p.symbol == symbol) return sizes->*p.value;
  throw std::invalid_argument("the rig has no " + std::string(id) + "." + std::string(symbol));
}

/// The same effect in the rig's terms.
rig::Link WithEffect(rig::Link link, const Effect& effect, const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const EffectParameter& p = effect.parameters[i];
    if (effect.id == "extra_slider" && p.symbol == "y_c") {
      link.effects.extra_T0 = values[0] * values[1];
    } else {
      RigValue(&link.effects, effect.id, p.symbol) =
          p.coordinate == Coordinate::kInverseSquare ? 1 / std::sqrt(values[i]) : values[i];
    }
  }
  link.effects.micro_count = 16;
  return link;
}

double MaxDifference(const std::vector<double>& a, const std::vector<double>& b, std::size_t stride_a,
                     std::size_t stride_b) {
  double worst = 0;
  for (std::size_t i = 0; i * stride_a < a.size() && i * stride_b < b.size(); ++i)
    worst = std::max(worst, std::abs(a[i * stride_a] - b[i * stride_b]));
  return worst;
}

/// Displacements of the solver at the rig's times.
std::vector<double> SolveAt(const ExtendedOscillator<double>& oscillator, double y0, double clock,
                            const SampleTimes& times) {
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(oscillator, y0, clock, times[times.size - 1], &run), SolveStatus::kOk);
  std::vector<double> y(times.size);
  CalcDisplacements(run, times, y);
  return y;
}

struct Comparison {
  double difference = 0;  ///< solver - rig at the halved step [m]
  double halving = 0;     ///< rig - rig at the halved step [m]
};

/// Both from the same start, over kDuration.
Comparison CompareWithRig(const ExtendedOscillator<double>& oscillator, const rig::Link& link, double y0) {
  const rig::FreeDecay coarse = rig::ReleaseFromExtremum(link, y0, kDuration, kStep);
  const rig::FreeDecay fine = rig::ReleaseFromExtremum(link, y0, kDuration, 0.5 * kStep);
  const std::vector<double> y = SolveAt(oscillator, y0, 0, {.first = 0, .step = 0.5 * kStep, .size = fine.y.size()});
  return {.difference = MaxDifference(y, fine.y, 1, 1), .halving = MaxDifference(coarse.y, fine.y, 1, 2)};
}

/// Where the limit grows with time a joint sticks v = y_c rate before the turning point, which the solver leaves out:
/// the slider would stay behind by v^2/(2 a) [m]. a is the least deceleration with slip, where the amplitude is y_c.
double CalcTurningError(const Effect& effect, const std::vector<double>& values, const rig::Link& link) {
  if (effect.id != "friction_drift") return 0;
  const rig::Joint& joint = link.joints[0];
  const double y_c = joint.T0 / joint.k, v = y_c * values[0], a = link.g * (link.k * y_c + joint.T0);
  return v * v / (2 * a);
}

class EveryEffect : public testing::TestWithParam<const Effect*> {
 protected:
  const Effect& effect() const { return *GetParam(); }
};

class EveryMechanicalEffect : public EveryEffect {};
class EveryReading : public EveryEffect {};

template <typename Condition>
std::vector<const Effect*> Select(Condition condition) {
  std::vector<const Effect*> selected;
  for (const Effect* effect : Effects())
    if (condition(*effect)) selected.push_back(effect);
  return selected;
}
std::string IdOf(const testing::TestParamInfo<const Effect*>& test) { return std::string(test.param->id); }

TEST_P(EveryMechanicalEffect, MovesAsInTheRig) {
  Comparison worst;
  for (const rig::Link& link : {rig::LateralSet1(), rig::LateralSet2()}) {  // k1 below and above k
    for (const double share : {0.3, 1.0, 3.0}) {
      for (const double y0 : {kStart, -0.7 * kStart}) {
        std::vector<double> values = MakeEffectValues(effect(), share, ScalesOf(link));
        // Both start with the joints at T0 (1 + s) only where they slide up to the turning point; see below.
        if (effect().id == "stribeck_friction") values[1] = 0.6 * ScalesOf(link).speed;
        const Comparison c =
            CompareWithRig(With<double>(MakePlain(link), effect(), values), WithEffect(link, effect(), values), y0);
        EXPECT_LT(c.difference, 2 * c.halving + CalcTurningError(effect(), values, link) + 1e-9)
            << "k1 " << link.joints[0].k << ", size " << share << ", " << y0;
        if (c.difference > worst.difference) worst = c;
      }
    }
  }
  Measured() << effect().id << " solver - rig at " << 0.5 * kStep << " s: |dy| <= " << worst.difference
             << " m; halving the step moves it by " << worst.halving << " m\n";
}

// ---------------------------------------------------------------------------------------------------------------------
// Stribeck friction from an extremum that is reached sliding.  The rig's own start is a joint at T0 (1 + s); from the
// next extremum on its state is what sliding left, which the solver calculates from where it stuck.

struct Extremum {
  double t = 0, y = 0;
};

/// First extremum of a run after its start.
Extremum FindSecondExtremum(const ExtendedOscillator<double>& oscillator, double y0) {
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(oscillator, y0, 0, kDuration, &run), SolveStatus::kOk);
  for (const ExtendedArc<double>& arc : run.arcs()) {
    const double middle = 0.5 * (arc.t_end - arc.t_start);
    if (CalcVelocity(arc, middle) * y0 > 0) return {arc.t_start, CalcDisplacement(arc, 0.0)};
  }
  ADD_FAILURE() << "no second extremum";
  return {};
}

/// Largest difference between a run and the one that is started anew at its second extremum [m].
double CalcRestartError(const ExtendedOscillator<double>& oscillator, double y0) {
  const Extremum second = FindSecondExtremum(oscillator, y0);
  const SampleTimes later{.first = second.t, .step = 0.005, .size = 2000};
  const SampleTimes anew{.first = 0, .step = 0.005, .size = 2000};
  return MaxDifference(SolveAt(oscillator, y0, 0, later), SolveAt(oscillator, second.y, second.t, anew), 1, 1);
}

TEST(StribeckFriction, StartsAtAnExtremumAsIfItHadArrivedThere) {
  const Effect& effect = *FindEffect("stribeck_friction");
  for (const rig::Link& link : {rig::LateralSet1(), rig::LateralSet2(), rig::LongitudinalSet2()}) {
    for (const double s : {0.05, 0.15, 0.45}) {
      double worst = 0;
      for (const double v_s : {0.1, 0.3}) {
        const std::vector<double> values = {s, v_s * ScalesOf(link).speed};
        worst = std::max(worst, CalcRestartError(With<double>(MakePlain(link), effect, values), kStart));
      }
      Measured() << "k1 " << link.joints[0].k << ", s " << s << ": restarted |dy| <= " << worst << " m\n";
      // Exact for one joint up to the solver's own error; joints that stick one after the other are taken for stuck
      // together, which is below a tenth of the noise of 0.0125 mm.
      EXPECT_LT(worst, link.joints.size() == 1 ? 1e-9 : 1.25e-6);
    }
  }
}

TEST(StribeckFriction, MovesAsInTheRigFromTheSecondExtremumOn) {
  const Effect& effect = *FindEffect("stribeck_friction");
  double worst = 0;
  for (const rig::Link& link : {rig::LateralSet1(), rig::LateralSet2()}) {
    for (const double v_s : {0.1, 0.3}) {
      for (const double s : {0.05, 0.15, 0.45}) {
        const std::vector<double> values = {s, v_s * ScalesOf(link).speed};
        const ExtendedOscillator<double> oscillator = With<double>(MakePlain(link), effect, values);
        std::vector<double> differences;  // by halved steps
        for (const double step : {kStep, 0.5 * kStep, 0.25 * kStep}) {
          const rig::FreeDecay decay =
              rig::ReleaseFromExtremum(WithEffect(link, effect, values), kStart, kDuration, step);
          const rig::FreeDecay::Extremum second = decay.extrema.front();
          const auto from = static_cast<std::size_t>(std::ceil(second.t / step));
          const std::vector<double> rest(decay.y.begin() + static_cast<std::ptrdiff_t>(from), decay.y.end());
          const SampleTimes times{.first = decay.t[from] - second.t, .step = step, .size = rest.size()};
          differences.push_back(MaxDifference(SolveAt(oscillator, second.y, second.t, times), rest, 1, 1));
        }
        // The rig is of first order here, as the force jumps at a breakout somewhere within a step: what is left at the
        // last step is half of what the last halving changed. The rest is the formula of the start.
        EXPECT_LT(differences[2],
                  2 * std::abs(differences[0] - differences[1]) + CalcRestartError(oscillator, kStart) + 1e-8)
            << "k1 " << link.joints[0].k << ", v_s " << values[1] << ", s " << s;
        if (s < 0.2) worst = std::max(worst, differences[2]);
      }
    }
  }
  Measured() << "stribeck_friction, second extremum on, s <= 0.15: solver - rig at " << 0.25 * kStep
             << " s: |dy| <= " << worst << " m\n";
}

// ---------------------------------------------------------------------------------------------------------------------
// Readings.

constexpr double kFitStart = 2.31, kRelease = 2.05;  // [s]

/// The parameters of our readings for the rig's: amplitudes and phases where the fit begins, the zero there.
struct SameReading {
  std::vector<double> values;
  double zero = 0;  ///< what the zero offset has moved by until there [m]
};

SameReading Translate(std::string_view id, const rig::EffectSizes& e) {
  const double two_pi = 2 * std::numbers::pi;
  if (id == "cross_axis_motion") {
    const double A = e.cross_A * std::exp(-e.cross_decay * kFitStart);
    const double phase = two_pi * e.cross_f * kFitStart + e.cross_phase;
    return {{A * std::cos(phase), -A * std::sin(phase), e.cross_f, e.cross_decay}};
  }
  if (id == "rig_mode") {
    const double w = two_pi * e.mode_f, damped = std::sqrt(1 - e.mode_zeta * e.mode_zeta);
    const double A = e.mode_A / damped * std::exp(-e.mode_zeta * w * (kFitStart - kRelease));
    const double phase = w * damped * (kFitStart - kRelease);
    return {{A * std::sin(phase), A * std::cos(phase), e.mode_f, e.mode_zeta}};
  }
  if (id == "mains_hum") {
    const double phase = two_pi * e.hum_f * kFitStart + e.hum_phase;
    return {{e.hum_A * std::sin(phase), e.hum_A * std::cos(phase), e.hum_f}};
  }
  if (id == "sensor_drift") return {{e.drift_rate}, e.drift_rate * kFitStart};
  if (id == "sensor_saturation") return {{e.saturation_level}};
  if (id == "sensor_nonlinearity") return {{e.nonlinearity_e}};
  throw std::invalid_argument("no translation of " + std::string(id));
}

/// All values of an effect in the rig at the examples of its catalogue.
void SetExample(std::string_view id, rig::EffectSizes* sizes) {
  for (const rig::Effect& effect : rig::EffectCatalogue())
    if (effect.id == id)
      for (const rig::EffectParameter& p : effect.parameters) sizes->*p.value = p.example;
}

/// A motion of 25 mm, one value for each sample of the converter.
std::vector<double> MakeMotion(const rig::Sensor& sensor) {
  std::vector<double> y;
  for (int i = 0; i < 8000; ++i) y.push_back(0.025 * std::cos(6.3 * i / sensor.sampling_hz));
  return y;
}

/// Largest difference between the rig's readings and ours from kFitStart on [m], for the effects given.
double CompareReadings(const std::vector<const Effect*>& effects) {
  const rig::Sensor sensor{.noise = 0, .zero_offset = 0, .range = 0.064, .bits = 32, .keep_every = 1};
  rig::Truth truth;
  truth.release_s = kRelease;
  truth.zero_offset = 4e-4;
  double zero = truth.zero_offset;
  for (const Effect* effect : effects) {
    SetExample(effect->id, &truth.link.effects);
    zero += Translate(effect->id, truth.link.effects).zero;
  }
  const std::vector<double> y = MakeMotion(sensor);
  rig::NormalGenerator normal(1, 1, rig::NormalGenerator::Stream::kSensor);
  const std::vector<double> readings_mm = rig::Measure(y, truth, sensor, normal);
  double worst = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double t = static_cast<double>(i) / sensor.sampling_hz;
    if (t < kFitStart) continue;
    double reading = y[i];
    for (const ReadingStage stage :
         {ReadingStage::kSensed, ReadingStage::kCurve, ReadingStage::kAdded, ReadingStage::kClipped}) {
      for (const Effect* effect : effects)
        if (effect->stage == stage)
          reading = effect->Read<double>(Translate(effect->id, truth.link.effects).values, t, kFitStart, reading);
      if (stage == ReadingStage::kCurve) reading += zero;
    }
    worst = std::max(worst, std::abs(reading - 1e-3 * readings_mm[i]));
  }
  return worst;
}

constexpr double kConverterStep = 2 * 0.064 / 4294967296.0;  // of 32 bits [m]

TEST_P(EveryReading, ReadsAsInTheRig) {
  const double difference = CompareReadings({&effect()});
  EXPECT_LT(difference, kConverterStep);  // rounded to the nearest code: half a step and rounding of 25 mm
  Measured() << effect().id << " reading - rig: " << difference << " m\n";
}

TEST(Readings, ActInTheOrderOfTheRigsChain) {
  std::vector<const Effect*> all;
  for (const Effect* effect : Effects())
    if (!effect->IsMechanical()) all.push_back(effect);
  EXPECT_EQ(all.size(), 6u);
  EXPECT_LT(CompareReadings(all), kConverterStep);
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EveryMechanicalEffect,
                         testing::ValuesIn(Select([](const Effect& e) { return e.IsMechanical(); })), IdOf);
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryReading,
                         testing::ValuesIn(Select([](const Effect& e) { return !e.IsMechanical(); })), IdOf);

}  // namespace
}  // namespace uiclink
