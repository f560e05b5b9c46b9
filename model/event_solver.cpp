#include "model/event_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uiclink {
namespace {

/// A slider within this share of T0i + k_i |y| of its limit is at its limit: T_i is a sum of terms of that size, so
/// this is a few roundings of T_i.
constexpr double kAtLimit = 1e-14;
/// A motion that overshoots no limit by more than this share (of the same sum) rolls for ever.  Later slips would
/// shrink from there geometrically, so what is left out is of the same size: 1e-13 of T0i / k_i + |y|, 1e-15 m.
constexpr double kLocked = 1e-13;

/// The state between two events, and the steps that lead to the next one.  One object lives for one run.
template <typename Scalar>
class Walk {
 public:
  Walk(const Oscillator<Scalar>& oscillator, const State<Scalar>& start)
      : oscillator_(oscillator), n_(oscillator.sliders().size()), state_(start) {
    for (std::size_t i = 0; i < n_; ++i) {
      stuck_stiffness_[i] = Value(slider(i).k);
      if (Value(slider(i).T0) == 0) powerless_ |= 1u << i;
    }
    travel_ = TravelOfStart();
    StartSliding();
  }

  /// The motion that starts in the present state and mode.
  Arc<Scalar> MakeArc(double t) const {
    using std::sqrt;
    Scalar stiffness = oscillator_.k;
    Scalar force{};  // of all sliders, as if they were springs about y = 0
    for (std::size_t i = 0; i < n_; ++i) {
      force += state_.T[i];
      if (!Slides(i)) {
        stiffness += slider(i).k;
        force += slider(i).k * state_.y;
      }
    }
    Arc<Scalar> arc;
    arc.t_start = t;
    arc.w = sqrt(oscillator_.g * stiffness);
    arc.c = force / stiffness;
    arc.a = state_.y - arc.c;
    arc.b = state_.v / arc.w;
    arc.sliding = sliding_;
    return arc;
  }

  /// True when the arc, all sliders sticking, never reaches a limit.
  bool RollsForEver(const Arc<Scalar>& arc) const {
    if ((sliding_ & ~powerless_) != 0) return false;
    const double c = Value(arc.c);
    const double radius = std::hypot(Value(arc.a), Value(arc.b));
    for (std::size_t i = 0; i < n_; ++i) {
      if (Slides(i)) continue;
      const double centre = Value(state_.T[i]) - stuck_stiffness_[i] * (c - Value(state_.y));
      const double T0 = Value(slider(i).T0);
      const double swing = stuck_stiffness_[i] * radius;
      if (std::abs(centre) + swing > T0 + kLocked * (T0 + swing + stuck_stiffness_[i] * std::abs(c))) return false;
    }
    return true;
  }

  /// Moves to the event that ends the arc and returns how long the arc lasts [s].
  double Advance(const Arc<Scalar>& arc, EventKind* kind) {
    // In the direction of travel: z is the distance past the centre, p the velocity over w; z^2 + p^2 stays.
    const double z = travel_ * Value(arc.a);
    const double p = std::max(0.0, travel_ * Value(arc.b));
    const double radius = std::hypot(z, p);
    const double to_turning = z > 0 ? p * p / (radius + z) : radius - z;
    const double to_breakout = DistanceToBreakout();

    double phase = 0, y_event = 0, v_event = 0;
    if (to_breakout < to_turning) {
      *kind = EventKind::kBreakout;
      const double z_event = z + to_breakout;
      const double p_event = std::sqrt(std::max(0.0, p * p - to_breakout * (z + z_event)));
      // The angle from (z, p) to (z_event, p_event); exact near both turning points, where acos is not.
      phase = std::max(0.0, std::atan2(p * z_event - z * p_event, z * z_event + p * p_event));
      y_event = Value(state_.y) + travel_ * to_breakout;
      v_event = travel_ * Value(arc.w) * p_event;
    } else {
      *kind = EventKind::kTurning;
      phase = std::max(0.0, std::atan2(p, z));
      y_event = Value(arc.c) + travel_ * radius;
    }
    const double duration = phase / Value(arc.w);
    MoveState(arc, duration, y_event, v_event);
    if (*kind == EventKind::kTurning) Reverse();
    StartSliding();
    return duration;
  }

  const State<Scalar>& state() const { return state_; }

 private:
  const Slider<Scalar>& slider(std::size_t i) const { return oscillator_.sliders()[i]; }
  bool Slides(std::size_t i) const { return (sliding_ >> i) & 1u; }

  /// +1 or -1: the direction in which the mass moves, or will move when it is at rest.
  double TravelOfStart() const {
    if (Value(state_.v) != 0) return Value(state_.v) > 0 ? 1 : -1;
    double acceleration = -Value(oscillator_.k) * Value(state_.y);
    for (std::size_t i = 0; i < n_; ++i) acceleration += Value(state_.T[i]);
    return acceleration < 0 ? -1 : 1;
  }

