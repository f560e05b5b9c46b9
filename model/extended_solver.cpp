#include "model/extended_solver.h"

#include <algorithm>
#include <cmath>

#include "model/damped_swing.h"
#include "model/dormand_prince.h"
#include "model/dual_sum.h"
#include "model/extended_mode.h"
#include "model/find_zero.h"

namespace uiclink {
namespace {

/// Distances below this share of the start displacement are none: a few roundings of the terms that they are sums of.
constexpr double kTiny = 1e-13;
/// The rounding of a displacement, as a share of the start displacement: no event can be found closer.
constexpr double kRounding = 2e-16;
/// An event time is lifted only where its guard moves through zero at more than this rate [m/s]: slower is a graze, and
/// has no derivative.
constexpr double kGraze = 1e-7;
/// Beyond so many start displacements the mass has left over the hill of a negative stiffness, and runs away ever
/// faster in ever smaller steps: not finite.
constexpr double kEscape = 1000;

/// A number with the value 0 and the derivatives of x; for plain numbers 0.
double Infinitesimal(double /*x*/) { return 0; }
template <int N>
Dual<N> Infinitesimal(Dual<N> x) {
  x.a = 0;
  return x;
}

using dormand_prince::Step;

/// The values of a polynomial arc.
struct PolynomialArc {
  std::array<double, 6> q{};
  double length = 0;

  struct Point {
    double y = 0, v = 0, a = 0;
  };
  Point At(double s) const {
    const double u = s / length;
    const double y = q[0] + u * (q[1] + u * (q[2] + u * (q[3] + u * (q[4] + u * q[5]))));
    const double slope = q[1] + u * (2 * q[2] + u * (3 * q[3] + u * (4 * q[4] + u * 5 * q[5])));
    const double bend = 2 * q[2] + u * (6 * q[3] + u * (12 * q[4] + u * 20 * q[5]));
    return {.y = y, .v = slope / length, .a = bend / (length * length)};
  }
};

/// The state between two events, and the steps that lead to the next one.  One object lives for one run.
template <typename T>
class ExtendedWalk {
 public:
  using Next = typename ExtendedMode<T>::Next;

  ExtendedWalk(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
               const ExtendedSolveOptions& options, ExtendedTrajectory<T>* out)
      : o_(oscillator),
        clock_(clock),
        duration_(duration),
        options_(options),
        out_(*out),
        mode_(oscillator, y0, clock),
        y_(y0) {
    scale_ = std::abs(Value(y0));
    StartFromRest();
  }

  SolveStatus Run() {
    while (out_.CountEvents() <= options_.max_events) {
      if (held_) {
        AppendRest();
        return SolveStatus::kOk;
      }
      mode_.SettleAtLimits(t_, y_, v_, kTiny * scale_);
      const ModeForces<T> forces = mode_.CalcForces(t_);
      const bool closed_form = !options_.always_integrate && mode_.IsAffine(forces);
      const bool goes_on = closed_form ? WalkClosedForm(forces) : WalkNumerically(forces);
      if (failed_) return SolveStatus::kNotFinite;
      if (!goes_on) return SolveStatus::kOk;
      out_.CountEvent();
    }
    return SolveStatus::kTooManyEvents;
  }

 private:
  // --- Events --------------------------------------------------------------------------------------------------

  /// Moves the state by an infinitesimal time that carries the derivatives of an event's time.
  void Lift(const T& delta, double a) {
    t_ += delta;
    y_ += Value(v_) * delta;
    v_ += a * delta;
  }

  void TurnRound(const ModeForces<T>& forces) {
    SetValue(v_, 0.0);
    const double a = Value(mode_.CalcAcceleration(forces, t_, y_, v_));
    if (std::abs(a) > kGraze) Lift(Infinitesimal(T(-v_ / a)), a);
    v_ = T(0);
    mode_.StickAll(t_, y_);
    StartFromRest();
  }

  void StartFromRest() { held_ = !mode_.StartFromRest(t_, y_); }

  /// A breakout at which the force jumps: the derivative of its time counts.
  void LiftBreakout(const ModeForces<T>& forces, std::size_t i) {
    if (o_.speed_terms.empty() || !o_.sliders.items()[i].joint) return;
    const double a = Value(mode_.CalcAcceleration(forces, t_, y_, v_));
    const auto reserve = mode_.CalcBreakout(i, t_, y_, v_, a);
    if (std::abs(reserve.rate) < kGraze) return;
    Lift(Infinitesimal(T(-reserve.guard / reserve.rate)), a);
  }

