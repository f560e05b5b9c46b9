#pragma once

#include <span>
#include <string_view>
#include <tuple>
#include <vector>

#include "model/extended_oscillator.h"
#include "model/scalar.h"

namespace uiclink {

/// Where an effect acts.
enum class ActsOn { kForce, kFrictionLaw, kStiffness, kMeasurement };
std::string_view Name(ActsOn acts_on);

/// Who has a value of a parameter in common.
enum class Scope {
  kLink,    ///< all records
  kRecord,  ///< each record has its own (a phase, the drift of a zero)
};

/// In which coordinate a parameter is fitted. Laws are given the value itself, except for kInverseSquare.
enum class Coordinate {
  kLinear,
  kLog,            ///< positive
  kInverseSquare,  ///< 1/value^2: zero where a length is infinite; laws are given 1/value^2
};

/// What start values of a parameter are multiples of.
enum class StartScale {
  kAbsolute,  ///< the unit of the parameter
  kSwing,     ///< largest displacement of the free decay [m]
  kSpeed,     ///< largest speed of the free decay [m/s]
  kSpectrum,  ///< lines of the spectrum of the residuals [Hz]; `starts` is not used
};

struct EffectParameter {
  std::string_view symbol;   ///< key in a parameter set
  std::string_view unit;     ///< SI, "-" for none
  std::string_view meaning;  ///< a few words
  double low = 0;            ///< physical bounds: what lies outside is no suspension; of the size, low may be neutral
  double high = 0;
  Scope scope = Scope::kLink;
  Coordinate coordinate = Coordinate::kLinear;
  StartScale start_scale = StartScale::kAbsolute;
  /// Where a search starts. The first parameter is the size: its first start is a size that shows clearly in a record.
  std::vector<double> starts = {};
};

/// What an engineer would look for.
struct Signature {
  std::string_view text;
  double loss_exponent = 0;     ///< energy loss per cycle ~ amplitude^p while all joints roll; 0: loses nothing
  bool even_harmonics = false;  ///< the two sides of the motion differ
};

/// The law of an effect on the mechanics: adds its part to the oscillator. One function for each scalar.
template <typename T>
using ExtendFunction = void (*)(std::span<const T> p, ExtendedOscillator<T>* oscillator);
using LawTable = std::tuple<ExtendFunction<double>, ExtendFunction<Dual<6>>, ExtendFunction<Dual<8>>,
                            ExtendFunction<Dual<12>>, ExtendFunction<Dual<16>>>;
template <template <typename> class Law>
constexpr LawTable MakeLaw() {
  return {&Law<double>::Extend, &Law<Dual<6>>::Extend, &Law<Dual<8>>::Extend, &Law<Dual<12>>::Extend,
          &Law<Dual<16>>::Extend};
}

/// In which order effects act on the reading.
enum class ReadingStage {
  kNone,     ///< no effect on the reading
  kSensed,   ///< what else moves at the sensor, added to the displacement [m]
  kCurve,    ///< the sensor's curve: displacement -> reading, both without the zero offset
  kAdded,    ///< added to the reading
  kClipped,  ///< what the converter does to the reading, zero offset included
};
/// The reading [m] for what comes in from the stage before. t is the record's clock [s]; `fit_start` its value where
/// the fit begins. Dual<6> carries the derivatives by the input and by up to five parameters.
template <typename T>
using ReadFunction = T (*)(std::span<const T> p, double t, double fit_start, const T& input);
using ReadTable = std::tuple<ReadFunction<double>, ReadFunction<Dual<6>>>;
template <template <typename> class Reading>
constexpr ReadTable MakeReading() {
  return {&Reading<double>::Read, &Reading<Dual<6>>::Read};
}

/// Something that the plain model lacks.  The effect vanishes where its size, the first parameter (with
/// `quadrature`: the first two), is neutral, whatever the others are.
struct Effect {
  std::string_view id;
  std::string_view title;
  std::string_view equation;
  ActsOn acts_on = ActsOn::kForce;
  std::vector<EffectParameter> parameters;
  double neutral = 0;  ///< of the size
  /// The first two parameters are the cosine and sine parts of one amplitude, told as "A".
  bool quadrature = false;
  Signature signature;
  std::string_view confused_with;  ///< in words
  std::string_view separated_by;   ///< the experiment that shows it alone
  /// Why it cannot be seen in displacement records; empty when it can. Such an effect is never named.
  std::string_view unseen = {};
  /// Symptoms (identify/symptoms.h) that must become smaller when this effect is the missing one; any of them will do.
  std::vector<std::string_view> repairs = {};

  /// Energy loss per cycle and unit load [m] for y = A cos wt while all joints roll; nullptr: none, or no closed form.
  double (*loss_per_cycle)(std::span<const double> p, double A, double w) = nullptr;

  LawTable law{};  ///< null functions: no effect on the mechanics
  ReadingStage stage = ReadingStage::kNone;
  ReadTable reading{};

  bool IsMechanical() const { return std::get<0>(law) != nullptr; }
  template <typename T>
  void Extend(std::span<const T> p, ExtendedOscillator<T>* oscillator) const {
    std::get<ExtendFunction<T>>(law)(p, oscillator);
  }
  template <typename T>
  T Read(std::span<const T> p, double t, double fit_start, const T& input) const {
    return std::get<ReadFunction<T>>(reading)(p, t, fit_start, input);
  }
};

/// All effects, in the order of the catalogue.
std::span<const Effect* const> Effects();
/// The effect of an identifier, or nullptr.
const Effect* FindEffect(std::string_view id);

}  // namespace uiclink
