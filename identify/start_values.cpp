#include "identify/start_values.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "identify/thinning.h"
#include "model/closed_form.h"

namespace uiclink {
namespace {

/// Half periods used at most: later ones repeat what the first ones and the rolling frequency say.
constexpr std::size_t kMaxSwings = 12;

/// Amplitudes from the centre, taken between neighbouring extrema so that no zero is needed: half the swing.
std::vector<double> HalfSwings(const std::vector<Extremum>& extrema) {
  std::vector<double> swings;
  for (std::size_t i = 0; i + 1 < extrema.size(); ++i)
    swings.push_back(0.5 * std::abs(extrema[i].y - extrema[i + 1].y));
  return swings;
}

double LateHalfPeriod(const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  const std::size_t first = std::min(phases.rolling_start, e.size() - 2);
  return (e.back().t - e[first].t) / static_cast<double>(e.size() - 1 - first);
}

/// T0 of the half-cycle map from A to B for given stiffnesses: the smaller root, the other one never slides.
std::optional<double> SolveFriction(double k, double k1, double A, double B) {
  const double sum = A + B;
  const double discriminant = sum * sum - 4 * k / k1 * (A * A - B * B);
  if (!(discriminant >= 0) || !(A > B)) return std::nullopt;
  return 0.25 * k1 * (sum - std::sqrt(discriminant));
}

/// rms distance of the map from the measured swings and times [m]; times are turned into lengths by the mean speed.
double Misfit(const Oscillator<double>& link, double A0, const std::vector<double>& swings,
              const std::vector<Extremum>& extrema) {
  double sum = 0, A = A0, t = extrema[0].t;
  const std::size_t n = std::min(swings.size(), kMaxSwings);
  for (std::size_t i = 0; i < n; ++i) {
    const HalfCycle half = CalcHalfCycle(link, A);
    t += half.duration;
    if (!(half.next_amplitude > 0)) return std::numeric_limits<double>::infinity();
    const double length = 0.5 * (A + half.next_amplitude) - swings[i];
    const double late = (t - extrema[i + 1].t) * 2 * swings[i] / half.duration;
    sum += length * length + late * late;
    A = half.next_amplitude;
  }
  return std::sqrt(sum / static_cast<double>(n));
}

}  // namespace

FitData MakeFitData(const Record& record, const Noise& noise, const Phases& phases) {
  return {.record = &record,
          .first = phases.fit_start,
          .size = std::min(record.t.size() - phases.fit_start, kManySamples),
          .sigma = noise.sigma,
          .g = record.g,
          .centre = phases.centre,
          .swing = std::abs(phases.extrema[0].y - phases.centre),
          // Motion below ten noise levels, or a tenth of the smallest swing of the record, is not told from rest. A
          // tone that counts as noise must not hide the joints: no more than three tenths of that swing.
          .smallest = std::max(std::min(10 * noise.sigma, 0.3 * phases.late_amplitude), 0.1 * phases.late_amplitude)};
}

StartValues FindStartValues(const Phases& phases, double g) {
  const std::vector<Extremum>& extrema = phases.extrema;
  const std::vector<double> swings = HalfSwings(extrema);
  const double rolling = std::numbers::pi / LateHalfPeriod(phases);
  const double stiffness = rolling * rolling / g;

  // Amplitudes at the first two extrema: from the late centre, which is the true origin up to a residual offset.
  const double A = std::abs(extrema[0].y - phases.centre);
  const double B = std::abs(extrema[1].y - phases.centre);
  StartValues best;
  best.misfit = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 49; ++i) {
    const double ratio =
        0.05 * std::pow(1.12, i);  // k1/k, to 11.5: from a hardly sliding link to a nearly rigid slider
    const double k = stiffness / (1 + ratio);
    const double k1 = stiffness - k;
    // Without a decrement (a decay that never slides) friction is just beyond reach.
    const double T0 = SolveFriction(k, k1, A, B).value_or(1.05 * k1 * A);
    if (!(T0 > 0)) continue;
    Oscillator<double> link;
    link.k = k;
    link.g = g;
    link.Add({.k = k1, .T0 = T0});
    const double misfit = Misfit(link, A, swings, extrema);
    if (misfit < best.misfit || best.link.size() == 0) best = {.link = link, .start = {}, .misfit = misfit};
  }
  best.start = {extrema[0].y - phases.centre, extrema[0].t, phases.centre};
  return best;
}

Oscillator<double> SplitSlider(const Oscillator<double>& link, int split, double spread) {
  Oscillator<double> result;
  result.k = link.k;
  result.g = link.g;
  for (int i = 0; i < link.size(); ++i) {
    const Slider<double>& s = link.sliders()[static_cast<std::size_t>(i)];
    if (i != split) {
      result.Add(s);
      continue;
    }
    result.Add({.k = 0.5 * s.k, .T0 = s.T0 / (1 + spread)});
    result.Add({.k = 0.5 * s.k, .T0 = s.T0 * spread / (1 + spread)});
  }
  return result;
}

Oscillator<double> MergeSliders(const Oscillator<double>& link, int first) {
  Oscillator<double> result;
  result.k = link.k;
  result.g = link.g;
  for (int i = 0; i < link.size(); ++i) {
    const Slider<double>& s = link.sliders()[static_cast<std::size_t>(i)];
    if (i == first + 1) {
      Slider<double>& merged = result.sliders()[static_cast<std::size_t>(first)];
      merged.k += s.k;
      merged.T0 += s.T0;
    } else {
      result.Add(s);
    }
  }
  return result;
}

std::vector<double> GrowingWindows(const Phases& phases) {
  std::vector<double> windows;
  const std::vector<Extremum>& e = phases.extrema;
  for (std::size_t half_periods = 2; half_periods < e.size(); half_periods += (half_periods + 1) / 2)
    windows.push_back(e[half_periods].t - e[0].t);
  return windows;
}

}  // namespace uiclink
