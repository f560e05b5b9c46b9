#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>

#include "dynamics/flow.h"

namespace uiclink {

/// How a small deviation is moved along with a trajectory.
enum class DeviationMethod {
  kNeighbour,   ///< a second trajectory close by, put back to the deviation after every interval (Benettin)
  kDerivative,  ///< the derivative of the passage, by_start (exact through events)
};

struct LyapunovOptions {
  DeviationMethod method = DeviationMethod::kNeighbour;
  double interval = 0.5;  ///< after which a deviation is made small again [s]; a forced flow: its period
  int intervals = 2000;   ///< that count
  int discarded = 100;    ///< before them: the deviation turns into the direction that grows most
  /// Norm (Flow::scales) of the deviation of a neighbour: large against the flow's own error, small against what the
  /// flow is curved by.
  double deviation = 1e-5;
  int blocks = 20;                                 ///< for the standard error
  std::uint64_t seed = 1;                          ///< of the first deviation's direction
  std::function<bool(int done)> on_interval = {};  ///< false ends early; may be null
};

struct LyapunovResult {
  double exponent = 0;  ///< largest Lyapunov exponent [1/s]
  /// Its standard error [1/s], from the means of the blocks; they count as independent, so a block must be long against
  /// the slowest modulation.
  double error = 0;
  double duration = 0;  ///< that was averaged over [s]
  int intervals = 0;
  long passages = 0;
  Eigen::VectorXd end;  ///< state at the end
};

/// Largest Lyapunov exponent of the trajectory from `start`:  lim (1/T) log(|dz(T)| / |dz(0)|),  norm by Flow::scales.
///
/// A motion that is no equilibrium has an exponent 0 along itself, so that 0 is the least answer there; chaos has a
/// positive one. Memory that is held adds zeros.
/// Where a neighbour falls onto the trajectory (all of its deviation was in memory that has been wiped out), a new
/// direction is drawn and the interval does not count.
/// @throws std::invalid_argument for options out of range; what Flow::Pass throws; std::runtime_error when neighbours
///         fall together time and again.
LyapunovResult FindLargestExponent(Flow& flow, const Eigen::VectorXd& start, double lambda,
                                   const LyapunovOptions& options = {});

}  // namespace uiclink
