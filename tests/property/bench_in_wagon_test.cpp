// The bench inside the wagon: the car body on its links, wheelsets held, swings as the solvers of the bench say. The
// right-hand side is that of the wagon (CalcRate), the events are those of its links, as in vehicle/integrator.cpp.
//
// Sway: with h = 0 links and guidance act at the height of the centre of mass, so that a body that sways does not roll;
// four equal corners do not yaw it either. dy = -y_c at each of them, and their loads add up to m_c g: the bench's
// equation for d = -y_c.
//
// Longitudinal links: through the body's yaw, exactly. dx = Y psi = +-b psi, and the moment is b (F left - F right):
//   I_z psi'' = 4 b F(b psi)   is   u'' = g m_c b^2/I_z F(u)/Q   for u = b psi,
// the bench's equation for a body whose radius of gyration is b. The moments of the second order, psi P_x X, cancel
// between front and rear. The lateral links would add their own moment about the same axis, so they get the stiffness
// 1e-300, which no sum sees. Effects that tell +d from -d are tried in sway alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <string>
#include <vector>

#include "model/effect.h"
#include "model/event_solver.h"
#include "model/extended_link.h"
#include "model/extended_solver.h"
#include "model/extremum_deflection.h"
#include "tests/support/effect_values.h"
#include "tests/support/wagon_fixture.h"
#include "vehicle/event_ode.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

constexpr double kSeconds = 15;
constexpr double kStep = 0.05;  // [s] between samples
const SampleTimes kSamples{.first = 0, .step = kStep, .size = static_cast<std::size_t>(kSeconds / kStep) + 1};
constexpr double kHeld = 1e-8;  // [m]: what is asked of the wagon

std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

/// The body of a real wagon, which sways (lateral links) or yaws (longitudinal ones) at one frequency of the bench.
class BodyOnLinks {
 public:
  BodyOnLinks(Direction direction, const DirectionParameters& parameters, const char* freight = "empty")
      : direction_(direction), wagon_(MakeWagon(direction, parameters, freight)) {}

  const Wagon& wagon() const { return wagon_; }
  const Link& link() const { return Links()[0]; }

  /// Deflection of the link at front left, from the extremum d0 on at which all joints slid.
  std::vector<double> Swing(double d0) {
    StateVector<double> x{};
    x[kBody + Place()] = direction_ == Direction::kLateral ? -d0 : d0 / wagon_.b;
    for (std::size_t i = 0; i < kCorners; ++i) {
      const CornerDeflection<double> d = CalcDeflection(wagon_, x, i);
      states_.longitudinal[i] = direction_ == Direction::kLongitudinal
                                    ? AtExtremumOf(wagon_.longitudinal[i], d.dx)
                                    : LinkState::AtRest(wagon_.longitudinal[i], d.dx);
      states_.lateral[i] = direction_ == Direction::kLateral ? AtExtremumOf(wagon_.lateral[i], d.dy)
                                                             : LinkState::AtRest(wagon_.lateral[i], d.dy);
    }
    Switch(x);
    EventOde ode{.size = body::kSize, .guards = 1, .rate = {}, .guard = {}, .pass = {}};
    ode.rate = [&](double, std::span<const double> y, std::span<double> rate) {
      const StateVector<double> all = CalcHeldRate(Whole(y));
      std::copy_n(all.begin() + kBody, body::kSize, rate.begin());
    };
    ode.guard = [&](double, std::span<const double> y, std::span<double> guards) { guards[0] = Margin(Whole(y)); };
    ode.pass = [&](double, std::span<double> y, std::span<const int>) { Switch(Whole(y)); };
    std::vector<double> swing(kSamples.size), other(kSamples.size);
    const auto sample = [&](std::size_t i, double, std::span<const double> y) {
      const CornerDeflection<double> d = CalcDeflection(wagon_, Whole(y), 0);
      swing[i] = direction_ == Direction::kLateral ? d.dy : d.dx;
      for (std::size_t k = 0; k < body::kSize; k += 2)
        if (k != Place()) strayed_ = std::max(strayed_, std::abs(y[k]));
    };
    // As in tests/support/link_swing.h: events are looked for on an interpolation that is exact over 2 ms.
    counts_ = SolveEventOde(ode, std::span(x).subspan(kBody, body::kSize), kStep, kSamples.size, sample,
                            {.rtol = 1e-12, .atol = {1e-14}, .max_step = 2e-3});
    return swing;
  }
  /// Largest of the motions that the body should not have [m], [rad].
  double strayed() const { return strayed_; }
  const EventOdeCounts& counts() const { return counts_; }

