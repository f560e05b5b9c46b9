#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identify/noise.h"
#include "identify/record.h"
#include "identify/release.h"

namespace uiclink {

/// An extremum of whatever part of a record, and how well it is known.
struct Turn : Extremum {
  double error = 0;      ///< standard deviation of y [m]
  double curvature = 0;  ///< [m/s^2]; 0 where no fit was possible
};

/// Samples at which the motion turns: from each it comes back by more than `least` and by 8 % of the swing before [m].
/// Maxima and minima alternate; the first may be the first sample.
std::vector<std::size_t> FindTurningSamples(std::span<const double> y, double least);

/// Smallest distance by which a motion must come back to have turned [m]: 8 noise levels, 3 steps of the converter.
double CalcTurnThreshold(const Noise& noise);

/// Every turn of a record that stands out of the noise, located between samples.  What follows the end of the motion
/// (swings within the noise, or out of step) is left out, as are turns at the very edges of the record.
std::vector<Turn> FindTurns(const Record& record, const Noise& noise);

/// Distance of turns i and i+1 [m].
inline double Span(std::span<const Turn> turns, std::size_t i) {
  const double distance = turns[i + 1].y - turns[i].y;
  return distance < 0 ? -distance : distance;
}

/// What each cycle loses: distance of turns i, i+1 less that of i+1, i+2 [m].  Free of the zero.
std::vector<double> CalcLosses(std::span<const Turn> turns);

/// How flat a motion is where it turns.
enum class Flatness {
  kRound,
  kHardlyCurved,  ///< less than 0.4 of the curvature of its swing: cut, or a very soft spring
  kOneLevel,      ///< stays at one level for much longer than noise and the converter's steps explain: cut, or a pause
};

/// Distance from the level of a cut within which a reading is at it [m]: noise, and one step of the converter.
inline double CutBand(const Noise& noise) { return 4 * noise.sigma + noise.quantum; }

/// Marks the turns that the sensor cut: flat at the record's highest or lowest reading. Their time becomes the middle
/// of the flat part, their reading its mean. A motion that pauses where it turns, or comes to rest, is flat at any
/// level; one single turn that is hardly curved may be the motion's own (a pendulum near its top).
/// @param first  turns before it may be held by a hand, and are left alone.
void MarkCut(const Record& record, const Noise& noise, std::size_t first, std::vector<Turn>* turns);

Flatness FindFlatness(const Record& record, const Noise& noise, std::span<const Turn> turns, std::size_t i);

}  // namespace uiclink
