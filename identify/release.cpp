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
/// A rise by more than this share of a large swing is a push; by less, tones and the other axis beat with it.
constexpr double kRise = 0.05;
/// A push that comes after a decay makes the swings grow by this share of the largest at least.
constexpr double kSecondPush = 0.2;
/// Swings below this share of the largest are free: by then much has been lost, and only friction takes so much.
constexpr double kLarge = 0.5;
/// Rolling: a cycle loses at most this share of the strongest loss, or that share of the swing.
constexpr double kRollingLoss = 0.1, kRollingShare = 0.03;
double InMm(double metres) { return 1e3 * metres; }

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

/// Turns within the first samples that stand still: a hand may hold the mass at the record's end of the range.
std::size_t CountHeld(const Record& record, const Noise& noise, std::span<const Turn> turns) {
  const std::size_t end = FindStill(record, noise).end;
  std::size_t held = 0;
  while (held < turns.size() && turns[held].index <= end) ++held;
  return held;
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

/// "3 extrema cut flat at 18.00 mm, the last at 2.70 s".
std::string FormatCut(const Phases& phases, const char* verb) {
  const auto last = std::find_if(phases.extrema.rbegin(), phases.extrema.rend(), [](const auto& e) { return e.cut; });
  return fmt::format("{} {} {}cut flat at {:.2f} mm, the last at {:.2f} s", phases.cut_count,
                     phases.cut_count == 1 ? "extremum" : "extrema", verb, InMm(phases.cut_level), last->t);
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
  MarkCut(record, noise, CountHeld(record, noise, swings.turns), &swings.turns);
  swings.losses = CalcLosses(swings.turns);
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

/// The last turn from which the swings do not grow again by much, and the last one of which swings are still large.
struct Range {
  std::size_t first = 0, last = 0;
};

Range FindLargeSwings(std::span<const Turn> turns) {
  Range range;
  if (turns.size() < 2) return range;
  double largest = 0;
  for (std::size_t i = 0; i + 1 < turns.size(); ++i) largest = std::max(largest, Span(turns, i));
  double later = 0;
  for (std::size_t i = turns.size() - 1; i-- > 0;) {
    if (later - Span(turns, i) > kSecondPush * largest) break;
    if (Span(turns, i) > later) later = Span(turns, i), range.first = i;
  }
  range.last = range.first;
  for (std::size_t i = range.first; i + 1 < turns.size() && Span(turns, i) >= kLarge * later; ++i) range.last = i;
  return range;
}

/// The first extremum from which on the motion is free. Leaves the phases of the decay from there.
void FindStart(const Record& record, const Noise& noise, Swings* swings, Phases* phases) {
  const std::vector<Turn>& turns = swings->turns;
  const std::vector<double>& losses = swings->losses;
  const auto start_at = [&](std::size_t i) {
    swings->start = i;
    TakeDecay(record, *swings, phases);
    if (phases->extrema.size() >= 3) TakeRolling(*swings, phases);
  };
  double later = 0;  // strongest loss behind the cycle in question
  const Range range = FindLargeSwings(turns);
  for (std::size_t i = losses.size(); i-- > 0; later = std::max(later, losses[i])) {
    if (i > range.last) continue;
    start_at(i);
    const double equal = kEqual * turns[i].error;
    const bool rises = losses[i] < -(equal + kRise * Span(turns, i));
    if (rises || (later > equal && IsFirstSwingDriven(record, noise, *phases, later))) return start_at(i + 1);
  }
  start_at(0);
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

void CountCut(Phases* phases) {
  for (const Extremum& e : phases->extrema) {
    if (!e.cut) continue;
    if (phases->cut_count++ == 0) phases->cut_level = e.y;
  }
  phases->clipped = phases->cut_count > 0;
}

std::string FindFault(const Record& record, const Swings& swings, const Before& before, Phases* phases) {
  const std::vector<Extremum>& e = phases->extrema;
  const bool pushed = before.still.size > 0 || swings.start > 0;
  const double samples = SamplesPerPeriod(record, e);
  if (samples < kMinSamplesPerPeriod) return TooCoarse(samples);
  if (e.size() < 3) return TooFew(*phases, pushed);
  if (e.size() < kMinExtrema) return TooFew(*phases, pushed);
  if (e.size() - phases->cut_count < kMinExtrema)
    return fmt::format(
        "expected a free decay within the sensor's range, found {}; push less, or keep only what comes later",
        FormatCut(*phases, ""));
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

  FindStart(record, noise, &swings, &phases);
  const Before before = FindBefore(record, noise, phases);
  if (before.held) {
    DropHeld(record, before.still, &swings);
    TakeDecay(record, swings, &phases);
  } else {
    phases.rest_size = before.still.size;
    phases.rest_level = before.still.level;
  }
  CountCut(&phases);
  phases.reason = FindFault(record, swings, before, &phases);
  if (!phases.reason.empty()) return phases;

  TakeRolling(swings, &phases);
  const std::size_t last_turn = swings.start > 0 ? swings.turns[swings.start - 1].index : 0;
  phases.release_s = before.held ? record.t[before.still.end - 1]
                                 : FindPushEnd(record, noise, phases, std::max(last_turn, before.still.size));
  phases.usable = true;
  return phases;
}

std::string DescribeCut(const Phases& phases) {
  if (!phases.clipped) return {};
  return FormatCut(phases, phases.cut_count == 1 ? "is " : "are ") +
         "; how far the motion went there is not known: push less, or widen the sensor's range";
}

}  // namespace uiclink
