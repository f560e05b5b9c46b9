#include "vehicle/link.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "model/effect.h"
#include "model/extended_link.h"

namespace uiclink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Forces that are given may exceed their bound by this share of it: rounding of files and of sums.
constexpr double kAtBound = 1e-9;

/// Counts from the start of a record; on a wagon there is none.
constexpr std::string_view kDrift = "friction_drift";

bool IsLeftOut(const Effect& effect) { return !effect.IsMechanical() || effect.id == kDrift; }

DirectionParameters WithoutLeftOut(DirectionParameters parameters) {
  std::erase_if(parameters.effects, [](const EffectValues& values) {
    const Effect* effect = FindEffect(values.id);
    return effect != nullptr && IsLeftOut(*effect);
  });
  return parameters;
}

/// How far d is beyond a stop, > 0 in contact [m].
double Beyond(const Stop<double>& stop, double d) { return stop.position > 0 ? d - stop.position : stop.position - d; }

}  // namespace

std::vector<std::string> EffectsLeftOut(const DirectionParameters& parameters) {
  std::vector<std::string> left_out;
  for (const EffectValues& values : parameters.effects) {
    const Effect* effect = FindEffect(values.id);
    if (effect != nullptr && IsLeftOut(*effect)) left_out.push_back(values.id);
  }
  return left_out;
}

// --- Link ------------------------------------------------------------------------------------------------------------

Link::Link(const DirectionParameters& parameters, double g, double load) : load_(load) {
  if (!(load > 0 && std::isfinite(load))) throw std::invalid_argument("Link: load must be positive");
  const DirectionParameters kept = WithoutLeftOut(parameters);
  law_ = MakeExtendedOscillator<double>(kept, g);
  forces_dual_ = MakeExtendedOscillator<Dual<6>>(kept, g).forces;
  rolling_slider_ = law_.sliders.size();
  if (law_.rolling > 0) {
    if (law_.sliders.size() == kMaxExtendedSliders)
      throw std::invalid_argument("Link: no room for rolling friction beside the sliders");
    law_.sliders.Add({.k = law_.rolling / kRollingSlip, .y_c = kRollingSlip, .joint = false});
  }
  law_.rolling = 0;
  law_.has_rolling = false;
  for (const SpeedTerm<double>& term : law_.speed_terms.items()) sticking_share_ += term.sticking(term.p);
  is_affine_ = law_.forces.empty() && law_.speed_terms.empty();
  needs_acceleration_ = law_.has_strengthening || !law_.speed_terms.empty();
}

double Link::CalcSlidingLimit(std::size_t joint, double side, double v) const {
  const ExtendedSlider<double>& slider = sliders()[joint];
  if (!slider.joint) return slider.y_c;
  double share = 1 + law_.strengthening * (side * v);
  for (const SpeedTerm<double>& term : law_.speed_terms.items()) share += term.sliding(term.p, side * v);
  return slider.y_c * ((1 + side * law_.asymmetry) * share);
}

double Link::CalcBreakoutLimit(std::size_t joint, double side, double v) const {
  const ExtendedSlider<double>& slider = sliders()[joint];
  if (!slider.joint) return slider.y_c;
  const double share = 1 + law_.strengthening * std::max(0.0, side * v) + sticking_share_;
  return slider.y_c * ((1 + side * law_.asymmetry) * share);
}

double Link::CalcLimitSlope(std::size_t joint, double side, double v) const {
  const ExtendedSlider<double>& slider = sliders()[joint];
  if (!slider.joint) return 0;
  double slope = law_.strengthening;
  for (const SpeedTerm<double>& term : law_.speed_terms.items()) slope += term.slope(term.p, side * v);
  return slider.y_c * ((1 + side * law_.asymmetry) * slope);
}

double Link::CalcSlidingForce(std::size_t joint, double side, double v) const {
  return sliders()[joint].k * CalcSlidingLimit(joint, side, v);
}

double Link::CalcBreakoutForce(std::size_t joint, double side, double v) const {
  return sliders()[joint].k * CalcBreakoutLimit(joint, side, v);
}

