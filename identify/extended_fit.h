#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "identify/extension.h"

namespace uiclink {

struct ExtendedControl {
  std::vector<double> window_s = {};  ///< growing windows from the first extremum [s]; the whole record comes last
  std::size_t stride = 1;             ///< every stride-th sample is used
  bool fix_link = false;              ///< levels and shape stay as they are
  bool fix_shared = false;            ///< shared parameters of the effects stay as they are
  int held_level = -1;                ///< this one of the levels (of record 0) stays as it is; -1: none
  int held_shared = -1;               ///< this one of the shared parameters stays as it is; -1: none
  int max_iterations = 60;
  double function_tolerance = 1e-8;  ///< relative fall of the sum of squares at which the last window stops [-]
  double step_tolerance = 1e-9;      ///< of the integrator, see ExtendedSolveOptions
  int threads = 1;                   ///< records evaluated side by side; 0: as many as the machine can
};

struct ExtendedOutcome {
  ExtendedState state = {};
  double chi2 = 0;  ///< sum of ((model - reading)/sigma)^2, of all samples used
  std::vector<double> chi2_of_record = {};
  int evaluations = 0;
  bool converged = false;
};

/// Least squares on the plain model with effects added to it, as Fit() does it for the plain model: exact derivatives,
/// Levenberg-Marquardt, growing windows.  Parameters of effects stay within their physical bounds.
ExtendedOutcome FitExtended(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                            const ExtendedState& initial, const ExtendedControl& control = {});

/// Model minus reading of one record [m], all its fitted samples. Empty where the model has no solution.
std::vector<double> CalcExtendedResiduals(const FitData& data, const Extension& extension, const ExtendedState& state,
                                          std::size_t record);

/// Derivatives of the residuals (in units of sigma) of one record by (levels, shape, start, shared, own), and the
/// residuals, every stride-th sample.
Linearisation LineariseExtended(const FitData& data, const Extension& extension, const ExtendedState& state,
                                std::size_t record, std::size_t stride = 1);

}  // namespace uiclink
