#pragma once

#include "model/oscillator.h"
#include "model/trajectory.h"

namespace uiclink {

enum class SolveStatus {
  kOk,
  kNotFinite,      ///< a parameter or start value is not finite, or k <= 0, k_i < 0, T0i < 0
  kTooManyEvents,  ///< more than SolveOptions::max_events
};

struct SolveOptions {
  /// Gives up after so many events [-].  Fifteen seconds of a link have about a hundred.
  std::size_t max_events = 100000;
};

/// Walks from event to event; between events the motion is known in closed form, so nothing is stepped in time.
///
/// Model, per unit load:  y''/g = -k y + sum T_i;  stick T_i' = -k_i y' while |T_i| < T0i;  slide T_i = -sign(y') T0i.
/// Starts from any admissible state (|T_i| <= T0i).  See EVENTS.md for the order of events, for grazing, for the
/// endless ever smaller slips of k1 < k, and for why derivatives pass every event without the derivative of its time.
///
/// @param duration  [s], >= 0; the trajectory covers 0 .. duration.
/// @param out       overwritten; on failure it holds the arcs up to the failure.
/// Errors: none is thrown inside a fit; the status says what happened.
template <typename Scalar>
SolveStatus Solve(const Oscillator<Scalar>& oscillator, const State<Scalar>& start, double duration,
                  Trajectory<Scalar>* out, const SolveOptions& options = {});

}  // namespace uiclink
