#pragma once

#include <span>
#include <string>
#include <vector>

#include "identify/symptoms.h"

namespace uiclink {

/// Where a line of a residual spectrum may come from.
enum class LineOrigin {
  kMotion,     ///< the motion itself or a harmonic of it
  kMains,      ///< a multiple of 50 or 60 Hz, itself or folded by the sampling
  kCrossAxis,  ///< in the band of the link's other direction, and no harmonic of this one's
  kDrift,      ///< slower than three cycles in a record: the mid-line, no tone
  kUnknown,
};

/// A line that stands out of its surroundings.
struct SpectralLine {
  double frequency = 0;  ///< [Hz]
  double amplitude = 0;  ///< of a steady tone, root mean square over the records [m]
  double z = 0;          ///< normal equivalent of its probability, all frequencies counted
  LineOrigin origin = LineOrigin::kUnknown;
  int harmonic = 0;  ///< of the motion, or of the mains
  double base = 0;   ///< 50 or 60 Hz
};

/// Frequencies at which a link's joints slide and roll; the motion's lie between them.
struct MotionBand {
  double sliding = 0, rolling = 0;  ///< [Hz]
};

/// What a line at frequency f is, of records sampled at `sampling_hz`.  A tone of frequency F shows at
/// |F - sampling_hz round(F/sampling_hz)|; keeping every n-th sample of a faster converter without a filter folds just
/// like sampling at the lower rate.
/// @param resolution  half width within which two frequencies are the same, 1/T of a record of length T [Hz].
SpectralLine NameLine(double f, double resolution, const MotionBand& motion, double sampling_hz);

/// Lines of the residual spectrum as symptoms, and the spectrum as a curve.
///
/// Periodograms under a Hann window, in units of white noise of each record's level, summed over the records:
/// chi-square with two degrees of freedom for each record. A line is judged against the median of its surroundings
/// (15/T to each side, T the length of a record), never against less than the noise; the probability counts every
/// frequency looked at. Records with uneven samples are left out.
void FindSpectralSymptoms(std::span<const SymptomInput> records, Direction direction, Symptoms* symptoms);

}  // namespace uiclink