// --- LinkState: where it starts --------------------------------------------------------------------------------------

LinkState LinkState::AtRest(const Link& link, double d) {
  LinkState state;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) state.joints[i].p = d;
  const auto stops = link.law_.stops.items();
  for (std::size_t i = 0; i < stops.size(); ++i) state.touches[i] = Beyond(stops[i], d) > 0;
  state.Load(link);
  return state;
}

LinkState LinkState::WithForces(const Link& link, double d, double v, std::span<const double> T) {
  if (T.size() != link.sliders().size()) throw std::invalid_argument("LinkState: one force per slider is needed");
  LinkState state = AtRest(link, d);
  for (std::size_t i = 0; i < T.size(); ++i) {
    Joint& joint = state.joints[i];
    if (T[i] == 0 || state.IsAbsent(link, i)) continue;
    const double side = T[i] < 0 ? 1 : -1, S = std::abs(T[i]) / (link.load_ * link.sliders()[i].k);
    const double bound = link.CalcBreakoutLimit(i, side, v),
                 sliding = link.CalcSlidingLimit(i, side, std::max(0.0, side * v) * side);
    if (!(S <= bound * (1 + kAtBound)))
      throw std::invalid_argument("LinkState: the force of slider " + std::to_string(i + 1) + " exceeds its bound");
    if (side * v > kAtRest && S >= sliding * (1 - kAtBound) && S <= sliding * (1 + kAtBound)) {
      joint.slides = static_cast<std::int8_t>(side);
    }
    joint.engaged = static_cast<std::int8_t>(link.HasGap(i) ? side : 0);
    joint.p = d - side * (link.HasGap(i) ? S + link.law_.gap : S);
  }
  if (std::abs(v) > kAtRest) state.travel = v > 0 ? 1 : -1;
  state.Load(link);
  return state;
}

LinkState LinkState::WithJoints(const Link& link, double d, double v, std::span<const Joint> joints) {
  if (joints.size() != link.sliders().size()) throw std::invalid_argument("LinkState: one joint per slider is needed");
  LinkState state = AtRest(link, d);
  std::ranges::copy(joints, state.joints.begin());
  if (std::abs(v) > kAtRest) state.travel = v > 0 ? 1 : -1;
  state.Load(link);
  return state;
}

LinkState LinkState::In(const Link& link) const {
  LinkState state = *this;
  state.Load(link);
  return state;
}

LinkState LinkState::Rolling(const Link& link) {
  LinkState state = AtRest(link, 0);
  state.without_rolling_friction = true;
  state.Load(link);
  return state;
}

// --- LinkState: forces -----------------------------------------------------------------------------------------------

double LinkState::CalcOther(const Link& link, double d, double v) const {
  const Motion<double> motion{.t = 0, .y = d, .v = v};
  double force = 0, share = 0;
  for (const ForceTerm<double>& term : link.law_.forces.items()) force += term.force(term.p, motion);
  if (slip != 0)
    for (const SpeedTerm<double>& term : link.law_.speed_terms.items()) share += term.sliding(term.p, slides * v);
  return link.load_ * force - slip * share;
}

LinkState::Slopes LinkState::AddOther(const Link& link, double d, double v, Slopes sum) const {
  using T = Dual<6>;
  const Motion<T> motion{.t = T(0), .y = T(d, 0), .v = T(v, 1)};
  for (const ForceTerm<T>& term : link.forces_dual_.items()) {
    const T force = term.force(term.p, motion);
    sum.F += link.load_ * force.a;
    sum.F_d += link.load_ * force.v(0);
    sum.F_v += link.load_ * force.v(1);
  }
  if (slip == 0) return sum;
  for (const SpeedTerm<double>& term : link.law_.speed_terms.items()) {
    sum.F -= slip * term.sliding(term.p, slides * v);
    sum.F_v -= slip * slides * term.slope(term.p, slides * v);
  }
  return sum;
}

