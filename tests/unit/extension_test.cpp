// Unknowns of extended models: where they are, what they mean, and how they move from one model to another.

#include "identify/extension.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <vector>

#include "tests/unit/synthetic_records.h"

namespace uiclink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class EveryEffect : public testing::TestWithParam<const Effect*> {};
INSTANTIATE_TEST_SUITE_P(Catalogue, EveryEffect, testing::ValuesIn(Effects().begin(), Effects().end()),
                         [](const auto& effect) { return std::string(effect.param->id); });

TEST_P(EveryEffect, HasItsParametersOnceAndInOrder) {
  const Effect* effect = GetParam();
  const Extension extension({effect});
  std::vector<std::size_t> shared, own;
  for (const Extension::Unknown& u : extension.shared()) shared.push_back(u.parameter);
  for (const Extension::Unknown& u : extension.own()) own.push_back(u.parameter);
  EXPECT_TRUE(std::is_sorted(shared.begin(), shared.end()));
  EXPECT_TRUE(std::is_sorted(own.begin(), own.end()));
  EXPECT_EQ(shared.size() + own.size(), effect->parameters.size());
  for (const std::size_t p : shared) EXPECT_EQ(effect->parameters[p].scope, Scope::kLink);
  for (const std::size_t p : own) EXPECT_EQ(effect->parameters[p].scope, Scope::kRecord);
  EXPECT_EQ(extension.SharedOf(effect).size, shared.size());
  EXPECT_EQ(extension.OwnOf(effect).size, own.size());
  EXPECT_EQ(extension.CountMechanical(), effect->IsMechanical() ? static_cast<int>(effect->parameters.size()) : 0);
  EXPECT_EQ(extension.readings().size(), effect->stage == ReadingStage::kNone ? 0u : 1u);
}

TEST_P(EveryEffect, HasOrderedBoundsWithItsStartsInside) {
  const Extension extension({GetParam()});
  const std::vector<double> x = MakeCoordinates(*GetParam(), 1);
  const auto check = [&](std::span<const Extension::Unknown> unknowns) {
    for (const Extension::Unknown& u : unknowns) {
      EXPECT_LT(u.low, u.high) << u.Parameter().symbol;
      EXPECT_FALSE(std::isnan(u.low) || std::isnan(u.high)) << u.Parameter().symbol;
      EXPECT_GT(u.scale, 0) << u.Parameter().symbol;
      EXPECT_LE(u.low, x[u.parameter]) << u.Parameter().symbol;
      EXPECT_GE(u.high, x[u.parameter]) << u.Parameter().symbol;
      if (u.parameter > 0) continue;
      const double neutral = ToCoordinate(u.Parameter(), u.effect->neutral);
      EXPECT_LE(u.low, neutral) << u.Parameter().symbol;
      EXPECT_GE(u.high, neutral) << u.Parameter().symbol;
    }
  };
  check(extension.shared());
  check(extension.own());
}

TEST_P(EveryEffect, GoesToCoordinatesAndBack) {
  for (const EffectParameter& p : GetParam()->parameters)
    for (const double share : {0.1, 0.5, 0.9}) {
      const double high = std::isinf(p.high) ? 10.0 : p.high;
      const double value = p.low + share * (high - p.low);
      if (value == 0) continue;
      const double back = FromCoordinate(p, ToCoordinate(p, value));
      // exp(log x) is good to some |log x| roundings.
      EXPECT_NEAR(back, value, 1e-14 * std::abs(value) * (1 + std::abs(std::log(std::abs(value))))) << p.symbol;
    }
}

