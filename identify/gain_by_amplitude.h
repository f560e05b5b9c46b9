#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identify/extended_result.h"
#include "identify/record_fit.h"

namespace uiclink {

/// What an extension gains while the motion is of some size.
struct AmplitudeGain {
  double low = 0, high = 0;              ///< local amplitudes [m]
  std::size_t samples = 0;               ///< of all records
  double rms_before = 0, rms_after = 0;  ///< of the residuals of these samples [m]; 0 without samples
  double noise = 0;                      ///< rms of their records' noise floors [m]

  double Gain() const { return rms_before > 0 ? 1 - rms_after / rms_before : 0; }
};

/// Amplitude of a free decay about each of the fitted samples [m]: half the distance between the extrema before and
/// after it, so that neither the sensor's zero nor its drift matters; after the last extremum that of the last two.
/// Empty with fewer than two extrema.
std::vector<double> CalcLocalAmplitudes(const FitData& data, std::span<const Extremum> extrema);

/// Residuals of two fits of the same records in three ranges of the local amplitude, equally wide from the smallest to
/// the largest of all records; largest first.
/// @param records  the used records, in the order of the fits.
std::vector<AmplitudeGain> CalcGainByAmplitude(std::span<const RecordResult* const> records,
                                               const ExtendedResult& before, const ExtendedResult& after);

}  // namespace uiclink