  /// How far the mass can move in its direction before the first sticking slider reaches its limit [m].
  double DistanceToBreakout() const {
    double distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < n_; ++i) {
      if (Slides(i) || stuck_stiffness_[i] == 0) continue;
      const double reserve = Value(slider(i).T0) + travel_ * Value(state_.T[i]);
      distance = std::min(distance, std::max(0.0, reserve) / stuck_stiffness_[i]);
    }
    return distance;
  }

  /// Every sticking slider whose force is at the limit against the motion slides from here on.
  void StartSliding() {
    for (std::size_t i = 0; i < n_; ++i) {
      if (Slides(i)) continue;
      const double T0 = Value(slider(i).T0);
      const double reserve = T0 + travel_ * Value(state_.T[i]);
      if (reserve > kAtLimit * (T0 + stuck_stiffness_[i] * std::abs(Value(state_.y)))) continue;
      if (stuck_stiffness_[i] == 0) continue;  // a slider without its spring keeps its force
      state_.T[i] = -travel_ * slider(i).T0;
      sliding_ |= 1u << i;
    }
  }

  void Reverse() {
    sliding_ = 0;
    travel_ = -travel_;
  }

  /// State after `duration` on the arc.  Values are set to those of the event, which are known better than cos and sin
  /// of the phase give them; derivatives are those at fixed time (EVENTS.md).
  void MoveState(const Arc<Scalar>& arc, double duration, double y_event, double v_event) {
    using std::cos;
    using std::sin;
    const Scalar phase = arc.w * duration;
    const Scalar cosine = cos(phase);
    const Scalar sine = sin(phase);
    Scalar y = arc.c + arc.a * cosine + arc.b * sine;
    SetValue(y, y_event);
    for (std::size_t i = 0; i < n_; ++i) {
      if (Slides(i)) continue;
      state_.T[i] -= slider(i).k * (y - state_.y);
      const double T0 = Value(slider(i).T0);
      SetValue(state_.T[i], std::clamp(Value(state_.T[i]), -T0, T0));
    }
    state_.y = y;
    state_.v = arc.w * (arc.b * cosine - arc.a * sine);
    SetValue(state_.v, v_event);
  }

  const Oscillator<Scalar>& oscillator_;
  std::size_t n_;
  State<Scalar> state_;
  std::array<double, kMaxSliders> stuck_stiffness_{};
  Mode sliding_ = 0;
  Mode powerless_ = 0;  // sliders with T0i = 0: they slide whenever the mass moves and never hold it
  double travel_ = 1;
};

template <typename Scalar>
bool IsAdmissible(const Oscillator<Scalar>& o, const State<Scalar>& s) {
  if (!(Value(o.k) > 0 && std::isfinite(Value(o.k)) && o.g > 0)) return false;
  if (!std::isfinite(Value(s.y)) || !std::isfinite(Value(s.v))) return false;
  for (std::size_t i = 0; i < o.sliders().size(); ++i) {
    const double k = Value(o.sliders()[i].k);
    const double T0 = Value(o.sliders()[i].T0);
    if (!(k >= 0 && std::isfinite(k) && T0 >= 0 && std::isfinite(T0))) return false;
    if (!(std::abs(Value(s.T[i])) <= T0 * (1 + kLocked))) return false;
  }
  return true;
}

}  // namespace

template <typename Scalar>
SolveStatus Solve(const Oscillator<Scalar>& oscillator, const State<Scalar>& start, double duration,
                  Trajectory<Scalar>* out, const SolveOptions& options) {
  const std::size_t n = oscillator.sliders().size();
  out->Clear(oscillator);
  if (!IsAdmissible(oscillator, start) || !(duration >= 0)) return SolveStatus::kNotFinite;
  Walk<Scalar> walk(oscillator, start);
  double t = 0;
  for (std::size_t events = 0; events <= options.max_events; ++events) {
    Arc<Scalar> arc = walk.MakeArc(t);
    arc.t_end = duration;
    const std::span<const Scalar> forces(walk.state().T.data(), n);
    if (walk.RollsForEver(arc)) {
      out->Append(arc, forces);
      return SolveStatus::kOk;
    }
    out->Append(arc, forces);
    EventKind kind = EventKind::kEnd;
    const double lasts = walk.Advance(arc, &kind);
    if (t + lasts >= duration) return SolveStatus::kOk;
    t += lasts;
    out->back().t_end = t;
    out->back().end = kind;
  }
  return SolveStatus::kTooManyEvents;
}

#define UICLINK_INSTANTIATE_SOLVE(Scalar)                                                                  \
  template SolveStatus Solve(const Oscillator<Scalar>&, const State<Scalar>&, double, Trajectory<Scalar>*, \
                             const SolveOptions&)
UICLINK_INSTANTIATE_SOLVE(double);
UICLINK_INSTANTIATE_SOLVE(Dual<4>);
UICLINK_INSTANTIATE_SOLVE(Dual<6>);
UICLINK_INSTANTIATE_SOLVE(Dual<8>);
UICLINK_INSTANTIATE_SOLVE(Dual<10>);
#undef UICLINK_INSTANTIATE_SOLVE

}  // namespace uiclink
