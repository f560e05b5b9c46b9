#include "identify/residual_spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "identify/significance.h"
#include "model/closed_form.h"

namespace uiclink {
namespace {

constexpr double kSteps = 2;           // of the frequency grid for each 1/T
constexpr std::size_t kAround = 30;    // grid steps to each side that make the surroundings
constexpr std::size_t kLineWidth = 4;  // grid steps that one line fills under a Hann window
constexpr std::size_t kMaxLines = 6;   // more are no lines but a shape
constexpr int kMaxMains = 5, kMaxHarmonic = 6, kMaxBand = 3;
constexpr double kMainsTolerance = 0.1;  // of a multiple of the mains [Hz], times its order
constexpr double kLowestAlias = 2;       // below, a folded multiple is not told from drift and motion [Hz]
// The link's frequencies in both directions, from the thesis's parameter sets (0.92 to 1.86 Hz).
constexpr double kLowestLink = 0.9, kHighestLink = 1.9;

struct Spectrum {
  double step = 0;             // [Hz]
  std::vector<double> power;   // sum over the records, in units of their noise; each adds 1 on the average
  std::vector<double> square;  // sum over the records of the squared amplitude of a steady tone [m^2]
  double records = 0;
  double sampling_hz = 0;  // lowest
};

/// Power of one record at the frequencies of the grid.
void AddRecord(const SymptomInput& input, Spectrum* spectrum) {
  const std::size_t n = input.size, padded = std::bit_ceil(4 * n);
  std::vector<double> series(padded, 0.0);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double window =
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    series[i] = window * (input.y()[i] - input.modelled[i]);
    sum += window, squares += window * window;
  }
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  std::vector<std::complex<double>> transform;
  fft.fwd(transform, series);
  for (std::size_t k = 0; k < spectrum->power.size(); ++k) {
    const double f = spectrum->step * static_cast<double>(k);
    const auto bin = static_cast<std::size_t>(std::lround(f / input.record->sampling_hz * static_cast<double>(padded)));
    const double power = std::norm(transform[std::min(bin, transform.size() - 1)]);
    spectrum->power[k] += power / (squares * input.sigma * input.sigma);
    spectrum->square[k] += 4 * power / (sum * sum);
  }
}

Spectrum CalcSpectrum(std::span<const SymptomInput> records) {
  Spectrum spectrum;
  double longest = 0;
  for (const SymptomInput& input : records) {
    if (!input.record->uniform) continue;
    const double rate = input.record->sampling_hz;
    spectrum.sampling_hz = spectrum.records > 0 ? std::min(spectrum.sampling_hz, rate) : rate;
    longest = std::max(longest, static_cast<double>(input.size) / rate);
    ++spectrum.records;
  }
  if (!(spectrum.records > 0)) return spectrum;
  spectrum.step = 1 / (kSteps * longest);
  const auto size = static_cast<std::size_t>(0.5 * spectrum.sampling_hz / spectrum.step);
  spectrum.power.resize(size), spectrum.square.resize(size);
  for (const SymptomInput& input : records)
    if (input.record->uniform) AddRecord(input, &spectrum);
  return spectrum;
}

/// Median of the surroundings, as a multiple of the noise; never below it.
double CalcFloor(const Spectrum& spectrum, std::size_t k) {
  std::vector<double> around;
  const std::size_t first = k > kAround ? k - kAround : 1, last = std::min(k + kAround + 1, spectrum.power.size());
  for (std::size_t i = first; i < last; ++i)
    if (i + kLineWidth < k || i > k + kLineWidth) around.push_back(spectrum.power[i]);
  if (around.empty()) return 1;
  const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
  std::nth_element(around.begin(), middle, around.end());
  return std::max(1.0, *middle / (spectrum.records - 1.0 / 3));  // median of a gamma variable of that shape
}

/// Frequencies that are highest within the width of a line, strongest first.
std::vector<SpectralLine> FindLines(const Spectrum& spectrum) {
  std::vector<SpectralLine> lines;
  const std::size_t n = spectrum.power.size();
  for (std::size_t k = 1; k < n; ++k) {
    const std::size_t first = k > kLineWidth ? k - kLineWidth : 1, last = std::min(n, k + kLineWidth + 1);
    const auto begin = spectrum.power.begin();
    if (*std::max_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(last)) >
        spectrum.power[k])
      continue;
    const double log_p = CalcLogChiSquareTail(2 * spectrum.power[k] / CalcFloor(spectrum, k), 2 * spectrum.records);
    lines.push_back({.frequency = spectrum.step * static_cast<double>(k),
                     .amplitude = std::sqrt(spectrum.square[k] / spectrum.records),
                     .z = CalcNormalEquivalent(log_p + std::log(static_cast<double>(n)))});
  }
  std::sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.z > b.z; });
  lines.resize(std::min(lines.size(), kMaxLines));
  return lines;
}

MotionBand CalcMotionBand(std::span<const SymptomInput> records) {
  MotionBand band;
  for (const SymptomInput& input : records) {
    band.sliding += CalcSlidingFrequency(input.link) / (2 * std::numbers::pi);
    band.rolling += CalcRollingFrequency(input.link) / (2 * std::numbers::pi);
  }
  const auto n = static_cast<double>(records.size());
  return {band.sliding / n, band.rolling / n};
}