 private:
  static Wagon MakeWagon(Direction direction, const DirectionParameters& parameters, const char* freight) {
    WagonFixture fixture{.set = "set1", .freight = freight, .options = {}};
    fixture.options.guidance = false;  // 20 mm of clearance are less than a swing of the bench
    CornerLinks links = fixture.ReadLinks();
    BodyInertia body = fixture.ReadBody();
    body.x = body.y = body.h = 0;
    const WagonData data = fixture.ReadData();
    if (direction == Direction::kLateral) {
      links.lateral = parameters;
    } else {
      links.longitudinal = parameters;
      links.lateral = {};
      links.lateral.k = 1e-300;
      body.I_z = body.m * data.b * data.b;
    }
    return Wagon(data, body, fixture.freight != "empty", {links, links, links, links}, MakeHandMadeTable(),
                 fixture.options);
  }

  static LinkState AtExtremumOf(const Link& link, double d0) {
    const double side = d0 < 0 ? -1 : 1;
    std::vector<double> T;
    for (std::size_t i = 0; i < link.sliders().size(); ++i) {
      const ExtendedSlider<double>& slider = link.sliders()[i];
      const double gap = slider.joint ? link.law().gap : 0;
      T.push_back(-side * link.load() * slider.k * (CalcDeflectionAtExtremum(link.law(), i, d0, 0.0) - gap));
    }
    return LinkState::WithForces(link, d0, 0, T);
  }

  const std::array<Link, kCorners>& Links() const {
    return direction_ == Direction::kLateral ? wagon_.lateral : wagon_.longitudinal;
  }
  std::size_t Place() const { return direction_ == Direction::kLateral ? body::kY : body::kPsi; }

  static StateVector<double> Whole(std::span<const double> y) {
    StateVector<double> x{};  // wheelsets where wheels of radius r0 stand on the rails
    std::copy(y.begin(), y.end(), x.begin() + kBody);
    return x;
  }
  StateVector<double> CalcHeldRate(const StateVector<double>& x) const {
    StateVector<double> rate;
    CalcRate(wagon_, 20, states_, x, &rate);
    std::fill_n(rate.begin(), kBody, 0.0);
    return rate;
  }
  struct LinkMotion {
    double d, v, a;
  };
  LinkMotion MotionOf(bool longitudinal, std::size_t i, const StateVector<double>& x,
                      const StateVector<double>& rate) const {
    const CornerDeflection<double> d = CalcDeflection(wagon_, x, i), moves = CalcDeflection(wagon_, rate, i);
    return longitudinal ? LinkMotion{d.dx, d.vx, moves.vx} : LinkMotion{d.dy, d.vy, moves.vy};
  }
  double Margin(const StateVector<double>& x) const {
    const StateVector<double> rate = CalcHeldRate(x);
    double margin = 1;
    for (std::size_t i = 0; i < kCorners; ++i) {
      for (const bool longitudinal : {true, false}) {
        const LinkMotion m = MotionOf(longitudinal, i, x, rate);
        const Link& link = (longitudinal ? wagon_.longitudinal : wagon_.lateral)[i];
        const LinkState& state = (longitudinal ? states_.longitudinal : states_.lateral)[i];
        margin = std::min(margin, state.CalcMargin(link, m.d, m.v, m.a));
      }
    }
    return margin;
  }
  void Switch(const StateVector<double>& x) {
    bool changed = true;
    for (int round = 0; changed && round < 32; ++round) {
      changed = false;
      const StateVector<double> rate = CalcHeldRate(x);  // one acceleration for all: they change over together
      for (std::size_t i = 0; i < kCorners; ++i) {
        for (const bool longitudinal : {true, false}) {
          const LinkMotion m = MotionOf(longitudinal, i, x, rate);
          const Link& link = (longitudinal ? wagon_.longitudinal : wagon_.lateral)[i];
          LinkState& state = (longitudinal ? states_.longitudinal : states_.lateral)[i];
          changed |= state.Switch(link, m.d, m.v, m.a);
        }
      }
    }
    EXPECT_FALSE(changed) << "the joints change for ever";
  }

