#include "identify/residual_patterns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "identify/half_swings.h"
#include "identify/harmonic_content.h"
#include "identify/significance.h"
#include "identify/statistics.h"

namespace uiclink {
namespace {

constexpr std::size_t kBins = 16;
constexpr double kFewestInBin = 10;
/// A residual's rms over the noise level that the same readings give scatters by this share of 1/sqrt(2n): the estimate
/// of the noise alone has 1.7 % where 1.44 % is the least possible (identify/noise.h), and both see the same noise.
constexpr double kRatioScatter = 0.63;

/// A record's residuals and what they may depend on.
struct Sampled {
  std::vector<double> residual;  // record less model [m]
  std::vector<double> displacement, velocity, phase, time;
  double weight = 0;  // 1/sigma^2
  double rms = 0;
  double independent = 0;  // observations
};

std::vector<double> Differentiate(std::span<const double> t, std::span<const double> y) {
  std::vector<double> v(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    const std::size_t a = i > 0 ? i - 1 : 0, b = std::min(i + 1, y.size() - 1);
    v[i] = (y[b] - y[a]) / (t[b] - t[a]);
  }
  return v;
}

/// Phase within a cycle, measured from a maximum [rad]; NaN where the motion has none.
std::vector<double> CalcCyclePhase(const SymptomInput& input) {
  Record samples;
  samples.t.assign(input.t().begin(), input.t().end());
  samples.y.assign(input.modelled.begin(), input.modelled.end());
  samples.g = input.record->g;
  const Swings swings = ReadSwings(samples, {.sigma = input.sigma, .quantum = input.quantum});
  const LocalPhase local = CalcLocalPhase(input.t(), swings.turns);
  std::vector<double> phase(input.size, std::numeric_limits<double>::quiet_NaN());
  const double shift = local.side > 0 ? 0 : std::numbers::pi;
  for (std::size_t i = 0; i < local.phase.size(); ++i)
    phase[i] = std::fmod(local.phase[i] + shift, 2 * std::numbers::pi);
  return phase;
}

Sampled Sample(const SymptomInput& input) {
  Sampled sampled;
  const std::span<const double> t = input.t(), y = input.y();
  double squares = 0;
  for (std::size_t i = 0; i < input.size; ++i) {
    sampled.residual.push_back(y[i] - input.modelled[i]);
    sampled.displacement.push_back(input.modelled[i] - input.offset);
    sampled.time.push_back(t[i] - t[0]);
    squares += sampled.residual[i] * sampled.residual[i];
  }
  sampled.velocity = Differentiate(t, input.modelled);
  sampled.phase = CalcCyclePhase(input);
  sampled.weight = 1 / (input.sigma * input.sigma);
  sampled.rms = std::sqrt(squares / static_cast<double>(input.size));
  sampled.independent = CalcEffectiveSize(sampled.residual);
  return sampled;
}

/// Residual over one coordinate.
struct Pattern {
  std::vector<double> x, mean, error;  // of the bins that hold enough samples
  double chi2 = 0;
  double explained = 0;  // share of the residuals' variance
};

struct Coordinate {
  const char *id, *name, *unit;
  std::vector<double> Sampled::*values;
  double scale;                                                               // of the unit, for printing
  std::vector<std::pair<const char*, std::function<double(double)>>> shapes;  // of x/(largest |x|)
};

Pattern CalcPattern(std::span<const Sampled> records, std::vector<double> Sampled::*values) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Sampled& s : records)
    for (const double x : s.*values)
      if (std::isfinite(x)) low = std::min(low, x), high = std::max(high, x);
  std::vector<double> n(kBins), w(kBins), x(kBins), sum(kBins), variance(kBins);
  double squares = 0;
  for (const Sampled& s : records) {
    const auto size = static_cast<double>(s.residual.size());
    // Variance of a sum of m correlated samples: m rms^2 n/n_independent.
    const double of_sample = s.weight * std::max(1.0, s.weight * s.rms * s.rms) * size / s.independent;
    for (std::size_t i = 0; i < s.residual.size(); ++i) {
      const double value = (s.*values)[i];
      if (!std::isfinite(value)) continue;
      const auto bin = std::min(kBins - 1, static_cast<std::size_t>((value - low) / (high - low) * kBins));
      n[bin] += 1, w[bin] += s.weight, x[bin] += s.weight * value, sum[bin] += s.weight * s.residual[i];
      variance[bin] += of_sample;
      squares += s.weight * s.residual[i] * s.residual[i];
    }
  }
  Pattern pattern;
  for (std::size_t b = 0; b < kBins; ++b) {
    if (n[b] < kFewestInBin) continue;
    const double mean = sum[b] / w[b];
    pattern.x.push_back(x[b] / w[b]), pattern.mean.push_back(mean);
    pattern.error.push_back(std::sqrt(variance[b]) / w[b]);
    pattern.chi2 += sum[b] * sum[b] / variance[b];
    pattern.explained += w[b] * mean * mean / squares;
  }
  return pattern;
}

