#include "identify/half_swings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "identify/local_fit.h"
#include "identify/sliding_arc.h"

namespace uiclink {
namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr double kSlidingMargin = 1.2;  // over the travel after which every joint slides
/// Half width of the window behind the first turn [rad]. Behind it the joints stick, and the motion has another
/// frequency than its half period tells: 6 um at 25 mm, less than noise makes of it; half a radian makes 36 um.
constexpr double kFirstWindow = 0.3;
constexpr std::size_t kFewestArcSamples = 6;

/// The turn that the samples start at, from what follows it.
std::optional<Turn> LocateFirst(const Record& samples, const Noise& noise, double half_period) {
  const double w = std::numbers::pi / half_period, half_width = kFirstWindow / w;
  const auto centre = std::lower_bound(samples.t.begin(), samples.t.end(), samples.t.front() + half_width);
  const std::optional<LocalFit> fit =
      FitLocally(samples.t, samples.y, static_cast<std::size_t>(centre - samples.t.begin()), half_width, w);
  if (!fit) return std::nullopt;
  // The samples start within one interval of the extremum: one step of Newton's.
  const double t = samples.t.front(), s = t - fit->t0;
  const double curvature = 2 * fit->c2 * (1 - w * w * s * s / 2) - fit->c1 * w * w * s;
  const double step = -fit->v(t) / curvature;
  if (!std::isfinite(step)) return std::nullopt;
  // The edge of a parabola is known half as well as its middle.
  return Turn{{t + step, fit->y(t) + 0.5 * fit->v(t) * step, 0}, 2 * fit->LevelError(noise.sigma), curvature};
}

/// Is this a turn of its own, or the start of the samples once more?
bool IsStart(const Record& samples, std::span<const Turn> turns) {
  return turns[0].t - samples.t.front() < 0.5 * (turns[1].t - turns[0].t);
}

HalfSwing MakeHalfSwing(std::span<const Turn> turns, std::size_t i, double g) {
  const double a = 0.5 * Span(turns, i), b = 0.5 * Span(turns, i + 1);
  HalfSwing swing;
  swing.t = turns[i + 1].t;
  swing.amplitude = 0.5 * (a + b);
  swing.decrement = a - b;
  swing.frequency = 1 / (turns[i + 2].t - turns[i].t);
  const double w = 2 * std::numbers::pi * swing.frequency;
  swing.loss = w * w * swing.amplitude * swing.decrement / g;
  swing.middle = 0.25 * (turns[i].y + 2 * turns[i + 1].y + turns[i + 2].y);
  return swing;
}

double SumOfSprings(const Oscillator<double>& link) {
  double sum = 0;
  for (const Slider<double>& slider : link.sliders()) sum += slider.k;
  return sum;
}

}  // namespace

Swings ReadSwings(const Record& samples, const Noise& noise) {
  Swings swings;
  swings.turns = FindTurns(samples, noise);
  if (swings.turns.size() < 2) return {};
  if (IsStart(samples, swings.turns)) swings.turns.erase(swings.turns.begin());
  const std::optional<Turn> first = LocateFirst(samples, noise, swings.turns[0].t - samples.t.front());
  if (first) swings.turns.insert(swings.turns.begin(), *first);
  for (std::size_t i = 0; i + 2 < swings.turns.size(); ++i)
    swings.half.push_back(MakeHalfSwing(swings.turns, i, samples.g));
  return swings;
}

AmplitudeCurve::AmplitudeCurve(std::span<const HalfSwing> swings, double HalfSwing::*quantity) {
  for (const HalfSwing& swing : swings)
    if (points_.empty() || swing.amplitude < points_.back().first)
      points_.emplace_back(swing.amplitude, swing.*quantity);
}

double AmplitudeCurve::operator()(double amplitude) const {
  if (points_.empty()) return kNothing;
  if (points_.size() == 1 || amplitude <= points_.back().first) return points_.back().second;
  std::size_t i = 1;
  while (points_[i].first > amplitude) ++i;
  const auto& [a0, q0] = points_[i - 1];
  const auto& [a1, q1] = points_[i];
  return q1 + (q0 - q1) * (amplitude - a1) / (a0 - a1);
}

double CalcCriticalAmplitude(const Oscillator<double>& link) {
  double largest = 0;
  for (const Slider<double>& slider : link.sliders()) largest = std::max(largest, slider.T0 / slider.k);
  return largest;
}

std::size_t CountSlidingTurns(std::span<const Turn> turns, const Oscillator<double>& link) {
  const double travel = 2 * kSlidingMargin * CalcCriticalAmplitude(link);
  std::size_t i = 0;
  while (i + 1 < turns.size() && Span(turns, i) > travel) ++i;
  return i == 0 ? 0 : i + 1;
}

double ReadFrictionFromDecrement(std::span<const Turn> turns, std::size_t sliding, const Oscillator<double>& link) {
  const double springs = SumOfSprings(link);
  double friction = 0, sum = 0, weights = 0;
  for (const Slider<double>& slider : link.sliders()) friction += slider.T0;
  for (std::size_t i = 0; i + 2 < std::min(sliding, turns.size()); ++i) {
    const double s0 = Span(turns, i), s1 = Span(turns, i + 1);
    const double alpha = 2 / springs * (1 / s0 + 1 / s1), loss = 0.5 * link.k * (s0 - s1);
    // The loss is largest for T0 = 1/alpha, distances of about 4 T0/k1, and says nothing about T0 there; below that
    // distance the larger root is the link's. No real root: the friction that loses most.
    const double sensitivity = 1 - alpha * friction, weight = sensitivity * sensitivity;
    const double root = std::sqrt(std::max(0.0, 1 - alpha * loss));
    sum += weight * (1 - (sensitivity > 0 ? root : -root)) / alpha;
    weights += weight;
  }
  return weights > 0 ? sum / weights : kNothing;
}

double ReadFrictionFromLock(std::span<const Turn> turns, std::size_t first, std::size_t last, double offset,
                            const Oscillator<double>& link) {
  if (link.size() != 1 || last > turns.size() || last < first + 3) return kNothing;
  double amplitude = 0, centre = 0, n = 0;
  for (std::size_t i = first; i + 2 < last; ++i, ++n) {
    amplitude += 0.25 * (Span(turns, i) + Span(turns, i + 1));
    centre += 0.25 * (turns[i].y + 2 * turns[i + 1].y + turns[i + 2].y);
  }
  return link.sliders()[0].k * amplitude / n + link.k * std::abs(centre / n - offset);
}

double ReadFrictionFromCentre(const Record& samples, std::span<const Turn> turns, std::size_t sliding,
                              const Oscillator<double>& link) {
  const double travel = 2 * kSlidingMargin * CalcCriticalAmplitude(link);
  std::vector<ArcWindow> arcs;
  for (std::size_t i = 1; i < std::min(sliding, turns.size()); ++i) {
    const ArcWindow arc =
        FindSlidingArc(samples.t, samples.y, turns[i - 1].index, turns[i - 1].y, turns[i].index, turns[i].t, travel);
    if (arc.last >= arc.first + kFewestArcSamples) arcs.push_back(arc);
  }
  if (arcs.size() < 2) return kNothing;
  const std::optional<ArcFit> fit = FitSlidingArcs(samples.t, samples.y, arcs, std::sqrt(link.g * link.k));
  return fit && fit->both_sides ? fit->omega * fit->omega / link.g * fit->shift : kNothing;
}

}  // namespace uiclink
