#include "identify/turns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "identify/local_fit.h"

namespace uiclink {
namespace {

/// A motion turns when it comes back by this many noise levels, steps of the converter, and shares of the last swing:
/// noise of 1e4 samples spans 7.4 deviations, and a rig mode or a tone on top must not count as swings.
constexpr double kTurnNoise = 8, kTurnSteps = 3, kTurnShare = 0.08;
/// Swings smaller than this, from extremum to extremum, are no extrema (three noise levels to each side).
constexpr double kSpanNoise = 6, kSpanSteps = 2;
/// Swings larger than this many smallest ones are a motion, however irregular: another one may beat with it.
constexpr double kCreep = 5;

/// Share of w^2 amplitude that the curvature of a round turn has at least: a sliding link has more than 1, a pendulum
/// at 136 degrees 0.4.
constexpr double kLeastCurvature = 0.4;

/// Smallest swing that is told from noise [m].
double SmallestSwing(const Noise& noise) {
  return std::max({kSpanNoise * noise.sigma, kSpanSteps * noise.quantum, 1e-12});
}

std::size_t NearestSample(std::span<const double> t, double time, std::size_t guess) {
  while (guess + 1 < t.size() && std::abs(t[guess + 1] - time) < std::abs(t[guess] - time)) ++guess;
  while (guess > 0 && std::abs(t[guess - 1] - time) < std::abs(t[guess] - time)) --guess;
  return guess;
}

/// Half swings shorter and longer than these, in units of the one before, are out of step. One half swing to the next
/// changes by a third at most where joints stop sliding; the margin is for a last creep.
constexpr double kShortest = 0.45, kLongest = 1.8;

/// Readings averaged over `width` [s] about each, twice: a tone of period `width` or less is gone.
std::vector<double> Smooth(std::span<const double> t, std::span<const double> y, double width) {
  std::vector<double> in(y.begin(), y.end()), out(y.size());
  for (int pass = 0; pass < 2; ++pass) {
    double sum = 0;
    std::size_t first = 0, last = 0;  // last is not included
    for (std::size_t i = 0; i < in.size(); ++i) {
      // Equally far to both sides, also at the ends of the record: a slope must not shift the mean.
      const double reach = std::min({width / 2, t[i] - t.front(), t.back() - t[i]}) * (1 + 1e-9);
      while (last < in.size() && t[last] - t[i] <= reach) sum += in[last++];
      while (last > first && t[last - 1] - t[i] > reach) sum -= in[--last];
      while (t[i] - t[first] > reach) sum -= in[first++];
      out[i] = sum / static_cast<double>(last - first);
    }
    std::swap(in, out);
  }
  return in;
}

/// Median time from turn to turn while swings are large [s]; 0 where there are none.
double TypicalHalfSwing(const Record& record, const std::vector<std::size_t>& samples) {
  constexpr double kLarge = 0.3;
  double largest = 0;
  const auto span = [&](std::size_t i) { return std::abs(record.y[samples[i + 1]] - record.y[samples[i]]); };
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) largest = std::max(largest, span(i));
  std::vector<double> halves;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i)
    if (span(i) > kLarge * largest) halves.push_back(record.t[samples[i + 1]] - record.t[samples[i]]);
  if (halves.empty()) return 0;
  const auto middle = halves.begin() + static_cast<std::ptrdiff_t>(halves.size() / 2);
  std::nth_element(halves.begin(), middle, halves.end());
  return *middle;
}

/// Locates one extremum. The window's half width, in radian, balances the fit's bias (~ amplitude width^4) against
/// noise (~ 1/sqrt(width)): width ~ (sigma/amplitude)^(2/9); half a radian at 25 mm and 0.013 mm.
/// @param tones  a tone lies on the motion: the widest window averages it best.
std::optional<Turn> Locate(const Record& record, const Noise& noise, std::size_t index, double half_period,
                           double amplitude, bool tones) {
  const double w = std::numbers::pi / half_period;
  const double width = (tones ? 0.9 : std::clamp(2.7 * std::pow(noise.sigma / amplitude, 2.0 / 9), 0.15, 0.9)) / w;
  std::optional<LocalFit> fit = FitLocally(record.t, record.y, index, width, w);
  std::optional<double> turning = fit ? fit->FindTurning() : std::nullopt;
  if (turning && std::abs(*turning - fit->t0) > 0.25 * width) {
    fit = FitLocally(record.t, record.y, NearestSample(record.t, *turning, index), width, w);
    turning = fit ? fit->FindTurning() : std::nullopt;
  }
  if (!fit) return std::nullopt;  // the record starts or ends here
  if (!turning) return Turn{{record.t[index], record.y[index], index}, noise.sigma, 0};
  return Turn{{*turning, fit->y(*turning), NearestSample(record.t, *turning, index)},
              fit->LevelError(noise.sigma),
              2 * fit->c2};
}

