#include "model/extended_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/damped_swing.h"
#include "model/dormand_prince.h"
#include "model/dual_sum.h"

namespace uiclink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
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

/// |v| for a mass that moves in direction d.
template <typename T>
T SpeedOf(const T& v, double d) {
  return d * v;
}

/// What a slider does.
enum class Hold : std::uint8_t {
  kSticks,  ///< its spring is loaded or slack-free
  kLoose,   ///< within its clearance: no force
  kSlides,
};

template <typename T>
struct SliderState {
  T p{};        ///< position of the slider [m], while it does not slide
  T neutral{};  ///< where its spring has no force [m], while it does not slide
  T load{};     ///< k times that [-]
  Hold hold = Hold::kSticks;
  double side = 1;  ///< end of the clearance at which the spring is engaged
};

/// The force between two events:  y''/g = C - K y - B v - d S F(t, |v|) + forces,  F the joints' friction factor L.
template <typename T>
struct ModeForces {
  T K{}, B{}, C{};
  T S{};                ///< sum of k y_c of sliding joints [-]
  bool slides = false;  ///< any joint slides, and its friction changes: a constant one is in C
};

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
  ExtendedWalk(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
               const ExtendedSolveOptions& options, ExtendedTrajectory<T>* out)
      : o_(oscillator), clock_(clock), duration_(duration), options_(options), out_(*out), y_(y0) {
    scale_ = std::abs(Value(y0));
    damped_ = o_.has_strengthening || !IsAbsent(o_.damping);
    asymmetric_ = !IsAbsent(o_.asymmetry);
    limits_vary_ = o_.has_drift || o_.has_strengthening || !o_.speed_terms.empty();
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) sticking_share_ += term.sticking(term.p);
    const double side = Value(y0) < 0 ? -1 : 1;
    const auto sliders = o_.sliders.items();
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      slip_[i] = sliders[i].k * sliders[i].y_c;
      state_[i].p = y0 - side * CalcDeflectionAtExtremum(o_, i, y0, clock);
      state_[i].side = side;
      Load(i);
    }
    const auto stops = o_.stops.items();
    for (std::size_t i = 0; i < stops.size(); ++i) stop_active_[i] = Beyond(stops[i], Value(y_)) > 0;
    d_ = side;
    StartFromRest();
  }

  SolveStatus Run() {
    while (out_.CountEvents() <= options_.max_events) {
      if (held_) {
        AppendRest();
        return SolveStatus::kOk;
      }
      SettleAtLimits();
      const ModeForces<T> forces = CalcMode();
      const bool goes_on = IsAffine(forces) ? WalkClosedForm(forces) : WalkNumerically(forces);
      if (failed_) return SolveStatus::kNotFinite;
      if (!goes_on) return SolveStatus::kOk;
      out_.CountEvent();
    }
    return SolveStatus::kTooManyEvents;
  }

 private:
  // --- Friction limits -----------------------------------------------------------------------------------------

  bool ActsOn(std::size_t i) const { return o_.sliders.items()[i].joint; }
  bool HasGap(std::size_t i) const { return o_.has_gap && ActsOn(i); }

  /// Factor of T0 by drift and asymmetry; t since the start of the run.
  T DriftFactor(const T& t) const {
    T factor(1);
    if (o_.has_drift) factor += o_.drift * (t + clock_);
    if (asymmetric_) factor *= T(1) + d_ * o_.asymmetry;
    return factor;
  }
  double DriftFactorValue(double t) const {
    return (1 + Value(o_.drift) * (t + clock_)) * (1 + d_ * Value(o_.asymmetry));
  }

  /// Friction factor L of a joint that slides.
  T SlidingFactor(const T& t, const T& speed) const {
    T factor(1);
    if (o_.has_strengthening) factor += o_.strengthening * speed;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) factor += term.sliding(term.p, speed);
    return o_.has_drift || asymmetric_ ? T(factor * DriftFactor(t)) : factor;
  }

  /// The same at which a joint that sticks breaks out.
  T StickingFactor(const T& t, const T& speed) const {
    return (T(1) + o_.strengthening * speed + sticking_share_) * DriftFactor(t);
  }

  double StickingLimitValue(std::size_t i, double t, double speed) const {
    const ExtendedSlider<T>& slider = o_.sliders.items()[i];
    if (!slider.joint) return Value(slider.y_c);
    return Value(slider.y_c) * (1 + Value(o_.strengthening) * speed + Value(sticking_share_)) * DriftFactorValue(t);
  }

  /// The limit of a joint that sticks changes while it sticks.
  bool LimitMoves(std::size_t i) const { return ActsOn(i) && (o_.has_drift || o_.has_strengthening); }

  // --- Springs, stops, mode ------------------------------------------------------------------------------------

  /// Brings what follows from the position and the side of a slider that does not slide up to date.
  void Load(std::size_t i) {
    SliderState<T>& s = state_[i];
    s.neutral = HasGap(i) ? T(s.p + s.side * o_.gap) : s.p;
    s.load = o_.sliders.items()[i].k * s.neutral;
  }

  /// How far the mass is beyond a stop, > 0 in contact.
  static double Beyond(const Stop<T>& stop, double y) {
    const double position = Value(stop.position);
    return position > 0 ? y - position : position - y;
  }

  ModeForces<T> CalcMode() const {
    ModeForces<T> forces{.K = o_.k, .B = o_.damping};
    const auto sliders = o_.sliders.items();
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      const ExtendedSlider<T>& slider = sliders[i];
      if (state_[i].hold == Hold::kSticks) {
        forces.K += slider.k;
        forces.C += state_[i].load;
      } else if (state_[i].hold == Hold::kSlides) {
        if (!slider.joint) {
          forces.C -= d_ * slip_[i];
        } else {
          forces.S += slip_[i];
          forces.slides = true;
        }
      }
    }
    if (forces.slides && !limits_vary_) {
      forces.C -= asymmetric_ ? T(d_ * (forces.S * DriftFactor(t_))) : T(d_ * forces.S);
      forces.slides = false;
    }
    const auto stops = o_.stops.items();
    for (std::size_t i = 0; i < stops.size(); ++i) {
      if (!stop_active_[i]) continue;
      forces.K += stops[i].k;
      forces.C += stops[i].k * stops[i].position;
    }
    if (o_.has_rolling) forces.C -= d_ * o_.rolling;
    return forces;
  }

  bool IsAffine(const ModeForces<T>& forces) const {
    if (options_.always_integrate || !o_.forces.empty()) return false;
    return !forces.slides || (o_.speed_terms.empty() && !(o_.has_drift && o_.has_strengthening));
  }

  T Acceleration(const ModeForces<T>& forces, const T& t, const T& y, const T& v) const {
    const double g = o_.g, K = Value(forces.K), B = Value(forces.B), y_value = Value(y), v_value = Value(v);
    const double linear = g * (Value(forces.C) - K * y_value - B * v_value);
    T a = damped_ ? Propagate<T>(
                        linear,
                        {{g, forces.C}, {-g * K, y}, {-g * y_value, forces.K}, {-g * B, v}, {-g * v_value, forces.B}})
                  : Propagate<T>(linear, {{g, forces.C}, {-g * K, y}, {-g * y_value, forces.K}});
    if (forces.slides) a -= (g * d_) * (forces.S * SlidingFactor(t, SpeedOf(v, d_)));
    if (o_.forces.empty()) return a;
    const Motion<T> motion{.t = t + clock_, .y = y, .v = v};
    for (const ForceTerm<T>& term : o_.forces.items()) a = Sum<T>({{1, a}, {g, term.force(term.p, motion)}});
    return a;
  }

  /// Force at rest without the friction of rolling [-].
  double RestForce() const {
    ModeForces<T> forces = CalcMode();
    if (o_.has_rolling) forces.C += d_ * o_.rolling;
    return Value(Acceleration(forces, t_, y_, T(0))) / o_.g;
  }

  // --- Thresholds: displacements at which the mode changes -----------------------------------------------------

  /// Where something happens to a slider next while the mass moves on [m].
  double Threshold(std::size_t i) const {
    const SliderState<T>& s = state_[i];
    const double gap = Value(o_.gap);
    if (s.hold == Hold::kLoose) return Value(s.p) + d_ * gap;
    if (HasGap(i) && s.side != d_) return Value(s.p) + s.side * gap;  // unloads into the clearance
    return Value(s.neutral) + d_ * StickingLimitValue(i, Value(t_), 0);
  }

  bool BreaksOut(std::size_t i) const {
    return state_[i].hold == Hold::kSticks && (!HasGap(i) || state_[i].side == d_);
  }

  void PassThreshold(std::size_t i) {
    SliderState<T>& s = state_[i];
    if (s.hold == Hold::kLoose) {
      s.hold = Hold::kSticks;
      s.side = d_;
      Load(i);
    } else if (BreaksOut(i)) {
      s.hold = Hold::kSlides;
    } else {
      s.hold = Hold::kLoose;
    }
  }

  /// Everything that is at its threshold already changes before the arc starts.
  void SettleAtLimits() {
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      for (int pass = 0; pass < 3 && state_[i].hold != Hold::kSlides; ++pass) {
        const double limit = BreaksOut(i) && LimitMoves(i)
                                 ? Value(state_[i].neutral) + d_ * StickingLimitValue(i, Value(t_), d_ * Value(v_))
                                 : Threshold(i);
        if (d_ * (limit - Value(y_)) > kTiny * scale_) break;
        PassThreshold(i);
      }
    }
  }

  /// Number of a slider or (beyond these) of a stop, and how far away its threshold is.
  struct Next {
    std::size_t what = 0;
    double distance = kInfinity;
    double y = 0;

    bool exists() const { return distance < kInfinity; }
  };

  Next FindNextThreshold() const {
    Next next;
    const double y = Value(y_);
    const auto consider = [&](std::size_t what, double threshold) {
      const double distance = d_ * (threshold - y);
      if (distance < next.distance) next = {.what = what, .distance = std::max(0.0, distance), .y = threshold};
    };
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (state_[i].hold == Hold::kSlides || (BreaksOut(i) && LimitMoves(i))) continue;
      consider(i, Threshold(i));
    }
    const auto stops = o_.stops.items();
    for (std::size_t i = 0; i < stops.size(); ++i) {
      const double position = Value(stops[i].position);
      const bool away = position * d_ < 0;
      if (stop_active_[i] == away) consider(o_.sliders.size() + i, position);
    }
    return next;
  }

  void Pass(std::size_t what) {
    const std::size_t sliders = o_.sliders.size();
    if (what >= sliders) {
      stop_active_[what - sliders] = !stop_active_[what - sliders];
    } else {
      PassThreshold(what);
    }
  }

  /// Reserve of a slider whose limit moves: > 0 while it sticks [m].
  double MovingReserve(std::size_t i, double t, double y, double v) const {
    return StickingLimitValue(i, t, std::max(0.0, d_ * v)) - d_ * (y - Value(state_[i].neutral));
  }

  // --- Events --------------------------------------------------------------------------------------------------

  /// Moves the state by an infinitesimal time that carries the derivatives of an event's time.
  void Lift(const T& delta, double a) {
    t_ += delta;
    y_ += Value(v_) * delta;
    v_ += a * delta;
  }

  void TurnRound(const ModeForces<T>& forces) {
    SetValue(v_, 0.0);
    const double a = Value(Acceleration(forces, t_, y_, v_));
    if (std::abs(a) > kGraze) Lift(Infinitesimal(T(-v_ / a)), a);
    v_ = T(0);
    const auto sliders = o_.sliders.items();
    for (std::size_t i = 0; i < sliders.size(); ++i)
      if (state_[i].hold == Hold::kSlides) Stick(i, t_, T(0));
    StartFromRest();
  }

  /// A slider stops sliding.
  void Stick(std::size_t i, const T& t, const T& speed) {
    const ExtendedSlider<T>& slider = o_.sliders.items()[i];
    const bool varies = slider.joint && (limits_vary_ || asymmetric_);
    const T reach = varies ? T(slider.y_c * SlidingFactor(t, speed)) : slider.y_c;
    state_[i].p = y_ - d_ * (HasGap(i) ? T(reach + o_.gap) : reach);
    state_[i].hold = Hold::kSticks;
    state_[i].side = d_;
    Load(i);
  }

  /// Direction of the motion that starts from rest, or none.
  void StartFromRest() {
    const double force = RestForce();
    held_ = o_.has_rolling && std::abs(force) <= Value(o_.rolling);
    if (force != 0) {
      d_ = force > 0 ? 1 : -1;
    } else {
      held_ = true;
    }
  }

  /// A breakout at which the force jumps: the derivative of its time counts.
  void LiftBreakout(const ModeForces<T>& forces, std::size_t i) {
    if (o_.speed_terms.empty() || !ActsOn(i)) return;
    const T factor = StickingFactor(t_, SpeedOf(v_, d_));
    const T reserve = o_.sliders.items()[i].y_c * factor - d_ * (y_ - state_[i].neutral);
    const double a = Value(Acceleration(forces, t_, y_, v_));
    const double drift = DriftFactorValue(Value(t_));
    const double growth = drift * Value(o_.strengthening) * d_ * a +
                          Value(factor) / drift * Value(o_.drift) * (1 + d_ * Value(o_.asymmetry));
    const double rate = Value(o_.sliders.items()[i].y_c) * growth - d_ * Value(v_);
    if (std::abs(rate) < kGraze) return;
    Lift(Infinitesimal(T(-reserve / rate)), a);
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
    if (!damped_ && !forces.slides) {
      q[0] = forces.C / forces.K;
      q[4] = sqrt(T(o_.g * forces.K));
      q[2] = y_ - q[0];
      q[3] = v_ / q[4];
      return arc;
    }
    T damping = forces.B, centre = forces.C;
    if (forces.slides) {
      const T side = asymmetric_ ? T(d_ + o_.asymmetry) : T(d_);  // d (1 + d asymmetry)
      const T at_start = T(1) + o_.drift * (t_ + clock_);
      centre -= forces.S * (side * at_start);
      damping += forces.S * (o_.strengthening * (at_start * (d_ * side)));
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

  /// A time at which a function that is positive at s0 and not positive at s1 is zero, or as good as: regula falsi
  /// after Anderson and Bjorck (1973), with a bisection wherever the bracket has not shrunk enough.
  template <typename Function>
  static double FindZero(Function f, double s0, double f0, double s1, double f1, double tiny) {
    double width = s1 - s0;
    bool was_positive = false;
    for (int i = 0; i < 200 && s1 - s0 > 1e-16 + 4e-16 * s1; ++i) {
      double s = s0 + (s1 - s0) * f0 / (f0 - f1);
      if (i % 4 == 3) {
        if (s1 - s0 > 0.25 * width) s = 0.5 * (s0 + s1);
        width = s1 - s0;
      }
      if (!(s > s0 && s < s1)) s = 0.5 * (s0 + s1);
      const double value = f(s);
      if (std::abs(value) <= tiny) return s;
      const bool positive = value > 0;
      if (i > 0 && positive == was_positive) {  // the other end has stayed: it counts for less
        const double fall = 1 - value / (positive ? f0 : f1);
        (positive ? f1 : f0) *= fall > 0 ? fall : 0.5;
      }
      (positive ? s0 : s1) = s;
      (positive ? f0 : f1) = value;
      was_positive = positive;
    }
    return s1;
  }

  /// First slider whose moving limit is reached before s_end; sets s_end.
  /// @param motion   displacement and velocity at s
  /// @param scan     the same at `scans` equally spaced s from the first step on
  template <typename Motion, typename Scan>
  std::size_t FindMovingBreakout(const Motion& motion, int scans, const Scan& scan, double* s_end) const {
    std::size_t found = kNothing;
    const double start = Value(t_);
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (!BreaksOut(i) || !LimitMoves(i)) continue;
      const auto reserve = [&](double s, const auto& p) { return MovingReserve(i, start + s, p.y, p.v); };
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
    if (damped_ || !IsAbsent(arc.q[1])) {
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

  /// One arc and the event that ends it. @returns false at the end of the run.
  bool WalkClosedForm(const ModeForces<T>& forces) {
    const ExtendedArc<T> arc = MakeArc(forces);
    const DampedSwing swing{ValuesOf(arc)};
    if (!std::isfinite(swing.q[4]) || !(swing.q[4] > 0) || !std::isfinite(swing.q[3])) return failed_ = true, false;
    out_.Append(arc);
    const double left = duration_ - Value(t_);
    const Next next = FindNextThreshold();
    double s = swing.FindTurning(d_);
    const bool turns = !(d_ * (swing.At(s).y - Value(y_)) - next.distance > kTiny * scale_);
    if (!turns) s = next.distance == 0 ? 0 : swing.FindCrossing(next.y, d_, s, kRounding * scale_);
    const std::size_t moving = FindMovingBreakout(swing, &s);
    if (!(s < left)) return false;
    out_.back().t_end = Value(t_) + s;
    Advance(arc, swing.q, swing.At(s), s);
    if (moving != kNothing) {
      LiftBreakout(forces, moving);
      PassThreshold(moving);
    } else if (turns) {
      TurnRound(forces);
    } else {
      SetValue(y_, next.y);
      if (next.what < o_.sliders.size() && BreaksOut(next.what)) LiftBreakout(forces, next.what);
      Pass(next.what);
    }
    return true;
  }

  // --- Integration ---------------------------------------------------------------------------------------------

  Step<T> TakeStep(const ModeForces<T>& forces, const T& a, double h) const {
    return dormand_prince::TakeStep(y_, v_, a, h, [&](double share, const T& y, const T& v) {
      return Acceleration(forces, o_.has_drift || !o_.forces.empty() ? T(t_ + share * h) : t_, y, v);
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

  /// Margin of a sliding joint against sticking: d p', > 0 while it slides [m/s]. It sticks where its limit grows
  /// faster than the spring can follow. The slow growth by drift is left out: it would matter below y_c rate only.
  T SlidingMargin(const ModeForces<T>& forces, std::size_t i, const T& t, const T& y, const T& v) const {
    const T speed = SpeedOf(v, d_);
    T slope = o_.strengthening;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) slope += term.slope(term.p, speed);
    const T deceleration = -d_ * Acceleration(forces, t, y, v);
    return speed + o_.sliders.items()[i].y_c * slope * DriftFactor(t) * deceleration;
  }

  /// A joint sticks at the zero of its margin. With drift its slider still moves there, so that the derivative of the
  /// time counts. A joint that sticks at once has been freed by an event that is lifted already.
  void LiftSticking(const ModeForces<T>& forces, std::size_t i) {
    const T margin = SlidingMargin(forces, i, t_, y_, v_);
    if (std::abs(Value(margin)) > 1e-7) return;
    const double a = Value(Acceleration(forces, t_, y_, v_));
    const auto at = [&](double s) {
      return Value(SlidingMargin(forces, i, T(Value(t_) + s), T(Value(y_) + Value(v_) * s), T(Value(v_) + a * s)));
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
    const double h = arc.length;
    *s = h;
    const double tiny = kRounding * scale_, at_h = d_ * arc.At(h).v;
    if (at_h <= 0) {
      const double start = d_ * arc.q[1] / h;
      *s = FindZero([&](double at) { return d_ * arc.At(at).v; }, start > 0 ? 0 : 1e-6 * h, std::max(start, 1e-300), h,
                    at_h, tiny * frequency_);
      event = EventIn::kTurning;
    }
    const auto reserve = [&](double at) { return d_ * (next.y - arc.At(at).y); };
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
      if (state_[i].hold != Hold::kSlides || !ActsOn(i)) continue;
      const auto margin = [&](double at) {
        const auto p = arc.At(at);
        const T t(Value(t_) + at), y(p.y), v(std::max(0.0, d_ * p.v) * d_);
        return Value(SlidingMargin(forces, i, t, y, v));
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
    T a = Acceleration(forces, t_, y_, v_);
    const Next next = FindNextThreshold();
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
        SetValue(y_, next.y);
        if (which < o_.sliders.size() && BreaksOut(which)) LiftBreakout(forces, which);
        Pass(which);
        break;
      case EventIn::kMoving:
        LiftBreakout(forces, which);
        PassThreshold(which);
        break;
      case EventIn::kSticking:
        LiftSticking(forces, which);
        Stick(which, t_, SpeedOf(v_, d_));
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

  T t_{}, y_{}, v_{};
  double d_ = 1;
  double scale_ = 0;
  double frequency_ = 1, step_ = 0;  // of the integrator
  std::array<SliderState<T>, kMaxExtendedSliders> state_{};
  std::array<T, kMaxExtendedSliders> slip_{};  // k y_c [-]
  T sticking_share_{};                         // of the limits of joints that stick, by their speed terms
  bool damped_ = false, asymmetric_ = false;   // be it by a derivative only
  bool limits_vary_ = false;                   // limits of joints change with time or speed
  std::array<bool, 2> stop_active_{};
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

/// Shares of T0 by the speed terms that joints have at an extremum at distance A [m] that they reached sliding.
///
/// A joint that sticks at the speed v before the extremum, a way x before it, has the share of v there and what its
/// spring takes on the way.  v follows from the deceleration a where it sticks, and x from  v^2 = 2 a x + g K x^2,  K
/// the stiffness with that joint stuck; both depend on each other weakly, so a few passes do.
template <typename T>
std::array<T, kMaxExtendedSliders> CalcSharesAtExtremum(const ExtendedOscillator<T>& o, const T& A) {
  using std::sqrt;
  constexpr int kPasses = 6;
  const auto sliders = o.sliders.items();
  std::array<T, kMaxExtendedSliders> share{}, way{};
  for (int pass = 0; pass < kPasses; ++pass) {
    T K = o.k, friction{};
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      friction += sliders[i].k * sliders[i].y_c * (T(1) + share[i]);
      if (Value(way[i]) > 0) K += sliders[i].k;
    }
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      if (!sliders[i].joint) continue;
      const T a = o.g * (o.k * (A - way[i]) + friction);
      share[i] = way[i] = T(0);
      for (const SpeedTerm<T>& term : o.speed_terms.items()) {
        const T v2 = term.sticking_speed_squared(term.p, sliders[i].y_c, a);
        const bool sticks = Value(v2) > 0;
        share[i] += term.sliding(term.p, sticks ? T(sqrt(v2)) : T(0));
        if (sticks) way[i] = (sqrt(a * a + o.g * K * v2) - a) / (o.g * K);
      }
    }
  }
  for (std::size_t i = 0; i < sliders.size(); ++i)
    if (Value(way[i]) > 0) share[i] += way[i] / sliders[i].y_c;
  return share;
}

}  // namespace

template <typename T>
T CalcDeflectionAtExtremum(const ExtendedOscillator<T>& o, std::size_t slider, const T& y0, double clock) {
  const ExtendedSlider<T>& s = o.sliders.items()[slider];
  if (!s.joint) return s.y_c;
  const double side = Value(y0) < 0 ? -1 : 1;
  T factor(1);
  if (!o.speed_terms.empty()) factor += CalcSharesAtExtremum(o, T(side * y0))[slider];
  factor *= (T(1) + o.drift * clock) * (T(1) + side * o.asymmetry);
  T reach = s.y_c * factor;
  if (o.has_gap) reach += o.gap;
  return reach;
}

template <typename T>
SolveStatus Solve(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
                  ExtendedTrajectory<T>* out, const ExtendedSolveOptions& options) {
  out->Clear();
  if (!IsAdmissible(oscillator, y0) || !(duration >= 0)) return SolveStatus::kNotFinite;
  return ExtendedWalk<T>(oscillator, y0, clock, duration, options, out).Run();
}

#define UICLINK_INSTANTIATE_SOLVE(T)                                                                         \
  template SolveStatus Solve(const ExtendedOscillator<T>&, const T&, double, double, ExtendedTrajectory<T>*, \
                             const ExtendedSolveOptions&);                                                   \
  template T CalcDeflectionAtExtremum(const ExtendedOscillator<T>&, std::size_t, const T&, double)
UICLINK_INSTANTIATE_SOLVE(double);
UICLINK_INSTANTIATE_SOLVE(Dual<6>);
UICLINK_INSTANTIATE_SOLVE(Dual<8>);
UICLINK_INSTANTIATE_SOLVE(Dual<12>);
UICLINK_INSTANTIATE_SOLVE(Dual<16>);
#undef UICLINK_INSTANTIATE_SOLVE

}  // namespace uiclink