  void AppendRest() {
    ExtendedArc<T> arc{.t_start = t_, .t_end = duration_};
    arc.q[0] = y_;
    arc.q[4] = T(1);  // any frequency
    out_.Append(arc);
  }

  // --- Closed form ---------------------------------------------------------------------------------------------

  ExtendedArc<T> MakeArc(const ModeForces<T>& forces) const {
    using std::sqrt;
    ExtendedArc<T> arc{.t_start = t_, .t_end = duration_};
    auto& q = arc.q;
    if (!mode_.damped() && !forces.slides) {
      q[0] = forces.C / forces.K;
      q[4] = sqrt(T(o_.g * forces.K));
      q[2] = y_ - q[0];
      q[3] = v_ / q[4];
      return arc;
    }
    T damping = forces.B, centre = forces.C;
    if (forces.slides) {
      const double d = mode_.direction();
      const T side = mode_.asymmetric() ? T(d + o_.asymmetry) : T(d);  // d (1 + d asymmetry)
      const T at_start = T(1) + o_.drift * (t_ + clock_);
      centre -= forces.S * (side * at_start);
      damping += forces.S * (o_.strengthening * (at_start * (d * side)));
      if (o_.has_drift) q[1] = -(forces.S * (side * o_.drift)) / forces.K;
    }
    q[0] = (centre - damping * q[1]) / forces.K;
    q[5] = 0.5 * o_.g * damping;
    q[4] = sqrt(T(o_.g * forces.K - q[5] * q[5]));
    q[2] = y_ - q[0];
    q[3] = (v_ - q[1] + q[5] * q[2]) / q[4];
    return arc;
  }

  static std::array<double, 6> ValuesOf(const ExtendedArc<T>& arc) {
    std::array<double, 6> q{};
    for (std::size_t j = 0; j < q.size(); ++j) q[j] = Value(arc.q[j]);
    return q;
  }

  /// First slider whose moving limit is reached before s_end; sets s_end.
  /// @param motion   displacement and velocity at s
  /// @param scan     the same at `scans` equally spaced s from the first step on
  template <typename Motion, typename Scan>
  std::size_t FindMovingBreakout(const Motion& motion, int scans, const Scan& scan, double* s_end) const {
    std::size_t found = kNothing;
    const double start = Value(t_);
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (!mode_.BreaksOut(i) || !mode_.LimitMoves(i)) continue;
      const auto reserve = [&](double s, const auto& p) { return mode_.MovingReserve(i, start + s, p.y, p.v); };
      double before = 0, at_before = std::max(reserve(0, motion(0.0)), 1e-300);
      const double step = *s_end / scans;
      scan(step, scans, [&](int number, const auto& p) {
        const double now = number * step, at_now = reserve(now, p);
        if (at_now < -kTiny * scale_) {
          const auto at = [&](double s) { return reserve(s, motion(s)); };
          *s_end = FindZero(at, before, at_before, now, at_now, kRounding * scale_);
          found = i;
          return false;
        }
        before = now, at_before = std::max(at_now, 1e-300);
        return true;
      });
    }
    return found;
  }

  bool LimitsMove() const { return o_.has_drift || o_.has_strengthening; }

  std::size_t FindMovingBreakout(const DampedSwing& swing, double* s_end) const {
    if (!LimitsMove()) return kNothing;
    const auto scan = [&](double step, int scans, const auto& use) {
      DampedTurner turner(swing.q[5], swing.q[4], step);
      for (int i = 1; i <= scans; ++i) {
        turner.Next();
        if (!use(i, swing.At(i * step, turner.cosine(), turner.sine()))) return;
      }
    };
    return FindMovingBreakout([&](double s) { return swing.At(s); }, 12, scan, s_end);
  }

  std::size_t FindMovingBreakout(const PolynomialArc& arc, double* s_end) const {
    if (!LimitsMove()) return kNothing;
    const auto scan = [&](double step, int scans, const auto& use) {
      for (int i = 1; i <= scans; ++i)
        if (!use(i, arc.At(i * step))) return;
    };
    return FindMovingBreakout([&](double s) { return arc.At(s); }, 3, scan, s_end);  // a step is a short arc
  }

