#pragma once

#include "model/event_solver.h"
#include "model/extended_oscillator.h"
#include "model/extended_trajectory.h"

namespace uiclink {

struct ExtendedSolveOptions {
  std::size_t max_events = 20000;  ///< gives up after so many [-]
  /// Error of one integrator step as a share of the start displacement [-]. Only for motions without closed form; the
  /// error of 15 s is some hundred times as large, far below a nanometre.
  double tolerance = 1e-10;
  bool always_integrate = false;  ///< use the integrator for closed forms too: a check of one by the other
};

/// The motion of an extended oscillator from an extremum at y0 that all sliders reached sliding.
///
/// Walks from event to event: turning points, breakouts, ends of clearances, stops.  Between events the motion is
/// a damped oscillation about a centre that may move linearly in time, in closed form, unless a smooth force or a
/// friction law makes it nonlinear; then Dormand-Prince steps of order 5 with error control and quintic Hermite
/// interpolation of (y, v, a).  Derivatives pass events with the derivative of their time: t* is found in double,
/// lifted once as t* - g/g', and the next arc starts at the dual t*.
///
/// @param y0        [m], not 0
/// @param clock     the record's clock at the extremum [s]: drift of friction is counted from 0
/// @param duration  [s], >= 0
/// Errors: none is thrown inside a fit; the status says what happened (kNotFinite also for overdamped motions).
template <typename T>
SolveStatus Solve(const ExtendedOscillator<T>& oscillator, const T& y0, double clock, double duration,
                  ExtendedTrajectory<T>* out, const ExtendedSolveOptions& options = {});

}  // namespace uiclink
