#include "identify/release.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "identify/push.h"
#include "identify/turns.h"

namespace uiclink {
namespace {

/// Deviations within which extrema count as equal.
constexpr double kEqual = 6;
/// The amplitude may rise by this share of a swing and still be called free: tones and the other axis beat with it.
constexpr double kRise = 0.05;
/// A cycle that loses less than this share of what a later one loses is still driven. Half is what a cycle loses whose
/// first half swing keeps its amplitude; dry friction with a gap to its static value stays above 0.8.
constexpr double kDriven = 0.75;
/// Rolling: a cycle loses at most this share of the strongest loss, or that share of the swing.
constexpr double kRollingLoss = 0.1, kRollingShare = 0.03;
double InMm(double metres) { return 1e3 * metres; }

/// The first extremum from which on the motion is free.
std::size_t FindStart(std::span<const Turn> turns, std::span<const double> losses) {
  if (losses.empty()) return 0;
  const double strongest = *std::max_element(losses.begin(), losses.end());
  double later = 0;  // strongest loss behind the cycle in question
  for (std::size_t i = losses.size(); i-- > 0; later = std::max(later, losses[i])) {
    const double equal = kEqual * turns[i].error, span = Span(turns, i);
    if (losses[i] < -(equal + kRise * span)) return i + 1;
    if (later > 0.3 * strongest && losses[i] < kDriven * later - (equal + 0.02 * span)) return i + 1;
  }
  return 0;
}

std::size_t FindRollingStart(std::span<const Turn> turns, std::span<const double> losses) {
  const double strongest = *std::max_element(losses.begin(), losses.end());
  std::size_t start = losses.size();
  while (start > 0) {
    const std::size_t i = start - 1;
    const double limit = std::max(kRollingLoss * strongest, kRollingShare * Span(turns, i));
    if (losses[i] > limit + kEqual * turns[i].error) break;
    --start;
  }
  return start < losses.size() ? start : turns.size();
}

/// Extrema that the sensor cut, among those from `first` on: flat at the record's highest or lowest reading. A motion
/// that pauses where it turns, or comes to rest, is flat at any level; one single turn that is hardly curved may be the
/// motion's own (a pendulum near its top).
std::vector<std::size_t> FindCut(const Record& record, const Noise& noise, std::span<const Turn> turns,
                                 std::size_t first) {
  const auto [low, high] = std::minmax_element(record.y.begin(), record.y.end());
  const double within = 4 * noise.sigma + noise.quantum;
  std::vector<std::size_t> cut;
  bool sure = false;
  for (std::size_t i = first; i < turns.size(); ++i) {
    if (std::min(*high - turns[i].y, turns[i].y - *low) > within) continue;
    const Flatness flatness = FindFlatness(record, noise, turns, i);
    if (flatness == Flatness::kRound) continue;
    cut.push_back(i);
    sure = sure || flatness == Flatness::kOneLevel || cut.size() > 1;
  }
  if (!sure) cut.clear();
  return cut;
}

/// The first samples, as long as they stay at one level.
struct Still {
  std::size_t size = 0;  ///< less a margin for motion that sets in softly
  std::size_t end = 0;   ///< all that stay
  double level = 0;
};

Still FindStill(const Record& record, const Noise& noise) {
  const double within = std::max(5 * noise.sigma, 1.5 * noise.quantum);
  const std::size_t start =
      std::min(record.y.size(), std::max<std::size_t>(8, static_cast<std::size_t>(0.05 * record.sampling_hz)));
  double sum = 0;
  for (std::size_t i = 0; i < start; ++i) sum += record.y[i];
  std::size_t size = start;
  const double first_mean = sum / static_cast<double>(start);
  for (std::size_t i = 0; i < start; ++i)
    if (std::abs(record.y[i] - first_mean) > within) return {};
  while (size < record.y.size() && std::abs(record.y[size] - sum / static_cast<double>(size)) <= within)
    sum += record.y[size++];
  // A push that sets in softly leaves the noise only after a while.
  const std::size_t kept = size - std::max<std::size_t>(3, size / 10);
  sum = 0;
  for (std::size_t i = 0; i < kept; ++i) sum += record.y[i];
  return {kept, size, sum / static_cast<double>(kept)};
}

/// Samples in a period, from turns of whatever size.
double SamplesPerPeriod(const std::vector<std::size_t>& turns) {
  if (turns.size() < 3) return std::numeric_limits<double>::infinity();
  return 2.0 * static_cast<double>(turns.back() - turns.front()) / static_cast<double>(turns.size() - 1);
}

/// Samples in the shortest period of the free decay.
double SamplesPerPeriod(const Record& record, std::span<const Extremum> extrema) {
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 2 < extrema.size(); ++i) shortest = std::min(shortest, extrema[i + 2].t - extrema[i].t);
  return shortest * record.sampling_hz;
}

std::string TooCoarse(double samples_per_period) {
  const double rounded_down = std::floor(10 * samples_per_period) / 10;  // never "at least 12, found 12.0"
  return fmt::format("expected at least {:.0f} samples in a period, found {:.1f}; sample faster", kMinSamplesPerPeriod,
                     rounded_down);
}

/// Readings all of which lie within what noise does.
std::string NoMotion(const Record& record, double range) {
  if (!(range > 0))
    return fmt::format(
        "expected a ring-down, found the same reading of {:.3f} mm in all samples; check sensor and column",
        InMm(record.y.front()));
  const double samples = SamplesPerPeriod(FindTurningSamples(record.y, 0.25 * range));
  if (samples < kMinSamplesPerPeriod)
    return fmt::format(
        "expected a ring-down with at least {:.0f} samples in a period, found readings that jump like noise within "
        "{:.3g} mm, {:.1f} samples from peak to peak; sample faster, or check sensor and column",
        kMinSamplesPerPeriod, InMm(range), samples);
  return fmt::format(
      "expected a ring-down, found no motion beyond noise, all readings within {:.3g} mm; check sensor and column",
      InMm(range));
}

std::string TooFew(const Phases& phases, bool pushed) {
  if (!pushed)
    return fmt::format("expected at least {} extrema of a free decay, found {}; record for longer", kMinExtrema,
                       phases.extrema.size());
  return fmt::format(
      "expected at least {} extrema after the push, found {} from {:.2f} s on; let go and record for longer",
      kMinExtrema, phases.extrema.size(), phases.extrema.empty() ? phases.release_s : phases.extrema[0].t);
}

std::string Clipped(double level, std::size_t count, double last) {
  return fmt::format(
      "expected a free decay within the sensor's range, found {} {} cut flat at {:.2f} mm, the last at {:.2f} s; "
      "push less, or keep only what comes later",
      count, count == 1 ? "extremum" : "extrema", InMm(level), last);
}

/// Everything that turns, and where the free decay starts among it.
struct Swings {
  std::string fault;
  std::vector<Turn> turns;
  std::vector<double> losses;
  std::size_t start = 0;
};

Swings FindSwings(const Record& record, const Noise& noise) {
  Swings swings;
  if (record.y.size() < kMinSamples) {
    swings.fault = fmt::format("expected at least {} samples, found {}", kMinSamples, record.y.size());
    return swings;
  }
  const auto [low, high] = std::minmax_element(record.y.begin(), record.y.end());
  const double range = *high - *low;
  if (!(range > CalcTurnThreshold(noise))) {
    swings.fault = NoMotion(record, range);
    return swings;
  }
  swings.turns = FindTurns(record, noise);
  swings.losses = CalcLosses(swings.turns);
  swings.start = FindStart(swings.turns, swings.losses);
  return swings;
}

/// Fills in what follows from the extrema alone.
void TakeDecay(const Record& record, const Swings& swings, Phases* phases) {
  phases->extrema.assign(swings.turns.begin() + static_cast<std::ptrdiff_t>(swings.start), swings.turns.end());
  const std::vector<Extremum>& e = phases->extrema;
  if (e.size() < 3) return;
  phases->fit_start = e[0].index + (record.t[e[0].index] < e[0].t ? 1 : 0);
  const std::size_t n = e.size();
  phases->late_amplitude = (std::abs(e[n - 1].y - e[n - 2].y) + std::abs(e[n - 2].y - e[n - 3].y)) / 4;
  // Each three neighbours give the centre whatever the decay, as long as it is steady; two periods average the noise.
  const std::size_t triples = std::min<std::size_t>(4, n - 2);
  phases->centre = 0;
  for (std::size_t i = n - 1 - triples; i + 1 < n; ++i)
    phases->centre += (e[i - 1].y + 2 * e[i].y + e[i + 1].y) / (4 * static_cast<double>(triples));
}

void TakeRolling(const Swings& swings, Phases* phases) {
  phases->rolling_start = FindRollingStart(std::span<const Turn>(swings.turns).subspan(swings.start),
                                           std::span<const double>(swings.losses).subspan(swings.start));
}

/// The readings before the push: rest, or a hand that holds the mass displaced.
struct Before {
  Still still;
  bool held = false;
};

Before FindBefore(const Record& record, const Noise& noise, const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  if (e.size() < 3) return {};
  Before before{.still = FindStill(record, noise)};
  // In motion the reading stands still for a tenth of a radian around an extremum; 0.15 periods are a full radian.
  const double period = 2 * (e.back().t - e.front().t) / static_cast<double>(e.size() - 1);
  if (static_cast<double>(before.still.size) < 0.15 * period * record.sampling_hz) return {};
  before.held = std::abs(before.still.level - phases.centre) > 0.25 * std::abs(e[1].y - e[0].y);
  return before;
}

/// Drops turns that lie where the mass is still held, so that the decay starts at a true extremum.
void DropHeld(const Record& record, const Still& still, Swings* swings) {
  const double end = record.t[still.end - 1];
  while (swings->start + 2 < swings->turns.size()) {
    const Turn* turn = &swings->turns[swings->start];
    if (turn->t > end + 0.3 * (turn[2].t - turn[1].t)) return;
    ++swings->start;
  }
}

std::string FindFault(const Record& record, const Noise& noise, const Swings& swings, const Before& before,
                      Phases* phases) {
  const std::vector<Extremum>& e = phases->extrema;
  const bool pushed = before.still.size > 0 || swings.start > 0;
  const double samples = SamplesPerPeriod(record, e);
  if (samples < kMinSamplesPerPeriod) return TooCoarse(samples);
  if (e.size() < 3) return TooFew(*phases, pushed);
  // A cut extremum right before the decay may be free as well: its size is unknown.
  std::size_t first = swings.start;
  while (!before.held && first > 0 && first < swings.turns.size() &&
         FindFlatness(record, noise, swings.turns, first - 1) != Flatness::kRound)
    --first;
  const std::vector<std::size_t> cut = FindCut(record, noise, swings.turns, first);
  phases->clipped = !cut.empty();
  if (phases->clipped) return Clipped(record.y[swings.turns[cut[0]].index], cut.size(), swings.turns[cut.back()].t);
  if (e.size() < kMinExtrema) return TooFew(*phases, pushed);
  const double first_span = std::abs(e[1].y - e[0].y), fall = first_span - 2 * phases->late_amplitude;
  const double equal = kEqual * std::numbers::sqrt2 * swings.turns[swings.start].error;
  if (!pushed && fall < std::max(equal, 0.01 * first_span))
    return fmt::format(
        "expected a free decay, found the same amplitude of {:.2f} mm from the first extremum to the last; record "
        "the motion after letting go",
        InMm(first_span / 2));
  return {};
}

}  // namespace

