#pragma once

#include <array>
#include <cassert>
#include <span>

#include "model/parameter_set.h"
#include "model/scalar.h"
#include "model/slider.h"

namespace uiclink {

/// Most sliders that a link can have: four of the thesis and room for the sliders that effects add.
inline constexpr int kMaxSliders = 16;

/// The mass on its link in one direction, per unit load: y'' / g = -k y + sum T_i.  Constant during a run.
template <typename Scalar>
class Oscillator {
 public:
  Scalar k{};                 ///< main (pendulum) stiffness [1/m], > 0
  double g = kThesisGravity;  ///< acceleration of gravity [m/s^2], > 0

  std::span<const Slider<Scalar>> sliders() const { return {sliders_.data(), static_cast<std::size_t>(size_)}; }
  std::span<Slider<Scalar>> sliders() { return {sliders_.data(), static_cast<std::size_t>(size_)}; }
  int size() const { return size_; }  ///< number of sliders

  void Add(const Slider<Scalar>& slider) {
    assert(size_ < kMaxSliders);
    sliders_[static_cast<std::size_t>(size_++)] = slider;
  }

 private:
  std::array<Slider<Scalar>, kMaxSliders> sliders_{};
  int size_ = 0;
};

/// Position, velocity and slider forces of the mass.
template <typename Scalar>
struct State {
  Scalar y{};                           ///< displacement from the true origin [m]
  Scalar v{};                           ///< velocity y' [m/s]
  std::array<Scalar, kMaxSliders> T{};  ///< force of each slider on the mass per unit load [-], |T_i| <= T0i
};

/// The oscillator of one direction of a parameter set.
/// @throws std::invalid_argument when the set has more than kMaxSliders sliders.
Oscillator<double> MakeOscillator(const DirectionParameters& parameters, double g);

/// The same oscillator, each parameter carrying its own derivative: k is number 0, then k1..kn, then T01..T0n
/// (the order of ParameterSymbols).
template <int N>
Oscillator<Dual<N>> WithDerivatives(const Oscillator<double>& oscillator) {
  const int n = oscillator.size();
  assert(1 + 2 * n <= N);
  Oscillator<Dual<N>> dual;
  dual.g = oscillator.g;
  dual.k = Dual<N>(oscillator.k, 0);
  for (int i = 0; i < n; ++i) {
    const Slider<double>& slider = oscillator.sliders()[static_cast<std::size_t>(i)];
    dual.Add({.k = Dual<N>(slider.k, 1 + i), .T0 = Dual<N>(slider.T0, 1 + n + i)});
  }
  return dual;
}

/// At rest at y0, every slider loaded against the way back: T_i = -sign(y0) T0i.  So stands a free decay at an extremum
/// that all joints reached sliding, which leaves no hidden start state.
template <typename Scalar>
State<Scalar> AtExtremum(const Oscillator<Scalar>& oscillator, const Scalar& y0) {
  State<Scalar> state{.y = y0};
  const double sign = Value(y0) < 0 ? -1.0 : 1.0;
  for (std::size_t i = 0; i < oscillator.sliders().size(); ++i) state.T[i] = -sign * oscillator.sliders()[i].T0;
  return state;
}

}  // namespace uiclink
