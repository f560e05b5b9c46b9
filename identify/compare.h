#pragma once

#include <optional>
#include <string>
#include <vector>

#include "identify/fit_problem.h"
#include "identify/record.h"
#include "identify/report.h"
#include "identify/validate.h"
#include "model/parameter_set.h"

namespace uiclink {

/// A parameter set under comparison.
struct ComparedSet {
  std::string file;
  std::string label;  ///< the name that the set gives itself, where these differ between the sets; else the file
  std::string source;
  double g = kThesisGravity;  ///< that it was normalised with [m/s^2]
  double load_N = 0;          ///< during its measurement [N]
};

/// How one parameter set does on one record: only the start of the record (amplitude, time, zero) is fitted, and what
/// effects of the set leave to each record (the amplitude of a tone, the drift of the zero).
struct SetOnRecord {
  bool used = false;       ///< false: the set cannot be simulated in this direction (Comparison::why_not)
  double rms = 0;          ///< [m]
  Start start{};           ///< as fitted
  bool converged = false;  ///< otherwise the rms is an upper bound
};

struct ComparedRecord {
  std::string file;
  std::size_t samples = 0;           ///< from the first free extremum
  double noise = 0;                  ///< standard deviation of a reading [m]
  std::vector<SetOnRecord> results;  ///< by set
};

/// Measured and modelled frequency and loss about one amplitude.
///
/// A cycle is what lies between three extrema y0, y1, y2 of the free decay, so that the sensor's zero cancels:
///   amplitude (|y0 - y1| + |y1 - y2|)/4,   frequency 1/(t2 - t0),   loss per half cycle |y0 - y2|/2.
/// The model's cycle has the same amplitude, by the same formulas; its half cycles are CalcHalfCycle's, or simulated
/// where the set has effects (compare_effects.h).
struct AmplitudePoint {
  int cycles = 0;                 ///< averaged
  double amplitude = 0;           ///< mean [m]
  double measured_frequency = 0;  ///< [Hz]
  double measured_loss = 0;       ///< amplitude lost in a half cycle [m]
  std::vector<double> frequency;  ///< by set [Hz]; NaN where the set is not simulated, or would not swing through
  std::vector<double> loss;       ///< by set [m]; NaN as above
};

/// The sets by themselves at one amplitude: in closed form (model/closed_form.h), with effects as compare_effects.h has
/// it.
struct BackbonePoint {
  double amplitude = 0;           ///< [m]
  std::vector<double> frequency;  ///< by set: of the half cycle that starts there [Hz]; NaN where not simulated
  std::vector<double> loss;       ///< by set: energy lost in a steady cycle per unit load [m]; NaN where not simulated
};

/// Parameter sets in one direction, on the records of that direction.
///
/// A set's values are divided by M g with the g of the set, so set.g k is the k/M that was measured. It is kept: a
/// record whose header has another g is simulated with the set's values and the set's g, which is the same as scaling
/// the values by set.g/record.g. (That the bench of the record stood at another place, where gravity and so the
/// pendulum stiffness differ, cannot be told from two conventions for the same g.) The mass does not enter: stiffness
/// and friction of a link are proportional to its load.
struct Comparison {
  Direction direction = Direction::kLateral;
  std::vector<DirectionParameters> parameters;  ///< by set; k = 0 where the set lacks the direction
  std::vector<std::string> why_not;             ///< by set: why it is not simulated; empty where it is
  std::vector<ComparedRecord> records;          ///< used
  std::vector<Rejected> left_out;               ///< unusable records, with the reason
  std::vector<SetOnRecord> overall;             ///< by set: rms over all samples
  double noise = 0;                             ///< rms over all samples [m]
  std::vector<AmplitudePoint> points;           ///< by falling amplitude, binned over the records
  std::vector<BackbonePoint> backbone;          ///< at standard amplitudes

  /// The set with the smallest overall rms; -1 without records, or with fewer than two sets that can be simulated.
  int FindBest() const;
};

struct CompareResult {
  std::vector<ComparedSet> sets;
  std::vector<Comparison> comparisons;
  std::vector<Rejected> rejected;    ///< files that could not be read
  std::vector<std::string> notices;  ///< what was assumed about records, with the file
  std::optional<Validation> wagon;   ///< the sets on the wagon, where that was asked for

  int CountUsed() const;     ///< records
  int CountLeftOut() const;  ///< records, and sets not simulated
};

/// Compares sets on records, direction by direction. Without records, in each direction that a set has: parameters,
/// backbone and loss side by side. A set is not simulated, and why_not says so, where it lacks the direction or has
/// more than kMaxFittedSliders sliders.
/// @param files  of the sets, for labels and messages.
/// @throws InputError for effects of a set that the catalogue does not have as they are (MakeSetModel).
CompareResult Compare(const std::vector<std::string>& files, const std::vector<ParameterSet>& sets,
                      std::vector<Record> records);

/// The sets as they stand in their files, for ValidateOnWagon with ValidateOptions::side_by_side. One that cannot run
/// is a row with its reason.
/// @throws InputError where a file cannot be read any more.
std::vector<ValidationSet> MakeComparedSets(const CompareResult& result, const std::vector<ParameterSet>& sets);

/// Lines about what was left out: "file: reason".
std::vector<std::string> FormatLeftOut(const CompareResult& result);

std::string FormatComparison(const CompareResult& result);
std::string FormatComparisonJson(const CompareResult& result);  ///< schema "identify-compare/1"

}  // namespace uiclink
