// Every effect that the rig can add: against a closed form where there is one, and all of them against the same
// demands (neutral size, visibility, step, energy, settings).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "measurements/rig/rig.h"
#include "tests/validation/rig_fixture.h"

namespace uiclink::rig {

void PrintTo(const Effect& effect, std::ostream* stream) { *stream << effect.id; }

namespace {

using testing::HasSubstr;

/// Amplitudes (half the difference of successive extrema) of a free decay.
std::vector<double> Amplitudes(const FreeDecay& decay) {
  std::vector<double> amplitudes;
  for (std::size_t i = 1; i < decay.extrema.size(); ++i) {
    amplitudes.push_back(0.5 * std::abs(decay.extrema[i].y - decay.extrema[i - 1].y));
  }
  return amplitudes;
}

TEST(RigEffectOracle, ViscousDampingDecaysExponentiallyWhileRolling) {
  Link link = LateralSet2();
  link.effects.viscous_c = 0.02;
  const std::vector<double> a = Amplitudes(ReleaseFromExtremum(link, 0.045, 15));
  const double w2 = link.g * (link.k + link.joints[0].k), rate = 0.5 * link.g * 0.02;
  const double ratio = std::exp(-rate * kPi / std::sqrt(w2 - rate * rate));
  for (std::size_t i = 10; i < 30; ++i) EXPECT_NEAR(a[i + 1] / a[i], ratio, 1e-5) << i;
}

TEST(RigEffectOracle, RollingFrictionDecaysLinearlyAndStopsTheMass) {
  Link link = LateralSet2();
  link.effects.rolling_T_r = 3e-4;
  const FreeDecay decay = ReleaseFromExtremum(link, 0.045, 20);
  const std::vector<double> a = Amplitudes(decay);
  const double K = link.k + link.joints[0].k;
  ASSERT_GT(a.size(), 20u);
  for (std::size_t i = 9; i < 19; ++i) EXPECT_NEAR(a[i] - a[i + 1], 2 * 3e-4 / K, 1e-9) << i;
  EXPECT_EQ(decay.y.back(), decay.y[decay.y.size() - 10000]);  // at rest, exactly
  // At rest within +-T_r/K of the centre that the locked joint leaves, itself within T0/(k + k1) of zero.
  EXPECT_LT(std::abs(decay.y.back()), (3e-4 + link.joints[0].T0) / K);
}

TEST(RigEffectOracle, QuadraticDragFollowsItsExactHalfCycleMap) {
  // y'' + m v|v| + w^2 y = 0, m = d g, is linear in v^2 along y; between extrema A and A' (all positive)
  //   ln(1 - 2 m A') + 2 m A' = ln(1 + 2 m A) - 2 m A.
  Link link{.g = 9.82, .k = 10, .joints = {}, .effects = {}};
  link.effects.drag_d = 0.5;
  const double m = 0.5 * link.g;
  const FreeDecay decay = ReleaseFromExtremum(link, 0.03, 15);
  ASSERT_GT(decay.extrema.size(), 20u);
  double A = 0.03;
  for (const FreeDecay::Extremum& extremum : decay.extrema) {
    const double next = std::abs(extremum.y);
    // Slope of the left side is 4 m^2 A' = 3 1/m at most: 3e-8 stands for 1e-8 m.
    EXPECT_NEAR(std::log1p(-2 * m * next) + 2 * m * next, std::log1p(2 * m * A) - 2 * m * A, 3e-8);
    A = next;
  }
}

TEST(RigEffectOracle, StiffnessEffectsMoveTheFrequencyAsSeriesSay) {
  const double A = 0.02, K = 10;
  const Link linear{.g = 9.82, .k = K, .joints = {}, .effects = {}};
  const auto frequency = [&](const EffectSizes& effects) {
    Link link = linear;
    link.effects = effects;
    const FreeDecay decay = ReleaseFromExtremum(link, A, 15);
    return kPi * static_cast<double>(decay.extrema.size() - 1) / (decay.extrema.back().t - decay.extrema.front().t);
  };
  const double w0 = std::sqrt(linear.g * K);
  EffectSizes cubic;
  cubic.cubic_k3 = 500;  // Duffing: w/w0 = 1 + 3 k3 A^2/(8 K) - 21 (k3 A^2/K)^2/256 ...
  const double c = 500 * A * A / K;
  EXPECT_NEAR(frequency(cubic) / w0, 1 + 3 * c / 8 - 21 * c * c / 256, 1e-6);
  EffectSizes pendulum;
  pendulum.pendulum_l = 0.1;  // w/w0 = 1 - theta^2/16 + theta^4/3072 ..., theta = A/l
  EXPECT_NEAR(frequency(pendulum) / w0, 1 - 0.04 / 16 + 0.0016 / 3072, 1e-6);
  EffectSizes stop;
  stop.stop_k = 90, stop.stop_position = 1e-9;  // half the period with K, half with K + 90
  EXPECT_NEAR(frequency(stop) / w0, 2 / (1 + std::sqrt(K / (K + 90))), 1e-4);
}

TEST(RigEffectOracle, AsymmetryIsAConstantForce) {
  // T0+ = T0 (1 + a), T0- = T0 (1 - a): exactly the plain link about -T0 a/k, once every joint has been sliding.
  Link link = LateralSet1();
  const double shift = -0.014 * 0.1 / link.k;
  const FreeDecay plain = ReleaseFromExtremum(link, 0.045, 15);
  link.effects.asymmetry_a = 0.1;
  const FreeDecay skew = ReleaseFromExtremum(link, 0.045 + shift, 15);
  std::vector<double> shifted = plain.y;
  for (double& y : shifted) y += shift;
  EXPECT_LT(LargestDifference(shifted, skew.y), 1e-9);
}

TEST(RigEffectOracle, FrictionLawsHoldWhatTheySay) {
  Link link{.g = 9.82, .k = 3.4, .joints = {{.k = 400, .T0 = 0.018}}, .effects = {}};  // almost a rigid slider
  const auto decrement = [&] {
    const FreeDecay decay = ReleaseFromExtremum(link, 0.045, 1);
    return 0.045 + decay.extrema.at(0).y;  // 2 T/k for a constant friction T
  };
  const double plain = decrement();
  EXPECT_NEAR(plain, 2 * 0.018 / 3.4, 1e-4);  // the slider's own travel T0/k1 = 0.045 mm, twice
  link.effects.friction_rate = 0.1;           // mean of 1 + rate t over the half period of 0.544 s
  EXPECT_NEAR(decrement() / plain, 1 + 0.1 * 0.5 * kPi / std::sqrt(9.82 * 3.4), 2e-3);
  link.effects = {};
  link.effects.strengthening_b = 1;  // a sliding joint at T0 (1 + b v) is one at T0 beside the damping c = T0 b
  const double strengthened = decrement();
  link.effects = {};
  link.effects.viscous_c = 0.018;
  EXPECT_NEAR(strengthened, decrement(), 1e-4);  // again the slider's own travel
  EXPECT_GT(strengthened - plain, 1e-3);         // so that the line above compares something
  link.effects = {};
  link.effects.stribeck_s = 0.2, link.effects.stribeck_v_s = 1000;  // far below v_s all friction is 1 + s
  EXPECT_NEAR(decrement() / plain, 1.2, 2e-3);
}

TEST(RigEffectOracle, StrengtheningFollowsTheSpeedOfTheMass) {
  // From rest at A, T = -T0: harmonic with k + k1 until T = T0 (1 + b abs(v)), then the oscillator of stiffness k and
  // damping c = T0 b about T0/k until v = 0. The joint is soft, so its own speed would be another one.
  Link link = LateralSet2();
  const double b = link.effects.strengthening_b = 2;
  const double A = 0.04, g = link.g, k = link.k, k1 = link.joints[0].k, T0 = link.joints[0].T0;
  const double w_r = std::sqrt(g * (k + k1)), centre = (k1 * A - T0) / (k + k1);
  const auto y_stuck = [&](double t) { return centre + (A - centre) * std::cos(w_r * t); };
  const auto v_stuck = [&](double t) { return -(A - centre) * w_r * std::sin(w_r * t); };
  double stuck = 0, slides = 0.5 * kPi / w_r;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (stuck + slides);
    (-T0 + k1 * (A - y_stuck(t)) > T0 * (1 - b * v_stuck(t)) ? slides : stuck) = t;
  }
  const double x = y_stuck(slides) - T0 / k, v = v_stuck(slides);
  const double d = 0.5 * g * T0 * b, w = std::sqrt(g * k - d * d);
  // x(t) = e^(-d t) (x cos wt + (v + d x)/w sin wt); its speed vanishes where tan wt = v w/(d v + (d^2 + w^2) x).
  const double t = (std::atan2(v * w, d * v + (d * d + w * w) * x) + (v < 0 && x > 0 ? kPi : 0.0)) / w;
  const double end = T0 / k + std::exp(-d * t) * (x * std::cos(w * t) + (v + d * x) / w * std::sin(w * t));
  const FreeDecay decay = ReleaseFromExtremum(link, A, 1);
  EXPECT_NEAR(decay.extrema.at(0).t, slides + t, 1e-6);
  EXPECT_NEAR(decay.extrema.at(0).y, end, 1e-8);  // (w h)^2/24 of A is 2e-8 m in a whole period
}

TEST(RigEffectOracle, ForceBumpHasThePeriodOfItsPotential) {
  const double A = 0.02, height = 0.004, centre = 0.012, width = 0.002;
  Link link{.g = 9.82, .k = 4, .joints = {}, .effects = {}};
  link.effects.bump_height = height, link.effects.bump_centre = centre, link.effects.bump_width = width;
  const auto dip = [&](double u) { return -height * width * std::exp(0.5 - 0.5 * u * u); };
  const auto potential = [&](double y) {
    return 0.5 * link.k * y * y + dip((y - centre) / width) + dip((y + centre) / width);
  };
  // Half a period: the integral of dy/v with y = A sin(a), which is smooth and periodic, so that equal steps converge
  // faster than any power.
  double half_period = 0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; ++i) {
    const double a = kPi * ((i + 0.5) / kSteps - 0.5), y = A * std::sin(a);
    half_period += A * std::cos(a) / std::sqrt(2 * link.g * (potential(A) - potential(y))) * kPi / kSteps;
  }
  const FreeDecay decay = ReleaseFromExtremum(link, A, 15);
  const std::size_t n = decay.extrema.size();
  ASSERT_GT(n, 20u);
  EXPECT_NEAR(decay.extrema.back().t / (static_cast<double>(n) * half_period), 1, 1e-6);
  EXPECT_NEAR(std::abs(decay.extrema.back().y), A, 1e-8);                         // it loses nothing
  EXPECT_GT(std::abs(half_period * std::sqrt(link.g * link.k) / kPi - 1), 1e-3);  // the bump matters
}

