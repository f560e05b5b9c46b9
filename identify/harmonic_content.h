#pragma once

#include <array>
#include <span>

#include "identify/half_swings.h"

namespace uiclink {

/// Phase and amplitude of a decay at each sample, from its turns: the phase grows by pi from turn to turn, linearly in
/// between, and the amplitude runs linearly too.  Samples behind the last turn have none.
struct LocalPhase {
  std::vector<double> phase;      ///< [rad], 0 at the first turn
  std::vector<double> amplitude;  ///< [m], > 0
  double side = 1;                ///< +1 when the first turn is a maximum
};
LocalPhase CalcLocalPhase(std::span<const double> t, std::span<const Turn> turns);

/// Second and third harmonic of readings at their own phase: least squares of
///   y = c + sum_n A(t) (a_n cos n phase + b_n sin n phase),  n = 1, 2, 3.
/// @returns a_2, b_2, a_3, b_3 [-], shares of the local amplitude, with the signs of a motion whose first turn is a
/// maximum; NaN where the motion has fewer than three turns.
std::array<double, 4> CalcHarmonicContent(std::span<const double> t, std::span<const double> y,
                                          std::span<const Turn> turns);

}  // namespace uiclink
