#include "measurements/rig/dynamics.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace uiclink::rig {
namespace {

double Square(double x) { return x * x; }

/// Force of one dip in the potential -width exp((1 - u^2)/2), largest (1) at u = +-1.
double Bump(double u) { return u * std::exp(0.5 - 0.5 * u * u); }

/// Velocity after dt under the constant acceleration a and the dry friction F (both [m/s^2]): slows down to zero, then
/// stays or turns round with what friction leaves of a.
double KickWithDryFriction(double v, double a, double F, double dt) {
  if (F == 0) return v + a * dt;
  if (v != 0) {
    const double slowed = a - std::copysign(F, v);
    const double v_end = v + slowed * dt;
    if (v_end * v > 0) return v_end;
    dt -= -v / slowed;  // v reaches 0 within dt, so slowed is against v and not zero
  }
  return std::abs(a) <= F ? 0.0 : (a - std::copysign(F, a)) * dt;
}

}  // namespace

Oscillator::Oscillator(const Link& link) : link_(link) {
  const EffectSizes& e = link_.effects;
  if (e.extra_k > 0) link_.joints.push_back({.k = e.extra_k, .T0 = e.extra_T0});
  double k_sum = link_.k;
  for (const Joint& joint : link_.joints) k_sum += joint.k;
  w_push_ = std::sqrt(link_.g * k_sum);
  state_.joints.resize(link_.joints.size());
  if (e.micro_k > 0) state_.micro.resize(static_cast<std::size_t>(e.micro_count));
}

void Oscillator::StartAtRest() {
  double T_start = 0;
  for (const Joint& joint : link_.joints) T_start += joint.T_start;
  double y = 0;
  for (int i = 0; i < 50 && T_start != 0; ++i) {  // Newton; the slope is that of the nearly linear pendulum
    y += (PositionForce(y) + T_start) / link_.k;
  }
  rest_y_ = y;
  state_.y = y;
  state_.v = 0;
  for (std::size_t i = 0; i < link_.joints.size(); ++i) {
    const Joint& joint = link_.joints[i];
    const double slack = joint.T_start == 0 ? 0 : std::copysign(link_.effects.clearance_gap, joint.T_start);
    state_.joints[i].p = y + joint.T_start / joint.k + slack;
  }
  std::fill(state_.micro.begin(), state_.micro.end(), y);
  FollowJoints(0, 0);
  FollowMicroSlip();
}

void Oscillator::StartAtExtremum(double y) {
  const double side = y < 0 ? -1 : 1;
  const EffectSizes& e = link_.effects;
  state_.y = y;
  state_.v = 0;
  for (std::size_t i = 0; i < link_.joints.size(); ++i) {
    const Joint& joint = link_.joints[i];
    const double T = FrictionLimit(joint, side) * (1 + e.stribeck_s);
    state_.joints[i].p = y - side * (T / joint.k + e.clearance_gap);
  }
  std::fill(state_.micro.begin(), state_.micro.end(), 0.0);
  FollowJoints(0, 0);
  FollowMicroSlip();
  state_.loss = 0;
}

void Oscillator::SetPush(double P, double sign) {
  push_ = P;
  push_sign_ = sign;
}

double Oscillator::Stiffness(double t) const {
  const EffectSizes& e = link_.effects;
  if (e.modulation_a == 0) return link_.k;
  return link_.k * (1 + e.modulation_a * std::sin(2 * std::numbers::pi * e.modulation_f * t + e.modulation_phase));
}

double Oscillator::PositionForce(double y) const {
  const EffectSizes& e = link_.effects;
  const double k = Stiffness(state_.t);
  double force = std::isinf(e.pendulum_l) ? -k * y : -k * e.pendulum_l * std::sin(y / e.pendulum_l);
  force -= (e.quadratic_k2 + e.cubic_k3 * y) * y * y;
  const double beyond = y - e.stop_position;
  if (e.stop_k > 0 && beyond * e.stop_position > 0) force -= e.stop_k * beyond;
  if (e.bump_height != 0) {
    force -= e.bump_height * (Bump((y - e.bump_centre) / e.bump_width) + Bump((y + e.bump_centre) / e.bump_width));
  }
  return force;
}