Phases FindPhases(const Record& record, const Noise& noise) {
  Phases phases;
  Swings swings = FindSwings(record, noise);
  phases.reason = swings.fault;
  if (!phases.reason.empty()) return phases;

  TakeDecay(record, swings, &phases);
  const Before before = FindBefore(record, noise, phases);
  if (before.held) {
    DropHeld(record, before.still, &swings);
    TakeDecay(record, swings, &phases);
  } else {
    phases.rest_size = before.still.size;
    phases.rest_level = before.still.level;
  }
  phases.reason = FindFault(record, noise, swings, before, &phases);
  if (!phases.reason.empty()) return phases;

  TakeRolling(swings, &phases);
  // What the losses leave open the shape of the first half swing decides.
  if (!before.held && phases.extrema.size() > kMinExtrema && IsFirstSwingPushed(record, noise, phases)) {
    ++swings.start;
    TakeDecay(record, swings, &phases);
    TakeRolling(swings, &phases);
  }
  const std::size_t last_turn = swings.start > 0 ? swings.turns[swings.start - 1].index : 0;
  phases.release_s = before.held ? record.t[before.still.end - 1]
                                 : FindPushEnd(record, noise, phases, std::max(last_turn, before.still.size));
  phases.usable = true;
  return phases;
}

}  // namespace uiclink