  /// Moves along an arc that carries derivatives.
  void Advance(const ExtendedArc<T>& arc, const std::array<double, 6>& q, const DampedSwing::Point& p, double s) {
    t_ += s;
    if (mode_.damped() || !IsAbsent(arc.q[1])) {
      y_ = Propagate<T>(p.y, {{1, arc.q[0]},
                              {s, arc.q[1]},
                              {p.cosine, arc.q[2]},
                              {p.sine, arc.q[3]},
                              {s * p.turned, arc.q[4]},
                              {-s * p.swing, arc.q[5]}});
      v_ = Propagate<T>(p.v, {{1, arc.q[1]},
                              {-q[4] * p.sine - q[5] * p.cosine, arc.q[2]},
                              {q[4] * p.cosine - q[5] * p.sine, arc.q[3]},
                              {p.turned - s * (q[4] * p.swing + q[5] * p.turned), arc.q[4]},
                              {-p.swing + s * (q[5] * p.swing - q[4] * p.turned), arc.q[5]}});
    } else {
      y_ = Propagate<T>(p.y, {{1, arc.q[0]}, {p.cosine, arc.q[2]}, {p.sine, arc.q[3]}, {s * p.turned, arc.q[4]}});
      v_ = Propagate<T>(
          p.v, {{-q[4] * p.sine, arc.q[2]}, {q[4] * p.cosine, arc.q[3]}, {p.turned - s * q[4] * p.swing, arc.q[4]}});
    }
  }

  void PassThreshold(const ModeForces<T>& forces, const Next& next) {
    SetValue(y_, next.y);
    if (next.what < o_.sliders.size() && mode_.BreaksOut(next.what)) LiftBreakout(forces, next.what);
    mode_.Pass(next.what);
  }

  /// One arc and the event that ends it. @returns false at the end of the run.
  bool WalkClosedForm(const ModeForces<T>& forces) {
    const ExtendedArc<T> arc = MakeArc(forces);
    const DampedSwing swing{ValuesOf(arc)};
    if (!std::isfinite(swing.q[4]) || !(swing.q[4] > 0) || !std::isfinite(swing.q[3])) return failed_ = true, false;
    out_.Append(arc);
    const double left = duration_ - Value(t_);
    const Next next = mode_.FindNextThreshold(t_, y_);
    const double d = mode_.direction();
    double s = swing.FindTurning(d);
    const bool turns = !(d * (swing.At(s).y - Value(y_)) - next.distance > kTiny * scale_);
    if (!turns) s = next.distance == 0 ? 0 : swing.FindCrossing(next.y, d, s, kRounding * scale_);
    const std::size_t moving = FindMovingBreakout(swing, &s);
    if (!(s < left)) return false;
    out_.back().t_end = Value(t_) + s;
    Advance(arc, swing.q, swing.At(s), s);
    if (moving != kNothing) {
      LiftBreakout(forces, moving);
      mode_.Pass(moving);
    } else if (turns) {
      TurnRound(forces);
    } else {
      PassThreshold(forces, next);
    }
    return true;
  }

  // --- Integration ---------------------------------------------------------------------------------------------

  Step<T> TakeStep(const ModeForces<T>& forces, const T& a, double h) const {
    return dormand_prince::TakeStep(y_, v_, a, h, [&](double share, const T& y, const T& v) {
      return mode_.CalcAcceleration(forces, o_.has_drift || !o_.forces.empty() ? T(t_ + share * h) : t_, y, v);
    });
  }

  /// The quintic through (y, v, a) at both ends of a step.
  static ExtendedArc<T> Interpolate(const T& t, const T& y, const T& v, const T& a, const Step<T>& end, double h) {
    ExtendedArc<T> arc{.t_start = t, .t_end = Value(t) + h, .length = h};
    auto& q = arc.q;
    q[0] = y;
    q[1] = h * v;
    q[2] = (0.5 * h * h) * a;
    // rise, slope and bend: what y, v and a at the end are beyond those of q0, q1, q2
    const double h2 = 0.5 * h * h;
    q[3] = Sum<T>({{10, end.y}, {-10, y}, {-6 * h, v}, {-3 * h2, a}, {-4 * h, end.v}, {h2, end.a}});
    q[4] = Sum<T>({{-15, end.y}, {15, y}, {8 * h, v}, {3 * h2, a}, {7 * h, end.v}, {-2 * h2, end.a}});
    q[5] = Sum<T>({{6, end.y}, {-6, y}, {-3 * h, v}, {-h2, a}, {-3 * h, end.v}, {h2, end.a}});
    return arc;
  }

