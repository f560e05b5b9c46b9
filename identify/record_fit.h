#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "identify/fit_problem.h"
#include "identify/noise.h"
#include "identify/record.h"
#include "identify/release.h"
#include "identify/sine_fit.h"
#include "identify/uncertainty.h"

namespace uiclink {

/// One record on its way from the file to its own fit.
struct RecordResult {
  Record record;
  bool used = false;
  std::string reason;  ///< why not used: "expected ..., found ..."
  Noise noise;
  Phases phases;
  std::optional<SineFit> sine;  ///< the frequency method

  FitOutcome own;                        ///< fit of this record alone
  LinkInformation information;           ///< at its own fit
  std::vector<Estimate> own_quantities;  ///< by CountQuantities
  Levels drift{};           ///< range of the levels over the growing windows, where the residuals have structure
  int starts = 0;           ///< scattered starts tried
  int starts_agreeing = 0;  ///< of those, ended at the same minimum

  Oscillator<double> link;  ///< of this record in the final fit (shared, or its own)
  Start start{};            ///< in the final fit
  double rms = 0;           ///< of the final fit [m]

  /// The samples of the fit; valid while this object stays where it is.
  FitData Data() const;
};

/// Scattered starts of the check that a minimum is the lowest.
struct ScatteredStarts {
  int count = 8;
  unsigned seed = 1;
};

/// Noise, phases and frequency method: everything that needs no fit. Sets `used` and `reason`.
void PrepareRecord(const SineFitOptions& options, RecordResult* result);

/// Fits a record alone: start values from its extrema, growing windows, scattered starts, errors and bounds.
void FitRecord(int sliders, const ScatteredStarts& starts, RecordResult* result);

/// Fits a record that FitRecord has seen once more, from another link with as many sliders; a lower minimum replaces
/// its own.
void RefitRecord(const Oscillator<double>& link, RecordResult* result);

/// Looks for a lower minimum of a record that FitRecord has seen: two neighbouring sliders become one, another one is
/// split, until no such step leads lower. Costs as much as FitRecord.
void RearrangeSliders(RecordResult* result);

/// Mean period of the free decay [s].
double CalcPeriod(const Phases& phases);

/// Orders the sliders by their critical displacements T0i/k_i, so that labels mean the same in every record.
void SortSliders(FitState* state);

/// Keeps the outcome with the smaller sum of squares and adds up the evaluations.
void KeepBetter(const FitOutcome& candidate, FitOutcome* best);

/// Adds a possible shift `drift` of a quantity's logarithm to its bounds, in quadrature.
void Widen(double drift, Estimate* estimate);

/// The level that a quantity scales with: 0 k, 1 sum k_i, 2 sum T0i.
std::size_t LevelOf(int sliders, std::size_t quantity);

/// Several sliders leave directions in which the sum of squares is flat; following them to the end changes no quantity
/// by a noticeable part of its error (a millionth of the sum of squares, some hundredths of a unit of chi-square).
inline constexpr double kSloppyTolerance = 1e-6;
inline constexpr int kSloppyIterations = 60;

}  // namespace uiclink
