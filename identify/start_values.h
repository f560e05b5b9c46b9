#pragma once

#include <optional>
#include <vector>

#include "identify/fit_problem.h"
#include "identify/release.h"

namespace uiclink {

/// The samples of the free decay and what limits their fit.  The record must outlive the result.
FitData MakeFitData(const Record& record, const Noise& noise, const Phases& phases);

/// Link and start of one record, read off its extrema without a fit.
struct StartValues {
  Oscillator<double> link;  ///< one slider
  Start start{};
  double misfit = 0;  ///< rms distance of the half-cycle map from the measured extrema [m]
};

/// One-slider link whose half-cycle map passes best through the measured extrema.
///
/// The late half periods give k + k1. For each ratio k1/k the first decrement gives T0 in closed form, from
///   (k/2)(A^2 - A'^2) = T0 (A + A') - 2 T0^2/k1,
/// and the map, iterated, the remaining amplitudes and times; the ratio with the smallest misfit wins.  When k1 < k the
/// late amplitude T0/k1 is thereby matched too.
StartValues FindStartValues(const Phases& phases, double g);

/// The same link with slider `split` replaced by two that together do the same until one of them slides: half the
/// stiffness each, the friction divided so that their critical displacements are apart by the ratio `spread` (> 1).
Oscillator<double> SplitSlider(const Oscillator<double>& link, int split, double spread);

/// The same link with sliders `first` and `first + 1` replaced by one that has the sums of both.
Oscillator<double> MergeSliders(const Oscillator<double>& link, int first);

/// Growing windows for the fit [s from the first extremum]: one, two, four ... periods.
std::vector<double> GrowingWindows(const Phases& phases);

}  // namespace uiclink
