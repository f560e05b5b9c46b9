#pragma once

#include <complex>
#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/stability.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Eigenvalues at one speed.
struct RootsAtSpeed {
  double V = 0;                             ///< [m/s]
  std::vector<std::complex<double>> roots;  ///< [1/s]
};

/// On which side of a crossing its small cycles live (vehicle/hunting/hopf.h).
struct CrossingType {
  std::string type;         ///< "supercritical", "subcritical"; empty: not known
  double decided_at = 0;    ///< size of the cycle that decides it [m]
  double other_below = 0;   ///< largest smaller size whose cycle lives on the other side [m]; 0: none does
  std::string reason = {};  ///< why it is not known
};

/// A search for critical speeds with what it stands on.
struct StabilityRun {
  const WagonInputs& inputs;
  const StabilityResult& result;
  const std::vector<RootsAtSpeed>& roots;  ///< by speed
  StabilityOptions options;
  double wall_s = 0;
  std::vector<CrossingType> types = {};  ///< of result.crossings; empty where they were not looked for
};

/// "supercritical, decided by the cycle of 0.1 mm; below 0.003 mm subcritical", "not known: ..."; empty where there is
/// neither a type nor a reason.
std::string FormatCrossingType(const CrossingType& type);

/// Schema "wagon-stability/1".
std::string FormatStabilityJson(const StabilityRun& run);

/// Summary for a terminal.
std::string FormatStability(const StabilityRun& run);
TextTable MakeCrossingTable(const StabilityRun& run);

/// Speed, real and imaginary part of each eigenvalue with imaginary part >= 0, a row each.
std::vector<DataColumn> RootColumns(const StabilityRun& run);

/// The slow eigenvalues (those that can make the wagon hunt): real part and frequency against speed, and their path in
/// the complex plane.
Figure RootLocusFigure(const StabilityRun& run);

/// Hunting and the body's swaying on its springs; Hertz contact and creep are 100 times as fast.
bool IsSlowRoot(const std::complex<double>& root);
/// Of the slow modes among `modes`, those with the least damping first, at most eight. Equal eigenvalues
/// are shown once.
std::vector<LinearMode> ChooseShownModes(const std::vector<LinearMode>& modes);
/// Frequency, damping, and of each motion its amplitude, relative to the largest, with its phase.
TextTable MakeModeTable(const std::vector<LinearMode>& modes);
/// Their shapes seen from above: now, and a quarter of a period later.
Figure ModeFigure(const StabilityRun& run, const std::vector<LinearMode>& modes, double V);

}  // namespace uiclink
