#include "model/extended_link.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>

#include "model/effect.h"

namespace uiclink {
namespace {

[[noreturn]] void Fail(const std::string& what) { throw std::invalid_argument("MakeExtendedOscillator: " + what); }

const Effect& Find(const EffectValues& values) {
  const Effect* effect = FindEffect(values.id);
  if (effect == nullptr) Fail("expected an effect of the catalogue, found \"" + values.id + "\"");
  return *effect;
}

double FindValue(const EffectValues& values, const EffectParameter& parameter) {
  const auto is_it = [&](const auto& value) { return value.first == parameter.symbol; };
  const std::string name = values.id + ": " + std::string(parameter.symbol);
  const auto found = std::find_if(values.parameters.begin(), values.parameters.end(), is_it);
  if (found == values.parameters.end()) Fail(name + ": expected a value, found none");
  if (std::count_if(values.parameters.begin(), values.parameters.end(), is_it) > 1) Fail(name + " is given twice");
  if (!(found->second >= parameter.low && found->second <= parameter.high))
    Fail(name + ": expected from " + std::to_string(parameter.low) + " to " + std::to_string(parameter.high) +
         ", found " + std::to_string(found->second));
  return found->second;
}

/// Values as the law of an effect is given them.
std::array<double, kMaxLawParameters> FindLawValues(const EffectValues& values, const Effect& effect) {
  for (const auto& [symbol, value] : values.parameters)
    if (std::none_of(effect.parameters.begin(), effect.parameters.end(),
                     [&, name = std::string_view(symbol)](const auto& p) { return p.symbol == name; }))
      Fail(values.id + ": has no parameter \"" + symbol + "\"");
  std::array<double, kMaxLawParameters> p{};
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    p[i] = FindValue(values, effect.parameters[i]);
    if (effect.parameters[i].coordinate == Coordinate::kInverseSquare) p[i] = 1 / (p[i] * p[i]);
  }
  return p;
}

template <typename Item, std::size_t capacity>
bool HasRoom(const FixedList<Item, capacity>& list, const FixedList<Item, capacity>& more) {
  return list.size() + more.size() <= capacity;
}

/// Adds an effect after a rehearsal on an empty oscillator: its lists hold no more than they are made for.
template <typename T>
void Add(const Effect& effect, std::span<const T> p, ExtendedOscillator<T>* oscillator) {
  ExtendedOscillator<T> alone;
  effect.Extend<T>(p, &alone);
  if (!HasRoom(oscillator->sliders, alone.sliders) || !HasRoom(oscillator->forces, alone.forces) ||
      !HasRoom(oscillator->stops, alone.stops) || !HasRoom(oscillator->speed_terms, alone.speed_terms))
    Fail("no room for " + std::string(effect.id) + " beside the sliders and effects before it");
  effect.Extend<T>(p, oscillator);
}

void CheckPlain(const DirectionParameters& parameters, double g) {
  if (!(g > 0 && std::isfinite(g))) Fail("g must be positive");
  if (!(parameters.k > 0 && std::isfinite(parameters.k))) Fail("k must be positive");
  for (const Slider<double>& s : parameters.sliders)
    if (!(s.k >= 0 && s.T0 >= 0 && std::isfinite(s.k) && std::isfinite(s.T0)))
      Fail("sliders must have k >= 0 and T0 >= 0");
}

}  // namespace

template <typename T>
ExtendedOscillator<T> MakeExtendedOscillator(const DirectionParameters& parameters, double g) {
  CheckPlain(parameters, g);
  const Oscillator<double> plain = MakeOscillator(parameters, g);
  ExtendedOscillator<T> oscillator;
  oscillator.k = T(plain.k);
  oscillator.g = g;
  for (const Slider<double>& s : plain.sliders())  // one without spring or without friction has no force
    oscillator.sliders.Add({.k = T(s.T0 > 0 ? s.k : 0.0), .y_c = T(s.k > 0 ? s.T0 / s.k : 0.0), .joint = true});
  for (const EffectValues& values : parameters.effects) {
    const Effect& effect = Find(values);
    if (!effect.IsMechanical()) continue;
    const std::array<double, kMaxLawParameters> law_values = FindLawValues(values, effect);
    const EffectParameter& size = effect.parameters.front();
    if (FindValue(values, size) == effect.neutral) continue;
    std::array<T, kMaxLawParameters> p{};
    for (std::size_t i = 0; i < p.size(); ++i) p[i] = T(law_values[i]);
    Add<T>(effect, {p.data(), effect.parameters.size()}, &oscillator);
  }
  return oscillator;
}

template ExtendedOscillator<double> MakeExtendedOscillator<double>(const DirectionParameters&, double);
template ExtendedOscillator<Dual<6>> MakeExtendedOscillator<Dual<6>>(const DirectionParameters&, double);

}  // namespace uiclink