const char* IdOf(const SpectralLine& line) {
  switch (line.origin) {
    case LineOrigin::kMotion:
      return "motion_line";
    case LineOrigin::kMains:
      return "mains_line";
    case LineOrigin::kCrossAxis:
      return "cross_axis_line";
    case LineOrigin::kDrift:
      return "drift_line";
    case LineOrigin::kUnknown:
      break;
  }
  return "unknown_line";
}

std::string Describe(const SpectralLine& line, Direction direction, double sampling_hz) {
  switch (line.origin) {
    case LineOrigin::kMotion:
      return line.harmonic == 1 ? std::string("the motion itself")
                                : fmt::format("harmonic {} of the motion", line.harmonic);
    case LineOrigin::kMains: {
      const double tone = line.base * line.harmonic;
      return tone < 0.5 * sampling_hz
                 ? fmt::format("the mains, {} times {:.0f} Hz", line.harmonic, line.base)
                 : fmt::format("the mains, {:.0f} Hz folded by sampling at {:g} Hz", tone, sampling_hz);
    }
    case LineOrigin::kCrossAxis:
      return fmt::format("no harmonic of this motion, but where the link swings in its {} direction",
                         Name(direction == Direction::kLateral ? Direction::kLongitudinal : Direction::kLateral));
    case LineOrigin::kDrift:
      return "slower than three cycles in a record: a drift, or a bend of the mid-line";
    case LineOrigin::kUnknown:
      break;
  }
  return fmt::format("neither harmonic nor mains nor the other direction; a tone above {:g} Hz would be folded, too",
                     0.5 * sampling_hz);
}

void AddCurve(const Spectrum& spectrum, Symptoms* symptoms) {
  SymptomCurve curve{"residual_spectrum",
                     "Spectrum of the residual",
                     "frequency [Hz]",
                     "power over that of white noise [-]",
                     {},
                     {},
                     {},
                     {},
                     {}};
  for (std::size_t k = 1; k < spectrum.power.size(); ++k) {
    curve.record.push_back(-1);
    curve.x.push_back(spectrum.step * static_cast<double>(k));
    curve.measured.push_back(spectrum.power[k] / spectrum.records);
    curve.modelled.push_back(1);
    curve.error.push_back(1 / std::sqrt(spectrum.records));
  }
  symptoms->curves.push_back(std::move(curve));
}

}  // namespace

SpectralLine NameLine(double f, double resolution, const MotionBand& motion, double sampling_hz) {
  SpectralLine line{.frequency = f};
  if (f < 3 * resolution) {
    line.origin = LineOrigin::kDrift;
    return line;
  }
  for (int n = 1; n <= kMaxMains; ++n)
    for (const double base : {50.0, 60.0}) {
      const double tone = base * n, folded = std::abs(tone - sampling_hz * std::round(tone / sampling_hz));
      if (folded < kLowestAlias || std::abs(f - folded) > kMainsTolerance * n + resolution) continue;
      line.origin = LineOrigin::kMains, line.harmonic = n, line.base = base;
      return line;
    }
  for (int n = 1; n <= kMaxHarmonic; ++n) {
    const bool in_band = f > n * motion.sliding - resolution && f < n * motion.rolling + resolution;
    // Bands of higher harmonics overlap; there only the rolling motion, which is most of a record, makes a line.
    if (n <= kMaxBand ? !in_band : std::abs(f - n * motion.rolling) > resolution) continue;
    line.origin = LineOrigin::kMotion, line.harmonic = n;
    return line;
  }
  if (f > kLowestLink && f < kHighestLink) line.origin = LineOrigin::kCrossAxis;
  return line;
}

void FindSpectralSymptoms(std::span<const SymptomInput> records, Direction direction, Symptoms* symptoms) {
  const Spectrum spectrum = CalcSpectrum(records);
  if (spectrum.power.empty()) return;
  const MotionBand motion = CalcMotionBand(records);
  std::vector<std::string> seen;
  for (SpectralLine line : FindLines(spectrum)) {
    const SpectralLine named = NameLine(line.frequency, kSteps * spectrum.step, motion, spectrum.sampling_hz);
    line.origin = named.origin, line.harmonic = named.harmonic, line.base = named.base;
    const bool significant = line.z > kSymptomThreshold;
    if (!significant && !seen.empty()) break;
    // One line of each kind; the strongest is reported even where it says nothing.
    const std::string id = significant ? IdOf(line) : "residual_line";
    if (std::find(seen.begin(), seen.end(), id) != seen.end()) continue;
    seen.push_back(id);
    symptoms->list.push_back(
        {.id = id,
         .sentence = fmt::format("the residual {} {:.2f} Hz (amplitude {:.4f} mm): {}",
                                 significant ? "has a line at" : "has no clear line; its highest point is at",
                                 line.frequency, 1e3 * line.amplitude, Describe(line, direction, spectrum.sampling_hz)),
         .measured = 1e3 * line.amplitude,
         .modelled = 0,
         .unit = "mm",
         .z = line.z});
  }
  AddCurve(spectrum, symptoms);
}

}  // namespace uiclink