double Oscillator::PendulumEnergy(double y, double k) const {
  const double l = link_.effects.pendulum_l;
  return std::isinf(l) ? 0.5 * k * y * y : 2 * k * Square(l * std::sin(0.5 * y / l));
}

double Oscillator::PotentialEnergy(double y) const {
  const EffectSizes& e = link_.effects;
  double energy = PendulumEnergy(y, Stiffness(state_.t));
  const double u_right = (y - e.bump_centre) / e.bump_width, u_left = (y + e.bump_centre) / e.bump_width;
  energy -=
      e.bump_height * e.bump_width * (std::exp(0.5 - 0.5 * Square(u_right)) + std::exp(0.5 - 0.5 * Square(u_left)));
  energy += (e.quadratic_k2 / 3 + e.cubic_k3 * y / 4) * y * y * y;
  const double beyond = y - e.stop_position;
  if (e.stop_k > 0 && beyond * e.stop_position > 0) energy += 0.5 * e.stop_k * Square(beyond);
  return energy;
}

double Oscillator::VelocityForce(double v) const {
  return -(link_.effects.viscous_c + link_.effects.drag_d * std::abs(v)) * v;
}

double Oscillator::PushForce(double v) const {
  if (push_ == 0) return 0;
  const double phase_radius = std::sqrt(Square(v) + Square(w_push_ * (state_.y - rest_y_)));
  return phase_radius == 0 ? push_ * push_sign_ : push_ * v / phase_radius;
}

double Oscillator::SlackFree(double z) const {
  const double gap = link_.effects.clearance_gap;
  return z - std::clamp(z, -gap, gap);
}

/// Force at which the joint slides towards `side`, before any influence of speed: drift and asymmetry.
double Oscillator::FrictionLimit(const Joint& joint, double side) const {
  const EffectSizes& e = link_.effects;
  return joint.T0 * std::max(0.0, 1 + e.friction_rate * state_.t) * (1 + side * e.asymmetry_a);
}

/// Return map of the joints at the new displacement; v_half is the mass's speed in the step, `speed` its size at the
/// end of the step, or 0 when it turned round within: there a limit that grows with the speed has been lowest, and the
/// slider has followed it. Leaves the sum of their forces and the dry friction that goes with their state.
void Oscillator::FollowJoints(double v_half, double speed) {
  const EffectSizes& e = link_.effects;
  const double growth = e.strengthening_b * speed;
  const double peak_static = 1 + e.stribeck_s + growth;
  const double peak_sliding =
      1 + (e.stribeck_s == 0 ? 0 : e.stribeck_s * std::exp(-Square(v_half / e.stribeck_v_s))) + growth;
  bool all_slide = !link_.joints.empty();
  state_.T_sum = 0;
  for (std::size_t i = 0; i < link_.joints.size(); ++i) {
    const Joint& joint = link_.joints[i];
    State::Slider& now = state_.joints[i];
    const double spring = joint.k * SlackFree(state_.y - now.p);
    const double side = spring < 0 ? -1 : 1;
    const double T0 = FrictionLimit(joint, side);
    double held = std::abs(spring);
    if (held > T0 * (now.sliding ? peak_sliding : peak_static)) {
      const double limit = T0 * peak_sliding;
      const double dp = (held - limit) / joint.k;
      // Breaking out through a static peak, the spring relaxes from the peak to the limit while p jumps.
      const double mean_force = now.sliding ? limit : 0.5 * (limit + std::max(limit, T0 * peak_static));
      state_.loss += mean_force * dp;
      now.p += side * dp;
      now.sliding = true;
      held = limit;
    } else {
      now.sliding = false;
      all_slide = false;
    }
    state_.T_sum -= side * held;
  }
  state_.friction = e.rolling_T_r * (all_slide ? e.rolling_sliding_share : 1);
}

