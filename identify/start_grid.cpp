#include "identify/start_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "identify/extension.h"

namespace uiclink {
namespace {

constexpr std::size_t kLines = 4;  // of a spectrum that are tried

double LargestSwing(std::span<const FitData> data) {
  double swing = 0;
  for (const FitData& d : data) swing = std::max(swing, d.swing);
  return swing;
}

/// Largest reading of the fitted parts, by size [m].
double LargestReading(std::span<const FitData> data) {
  double largest = 0;
  for (const FitData& d : data)
    for (std::size_t i = 0; i < d.size; ++i) largest = std::max(largest, std::abs(d.record->y[d.first + i]));
  return largest;
}

}  // namespace

bool HasNoScore(const Effect& effect) {
  return std::isinf(effect.neutral) && effect.parameters[0].coordinate == Coordinate::kLinear;
}

std::vector<StartPoint> StartGrid::Make(const Effect& effect) const {
  std::vector<std::vector<double>> points = {{}};
  for (std::size_t p = 0; p < effect.parameters.size(); ++p) {
    const EffectParameter& parameter = effect.parameters[p];
    std::vector<double> values = {0.0};
    const bool is_size = p == 0 || (effect.quadrature && p == 1);
    if (!is_size || HasNoScore(effect)) {
      values = Values(effect, parameter);
    } else {
      values = {p == 0 ? NearNeutral(effect) : 0.0};
    }
    std::vector<std::vector<double>> longer;
    for (const std::vector<double>& point : points)
      for (const double value : values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    points = std::move(longer);
  }
  std::vector<StartPoint> starts;
  for (const std::vector<double>& point : points) {
    StartPoint start;
    for (std::size_t p = 0; p < point.size(); ++p)
      (effect.parameters[p].scope == Scope::kLink ? start.shared : start.own).push_back(point[p]);
    starts.push_back(start);
  }
  return starts;
}

double StartGrid::NearNeutral(const Effect& effect) const {
  constexpr double kBeside = 1e-5;  // of a size that shows clearly: below what any record resolves
  const EffectParameter& size = effect.parameters[0];
  const double neutral = ToCoordinate(size, effect.neutral);
  const bool one_sided = size.coordinate == Coordinate::kLinear && size.low == effect.neutral;
  return one_sided ? neutral + kBeside * Values(effect, size)[0] : neutral;
}

std::vector<double> StartGrid::Values(const Effect& effect, const EffectParameter& parameter) const {
  std::vector<double> values;
  if (parameter.start_scale == StartScale::kSpectrum) {
    for (const double decay : {0.0, 0.5}) {
      const double nyquist = 0.5 * data_[0].record->sampling_hz;
      const bool steady = effect.parameters.size() <= 3;
      // A steady tone may be folded onto the very end of the spectrum; one that dies away needs room about it.
      const double low = parameter.low, high = std::min(parameter.high, (steady ? 1.0 : 0.98) * nyquist);
      if (steady && decay > 0) continue;
      for (const double f : FindLines(residuals_, data_[0].record->sampling_hz, low, high, decay, kLines))
        values.push_back(f);
    }
  } else {
    double scale = 1;
    if (parameter.start_scale == StartScale::kSwing)
      scale = effect.stage == ReadingStage::kClipped ? LargestReading(data_) : LargestSwing(data_);
    if (parameter.start_scale == StartScale::kSpeed) scale = LargestSwing(data_) * Frequency();
    for (const double start : parameter.starts)
      values.push_back(std::clamp(start * scale, parameter.low, parameter.high));
  }
  for (double& value : values) value = ToCoordinate(parameter, value);
  return values;
}

double StartGrid::Frequency() const {
  return std::sqrt(data_[0].g * (std::exp(link_.levels[0][0]) + 0.5 * std::exp(link_.levels[0][1])));
}

std::vector<double> FindLines(std::span<const std::vector<float>> residuals, double sampling_hz, double low_hz,
                              double high_hz, double decay, std::size_t count) {
  constexpr std::size_t kLanes = 8;
  std::size_t longest = 0;
  for (const std::vector<float>& r : residuals) longest = std::max(longest, r.size());
  const double step_hz = 0.4 * sampling_hz / static_cast<double>(std::max<std::size_t>(longest, 1));
  const auto size = static_cast<std::size_t>(std::max(0.0, (high_hz - low_hz) / step_hz)) + 1;
  std::vector<double> power(size + kLanes - 1);
  for (const std::vector<float>& series : residuals) {
    std::vector<double> weighted(series.begin(), series.end());
    for (std::size_t i = 0; i < weighted.size(); ++i)
      weighted[i] *= std::exp(-decay * static_cast<double>(i) / sampling_hz);
    // Goertzel: one multiplication a sample. One frequency alone would wait for its own last sum.
    for (std::size_t k = 0; k < size; k += kLanes) {
      std::array<double, kLanes> twice{}, s1{}, s2{};
      for (std::size_t l = 0; l < kLanes; ++l)
        twice[l] = 2 * std::cos(2 * std::numbers::pi * (low_hz + static_cast<double>(k + l) * step_hz) / sampling_hz);
      for (const double x : weighted)
        for (std::size_t l = 0; l < kLanes; ++l) {
          const double s0 = x + twice[l] * s1[l] - s2[l];
          s2[l] = s1[l];
          s1[l] = s0;
        }
      for (std::size_t l = 0; l < kLanes; ++l) power[k + l] += s1[l] * s1[l] + s2[l] * s2[l] - twice[l] * s1[l] * s2[l];
    }
  }
  power.resize(size);
  // The top of a peak lies between the frequencies that were tried.
  const auto find_top = [&](std::size_t k) {
    const double at = low_hz + static_cast<double>(k) * step_hz;
    if (k == 0 || k + 1 == size) return at;
    const double bend = power[k - 1] - 2 * power[k] + power[k + 1];
    return at + (bend < 0 ? 0.5 * (power[k - 1] - power[k + 1]) / bend : 0.0) * step_hz;
  };
  std::vector<std::size_t> peaks;
  for (std::size_t k = 0; k < size; ++k)
    if ((k == 0 || power[k] >= power[k - 1]) && (k + 1 == size || power[k] > power[k + 1])) peaks.push_back(k);
  std::sort(peaks.begin(), peaks.end(), [&](std::size_t a, std::size_t b) { return power[a] > power[b]; });
  std::vector<double> lines;
  for (const std::size_t k : peaks) {
    if (lines.size() == count) break;
    const double f = find_top(k);
    const bool near =
        std::any_of(lines.begin(), lines.end(), [&](double other) { return std::abs(other - f) < 3 * step_hz; });
    if (!near) lines.push_back(f);
  }
  return lines;
}

}  // namespace uiclink
