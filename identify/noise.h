#pragma once

#include <span>

namespace uiclink {

/// What the readings of a record are worth.
struct Noise {
  /// Standard deviation of one reading about the motion [m]: sensor noise and quantisation (quantum^2/12) together.
  double sigma = 0;
  /// Step of the A/D converter or of the print [m], whichever is coarser; 0 where the readings lie on no lattice.
  double quantum = 0;
};

/// Noise of the readings y [m] at the times t [s], from the readings alone.
///
/// The record is cut into blocks of about 0.1 s. In each, the motion is a polynomial in time; what its degree does
/// not explain is noise:  sigma^2 = sum r^2 / (N - degree - 1).  The degree is the lowest whose higher coefficients
/// carry no more than noise, and one more. Blocks with a kink (stick/slip), a spike or an impact stand out against the
/// chi-square distribution of the others and are left out; the mean of the others is corrected for that cut.
///
/// Readings that stand still on one step of the lattice say nothing about noise, so blocks that move by less than four
/// steps are not used where others do; and sigma is never below quantum / sqrt(12), the deviation of rounding alone.
///
/// Where the motion is resolved (ten or more samples per period) the estimate is unbiased for white noise: on 12 s of
/// a decay at 200 Hz its own standard deviation is about 1.7 % (1.44 % is the least possible). Coloured noise counts as
/// far as it is faster than the block; steady tones above about 30 Hz count as noise.
///
/// @throws std::invalid_argument when t and y differ in length, hold fewer than 16 values, or t does not increase.
Noise EstimateNoise(std::span<const double> t, std::span<const double> y);

/// Noise of a record that states the standard deviation of each sample (digitised, tracked): sigma is no less than
/// their rms. Such samples err together over some of their neighbours, so the readings alone look far quieter than they
/// are. Without stated values as EstimateNoise(t, y).
Noise EstimateNoise(std::span<const double> t, std::span<const double> y, std::span<const double> stated);

/// Step of the lattice that the readings lie on, allowing for a coarser lattice behind the print: values that are
/// multiples of 0.015625 mm (plus any offset), printed with three decimals. Same unit as `y`; 0 where there is none.
double FindQuantum(std::span<const double> y);

}  // namespace uiclink
