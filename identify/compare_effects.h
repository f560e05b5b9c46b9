#pragma once

#include <string>
#include <vector>

#include "identify/extension.h"
#include "identify/release.h"
#include "model/parameter_set.h"

namespace uiclink {

/// One direction of a parameter set, ready to be simulated: the plain link, and the effects beside it with their
/// parameters that belong to the link.  What belongs to a record (an amplitude, the drift of a zero) is no part of a
/// set and is fitted to each record.
struct SetModel {
  bool simulated = false;
  Oscillator<double> link;
  Extension extension;
  std::vector<double> shared;  ///< by extension.shared(), in coordinates

  bool IsPlain() const { return extension.empty(); }
};

/// @param g  that the set was normalised with [m/s^2].
/// @throws InputError "file: expected ..., found ..." for an effect that the catalogue does not have, a parameter that
///         the effect does not have or that belongs to a record, one that is missing, or one outside its bounds.
SetModel MakeSetModel(const DirectionParameters& parameters, double g, Direction direction, const std::string& file);

/// A full cycle of a decay, see AmplitudePoint.
struct Cycle {
  double amplitude = 0;  ///< mean [m]
  double frequency = 0;  ///< [Hz]
  double loss = 0;       ///< amplitude lost in a half cycle [m]
};
std::vector<Cycle> FindCycles(const std::vector<Extremum>& extrema);

/// Cycles of simulated free decays of an extended link, by amplitude: the first ones of decays from many amplitudes.
/// Effects on the reading do not show here; what changes in time is as it is where the record's clock is zero.
class CycleTable {
 public:
  /// @param largest  mean amplitude of the largest cycle that will be asked for [m]
  CycleTable(const SetModel& model, double largest);
  /// The cycle of the given mean amplitude, between those simulated; NaN below the smallest.
  Cycle About(double amplitude) const;

 private:
  std::vector<Cycle> cycles_;  // by rising amplitude
};

/// Frequency of the half cycle that starts at rest at amplitude A [Hz]; NaN where the mass stops before the other side.
double CalcExtendedFrequency(const SetModel& model, double A);

/// Energy that a steady cycle of amplitude A loses per unit load [m]: that of the sliders and of the forces beside
/// them. NaN where an effect changes the sliders themselves or has no closed form.
double CalcExtendedLoss(const SetModel& model, double A);

}  // namespace uiclink
