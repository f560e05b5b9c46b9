#pragma once

#include <complex>
#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/figure.h"
#include "vehicle/stability.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Eigenvalues at one speed.
struct RootsAtSpeed {
  double V = 0;                             ///< [m/s]
  std::vector<std::complex<double>> roots;  ///< [1/s]
};

/// A search for critical speeds with what it stands on.
struct StabilityRun {
  const WagonInputs& inputs;
  const StabilityResult& result;
  const std::vector<RootsAtSpeed>& roots;  ///< by speed
  StabilityOptions options;
  double wall_s = 0;
};

/// Schema "wagon-stability/1".
std::string FormatStabilityJson(const StabilityRun& run);

/// Summary for a terminal.
std::string FormatStability(const StabilityRun& run);

/// Speed, real and imaginary part of each eigenvalue with imaginary part >= 0, a row each.
std::vector<DataColumn> RootColumns(const StabilityRun& run);

/// The slow eigenvalues (those that can make the wagon hunt): real part and frequency against speed, and their path in
/// the complex plane.
Figure RootLocusFigure(const StabilityRun& run);

}  // namespace uiclink
