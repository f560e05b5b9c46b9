#pragma once

#include "model/oscillator.h"
#include "model/trajectory.h"

namespace uiclink {

/// One swing of a free decay from an extremum to the next, on the other side.
struct HalfCycle {
  double next_amplitude =
      0;                ///< distance of the next extremum on the other side [m]; negative if it stays on this side
  double duration = 0;  ///< [s]
  double loss = 0;      ///< energy lost to the sliders per unit load [m]
};

/// The swing from rest at amplitude A, each slider loaded as a steady cycle leaves it: T_i = -min(k_i A, T0i).
///
/// Energy: the travel S solves  k S (2A - S)/2 + sum W_i(S) = 0  with the work W_i of slider i; between breakouts this
/// is a quadratic in S. For one slider and A > T0/k1 this is the exact map
///   A' = ( sqrt((kA - T0)^2 + 4 k T0^2/k1) - T0 ) / k.
/// Independent of the event solver: velocities come from the energy, not from the motion.
/// @param A  [m], > 0.   @throws std::invalid_argument unless A > 0.
HalfCycle CalcHalfCycle(const Oscillator<double>& oscillator, double A);

/// Backbone: frequency of the free decay at amplitude A, from the duration of its half cycle [Hz]. Rises from
/// sqrt(g k)/2 pi (A >> T0/k1) to sqrt(g (k + sum k_i))/2 pi (A <= T0i/k_i for all i).
double CalcFrequency(const Oscillator<double>& oscillator, double A);

/// Energy that a steady cycle of amplitude A loses, per unit load:  W = sum 4 T0i (A - T0i/k_i)+  [m].
double CalcLossPerCycle(const Oscillator<double>& oscillator, double A);

/// Angular frequency while every joint slides, sqrt(g k), and while every joint rolls, sqrt(g (k + sum k_i)) [rad/s].
double CalcSlidingFrequency(const Oscillator<double>& oscillator);
double CalcRollingFrequency(const Oscillator<double>& oscillator);

/// Energy per unit load:  E = v^2/2g + k y^2/2 + sum T_i^2/2k_i  [m].
double CalcEnergy(const Oscillator<double>& oscillator, const State<double>& state);

/// Energy per unit load that the sliders have dissipated from the start of a run to time t:  sum T0i |slip_i|  [m].
double CalcDissipation(const Oscillator<double>& oscillator, const Trajectory<double>& trajectory, double t);

}  // namespace uiclink
