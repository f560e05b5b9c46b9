#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "identify/noise.h"
#include "identify/record.h"

namespace uiclink {

/// Fewest extrema of a usable free decay: two periods, the least that tells a decrement from a drifting zero.
inline constexpr std::size_t kMinExtrema = 5;

/// Fewest samples in the shortest period of a usable free decay: five samples then span an extremum's parabola.
inline constexpr double kMinSamplesPerPeriod = 12;

/// A turning point of the measured motion, located between samples by a local least-squares fit (identify/local_fit.h).
struct Extremum {
  double t = 0;           ///< [s]
  double y = 0;           ///< reading [m], the record's own zero
  std::size_t index = 0;  ///< nearest sample
  /// Cut flat by the sensor's limit: t is the middle of the flat part, y its level, and the motion went beyond.
  bool cut = false;
};

/// What a ring-down record consists of: rest, push, release, free decay that first slides and then rolls.
struct Phases {
  bool usable = false;
  std::string reason;  ///< why not, in the form "expected ..., found ...", when not usable

  std::size_t rest_size = 0;      ///< samples at rest before the push (0: the record starts in motion)
  double rest_level = 0;          ///< mean reading at rest [m], where rest_size > 0
  double release_s = 0;           ///< estimated end of the push [s]; the fit may refine it
  std::size_t fit_start = 0;      ///< first sample at or after the first extremum after release
  std::vector<Extremum> extrema;  ///< of the free decay; extrema[0] is the first after release
  std::size_t rolling_start =
      0;                      ///< index into extrema: from here on the joints (nearly) only roll; size: they never do
  double late_amplitude = 0;  ///< half the distance between the last extrema [m]
  double centre = 0;          ///< centre of the late motion [m], in readings
  bool clipped = false;       ///< the sensor cut extrema of the free decay: those are marked, the record is used
  std::size_t cut_count = 0;  ///< how many
  double cut_level = 0;       ///< reading of the first of them [m]
};

/// Finds the phases of a record.  Never throws for what is in the data: an unusable record says why.
///
/// The free decay starts at the first extremum from which the distance between neighbouring extrema only falls, and
/// falls fastest at first, as dry friction makes it: a half swing that the hand still drives loses too little, and its
/// shape shows the force (identify/push.h). Only swings of half the largest and more are asked, and what rises by less
/// than a fifth of the largest is no push: late in a record, tones and the other axis beat with what is left.
/// All rules compare distances between extrema, so neither a zero offset nor a slow drift of the sensor matters.
///
/// release_s: on the way to the first extremum the motion is compared with the free sliding arc, whose frequency and
/// centre are those of a later arc on the same side; the last departure from it is the end of the push (within some
/// 10 ms).  Where there is none back to the first sample or the extremum before, it is that sample's time.
///
/// rolling_start: from here on no cycle loses more than 10 % of what the strongest cycle lost, or 3 % of its size.
///
/// A record that is held displaced and let go has no rest reading; its decay starts at the first extremum after that.
///
/// Not usable: no free decay (amplitude does not fall: still driven, or only noise), fewer than kMinExtrema extrema,
/// fewer than kMinSamplesPerPeriod samples in a period, fewer than kMinExtrema extrema that the sensor did not cut.
/// Where the sensor cuts a third of the largest swing and more, what is left of an arc hardly tells a driven one from a
/// free one: the decay may then start one extremum too early or too late.
/// A decay that never slides (harmonic from the start) is usable for k + sum k_i only: rolling_start is 0, and the fit
/// says so.  A constant amplitude counts as such only where a push comes before it; else it may as well be driven.
Phases FindPhases(const Record& record, const Noise& noise);

/// "3 extrema are cut flat at 18.00 mm, the last at 2.70 s; ..." for the user; empty where none is.
std::string DescribeCut(const Phases& phases);

}  // namespace uiclink
