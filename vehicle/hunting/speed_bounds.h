#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/hunting/propagation.h"
#include "vehicle/hunting/set_scatter.h"
#include "vehicle/stability.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// The crossing that the draws are followed from: speed and eigenvalue.
struct KnownCrossing {
  double V = 0;                 ///< [m/s]
  std::complex<double> lambda;  ///< the eigenvalue that crosses [1/s]
};

struct CriticalSpeedOptions {
  double from = 1;          ///< [m/s]; no crossing below it is looked for
  double to = 80;           ///< [m/s]
  double tolerance = 1e-8;  ///< of the speed [m/s]
  int checked_below = 5;    ///< speeds between `from` and the crossing at which every eigenvalue must be stable
};

/// Linear critical speed of a wagon that is a little different from one whose crossing is known, in some five
/// linearisations: the zero of Re(lambda) by secants, lambda followed from `known` by its neighbourhood. What is found
/// counts when every other eigenvalue is stable there and all are at `checked_below` speeds below; otherwise the whole
/// range is searched (FindCrossings).
/// @throws std::runtime_error where there is none up to `to` or the wagon is unstable from the start.
double FindCriticalSpeedNear(const Wagon& wagon, const KnownCrossing& known, const CriticalSpeedOptions& options = {});

/// Derivatives of the critical speed by the parameters of a scatter [m/s per unit of the parameter],
///   dV/dp = - (d Re(lambda)/dp) / (d Re(lambda)/dV),
/// both by central differences at the crossing, where each costs two linearisations instead of two searches; one-sided
/// at a bound. Steps are a thousandth of the parameter (of its standard deviation where it is zero).
Eigen::VectorXd CalcSpeedGradient(const SetScatter& scatter, const Wagon& wagon, const KnownCrossing& known);

/// The linear critical speed with its bounds.
struct SpeedBounds {
  ScalarBounds speed;
  Eigen::VectorXd gradient;  ///< by the parameters of the scatter; empty without a critical speed
  /// Share of the linear part that k + sum k_i of one direction alone, the one number, explains.
  double by_lateral_stiffness = 0;
  double by_longitudinal_stiffness = 0;
  double wall_s = 0;
};

/// Carries the draws of a scatter to the linear critical speed (first crossing up to CriticalSpeedOptions::to), beside
/// first-order bounds. Without draws (or nothing uncertain) only the latter.
/// They hold the uncertainty of the links' parameters alone, not that of wagon, wheels or rails.
SpeedBounds CalcSpeedBounds(const SetScatter& scatter, const Wagon& wagon, const CriticalSpeedOptions& range = {},
                            const PropagateOptions& options = {});
/// The same from a crossing that has been found already.
SpeedBounds CalcSpeedBounds(const SetScatter& scatter, const Wagon& wagon, const KnownCrossing& known,
                            const CriticalSpeedOptions& range = {}, const PropagateOptions& options = {});

}  // namespace uiclink
