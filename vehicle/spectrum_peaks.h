#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace uiclink {

/// Lines 0 to n/2 of the Fourier transform of n samples under a Hann window, their mean under it removed: sum of
/// window x sample x exp(-2 pi i line sample/n), not scaled. Empty for fewer than two samples.
std::vector<std::complex<double>> TransformHann(std::span<const double> samples);
/// The window: 0 at the first of n samples, 1 in the middle.
double HannWindow(std::size_t sample, std::size_t n);

struct SpectrumPeak {
  double frequency = 0;  ///< [Hz]
  double amplitude = 0;  ///< of a sine that makes this peak, in the unit of the samples
};

/// The highest peaks of the amplitude spectrum of evenly spaced samples, mean removed, with a Hann window, by falling
/// height: those above 2 % of the highest that no higher line is within four lines of (Hann's own side lobes).
/// Frequencies are refined between the lines by the parabola through the logarithms, to some 2 % of a line for a
/// steady sine, amplitudes to 3 %. Empty for fewer than 16 samples, or where nothing moves by more than 1e-12 of the
/// unit.
std::vector<SpectrumPeak> FindSpectrumPeaks(std::span<const double> samples, double hz, std::size_t most);

}  // namespace uiclink