void Oscillator::FollowMicroSlip() {
  if (state_.micro.empty()) return;
  const double n = static_cast<double>(state_.micro.size());
  const double k = link_.effects.micro_k / n;
  const double width = link_.effects.micro_y_max / n;
  double stretch = 0, slipped = 0;
  double limit = -0.5 * width;
  for (double& p : state_.micro) {
    limit += width;
    const double z = state_.y - p;
    const double held = std::clamp(z, -limit, limit);
    slipped += limit * std::abs(z - held);
    p = state_.y - held;
    stretch += held;
  }
  state_.T_sum -= k * stretch;
  state_.loss += k * slipped;
}

/// Exact for a displacement that grows by dy at a constant rate within the step of length h.
void Oscillator::FollowMaxwell(double dy, double h) {
  const EffectSizes& e = link_.effects;
  if (e.maxwell_k == 0) return;
  const double before = state_.maxwell_T;
  const double relaxed = -std::expm1(-h / e.maxwell_tau);
  state_.maxwell_T += -before * relaxed - e.maxwell_k * dy * relaxed * e.maxwell_tau / h;
  const double mean_square = (Square(before) + before * state_.maxwell_T + Square(state_.maxwell_T)) / 3;
  state_.loss += mean_square * h / (e.maxwell_k * e.maxwell_tau);  // the dashpot's force times its speed
  state_.T_sum += state_.maxwell_T;
}

void Oscillator::Step(double h) {
  const double g = link_.g;
  const double v0 = state_.v;
  const double a0 = g * (PositionForce(state_.y) + state_.T_sum + VelocityForce(v0) + PushForce(v0));
  const double v_half = KickWithDryFriction(v0, a0, g * state_.friction, 0.5 * h);
  state_.loss += (state_.friction * std::abs(v_half) - VelocityForce(v_half) * v_half) * h;
  if (link_.effects.modulation_a != 0) {
    const double y_middle = state_.y + 0.5 * h * v_half;  // the spring changes under the mass: what it takes is lost
    state_.loss += PendulumEnergy(y_middle, Stiffness(state_.t)) - PendulumEnergy(y_middle, Stiffness(state_.t + h));
  }
  state_.t += h;
  state_.y += h * v_half;
  const double v_end = v_half + (v_half - v0);  // velocity-dependent forces at a second-order guess of the end
  FollowJoints(v_half, v0 * v_end > 0 ? std::abs(v_end) : 0);
  FollowMicroSlip();
  FollowMaxwell(h * v_half, h);
  const double a1 = g * (PositionForce(state_.y) + state_.T_sum + VelocityForce(v_end) + PushForce(v_end));
  state_.v = KickWithDryFriction(v_half, a1, g * state_.friction, 0.5 * h);
}

double Oscillator::Energy() const {
  double energy = 0.5 * Square(state_.v) / link_.g + PotentialEnergy(state_.y);
  if (link_.effects.maxwell_k > 0) energy += 0.5 * Square(state_.maxwell_T) / link_.effects.maxwell_k;
  for (std::size_t i = 0; i < link_.joints.size(); ++i) {
    energy += 0.5 * link_.joints[i].k * Square(SlackFree(state_.y - state_.joints[i].p));
  }
  const double k_micro = state_.micro.empty() ? 0 : link_.effects.micro_k / static_cast<double>(state_.micro.size());
  for (const double p : state_.micro) energy += 0.5 * k_micro * Square(state_.y - p);
  return energy;
}