TEST_P(EveryEffect, StartsAtItsNeutralValueWhenItIsNew) {
  const Effect* effect = GetParam();
  const Extension extension({effect});
  ExtendedState plain;
  plain.link.starts.resize(3);
  plain.own.resize(3);
  const ExtendedState state = Convert(Extension(), plain, extension);
  ASSERT_EQ(state.shared.size(), extension.shared().size());
  ASSERT_EQ(state.own.size(), 3u);
  for (const std::vector<double>& own : state.own) {
    ASSERT_EQ(own.size(), extension.own().size());
    const LawValues values = extension.CalcLawValues(effect, state.shared, own);
    ASSERT_EQ(values.size(), effect->parameters.size());
    // Laws are given an inverse square as such: infinite lengths are 0.
    const bool inverse = effect->parameters[0].coordinate == Coordinate::kInverseSquare;
    EXPECT_EQ(values[0], inverse ? 0 : effect->neutral);
    if (effect->quadrature) {
      EXPECT_EQ(values[1], 0);
    }
    for (std::size_t p = 1; p < values.size(); ++p) {
      if (effect->quadrature && p == 1) continue;
      EXPECT_GE(values[p], effect->parameters[p].low) << effect->parameters[p].symbol;
      EXPECT_LE(values[p], effect->parameters[p].high) << effect->parameters[p].symbol;
    }
  }
}

TEST(Extension, OrdersUnknownsEffectAfterEffect) {
  const Effect *viscous = FindEffect("viscous_damping"), *mode = FindEffect("rig_mode"),
               *slider = FindEffect("extra_slider"), *drift = FindEffect("sensor_drift");
  const Extension extension({viscous, mode, slider, drift});
  ASSERT_EQ(extension.shared().size(), 5u);  // c; f, zeta; k, y_c
  ASSERT_EQ(extension.own().size(), 3u);     // A_cos, A_sin; rate
  EXPECT_EQ(extension.SharedOf(viscous).first, 0u);
  EXPECT_EQ(extension.SharedOf(mode).first, 1u);
  EXPECT_EQ(extension.SharedOf(mode).size, 2u);
  EXPECT_EQ(extension.SharedOf(slider).first, 3u);
  EXPECT_EQ(extension.SharedOf(slider).size, 2u);
  EXPECT_EQ(extension.OwnOf(mode).first, 0u);
  EXPECT_EQ(extension.OwnOf(drift).first, 2u);
  EXPECT_EQ(extension.OwnOf(viscous).size, 0u);
  EXPECT_EQ(extension.CountMechanical(), 3);
  const std::vector<double> shared = {0.01, std::log(23.0), std::log(0.02), 0.4, std::log(0.003)};
  const std::vector<double> own = {1e-4, 2e-4, 3e-5};
  const LawValues of_mode = extension.CalcLawValues(mode, shared, own);
  ASSERT_EQ(of_mode.size(), 4u);
  EXPECT_EQ(of_mode[0], 1e-4);
  EXPECT_EQ(of_mode[1], 2e-4);
  EXPECT_NEAR(of_mode[2], 23, 1e-12);  // rounding of exp(log)
  EXPECT_NEAR(of_mode[3], 0.02, 1e-15);
  const LawValues of_slider = extension.CalcLawValues(slider, shared, own);
  EXPECT_EQ(of_slider[0], 0.4);
  EXPECT_NEAR(of_slider[1], 0.003, 1e-16);
  const LawValues of_drift = extension.CalcLawValues(drift, shared, own);
  ASSERT_EQ(of_drift.size(), 1u);
  EXPECT_EQ(of_drift[0], 3e-5);
}

TEST(Extension, ReadsThroughItsStagesInTheirOrder) {
  const Extension extension({FindEffect("sensor_saturation"), FindEffect("mains_hum"),
                             FindEffect("sensor_nonlinearity"), FindEffect("cross_axis_motion"),
                             FindEffect("sensor_drift")});
  ASSERT_EQ(extension.readings().size(), 5u);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_LE(extension.readings()[i - 1]->stage, extension.readings()[i]->stage);
  EXPECT_EQ(extension.readings().front()->id, "cross_axis_motion");
  EXPECT_EQ(extension.readings().back()->id, "sensor_saturation");
  EXPECT_EQ(extension.effects().front()->id, "sensor_saturation");  // as it was given
}