std::vector<Turn> LocateAll(const Record& record, const Noise& noise, const std::vector<std::size_t>& samples,
                            bool tones) {
  std::vector<Turn> turns;
  turns.reserve(samples.size());
  const std::size_t n = samples.size();
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    const std::size_t before = samples[i > 0 ? i - 1 : i], after = samples[i + 1 < n ? i + 1 : i];
    // The shorter of the two half swings: the mass may have been held, or at rest, before the other.
    const double half_period =
        i == 0       ? record.t[after] - record.t[samples[i]]
        : i + 1 == n ? record.t[samples[i]] - record.t[before]
                     : std::min(record.t[after] - record.t[samples[i]], record.t[samples[i]] - record.t[before]);
    const double y = record.y[samples[i]];
    const double amplitude = 0.5 * std::max(std::abs(y - record.y[before]), std::abs(y - record.y[after]));
    const std::optional<Turn> turn = Locate(record, noise, samples[i], half_period, amplitude, tones);
    if (!turn) continue;
    // A spike may send the fit astray; then the sample itself has to do.
    const bool between = turn->index > before && (turn->index < after || i + 1 == n);
    turns.push_back(between || i == 0 ? *turn : Turn{{record.t[samples[i]], y, samples[i]}, noise.sigma, 0});
  }
  return turns;
}

/// Leaves out what follows when the motion has come to rest: swings within the noise, or out of step.
void CutRest(const Noise& noise, std::vector<Turn>* turns) {
  if (turns->size() < 3) return;
  std::size_t largest = 0;
  for (std::size_t i = 1; i + 1 < turns->size(); ++i)
    if (Span(*turns, i) > Span(*turns, largest)) largest = i;
  for (std::size_t i = largest + 1; i + 1 < turns->size(); ++i) {
    const Turn *a = &(*turns)[i - 1], *b = a + 1, *c = a + 2;
    const double ratio = (c->t - b->t) / (b->t - a->t);
    // One half swing to the next changes by a third at most where joints stop sliding; the margin is for a last creep.
    // The largest may have been held for any time.
    const bool out_of_step =
        i > largest + 1 && (ratio < 0.45 || ratio > 1.8) && Span(*turns, i) < kCreep * SmallestSwing(noise);
    if (Span(*turns, i) < SmallestSwing(noise) || out_of_step) {
      turns->resize(i + 1);
      return;
    }
  }
}

/// Phase for which the reading stays within `band` of its extreme around a turn [rad].
double FlatPhase(const Record& record, const Turn& turn, double w, double side, double band) {
  const double reach = 1.0 / w;
  std::size_t first = turn.index, last = turn.index;
  while (first > 0 && turn.t - record.t[first - 1] < reach) --first;
  while (last + 1 < record.t.size() && record.t[last + 1] - turn.t < reach) ++last;
  double top = record.y[first];
  for (std::size_t i = first; i <= last; ++i)
    if (side * (record.y[i] - top) > 0) top = record.y[i];
  const auto near = [&](std::size_t i) { return side * (top - record.y[i]) <= band; };
  double longest = 0;
  for (std::size_t i = first; i <= last; ++i) {
    const std::size_t start = i;
    while (i < last && near(start) && near(i + 1)) ++i;
    longest = std::max(longest, record.t[i] - record.t[start]);
  }
  return w * longest;
}

/// Puts a cut turn into the middle of the samples at its level.
void MoveToFlatPart(const Record& record, const Noise& noise, Turn* turn) {
  const double level = record.y[turn->index], within = CutBand(noise);
  const auto near = [&](std::size_t i) { return std::abs(record.y[i] - level) <= within; };
  std::size_t first = turn->index, last = turn->index;
  while (first > 0 && near(first - 1)) --first;
  while (last + 1 < record.t.size() && near(last + 1)) ++last;
  double sum = 0;
  for (std::size_t i = first; i <= last; ++i) sum += record.y[i];
  turn->t = 0.5 * (record.t[first] + record.t[last]);
  turn->y = sum / static_cast<double>(last - first + 1);
  turn->index = NearestSample(record.t, turn->t, first);
  turn->curvature = 0;
  turn->cut = true;
}

}  // namespace

