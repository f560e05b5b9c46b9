#include "vehicle/link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "model/effect.h"
#include "model/extended_link.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/effect_values.h"

namespace uiclink {
namespace {

constexpr double kG = kThesisGravity;
constexpr double kLoad = 30e3;  // a corner of the laden wagon [N]
constexpr double kSpeed = 0.1;  // at which links are led [m/s]
constexpr double kSlack = LinkState::kSlack;

/// Table 4.2 of the thesis, longitudinal: four sliders that slip at 2.0, 2.6, 2.8 and 3.8 mm.
DirectionParameters MakeParameters() {
  DirectionParameters parameters;
  parameters.k = 5.50;
  parameters.sliders = {{3.44, 6.98e-3}, {2.00, 5.11e-3}, {0.33, 0.91e-3}, {1.90, 7.16e-3}};
  return parameters;
}

/// One slider that slips at y_c = 5 mm.
DirectionParameters MakeOneSlider() {
  DirectionParameters parameters;
  parameters.k = 4;
  parameters.sliders = {{2, 0.01}};
  return parameters;
}

using Values = std::vector<std::pair<std::string, double>>;

DirectionParameters With(DirectionParameters parameters, const std::string& id, const Values& values) {
  parameters.effects.push_back({.id = id, .parameters = values});
  return parameters;
}

DirectionParameters With(const DirectionParameters& parameters, const Effect& effect, double share) {
  const std::vector<double> law_values = MakeEffectValues(effect, share);
  Values values;
  for (std::size_t i = 0; i < law_values.size(); ++i) {
    const bool inverse = effect.parameters[i].coordinate == Coordinate::kInverseSquare;
    values.emplace_back(effect.parameters[i].symbol, inverse ? 1 / std::sqrt(law_values[i]) : law_values[i]);
  }
  return With(parameters, std::string(effect.id), values);
}

/// Mechanical effects of the catalogue that act on the wagon.
std::vector<const Effect*> WagonEffects() {
  std::vector<const Effect*> effects;
  for (const Effect* effect : Effects())
    if (effect->IsMechanical() && effect->id != "friction_drift") effects.push_back(effect);
  return effects;
}

double Stiffness(const Link& link) {
  double K = link.law().k;
  for (const ExtendedSlider<double>& slider : link.sliders()) K += slider.k;
  for (const Stop<double>& stop : link.law().stops.items()) K += stop.k;
  return link.load() * K;
}

/// Leads a link along d at constant speed, without acceleration, from event to event.
class Led {
 public:
  Led(const Link& link, const LinkState& start, double d) : state(start), link_(link), d_(d) {}

  void To(double d) {
    const double v = d > d_ ? kSpeed : -kSpeed;
    Change(v);
    while (Margin(d, v) <= 0) {
      double low = d_, high = d;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        (Margin(middle, v) > 0 ? low : high) = middle;
      }
      Pass(high, v);
      Change(v);
      ++events;
    }
    Pass(d, v);
  }

  double Force() const { return state.CalcForce(link_, d_, v_); }
  double d() const { return d_; }
  double v() const { return v_; }

  LinkState state;
  int events = 0;
  double work = 0;  ///< done on the link [J]

 private:
  double Margin(double d, double v) const { return state.CalcMargin(link_, d, v, 0); }
  void Change(double v) {
    for (int i = 0; i < 10 && (state.Switch(link_, d_, v, 0)); ++i) ASSERT_LT(i, 4);
    v_ = v;
    EXPECT_GT(Margin(d_, v), 0) << "at " << d_ << ": an event that has passed gives an alarm";
  }
  void Pass(double d, double v) {
    v_ = v;
    work -= 0.5 * (state.CalcForce(link_, d_, v) + state.CalcForce(link_, d, v)) * (d - d_);
    d_ = d;
  }