/// The shape that describes a pattern best, a constant being free.
const char* NameShape(const Pattern& pattern, const Coordinate& coordinate) {
  double reach = 0;
  for (const double x : pattern.x) reach = std::max(reach, std::abs(x));
  const char* best = "";
  double most = 0;
  for (const auto& [name, shape] : coordinate.shapes) {
    double w = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (std::size_t i = 0; i < pattern.x.size(); ++i) {
      const double weight = 1 / (pattern.error[i] * pattern.error[i]), s = shape(pattern.x[i] / reach);
      w += weight, sx += weight * s, sy += weight * pattern.mean[i];
      sxx += weight * s * s, sxy += weight * s * pattern.mean[i];
    }
    const double gain = (sxy - sx * sy / w) * (sxy - sx * sy / w) / (sxx - sx * sx / w);
    if (gain > most) most = gain, best = name;
  }
  return best;
}

std::vector<Coordinate> MakeCoordinates() {
  const std::vector<std::pair<const char*, std::function<double(double)>>> powers = {
      {"in proportion", [](double x) { return x; }},
      {"like its square: alike on both sides", [](double x) { return x * x; }},
      {"like its cube", [](double x) { return x * x * x; }},
      {"by its sign", [](double x) { return x > 0 ? 1.0 : -1.0; }}};
  const auto wave = [](double n, double shift) {
    return [n, shift](double x) { return std::cos(2 * std::numbers::pi * n * x - shift); };
  };
  const double quarter = 0.5 * std::numbers::pi;
  return {{"residual_against_displacement", "displacement", "mm", &Sampled::displacement, 1e3, powers},
          {"residual_against_velocity", "velocity", "mm/s", &Sampled::velocity, 1e3, powers},
          {"residual_against_phase",
           "phase of the cycle",
           "degrees",
           &Sampled::phase,
           180 / std::numbers::pi,
           {{"once a cycle", wave(1, 0)},
            {"once a cycle", wave(1, quarter)},
            {"twice a cycle", wave(2, 0)},
            {"twice a cycle", wave(2, quarter)},
            {"three times a cycle", wave(3, 0)},
            {"three times a cycle", wave(3, quarter)}}},
          {"residual_against_time",
           "time",
           "s",
           &Sampled::time,
           1,
           {{"in proportion", [](double x) { return x; }}, {"like its square", [](double x) { return x * x; }}}}};
}

