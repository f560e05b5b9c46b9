#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "identify/effect_search.h"
#include "identify/extended_fit.h"
#include "identify/screen.h"
#include "identify/start_grid.h"

namespace uiclink {

/// The sizes of an effect among all unknowns: parameter 0, with `quadrature` 0 and 1; own ones of every record.
struct SizeUnknowns {
  std::vector<Eigen::Index> numbers;
  struct Place {
    bool shared = true;
    std::size_t record = 0, index = 0;
  };
  std::vector<Place> places;
};

/// The trial of one effect: screen, quick refits from many starts, the best of them to the end.
class Trial {
 public:
  Trial(std::span<const FitData> data, Sharing sharing, const Extension& current, const ExtendedOutcome& now,
        const Effect* effect);

  /// Screen, and quick refits where they are worth it.
  void Explore(std::span<const std::vector<float>> residuals);

  /// Sum of squares of the best quick refit, in units of all samples.
  double chi2() const;

  /// The best quick refit to the end, or as it is where it is far behind the best of all effects.
  void Finish(double best_of_all);

  EffectFit Take() { return std::move(fit_); }

 private:
  bool HasNoScore() const { return uiclink::HasNoScore(*effect_); }

  ExtendedState StateAt(const StartPoint& start) const;

  void Screen(std::span<const std::vector<float>> residuals);

  /// Places that were tried; for tones all frequencies that the records can tell apart.
  double CountAlternatives() const;

  /// What the effect would change in the readings by the linear screen, less what the link and the starts absorb.
  void FindCorrection();

  /// Sizes to start from: the linear step, and, where the fit is far from its minimum and the step means little, parts
  /// of it and sizes that show clearly, on either side.
  std::vector<ExtendedState> SpreadSizes(const StartPoint& start, const Score& score) const;

  /// The most telling records, as many as a search needs: those with the largest swings.
  void ChooseRecords();

  ExtendedState ChooseFrom(const ExtendedState& all) const;

  /// The same for all records: those that were not chosen start from the effect's size and their own link.
  ExtendedOutcome FitTheOthers(const ExtendedOutcome& chosen, const ExtendedState& from,
                               const ExtendedControl& control);

  /// Records that were not chosen may have settled where their sliders imitate the effect: each starts from its own
  /// link or from that of a chosen record, whichever describes it better beside the effect.
  void StartFromChosen(const ExtendedOutcome& chosen, const ExtendedControl& control, ExtendedState* all);

  ExtendedOutcome Fit(std::span<const FitData> data, const ExtendedState& state, const ExtendedControl& control);

  /// A record that the plain model describes badly may have ended at a link that no other record has, and does not come
  /// back: it starts from the median of all. @returns whether there was one.
  static bool FetchStrays(ExtendedState* state);

  /// Several sliders that were fitted without the effect have often settled where they imitate it, and do not come
  /// back. So the link is grown once more, from one slider with the effect at its side to as many as it has.
  ExtendedOutcome Regrow(const ExtendedControl& glance, const ExtendedControl& quick);

  /// The shape with one slider split in two; the levels stay.
  void Split(const Levels& levels, const Shape& shape, int split, double spread, Shape* result) const;

  void RefitQuickly();

  std::span<const FitData> data_;
  Sharing sharing_;
  const Effect* effect_;
  int sliders_;
  ExtendedOutcome now_;
  EffectFit fit_;
  ExtendedState neutral_;
  SizeUnknowns sizes_;
  std::vector<std::pair<StartPoint, Score>> scored_;
  std::vector<std::size_t> chosen_;
  std::vector<FitData> chosen_data_;
  ExtendedOutcome best_;
  std::size_t stride_ = 1;
  int evaluations_ = 0;
  bool found_ = false;
  bool leaves_much_ = false;
};

/// The state of one record of several with links of their own, taken by itself, with the link of `donor`; and back.
ExtendedState TakeRecord(const ExtendedState& all, std::size_t record, std::size_t donor);
void PutRecord(const ExtendedState& one, std::size_t record, ExtendedState* all);

}  // namespace uiclink
