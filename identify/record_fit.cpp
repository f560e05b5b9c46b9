#include "identify/record_fit.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "identify/start_values.h"

namespace uiclink {
namespace {

constexpr double kSameMinimum = 1e-3;     // relative difference of the sum of squares that still is the same minimum
constexpr double kRollsThroughout = 0.9;  // last over first amplitude of a decay that never slides
// Ratios of the critical displacements of the two halves of a slider that is split: the first, the others, hardly at
// all.
constexpr double kFirstSplit = 3;
constexpr double kSplits[] = {1.6, 2.2};
constexpr double kHardlySplit = 1.05;

FitState MakeState(const Oscillator<double>& link, const Start& start) {
  FitState state;
  state.levels.resize(1);
  FromOscillator(link, &state.levels[0], &state.shape);
  state.starts = {start};
  return state;
}

/// By how much the levels move while the window of the fit grows from two periods to the whole record. A model that is
/// right gives the same values everywhere within their errors; one that lacks something does not, and no covariance
/// knows.
Levels CalcDrift(const std::vector<Levels>& windows) {
  constexpr std::size_t kFirst = 1;  // the first window, one period, determines the friction too poorly
  Levels drift{};
  for (std::size_t j = 0; j < drift.size(); ++j) {
    double low = windows.back()[j], high = low;
    for (std::size_t i = kFirst; i < windows.size(); ++i) {
      low = std::min(low, windows[i][j]);
      high = std::max(high, windows[i][j]);
    }
    drift[j] = high - low;
  }
  return drift;
}

/// Does the sum of squares fall by more than a slider too many makes it fall? Two unknowns too many take 12 off it in
/// one record of 400 (chi-square).
bool Gains(double before, double after) { return before - after > std::max(kSameMinimum * before, 12.0); }

/// Several sliders grow from the fit of one: two, far apart, then each slider of the best fit so far is split in turn.
/// The sum of squares of several sliders has many local minima, in which one joint does the work of two: from equal
/// shares one fit in thirty finds the lowest, this way most do, for the same number of evaluations.
FitOutcome FitSpread(const FitData& data, const FitOutcome& one, int sliders) {
  constexpr double kPassing = 1e-4;  // tolerance of fits that are only passed through
  const auto fit = [&](const Oscillator<double>& link, const Start& start, int n) {
    return Fit({&data, 1}, Sharing::kLink, MakeState(link, start),
               {.max_iterations = kSloppyIterations, .function_tolerance = n < sliders ? kPassing : kSloppyTolerance});
  };
  FitOutcome best = one;
  Oscillator<double> link = ToOscillator(one.state.levels[0], one.state.shape, data.g);
  bool gains = true;
  for (int n = 2; n <= sliders; ++n) {
    FitOutcome grown;
    grown.evaluations = best.evaluations;
    const auto try_split = [&](int slider, double spread) {
      KeepBetter(fit(SplitSlider(link, slider, spread), best.state.starts[0], n), &grown);
    };
    // Where the last slider gained nothing, it does not matter which one the next is split from.
    for (int i = 0; i + 1 < (gains ? n : 2); ++i) try_split(i, n == 2 ? kFirstSplit : kSplits[0]);
    // Two halves that are nearly one cannot do worse than the whole, wherever the others have strayed.
    if (grown.chi2 > (1 + kSameMinimum) * best.chi2) try_split(0, kHardlySplit);
    gains = gains && Gains(best.chi2, grown.chi2);
    best = grown;
    link = ToOscillator(best.state.levels[0], best.state.shape, data.g);
  }
  // How far the sums depend on the window, and on the number of sliders.
  best.window_levels = one.window_levels;
  best.window_levels.push_back(best.state.levels[0]);
  return best;
}

/// A fit of several sliders from a link that is not far away.
FitOutcome FitFrom(const FitData& data, const Oscillator<double>& link, const Start& start) {
  return Fit({&data, 1}, Sharing::kLink, MakeState(link, start),
             {.max_iterations = kSloppyIterations, .function_tolerance = kSloppyTolerance});
}

/// One-slider fits from starts scattered about the one read off the record: k by up to a third, the others by up to a
/// factor of 3. A lower minimum replaces `one`.
void CheckStarts(const FitData& data, const StartValues& from, const std::vector<double>& windows,
                 const ScatteredStarts& starts, FitOutcome* one, RecordResult* result) {
  std::mt19937_64 random(starts.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> reached;
  for (int i = 0; i < starts.count; ++i) {
    Oscillator<double> link = from.link;
    link.k *= std::pow(4.0 / 3.0, uniform(random));
    link.sliders()[0].k *= std::pow(3.0, uniform(random));
    link.sliders()[0].T0 *= std::pow(3.0, uniform(random));
    const FitOutcome outcome = Fit({&data, 1}, Sharing::kLink, MakeState(link, from.start), {.window_s = windows});
    reached.push_back(outcome.chi2);
    if (outcome.chi2 < (1 - kSameMinimum) * one->chi2) {
      KeepBetter(outcome, one);
    } else {
      one->evaluations += outcome.evaluations;
    }
  }
  result->starts = starts.count;
  for (const double chi2 : reached) result->starts_agreeing += chi2 <= (1 + kSameMinimum) * one->chi2 ? 1 : 0;
}

/// Errors and bounds: a profile for one slider; normal in the logarithm for several, whose joint fit is profiled later.
std::vector<Estimate> EstimateQuantities(const FitData& data, const LinkInformation& information, int sliders,
                                         FitOutcome* own) {
  const double bound = CalcStudentBound(0.95, std::numeric_limits<double>::infinity());
  const Oscillator<double> link = ToOscillator(own->state.levels[0], own->state.shape, data.g);
  const Eigen::MatrixXd covariance = CalcCovariance(information.information, information.variance_factor);
  std::vector<Estimate> estimates;
  for (int q = 0; q < CountQuantities(sliders); ++q) {
    const double log_std = CalcLogStd(link, covariance, q);
    if (sliders == 1 && q <= 2) {
      estimates.push_back(
          ProfileQuantity({&data, 1}, *own, q, covariance, information.variance_factor, &own->evaluations));
    } else if (sliders == 1) {
      estimates.push_back(estimates[static_cast<std::size_t>(q - 2)]);  // the sums are k1 and T01 themselves
    } else {
      const double value = CalcQuantity(link, q);
      estimates.push_back({.value = value,
                           .std = value * log_std,
                           .low = value * std::exp(-bound * log_std),
                           .high = value * std::exp(bound * log_std)});
    }
  }
  return estimates;
}

/// What follows from the record's own fit: errors, bounds, drift.
void FinishOwn(RecordResult* result) {
  const FitData data = result->Data();
  const int sliders = CountSliders(result->own.state.shape);
  SortSliders(&result->own.state);
  const FitState& state = result->own.state;
  result->information =
      CalcInformation(data, state.levels[0], state.shape, state.starts[0], CalcPeriod(result->phases));
  result->own_quantities = EstimateQuantities(data, result->information, sliders, &result->own);
  result->drift = {};
  if (!result->information.structured) return;
  result->drift = CalcDrift(result->own.window_levels);
  for (std::size_t q = 0; q < result->own_quantities.size(); ++q)
    Widen(result->drift[LevelOf(sliders, q)], &result->own_quantities[q]);
}

/// Replaces the record's own fit if the sum of squares is lower than at the same minimum.
bool TakeLower(FitOutcome other, RecordResult* result) {
  FitOutcome& own = result->own;
  own.evaluations += other.evaluations;
  if (!(other.chi2 < (1 - kSameMinimum) * own.chi2)) return false;
  other.evaluations = own.evaluations;
  other.window_levels = own.window_levels;
  other.window_levels.back() = other.state.levels[0];
  own = std::move(other);
  FinishOwn(result);
  return true;
}

/// One slider fewer does as well: there is nothing that another arrangement of them could find.
bool HasSpareSlider(const FitData& data, RecordResult* result) {
  const FitState& own = result->own.state;
  const Oscillator<double> link = ToOscillator(own.levels[0], own.shape, data.g);
  for (int i = 0; i + 1 < link.size(); ++i) {
    const FitOutcome fewer = FitFrom(data, MergeSliders(link, i), own.starts[0]);
    result->own.evaluations += fewer.evaluations;
    if (!Gains(fewer.chi2, result->own.chi2)) return !result->information.structured;
  }
  return false;
}

/// No half swing stands out, and all of them together lose next to nothing: friction that holds all the time does not
/// show. A slow decay that does lose amplitude goes on to the fit.
bool OnlyRolls(const Phases& phases) {
  const double first = 0.5 * std::abs(phases.extrema[0].y - phases.extrema[1].y);
  return phases.rolling_start == 0 && phases.late_amplitude > kRollsThroughout * first;
}

/// A decay that only rolls determines k + sum k_i, and nothing about the friction.
std::string NeverSlides(const Phases& phases, double g) {
  const std::vector<Extremum>& e = phases.extrema;
  const double omega = std::numbers::pi * static_cast<double>(e.size() - 1) / (e.back().t - e.front().t);
  return fmt::format(
      "expected a decay that slides at first, found one that only rolls, at {:.3f} Hz: k + sum k_i = {:.3g} 1/m, and "
      "nothing about k and friction; push farther",
      omega / (2 * std::numbers::pi), omega * omega / g);
}

}  // namespace

FitData RecordResult::Data() const { return MakeFitData(record, noise, phases); }

void PrepareRecord(const SineFitOptions& options, RecordResult* result) {
  result->noise = EstimateNoise(result->record.t, result->record.y, result->record.uncertainty);
  result->phases = FindPhases(result->record, result->noise);
  result->used = result->phases.usable;
  result->reason = result->phases.reason;
  if (result->used && OnlyRolls(result->phases)) {
    result->used = false;
    result->reason = NeverSlides(result->phases, result->record.g);
  }
  if (!result->used) return;
  if (result->phases.clipped) result->record.notices.push_back(DescribeCut(result->phases));
  result->sine = FitSine(result->record, result->phases, options);
  const std::size_t left = result->record.t.size() - result->phases.fit_start;
  const std::size_t fitted = MakeFitData(result->record, result->noise, result->phases).size;
  if (fitted < left)
    result->record.notices.push_back(fmt::format("{} samples of the decay, the first {:.4g} s are fitted", left,
                                                 static_cast<double>(fitted) / result->record.sampling_hz));
}

void FitRecord(int sliders, const ScatteredStarts& starts, RecordResult* result) {
  const FitData data = result->Data();
  const StartValues from = FindStartValues(result->phases, data.g);
  const std::vector<double> windows = GrowingWindows(result->phases);
  FitOutcome one = Fit({&data, 1}, Sharing::kLink, MakeState(from.link, from.start), {.window_s = windows});
  CheckStarts(data, from, windows, starts, &one, result);
  result->own = sliders == 1 ? one : FitSpread(data, one, sliders);
  FinishOwn(result);
}

void RefitRecord(const Oscillator<double>& link, RecordResult* result) {
  TakeLower(FitFrom(result->Data(), link, result->own.state.starts[0]), result);
}

void RearrangeSliders(RecordResult* result) {
  constexpr int kRounds = 3;  // hardly ever more than two
  const FitData data = result->Data();
  bool lower = !HasSpareSlider(data, result);
  for (int round = 0; lower && round < kRounds; ++round) {
    lower = false;
    const FitState from = result->own.state;
    const Oscillator<double> link = ToOscillator(from.levels[0], from.shape, data.g);
    for (int merged = 0; merged + 1 < link.size(); ++merged)
      for (int split = 0; split + 1 < link.size(); ++split)
        for (const double spread : kSplits)
          if (split != merged)
            lower |= TakeLower(FitFrom(data, SplitSlider(MergeSliders(link, merged), split, spread), from.starts[0]),
                               result);
  }
}

double CalcPeriod(const Phases& phases) {
  const std::vector<Extremum>& e = phases.extrema;
  return 2 * (e.back().t - e.front().t) / static_cast<double>(e.size() - 1);
}

void SortSliders(FitState* state) {
  if (state->shape.empty()) return;
  Oscillator<double> link = ToOscillator(state->levels[0], state->shape, 1.0);
  std::sort(link.sliders().begin(), link.sliders().end(),
            [](const Slider<double>& l, const Slider<double>& r) { return l.T0 * r.k < r.T0 * l.k; });
  Levels unchanged;
  FromOscillator(link, &unchanged, &state->shape);
}

void KeepBetter(const FitOutcome& candidate, FitOutcome* best) {
  const int evaluations = best->evaluations + candidate.evaluations;
  if (best->chi2_of_record.empty() || candidate.chi2 < best->chi2) *best = candidate;
  best->evaluations = evaluations;
}

void Widen(double drift, Estimate* e) {
  e->std = std::hypot(e->std, 0.5 * drift * e->value);
  e->low = e->value * std::exp(-std::hypot(std::log(e->value / e->low), drift));
  e->high = e->value * std::exp(std::hypot(std::log(e->high / e->value), drift));
}

std::size_t LevelOf(int sliders, std::size_t quantity) {
  const int q = static_cast<int>(quantity);
  if (q == 0) return 0;
  return q <= sliders || q == SumOfStiffness(sliders) ? 1 : 2;
}

}  // namespace uiclink
