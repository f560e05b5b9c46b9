#pragma once

#include <optional>
#include <vector>

#include "identify/record.h"
#include "identify/release.h"

namespace uiclink {

struct SineFitOptions {
  std::optional<double> cutoff;  ///< cut-off amplitude of the sliding arcs [m]; default: chosen from the late amplitude
  int rolling_periods = 0;       ///< periods for the rolling frequency; 0: as many as the rolling phase has
};

/// The sliding stiffness from one arc before an extremum.
struct SlidingArc {
  double extremum_t = 0;   ///< [s]
  double extremum = 0;     ///< amplitude a of the extremum from the centre used [m], > 0
  double k_published = 0;  ///< sine about zero through the cut-off point and the extremum (thesis 4.3.2), w^2/g [1/m]
  double k_corrected = 0;  ///< least squares over all samples of the arc with free centre, w^2/g [1/m]
  double centre = 0;       ///< fitted centre of the arc relative to the zero used [m]; theory: -sign(a) T0/k
  double omega_published = 0;  ///< [rad/s]
};

/// The frequency method of the thesis (4.3.2, 4.3.3) as published, and beside it the corrected one.
struct SineFit {
  double cutoff = 0;              ///< [m]
  double zero = 0;                ///< reading that amplitudes are counted from [m]
  std::vector<SlidingArc> arcs;   ///< every sliding arc before an extremum above the cut-off
  double omega_sliding = 0;       ///< mean over the arcs, published method [rad/s]
  double omega_rolling = 0;       ///< 2 pi N / (t2 - t1) [rad/s]
  int rolling_periods = 0;        ///< N
  double k = 0;                   ///< published: omega_sliding^2/g of each arc, mean [1/m]
  double sum_ki = 0;              ///< published: (omega_rolling^2 - omega_sliding^2)/g [1/m]
  double T0 = 0;                  ///< sum T0i that reproduces the first decrement with these stiffnesses [-]
  double k_corrected = 0;         ///< [1/m]
  double sum_ki_corrected = 0;    ///< [1/m]
  double T0_corrected = 0;        ///< k_corrected times the shift of the arc centres [-]
};

/// Applies the method to one record.  @returns nothing when no arc reaches above the cut-off or the record never rolls.
std::optional<SineFit> FitSine(const Record& record, const Phases& phases, const SineFitOptions& options = {});

/// Bias of the published k for an extremum a, cut-off c and slider shift o = T0/k (literature: sine about zero although
/// the centre of sliding is at -+o):  k_est/k = ( acos(c/a) / acos((c+o)/(a+o)) )^2.   All in metres, 0 < c < a, o >= 0.
double CalcPublishedBias(double a, double c, double o);

}  // namespace uiclink
