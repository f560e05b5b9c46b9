#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "model/oscillator.h"

namespace uiclink {

/// Which sliders slide: bit i is set while slider i is held at its limit.  All that slide slide the same way.
using Mode = std::uint32_t;

/// What ends an arc.
enum class EventKind : std::uint8_t {
  kBreakout,  ///< a slider reaches its limit and starts to slide
  kTurning,   ///< the mass comes to rest, every slider sticks, the motion reverses
  kEnd,       ///< the end of the run
};

/// Motion between two events, in closed form:  y(t) = c + a cos w s + b sin w s,  s = t - t_start.
template <typename Scalar>
struct Arc {
  double t_start = 0;  ///< [s]
  double t_end = 0;    ///< [s]
  Scalar c{};          ///< centre [m]
  Scalar a{};          ///< y(t_start) - c [m]
  Scalar b{};          ///< v(t_start) / w [m]
  Scalar w{};          ///< angular frequency [rad/s]
  Mode sliding = 0;    ///< sliders held at their limit
  EventKind end = EventKind::kEnd;
};

/// Sample times: first + i step, or a list.  Kept as a view; the list must outlive it.
struct SampleTimes {
  double first = 0;  ///< [s]
  double step = 0;   ///< [s], unless `times` is given
  std::size_t size = 0;
  std::span<const double> times = {};  ///< [s], non-decreasing; replaces first + i step when not empty

  double operator[](std::size_t i) const { return times.empty() ? first + static_cast<double>(i) * step : times[i]; }
  /// First sample at or after t [s], not before `from`; `size` where there is none.
  std::size_t FindFirst(double t, std::size_t from) const;
};

/// A run of the event solver: arcs from event to event, exact at any time.  Reuse one object for many runs; it keeps
/// its memory.
template <typename Scalar>
class Trajectory {
 public:
  std::span<const Arc<Scalar>> arcs() const { return arcs_; }
  /// Forces of the sliders at the start of arc `j` [-].
  std::span<const Scalar> StartForces(std::size_t j) const { return {forces_.data() + j * sliders_, sliders_}; }
  /// Number of events passed (starts and ends of the run are none).
  std::size_t CountEvents() const { return arcs_.empty() ? 0 : arcs_.size() - 1; }

  Scalar y(double t) const;                      ///< displacement [m]
  Scalar v(double t) const;                      ///< velocity [m/s]
  Scalar T(std::size_t slider, double t) const;  ///< force of one slider [-]

  void Clear(const Oscillator<Scalar>& oscillator);
  void Append(const Arc<Scalar>& arc, std::span<const Scalar> forces);
  Arc<Scalar>& back() { return arcs_.back(); }

  /// Index of the arc that covers t; times before the start belong to the first arc, times after the end to the last.
  std::size_t FindArc(double t) const;

 private:
  std::vector<Arc<Scalar>> arcs_;
  std::vector<Scalar> forces_;  // StartForces, arc by arc
  Oscillator<Scalar> oscillator_;
  std::size_t sliders_ = 0;
};

/// Displacements at many times [m], the fast way: the phase is turned from sample to sample, not evaluated.
/// Error against Trajectory::y: rounding of `size` turns, below 1e-14 of the amplitude per thousand samples of an arc.
void CalcDisplacements(const Trajectory<double>& trajectory, const SampleTimes& times, std::span<double> y);

/// Displacements [m], velocities [m/s] and derivatives of the displacement with respect to the N dual quantities.
/// @param dy  column after column: dy[p * times.size + i] is the derivative of sample i by quantity p.
template <int N>
void CalcDisplacements(const Trajectory<Dual<N>>& trajectory, const SampleTimes& times, std::span<double> y,
                       std::span<double> v, std::span<double> dy);

}  // namespace uiclink