void AddPattern(const Pattern& pattern, const Coordinate& coordinate, Symptoms* symptoms) {
  if (pattern.x.empty()) return;
  const auto [low, high] = std::minmax_element(pattern.mean.begin(), pattern.mean.end());
  const auto at = [&](auto place) {
    return coordinate.scale * pattern.x[static_cast<std::size_t>(place - pattern.mean.begin())];
  };
  symptoms->list.push_back(
      {.id = coordinate.id,
       .sentence =
           fmt::format("over {} the residual runs from {:+.4f} mm (at {:.3g} {}) to {:+.4f} mm (at {:.3g} {}), {}; "
                       "this is {:.2g} % of its variance",
                       coordinate.name, 1e3 * *low, at(low), coordinate.unit, 1e3 * *high, at(high), coordinate.unit,
                       NameShape(pattern, coordinate), 100 * pattern.explained),
       .measured = 1e3 * (*high - *low),
       .modelled = 0,
       .unit = "mm",
       .z = CalcNormalEquivalent(CalcLogChiSquareTail(pattern.chi2, static_cast<double>(pattern.x.size())))});
  SymptomCurve curve{coordinate.id,
                     fmt::format("Residual over {}", coordinate.name),
                     fmt::format("{} [{}]", coordinate.name, coordinate.unit),
                     "record less model [mm]",
                     {},
                     {},
                     {},
                     {},
                     {}};
  for (std::size_t i = 0; i < pattern.x.size(); ++i) {
    curve.record.push_back(-1);
    curve.x.push_back(coordinate.scale * pattern.x[i]), curve.measured.push_back(1e3 * pattern.mean[i]);
    curve.modelled.push_back(0), curve.error.push_back(1e3 * pattern.error[i]);
  }
  symptoms->curves.push_back(std::move(curve));
}

/// Portmanteau test of all records together; statistic and degrees of freedom add up.
void AddWhiteness(std::span<const Sampled> records, Symptoms* symptoms) {
  double statistic = 0, lags = 0, samples = 0, independent = 0;
  for (const Sampled& s : records) {
    const Whiteness whiteness = TestWhiteness(s.residual);
    statistic += whiteness.statistic, lags += whiteness.lags;
    samples += static_cast<double>(s.residual.size()), independent += s.independent;
  }
  symptoms->list.push_back(
      {.id = "residual_not_white",
       .sentence = fmt::format(
           "the residual is not white (Ljung and Box: {:.0f}, of white noise {:.0f}); its {:.0f} samples are worth "
           "{:.0f} independent ones",
           statistic, lags, samples, independent),
       .measured = statistic,
       .modelled = lags,
       .unit = "-",
       .z = CalcNormalEquivalent(CalcLogChiSquareTail(statistic, lags))});
}

/// How much larger the residual is than the noise.
void AddSize(std::span<const SymptomInput> inputs, std::span<const Sampled> records, Symptoms* symptoms) {
  double chi2 = 0, dof = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const auto n = static_cast<double>(inputs[i].size);
    chi2 += n * records[i].weight * records[i].rms * records[i].rms;
    dof += n - (inputs[i].own == nullptr ? 0.0 : static_cast<double>(inputs[i].own->cols()));
  }
  if (inputs[0].common != nullptr) dof -= static_cast<double>(inputs[0].common->cols());
  const double ratio = std::sqrt(chi2 / dof);
  symptoms->list.push_back({.id = "residual_over_noise",
                            .sentence = fmt::format("the residual's rms is {:.3f} times the noise{}", ratio,
                                                    ratio < 1 ? "; a steady tone may have passed for noise" : ""),
                            .measured = ratio,
                            .modelled = 1,
                            .unit = "-",
                            .z = (ratio - 1) / (kRatioScatter / std::sqrt(2 * dof))});
}

}  // namespace

void FindResidualPatterns(std::span<const SymptomInput> inputs, Symptoms* symptoms) {
  std::vector<Sampled> records;
  for (const SymptomInput& input : inputs) records.push_back(Sample(input));
  for (const Coordinate& coordinate : MakeCoordinates())
    AddPattern(CalcPattern(records, coordinate.values), coordinate, symptoms);
  AddWhiteness(records, symptoms);
  AddSize(inputs, records, symptoms);
}

}  // namespace uiclink