TEST(RigEffectOracle, ModulatedStiffnessPumpsAtTwiceTheFrequency) {
  // Mathieu: x'' + w^2 (1 + a sin 2wt) x = 0 grows as exp(a w t/4), with a relative error of the order of a^2.
  Link link{.g = 9.82, .k = 4, .joints = {}, .effects = {}};
  const double w = std::sqrt(link.g * link.k), a = 0.04;
  link.effects.modulation_a = a, link.effects.modulation_f = w / kPi, link.effects.modulation_phase = 0;
  const FreeDecay decay = ReleaseFromExtremum(link, 0.01, 60);
  ASSERT_GT(decay.extrema.size(), 100u);
  const auto& early = decay.extrema[60];  // the falling solution, which it starts with too, has gone by exp(-2 a w t/4)
  const auto& late = decay.extrema[110];
  EXPECT_NEAR(std::log(std::abs(late.y / early.y)) / (late.t - early.t), a * w / 4, 5e-3 * a * w / 4);
}

TEST(RigEffectOracle, MaxwellBranchDecaysAsItsEigenvalueSays) {
  // (s^2 + g k)(s + 1/tau) + g k_m s = 0.
  Link link{.g = 9.82, .k = 4, .joints = {}, .effects = {}};
  const double k_m = link.effects.maxwell_k = 0.3, tau = link.effects.maxwell_tau = 0.2;
  std::complex<double> s(0, std::sqrt(link.g * link.k));
  for (int i = 0; i < 20; ++i) {
    const std::complex<double> f = (s * s + link.g * link.k) * (s + 1 / tau) + link.g * k_m * s;
    const std::complex<double> slope = 2.0 * s * (s + 1 / tau) + s * s + link.g * k_m + link.g * link.k;
    s -= f / slope;
  }
  const FreeDecay decay = ReleaseFromExtremum(link, 0.02, 15);
  ASSERT_GT(decay.extrema.size(), 25u);
  for (std::size_t i = 10; i < 25; ++i) {  // after 10 half swings the relaxing part, exp(-4.6 t), is below 1e-10
    EXPECT_NEAR(decay.extrema[i + 1].y / decay.extrema[i].y, -std::exp(s.real() * kPi / s.imag()), 1e-5) << i;
    EXPECT_NEAR(decay.extrema[i + 1].t - decay.extrema[i].t, kPi / s.imag(), 1e-6) << i;
  }
}

