#include "vehicle/spectrum_peaks.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace uiclink {
namespace {

constexpr double kLeastShare = 0.02;
constexpr double kNothing = 1e-12;
constexpr std::size_t kReach = 4;  ///< lines

}  // namespace

double HannWindow(std::size_t sample, std::size_t n) {
  return 0.5 * (1 - std::cos(2 * std::numbers::pi * static_cast<double>(sample) / static_cast<double>(n)));
}

std::vector<std::complex<double>> TransformHann(std::span<const double> samples) {
  const std::size_t n = samples.size();
  std::vector<std::complex<double>> lines;
  if (n < 2) return lines;
  std::vector<double> window(n), windowed(n);
  // The mean under the window, so that nothing of it is left in the first lines.
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < n; ++i) {
    window[i] = HannWindow(i, n);
    sum += window[i] * samples[i];
    weight += window[i];
  }
  const double mean = sum / weight;
  for (std::size_t i = 0; i < n; ++i) windowed[i] = (samples[i] - mean) * window[i];
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(lines, windowed);
  return lines;
}

namespace {

std::vector<double> CalcAmplitudes(std::span<const double> samples) {
  const std::vector<std::complex<double>> lines = TransformHann(samples);
  std::vector<double> amplitudes(lines.size());
  // The window halves a sine, and so does the other half of the spectrum.
  for (std::size_t i = 0; i < lines.size(); ++i)
    amplitudes[i] = 4 * std::abs(lines[i]) / static_cast<double>(samples.size());
  return amplitudes;
}

}  // namespace

std::vector<SpectrumPeak> FindSpectrumPeaks(std::span<const double> samples, double hz, std::size_t most) {
  std::vector<SpectrumPeak> peaks;
  if (samples.size() < 16) return peaks;
  const std::vector<double> a = CalcAmplitudes(samples);
  const double highest = *std::max_element(a.begin() + 1, a.end());
  if (!(highest > kNothing)) return peaks;
  for (std::size_t i = 1; i + 1 < a.size(); ++i) {
    const std::size_t from = i > kReach ? i - kReach : 1;
    const std::size_t to = std::min(i + kReach + 1, a.size());
    const auto first = a.begin() + static_cast<std::ptrdiff_t>(from);
    const auto last = a.begin() + static_cast<std::ptrdiff_t>(to);
    if (a[i] < kLeastShare * highest || std::max_element(first, last) != a.begin() + static_cast<std::ptrdiff_t>(i))
      continue;
    const double left = std::log(std::max(a[i - 1], 1e-300));
    const double middle = std::log(a[i]);
    const double right = std::log(std::max(a[i + 1], 1e-300));
    const double bend = left - 2 * middle + right;
    const double shift = bend < 0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
    peaks.push_back({.frequency = (static_cast<double>(i) + shift) * hz / static_cast<double>(samples.size()),
                     .amplitude = std::exp(middle - 0.25 * (left - right) * shift)});
  }
  std::sort(peaks.begin(), peaks.end(),
            [](const SpectrumPeak& x, const SpectrumPeak& y) { return x.amplitude > y.amplitude; });
  if (peaks.size() > most) peaks.resize(most);
  return peaks;
}

}  // namespace uiclink