TEST(Extension, TakesEffectsInAndOut) {
  const Effect *a = FindEffect("viscous_damping"), *b = FindEffect("sensor_drift");
  const Extension none, both = none.With(a).With(b);
  EXPECT_TRUE(none.empty());
  EXPECT_TRUE(both.Has(a) && both.Has(b));
  EXPECT_FALSE(both.Without(a).Has(a));
  EXPECT_TRUE(both.Without(a).Has(b));
  EXPECT_TRUE(both.Without(a).shared().empty());
  EXPECT_EQ(both.Without(b).own().size(), 0u);
  EXPECT_TRUE(both.Without(a).Without(b).empty());
  EXPECT_EQ(both.Without(FindEffect("mains_hum")).effects().size(), 2u);
}

TEST(Convert, KeepsWhatBothHave) {
  const Effect *viscous = FindEffect("viscous_damping"), *mode = FindEffect("rig_mode"),
               *drift = FindEffect("sensor_drift");
  const Extension from({viscous, mode, drift}), to({drift, FindEffect("extra_slider"), mode});
  ExtendedState state;
  state.link.levels = {{1.0, 0.5, -4.0}};
  state.link.starts = {{0.025, 0.1, 1e-4}, {-0.02, 0.2, 0}};
  state.shared = {0.01, 3.0, -4.0};
  state.own = {{1, 2, 3}, {4, 5, 6}};
  const ExtendedState there = Convert(from, state, to);
  EXPECT_EQ(there.link.levels, state.link.levels);
  EXPECT_EQ(there.link.starts, state.link.starts);
  ASSERT_EQ(there.shared.size(), 4u);
  EXPECT_EQ(there.shared[2], 3.0);
  EXPECT_EQ(there.shared[3], -4.0);
  EXPECT_EQ(there.shared[0], 0);  // the slider's stiffness: not there
  EXPECT_EQ(there.own, (std::vector<std::vector<double>>{{3, 1, 2}, {6, 4, 5}}));
  const ExtendedState back = Convert(to, there, from);
  EXPECT_EQ(back.shared, (std::vector<double>{0, 3.0, -4.0}));  // the damping was lost on the way
  EXPECT_EQ(back.own, state.own);
}

TEST(Convert, GivesEveryRecordItsOwnUnknownsWhenThereWereNone) {
  ExtendedState state;
  state.link.starts.resize(4);
  const ExtendedState with = Convert(Extension(), state, Extension({FindEffect("mains_hum")}));
  ASSERT_EQ(with.own.size(), 4u);
  for (const std::vector<double>& own : with.own) EXPECT_EQ(own, (std::vector<double>{0, 0}));
  ASSERT_EQ(with.shared.size(), 1u);
  EXPECT_GT(std::exp(with.shared[0]), 3);
  EXPECT_LT(std::exp(with.shared[0]), 500);
}

TEST(MakeExtendedOscillator, AddsTheMechanicsOnly) {
  const Extension extension({FindEffect("mains_hum"), FindEffect("viscous_damping"), FindEffect("pendulum_geometry")});
  // log f; c; 1/l^2
  const std::vector<double> shared = {3.0, 0.012, 1 / (0.3 * 0.3)};
  const ExtendedOscillator<double> oscillator = MakeExtendedOscillator(MakeLink(1), extension, shared);
  EXPECT_EQ(oscillator.damping, 0.012);
  EXPECT_EQ(oscillator.forces.size(), 1u);
  EXPECT_EQ(oscillator.k, 3.41);
  const ExtendedOscillator<double> plain = MakeExtendedOscillator(MakeLink(1), Extension(), {});
  EXPECT_EQ(plain.damping, 0);
  EXPECT_EQ(plain.sliders.size(), 1u);
}

TEST(ToCoordinate, PutsAnInfiniteLengthAtZero) {
  const EffectParameter& length = FindEffect("pendulum_geometry")->parameters[0];
  EXPECT_EQ(ToCoordinate(length, kInfinity), 0);
  EXPECT_EQ(FromCoordinate(length, 0), kInfinity);
  EXPECT_NEAR(FromCoordinate(length, 25), 0.2, 1e-16);
}

}  // namespace
}  // namespace uiclink
