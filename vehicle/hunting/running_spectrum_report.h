#pragma once

#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/hunting/guidance_history.h"
#include "vehicle/hunting/joint_losses.h"
#include "vehicle/hunting/running_spectrum.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Spectra, impacts and losses of a run with what they stand on.
struct SpectrumRun {
  const WagonInputs& inputs;
  double V = 0;        ///< [m/s]; 0: not known (a file of histories)
  std::string source;  ///< the start state in words, or the file of histories
  bool from_file = false;
  double settle = 0;            ///< simulated before the window [s]
  std::string end_reason = {};  ///< why the run ended within the window; empty: it did not
  RunningSpectrum spectrum = {};
  std::vector<FreeVibration> vibrations = {};  ///< none without a speed
  GuidanceHistory guidance = {};
  GuidanceUses uses = {};
  EnergyLosses losses = {};  ///< nothing in it where they are not known (from_file)
  std::vector<LossPart> loss_parts = {};
  double cycles = 0;  ///< of hunting that the losses are of, a whole number; 0 at rest
  double wall_s = 0;
};

/// Schema "wagon-spectrum/1" (vehicle/README.md).
std::string FormatSpectrumJson(const SpectrumRun& run);
/// Tables for a terminal: lines (tables 10.1 and 10.2), phase locking, guidance, losses.
std::string FormatSpectrum(const SpectrumRun& run);
TextTable MakeLineTable(const RunningSpectrum& spectrum);
TextTable MakeLockingTable(const RunningSpectrum& spectrum);
TextTable MakeVibrationTable(const SpectrumRun& run);
TextTable MakeGuidanceTable(const SpectrumRun& run);
TextTable MakeLossTable(const SpectrumRun& run);

/// Frequency and, of every motion, the power spectral density [m^2/Hz], [rad^2/Hz].
std::vector<DataColumn> SpectrumColumns(const SpectrumRun& run);
/// CSV: place, part, corner, J, J per cycle, share of all losses; then the lines of the balance.
std::string FormatLossesCsv(const SpectrumRun& run);

/// Power against frequency of front longitudinal, lateral, yaw and body roll (figures 10.27 to 10.30).
Figure SpectrumFigure(const SpectrumRun& run);
/// Forces of the guides and what the clearances are used for (figure 10.6), the last seconds.
Figure ImpactFigure(const SpectrumRun& run);
/// The same of any history: its last so many seconds.
Figure GuidanceFigure(const std::string& title, const GuidanceHistory& history, double duration);
/// Losses as bars, all corners together and each.
Figure LossFigure(const SpectrumRun& run);

/// Lines of the balance of energies: name ("drive", "contact", ...) and J, in the order of EnergyLosses.
struct BalanceLine {
  std::string name;
  double energy = 0;  ///< [J]
};
std::vector<BalanceLine> ListBalance(const EnergyLosses& losses);

/// What of all losses goes one way, all corners together.
struct LossSum {
  std::string where, what;
  std::array<double, kCorners> lost{};  ///< [J]
  double Sum() const;
};
std::vector<LossSum> SumLosses(const std::vector<LossPart>& parts);

}  // namespace uiclink