  Direction direction_;
  Wagon wagon_;
  LinkStates states_;
  double strayed_ = 0;
  EventOdeCounts counts_;
};

double MaxDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

DirectionParameters ReadDirection(const char* set, Direction direction) {
  const CornerLinks links = WagonFixture{.set = set, .freight = "empty", .options = {}}.ReadLinks();
  return direction == Direction::kLateral ? links.lateral : links.longitudinal;
}

std::vector<double> SolvePlain(const DirectionParameters& parameters, double g, double d0) {
  const Oscillator<double> oscillator = MakeOscillator(parameters, g);
  Trajectory<double> run;
  EXPECT_EQ(Solve(oscillator, AtExtremum(oscillator, d0), kSeconds, &run), SolveStatus::kOk);
  std::vector<double> y(kSamples.size);
  CalcDisplacements(run, kSamples, y);
  return y;
}

std::vector<double> SolveExtended(const ExtendedOscillator<double>& oscillator, double d0,
                                  ExtendedTrajectory<double>* run) {
  EXPECT_EQ(Solve(oscillator, d0, 0.0, kSeconds, run), SolveStatus::kOk);
  std::vector<double> y(kSamples.size);
  CalcDisplacements(*run, kSamples, y);
  return y;
}

struct Choice {
  const char* set;
  Direction direction;
};
std::string NameOf(const Choice& choice) { return std::string(choice.set) + "_" + Name(choice.direction); }
void PrintTo(const Choice& choice, std::ostream* out) { *out << NameOf(choice); }

class BenchInWagon : public testing::TestWithParam<Choice> {
 protected:
  DirectionParameters Parameters() const { return ReadDirection(GetParam().set, GetParam().direction); }
};