  /// A joint sticks at the zero of its margin. With drift its slider still moves there, so that the derivative of the
  /// time counts. A joint that sticks at once has been freed by an event that is lifted already.
  void LiftSticking(const ModeForces<T>& forces, std::size_t i) {
    const T margin = mode_.CalcSlidingMargin(forces, i, t_, y_, v_);
    if (std::abs(Value(margin)) > 1e-7) return;
    const double a = Value(mode_.CalcAcceleration(forces, t_, y_, v_));
    const auto at = [&](double s) {
      return Value(
          mode_.CalcSlidingMargin(forces, i, T(Value(t_) + s), T(Value(y_) + Value(v_) * s), T(Value(v_) + a * s)));
    };
    constexpr double h = 1e-6;  // [s]; margins change within 1e-2 s
    const double rate = (at(h) - at(-h)) / (2 * h);
    if (std::abs(rate) > kGraze) Lift(Infinitesimal(T(-margin / rate)), a);
  }

  enum class EventIn { kNone, kTurning, kThreshold, kMoving, kSticking };

  /// The first event within a step that has been interpolated, and when.
  EventIn FindEvent(const ModeForces<T>& forces, const PolynomialArc& arc, const Next& next, double* s,
                    std::size_t* which) const {
    EventIn event = EventIn::kNone;
    const double h = arc.length, d = mode_.direction();
    *s = h;
    const double tiny = kRounding * scale_, at_h = d * arc.At(h).v;
    if (at_h <= 0) {
      const double start = d * arc.q[1] / h;
      *s = FindZero([&](double at) { return d * arc.At(at).v; }, start > 0 ? 0 : 1e-6 * h, std::max(start, 1e-300), h,
                    at_h, tiny * frequency_);
      event = EventIn::kTurning;
    }
    const auto reserve = [&](double at) { return d * (next.y - arc.At(at).y); };
    const double at_end = reserve(*s);
    if (next.exists() && at_end < (event == EventIn::kTurning ? -kTiny * scale_ : 0)) {
      *s = FindZero(reserve, 0, std::max(1e-300, reserve(0)), *s, at_end, tiny);
      *which = next.what;
      event = EventIn::kThreshold;
    }
    const std::size_t moving = FindMovingBreakout(arc, s);
    if (moving != kNothing) {
      *which = moving;
      event = EventIn::kMoving;
    }
    if (o_.speed_terms.empty()) return event;
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (!mode_.SlidesAsJoint(i)) continue;
      const auto margin = [&](double at) {
        const auto p = arc.At(at);
        const T t(Value(t_) + at), y(p.y), v(std::max(0.0, d * p.v) * d);
        return Value(mode_.CalcSlidingMargin(forces, i, t, y, v));
      };
      const double to = event == EventIn::kTurning ? 0.999 * *s : *s;  // at rest the margin is zero anyway
      const double at_to = margin(to);
      if (at_to >= 0) continue;
      *s = FindZero(margin, 0, std::max(1e-300, margin(0)), to, at_to, 10 * tiny * frequency_);
      *which = i;
      event = EventIn::kSticking;
    }
    return event;
  }

  /// Steps to the next event. @returns false at the end of the run.
  bool WalkNumerically(const ModeForces<T>& forces) {
    frequency_ = std::sqrt(o_.g * std::max(Value(forces.K), 1e-3));
    // The interpolation is off by (w h)^6/46080 of the amplitude: no more than three steps' errors.
    const double longest = std::min(0.5, std::pow(1.4e5 * options_.tolerance, 1.0 / 6)) / frequency_;
    T a = mode_.CalcAcceleration(forces, t_, y_, v_);
    const Next next = mode_.FindNextThreshold(t_, y_);
    double h = std::min(step_ > 0 ? step_ : longest, longest);
    while (true) {
      const double left = duration_ - Value(t_);
      Step<T> end = TakeStep(forces, a, h);
      const double error =
          std::max(std::abs(end.y_error), std::abs(end.v_error) / frequency_) / (options_.tolerance * scale_);
      if (!(std::abs(Value(end.y)) < kEscape * scale_) || !std::isfinite(Value(end.a)) || !(h > 1e-12))
        return failed_ = true, false;
      const double factor = std::clamp(0.9 * std::pow(std::max(error, 1e-10), -0.2), 0.2, 4.0);
      if (error > 1) {
        h *= factor;
        continue;
      }
      ExtendedArc<T> arc = Interpolate(t_, y_, v_, a, end, h);
      double s = h;
      std::size_t which = 0;
      const EventIn event = FindEvent(forces, {ValuesOf(arc), h}, next, &s, &which);
      if (event != EventIn::kNone) {
        if (s > 1e-12) {
          end = TakeStep(forces, a, s);
          if (event == EventIn::kTurning) Polish(forces, a, &end, &s);
          arc = Interpolate(t_, y_, v_, a, end, s);
          out_.Append(arc);
          t_ += s;
          y_ = end.y;
          v_ = end.v;
        }
        if (Value(t_) >= duration_) return out_.back().t_end = duration_, false;
        Handle(forces, event, which, next);
        return true;
      }
      out_.Append(arc);
      if (left <= h) return out_.back().t_end = duration_, false;
      t_ += h;
      y_ = end.y;
      v_ = end.v;
      a = end.a;
      h = std::min(h * factor, longest);
      step_ = h;
    }
  }

