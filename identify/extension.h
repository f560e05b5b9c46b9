#pragma once

#include <array>
#include <cassert>
#include <span>
#include <string>
#include <vector>

#include "identify/fit_problem.h"
#include "model/effect.h"
#include "model/extended_oscillator.h"

namespace uiclink {

/// Most parameters of an effect: those of a reading, which a Dual<6> carries beside its input.
inline constexpr std::size_t kMostParameters = 5;

/// Values of an effect's parameters as its laws are given them, in the order of the effect. Needs no memory of its own:
/// every evaluation of a fit asks for them.
class LawValues {
 public:
  explicit LawValues(std::size_t size) : size_(size) { assert(size <= kMostParameters); }

  std::size_t size() const { return size_; }
  double operator[](std::size_t i) const { return values_[i]; }
  double& operator[](std::size_t i) { return values_[i]; }
  operator std::span<const double>() const { return {values_.data(), size_}; }  // NOLINT(google-explicit-constructor)

 private:
  std::array<double, kMostParameters> values_{};
  std::size_t size_;
};

/// The plain model with effects added to it: which unknowns it has beside those of the link.
///   shared  parameters of Scope::kLink, effect after effect, in the coordinates of the fit
///   own     parameters of Scope::kRecord, the same
class Extension {
 public:
  /// Place of one parameter among the unknowns.
  struct Unknown {
    const Effect* effect = nullptr;
    std::size_t parameter = 0;  ///< of the effect
    double low = 0, high = 0;   ///< bounds, in coordinates
    double scale = 1;           ///< a typical value, in coordinates

    const EffectParameter& Parameter() const { return effect->parameters[parameter]; }
    /// A fit that ended there at a bound that is not the neutral value: the data do not want the effect as it is.
    bool IsAtBound(double coordinate) const;
  };

  Extension() = default;
  explicit Extension(std::vector<const Effect*> effects);

  std::span<const Effect* const> effects() const { return effects_; }
  std::span<const Unknown> shared() const { return shared_; }
  std::span<const Unknown> own() const { return own_; }
  bool empty() const { return effects_.empty(); }
  bool Has(const Effect* effect) const;
  /// Effects that act on the mechanics have this many parameters.
  int CountMechanical() const { return mechanical_; }
  /// Effects on the reading, in the order in which they act.
  std::span<const Effect* const> readings() const { return readings_; }

  /// The same with one more.
  Extension With(const Effect* effect) const;
  Extension Without(const Effect* effect) const;

  /// Number of the first unknown of an effect among shared() or own(), and how many it has there.
  struct Range {
    std::size_t first = 0, size = 0;
  };
  Range SharedOf(const Effect* effect) const;
  Range OwnOf(const Effect* effect) const;

  /// @param own  may be empty for an effect without parameters of Scope::kRecord.
  LawValues CalcLawValues(const Effect* effect, std::span<const double> shared, std::span<const double> own) const;

 private:
  std::vector<const Effect*> effects_, readings_;
  std::vector<Unknown> shared_, own_;
  int mechanical_ = 0;
};

/// Coordinate of the fit for a value of a parameter, and back. Infinite lengths are 0 in Coordinate::kInverseSquare.
double ToCoordinate(const EffectParameter& parameter, double value);
double FromCoordinate(const EffectParameter& parameter, double coordinate);
/// d value / d coordinate.
double CalcSlope(const EffectParameter& parameter, double coordinate);

/// Unknowns of an extended fit.
struct ExtendedState {
  FitState link;
  std::vector<double> shared;
  std::vector<std::vector<double>> own;  ///< one per record
};

/// Takes over a state of another extension of the same records: unknowns that both have keep their values; an effect
/// that is new starts at its neutral value.
ExtendedState Convert(const Extension& from, const ExtendedState& state, const Extension& to);

/// The oscillator of a state, all effects on the mechanics included.
ExtendedOscillator<double> MakeExtendedOscillator(const Oscillator<double>& link, const Extension& extension,
                                                  std::span<const double> shared);

}  // namespace uiclink
