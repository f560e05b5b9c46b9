#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "identify/extended_fit.h"
#include "identify/screen.h"

namespace uiclink {

/// What one effect does for a fit: its score beforehand, and the full joint refit with it.
struct EffectFit {
  const Effect* effect = nullptr;
  double score = 0;               ///< fall of the sum of squares that the linear screen promises, at its best start
  double visibility = 0;          ///< u: share of its sensitivity that the other unknowns cannot absorb
  std::vector<float> correction;  ///< what the screen would change in the readings, every 8th sample, in noise levels
  bool refitted = false;
  Extension extension;      ///< the model before, and this effect
  ExtendedOutcome outcome;  ///< of the refit
  int unknowns = 0;         ///< by how many the model has grown
  double alternatives = 1;  ///< independent alternatives that were tried for the effect (places, frequencies, ...)
};

/// Cosine of the angle between the corrections of two effects, 0..1: 1 cannot be told apart by a linear screen.
double CalcCollinearity(const EffectFit& a, const EffectFit& b);

struct SearchOptions {
  int threads = 1;
  std::function<void(int done, int of)> progress;
};

/// Tries effects as extensions of a fitted model, each by itself: linear screen over all of its start values, then full
/// refits from the best of them. Where the model leaves little, effects of which the screen promises nothing are not
/// refitted.  Effects whose quick refit is far behind the best one are not refined further.
class EffectSearch {
 public:
  EffectSearch(std::span<const FitData> data, Sharing sharing, SearchOptions options)
      : data_(data), sharing_(sharing), options_(std::move(options)) {}

  /// The fit without further effects, from where another one ended.
  ExtendedOutcome Refit(const Extension& extension, const ExtendedState& from) const;

  /// Several sliders have many minima: each record of a fit with own links starts once more from the links of all
  /// others, the effects as they are; then all are fitted together. Sliders come out in the order of their critical
  /// displacements. Other fits are returned as they are.
  ExtendedOutcome Settle(const Extension& extension, const ExtendedOutcome& outcome) const;

  /// @param now  the fit of `current`; `tried` are the effects to be tried.
  std::vector<EffectFit> Try(const Extension& current, const ExtendedOutcome& now,
                             std::span<const Effect* const> tried) const;

 private:
  std::span<const FitData> data_;
  Sharing sharing_;
  SearchOptions options_;
};

}  // namespace uiclink
