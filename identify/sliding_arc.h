#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace uiclink {

/// Samples on the way to an extremum while every joint slides: first <= i < last.
struct ArcWindow {
  std::size_t first = 0, last = 0;
  double t = 0;     ///< time of the extremum [s]
  double side = 1;  ///< +1 at a maximum, -1 at a minimum
};

/// What the arcs say together.  Standard deviations hold for white noise of the size that the arcs themselves show.
struct ArcFit {
  bool both_sides = false;            ///< arcs to maxima and to minima: zero and shift are told apart
  double omega = 0, omega_std = 0;    ///< [rad/s]
  double zero = 0, zero_std = 0;      ///< reading midway between the centres of the two sides [m]
  double shift = 0, shift_std = 0;    ///< o = T0/k: the centre on the way to a maximum is zero - o [m]
  double covariance_omega_shift = 0;  ///< [rad m/s]
  double rms = 0;                     ///< of the residuals [m]
};

/// Least squares of  y = zero - side o + a_j cos w(t - t_j) + b_j sin w(t - t_j)  over arcs j: w, zero and o are common
/// to all, a_j and b_j belong to each arc.
///
/// Theory: while all joints slide, y''/g = -k y - side T0, so the centre is at -side T0/k and w^2 = g k whatever the
/// amplitude.  Needs arcs of both sides; with arcs of one side `zero` is their centre and shift is 0.
/// Variable projection: all but w is linear, so each step of w solves the rest exactly.
/// @param omega  where to start [rad/s]; converges from within some 30 %.
/// @returns nothing when the samples do not determine w (too few, or a straight line), or it is outside 1/3 .. 3 omega.
std::optional<ArcFit> FitSlidingArcs(std::span<const double> t, std::span<const double> y,
                                     std::span<const ArcWindow> arcs, double omega);

/// The samples before extremum `t` (nearest sample `index`) at which the motion, coming from a reading `from` at sample
/// `from_index`, has travelled farther than `travel` [m]: each joint with 2 T0i/k_i < travel slides there.
ArcWindow FindSlidingArc(std::span<const double> t, std::span<const double> y, std::size_t from_index, double from,
                         std::size_t index, double t_extremum, double travel);

}  // namespace uiclink
