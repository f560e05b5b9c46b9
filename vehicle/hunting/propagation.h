#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/hunting/set_scatter.h"
#include "vehicle/hunting/variance_shares.h"

namespace uiclink {

/// A number with the standard error that it has because draws are few.
struct Sampled {
  double value = 0;
  double error = 0;
};

/// What the uncertainty of the links makes of one scalar of the wagon.
struct ScalarBounds {
  std::string name;  ///< "linear critical speed"
  std::string unit;
  std::optional<double> nominal;     ///< of the set itself; none where it has none
  std::string nominal_reason;        ///< why
  std::vector<double> values;        ///< by draw; not finite where there is none
  std::vector<std::string> reasons;  ///< by draw: why there is none; empty elsewhere
  std::size_t failed = 0;            ///< draws without a value

  // Of the draws with a value; errors as of independent draws, which is the upper bound for a Latin hypercube.
  Sampled mean, std;
  Sampled low, high;  ///< 2.5 % and 97.5 % quantiles
  double median = 0;

  /// First order, where derivatives are known:  nominal +- 1.96 s,  s^2 = g' C g.
  std::optional<double> linear_low, linear_high;
  VarianceShares shares;
  std::string shares_reason;  ///< why there are none

  bool exists() const { return failed < values.size(); }  ///< at least one draw has a value
};

struct PropagateOptions {
  int threads = 0;                                                     ///< 0: as many as the machine has
  std::function<void(std::size_t done, std::size_t of)> on_done = {};  ///< on the calling thread
};

/// What is asked of a wagon.
struct Asked {
  std::string name;
  std::string unit;
};
/// The scalars of one wagon, in the order of what was asked; not finite where there is none. May throw: every scalar
/// of that draw then has the exception's words as its reason.
using WagonScalars = std::function<std::vector<double>(const Wagon& wagon)>;

/// Carries the draws of a scatter through a function of the wagon: nominal first, then every draw, on all threads.
/// A draw that fails keeps its row with the reason, is counted, and is left out of the statistics.
/// Shares of variance are those of the linear regression of the draws on the parameters; what it does not explain is
/// VarianceShares::not_linear. It takes three draws with a value for each parameter.
/// The result does not depend on the number of threads.
std::vector<ScalarBounds> PropagateScalars(const SetScatter& scatter, const Wagon& wagon,
                                           const std::vector<Asked>& asked, const WagonScalars& function,
                                           const PropagateOptions& options = {});
/// The same for one scalar, say a nonlinear critical speed.
ScalarBounds PropagateScalar(const std::string& name, const std::string& unit,
                             const std::function<double(const Wagon&)>& function, const SetScatter& scatter,
                             const Wagon& wagon, const PropagateOptions& options = {});

/// Derivatives of a function by the parameters of a scatter, at its centre: central differences with a thousandth of
/// the parameter (of its standard deviation where it is zero), one-sided at a bound.
/// @param function  of the values of all parameters.
/// @throws std::runtime_error for a parameter that cannot be changed without leaving its bounds; what `function`
/// throws.
Eigen::VectorXd DifferentiateByParameters(const SetScatter& scatter,
                                          const std::function<double(const Eigen::VectorXd& values)>& function);

/// Mean, standard deviation, quantiles and their errors from `values`. Quantiles interpolate between order statistics
/// (Hyndman and Fan 1996, type 7), their errors are Maritz and Jarrett's (1978).
void Summarise(ScalarBounds* bounds);
/// Adds shares by regression (above).
void AddShares(const SetScatter& scatter, ScalarBounds* bounds);
/// Adds first-order bounds and shares from derivatives dV/dp of the scatter's parameters.
void AddShares(const SetScatter& scatter, const Eigen::VectorXd& gradient, ScalarBounds* bounds);

}  // namespace uiclink