namespace {

/// One record in progress: pushes until the release, then watches for the first free extremum.
class RingDown {
 public:
  RingDown(const Link& link, const PushPlan& plan)
      : plan_(plan), oscillator_(link), tangent_(std::tan(2 * std::numbers::pi * plan.release_before_extremum)) {
    oscillator_.StartAtRest();
    rest_y_ = oscillator_.y();
    oscillator_.SetTime(plan.start_s);
    const double first_push = plan.half_swings % 2 == 1 ? plan.side : -plan.side;
    oscillator_.SetPush(plan.strength, first_push);
    direction_ = first_push;
  }

  void Step(double h) {
    if (released_s_) {
      StepFree(h);
    } else {
      StepPushed(h);
    }
  }

  double y() const { return oscillator_.y(); }
  double rest_y() const { return rest_y_; }
  std::optional<double> released_s() const { return released_s_; }
  const std::optional<FreeDecay::Extremum>& first_extremum() const { return first_extremum_; }

 private:
  /// The hand lets go where the phase angle atan(|v| / (w |y|)) to the coming extremum has shrunk to its share.
  bool ReleaseIsDue() const {
    const double y = oscillator_.y() - rest_y_;
    const double v = oscillator_.v();
    return y * v > 0 && std::abs(v) <= tangent_ * oscillator_.ResonanceFrequency() * std::abs(y);
  }

  void StepPushed(double h) {
    const bool last_swing = reversals_ == plan_.half_swings - 1;
    if (!last_swing) {
      oscillator_.Step(h);
      CountReversal();
      return;
    }
    before_ = oscillator_.state();
    oscillator_.Step(h);
    if (!ReleaseIsDue()) return;
    // The moment of release is located within the step: snapped to the grid it would shift the whole record by up to
    // h |v|, a hundred times the error of the steps themselves.
    double early = 0, late = h;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (early + late);
      oscillator_.Restore(before_);
      oscillator_.Step(middle);
      (ReleaseIsDue() ? late : early) = middle;
    }
    oscillator_.Restore(before_);
    oscillator_.Step(late);
    released_s_ = oscillator_.t();
    oscillator_.SetPush(0, 1);
    StepFree(h - late);
  }

  void StepFree(double h) {
    if (first_extremum_) {
      oscillator_.Step(h);
      return;
    }
    const double t0 = oscillator_.t(), y0 = oscillator_.y(), v0 = oscillator_.v();
    oscillator_.Step(h);
    const double v1 = oscillator_.v();
    if (v0 * v1 > 0 || v0 == v1) return;
    const double to_extremum = h * v0 / (v0 - v1);
    first_extremum_ = {.t = t0 + to_extremum, .y = y0 + 0.5 * v0 * to_extremum};
  }

  void CountReversal() {
    if (oscillator_.v() * direction_ >= 0) return;
    direction_ = -direction_;
    ++reversals_;
  }

  PushPlan plan_;
  Oscillator oscillator_;
  Oscillator::State before_;
  double tangent_;
  double rest_y_ = 0;
  double direction_ = 1;
  int reversals_ = 0;
  std::optional<double> released_s_;
  std::optional<FreeDecay::Extremum> first_extremum_;
};

/// Size of the first free extremum, measured from the link's zero on the plan's side [m]; 0 when there is none by
/// `end_s`, not a number when the push drove a softening link over the top of its potential.
double FirstExtremumSize(const Link& link, const PushPlan& plan, double step, double end_s) {
  RingDown run(link, plan);
  const auto steps = static_cast<long>((end_s - plan.start_s) / step);
  constexpr double kFarAway = 1;  // [m]
  for (long i = 0; i < steps && !run.first_extremum(); ++i) {
    run.Step(step);
    if (!(std::abs(run.y()) < kFarAway)) return std::numeric_limits<double>::quiet_NaN();
  }
  return run.first_extremum() ? plan.side * run.first_extremum()->y : 0.0;
}

