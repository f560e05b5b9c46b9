#include "model/extended_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace uiclink {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Distances below this share of the start displacement are none: a few roundings of the terms that they are sums of.
constexpr double kTiny = 1e-13;
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
  T p{};  ///< position of the slider [m], while it does not slide
  Hold hold = Hold::kSticks;
  double side = 1;  ///< end of the clearance at which the spring is engaged
};

/// The force between two events:  y''/g = C - K y - B v - d S F(t, |v|) + forces,  F the joints' friction factor L.
template <typename T>
struct ModeForces {
  T K{}, B{}, C{};
  T S{};                ///< sum of k y_c of sliding joints [-]
  bool slides = false;  ///< any joint slides
};

template <typename T>
struct Step {
  T y{}, v{}, a{};   ///< at its end
  double error = 0;  ///< of y, and of v over the frequency [m]
};

/// The state between two events, and the steps that lead to the next one.  One object lives for one run.
template <typename T>
class ExtendedWalk {
 public:
  ExtendedWalk(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
               const ExtendedSolveOptions& options, ExtendedTrajectory<T>* out)
      : o_(oscillator), clock_(clock), duration_(duration), options_(options), out_(*out), y_(y0) {
    scale_ = std::abs(Value(y0));
    const double side = Value(y0) < 0 ? -1 : 1;
    const auto sliders = o_.sliders.items();
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      state_[i].p = y0 - side * CalcDeflectionAtExtremum(o_, i, y0, clock);
      state_[i].side = side;
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
  template <typename S>
  S DriftFactor(const S& t, double d) const {
    return (S(1) + Cast<S>(o_.drift) * (t + clock_)) * (S(1) + d * Cast<S>(o_.asymmetry));
  }

  template <typename S>
  S Cast(const T& x) const {
    if constexpr (std::is_same_v<S, T>) {
      return x;
    } else {
      return Value(x);
    }
  }

  /// Friction factor L of a joint that slides.
  T SlidingFactor(const T& t, const T& speed) const {
    T factor = T(1) + o_.strengthening * speed;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) factor += term.sliding(term.p, speed);
    return factor * DriftFactor(t, d_);
  }