/// Where the spring of a joint that sticks, and is not loose, has no force [m].
double LinkState::CalcNeutral(const Link& link, std::size_t joint) const {
  const Joint& state = joints[joint];
  return link.HasGap(joint) ? state.p + state.engaged * link.law_.gap : state.p;
}

double LinkState::CalcJointForce(const Link& link, std::size_t joint, double d, double v) const {
  const Joint& state = joints[joint];
  if (IsAbsent(link, joint)) return 0;
  if (state.slides != 0) return -state.slides * link.load_ * link.CalcSlidingForce(joint, state.slides, v);
  return IsLoose(link, joint) ? 0 : -link.load_ * link.sliders()[joint].k * (d - CalcNeutral(link, joint));
}

double LinkState::CalcPosition(const Link& link, std::size_t joint, double d, double v) const {
  const Joint& state = joints[joint];
  if (state.slides != 0) return d - state.slides * link.CalcSlidingLimit(joint, state.slides, v);
  return IsLoose(link, joint) ? d : CalcNeutral(link, joint);
}

// --- LinkState: events -----------------------------------------------------------------------------------------------

/// Where something happens next to a joint that sticks.
LinkState::Range LinkState::FindThresholds(const Link& link, std::size_t joint, double v) const {
  const Joint& state = joints[joint];
  if (IsLoose(link, joint)) return {state.p - link.law_.gap, state.p + link.law_.gap};
  const double neutral = CalcNeutral(link, joint);
  return {.lower = state.engaged > 0 ? neutral : neutral - link.CalcBreakoutLimit(joint, -1, v),
          .upper = state.engaged < 0 ? neutral : neutral + link.CalcBreakoutLimit(joint, +1, v)};
}

/// Speed at which a joint slides in its direction, slides p' [m/s]: the limit is not only followed, it grows itself.
double LinkState::CalcSlidingRate(const Link& link, std::size_t joint, double v, double a) const {
  const double side = joints[joint].slides;
  return side * v - link.CalcLimitSlope(joint, side, v) * (side * a);
}

double LinkState::CalcMovingMargin(const Link& link, double d, double v, double a) const {
  double margin = kInfinity;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    if (IsAbsent(link, i) || !link.sliders()[i].joint) continue;
    if (joints[i].slides != 0) {
      margin = std::min(margin, kMarginTime * (CalcSlidingRate(link, i, v, a) + kAtRest));
    } else if (link.LimitMoves(i)) {
      const Range range = FindThresholds(link, i, v);
      if (travel >= 0) margin = std::min(margin, range.upper + kSlack - d);
      if (travel <= 0) margin = std::min(margin, d - (range.lower - kSlack));
    }
  }
  return margin;
}

/// A joint sticks with the force that it has while it slides at v.
void LinkState::Stick(const Link& link, std::size_t joint, double d, double v) {
  const double side = joints[joint].slides;
  const double speed = std::max(0.0, side * v);  // an event of reversal may be found a rounding late
  const double limit = link.CalcSlidingLimit(joint, side, side * speed);
  joints[joint] = {.p = d - side * (link.HasGap(joint) ? limit + link.law_.gap : limit),
                   .slides = 0,
                   .engaged = static_cast<std::int8_t>(link.HasGap(joint) ? side : 0)};
}

void LinkState::PassThreshold(const Link& link, std::size_t joint, double side, double d, double v) {
  Joint& state = joints[joint];
  if (IsLoose(link, joint)) {
    state.engaged = static_cast<std::int8_t>(side);
  } else if (link.HasGap(joint) && state.engaged != side) {
    state.engaged = 0;
  } else if (side * v > kAtRest) {
    state.slides = static_cast<std::int8_t>(side);
  } else {  // a slip without length: it sticks with its force on the limit
    const double limit = link.CalcBreakoutLimit(joint, side, v);
    state.p = d - side * (link.HasGap(joint) ? limit + link.law_.gap : limit);
  }
}

