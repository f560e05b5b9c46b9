#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "identify/noise.h"
#include "identify/record.h"

namespace uiclink {

/// A turning point of the measured motion, located between samples by a local least-squares parabola or cubic.
struct Extremum {
  double t = 0;           ///< [s]
  double y = 0;           ///< reading [m], the record's own zero
  std::size_t index = 0;  ///< nearest sample
};

/// What a ring-down record consists of: rest, push, release, free decay that first slides and then rolls.
struct Phases {
  bool usable = false;
  std::string reason;            ///< why not, in the form "expected ..., found ...", when not usable

  std::size_t rest_size = 0;     ///< samples at rest before the push (0: the record starts in motion)
  double rest_level = 0;         ///< mean reading at rest [m], where rest_size > 0
  double release_s = 0;          ///< estimated end of the push [s]; the fit may refine it
  std::size_t fit_start = 0;     ///< first sample at or after the first extremum after release
  std::vector<Extremum> extrema; ///< of the free decay; extrema[0] is the first after release
  std::size_t rolling_start = 0; ///< index into extrema: from here on the joints (nearly) only roll
  double late_amplitude = 0;     ///< half the distance between the last extrema [m]
  double centre = 0;             ///< centre of the late motion [m], in readings
  bool clipped = false;          ///< the free decay has extrema cut flat at one level
};

/// Finds the phases of a record.  Never throws for what is in the data: an unusable record says why.
///
/// Not usable: no free decay (amplitude does not fall: still driven, or only noise), fewer than kMinExtrema extrema,
/// fewer than kMinSamplesPerPeriod samples in a period, decay clipped at the sensor's limit.
/// A decay that never slides (harmonic from the start) is usable for k + sum k_i only; the fit says so.
Phases FindPhases(const Record& record, const Noise& noise);

}  // namespace uiclink
