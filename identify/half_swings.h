#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identify/turns.h"
#include "model/oscillator.h"

namespace uiclink {

/// What three successive turns of a free decay say, from readings alone.  Free of the sensor's zero.
struct HalfSwing {
  double t = 0;          ///< of the turn in the middle [s]
  double amplitude = 0;  ///< mean of half the two distances [m]
  double decrement = 0;  ///< difference of half the two distances: amplitude lost in a half cycle [m]
  double frequency = 0;  ///< of the cycle [Hz]
  /// Energy lost in the half cycle per unit load, the motion taken as harmonic with its own period:
  ///   w^2 (A^2 - A'^2)/2g,  w = 2 pi frequency  [m]
  double loss = 0;
  double middle = 0;  ///< mid-line (y0 + 2 y1 + y2)/4, free of the decrement to first order [m]
};

/// A free decay as its turns tell it.
struct Swings {
  std::vector<Turn> turns;  ///< turns[0] is the start of the samples, an extremum
  std::vector<HalfSwing> half;
};

/// Reads turns and half swings off samples that start at an extremum.  The first turn is located by a fit to one side.
Swings ReadSwings(const Record& samples, const Noise& noise);

/// A curve over amplitude, drawn by the half swings of a decay.
/// Linear between its points; below the smallest amplitude its last value, above the largest the line through the
/// first two.
class AmplitudeCurve {
 public:
  AmplitudeCurve(std::span<const HalfSwing> swings, double HalfSwing::*quantity);
  double operator()(double amplitude) const;

 private:
  std::vector<std::pair<double, double>> points_;  // by falling amplitude
};

/// Largest critical displacement T0i/k_i of a link [m]: joints whose motion turns above it slide.
double CalcCriticalAmplitude(const Oscillator<double>& link);

/// Number of turns after which not every joint slides within the half cycle that follows: distances between turns fall
/// below 2.4 critical displacements, that is, 1.2 times what sliding takes.
std::size_t CountSlidingTurns(std::span<const Turn> turns, const Oscillator<double>& link);

/// T0 from what the first `sliding` turns lose, with the link's stiffnesses:
///   k (A0 - A2)/2 = 2 T0 - 2 (T0^2/sum k_i)(1/(A0 + A1) + 1/(A1 + A2)),
/// mean over the cycles, each weighted by the square of what its loss says about T0.  Of the two roots the one on the
/// side of the link's own T0 counts.  NaN where there is no cycle.
double ReadFrictionFromDecrement(std::span<const Turn> turns, std::size_t sliding, const Oscillator<double>& link);

/// T0 = k1 a + k |o| from the late motion of amplitude a about the centre o (one slider: the state in which it locks),
/// over turns first .. last - 1.  NaN for several sliders, which lock at different amplitudes.
double ReadFrictionFromLock(std::span<const Turn> turns, std::size_t first, std::size_t last, double offset,
                            const Oscillator<double>& link);

/// T0 = w^2/g times the shift of the centres of the sliding arcs (identify/sliding_arc.h).  NaN where the first
/// `sliding` turns do not determine it.
double ReadFrictionFromCentre(const Record& samples, std::span<const Turn> turns, std::size_t sliding,
                              const Oscillator<double>& link);

}  // namespace uiclink
