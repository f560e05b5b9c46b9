#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "model/dual_sum.h"
#include "model/extended_oscillator.h"

namespace uiclink {

/// The force between two events:  y''/g = C - K y - B v - d S F(t, |v|) + forces,  F the joints' friction factor L.
template <typename T>
struct ModeForces {
  T K{}, B{}, C{};
  T S{};                ///< sum of k y_c of sliding joints [-]
  bool slides = false;  ///< any joint slides, and its friction changes: a constant one is in C
};

/// What sticks, slides, or is loose, which stops are touched, and where that changes next. Knows the direction of the
/// motion, but not where the mass is: times t [s] are since the start of the run.  One object lives for one run of the
/// extended solver, and refers to the oscillator.
template <typename T>
class ExtendedMode {
 public:
  /// At an extremum at y0 [m], not 0, that all sliders reached sliding.
  /// @param clock  the record's clock at t = 0 [s]
  ExtendedMode(const ExtendedOscillator<T>& oscillator, const T& y0, double clock);

  double direction() const { return d_; }  ///< d of the motion, at rest of the one before: +1 or -1
  bool damped() const { return damped_; }
  bool asymmetric() const { return asymmetric_; }
  bool BreaksOut(std::size_t i) const {  ///< a slider that sticks, and slides next if the mass moves on
    return state_[i].hold == Hold::kSticks && (!HasGap(i) || state_[i].side == d_);
  }
  bool SlidesAsJoint(std::size_t i) const { return state_[i].hold == Hold::kSlides && IsJoint(i); }
  /// The limit of a joint that sticks changes while it sticks.
  bool LimitMoves(std::size_t i) const { return IsJoint(i) && (o_.has_drift || o_.has_strengthening); }

  // --- Forces

  ModeForces<T> CalcForces(const T& t) const;
  /// The motion has a closed form.
  bool IsAffine(const ModeForces<T>& forces) const;
  T CalcAcceleration(const ModeForces<T>& forces, const T& t, const T& y, const T& v) const;

  /// Takes the direction of the motion that starts from rest. @returns false where none does.
  bool StartFromRest(const T& t, const T& y);

  // --- Thresholds: displacements at which the mode changes

  /// A slider or (numbers beyond these) a stop, and how far away its threshold is.
  struct Next {
    std::size_t what = 0;
    double distance = std::numeric_limits<double>::infinity();  ///< [m], >= 0
    double y = 0;                                               ///< [m]

    bool exists() const { return distance < std::numeric_limits<double>::infinity(); }
  };
  /// The next one while the mass moves on; moving limits are not among them.
  Next FindNextThreshold(const T& t, const T& y) const;
  void Pass(std::size_t what);
  /// Everything closer than `tiny` [m] to its threshold changes already now.
  void SettleAtLimits(const T& t, const T& y, const T& v, double tiny);
  /// A slider stops sliding at this speed [m/s].
  void Stick(std::size_t i, const T& t, const T& y, const T& speed);
  /// All stop sliding: the mass turns round.
  void StickAll(const T& t, const T& y);

  // --- Limits that move

  /// Reserve of a slider whose limit moves: > 0 while it sticks [m].
  double MovingReserve(std::size_t i, double t, double y, double v) const {
    return StickingLimitValue(i, t, std::max(0.0, d_ * v)) - d_ * (y - Value(state_[i].neutral));
  }

  /// A guard at its zero, and by what it grows.
  struct Crossing {
    T guard{};        ///< [m]
    double rate = 0;  ///< [m/s]
  };
  /// The same reserve with its derivatives, where the acceleration is a [m/s^2].
  Crossing CalcBreakout(std::size_t i, const T& t, const T& y, const T& v, double a) const;

  /// Margin of a sliding joint against sticking: d p', > 0 while it slides [m/s]. It sticks where its limit grows
  /// faster than the spring can follow. The slow growth by drift is left out: it would matter below y_c rate only.
  T CalcSlidingMargin(const ModeForces<T>& forces, std::size_t i, const T& t, const T& y, const T& v) const {
    const T speed = d_ * v;
    T slope = o_.strengthening;
    for (const SpeedTerm<T>& term : o_.speed_terms.items()) slope += term.slope(term.p, speed);
    const T deceleration = -d_ * CalcAcceleration(forces, t, y, v);
    return speed + o_.sliders.items()[i].y_c * slope * DriftFactor(t) * deceleration;
  }

 private:
  /// What a slider does.
  enum class Hold : std::uint8_t {
    kSticks,  ///< its spring is loaded or slack-free
    kLoose,   ///< within its clearance: no force
    kSlides,
  };

  struct SliderState {
    T p{};        ///< position of the slider [m], while it does not slide
    T neutral{};  ///< where its spring has no force [m], while it does not slide
    T load{};     ///< k times that [-]
    Hold hold = Hold::kSticks;
    double side = 1;  ///< end of the clearance at which the spring is engaged
  };

  bool IsJoint(std::size_t i) const { return o_.sliders.items()[i].joint; }
  bool HasGap(std::size_t i) const { return o_.has_gap && IsJoint(i); }

  /// Factor of T0 by drift and asymmetry.
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

  /// Displacement at which a slider that sticks breaks out [m].
  double StickingLimitValue(std::size_t i, double t, double speed) const {
    const ExtendedSlider<T>& slider = o_.sliders.items()[i];
    if (!slider.joint) return Value(slider.y_c);
    return Value(slider.y_c) * (1 + Value(o_.strengthening) * speed + Value(sticking_share_)) * DriftFactorValue(t);
  }

  void Load(std::size_t i);
  double Threshold(std::size_t i, double t) const;
  void PassThreshold(std::size_t i);

  const ExtendedOscillator<T>& o_;
  double clock_;
  double d_ = 1;
  std::array<SliderState, kMaxExtendedSliders> state_{};
  std::array<T, kMaxExtendedSliders> slip_{};  // k y_c [-]
  T sticking_share_{};                         // of the limits of joints that stick, by their speed terms
  bool damped_ = false, asymmetric_ = false;   // be it by a derivative only
  bool limits_vary_ = false;                   // limits of joints change with time or speed
  std::array<bool, 2> stop_active_{};
};

template <typename T>
T ExtendedMode<T>::CalcAcceleration(const ModeForces<T>& forces, const T& t, const T& y, const T& v) const {
  const double g = o_.g, K = Value(forces.K), B = Value(forces.B), y_value = Value(y), v_value = Value(v);
  const double linear = g * (Value(forces.C) - K * y_value - B * v_value);
  T a = damped_
            ? Propagate<T>(
                  linear, {{g, forces.C}, {-g * K, y}, {-g * y_value, forces.K}, {-g * B, v}, {-g * v_value, forces.B}})
            : Propagate<T>(linear, {{g, forces.C}, {-g * K, y}, {-g * y_value, forces.K}});
  if (forces.slides) a -= (g * d_) * (forces.S * SlidingFactor(t, T(d_ * v)));
  if (o_.forces.empty()) return a;
  const Motion<T> motion{.t = t + clock_, .y = y, .v = v};
  for (const ForceTerm<T>& term : o_.forces.items()) a = Sum<T>({{1, a}, {g, term.force(term.p, motion)}});
  return a;
}

}  // namespace uiclink
