#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace uiclink {

/// A motion y' = f(t, y) whose right-hand side changes at events: zero crossings of guard functions. Between events f
/// must be smooth; what changes at an event is kept by the caller and changed in `pass` alone.
struct EventOde {
  std::size_t size = 0;    ///< of y
  std::size_t guards = 0;  ///< number of guard functions
  std::function<void(double t, std::span<const double> y, std::span<double> rate)> rate;
  /// Values of the guards; an event is where one changes sign. A guard that is zero at a start or restart is armed once
  /// it has left zero.
  std::function<void(double t, std::span<const double> y, std::span<double> guards)> guard;
  /// Called at an event; may change y. crossed[i] is +1 where guard i has become positive, -1 negative, 0 neither.
  std::function<void(double t, std::span<double> y, std::span<const int> crossed)> pass;
};

struct EventOdeOptions {
  double rtol = 1e-10;       ///< relative tolerance of a step [-]
  std::vector<double> atol;  ///< absolute tolerance of each component; one number serves for all
  double max_step = 0;       ///< [s]; 0: no limit. It bounds what a guard can do unseen between two looks
};

struct EventOdeCounts {
  long steps = 0;
  long rate_calls = 0;
  long events = 0;
};

/// Runs from t = 0 and calls sample(i, t_i, y) at t_i = i step, i = 0 .. samples - 1. ARKODE's explicit pair of order
/// 5, with its root finder; samples are ends of steps, events are read off its interpolant.
/// @throws std::invalid_argument for sizes that do not fit, std::runtime_error with ARKODE's message when it gives up.
EventOdeCounts SolveEventOde(const EventOde& ode, std::span<const double> start, double step, std::size_t samples,
                             const std::function<void(std::size_t i, double t, std::span<const double> y)>& sample,
                             const EventOdeOptions& options);

}  // namespace uiclink
