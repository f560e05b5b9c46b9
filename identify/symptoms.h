#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "identify/record.h"
#include "identify/sine_fit.h"
#include "model/oscillator.h"
#include "model/parameter_set.h"

namespace uiclink {

/// One record as its symptoms are read from: measured and modelled readings on the same samples.
struct SymptomInput {
  const Record* record = nullptr;         ///< readings y [m], times t [s]
  std::size_t first = 0, size = 0;        ///< the fitted samples, from the first free extremum on
  std::span<const double> modelled = {};  ///< readings of the fitted model at those samples [m], sensor's zero included
  double sigma = 0;                       ///< noise of a reading [m], > 0
  double quantum = 0;                     ///< step of the readings [m]; 0: none
  double offset = 0;                      ///< sensor's zero in the fit [m]
  Oscillator<double> link;                ///< fitted link of this record
  const SineFit* sine = nullptr;          ///< the published frequency method; may be missing

  /// What the fit could follow: derivatives of the readings, in units of sigma, by the unknowns that this record has
  /// for itself and by those that it shares with the other records (same columns for all). A residual never holds
  /// these directions, and every error below knows it. Missing: the fit counts as known beforehand, and |z| of a
  /// clean record comes out too small.
  const Eigen::MatrixXd* own = nullptr;
  const Eigen::MatrixXd* common = nullptr;

  std::span<const double> t() const { return {record->t.data() + first, size}; }
  std::span<const double> y() const { return {record->y.data() + first, size}; }
};

/// One read-out of the records beside the same read-out of the model.
struct Symptom {
  std::string id;        ///< snake_case, does not change: "loss_per_half_cycle_small", "mains_line"
  std::string sentence;  ///< what an engineer would say: "between 5 and 9 mm the record loses 2.1 times the energy ..."
  double measured = 0;   ///< means over the records, weighted by what each says about it
  double modelled = 0;
  std::string unit;
  double z = 0;          ///< difference over its standard error, all records together; unsigned ones are positive
  bool of_model = true;  ///< false: a bias of a method, nothing that the model lacks

  bool IsSignificant() const;
};

/// |z| from which a symptom counts.  Of 640 studies of clean records of the rig (1 to 10 records, three links) 8 had
/// any read-out above it; there are about 25.
inline constexpr double kSymptomThreshold = 3.5;

/// A curve to draw: measured beside modelled.  x, measured, modelled and error have the same length; `record` holds the
/// number of the record that each point belongs to (-1: all together).
struct SymptomCurve {
  std::string id, title, x_label, y_label;  ///< labels carry the unit
  std::vector<int> record;
  std::vector<double> x, measured, modelled, error;
};

/// Loss per cycle ~ A^p while the joints only roll: 1 dry friction, 2 viscous, 3 quadratic drag or micro-slip.
struct DecayExponent {
  bool known = false;        ///< the records have a rolling phase, it loses energy, and the interval is closed
  double p = 0;              ///< [-]
  double low = 0, high = 0;  ///< 95 % interval
  double from = 0, to = 0;   ///< amplitudes that it was read from [m]
  double loss = 0;           ///< amplitude that a half cycle loses there, mean [m]
  double modelled_loss = 0;  ///< the same of the model [m]
  double z = 0;              ///< of a loss being there
  double largest_ratio = 0;  ///< largest over smallest amplitude of a record; below 3 kinds of loss look alike
};

struct Symptoms {
  std::vector<Symptom> list;  ///< strongest first; insignificant ones are there too
  std::vector<SymptomCurve> curves;
  DecayExponent exponent;
};

/// Everything that the model gets wrong, as an engineer would look for it, each computed from readings and model by the
/// same code.
///
/// Errors come from draws: the model's readings plus noise of the records' level, less what the fit would have
/// followed, go through the same read-outs (100 draws: each error is known to 7 %). So z is standard normal for a
/// record of the model, whatever the read-out. Where the model is wrong, z says how surely, not how much.
///
/// A quantity at some amplitude is compared with the model at the same amplitude, not at the same time.
/// @throws std::invalid_argument when a record and its modelled readings do not fit together, or sigma is not positive.
Symptoms FindSymptoms(std::span<const SymptomInput> records, Direction direction);

}  // namespace uiclink
