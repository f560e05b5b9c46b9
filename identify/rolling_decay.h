#pragma once

#include <span>
#include <vector>

#include "identify/half_swings.h"
#include "identify/symptoms.h"

namespace uiclink {

/// The part of one record in which its joints only roll: the plain model loses nothing there.
struct RollingTail {
  std::vector<Turn> turns;
  double modelled_decrement = 0;  ///< mean amplitude that the model loses in a half cycle [m]
};

/// From the first half swing in which the model loses less than a third of what the record loses from there on, or less
/// than the noise shows. Fewer than six turns: nothing is left, `turns` is empty.
RollingTail FindRollingTail(const Swings& measured, const Swings& modelled);

/// Fits  turn_n = z + z' n +- A_n,  dA/dn = -c A^(p-1),  to the turns of all tails: one exponent p for all, amplitude,
/// loss, centre and its drift for each.  Solution  A_n^(2-p) = A_0^(2-p) - (2-p) c n,  A_0 e^(-c n) for p = 2.
/// The interval of p is where chi-square stays within 3.84 of its least (95 %), times chi-square per degree of freedom
/// where that is above 1.
DecayExponent FitDecayExponent(std::span<const RollingTail> tails);

}  // namespace uiclink