// ---------------------------------------------------------------- effects

void SwitchOn(const Effect& effect, EffectSizes& sizes) {
  for (const EffectParameter& p : effect.parameters) sizes.*p.value = p.example;
}

/// What halving the step may move, with the examples' sizes. The noise of a record is 0.013 mm.
double StepError_mm(const std::string& id) {
  if (id == "stribeck_friction")
    return 3e-3;                      // the force jumps at a moment known to one step: T0 s g h/w = 3e-4 a slip
  if (id == "end_stop") return 3e-4;  // w of the stop is 44 rad/s, so (w h)^2 is 40 times that of the link
  return 5e-5;                        // (w h)^2/24 over 15 s is 1e-5 mm; slips add as much
}

class EveryRigEffect : public testing::TestWithParam<Effect> {};

TEST_P(EveryRigEffect, VanishesAtItsNeutralSize) {
  Settings settings = IdealSettings(LateralSet1());
  const std::vector<double> plain = MakeRecord(settings, 1).y_mm;
  SwitchOn(GetParam(), settings.link.effects);
  const auto size = GetParam().parameters.front().value;
  settings.link.effects.*size = EffectSizes{}.*size;
  EXPECT_EQ(MakeRecord(settings, 1).y_mm, plain);
}

TEST_P(EveryRigEffect, ChangesTheRecordVisibly) {
  Settings settings = IdealSettings(LateralSet1());
  const std::vector<double> plain = MakeRecord(settings, 1).y_mm;
  SwitchOn(GetParam(), settings.link.effects);
  const RigRecord changed = MakeRecord(settings, 1);
  EXPECT_GT(LargestDifference(changed.y_mm, plain), 0.04);  // three times the noise of a record
  EXPECT_NEAR(std::abs(changed.truth.first_extremum), settings.push.first_extremum, 1e-8);  // the push adapts
}