  const Link& link_;
  double d_, v_ = 0;
};

// ---------------------------------------------------------------------------------------------------------------------
// What a link is made of.

TEST(EffectsLeftOut, NamesWhatBelongsToRigRecordOrSensor) {
  DirectionParameters parameters;
  for (const Effect* effect : Effects())
    parameters.effects.push_back({.id = std::string(effect->id), .parameters = {}});
  EXPECT_THAT(EffectsLeftOut(parameters),
              testing::ElementsAre("friction_drift", "cross_axis_motion", "rig_mode", "sensor_drift",
                                   "sensor_saturation", "sensor_nonlinearity", "mains_hum"));
  EXPECT_TRUE(EffectsLeftOut(MakeParameters()).empty());
}

TEST(Link, LeavesThemOut) {
  const Link plain(MakeParameters(), kG, kLoad);
  const Link link(With(With(MakeParameters(), "friction_drift", {{"rate", 0.02}}), "sensor_drift", {}), kG, kLoad);
  EXPECT_FALSE(link.law().has_drift);
  EXPECT_EQ(link.sliders().size(), 4u);
  EXPECT_TRUE(link.is_affine());
  EXPECT_EQ(LinkState::AtRest(link, 0).CalcForce(link, 0.01, 0.1),
            LinkState::AtRest(plain, 0).CalcForce(plain, 0.01, 0.1));
}

TEST(Link, RefusesWhatItCannotBe) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const DirectionParameters good = MakeParameters();
  EXPECT_THROW(Link(good, kG, 0), std::invalid_argument);
  EXPECT_THROW(Link(good, kG, nan), std::invalid_argument);
  EXPECT_THROW(Link(good, 0, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "no such effect", {}), kG, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "viscous_damping", {}), kG, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "viscous_damping", {{"c", 0.01}, {"d", 1}}), kG, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "viscous_damping", {{"c", 0.01}, {"c", 0.02}}), kG, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "viscous_damping", {{"c", -0.01}}), kG, kLoad), std::invalid_argument);
  EXPECT_THROW(Link(With(good, "viscous_damping", {{"c", nan}}), kG, kLoad), std::invalid_argument);
  const Values micro_slip = {{"k", 0.3}, {"y_max", 2e-3}};
  const DirectionParameters fine = With(good, "micro_slip", micro_slip);
  EXPECT_NO_THROW(Link(fine, kG, kLoad));
  EXPECT_THROW(Link(With(fine, "micro_slip", micro_slip), kG, kLoad), std::invalid_argument);  // 36 sliders
  const Values stop = {{"k", 100}, {"position", 0.02}};
  const DirectionParameters two = With(With(good, "end_stop", stop), "end_stop", {{"k", 100}, {"position", -0.02}});
  EXPECT_NO_THROW(Link(two, kG, kLoad));
  EXPECT_THROW(Link(With(two, "end_stop", stop), kG, kLoad), std::invalid_argument);
  DirectionParameters bad = good;
  bad.sliders[1].T0 = -1e-3;
  EXPECT_THROW(Link(bad, kG, kLoad), std::invalid_argument);
  bad = good;
  bad.k = nan;
  EXPECT_THROW(Link(bad, kG, kLoad), std::invalid_argument);
}

TEST(Link, IsThePlainOneWhereEffectsAreNeutral) {
  const Link plain(MakeParameters(), kG, kLoad);
  for (const Effect* effect : WagonEffects()) {
    const Link link(With(MakeParameters(), *effect, 0), kG, kLoad);
    Led led(link, LinkState::AtRest(link, 0), 0), reference(plain, LinkState::AtRest(plain, 0), 0);
    EXPECT_TRUE(link.is_affine()) << effect->id;
    EXPECT_FALSE(link.needs_acceleration()) << effect->id;
    for (const double d : {1e-3, 0.02, -0.015, 2e-3, -1e-3}) {
      led.To(d);
      reference.To(d);
      EXPECT_EQ(led.Force(), reference.Force()) << effect->id << " at " << d;
      EXPECT_EQ(led.events, reference.events) << effect->id << " at " << d;
    }
  }
}