/// Strength of the push that makes the first free extremum `target`: false position with the Illinois weights, so the
/// root stays bracketed.
double TunePush(const Link& link, PushPlan plan, double target, double step, double end_s) {
  const auto miss = [&](double strength) {
    plan.strength = strength;
    return FirstExtremumSize(link, plan, step, end_s) - target;
  };
  double low = 0, f_low = -target;
  double high = 0.03, f_high = miss(high);
  double too_much = kNever;
  while (!(f_high >= 0)) {
    if (high > 1e3 || too_much - low < 1e-6 * too_much) {
      throw std::invalid_argument(fmt::format(
          "push: expected a push that reaches first_extremum_mm = {:.4g}, found none up to {:.0f} times the load",
          1e3 * target, high));
    }
    if (std::isnan(f_high)) {
      too_much = high;
    } else {
      low = high, f_low = f_high;
    }
    high = std::isinf(too_much) ? 2 * high : 0.5 * (low + too_much);
    f_high = miss(high);
  }
  int kept = 0;  // which end was kept last: +1 high, -1 low
  for (int i = 0; i < 60; ++i) {
    const double trial = (low * f_high - high * f_low) / (f_high - f_low);
    const double f = miss(trial);
    if (std::abs(f) < 1e-9) return trial;  // 1e-6 mm
    if (f < 0) {
      low = trial, f_low = f;
      if (kept == 1) f_high *= 0.5;
      kept = 1;
    } else {
      high = trial, f_high = f;
      if (kept == -1) f_low *= 0.5;
      kept = -1;
    }
  }
  return high;
}

}  // namespace

Motion RunRecord(const Settings& settings, const Link& link, double side, double target) {
  const double sample_s = 1 / settings.sensor.sampling_hz;
  const double step = sample_s / settings.steps_per_sample;
  const long samples = std::lround(settings.duration_s * settings.sensor.sampling_hz) + 1;
  const long rest_samples = std::lround(settings.push.rest_s * settings.sensor.sampling_hz);
  PushPlan plan{.start_s = static_cast<double>(rest_samples) * sample_s,
                .strength = 0,
                .half_swings = settings.push.half_swings,
                .release_before_extremum = settings.push.release_before_extremum,
                .side = side};
  plan.strength = TunePush(link, plan, target, step, settings.duration_s);

  RingDown run(link, plan);
  Motion motion;
  motion.y.assign(static_cast<std::size_t>(rest_samples) + 1, run.rest_y());
  motion.y.reserve(static_cast<std::size_t>(samples));
  for (long i = rest_samples + 1; i < samples; ++i) {
    for (int j = 0; j < settings.steps_per_sample; ++j) run.Step(step);
    motion.y.push_back(run.y());
  }
  motion.rest_y = run.rest_y();
  motion.push_amplitude = plan.strength;
  motion.push_start_s = plan.start_s;
  motion.release_s = run.released_s().value();
  motion.first_extremum_s = run.first_extremum().value().t;
  motion.first_extremum = run.first_extremum()->y;
  return motion;
}

FreeDecay ReleaseFromExtremum(const Link& link, double y0, double duration_s, double step_s) {
  Oscillator oscillator(link);
  oscillator.StartAtExtremum(y0);
  FreeDecay decay;
  const auto keep = [&] {
    decay.t.push_back(oscillator.t());
    decay.y.push_back(oscillator.y());
    decay.energy.push_back(oscillator.Energy());
    decay.loss.push_back(oscillator.Loss());
  };
  keep();
  const long steps = std::lround(duration_s / step_s);
  for (long i = 0; i < steps; ++i) {
    const double t = oscillator.t(), y = oscillator.y(), v = oscillator.v();
    oscillator.Step(step_s);
    if (v * oscillator.v() < 0) {
      const double to_extremum = step_s * v / (v - oscillator.v());
      decay.extrema.push_back({.t = t + to_extremum, .y = y + 0.5 * v * to_extremum});
    }
    keep();
  }
  return decay;
}

}  // namespace uiclink::rig
