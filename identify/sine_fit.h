#pragma once

#include <optional>
#include <vector>

#include "identify/record.h"
#include "identify/release.h"

namespace uiclink {

struct SineFitOptions {
  /// Cut-off amplitude of the sliding arcs [m], > 0; default: 1.2 times the amplitude at which rolling starts, so that
  /// no part of an arc lies where the joints may roll.  The thesis took 10 mm lateral and 5 mm longitudinal.
  std::optional<double> cutoff;
  int rolling_periods = 0;  ///< periods for the rolling frequency; 0: as many as the rolling phase has
};

/// Reading from which the published method counts amplitudes.
enum class ZeroSource {
  kRestReading,  ///< at rest before the push, as the experimenter of 2003 set the zero (thesis, 4.2.2)
  kLateCentre,   ///< centre of the late motion, where the record has no rest reading
};

/// The sliding stiffness from one arc before an extremum.
struct SlidingArc {
  double extremum_t = 0;       ///< [s]
  double extremum = 0;         ///< amplitude a of the extremum from the zero used [m], > 0
  double k_published = 0;      ///< sine about zero through the cut-off point and the extremum (4.3.2), w^2/g [1/m]
  double k_corrected = 0;      ///< least squares over all samples of the arc with free centre, w^2/g [1/m]; 0: no fit
  double k_corrected_std = 0;  ///< its standard deviation from the scatter of the samples [1/m]
  double centre = 0;           ///< fitted centre of the arc relative to the zero used [m]; theory: -sign(a) T0/k
  double omega_published = 0;  ///< [rad/s]
};

/// The frequency method of the thesis (4.3.2, 4.3.3) as published, and beside it the corrected one.
///
/// Published: a sine about zero, w = (acos(c/a)) / |t2 - t1| through the cut-off point (t1, c) and the extremum
/// (t2, a); while the joints slide the centre is at -+T0/k instead, so k comes out high, the more the smaller the
/// extremum (CalcPublishedBias).  That dependence is visible in `arcs`.  Both points are located between samples.
/// The value of a record is that of its first and largest extremum, where the thesis reads it ("a single extremum prior
/// to pure rolling"); a mean over all arcs would mix different biases.
///
/// Corrected: one frequency, one zero and one shift o = T0/k for all arcs together, an amplitude and a phase for each
/// (identify/sliding_arc.h).  Its arcs reach farther back than the published ones: over all samples behind a travel of
/// twice the cut-off since the extremum before, where every joint slides.  One arc by itself (SlidingArc::k_corrected)
/// cannot tell frequency from centre well: both bend it alike.
struct SineFit {
  double cutoff = 0;  ///< [m]
  double zero = 0;    ///< reading that amplitudes are counted from [m]
  ZeroSource zero_source = ZeroSource::kLateCentre;
  std::vector<SlidingArc> arcs;  ///< every sliding arc before an extremum above the cut-off
  double omega_sliding = 0;      ///< published method, of arcs[0] [rad/s]
  double omega_rolling = 0;      ///< 2 pi N / (t2 - t1) [rad/s]
  int rolling_periods = 0;       ///< N
  double rolling_from = 0;       ///< t1 of the rolling frequency [s]
  double rolling_to = 0;         ///< t2 [s]
  double k = 0;                  ///< published: omega_sliding^2/g [1/m]
  double sum_ki = 0;             ///< published: omega_rolling^2/g - k [1/m]
  /// sum T0i that reproduces the loss of the first free cycle with these stiffnesses and one slider [-]; from
  ///   k (A0 - A2)/2 = 2 T0 - 2 (T0^2/sum_ki) (1/(A0+A1) + 1/(A1+A2)),  which is free of the zero.
  double T0 = 0;
  /// False where no T0 loses that much with these stiffnesses: T0 is then the one that loses most.
  bool T0_reproduces_loss = true;
  double k_corrected = 0;       ///< [1/m]
  double k_corrected_std = 0;   ///< from the scatter of the samples [1/m]
  double sum_ki_corrected = 0;  ///< omega_rolling^2/g - k_corrected [1/m]
  double T0_corrected = 0;      ///< k_corrected times the shift of the arc centres [-]
  double T0_corrected_std = 0;  ///< from the scatter of the samples [-]
};

/// Applies the method to one record.  The arc before the first extremum counts only if the push ended before it.
/// @returns nothing when no arc reaches above the cut-off, or the record has no full period of rolling.
std::optional<SineFit> FitSine(const Record& record, const Phases& phases, const SineFitOptions& options = {});

/// Bias of the published k for an extremum a, cut-off c and slider shift o = T0/k (literature: sine about zero although
/// the centre of sliding is at -+o):  k_est/k = ( acos(c/a) / acos((c+o)/(a+o)) )^2.
/// All in metres; 0 < c < a, o >= 0.  @throws std::invalid_argument otherwise.
double CalcPublishedBias(double a, double c, double o);

}  // namespace uiclink