std::vector<std::size_t> FindTurningSamples(std::span<const double> y, double least) {
  std::vector<std::size_t> turns;
  std::size_t high = 0, low = 0;
  int direction = 0;  // of the swing under way; 0: not yet known
  double back = least;
  for (std::size_t i = 1; i < y.size(); ++i) {
    if (y[i] > y[high]) high = i;
    if (y[i] < y[low]) low = i;
    if (direction >= 0 && y[high] - y[i] > back) {
      back = std::max(least, kTurnShare * (y[high] - y[low]));
      turns.push_back(high);
      direction = -1;
      low = i;
    } else if (direction <= 0 && y[i] - y[low] > back) {
      back = std::max(least, kTurnShare * (y[high] - y[low]));
      turns.push_back(low);
      direction = 1;
      high = i;
    }
  }
  return turns;
}

double CalcTurnThreshold(const Noise& noise) { return std::max(kTurnNoise * noise.sigma, kTurnSteps * noise.quantum); }

std::vector<Turn> FindTurns(const Record& record, const Noise& noise) {
  const auto [low, high] = std::minmax_element(record.y.begin(), record.y.end());
  // Rounding of the readings is no motion, whatever the noise estimate.
  const double least = std::max(CalcTurnThreshold(noise), 1e-9 * (*high - *low));
  std::vector<std::size_t> samples = FindTurningSamples(record.y, least);
  // Tones and modes far faster than the motion turn where it does not.
  constexpr double kFar = 0.3;
  const double half_swing = TypicalHalfSwing(record, samples);
  const auto crowded = [&](std::size_t i, std::size_t j) { return record.t[j] - record.t[i] < kFar * half_swing; };
  const bool tones = std::adjacent_find(samples.begin(), samples.end(), crowded) != samples.end();
  if (tones) samples = FindTurningSamples(Smooth(record.t, record.y, kFar * half_swing), least);
  std::vector<Turn> turns = LocateAll(record, noise, samples, tones);
  CutRest(noise, &turns);
  return turns;
}

std::vector<double> CalcLosses(std::span<const Turn> turns) {
  std::vector<double> losses;
  for (std::size_t i = 0; i + 2 < turns.size(); ++i) losses.push_back(Span(turns, i) - Span(turns, i + 1));
  return losses;
}

Flatness FindFlatness(const Record& record, const Noise& noise, std::span<const Turn> turns, std::size_t i) {
  if (turns.size() < 2) return Flatness::kRound;
  double half_period = std::numeric_limits<double>::infinity(), amplitude = 0;
  std::size_t neighbours = 0;
  double side = 0;
  for (const std::size_t j : {i - 1, i + 1}) {
    if (j >= turns.size()) continue;  // i - 1 of the first wraps round
    half_period = std::min(half_period, std::abs(turns[j].t - turns[i].t));
    amplitude += 0.5 * std::abs(turns[j].y - turns[i].y);
    side = turns[i].y > turns[j].y ? 1 : -1;
    ++neighbours;
  }
  amplitude /= static_cast<double>(neighbours);
  const double w = std::numbers::pi / half_period;
  if (amplitude < 20 * std::max(noise.quantum, noise.sigma)) return Flatness::kRound;
  // How long a round turn stays within a band that noise and steps fill, if it has as little curvature as allowed.
  const double band = noise.quantum + 6 * noise.sigma;
  const double round = 2 * std::sqrt(2 * band / (kLeastCurvature * amplitude)),
               two_samples = 2 * w / record.sampling_hz;
  if (FlatPhase(record, turns[i], w, side, band) > std::max(0.25, 1.5 * round + two_samples))
    return Flatness::kOneLevel;
  return std::abs(turns[i].curvature) < kLeastCurvature * w * w * amplitude ? Flatness::kHardlyCurved
                                                                            : Flatness::kRound;
}

void MarkCut(const Record& record, const Noise& noise, std::size_t first, std::vector<Turn>* turns) {
  const auto [low, high] = std::minmax_element(record.y.begin(), record.y.end());
  std::vector<std::size_t> cut;
  bool sure = false;
  for (std::size_t i = first; i < turns->size(); ++i) {
    if (std::min(*high - (*turns)[i].y, (*turns)[i].y - *low) > CutBand(noise)) continue;
    const Flatness flatness = FindFlatness(record, noise, *turns, i);
    if (flatness == Flatness::kRound) continue;
    cut.push_back(i);
    sure = sure || flatness == Flatness::kOneLevel || cut.size() > 1;
  }
  if (!sure) return;
  for (const std::size_t i : cut) MoveToFlatPart(record, noise, &(*turns)[i]);
}

}  // namespace uiclink
