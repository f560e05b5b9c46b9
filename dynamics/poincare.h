#pragma once

#include <Eigen/Core>
#include <span>

namespace uiclink {

/// What the points of a Poincare section say about a motion.
enum class MotionKind {
  kEquilibrium,  ///< nothing passes the section
  kPeriodic,     ///< every k-th point is the same
  kModulated,    ///< the points wander with a period of their own and come back (torus)
  kIrregular,    ///< they do not come back: its Lyapunov exponent decides
  kSettling,     ///< they still move one way, or their deviations still grow or die away: `rate`
  kTooShort,     ///< too few points, or less than four periods of a modulation
};

struct SectionOptions {
  int most_returns = 8;  ///< largest k
  /// Points closer than this are the same [units of the scales], however steady the others are.
  double least = 1e-3;
  /// Scatter above this is never taken for noise about a periodic motion [units of the scales].
  double most = 5e-3;
  /// Over lags of a quarter to half of the series the points of a modulated motion come back with at least this
  /// correlation [-]. A torus comes as close to one as is waited for; of chaos nothing is left.
  double recurrence = 0.9;
  /// A deviation has a trend when it grows or falls from quarter to quarter of the series, in all by this factor.
  double trend = 1.35;
};

/// The kind of a motion by its section.
struct SectionMotion {
  MotionKind kind = MotionKind::kTooShort;
  int k = 1;                     ///< returns in a period; with modulation: of the periodic motion that is modulated
  double period = 0;             ///< of k returns, on average [s]
  double modulation_period = 0;  ///< kModulated, kIrregular (the strongest line): [s]; else 0
  /// Growth (+) or decay (-) of the deviation [1/s]: kSettling; also kPeriodic while it can be told from noise. Else 0.
  double rate = 0;
  double scatter = 0;      ///< rms distance of the points, second half of the series, from the k that they return to
  double tolerance = 0;    ///< that the scatter was compared with, from the data
  double correlation = 0;  ///< at the best of the long lags [-]; 0 unless it was looked at

  double e_folding() const { return rate != 0 ? 1 / (rate > 0 ? rate : -rate) : 0; }  ///< [s]; 0 without a rate
};

/// The kind of a motion from its passages through a section.
///
/// With p_i the points in units of the scales, e_k = rms |p_(i+k) - p_i| / sqrt(2) and s_k the rms distance from the
/// mean of every k-th point (both over the second half):
///   k           the smallest with e_k near the least of all
///   tolerance   3 e_k, within [least, most]. Points that scatter have s = e, those that drift or turn s >> e.
///   periodic    s_k <= tolerance, and e_k has no trend. It may fall where s_k <= least; where it grows the motion is
///               about to leave a cycle (settling)
///   trend       points run one way, or the rms distance from their means grows or falls in all four quarters:
///               rate = slope of its logarithm
///   modulated   correlation sum p_i p_(i+lag) at the best lag between a quarter and half of the series >= recurrence;
///               period: highest line of the spectrum of the first principal component
///   irregular   what is left
///
/// A motion that is irregular by less than `most` cannot be told from a periodic one with noise; its scatter says so.
///
/// @param times   of the passages [s], rising.
/// @param points  one column a passage.
/// @param scales  of the coordinates, > 0: what counts as one. Take the amplitude of the motion, so that `least` and
///                `most` are shares of it.
/// @throws std::invalid_argument for sizes that do not agree or scales that are not positive.
SectionMotion ClassifySection(std::span<const double> times, const Eigen::MatrixXd& points,
                              const Eigen::VectorXd& scales, const SectionOptions& options = {});

/// "periodic", ...
const char* MotionKindName(MotionKind kind);

}  // namespace uiclink