TEST(Link, HasNoForceFromJointsWithoutFrictionOrSpring) {
  DirectionParameters parameters = MakeOneSlider();
  parameters.sliders.push_back({3, 0});
  parameters.sliders.push_back({0, 0.01});
  const Link link(parameters, kG, kLoad), plain(MakeOneSlider(), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0), reference(plain, LinkState::AtRest(plain, 0), 0);
  for (const double d : {0.02, -0.015, 2e-3}) {
    led.To(d);
    reference.To(d);
    EXPECT_EQ(led.Force(), reference.Force());
    EXPECT_EQ(led.events, reference.events);
    EXPECT_EQ(led.state.CalcJointForce(link, 1, led.d(), led.v()), 0);
    EXPECT_EQ(led.state.CalcJointForce(link, 2, led.d(), led.v()), 0);
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// The loop.

TEST(LinkState, StartsRelaxed) {
  const Link link(MakeParameters(), kG, kLoad);
  const LinkState state = LinkState::AtRest(link, 3e-3);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(state.CalcJointForce(link, i, 3e-3, 0), 0);
  // The main spring is left; K d - C is a difference of terms that are three times as large.
  EXPECT_NEAR(state.CalcForce(link, 3e-3, 0), -kLoad * 5.50 * 3e-3, 4 * 2.2e-16 * Stiffness(link) * 3e-3);
  EXPECT_TRUE(state.AllStick());
  EXPECT_GT(state.CalcMargin(link, 3e-3, 0, 0), 0);
}

TEST(LinkState, ForcesStayExactlyOnTheirBoundsWhileJointsSlide) {
  const Link link(MakeParameters(), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  for (const double d : {0.01, 0.015, 0.02, -0.01, -0.017}) {
    led.To(d);
    const double side = d > 0 ? 1 : -1;
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_EQ(led.state.joints[i].slides, side) << i;
      const ExtendedSlider<double>& slider = link.sliders()[i];
      EXPECT_EQ(led.state.CalcJointForce(link, i, led.d(), led.v()), -side * kLoad * (slider.k * slider.y_c)) << i;
      EXPECT_EQ(led.state.CalcPosition(link, i, d, led.v()), d - side * slider.y_c) << i;
    }
    EXPECT_EQ(led.state.K, kLoad * 5.50);
    EXPECT_NEAR(led.Force(), -kLoad * (5.50 * d + side * 20.16e-3), 1e-12 * kLoad);  // rounding of a sum of five
  }
}

TEST(LinkState, LosesWhatClosedFormsSayInACycle) {
  // 4 T0 (A - y_c) per slider that slips, A > y_c.
  const Link link(MakeParameters(), kG, kLoad);
  for (const double A : {0.02, 5e-3, 2.6e-3, 2.2e-3, 1e-3}) {
    Led led(link, LinkState::AtRest(link, 0), 0);
    led.To(A);
    led.To(-A);
    led.To(A);
    const double before = led.work;
    led.To(-A);
    led.To(A);
    double expected = 0, slipping = 0;
    for (const Slider<double>& slider : MakeParameters().sliders) {
      const double y_c = slider.T0 / slider.k;
      if (A <= y_c) continue;
      expected += 4 * kLoad * slider.T0 * (A - y_c);
      slipping += kLoad * slider.T0;
    }
    // Each slider breaks out kSlack late, twice in a cycle, and rounding of the energy that goes to and fro.
    EXPECT_NEAR(led.work - before, expected, 4 * kSlack * slipping + 1e-15 * Stiffness(link) * A * A * 10) << A;
  }
}

TEST(LinkState, FollowsMasingsRule) {
  // The branches of the loop are the virgin curve, twice as large: F(A - 2x) = F(A) - 2 F(x).
  const Link link(MakeParameters(), kG, kLoad);
  constexpr double A = 0.012;
  Led led(link, LinkState::AtRest(link, 0), 0);
  led.To(A);
  const double at_A = led.Force();
  Led virgin(link, LinkState::AtRest(link, 0), 0);
  for (int i = 1; i < 40; ++i) {
    const double x = A * i / 40;
    virgin.To(x);
    led.To(A - 2 * x);
    EXPECT_NEAR(led.Force(), at_A - 2 * virgin.Force(), 4 * kSlack * Stiffness(link)) << x;
  }
}

TEST(LinkState, IsMirroredExactly) {
  for (const Effect* effect : WagonEffects()) {
    if (effect->signature.even_harmonics) continue;
    const Link link(With(MakeParameters(), *effect, 1), kG, kLoad);
    Led led(link, LinkState::AtRest(link, 0), 0), mirrored = led;
    for (const double d : {0.011, -0.02, 1e-3, 2e-3, -3e-3}) {
      led.To(d);
      mirrored.To(-d);
      EXPECT_EQ(led.Force(), -mirrored.Force()) << effect->id << " at " << d;
    }
  }
}

TEST(LinkState, SlidesAtAnotherForceToEachSideWhereFrictionIsAsymmetric) {
  const Link link(With(MakeOneSlider(), "asymmetric_friction", {{"a", 0.2}}), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  led.To(0.02);
  EXPECT_DOUBLE_EQ(led.state.CalcJointForce(link, 0, led.d(), led.v()), -kLoad * 0.012);
  led.To(-0.02);
  EXPECT_DOUBLE_EQ(led.state.CalcJointForce(link, 0, led.d(), led.v()), kLoad * 0.008);
}

TEST(LinkState, IsSlackWithinAClearance) {
  const Link link(With(MakeOneSlider(), "clearance", {{"gap", 1e-3}}), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  const auto T = [&](double d) {
    led.To(d);
    return led.state.CalcJointForce(link, 0, led.d(), led.v()) / kLoad;
  };
  constexpr double kRounding = 1e-16;
  EXPECT_EQ(T(0.9e-3), 0);
  EXPECT_NEAR(T(3e-3), -2 * 2e-3, kRounding);
  EXPECT_NEAR(T(6.1e-3), -0.01, kRounding);  // slides from gap + y_c = 6 mm on
  EXPECT_NEAR(T(10e-3), -0.01, kRounding);
  EXPECT_NEAR(T(6e-3), -2 * 1e-3, kRounding);  // sticks with p = 4 mm
  EXPECT_EQ(T(4.9e-3), 0);
  EXPECT_EQ(T(3.1e-3), 0);
  EXPECT_NEAR(T(2e-3), 2 * 1e-3, kRounding);
  EXPECT_NEAR(T(-3e-3), 0.01, kRounding);
  EXPECT_EQ(led.events, 5);  // engages, slides; leaves, engages, slides
}

TEST(LinkState, PushesBackBeyondAStop) {
  for (const double side : {1.0, -1.0}) {
    const Link link(With(MakeOneSlider(), "end_stop", {{"k", 100}, {"position", side * 8e-3}}), kG, kLoad);
    const Link plain(MakeOneSlider(), kG, kLoad);
    Led led(link, LinkState::AtRest(link, 0), 0), free(plain, LinkState::AtRest(plain, 0), 0);
    for (const double d : {7.9e-3, 8.5e-3, 9e-3, 8.1e-3, 7.9e-3, -0.02, 0.01}) {
      led.To(side * d);
      free.To(side * d);
      // to the rounding of K d, K with the stop
      EXPECT_NEAR(led.Force(), free.Force() - side * kLoad * 100 * std::max(0.0, d - 8e-3), 1e-15 * Stiffness(link))
          << d;
    }
  }
}

TEST(LinkState, BreaksOutFromTheStaticPeak) {
  const Link link(With(MakeOneSlider(), "stribeck_friction", {{"s", 0.2}, {"v_s", 0.05}}), kG, kLoad);
  const double sliding = 0.01 * (1 + 0.2 * std::exp(-4));  // at kSpeed = 2 v_s
  Led led(link, LinkState::AtRest(link, 0), 0);
  led.To(5.99e-3);  // of 1.2 y_c = 6 mm
  EXPECT_NEAR(led.state.CalcJointForce(link, 0, led.d(), led.v()), -kLoad * 2 * 5.99e-3, 1e-15 * kLoad);
  led.To(6.01e-3);
  EXPECT_DOUBLE_EQ(led.state.CalcJointForce(link, 0, led.d(), led.v()), -kLoad * sliding);
  EXPECT_DOUBLE_EQ(led.Force(), -kLoad * (sliding + 4 * 6.01e-3));
}

TEST(LinkState, SticksWhereItsLimitGrowsFasterThanItIsDeflected) {
  // Decelerating at a, a joint slides while v > y_c 2 s v/v_s^2 exp(-(v/v_s)^2) a (stribeck_friction.cpp).
  const Link link(With(MakeOneSlider(), "stribeck_friction", {{"s", 0.2}, {"v_s", 0.05}}), kG, kLoad);
  LinkState state = LinkState::WithForces(link, 0.02, 0.1, std::vector{-kLoad * link.CalcSlidingForce(0, 1, 0.1)});
  ASSERT_EQ(state.slides, 1);
  constexpr double a = -2;
  const double v = 0.05 * std::sqrt(std::log(2 * 5e-3 * 0.2 * 2 / (0.05 * 0.05)));
  EXPECT_GT(state.CalcMargin(link, 0.02, 1.001 * v, a), 0);
  EXPECT_LT(state.CalcMargin(link, 0.02, 0.999 * v, a), 0);
  EXPECT_GT(state.CalcMargin(link, 0.02, 0.999 * v, -a), 0);  // not while it gets faster
  EXPECT_FALSE(state.Switch(link, 0.02, 1.001 * v, a));
  const double before = state.CalcForce(link, 0.02, 0.999 * v);
  EXPECT_TRUE(state.Switch(link, 0.02, 0.999 * v, a));
  EXPECT_TRUE(state.AllStick());
  EXPECT_NEAR(state.CalcForce(link, 0.02, 0.999 * v), before, 1e-15 * Stiffness(link));
  EXPECT_GT(state.CalcMargin(link, 0.02, 0.999 * v, a), 0);
}

// ---------------------------------------------------------------------------------------------------------------------
// Changing over.

TEST(Switch, DoesNothingWithinAMode) {
  const Link link(MakeOneSlider(), kG, kLoad);
  LinkState state = LinkState::AtRest(link, 0);
  for (const double d : {0.0, 4.999e-3, -4.999e-3}) EXPECT_FALSE(state.Switch(link, d, 0.1, 0)) << d;
  EXPECT_TRUE(state.Switch(link, 5e-3 + kSlack, 0.1, 0));
  EXPECT_FALSE(state.Switch(link, 0.01, 0.05, 0));
  EXPECT_EQ(state.slides, 1);
}

TEST(Switch, TakesEventsThatAreFoundAWhileEarlyOrLate) {
  // An integrator knows the time within 1e-12 s: at 2 m/s d within 2e-12 m; and one that has come late is not lost.
  for (const double side : {1.0, -1.0}) {
    for (const double error : {-2e-12, -1e-12, 0.0, 1e-12, 1e-9, 1e-5}) {
      const Link link(MakeOneSlider(), kG, kLoad);
      LinkState state = LinkState::AtRest(link, 0);
      state.Switch(link, 0, side * 2, 0);
      const double d = side * (5e-3 + kSlack + error);
      EXPECT_EQ(state.CalcMargin(link, d, side * 2, 0) > 0, error < 0);
      EXPECT_TRUE(state.Switch(link, d, side * 2, 0)) << error;
      EXPECT_FALSE(state.Switch(link, d, side * 2, 0)) << error;
      EXPECT_EQ(state.slides, side);
      EXPECT_GT(state.CalcMargin(link, d, side * 2, 0), 0);
      EXPECT_EQ(state.CalcJointForce(link, 0, d, side * 2), -side * kLoad * 0.01);
    }
  }
}

TEST(Switch, ChangesEqualJointsTogether) {
  DirectionParameters parameters = MakeOneSlider();
  parameters.sliders = {{2, 0.01}, {0.7, 0.7 * 5e-3}, {1.3, 1.3 * 5e-3 * (1 + 1e-15)}};
  const Link link(parameters, kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  led.To(0.01);
  EXPECT_EQ(led.events, 1);
  EXPECT_EQ(led.state.joints[2].slides, 1);
  led.To(-0.01);
  EXPECT_EQ(led.events, 2);
}

TEST(Switch, KeepsAJointOnItsLimitWhereTheMotionOnlyTouchesIt) {
  const Link link(MakeOneSlider(), kG, kLoad);
  for (const double v : {0.0, 1e-11, -1e-11}) {
    LinkState state = LinkState::AtRest(link, 0);
    state.Switch(link, 0, 0.1, 0);
    const double d = 5e-3 + 1.1 * kSlack;
    EXPECT_TRUE(state.Switch(link, d, v, -1)) << v;
    EXPECT_FALSE(state.Switch(link, d, v, -1)) << v;
    EXPECT_TRUE(state.AllStick());
    EXPECT_NEAR(state.CalcJointForce(link, 0, d, v), -kLoad * 0.01, 1e-15 * kLoad);
    EXPECT_GT(state.CalcMargin(link, d, v, -1), 0) << v;
    // Whatever way it goes from here.
    LinkState back = state;
    back.Switch(link, d - 1e-9, -0.01, 0);
    EXPECT_TRUE(back.AllStick());
    EXPECT_GT(back.CalcMargin(link, d - 1e-9, -0.01, 0), 0);
    LinkState on = state;
    EXPECT_LT(on.CalcMargin(link, d + 2 * kSlack, 0.01, 0), 0);
    EXPECT_TRUE(on.Switch(link, d + 2 * kSlack, 0.01, 0));
    EXPECT_EQ(on.slides, 1);
  }
}

TEST(Switch, SticksWhereTheMotionReverses) {
  const Link link(MakeParameters(), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  led.To(0.02);
  LinkState state = led.state;
  EXPECT_GT(state.CalcMargin(link, 0.02, 0, 0), 0);  // it has reversed only when it goes back
  EXPECT_LT(state.CalcMargin(link, 0.02, -1.01 * LinkState::kAtRest, 0), 0);
  EXPECT_TRUE(state.Switch(link, 0.02, -LinkState::kAtRest, 0));
  EXPECT_FALSE(state.Switch(link, 0.02, -LinkState::kAtRest, 0));
  EXPECT_TRUE(state.AllStick());
  EXPECT_EQ(state.travel, -1);
  EXPECT_GT(state.CalcMargin(link, 0.02, -LinkState::kAtRest, 0), 0);
  EXPECT_NEAR(state.CalcForce(link, 0.02, 0), led.Force(), 1e-15 * Stiffness(link));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(state.joints[i].p, 0.02 - link.sliders()[i].y_c);
}

TEST(Switch, MarginsThatHaveFallenStayNegative) {
  // A slip within one step, over the threshold and back: negative at the end of the step.
  const Link link(MakeOneSlider(), kG, kLoad);
  LinkState state = LinkState::AtRest(link, 0);
  state.Switch(link, 4.9999e-3, 0.01, 0);
  EXPECT_GT(state.CalcMargin(link, 4.9999e-3, 0.01, 0), 0);
  EXPECT_LT(state.CalcMargin(link, 4.9999e-3, -0.01, 0), 0);
  EXPECT_FALSE(state.Switch(link, 4.9999e-3, -0.01, 0));  // no slip, only a reversal: the force is as it was
  EXPECT_GT(state.CalcMargin(link, 4.9999e-3, -0.01, 0), 0);
}

TEST(Switch, PassesClearanceAndLimitAtOnce) {
  const Link link(With(MakeOneSlider(), "clearance", {{"gap", 1e-3}}), kG, kLoad);
  LinkState state = LinkState::WithForces(link, 0, 0.1, std::vector{kLoad * 0.005});  // engaged below
  EXPECT_TRUE(state.Switch(link, 0.02, 0.1, 0));
  EXPECT_EQ(state.slides, 1);
  EXPECT_EQ(state.CalcJointForce(link, 0, 0.02, 0.1), -kLoad * 0.01);
}

TEST(Switch, NoiseAtRestMakesNoEvents) {
  const Link link(MakeParameters(), kG, kLoad);
  LinkState state = LinkState::AtRest(link, 0.01);
  state.Switch(link, 0.01, 1e-9, 0);
  for (const double v : {1e-11, -1e-11, 9e-11, -9e-11, 0.0}) EXPECT_GT(state.CalcMargin(link, 0.01, v, 0), 0) << v;
}

TEST(WithForces, IsTheStateThatHasThem) {
  for (const Effect* effect : WagonEffects()) {
    const Link link(With(MakeParameters(), *effect, 1), kG, kLoad);
    Led led(link, LinkState::AtRest(link, 0), 0);
    for (const double d : {2.5e-3, 0.011, 5e-3, -0.013, 1e-3, 2.3e-3}) {
      led.To(d);
      std::vector<double> T;
      bool loose = false;
      for (std::size_t i = 0; i < link.sliders().size(); ++i) {
        T.push_back(led.state.CalcJointForce(link, i, led.d(), led.v()));
        loose |= link.sliders()[i].joint && link.law().has_gap && T[i] == 0;
      }
      if (loose) continue;  // anywhere within its clearance
      const LinkState state = LinkState::WithForces(link, led.d(), led.v(), T);
      EXPECT_EQ(state.slides, led.state.slides) << effect->id << " at " << d;
      for (std::size_t i = 0; i < T.size(); ++i) {
        EXPECT_EQ(state.joints[i].slides, led.state.joints[i].slides) << effect->id << " at " << d << ", " << i;
        EXPECT_NEAR(state.CalcJointForce(link, i, led.d(), led.v()), T[i], 1e-15 * Stiffness(link));
      }
      EXPECT_NEAR(state.CalcForce(link, led.d(), led.v()), led.Force(), 1e-15 * Stiffness(link)) << effect->id;
    }
  }
  const Link link(MakeOneSlider(), kG, kLoad);
  EXPECT_THROW(LinkState::WithForces(link, 0, 0, std::vector{kLoad * 0.0101}), std::invalid_argument);
  EXPECT_THROW(LinkState::WithForces(link, 0, 0, std::vector<double>{}), std::invalid_argument);
  const LinkState turning = LinkState::WithForces(link, 0.02, 0, std::vector{-kLoad * 0.01});
  EXPECT_TRUE(turning.AllStick());
  EXPECT_TRUE(LinkState::WithForces(link, 0.02, -0.1, std::vector{-kLoad * 0.01}).AllStick());
  EXPECT_FALSE(LinkState::WithForces(link, 0.02, 0.1, std::vector{-kLoad * 0.01}).AllStick());
}

// ---------------------------------------------------------------------------------------------------------------------
// Slopes, and what linear stability sees.

TEST(CalcSlopes, AgreeWithDifferences) {
  for (const Effect* effect : WagonEffects()) {
    const Link link(With(With(MakeParameters(), "viscous_damping", {{"c", 0.02}}), *effect, 1), kG, kLoad);
    Led led(link, LinkState::AtRest(link, 0), 0);
    for (const double d : {1e-3, 2.4e-3, 0.013, 0.01, -0.02}) {  // all stick, some slide, all slide, all stick ...
      led.To(d);
      const double v = led.v(), h = 1e-5;
      const auto F = [&](double by_d, double by_v) { return led.state.CalcForce(link, d + by_d, v + by_v); };
      const LinkState::Slopes slopes = led.state.CalcSlopes(link, d, v);
      EXPECT_DOUBLE_EQ(slopes.F, F(0, 0)) << effect->id;
      // Rounding of F over h; h^2/6 of third derivatives: cubic stiffness 6 k3 Q, Stribeck T0 s/v_s^3.
      const double tolerance = 1e-15 * Stiffness(link) * 0.02 / h + h * h * kLoad * (400 + 2e-2 / 6e-6);
      EXPECT_NEAR(slopes.F_d, (F(h, 0) - F(-h, 0)) / (2 * h), tolerance) << effect->id << " at " << d;
      EXPECT_NEAR(slopes.F_v, (F(0, h) - F(0, -h)) / (2 * h), tolerance) << effect->id << " at " << d;
    }
  }
}

TEST(CalcSlopes, KnowTheSpeedOfSlidingJoints) {
  // F = -d Q T0 s exp(-(v/v_s)^2) + ...: friction that falls with speed drives, to either side.
  const Link link(With(MakeOneSlider(), "stribeck_friction", {{"s", 0.2}, {"v_s", 0.1}}), kG, kLoad);
  Led led(link, LinkState::AtRest(link, 0), 0);
  for (const double d : {0.02, -0.02}) {
    led.To(d);
    const double expected = kLoad * 0.01 * 0.2 * 2 * kSpeed / (0.1 * 0.1) * std::exp(-1);
    EXPECT_NEAR(led.state.CalcSlopes(link, d, led.v()).F_v, expected, 1e-14 * expected) << d;
  }
}

TEST(Rolling, HasTheStiffnessOfAllJoints) {
  const Link link(MakeParameters(), kG, kLoad);
  const LinkState::Slopes slopes = LinkState::Rolling(link).CalcSlopes(link, 0, 0);
  EXPECT_EQ(slopes.F, 0);
  EXPECT_DOUBLE_EQ(slopes.F_d, -kLoad * (5.50 + 7.67));
  EXPECT_EQ(slopes.F_v, 0);
}

TEST(Rolling, IsNotLockedByTheFrictionOfRolling) {
  const DirectionParameters parameters = With(MakeParameters(), "micro_slip", {{"k", 0.3}, {"y_max", 2e-3}});
  const Link link(With(parameters, "rolling_friction", {{"T_r", 3e-4}}), kG, kLoad), without(parameters, kG, kLoad);
  const LinkState state = LinkState::Rolling(link), locked = LinkState::AtRest(link, 0);
  EXPECT_EQ(state.CalcSlopes(link, 0, 0).F_d, LinkState::Rolling(without).CalcSlopes(without, 0, 0).F_d);
  EXPECT_NEAR(state.K, kLoad * (5.50 + 7.67 + 0.3), 1e-14 * kLoad * 13);
  EXPECT_NEAR(locked.K, state.K + kLoad * 3e-4 / Link::kRollingSlip, 1e-14 * kLoad * 40);
  ASSERT_LT(link.rolling_slider(), link.sliders().size());
  EXPECT_EQ(state.CalcJointForce(link, link.rolling_slider(), 1e-4, 0.1), 0);
  // Micro-slip is the first to slip, at y_max/32; rolling friction is no event.
  EXPECT_NEAR(state.CalcMargin(link, 0, 0, 0), 2e-3 / 32, 2 * kSlack);
  EXPECT_NEAR(locked.CalcMargin(link, 0, 0, 0), Link::kRollingSlip, 2 * kSlack);
}

TEST(Rolling, IsLooseWithinAClearance) {
  const Link link(With(MakeParameters(), "clearance", {{"gap", 1e-3}}), kG, kLoad);
  EXPECT_EQ(LinkState::Rolling(link).CalcSlopes(link, 0, 0).F_d, -kLoad * 5.50);
}

TEST(LinkState, TakesNoMemory) {
  DirectionParameters parameters = MakeParameters();
  for (const char* id : {"stribeck_friction", "velocity_strengthening", "clearance", "cubic_stiffness", "micro_slip"})
    parameters = With(parameters, *FindEffect(id), 1);
  const Link link(parameters, kG, kLoad);
  const std::size_t before = CountAllocations();
  LinkState state = LinkState::AtRest(link, 0);
  double sum = 0;
  int changes = 0;
  for (int i = 0; i < 1000; ++i) {
    const double d = 0.02 * std::sin(0.01 * i), v = 0.2 * std::cos(0.01 * i), a = -2 * std::sin(0.01 * i);
    if (state.CalcMargin(link, d, v, a) < 0) changes += state.Switch(link, d, v, a);
    sum += state.CalcForce(link, d, v) + state.CalcSlopes(link, d, v).F_d;
  }
  EXPECT_EQ(CountAllocations(), before);
  EXPECT_TRUE(std::isfinite(sum));
  EXPECT_GT(changes, 20);
}

// ---------------------------------------------------------------------------------------------------------------------
// The oscillator of a parameter set.

TEST(MakeExtendedOscillatorOfASet, HasTheEffectsOfTheSet) {
  const DirectionParameters set =
      With(With(With(MakeParameters(), "pendulum_geometry", {{"l", 0.25}}), "friction_drift", {{"rate", 0.02}}),
           "mains_hum", {});
  const ExtendedOscillator<double> oscillator = MakeExtendedOscillator<double>(set, kG);
  EXPECT_EQ(oscillator.g, kG);
  EXPECT_EQ(oscillator.drift, 0.02);
  ASSERT_EQ(oscillator.forces.size(), 1u);
  EXPECT_EQ(oscillator.forces.items()[0].p[0], 16);  // laws are given 1/l^2
  ASSERT_EQ(oscillator.sliders.size(), 4u);
  EXPECT_DOUBLE_EQ(oscillator.sliders.items()[3].k * oscillator.sliders.items()[3].y_c, 7.16e-3);
  const ExtendedOscillator<Dual<6>> dual = MakeExtendedOscillator<Dual<6>>(set, kG);
  EXPECT_EQ(dual.forces.items()[0].p[0].a, 16);
  EXPECT_TRUE(dual.forces.items()[0].p[0].v.isZero());
}

}  // namespace
}  // namespace uiclink