TEST_P(EveryRigEffect, IsResolvedByTheStep) {
  Settings settings = IdealSettings(LateralSet1());
  SwitchOn(GetParam(), settings.link.effects);
  EXPECT_LT(HalvingError_mm(settings), StepError_mm(GetParam().id));
}

TEST_P(EveryRigEffect, KeepsTheEnergyBalance) {
  Link link = LongitudinalSet2();
  SwitchOn(GetParam(), link.effects);
  const FreeDecay decay = ReleaseFromExtremum(link, 0.03, 10);
  double worst = 0;
  for (std::size_t i = 0; i < decay.t.size(); ++i) {
    worst = std::max(worst, std::abs(decay.energy[i] + decay.loss[i] - decay.energy[0]));
  }
  // First order in the step where forces jump (2e-5 with a static peak), second elsewhere.
  EXPECT_LT(worst, 5e-5 * decay.energy[0]);
  const bool feeds = std::string(GetParam().id) == "stiffness_modulation";  // whoever changes the spring does work
  EXPECT_EQ(std::is_sorted(decay.loss.begin(), decay.loss.end()), !feeds);
}

TEST_P(EveryRigEffect, IsReadFromSettings) {
  const Effect& effect = GetParam();
  std::ostringstream text;
  text << "direction = \"lateral\"\n[link]\nk = 4\nsliders = [{ k = 1, T0 = 0.01 }]\n[effects." << effect.id << "]\n";
  for (const EffectParameter& p : effect.parameters) text << p.symbol << " = " << p.example << "\n";
  const Settings settings = ParseSettings(text.str(), "some.toml");
  for (const EffectParameter& p : effect.parameters) EXPECT_DOUBLE_EQ(settings.link.effects.*p.value, p.example);
}

INSTANTIATE_TEST_SUITE_P(All, EveryRigEffect, testing::ValuesIn(AllEffects()),
                         [](const auto& effect) { return std::string(effect.param.id); });

TEST(RigEffects, AreTheTwentyOfTheDesign) {
  std::vector<std::string> ids;
  for (const Effect& effect : EffectCatalogue()) ids.push_back(effect.id);
  EXPECT_THAT(
      ids, testing::UnorderedElementsAre("viscous_damping", "quadratic_drag", "rolling_friction", "micro_slip",
                                         "extra_slider", "cubic_stiffness", "quadratic_stiffness", "stribeck_friction",
                                         "velocity_strengthening", "friction_drift", "asymmetric_friction",
                                         "pendulum_geometry", "clearance", "end_stop", "cross_axis_motion", "rig_mode",
                                         "sensor_drift", "sensor_saturation", "sensor_nonlinearity", "mains_hum"));
}

