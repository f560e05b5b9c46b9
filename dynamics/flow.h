#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace uiclink {

/// What happens to a state in a time.
struct Passage {
  Eigen::VectorXd end;   ///< the state after it
  Eigen::VectorXd rate;  ///< d end / dT, the rate of the state there
  /// Components of the state that hold the memory of something that keeps still, by what happened to them:
  std::vector<int> held;          ///< nothing has changed them from begin to end: multipliers that are exactly 1
  std::vector<int> slaved_start;  ///< no freedom at the start, they follow the others (a joint that slides): exactly 0
  std::vector<int> slaved_end;    ///< the same at the end
  /// d end / d start and d end / d lambda, through all events; empty unless asked for. Columns of slaved_start are
  /// zero.
  Eigen::MatrixXd by_start;
  Eigen::VectorXd by_parameter;
  /// Smallest and largest value of what the flow watches (Flow::watched) on the way.
  Eigen::VectorXd least, greatest;
  /// What happened on the way, as far as it tells one kind of motion from another: "slips 8, rear guidance".  Equal
  /// texts mean equal sequences of events as far as the flow counts them.
  std::string character;
};

/// Components of the state with freedom of their own: neither held nor slaved at the start. Rising.
std::vector<int> FreeComponents(const Passage& passage);

/// A way in which states move, with one parameter: what the search for cycles knows of a system.
///
/// States are vectors of size() numbers. The flow is piecewise smooth: events are its own business, and so is the
/// derivative through them (saltation). Memory of friction joints is part of the state, see Passage.
/// One object serves one thread.
class Flow {
 public:
  virtual ~Flow() = default;

  virtual int size() const = 0;
  /// What a deviation of each component counts as one [its unit], > 0: norms are  sqrt(mean((dz_i/scale_i)^2)).
  virtual const Eigen::VectorXd& scales() const = 0;
  /// Names of what is watched on the way: "front_lateral", ...
  virtual const std::vector<std::string>& watched() const = 0;
  /// The period of the excitation at a parameter; none for a flow that does not depend on time, whose cycles find their
  /// own period.
  virtual std::optional<double> ForcedPeriod(double /*lambda*/) const { return std::nullopt; }

  enum class Derivatives { kNone, kAll };
  /// Moves a state for the time T > 0. With a forced period T is that, the passage begins at phase zero, and
  /// by_parameter is the derivative of the map, with what T adds.
  /// @throws std::runtime_error when the state cannot be moved so far (derailment, a solver that gives up).
  virtual Passage Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) = 0;

  /// After `state` has been moved away from `from`, lets its slaved components follow.
  virtual void Follow(const Eigen::VectorXd& /*from*/, const std::vector<int>& /*slaved*/,
                      Eigen::VectorXd* /*state*/) const {}
};

}  // namespace uiclink
