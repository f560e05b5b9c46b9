#include "identify/extension.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace uiclink {

Extension::Extension(std::vector<const Effect*> effects) : effects_(std::move(effects)) {
  for (const Effect* effect : effects_) {
    if (effect->IsMechanical()) mechanical_ += static_cast<int>(effect->parameters.size());
    if (effect->stage != ReadingStage::kNone) readings_.push_back(effect);
    for (std::size_t p = 0; p < effect->parameters.size(); ++p) {
      const EffectParameter& parameter = effect->parameters[p];
      // What an inverse square has as its bounds change places.
      const double a = ToCoordinate(parameter, parameter.low), b = ToCoordinate(parameter, parameter.high);
      Unknown unknown{.effect = effect, .parameter = p, .low = std::min(a, b), .high = std::max(a, b)};
      if (!parameter.starts.empty() && parameter.start_scale == StartScale::kAbsolute && parameter.starts[0] != 0)
        unknown.scale = std::abs(ToCoordinate(parameter, parameter.starts[0]));
      assert(parameter.scope == Scope::kLink || !effect->IsMechanical());
      (parameter.scope == Scope::kLink ? shared_ : own_).push_back(unknown);
    }
  }
  std::stable_sort(readings_.begin(), readings_.end(),
                   [](const Effect* a, const Effect* b) { return a->stage < b->stage; });
}

bool Extension::Unknown::IsAtBound(double coordinate) const {
  const double neutral = ToCoordinate(Parameter(), effect->neutral);
  const auto at = [&](double bound) {
    if (parameter == 0 && bound == neutral) return false;
    return std::abs(coordinate - bound) < 1e-6 * std::min(high - low, std::abs(scale) * 1e3);
  };
  return at(low) || at(high);
}

bool Extension::Has(const Effect* effect) const {
  return std::find(effects_.begin(), effects_.end(), effect) != effects_.end();
}

Extension Extension::With(const Effect* effect) const {
  std::vector<const Effect*> effects = effects_;
  effects.push_back(effect);
  return Extension(effects);
}

Extension Extension::Without(const Effect* effect) const {
  std::vector<const Effect*> effects = effects_;
  std::erase(effects, effect);
  return Extension(effects);
}

namespace {

Extension::Range RangeOf(std::span<const Extension::Unknown> unknowns, const Effect* effect) {
  Extension::Range range;
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (unknowns[i].effect != effect) continue;
    if (range.size++ == 0) range.first = i;
  }
  return range;
}

double LawValue(const Extension::Unknown& unknown, double coordinate) {
  return unknown.Parameter().coordinate == Coordinate::kLog ? std::exp(coordinate) : coordinate;
}

}  // namespace

Extension::Range Extension::SharedOf(const Effect* effect) const { return RangeOf(shared_, effect); }
Extension::Range Extension::OwnOf(const Effect* effect) const { return RangeOf(own_, effect); }

LawValues Extension::CalcLawValues(const Effect* effect, std::span<const double> shared,
                                   std::span<const double> own) const {
  LawValues values(effect->parameters.size());
  for (std::size_t i = 0; i < shared_.size(); ++i)
    if (shared_[i].effect == effect) values[shared_[i].parameter] = LawValue(shared_[i], shared[i]);
  for (std::size_t i = 0; i < own_.size(); ++i)
    if (own_[i].effect == effect) values[own_[i].parameter] = LawValue(own_[i], own[i]);
  return values;
}

double ToCoordinate(const EffectParameter& parameter, double value) {
  switch (parameter.coordinate) {
    case Coordinate::kLog:
      return std::log(value);
    case Coordinate::kInverseSquare:
      return 1 / (value * value);
    case Coordinate::kLinear:
      break;
  }
  return value;
}

double FromCoordinate(const EffectParameter& parameter, double coordinate) {
  switch (parameter.coordinate) {
    case Coordinate::kLog:
      return std::exp(coordinate);
    case Coordinate::kInverseSquare:
      return 1 / std::sqrt(coordinate);
    case Coordinate::kLinear:
      break;
  }
  return coordinate;
}

double CalcSlope(const EffectParameter& parameter, double coordinate) {
  switch (parameter.coordinate) {
    case Coordinate::kLog:
      return std::exp(coordinate);
    case Coordinate::kInverseSquare:
      return -0.5 * std::pow(coordinate, -1.5);
    case Coordinate::kLinear:
      break;
  }
  return 1;
}

namespace {

/// Values of unknowns that both extensions have; neutral or middling ones for the others.
std::vector<double> ConvertUnknowns(std::span<const Extension::Unknown> from, std::span<const double> values,
                                    std::span<const Extension::Unknown> to) {
  std::vector<double> converted;
  for (const Extension::Unknown& unknown : to) {
    double value = 0;
    const auto same = [&](const Extension::Unknown& other) {
      return other.effect == unknown.effect && other.parameter == unknown.parameter;
    };
    const auto found = std::find_if(from.begin(), from.end(), same);
    if (found != from.end()) {
      value = values[static_cast<std::size_t>(found - from.begin())];
    } else if (unknown.parameter == 0) {
      value = ToCoordinate(unknown.Parameter(), unknown.effect->neutral);
    } else if (unknown.Parameter().coordinate == Coordinate::kLog) {
      value = 0.5 * (unknown.low + unknown.high);
    }
    converted.push_back(value);
  }
  return converted;
}

}  // namespace

ExtendedState Convert(const Extension& from, const ExtendedState& state, const Extension& to) {
  ExtendedState converted{.link = state.link, .shared = {}, .own = {}};
  converted.shared = ConvertUnknowns(from.shared(), state.shared, to.shared());
  for (std::size_t r = 0; r < state.link.starts.size(); ++r)
    converted.own.push_back(ConvertUnknowns(
        from.own(), state.own.empty() ? std::span<const double>{} : std::span<const double>(state.own[r]), to.own()));
  return converted;
}

ExtendedOscillator<double> MakeExtendedOscillator(const Oscillator<double>& link, const Extension& extension,
                                                  std::span<const double> shared) {
  ExtendedOscillator<double> oscillator = Extend(link);
  for (const Effect* effect : extension.effects()) {
    if (!effect->IsMechanical()) continue;
    effect->Extend<double>(extension.CalcLawValues(effect, shared, {}), &oscillator);
  }
  return oscillator;
}

}  // namespace uiclink