  /// The same at which a joint that sticks breaks out.
  T StickingFactor(const T& t, const T& speed) const {
    T factor = T(1) + o_.strengthening * speed;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) factor += term.sticking(term.p);
    return factor * DriftFactor(t, d_);
  }

  T StickingLimit(std::size_t i, const T& t, const T& speed) const {
    const ExtendedSlider<T>& slider = o_.sliders.items()[i];
    return slider.joint ? T(slider.y_c * StickingFactor(t, speed)) : slider.y_c;
  }

  /// The limit of a joint that sticks changes while it sticks.
  bool LimitMoves(std::size_t i) const { return ActsOn(i) && (o_.has_drift || o_.has_strengthening); }

  // --- Springs, stops, mode ------------------------------------------------------------------------------------

  /// Where the spring of a slider that does not slide has no force.
  T Neutral(std::size_t i) const { return HasGap(i) ? T(state_[i].p + state_[i].side * o_.gap) : state_[i].p; }

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
        forces.C += slider.k * Neutral(i);
      } else if (state_[i].hold == Hold::kSlides) {
        if (slider.joint) {
          forces.S += slider.k * slider.y_c;
          forces.slides = true;
        } else {
          forces.C -= d_ * (slider.k * slider.y_c);
        }
      }
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
    T sum = forces.C - forces.K * y - forces.B * v;
    if (forces.slides) sum -= d_ * (forces.S * SlidingFactor(t, SpeedOf(v, d_)));
    const Motion<T> motion{.t = t + clock_, .y = y, .v = v};
    for (const ForceTerm<T>& term : o_.forces.items()) sum += term.force(term.p, motion);
    return o_.g * sum;
  }

  /// Force at rest without the friction of rolling [-].
  double RestForce() const {
    ModeForces<T> forces = CalcMode();
    if (o_.has_rolling) forces.C += d_ * o_.rolling;
    return Value(Acceleration(forces, t_, y_, T(0))) / o_.g;
  }

  // --- Thresholds: displacements at which the mode changes -----------------------------------------------------

  /// What happens to a slider next while the mass moves in direction d, and where.
  T Threshold(std::size_t i, double d) const {
    const SliderState<T>& s = state_[i];
    if (s.hold == Hold::kLoose) return s.p + d * o_.gap;
    if (HasGap(i) && s.side != d) return s.p + s.side * o_.gap;  // unloads into the clearance
    return Neutral(i) + d * StickingLimit(i, t_, T(0));
  }

  bool BreaksOut(std::size_t i) const {
    return state_[i].hold == Hold::kSticks && (!HasGap(i) || state_[i].side == d_);
  }

  void PassThreshold(std::size_t i) {
    SliderState<T>& s = state_[i];
    if (s.hold == Hold::kLoose) {
      s.hold = Hold::kSticks;
      s.side = d_;
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
                                 ? Value(Neutral(i)) + d_ * Value(StickingLimit(i, t_, SpeedOf(v_, d_)))
                                 : Value(Threshold(i, d_));
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
      consider(i, Value(Threshold(i, d_)));
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
    const double limit = Value(StickingLimit(i, T(t), T(std::max(0.0, d_ * v))));
    return limit - d_ * (y - Value(Neutral(i)));
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
    const T reach = slider.joint ? T(slider.y_c * SlidingFactor(t, speed)) : slider.y_c;
    state_[i].p = y_ - d_ * (HasGap(i) ? T(reach + o_.gap) : reach);
    state_[i].hold = Hold::kSticks;
    state_[i].side = d_;
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
    const T reserve = o_.sliders.items()[i].y_c * factor - d_ * (y_ - Neutral(i));
    const double a = Value(Acceleration(forces, t_, y_, v_));
    const double drift = Value(DriftFactor(t_, d_));
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
    T damping = forces.B, centre = forces.C, moving{};
    if (forces.slides) {
      const T side = d_ * (T(1) + d_ * o_.asymmetry);
      const T at_start = T(1) + o_.drift * (t_ + clock_);
      centre -= forces.S * (side * at_start);
      moving = -(forces.S * (side * o_.drift));
      damping += forces.S * (o_.strengthening * (at_start * (T(1) + d_ * o_.asymmetry)));
    }
    ExtendedArc<T> arc{.t_start = t_, .t_end = duration_};
    auto& q = arc.q;
    q[1] = moving / forces.K;
    q[0] = (centre - damping * q[1]) / forces.K;
    q[5] = 0.5 * o_.g * damping;
    q[4] = sqrt(o_.g * forces.K - q[5] * q[5]);
    q[2] = y_ - q[0];
    q[3] = (v_ - q[1] + q[5] * q[2]) / q[4];
    return arc;
  }

  static ExtendedArc<double> ValueOf(const ExtendedArc<T>& arc) {
    ExtendedArc<double> value{.t_start = Value(arc.t_start), .t_end = arc.t_end, .length = arc.length};
    for (std::size_t j = 0; j < arc.q.size(); ++j) value.q[j] = Value(arc.q[j]);
    return value;
  }

  /// Time until the mass turns round [s].
  double FindTurning(const ExtendedArc<double>& arc) const {
    const auto& q = arc.q;
    const double cosine = q[4] * q[3] - q[5] * q[2];  // v = q1 + exp() (cosine cos - sine sin)
    const double sine = q[4] * q[2] + q[5] * q[3];
    double phase = std::atan2(d_ * cosine, d_ * sine);
    if (phase <= 0) phase += 2 * std::numbers::pi;
    double s = phase / q[4];
    if (q[1] == 0) return s;
    for (int i = 0; i < 20; ++i) {  // the centre moves slowly: two or three steps
      const double v = CalcVelocity(arc, s);
      const double swing = CalcDisplacement(arc, s) - q[0] - q[1] * s;
      const double a = -(q[4] * q[4] + q[5] * q[5]) * swing - 2 * q[5] * (v - q[1]);
      const double step = v / a;
      if (!std::isfinite(step)) break;
      s = std::max(0.0, s - std::clamp(step, -0.3 / q[4], 0.3 / q[4]));
      if (std::abs(step) < 1e-15) break;
    }
    return s;
  }

  /// First time at which a function that is positive at 0 is not, known to be not positive at s1.
  template <typename Function>
  static double FindZero(Function f, double s0, double f0, double s1, double f1) {
    for (int i = 0; i < 200 && s1 - s0 > 1e-16 + 4e-16 * s1; ++i) {
      double s = s0 + (s1 - s0) * f0 / (f0 - f1);
      if (!(i % 3 != 2 && s > s0 && s < s1)) s = 0.5 * (s0 + s1);
      const double value = f(s);
      if (value > 0) {
        s0 = s, f0 = value;
      } else {
        s1 = s, f1 = value;
      }
    }
    return s1;
  }

  /// First slider whose moving limit is reached before s_end; sets s_end.
  std::size_t FindMovingBreakout(const ExtendedArc<double>& arc, double* s_end) const {
    constexpr int kScans = 12;
    std::size_t found = o_.sliders.size() + o_.stops.size();
    if (!o_.has_drift && !o_.has_strengthening) return found;
    const double start = Value(t_);
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (!BreaksOut(i) || !LimitMoves(i)) continue;
      const auto reserve = [&](double s) {
        return MovingReserve(i, start + s, CalcDisplacement(arc, s), CalcVelocity(arc, s));
      };
      double before = 0, at_before = std::max(reserve(0), 1e-300);
      const double step = *s_end / kScans;
      for (int scan = 1; scan <= kScans; ++scan) {
        const double now = scan == kScans ? *s_end : scan * step;
        const double at_now = reserve(now);
        if (at_now < -kTiny * scale_) {
          *s_end = FindZero(reserve, before, at_before, now, at_now);
          found = i;
          break;
        }
        before = now, at_before = std::max(at_now, 1e-300);
      }
    }
    return found;
  }

  /// One arc and the event that ends it. @returns false at the end of the run.
  bool WalkClosedForm(const ModeForces<T>& forces) {
    const ExtendedArc<T> arc = MakeArc(forces);
    const ExtendedArc<double> value = ValueOf(arc);
    if (!std::isfinite(value.q[4]) || !(value.q[4] > 0) || !std::isfinite(value.q[3])) return failed_ = true, false;
    out_.Append(arc);
    const double left = duration_ - value.t_start;
    double s = FindTurning(value);
    bool turns = true;
    const Next next = FindNextThreshold();
    const double overshoot = d_ * (CalcDisplacement(value, s) - Value(y_)) - next.distance;
    if (overshoot > kTiny * scale_) {
      const auto reserve = [&](double at) { return d_ * (next.y - CalcDisplacement(value, at)); };
      s = next.distance == 0 ? 0 : FindZero(reserve, 0, next.distance, s, -overshoot);
      turns = false;
    }
    const std::size_t none = o_.sliders.size() + o_.stops.size();
    const std::size_t moving = FindMovingBreakout(value, &s);
    if (!(s < left)) return false;
    out_.back().t_end = value.t_start + s;
    t_ += s;
    y_ = CalcDisplacement(arc, T(s));
    v_ = CalcVelocity(arc, T(s));
    if (moving != none) {
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

  /// One step of Dormand and Prince (1980), order 5 with an error of order 4, from (t, y, v, a).
  Step<T> TakeStep(const ModeForces<T>& forces, const T& t, const T& y, const T& v, const T& a, double h) const {
    const T &v1 = v, &a1 = a;
    const auto accelerate = [&](double c, const T& yi, const T& vi) { return Acceleration(forces, t + c * h, yi, vi); };
    const T v2 = v + (h / 5) * a1;
    const T a2 = accelerate(1.0 / 5, y + (h / 5) * v1, v2);
    const T v3 = v + h * ((3.0 / 40) * a1 + (9.0 / 40) * a2);
    const T a3 = accelerate(3.0 / 10, y + h * ((3.0 / 40) * v1 + (9.0 / 40) * v2), v3);
    const T v4 = v + h * ((44.0 / 45) * a1 - (56.0 / 15) * a2 + (32.0 / 9) * a3);
    const T a4 = accelerate(4.0 / 5, y + h * ((44.0 / 45) * v1 - (56.0 / 15) * v2 + (32.0 / 9) * v3), v4);
    constexpr double b51 = 19372.0 / 6561, b52 = 25360.0 / 2187, b53 = 64448.0 / 6561, b54 = 212.0 / 729;
    const T v5 = v + h * (b51 * a1 - b52 * a2 + b53 * a3 - b54 * a4);
    const T a5 = accelerate(8.0 / 9, y + h * (b51 * v1 - b52 * v2 + b53 * v3 - b54 * v4), v5);
    constexpr double b61 = 9017.0 / 3168, b62 = 355.0 / 33, b63 = 46732.0 / 5247, b64 = 49.0 / 176,
                     b65 = 5103.0 / 18656;
    const T v6 = v + h * (b61 * a1 - b62 * a2 + b63 * a3 + b64 * a4 - b65 * a5);
    const T a6 = accelerate(1, y + h * (b61 * v1 - b62 * v2 + b63 * v3 + b64 * v4 - b65 * v5), v6);
    constexpr double b1 = 35.0 / 384, b3 = 500.0 / 1113, b4 = 125.0 / 192, b5 = 2187.0 / 6784, b6 = 11.0 / 84;
    Step<T> end;
    end.v = v + h * (b1 * a1 + b3 * a3 + b4 * a4 - b5 * a5 + b6 * a6);
    end.y = y + h * (b1 * v1 + b3 * v3 + b4 * v4 - b5 * v5 + b6 * v6);
    end.a = accelerate(1, end.y, end.v);
    constexpr double e1 = 71.0 / 57600, e3 = 71.0 / 16695, e4 = 71.0 / 1920, e5 = 17253.0 / 339200, e6 = 22.0 / 525,
                     e7 = 1.0 / 40;
    const auto mix = [](const T& x1, const T& x3, const T& x4, const T& x5, const T& x6, const T& x7) {
      return e1 * Value(x1) - e3 * Value(x3) + e4 * Value(x4) - e5 * Value(x5) + e6 * Value(x6) - e7 * Value(x7);
    };
    const double y_error = h * mix(v1, v3, v4, v5, v6, end.v);
    const double v_error = h * mix(a1, a3, a4, a5, a6, end.a);
    end.error = std::max(std::abs(y_error), std::abs(v_error) / frequency_);
    return end;
  }

  /// The quintic through (y, v, a) at both ends of a step.
  static ExtendedArc<T> Interpolate(const T& t, const T& y, const T& v, const T& a, const Step<T>& end, double h) {
    ExtendedArc<T> arc{.t_start = t, .t_end = Value(t) + h, .length = h};
    auto& q = arc.q;
    q[0] = y;
    q[1] = h * v;
    q[2] = (0.5 * h * h) * a;
    const T rise = end.y - q[0] - q[1] - q[2];
    const T slope = h * end.v - q[1] - 2.0 * q[2];
    const T bend = (0.5 * h * h) * end.a - q[2];
    q[3] = 10.0 * rise - 4.0 * slope + bend;
    q[4] = -15.0 * rise + 7.0 * slope - 2.0 * bend;
    q[5] = 6.0 * rise - 3.0 * slope + bend;
    return arc;
  }

  /// Margin of a sliding joint against sticking: d p', > 0 while it slides [m/s]. It sticks where its limit grows
  /// faster than the spring can follow. The slow growth by drift is left out: it would matter below y_c rate only.
  T SlidingMargin(const ModeForces<T>& forces, std::size_t i, const T& t, const T& y, const T& v) const {
    const T speed = SpeedOf(v, d_);
    T slope = o_.strengthening;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) slope += term.slope(term.p, speed);
    const T deceleration = -d_ * Acceleration(forces, t, y, v);
    return speed + o_.sliders.items()[i].y_c * slope * DriftFactor(t, d_) * deceleration;
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
  EventIn FindEvent(const ModeForces<T>& forces, const ExtendedArc<double>& arc, const Next& next, double* s,
                    std::size_t* which) const {
    EventIn event = EventIn::kNone;
    const double h = arc.length;
    *s = h;
    if (d_ * CalcVelocity(arc, h) <= 0) {
      const double start = d_ * arc.q[1] / h;
      *s = FindZero([&](double at) { return d_ * CalcVelocity(arc, at); }, start > 0 ? 0 : 1e-6 * h,
                    std::max(start, 1e-300), h, d_ * CalcVelocity(arc, h));
      event = EventIn::kTurning;
    }
    const auto reserve = [&](double at) { return d_ * (next.y - CalcDisplacement(arc, at)); };
    const double at_end = reserve(*s);
    if (next.exists() && at_end < (event == EventIn::kTurning ? -kTiny * scale_ : 0)) {
      *s = FindZero(reserve, 0, std::max(1e-300, reserve(0)), *s, at_end);
      *which = next.what;
      event = EventIn::kThreshold;
    }
    const std::size_t moving = FindMovingBreakout(arc, s);
    if (moving < o_.sliders.size()) {
      *which = moving;
      event = EventIn::kMoving;
    }
    if (o_.speed_terms.empty()) return event;
    for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
      if (state_[i].hold != Hold::kSlides || !ActsOn(i)) continue;
      const auto margin = [&](double at) {
        const T t(arc.t_start + at), y(CalcDisplacement(arc, at)), v(std::max(0.0, d_ * CalcVelocity(arc, at)) * d_);
        return Value(SlidingMargin(forces, i, t, y, v));
      };
      const double to = event == EventIn::kTurning ? 0.999 * *s : *s;  // at rest the margin is zero anyway
      if (margin(to) >= 0) continue;
      *s = FindZero(margin, 0, std::max(1e-300, margin(0)), to, margin(to));
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
      Step<T> end = TakeStep(forces, t_, y_, v_, a, h);
      const double error = end.error / (options_.tolerance * scale_);
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
      const EventIn event = FindEvent(forces, ValueOf(arc), next, &s, &which);
      if (event != EventIn::kNone) {
        if (s > 1e-12) {
          end = TakeStep(forces, t_, y_, v_, a, s);
          if (event == EventIn::kTurning) end = Polish(forces, a, end, &s);
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
  Step<T> Polish(const ModeForces<T>& forces, const T& a, Step<T> end, double* s) const {
    for (int i = 0; i < 3 && std::abs(Value(end.v)) > 1e-15 && std::abs(Value(end.a)) > kGraze; ++i) {
      const double better = *s - Value(end.v) / Value(end.a);
      if (!(better > 0 && better < 2 * *s)) break;
      *s = better;
      end = TakeStep(forces, t_, y_, v_, a, *s);
    }
    return end;
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

  const ExtendedOscillator<T>& o_;
  double clock_, duration_;
  ExtendedSolveOptions options_;
  ExtendedTrajectory<T>& out_;

  T t_{}, y_{}, v_{};
  double d_ = 1;
  double scale_ = 0;
  double frequency_ = 1, step_ = 0;  // of the integrator
  std::array<SliderState<T>, kMaxExtendedSliders> state_{};
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

}  // namespace

template <typename T>
T CalcDeflectionAtExtremum(const ExtendedOscillator<T>& o, std::size_t slider, const T& y0, double clock) {
  const ExtendedSlider<T>& s = o.sliders.items()[slider];
  if (!s.joint) return s.y_c;
  const double side = Value(y0) < 0 ? -1 : 1;
  T factor(1);
  if (!o.speed_terms.empty()) {
    T a = o.k * (side * y0);
    for (const ExtendedSlider<T>& other : o.sliders.items()) a += other.k * other.y_c;
    a = o.g * a;
    for (const SpeedTerm<T>& term : o.speed_terms.items()) factor += term.at_extremum(term.p, s.y_c, a);
  }
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