TEST(RigEffects, BeyondTheCatalogueStayThere) {
  std::vector<std::string> outside;
  for (const Effect& effect : OutsideCatalogue()) outside.push_back(effect.id);
  EXPECT_THAT(outside, testing::UnorderedElementsAre("force_bump", "stiffness_modulation", "maxwell_branch"));
  EXPECT_EQ(AllEffects().size(), EffectCatalogue().size() + OutsideCatalogue().size());
}

TEST(RigEffects, StandInTheTablesOfTheReadme) {
  const std::string readme = ReadFile(kMeasurements / "rig/README.md");
  EXPECT_THAT(readme, HasSubstr(FormatEffectTable(EffectCatalogue())));
  EXPECT_THAT(readme, HasSubstr(FormatEffectTable(OutsideCatalogue())));
}

TEST(RigEffects, ActTogether) {
  Settings settings = IdealSettings(LateralSet1());
  const std::vector<double> plain = MakeRecord(settings, 1).y_mm;
  for (const Effect& effect : AllEffects()) SwitchOn(effect, settings.link.effects);
  settings.link.effects.stop_position = 0.04;
  settings.link.effects.saturation_level = 0.03;
  const RigRecord all = MakeRecord(settings, 1);
  EXPECT_NEAR(std::abs(all.truth.first_extremum), settings.push.first_extremum, 1e-8);
  // Each of them still matters when the others act.
  for (const Effect& effect : AllEffects()) {
    if (std::string(effect.id) == "end_stop" || std::string(effect.id) == "sensor_saturation")
      continue;  // out of reach
    Settings without = settings;
    const auto size = effect.parameters.front().value;
    without.link.effects.*size = EffectSizes{}.*size;
    EXPECT_GT(LargestDifference(MakeRecord(without, 1).y_mm, all.y_mm), 0.01) << effect.id;
  }
  EXPECT_GT(LargestDifference(all.y_mm, plain), 1);
}

TEST(RigEffects, ASofteningLinkIsNotPushedOverTheTop) {
  Settings settings = IdealSettings(LateralSet1());
  settings.link.joints[0].T0 = 0.006;  // so that the first push that is tried would do so
  settings.link.effects.cubic_k3 = -0.45 * settings.link.k / (0.025 * 0.025);  // the top is at 37 mm
  const RigRecord record = MakeRecord(settings, 1);
  EXPECT_NEAR(record.truth.first_extremum, 0.025, 1e-8);
  EXPECT_LT(*std::max_element(record.y_mm.begin(), record.y_mm.end()), 25.001);
}

TEST(RigEffects, MeasurementEffectsAreExactlyWhatTheTableSays) {
  Settings settings = IdealSettings(LateralSet1());
  const RigRecord plain = MakeRecord(settings, 1);
  EffectSizes& e = settings.link.effects;
  e.nonlinearity_e = 1.5;
  e.drift_rate = 2e-5;
  e.hum_A = 5e-5, e.hum_f = 153, e.hum_phase = 0.3;
  e.cross_A = 4e-4, e.cross_f = 1.4, e.cross_decay = 0.2, e.cross_phase = 1;
  e.mode_A = 3e-4, e.mode_f = 20, e.mode_zeta = 0.02;
  const RigRecord changed = MakeRecord(settings, 1);
  for (std::size_t i = 0; i < plain.t.size(); ++i) {
    const double t = plain.t[i], free = std::max(0.0, t - plain.truth.release_s), w = 2 * kPi * 20;
    double y = 1e-3 * plain.y_mm[i] + 4e-4 * std::exp(-0.2 * t) * std::cos(2 * kPi * 1.4 * t + 1);
    const double wd = w * std::sqrt(1 - 0.02 * 0.02);
    y += 3e-4 * w / wd * std::exp(-0.02 * w * free) * std::sin(wd * free);
    y = y * (1 + 1.5 * y) + 2e-5 * t + 5e-5 * std::sin(2 * kPi * 153 * t + 0.3);
    ASSERT_NEAR(changed.y_mm[i], 1e3 * y, 1e-6) << "t = " << t;  // two steps of the 32-bit converter and rounding
  }
}

TEST(RigEffects, SaturationIsFlat) {
  Settings settings = IdealSettings(LateralSet1());
  settings.link.effects.saturation_level = 0.018;
  const std::vector<double> y = MakeRecord(settings, 1).y_mm;
  EXPECT_NEAR(*std::max_element(y.begin(), y.end()), 18, 1e-6);
  EXPECT_GT(std::count(y.begin(), y.end(), *std::max_element(y.begin(), y.end())), 30);
}

}  // namespace
}  // namespace uiclink::rig
