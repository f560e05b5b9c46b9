#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "model/extended_oscillator.h"
#include "model/trajectory.h"

namespace uiclink {

/// A piece of the motion of an extended oscillator, s = t - t_start.
///   closed form:  y = q0 + q1 s + exp(-q5 s) (q2 cos q4 s + q3 sin q4 s)
///   polynomial:   y = q0 + q1 u + ... + q5 u^5,  u = s / length
/// t_start carries derivatives: it is the time of an event.
template <typename T>
struct ExtendedArc {
  T t_start{};        ///< [s] since the first extremum
  double t_end = 0;   ///< [s]
  double length = 0;  ///< of the polynomial's step [s]; 0 for a closed form
  std::array<T, 6> q{};
};

/// A run of the extended solver. Reuse one object for many runs; it keeps its memory.
template <typename T>
class ExtendedTrajectory {
 public:
  std::span<const ExtendedArc<T>> arcs() const { return arcs_; }
  std::size_t CountEvents() const { return events_; }

  T y(double t) const;  ///< displacement [m]
  T v(double t) const;  ///< velocity [m/s]

  void Clear() { arcs_.clear(), events_ = 0; }
  void Append(const ExtendedArc<T>& arc) { arcs_.push_back(arc); }
  ExtendedArc<T>& back() { return arcs_.back(); }
  void CountEvent() { ++events_; }

 private:
  const ExtendedArc<T>& FindArc(double t) const;

  std::vector<ExtendedArc<T>> arcs_;
  std::size_t events_ = 0;
};

/// Displacement and velocity of an arc at s = t - t_start.
template <typename T>
T CalcDisplacement(const ExtendedArc<T>& arc, const T& s);
template <typename T>
T CalcVelocity(const ExtendedArc<T>& arc, const T& s);

/// Displacements at many times [m], the fast way.
void CalcDisplacements(const ExtendedTrajectory<double>& trajectory, const SampleTimes& times, std::span<double> y);

/// Displacements [m], velocities [m/s] and derivatives of the displacement with respect to the N dual quantities.
/// @param dy  column after column: dy[p * times.size + i] is the derivative of sample i by quantity p; the first
///            `columns` quantities are wanted.
template <int N>
void CalcDisplacements(const ExtendedTrajectory<Dual<N>>& trajectory, const SampleTimes& times, int columns,
                       std::span<double> y, std::span<double> v, std::span<double> dy);

}  // namespace uiclink
