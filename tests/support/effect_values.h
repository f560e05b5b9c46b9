#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/effect.h"

namespace uiclink {

/// What start values of effects are multiples of, for one free decay.
struct Scales {
  double swing = 0.025;  ///< [m]
  double speed = 0.18;   ///< [m/s]
};

/// Values of the parameters as laws and readings are given them: the first starts of the catalogue, the size `share` of
/// its own; share 0 gives the neutral value. Frequencies are the geometric mean of their bounds.
inline std::vector<double> MakeEffectValues(const Effect& effect, double share, const Scales& scales = {}) {
  std::vector<double> values;
  for (const EffectParameter& p : effect.parameters) {
    double value = p.starts.empty() ? std::sqrt(p.low * p.high) : p.starts.front();
    if (p.start_scale == StartScale::kSwing) value *= scales.swing;
    if (p.start_scale == StartScale::kSpeed) value *= scales.speed;
    if (p.coordinate == Coordinate::kInverseSquare) value = 1 / (value * value);
    values.push_back(value);
  }
  const std::size_t sizes = effect.quadrature ? 2 : 1;
  for (std::size_t i = 0; i < sizes; ++i) {
    const bool level = std::isinf(effect.neutral) && effect.parameters[i].coordinate == Coordinate::kLinear;
    values[i] = level ? values[i] / share : values[i] * share;  // a level vanishes at infinity
  }
  return values;
}

/// The extended oscillator with an effect at these values.
template <typename T>
ExtendedOscillator<T> With(ExtendedOscillator<T> oscillator, const Effect& effect, const std::vector<T>& values) {
  effect.Extend<T>(values, &oscillator);
  return oscillator;
}

}  // namespace uiclink
