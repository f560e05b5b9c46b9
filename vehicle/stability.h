#pragma once

#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "vehicle/wagon.h"

namespace uiclink {

/// One way in which the wagon moves about its running equilibrium: the real part of  x = Re(shape e^(lambda t)).
struct LinearMode {
  std::complex<double> lambda;                          ///< [1/s]
  std::array<std::complex<double>, kMaxState> shape{};  ///< largest displacement 1; phases relative to it

  double frequency_hz() const;
  double damping_ratio() const { return -lambda.real() / std::abs(lambda); }  ///< of critical [-]
};

/// The wagon linearised about its running equilibrium, with every joint stuck and relaxed (rolling friction apart:
/// LinkState::Rolling).
///
/// The thesis integrates the forces T_i of the sliders; while they stick T_i + k_i d_i is conserved, which makes one
/// structural zero eigenvalue for each.  Here the force of a joint that sticks is algebraic, so that these zeros do not
/// appear at all; `structural_zeros` counts them (20 for the plain model).  Leaf springs add four zeros of the same
/// kind, since at rest their force stays; they are taken out by their rows, which vanish.
struct LinearWagon {
  double V = 0;  ///< [m/s]
  WagonState equilibrium;
  Eigen::MatrixXd jacobian;  ///< d rate / d state of the 30 motions
  int structural_zeros = 0;
};

/// @throws what FindEquilibrium throws.
LinearWagon Linearize(const Wagon& wagon, double V);

/// Eigenvalues [1/s] by falling real part, those of a pair with the positive imaginary part first.
std::vector<std::complex<double>> CalcEigenvalues(const LinearWagon& linear);
/// The same with their shapes.
std::vector<LinearMode> CalcModes(const LinearWagon& linear);

struct StabilityOptions {
  double from = 1;          ///< [m/s], > 0
  double to = 50;           ///< [m/s]
  double step = 0.25;       ///< of the first search [m/s]; two crossings within one step are not seen
  double tolerance = 1e-7;  ///< of the speed of a crossing [m/s]
  bool first_only = false;  ///< stop at the linear critical speed
  /// Told after every speed of the first search; may be null.
  std::function<void(double V, const std::vector<std::complex<double>>& eigenvalues)> on_speed;
};

/// A speed at which an eigenvalue or a pair of them crosses the imaginary axis.
struct Crossing {
  double V = 0;                ///< [m/s], or the parameter of a LinearFamily
  double frequency_hz = 0;     ///< 0: a real eigenvalue (the wagon diverges)
  bool to_unstable = false;    ///< with growing speed or parameter
  LinearMode mode;             ///< at the crossing
  double real_part_slope = 0;  ///< d Re(lambda)/dV [1/m]
};

struct StabilityResult {
  std::vector<Crossing> crossings;  ///< by speed
  int unstable_at_start = 0;        ///< eigenvalues with positive real part at options.from
  std::optional<double>
      linear_critical_speed;  ///< the first crossing to unstable, if the wagon is stable before it [m/s]
  int structural_zeros = 0;
  double searched_to = 0;  ///< [m/s]
};

/// All crossings in a range of speeds, located by the sign of the crossing eigenvalue's real part.
/// @throws std::invalid_argument for a range or tolerance that makes no sense; what FindEquilibrium throws.
StabilityResult FindCrossings(const Wagon& wagon, const StabilityOptions& options = {});

/// The wagon linearised at a value of some parameter.
using LinearFamily = std::function<LinearWagon(double value)>;
/// The same by another parameter than the speed: where StabilityOptions and StabilityResult say m/s it is the
/// parameter's unit. There is no linear critical speed.
StabilityResult FindCrossings(const LinearFamily& family, const StabilityOptions& options);

}  // namespace uiclink
