#include "identify/effect_search.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/effect_trial.h"
#include "identify/record_fit.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

void SortOwnSliders(ExtendedState* state) {
  for (std::size_t r = 0; r < state->link.shapes.size(); ++r) {
    FitState one{.levels = {state->link.levels[r]}, .shape = state->link.shapes[r], .starts = {}};
    SortSliders(&one);
    state->link.levels[r] = one.levels[0];
    state->link.shapes[r] = one.shape;
  }
}

}  // namespace

double CalcCollinearity(const EffectFit& a, const EffectFit& b) {
  if (a.correction.empty() || a.correction.size() != b.correction.size()) return 0;
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < a.correction.size(); ++i) {
    const double x = a.correction[i], y = b.correction[i];
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  return aa > 0 && bb > 0 ? std::abs(ab) / std::sqrt(aa * bb) : 0;
}

ExtendedOutcome EffectSearch::Refit(const Extension& extension, const ExtendedState& from) const {
  return FitExtended(data_, sharing_, extension, from, {.threads = options_.threads});
}

ExtendedOutcome EffectSearch::Settle(const Extension& extension, const ExtendedOutcome& outcome) const {
  if (outcome.state.link.shapes.empty()) return outcome;
  ExtendedState state = outcome.state;
  const ExtendedControl given{.fix_shared = true, .max_iterations = 25, .function_tolerance = 1e-5};
  ParallelFor(data_.size(), options_.threads, [&](std::size_t r) {
    ExtendedOutcome best;
    best.chi2 = std::numeric_limits<double>::infinity();
    for (std::size_t donor = 0; donor < data_.size(); ++donor) {
      ExtendedOutcome tried =
          FitExtended({&data_[r], 1}, sharing_, extension, TakeRecord(outcome.state, r, donor), given);
      if (tried.chi2 < best.chi2) best = std::move(tried);
    }
    if (std::isfinite(best.chi2)) PutRecord(best.state, r, &state);
  });
  ExtendedOutcome settled = Refit(extension, state);
  if (!(settled.chi2 < outcome.chi2)) settled = outcome;
  SortOwnSliders(&settled.state);
  return settled;
}

std::vector<EffectFit> EffectSearch::Try(const Extension& current, const ExtendedOutcome& now,
                                         std::span<const Effect* const> tried) const {
  std::vector<std::vector<float>> residuals;
  for (std::size_t r = 0; r < data_.size(); ++r) {
    const std::vector<double> of_record = CalcExtendedResiduals(data_[r], current, now.state, r);
    residuals.emplace_back(of_record.begin(), of_record.end());
    for (float& x : residuals.back()) x /= static_cast<float>(data_[r].sigma);
  }
  std::vector<Trial> trials;
  for (const Effect* effect : tried) trials.emplace_back(data_, sharing_, current, now, effect);
  ParallelFor(
      trials.size(), options_.threads, [&](std::size_t i) { trials[i].Explore(residuals); },
      [&](std::size_t done) {
        if (options_.progress) options_.progress(static_cast<int>(done), static_cast<int>(trials.size()));
      });
  double best = std::numeric_limits<double>::infinity();
  for (const Trial& trial : trials) best = std::min(best, trial.chi2());
  ParallelFor(trials.size(), options_.threads, [&](std::size_t i) { trials[i].Finish(best); });
  std::vector<EffectFit> fits;
  for (Trial& trial : trials) fits.push_back(trial.Take());
  return fits;
}

}  // namespace uiclink
