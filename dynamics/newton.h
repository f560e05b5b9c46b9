#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>
#include <optional>
#include <vector>

#include "dynamics/cycle.h"
#include "dynamics/flow.h"

namespace uiclink {

/// What the search for a cycle may move; also a difference of two such.
struct Place {
  Eigen::VectorXd state;
  double period = 0;
  double lambda = 0;
};

Place operator+(const Place& a, const Place& b);
Place operator-(const Place& a, const Place& b);
Place operator*(double factor, const Place& a);
Place PlaceOf(const Cycle& cycle);

/// A linear equation beside  end - start = 0:   by_state . state + by_lambda lambda = value,  in units of the norm.
struct Condition {
  Eigen::VectorXd by_state;
  double by_lambda = 0;
  double value = 0;

  double Residual(const Place& place) const { return by_state.dot(place.state) + by_lambda * place.lambda - value; }
};

/// sqrt(mean((difference_i/scale_i)^2)).
double Norm(const Flow& flow, const Eigen::VectorXd& difference);

/// direction . (state - at.state) = offset, in the norm; direction is made one long.
/// @throws CycleError when the direction is zero.
Condition StateCondition(const Flow& flow, const Eigen::VectorXd& direction, const Place& at, double offset = 0);

/// The same values, with zeros in all other components.
Eigen::VectorXd ActivePart(const Passage& passage, const Eigen::VectorXd& values);

/// The linear equations of Newton's method at a passage with derivatives:
///   (I - d end/d start) dz - rate dT - (d end/d lambda) dlambda = end - start,   conditions
/// in the active components, with rows and columns divided by the scales.
class Linearization {
 public:
  Linearization(const Flow& flow, const Passage& passage, const Place& place, const std::vector<Condition>& conditions,
                bool free_lambda);

  /// The step that makes closure and conditions zero; slaved components of the step are zero.
  Place Solve(const Eigen::VectorXd& closure, const Eigen::VectorXd& conditions) const;
  /// Of the matrix: det(I - monodromy), bordered. Memory that is wiped out (multiplier zero) does not touch it.
  double Determinant() const { return matrix_.partialPivLu().determinant() * column_lengths_.prod(); }
  const std::vector<int>& active() const { return active_; }

 private:
  std::vector<int> active_;
  Eigen::VectorXd scales_;  ///< of all components, times the root of their number
  double period_;
  bool free_period_, free_lambda_;
  Eigen::VectorXd column_lengths_;
  Eigen::MatrixXd matrix_;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> factors_;
};

/// Where Newton's method has arrived.
struct Corrected {
  Place place;
  Passage passage;      ///< with derivatives
  double residual = 0;  ///< norm of end - start
  int passages = 0;
};

/// Newton's method on  end - start = 0  and the conditions, from a guess, with a free period unless it is forced. Chord
/// steps while they bring the residual down to a fifth; damped steps where it would grow. When joints stop to slide
/// between start and end, so that the start cannot follow, the end state becomes the new guess, three times at most.
/// @param known  null, or a passage nearby with derivatives: the first matrix is made of it.
/// @throws CycleError when it does not converge; what Flow::Pass throws at the guess.
Corrected Correct(Flow& flow, const Place& guess, const std::vector<Condition>& conditions, bool free_lambda,
                  const CycleOptions& options, const Passage* known = nullptr);

/// The cycle at a place that Correct has found, with its multipliers.
Cycle MakeCycle(const Flow& flow, const Corrected& corrected, const CycleOptions& options);

}  // namespace uiclink
