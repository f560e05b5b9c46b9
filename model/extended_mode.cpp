#include "model/extended_mode.h"

#include "model/extremum_deflection.h"

namespace uiclink {
namespace {

/// How far the mass is beyond a stop, > 0 in contact.
template <typename T>
double Beyond(const Stop<T>& stop, double y) {
  const double position = Value(stop.position);
  return position > 0 ? y - position : position - y;
}

}  // namespace

template <typename T>
ExtendedMode<T>::ExtendedMode(const ExtendedOscillator<T>& oscillator, const T& y0, double clock)
    : o_(oscillator),
      clock_(clock),
      d_(Value(y0) < 0 ? -1 : 1),
      damped_(o_.has_strengthening || !IsAbsent(o_.damping)),
      asymmetric_(!IsAbsent(o_.asymmetry)),
      limits_vary_(o_.has_drift || o_.has_strengthening || !o_.speed_terms.empty()) {
  for (const SpeedTerm<T>& term : o_.speed_terms.items()) sticking_share_ += term.sticking(term.p);
  const auto sliders = o_.sliders.items();
  for (std::size_t i = 0; i < sliders.size(); ++i) {
    slip_[i] = sliders[i].k * sliders[i].y_c;
    state_[i].p = y0 - d_ * CalcDeflectionAtExtremum(o_, i, y0, clock);
    state_[i].side = d_;
    Load(i);
  }
  const auto stops = o_.stops.items();
  for (std::size_t i = 0; i < stops.size(); ++i) stop_active_[i] = Beyond(stops[i], Value(y0)) > 0;
}

/// Brings what follows from the position and the side of a slider that does not slide up to date.
template <typename T>
void ExtendedMode<T>::Load(std::size_t i) {
  SliderState& s = state_[i];
  s.neutral = HasGap(i) ? T(s.p + s.side * o_.gap) : s.p;
  s.load = o_.sliders.items()[i].k * s.neutral;
}

// --- Forces ------------------------------------------------------------------------------------------------------

template <typename T>
ModeForces<T> ExtendedMode<T>::CalcForces(const T& t) const {
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
    forces.C -= asymmetric_ ? T(d_ * (forces.S * DriftFactor(t))) : T(d_ * forces.S);
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

template <typename T>
bool ExtendedMode<T>::IsAffine(const ModeForces<T>& forces) const {
  if (!o_.forces.empty()) return false;
  return !forces.slides || (o_.speed_terms.empty() && !(o_.has_drift && o_.has_strengthening));
}

template <typename T>
bool ExtendedMode<T>::StartFromRest(const T& t, const T& y) {
  ModeForces<T> forces = CalcForces(t);
  if (o_.has_rolling) forces.C += d_ * o_.rolling;  // without the friction of rolling
  const double force = Value(CalcAcceleration(forces, t, y, T(0))) / o_.g;
  if (force != 0) d_ = force > 0 ? 1 : -1;
  return force != 0 && !(o_.has_rolling && std::abs(force) <= Value(o_.rolling));
}

// --- Thresholds --------------------------------------------------------------------------------------------------

/// Where something happens to a slider next while the mass moves on [m].
template <typename T>
double ExtendedMode<T>::Threshold(std::size_t i, double t) const {
  const SliderState& s = state_[i];
  const double gap = Value(o_.gap);
  if (s.hold == Hold::kLoose) return Value(s.p) + d_ * gap;
  if (HasGap(i) && s.side != d_) return Value(s.p) + s.side * gap;  // unloads into the clearance
  return Value(s.neutral) + d_ * StickingLimitValue(i, t, 0);
}

template <typename T>
void ExtendedMode<T>::PassThreshold(std::size_t i) {
  SliderState& s = state_[i];
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

template <typename T>
void ExtendedMode<T>::SettleAtLimits(const T& t, const T& y, const T& v, double tiny) {
  for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
    for (int pass = 0; pass < 3 && state_[i].hold != Hold::kSlides; ++pass) {
      const double limit = BreaksOut(i) && LimitMoves(i)
                               ? Value(state_[i].neutral) + d_ * StickingLimitValue(i, Value(t), d_ * Value(v))
                               : Threshold(i, Value(t));
      if (d_ * (limit - Value(y)) > tiny) break;
      PassThreshold(i);
    }
  }
}

template <typename T>
typename ExtendedMode<T>::Next ExtendedMode<T>::FindNextThreshold(const T& t, const T& y) const {
  Next next;
  const auto consider = [&](std::size_t what, double threshold) {
    const double distance = d_ * (threshold - Value(y));
    if (distance < next.distance) next = {.what = what, .distance = std::max(0.0, distance), .y = threshold};
  };
  for (std::size_t i = 0; i < o_.sliders.size(); ++i) {
    if (state_[i].hold == Hold::kSlides || (BreaksOut(i) && LimitMoves(i))) continue;
    consider(i, Threshold(i, Value(t)));
  }
  const auto stops = o_.stops.items();
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const double position = Value(stops[i].position);
    const bool away = position * d_ < 0;
    if (stop_active_[i] == away) consider(o_.sliders.size() + i, position);
  }
  return next;
}

template <typename T>
void ExtendedMode<T>::Pass(std::size_t what) {
  const std::size_t sliders = o_.sliders.size();
  if (what >= sliders) {
    stop_active_[what - sliders] = !stop_active_[what - sliders];
  } else {
    PassThreshold(what);
  }
}

template <typename T>
void ExtendedMode<T>::Stick(std::size_t i, const T& t, const T& y, const T& speed) {
  const ExtendedSlider<T>& slider = o_.sliders.items()[i];
  const bool varies = slider.joint && (limits_vary_ || asymmetric_);
  const T reach = varies ? T(slider.y_c * SlidingFactor(t, speed)) : slider.y_c;
  state_[i].p = y - d_ * (HasGap(i) ? T(reach + o_.gap) : reach);
  state_[i].hold = Hold::kSticks;
  state_[i].side = d_;
  Load(i);
}

template <typename T>
void ExtendedMode<T>::StickAll(const T& t, const T& y) {
  for (std::size_t i = 0; i < o_.sliders.size(); ++i)
    if (state_[i].hold == Hold::kSlides) Stick(i, t, y, T(0));
}

// --- Limits that move --------------------------------------------------------------------------------------------

template <typename T>
typename ExtendedMode<T>::Crossing ExtendedMode<T>::CalcBreakout(std::size_t i, const T& t, const T& y, const T& v,
                                                                 double a) const {
  const T factor = (T(1) + o_.strengthening * (d_ * v) + sticking_share_) * DriftFactor(t);
  const double drift = DriftFactorValue(Value(t));
  const double growth = drift * Value(o_.strengthening) * d_ * a +
                        Value(factor) / drift * Value(o_.drift) * (1 + d_ * Value(o_.asymmetry));
  const ExtendedSlider<T>& slider = o_.sliders.items()[i];
  return {.guard = slider.y_c * factor - d_ * (y - state_[i].neutral),
          .rate = Value(slider.y_c) * growth - d_ * Value(v)};
}

template class ExtendedMode<double>;
template class ExtendedMode<Dual<6>>;
template class ExtendedMode<Dual<8>>;
template class ExtendedMode<Dual<12>>;
template class ExtendedMode<Dual<16>>;

}  // namespace uiclink
