#pragma once

#include <Eigen/Core>
#include <complex>
#include <stdexcept>
#include <string>
#include <vector>

#include "dynamics/flow.h"

namespace uiclink {

/// A periodic solution: a state to which the flow returns after the period.
struct Cycle {
  double lambda = 0;
  Eigen::VectorXd state;
  double period = 0;
  /// Eigenvalues of the monodromy matrix (d end / d start), by falling magnitude, the trivial one first for a flow
  /// without excitation. Those of held and slaved memory are not among them; they are counted below. Memory that is at
  /// rest where the cycle begins and wiped out later is among them, as a zero to rounding.
  std::vector<std::complex<double>> multipliers;
  int multipliers_one = 0;   ///< exactly one: memory that nothing touches
  int multipliers_zero = 0;  ///< exactly zero: memory that is wiped out by sliding
  double trivial_error = 0;  ///< distance of the trivial multiplier from 1, the accuracy of all; 0 with an excitation
  int unstable = 0;          ///< multipliers outside of the unit circle, the trivial one apart
  double residual = 0;       ///< norm (Flow::scales) of end - start
  Passage passage;           ///< one period, with derivatives
  int iterations = 0;        ///< passages that finding it took

  /// greatest - least of what is watched, by its number, halved.
  double Amplitude(int watched) const { return 0.5 * (passage.greatest[watched] - passage.least[watched]); }
  bool stable() const { return unstable == 0; }
};

struct CycleOptions {
  /// Norm of end - start at which a cycle counts as found. Not below what the flow's own integration error allows.
  double tolerance = 1e-7;
  int max_iterations = 20;
  /// A multiplier counts as outside of the unit circle when its magnitude exceeds 1 by this much and by twice the
  /// trivial one's error.
  double unstable_margin = 1e-4;
  /// Passages straight on before the first correction: they find the memory that belongs to the motion.
  int settle = 1;
};

/// No cycle was found: what() says why.
class CycleError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The cycle near a guess at a fixed parameter: Newton's method on  end(start, T) - start = 0  with the phase condition
///   rate(guess) . (start - guess) = 0  (in the norm),  unknown start and T.
/// Held memory keeps the value it has in the guess; slaved memory follows.
/// @param period  a guess; ignored with an excitation.
/// @throws CycleError when the iteration does not converge or ends in an equilibrium; what Flow::Pass throws.
Cycle FindCycle(Flow& flow, double lambda, const Eigen::VectorXd& guess, double period,
                const CycleOptions& options = {});

/// Multipliers, their counts, trivial_error and unstable from cycle->passage (with derivatives).
void CalcMultipliers(const Flow& flow, const CycleOptions& options, Cycle* cycle);

}  // namespace uiclink