/// Brings the direction of travel up to date.
void LinkState::Follow(double v, double a) {
  if (travel == 0) {
    const double sense = std::abs(v) > kAtRest ? v : a;
    travel = static_cast<std::int8_t>((sense > 0) - (sense < 0));
  } else if (travel * v <= -0.5 * kAtRest) {
    travel = static_cast<std::int8_t>(-travel);
  }
}

bool LinkState::StopSliding(const Link& link, double d, double v, double a) {
  if (slides == 0) return false;
  const bool reverses = slides != travel;
  bool changed = false;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    if (joints[i].slides == 0) continue;
    const bool outrun =
        link.needs_acceleration_ && link.sliders()[i].joint && CalcSlidingRate(link, i, v, a) <= -0.5 * kAtRest;
    if (!reverses && !outrun) continue;
    Stick(link, i, d, v);
    changed = true;
  }
  return changed;
}

bool LinkState::PassThresholds(const Link& link, double d, double v) {
  bool changed = false;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    if (IsAbsent(link, i)) continue;
    // From one side of a clearance through it to the limit of the other takes three.
    for (int pass = 0; pass < 3 && joints[i].slides == 0; ++pass) {
      const Range range = FindThresholds(link, i, v);
      const bool above = d >= range.upper + 0.5 * kSlack, below = d <= range.lower - 0.5 * kSlack;
      if (!above && !below) break;
      PassThreshold(link, i, above ? 1 : -1, d, v);
      changed = true;
    }
  }
  return changed;
}

bool LinkState::PassStops(const Link& link, double d) {
  bool changed = false;
  const auto stops = link.law_.stops.items();
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const double beyond = touches[i] ? -Beyond(stops[i], d) : Beyond(stops[i], d);
    if (beyond < 0.5 * kSlack) continue;
    touches[i] = !touches[i];
    changed = true;
  }
  return changed;
}

bool LinkState::Switch(const Link& link, double d, double v, double a) {
  const std::int8_t travelled = travel;
  Follow(v, a);
  bool changed = StopSliding(link, d, v, a);
  changed |= PassThresholds(link, d, v);
  changed |= PassStops(link, d);
  if (changed || travel != travelled) Load(link);
  return changed;
}

/// Brings what follows from the joints and stops up to date.
void LinkState::Load(const Link& link) {
  const ExtendedOscillator<double>& law = link.law_;
  const double Q = link.load_;
  K = Q * law.k;
  c = Q * law.damping;
  C = 0;
  slip = 0;
  slides = 0;
  upper = kInfinity;
  lower = -kInfinity;
  const auto sliders = law.sliders.items();
  for (std::size_t i = 0; i < sliders.size(); ++i) {
    if (IsAbsent(link, i)) continue;
    if (joints[i].slides != 0) {
      slides = joints[i].slides;
      const double force = Q * sliders[i].k * sliders[i].y_c * (sliders[i].joint ? 1 + slides * law.asymmetry : 1);
      C -= slides * force;
      if (!sliders[i].joint) continue;
      c += force * law.strengthening;
      slip += slides * force;
      continue;
    }
    if (!IsLoose(link, i)) {
      K += Q * sliders[i].k;
      C += Q * sliders[i].k * CalcNeutral(link, i);
    }
    if (link.LimitMoves(i)) continue;
    const Range range = FindThresholds(link, i, 0);
    upper = std::min(upper, range.upper);
    lower = std::max(lower, range.lower);
  }
  LoadStops(link);
  upper = travel < 0 ? kInfinity : upper + kSlack;
  lower = travel > 0 ? -kInfinity : lower - kSlack;
}

void LinkState::LoadStops(const Link& link) {
  const auto stops = link.law_.stops.items();
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const Stop<double>& stop = stops[i];
    if (touches[i]) {
      K += link.load_ * stop.k;
      C += link.load_ * stop.k * stop.position;
    }
    if ((stop.position > 0) != touches[i]) {
      upper = std::min(upper, stop.position);
    } else {
      lower = std::max(lower, stop.position);
    }
  }
}

}  // namespace uiclink
