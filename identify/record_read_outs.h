#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "identify/half_swings.h"
#include "identify/harmonic_content.h"
#include "identify/symptoms.h"

namespace uiclink {

/// Numbers that are read off one record and its model alike.
enum ReadOut : std::size_t {
  kLossSmall,   ///< energy lost per half cycle [m], mean over the half swings of an amplitude range; against the model
  kLossMedium,  // at the same amplitude
  kLossLarge,
  kFrequencySmall,  ///< frequency [Hz] there, weighted by amplitude^2; against the model at the same amplitude
  kFrequencyMedium,
  kFrequencyLarge,
  kFrequencyTrend,     ///< growth of the frequency in time in the small range, without what follows amplitude [Hz/s]
  kFrictionDecrement,  ///< T0 from the decrement [-]
  kFrictionLock,       ///< T0 from the locked state [-]
  kFrictionCentre,     ///< T0 from the shift of the sliding centre [-]
  kMiddleTrend,        ///< motion of the mid-line in time [m/s]
  kMiddleAmplitude,    ///< mid-line over amplitude^2 [1/m]
  kRest,               ///< centre of the late motion from the sensor's zero of the fit [m]
  kSecondCos,
  kSecondSin,
  kThirdCos,
  kThirdSin,  ///< harmonics at the motion's own phase, shares of its amplitude [-]
  kReadOuts
};
inline constexpr std::size_t kAmplitudeRanges = 3;

/// A read-out of readings, and what the model shows there.  NaN where there is nothing to read.
struct ReadOutValue {
  double measured = std::numeric_limits<double>::quiet_NaN();
  double modelled = std::numeric_limits<double>::quiet_NaN();
};
using ReadOutValues = std::array<ReadOutValue, kReadOuts>;

/// Reads any readings on the samples of one record beside the fitted model of that record.
class RecordReadOuts {
 public:
  explicit RecordReadOuts(const SymptomInput& input);

  const Swings& modelled() const { return modelled_; }
  /// Ranges: small, down from 2 % above the smallest amplitude of the model, where it only rolls; medium and large,
  /// above, on either side of the geometric mean with the `largest` amplitude of all records.  Which half swing belongs
  /// to which is read off the record once, so that every draw has the same ones.
  void AssignRanges(const Swings& measured, double largest);
  /// Range of half swing i.
  std::size_t RangeOf(std::size_t half_swing) const { return ranges_[half_swing]; }

  struct Reading {
    Swings swings;
    ReadOutValues values;
  };
  /// @param y  readings on the fitted samples [m].
  Swings ReadTurns(std::span<const double> y);
  /// The ranges must be assigned.
  Reading Read(std::span<const double> y);

  /// The model at the same amplitude.
  double ModelledLoss(double amplitude) const { return loss_(amplitude); }
  double ModelledFrequency(double amplitude) const { return frequency_(amplitude); }

 private:
  void ReadRanges(const Swings& swings, ReadOutValues* values) const;
  void ReadFriction(const Swings& swings, ReadOutValues* values) const;
  void ReadMiddle(const Swings& swings, ReadOutValues* values) const;
  void ReadHarmonics(const Swings& swings, ReadOutValues* values) const;
  double CalcFrequencyTrend(const Swings& swings) const;
  std::size_t CountCommon(const Swings& swings) const { return std::min(swings.half.size(), modelled_.half.size()); }

  const SymptomInput* input_;
  Noise noise_;
  Record samples_;  // of the fit; y holds what is being read
  Swings modelled_, measured_;
  AmplitudeCurve loss_, frequency_;
  std::size_t sliding_ = 0;  // turns
  std::vector<std::size_t> ranges_;
  std::array<double, 4> modelled_harmonics_{};
  double modelled_decrement_ = 0, modelled_centre_ = 0;
};

}  // namespace uiclink
