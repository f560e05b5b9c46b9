#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <span>

#include "model/oscillator.h"
#include "model/scalar.h"

namespace uiclink {

/// A list of at most `capacity` items that needs no memory of its own.
template <typename Item, std::size_t capacity>
class FixedList {
 public:
  void Add(const Item& item) {
    assert(size_ < capacity);
    items_[size_++] = item;
  }
  std::span<const Item> items() const { return {items_.data(), size_}; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

 private:
  std::array<Item, capacity> items_{};
  std::size_t size_ = 0;
};

/// Parameters of one law of an effect, in the order of the effect.
inline constexpr std::size_t kMaxLawParameters = 4;
template <typename T>
using LawParameters = std::array<T, kMaxLawParameters>;

/// Where the mass is, as laws see it.
template <typename T>
struct Motion {
  T t{};  ///< [s], clock of the record
  T y{};  ///< displacement from the true origin [m]
  T v{};  ///< velocity [m/s]
};

/// A smooth force on the mass, per unit load: y''/g = ... + force(p, motion).  Smooth means: between two turning
/// points.
template <typename T>
struct ForceTerm {
  LawParameters<T> p{};
  T (*force)(const LawParameters<T>& p, const Motion<T>& motion) = nullptr;
};

/// A share of T0 that depends on the speed of the mass: a joint that slides has T0 (1 + ... + sliding(p, |v|)), one
/// that sticks breaks out at T0 (1 + ... + sticking(p)).
template <typename T>
struct SpeedTerm {
  LawParameters<T> p{};
  T (*sliding)(const LawParameters<T>& p, const T& speed) = nullptr;
  T (*slope)(const LawParameters<T>& p, const T& speed) = nullptr;  ///< d sliding / d speed [s/m]
  T (*sticking)(const LawParameters<T>& p) = nullptr;
  /// Square of the speed at which a joint that slides towards a turning point sticks before it, because its limit grows
  /// faster than the spring can follow [m^2/s^2]; 0 if it slides all the way. a: deceleration there [m/s^2] > 0,
  /// y_c = T0/k [m].
  T (*sticking_speed_squared)(const LawParameters<T>& p, const T& y_c, const T& a) = nullptr;
};

/// A one-sided linear stop: force -k (y - position) beyond it, above position > 0, below position < 0.
template <typename T>
struct Stop {
  T k{};         ///< [1/m], >= 0
  T position{};  ///< [m], not 0
};

/// A spring in series with dry friction, by its critical displacement, so that it vanishes smoothly with k.
template <typename T>
struct ExtendedSlider {
  T k{};              ///< stiffness [1/m], >= 0
  T y_c{};            ///< displacement at which it slides [m], >= 0; T0 = k y_c
  bool joint = true;  ///< a joint of the link: drift, asymmetry, speed and clearance act on it
};

inline constexpr std::size_t kMaxExtendedSliders = 32;

/// The mass on its link with all that effects add to it, per unit load:
///
///   y''/g = -k y - c y' - T_r sign(y') - sum_i k_i S(y - p_i) + stops + forces
///
/// S is the identity, or a dead zone of +-gap for joints with clearance.  Joint i sticks (p_i at rest) while
/// |S| < y_c,i L and slides with |S| = y_c,i L;
///   L = (1 + rate t)(1 + d asymmetry)(1 + b |v| + speed terms),  d the direction of sliding, t the record's clock.
/// Sliders that are no joints have L = 1 and no clearance.
template <typename T>
struct ExtendedOscillator {
  T k{};                      ///< main (pendulum) stiffness [1/m], > 0
  double g = kThesisGravity;  ///< [m/s^2]
  FixedList<ExtendedSlider<T>, kMaxExtendedSliders> sliders;

  T damping{};        ///< c [s/m]
  T rolling{};        ///< T_r [-]: dry friction on the mass itself, holds it at rest where it can
  T gap{};            ///< half the clearance of every joint [m]
  T drift{};          ///< rate [1/s]
  T asymmetry{};      ///< [-]
  T strengthening{};  ///< b [s/m]
  FixedList<Stop<T>, 2> stops;
  FixedList<ForceTerm<T>, 4> forces;
  FixedList<SpeedTerm<T>, 2> speed_terms;

  bool has_rolling = false;  ///< what is there at all, be its value zero: a derivative at zero is wanted too
  bool has_gap = false;
  bool has_drift = false;
  bool has_strengthening = false;
};

/// The plain link as the one to be extended.
template <typename T>
ExtendedOscillator<T> Extend(const Oscillator<T>& plain) {
  ExtendedOscillator<T> extended;
  extended.k = plain.k;
  extended.g = plain.g;
  for (const Slider<T>& s : plain.sliders()) extended.sliders.Add({.k = s.k, .y_c = s.T0 / s.k, .joint = true});
  return extended;
}

}  // namespace uiclink