  /// Moves a step's end to where the integrator itself, not its interpolation, has v = 0.
  void Polish(const ModeForces<T>& forces, const T& a, Step<T>* end, double* s) const {
    for (int i = 0; i < 3 && std::abs(Value(end->a)) > kGraze; ++i) {
      const double more = -Value(end->v) / Value(end->a);
      if (!(*s + more > 0 && *s + more < 2 * *s)) return;
      *s += more;
      if (std::abs(more) * frequency_ < 1e-8) {  // what it leaves is a share of 1e-16
        end->y += more * end->v;
        end->v += more * end->a;
        return;
      }
      *end = TakeStep(forces, a, *s);
    }
  }

  void Handle(const ModeForces<T>& forces, EventIn event, std::size_t which, const Next& next) {
    switch (event) {
      case EventIn::kTurning:
        TurnRound(forces);
        break;
      case EventIn::kThreshold:
        PassThreshold(forces, next);
        break;
      case EventIn::kMoving:
        LiftBreakout(forces, which);
        mode_.Pass(which);
        break;
      case EventIn::kSticking:
        LiftSticking(forces, which);
        mode_.Stick(which, t_, y_, mode_.direction() * v_);
        break;
      case EventIn::kNone:
        break;
    }
  }

  static constexpr std::size_t kNothing = ~std::size_t{0};

  const ExtendedOscillator<T>& o_;
  double clock_, duration_;
  ExtendedSolveOptions options_;
  ExtendedTrajectory<T>& out_;

  ExtendedMode<T> mode_;
  T t_{}, y_{}, v_{};
  double scale_ = 0;
  double frequency_ = 1, step_ = 0;  // of the integrator
  bool held_ = false;
  bool failed_ = false;
};

template <typename T>
bool IsAdmissible(const ExtendedOscillator<T>& o, const T& y0) {
  if (!(Value(o.k) > 0 && std::isfinite(Value(o.k)) && o.g > 0)) return false;
  if (!std::isfinite(Value(y0)) || Value(y0) == 0) return false;
  for (const ExtendedSlider<T>& s : o.sliders.items())
    if (!(Value(s.k) >= 0 && std::isfinite(Value(s.k)) && Value(s.y_c) >= 0 && std::isfinite(Value(s.y_c))))
      return false;
  return Value(o.gap) >= 0 && Value(o.rolling) >= 0;
}

}  // namespace

template <typename T>
SolveStatus Solve(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
                  ExtendedTrajectory<T>* out, const ExtendedSolveOptions& options) {
  out->Clear();
  if (!IsAdmissible(oscillator, y0) || !(duration >= 0)) return SolveStatus::kNotFinite;
  return ExtendedWalk<T>(oscillator, y0, clock, duration, options, out).Run();
}

#define UICLINK_INSTANTIATE_SOLVE(T)                                                                         \
  template SolveStatus Solve(const ExtendedOscillator<T>&, const T&, double, double, ExtendedTrajectory<T>*, \
                             const ExtendedSolveOptions&)
UICLINK_INSTANTIATE_SOLVE(double);
UICLINK_INSTANTIATE_SOLVE(Dual<6>);
UICLINK_INSTANTIATE_SOLVE(Dual<8>);
UICLINK_INSTANTIATE_SOLVE(Dual<12>);
UICLINK_INSTANTIATE_SOLVE(Dual<16>);
#undef UICLINK_INSTANTIATE_SOLVE

}  // namespace uiclink