TEST_P(BenchInWagon, SwingsAsTheEventSolverSays) {
  for (const char* freight : {"empty", "packed"}) {
    for (const double d0 : {25.3e-3, -15e-3, 45e-3, 12e-3}) {
      BodyOnLinks body(GetParam().direction, Parameters(), freight);
      const double difference = MaxDifference(body.Swing(d0), SolvePlain(Parameters(), body.wagon().g, d0));
      Measured() << NameOf(GetParam()) << ", " << freight << ", from " << 1e3 * d0 << " mm: |dd| <= " << difference
                 << " m, " << body.counts().events << " events; other motions " << body.strayed() << '\n';
      // Asked for is 1e-8 m. Steps keep 1e-12; events are passed kSlack = 4e-12 m late, some hundred of them.
      EXPECT_LT(difference, kHeld) << freight << ", " << d0;
      EXPECT_LT(difference, 1e-10) << freight << ", " << d0;
      EXPECT_LT(body.strayed(), 1e-12);
      EXPECT_GT(body.counts().events, 10);
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------

DirectionParameters With(DirectionParameters parameters, const Effect& effect, double d0) {
  const Scales scales{
      .swing = std::abs(d0),
      .speed = std::abs(d0) * std::sqrt(kThesisGravity * (parameters.k + parameters.SumOfSliderStiffness()))};
  const std::vector<double> law = MakeEffectValues(effect, 1, scales);
  EffectValues values{.id = std::string(effect.id), .parameters = {}};
  for (std::size_t i = 0; i < law.size(); ++i) {
    const EffectParameter& p = effect.parameters[i];
    const double value = p.coordinate == Coordinate::kInverseSquare ? 1 / std::sqrt(law[i]) : law[i];
    values.parameters.emplace_back(p.symbol, std::clamp(value, p.low, p.high));
  }
  parameters.effects.push_back(values);
  return parameters;
}

std::vector<const Effect*> EffectsOfTheWagon() {
  std::vector<const Effect*> effects;
  for (const Effect* effect : Effects()) {
    DirectionParameters parameters;
    parameters.effects.push_back({.id = std::string(effect->id), .parameters = {}});
    if (EffectsLeftOut(parameters).empty()) effects.push_back(effect);
  }
  return effects;
}

/// Effects that tell +d from -d. In yaw the left links go forward while the right ones go back, so that together they
/// do not: the longitudinal sets are tried with these effects in sway, as lateral links.
bool TellsSidesApart(const Effect& effect) {
  return effect.id == "quadratic_stiffness" || effect.id == "asymmetric_friction" || effect.id == "end_stop";
}

/// What the slider that rolling friction is on the wagon may be ahead of its sign on the bench [m] (link.h): at each
/// reversal with the acceleration a the excess makes the mass faster by (8/3) g T_r sqrt(kRollingSlip/a); it is ahead
/// by that over the lowest frequency, and in the end held by 2 kRollingSlip to either side.
double CalcRollingPush(const ExtendedTrajectory<double>& run, double g, double k, double T_r) {
  double sum = 4 * Link::kRollingSlip;
  constexpr double kLook = 1e-3;  // [s], in which reversals are looked for
  for (double t = kLook; t + kLook < kSeconds; t += kLook) {
    if (!(run.v(t) * run.v(t + kLook) < 0)) continue;
    const double a = std::abs(run.v(t + kLook) - run.v(t)) / kLook;
    sum += 8.0 / 3 * g * T_r * std::sqrt(Link::kRollingSlip / a) / std::sqrt(g * k);
  }
  return sum;
}

TEST_P(BenchInWagon, SwingsAsTheExtendedSolverSays) {
  const double d0 = 25.3e-3;
  double worst = 0;
  for (const Effect* effect : EffectsOfTheWagon()) {
    const DirectionParameters parameters = With(Parameters(), *effect, d0);
    BodyOnLinks body(TellsSidesApart(*effect) ? Direction::kLateral : GetParam().direction, parameters);
    const std::vector<double> swing = body.Swing(d0);
    ExtendedTrajectory<double> run;
    // The law of the link, which differs from the bench's in the friction of rolling alone.
    const double difference = MaxDifference(swing, SolveExtended(body.link().law(), d0, &run));
    worst = std::max(worst, difference);
    EXPECT_LT(difference, kHeld) << effect->id;
    EXPECT_LT(difference, 1e-9) << effect->id;  // two integrators, each good to some 2e-10 m in 15 s
    EXPECT_LT(body.strayed(), 1e-12) << effect->id;
    if (effect->id != "rolling_friction") continue;

    const double bench =
        MaxDifference(swing, SolveExtended(MakeExtendedOscillator<double>(parameters, body.wagon().g), d0, &run));
    const double push = CalcRollingPush(run, body.wagon().g, parameters.k, parameters.effects[0].parameters[0].second);
    Measured() << NameOf(GetParam()) << ", rolling friction: |dd| <= " << bench << " m, kRollingSlip explains " << push
               << " m\n";
    EXPECT_LT(bench, push);
  }
  Measured() << NameOf(GetParam()) << ", " << EffectsOfTheWagon().size() << " effects: |dd| <= " << worst << " m\n";
}

INSTANTIATE_TEST_SUITE_P(Sets, BenchInWagon,
                         testing::Values(Choice{"set1", Direction::kLateral}, Choice{"set2", Direction::kLateral},
                                         Choice{"set1", Direction::kLongitudinal},
                                         Choice{"set2", Direction::kLongitudinal}),
                         [](const auto& test) { return NameOf(test.param); });

}  // namespace
}  // namespace uiclink
