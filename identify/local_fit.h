#pragma once

#include <cstddef>
#include <optional>
#include <span>

namespace uiclink {

/// A few samples of an oscillation, smoothed:  y = c0 + c1 (s - w^2 s^3/6) + c2 (s^2 - w^2 s^4/12),  s = t - t0.
///
/// A harmonic motion about any centre, to fourth order, so the window may be half a radian wide and more.
/// Where joints stop sliding at an extremum the motion goes on with another frequency: the third derivative is
/// continuous, the fourth jumps, and the located time is off by (w_after^2 - w_before^2) W^3/96, W the half width of
/// the window: 0.12 ms for a lateral link at 25 mm and 0.013 mm of noise.
struct LocalFit {
  double t0 = 0;                  ///< [s]
  double c0 = 0, c1 = 0, c2 = 0;  ///< [m], [m/s], [m/s^2]
  double w = 0;                   ///< angular frequency of the cubic and quartic terms [rad/s]
  double half_width = 0;          ///< of the window [s]
  std::size_t size = 0;           ///< samples used

  double y(double t) const;
  double v(double t) const;
  /// Time within the window at which v = 0 / y = level; nothing where the curve does not get there.
  std::optional<double> FindTurning() const;
  std::optional<double> FindCrossing(double level) const;
  /// Standard deviation of y(t0) when each sample has the standard deviation sigma.
  double LevelError(double sigma) const;
};

/// Least squares over the samples with |t - t0| <= half_width.  @param w  angular frequency, about right [rad/s].
/// @returns nothing when fewer than five samples are there, or the window reaches beyond the record.
std::optional<LocalFit> FitLocally(std::span<const double> t, std::span<const double> y, std::size_t centre,
                                   double half_width, double w);

}  // namespace uiclink
