#include "identify/diagnosis.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "identify/diagnose_symptoms.h"
#include "identify/family_wise.h"
#include "identify/statistics.h"

namespace uiclink {
namespace {

constexpr std::size_t kMostCauses = 3;
constexpr double kSignificant = 0.005;  // family-wise
constexpr double kRivalBic = 10;        // difference below which two models are not told apart ("very strong" is above)
constexpr double kExplainsEnough = 0.95;  // of the mean square, from which causes are named although structure is left
constexpr double kWorthAnotherPair =
    0.9;                         // of the mean square: what explains less is not one effect short of the truth
constexpr double kNeeded = 0.9;  // rms with / without a cause: above this a model with structure left can do without
constexpr double kSharingLevel = 0.01;

std::vector<const Effect*> Observable() {
  std::vector<const Effect*> effects;
  for (const Effect* effect : Effects())
    if (effect->unseen.empty()) effects.push_back(effect);
  return effects;
}

/// A model on its way: an extension and its fit.
struct Step {
  Extension extension;
  ExtendedOutcome outcome;
};

/// The diagnosis in the making.
class Diagnoser {
 public:
  Diagnoser(const Identification& plain, const DiagnoseOptions& options)
      : plain_(plain),
        options_(options),
        data_(CollectData(plain)),
        sharing_(plain.shared ? Sharing::kLink : Sharing::kShape),
        search_(data_, sharing_, MakeSearchOptions()),
        catalogue_(Observable()) {
    for (const FitData& d : data_) samples_ += static_cast<double>(d.size);
  }

  Diagnosis Run() {
    const Step start = FitPlain();
    result_.plain = Describe(data_, sharing_, start.extension, start.outcome);
    Step final = GoForward(start, plain_.sliders == 1 ? kMostCauses : 2);
    DropUnneeded(&final);
    // With several sliders a model has so much freedom that another pair would hardly be told from this one.
    const bool doubtful = final.extension.effects().size() == kMostCauses || IsStructured(final);
    const bool promising = final.outcome.chi2 < (1 - kWorthAnotherPair) * start.outcome.chi2;
    if (doubtful && promising && plain_.sliders == 1) LookForBetterPair(start, &final);
    Judge(start, final);
    return std::move(result_);
  }

 private:
  SearchOptions MakeSearchOptions() const {
    SearchOptions search{.threads = options_.threads, .progress = {}};
    if (options_.progress)
      search.progress = [this](int done, int of) { options_.progress("trying effects", done, of); };
    return search;
  }

  Step FitPlain() const {
    ExtendedState state{.link = CollectState(plain_, sharing_), .shared = {}, .own = {}};
    state.own.resize(data_.size());
    return {.extension = Extension(), .outcome = search_.Refit(Extension(), state)};
  }

  /// Independent observations under the best model so far; all models are judged with the same number.
  double EffectiveSize(const Step& step) const {
    return std::max(2.0, CalcStructure(data_, step.extension, step.outcome.state).effective_size);
  }

  static double LogLikelihoodRatio(double before, double after, double size) {
    return size * std::log(before / std::max(after, 1e-300));
  }

  /// Smaller is better; for models of the same records with the same number of independent observations.
  double Penalise(double chi2, int unknowns, double size) const {
    return size * std::log(chi2) + CalcPenalty(unknowns, size);
  }

  /// What an effect costs: its unknowns, and the choice among all effects.
  double CalcPenalty(int unknowns, double size) const {
    return unknowns * std::log(size) + 2 * std::log(static_cast<double>(catalogue_.size()));
  }

  /// Why an effect cannot be a cause as it was fitted.
  std::string FindFault(const EffectFit& fit) const {
    double smallest = 0;
    for (const FitData& d : data_) smallest = std::max(smallest, d.smallest);
    for (std::size_t i = 0; i < fit.extension.shared().size(); ++i) {
      const Extension::Unknown& unknown = fit.extension.shared()[i];
      if (unknown.effect != fit.effect) continue;
      const EffectParameter& p = unknown.Parameter();
      const double x = fit.outcome.state.shared[i];
      if (unknown.IsAtBound(x)) return std::string(p.symbol) + " ends at its physical bound";
      if (p.start_scale == StartScale::kSwing && p.coordinate == Coordinate::kLog && FromCoordinate(p, x) < smallest)
        return std::string(p.symbol) + " is below what the records resolve";
    }
    return "";
  }

  /// One round: all effects that are not in the model yet, each tried by itself.
  std::vector<EffectFit> TryAll(const Step& step) {
    std::vector<const Effect*> tried;
    for (const Effect* effect : catalogue_)
      if (!step.extension.Has(effect)) tried.push_back(effect);
    std::vector<EffectFit> fits = search_.Try(step.extension, step.outcome, tried);
    for (const EffectFit& fit : fits) result_.evaluations += fit.outcome.evaluations;
    return fits;
  }

  /// The best of a round by penalised likelihood, among those that are significant and possible.
  struct Best {
    const EffectFit* fit = nullptr;
    double penalised = std::numeric_limits<double>::infinity();
    double size = 0;
  };

  Best FindBest(const Step& step, const std::vector<EffectFit>& fits) const {
    const EffectFit* lowest = nullptr;
    for (const EffectFit& fit : fits)
      if (fit.refitted && (lowest == nullptr || fit.outcome.chi2 < lowest->outcome.chi2)) lowest = &fit;
    Best best;
    if (lowest == nullptr) return best;
    best.size = EffectiveSize({lowest->extension, lowest->outcome});
    for (const EffectFit& fit : fits) {
      if (!fit.refitted) continue;
      const double statistic = LogLikelihoodRatio(step.outcome.chi2, fit.outcome.chi2, best.size);
      const double p = CalcFamilyWiseP(statistic, fit.unknowns, fit.alternatives, data_.size());
      const double penalised = Penalise(fit.outcome.chi2, fit.unknowns, best.size);
      if (p > kSignificant || penalised >= best.penalised) continue;
      if (penalised > best.size * std::log(step.outcome.chi2)) continue;
      if (!FindFault(fit).empty()) continue;
      best.fit = &fit;
      best.penalised = penalised;
    }
    return best;
  }

  bool IsStructured(const Step& step) const {
    return CalcStructure(data_, step.extension, step.outcome.state).structured;
  }

  /// Adds the best effect again and again, until nothing is left to explain or nothing helps.
  Step GoForward(Step now, std::size_t most) {
    while (now.extension.effects().size() < most && (now.extension.empty() || IsStructured(now))) {
      std::vector<EffectFit> fits = TryAll(now);
      const Best best = FindBest(now, fits);
      const bool first = now.extension.empty() && singles_.empty();
      if (first) ReportCandidates(now, fits, best);
      const bool found = best.fit != nullptr;
      if (found)
        now = {.extension = best.fit->extension, .outcome = search_.Settle(best.fit->extension, best.fit->outcome)};
      if (first) singles_ = std::move(fits);
      if (!found) break;
    }
    return now;
  }

  /// All of a model's penalised likelihood; smaller is better.
  double PenaliseModel(const Step& step, double size) const {
    double penalised = size * std::log(step.outcome.chi2);
    for (const Effect* effect : step.extension.effects()) penalised += CalcPenalty(CountUnknowns(effect), size);
    return penalised;
  }

  /// The effect that explains most by itself may be one that imitates two others: the way forward starts again from
  /// effects of the model so far that came in later, and from the next best ones.
  void LookForBetterPair(const Step& start, Step* final) {
    constexpr std::size_t kMostStarts = 6;
    std::vector<const Effect*> tried;
    if (!final->extension.empty()) tried.push_back(final->extension.effects()[0]);
    while (tried.size() < kMostStarts && (IsStructured(*final) || final->extension.effects().size() > 2)) {
      const EffectFit* single = FindNextStart(start, *final, tried);
      if (single == nullptr) return;
      tried.push_back(single->effect);
      Step pair = GoForward({.extension = single->extension, .outcome = single->outcome}, 2);
      if (pair.extension.effects().size() < 2) continue;
      DropUnneeded(&pair);
      const double size = EffectiveSize(pair.outcome.chi2 < final->outcome.chi2 ? pair : *final);
      if (PenaliseModel(pair, size) < PenaliseModel(*final, size)) *final = std::move(pair);
    }
  }

  /// The next single effect from which a pair may start: those of the model so far first, then by what they explain.
  const EffectFit* FindNextStart(const Step& start, const Step& final, const std::vector<const Effect*>& tried) const {
    const EffectFit* next = nullptr;
    for (const EffectFit& fit : singles_) {
      if (!fit.refitted || fit.outcome.chi2 > 0.95 * start.outcome.chi2) continue;
      if (std::find(tried.begin(), tried.end(), fit.effect) != tried.end()) continue;
      if (!FindFault(fit).empty()) continue;
      const bool in = final.extension.Has(fit.effect);
      const bool next_in = next != nullptr && final.extension.Has(next->effect);
      if (next == nullptr || (in != next_in ? in : fit.outcome.chi2 < next->outcome.chi2)) next = &fit;
    }
    return next;
  }

  void ReportCandidates(const Step& start, const std::vector<EffectFit>& fits, const Best& best) {
    const double size = best.size > 0 ? best.size : EffectiveSize(start);
    double noise = 0;
    for (const EffectFit& fit : fits) {
      Candidate candidate{.effect = fit.effect,
                          .score = fit.score,
                          .visibility = fit.visibility,
                          .refitted = fit.refitted,
                          .unknowns = fit.unknowns};
      for (const EffectFit& other : fits) {
        const double cosine = &other == &fit ? 0 : CalcCollinearity(fit, other);
        if (cosine <= candidate.collinearity) continue;
        candidate.collinearity = cosine;
        candidate.most_alike = other.effect;
      }
      const double chi2 = fit.refitted ? fit.outcome.chi2 : start.outcome.chi2;
      candidate.statistic = LogLikelihoodRatio(start.outcome.chi2, chi2, size);
      candidate.p_value = CalcFamilyWiseP(candidate.statistic, fit.unknowns, fit.alternatives, data_.size());
      candidate.delta_bic = Penalise(chi2, fit.unknowns, size) - size * std::log(start.outcome.chi2);
      candidate.rms_over_noise = std::sqrt(chi2 / samples_);
      if (fit.refitted) {
        const ExtendedResult described = Describe(data_, sharing_, fit.extension, fit.outcome);
        candidate.parameters = described.effects;
        candidate.inadmissible = FindFault(fit);
        if (&fit == best.fit) noise = described.structure.noise / described.structure.rms * candidate.rms_over_noise;
      }
      result_.candidates.push_back(candidate);
    }
    if (noise > 0)  // what counted as noise before may have been a tone
      for (Candidate& candidate : result_.candidates) candidate.rms_over_noise /= noise;
    std::stable_sort(result_.candidates.begin(), result_.candidates.end(),
                     [](const Candidate& a, const Candidate& b) { return a.delta_bic < b.delta_bic; });
  }

  /// The model without one of its effects, fitted again.
  Step FitWithout(const Step& step, const Effect* effect) {
    const Extension extension = step.extension.Without(effect);
    Step without{.extension = extension,
                 .outcome = search_.Refit(extension, Convert(step.extension, step.outcome.state, extension))};
    result_.evaluations += without.outcome.evaluations;
    return without;
  }

  int CountUnknowns(const Effect* effect) const {
    int unknowns = 0;
    for (const EffectParameter& p : effect->parameters)
      unknowns += p.scope == Scope::kLink ? 1 : static_cast<int>(data_.size());
    return unknowns;
  }

  /// Backward: effects that the model can do without, the least needed first.
  void DropUnneeded(Step* step) {
    while (step->extension.effects().size() > 1) {
      const double size = EffectiveSize(*step);
      const bool structured = IsStructured(*step);
      const Effect* least = nullptr;
      Step kept;
      double smallest_gain = std::numeric_limits<double>::infinity();
      for (const Effect* effect : step->extension.effects()) {
        Step without = FitWithout(*step, effect);
        const double gain = LogLikelihoodRatio(without.outcome.chi2, step->outcome.chi2, size) -
                            CalcPenalty(CountUnknowns(effect), size);
        const bool needed = structured ? step->outcome.chi2 < kNeeded * kNeeded * without.outcome.chi2 : gain > 0;
        if (needed || gain >= smallest_gain) continue;
        smallest_gain = gain;
        least = effect;
        kept = std::move(without);
      }
      if (least == nullptr) return;
      *step = std::move(kept);
    }
  }

  /// The final fit once more: with one link for all if it may be, tested with the causes in the model, which the plain
  /// test could not do.
  ExtendedResult DescribeFinal(const Step& final) {
    if (sharing_ == Sharing::kLink || data_.size() < 2 || plain_.sliders > 1)
      return Describe(data_, sharing_, final.extension, final.outcome);
    ExtendedState state = final.outcome.state;
    Levels mean{};
    for (const Levels& levels : state.link.levels)
      for (std::size_t j = 0; j < mean.size(); ++j) mean[j] += levels[j] / static_cast<double>(data_.size());
    state.link.levels = {mean};
    const ExtendedOutcome shared =
        FitExtended(data_, Sharing::kLink, final.extension, state, {.max_iterations = 60, .threads = options_.threads});
    result_.evaluations += shared.evaluations;
    const double statistic = LogLikelihoodRatio(shared.chi2, final.outcome.chi2, EffectiveSize(final));
    const double p = CalcChiSquareTail(std::max(0.0, statistic), 3.0 * static_cast<double>(data_.size() - 1));
    ExtendedResult described = p > kSharingLevel ? Describe(data_, Sharing::kLink, final.extension, shared)
                                                 : Describe(data_, sharing_, final.extension, final.outcome);
    described.sharing_p = p;
    return described;
  }

  void Judge(const Step& start, const Step& final) {
    const Structure before = result_.plain.structure;
    if (final.extension.empty()) {
      result_.extended = result_.plain;
      result_.verdict = before.structured ? Verdict::kUnexplained : Verdict::kAdequate;
      return;
    }
    const Structure after = CalcStructure(data_, final.extension, final.outcome.state);
    const double explained = 1 - final.outcome.chi2 / start.outcome.chi2;
    if (after.structured && explained < kExplainsEnough) {
      result_.extended = result_.plain;
      result_.verdict = Verdict::kUnexplained;
      return;
    }
    DescribeCauses(start, final);
    if (result_.causes.empty()) {
      result_.extended = result_.plain;
      result_.verdict = before.structured ? Verdict::kUnexplained : Verdict::kAdequate;
      return;
    }
    result_.extended = DescribeFinal(final);
    for (Cause& cause : result_.causes) {
      cause.parameters.clear();
      for (const EffectEstimate& e : result_.extended.effects)
        if (e.effect == cause.effect) cause.parameters.push_back(e);
    }
    result_.verdict = after.structured ? Verdict::kPartlyExplained : Verdict::kExplained;
  }

  void DescribeCauses(const Step& start, const Step& final) {
    const double size = EffectiveSize(final);
    for (const Effect* effect : final.extension.effects()) {
      const bool only = final.extension.effects().size() == 1;
      const Step without = only ? start : FitWithout(final, effect);
      Cause cause{.effect = effect};
      const int unknowns = CountUnknowns(effect);
      const double statistic = LogLikelihoodRatio(without.outcome.chi2, final.outcome.chi2, size);
      cause.p_value = CalcFamilyWiseP(statistic, unknowns, CountAlternatives(effect), data_.size());
      cause.delta_bic = -statistic + CalcPenalty(unknowns, size);
      cause.rms_before = CalcStructure(data_, without.extension, without.outcome.state).rms;
      cause.rms_after = CalcStructure(data_, final.extension, final.outcome.state).rms;
      cause.held_out = PredictHeldOut(data_, sharing_, without.extension, without.outcome.state, final.extension,
                                      final.outcome.state, options_.threads);
      if (cause.held_out.known && cause.held_out.Gain() <= 0) {
        result_.notices.push_back(std::string(effect->id) + " fits better but predicts records worse; it is not named");
        continue;
      }
      cause.rivals = FindRivals(without, final, effect, size);
      result_.causes.push_back(std::move(cause));
    }
    std::stable_sort(result_.causes.begin(), result_.causes.end(),
                     [](const Cause& a, const Cause& b) { return a.delta_bic < b.delta_bic; });
  }

  double CountAlternatives(const Effect* effect) const {
    for (const EffectFit& fit : singles_)
      if (fit.effect == effect) return fit.alternatives;
    return 1;
  }

  /// Effects that do as well in the place of a cause.
  std::vector<const Effect*> FindRivals(const Step& without, const Step& final, const Effect* effect, double size) {
    std::vector<const Effect*> rivals;
    if (!without.extension.empty() && plain_.sliders > 1) return rivals;  // would take as long as all the rest
    const double best = Penalise(final.outcome.chi2, CountUnknowns(effect), size);
    const std::vector<EffectFit> fits = without.extension.empty() ? singles_ : TryAll(without);
    for (const EffectFit& fit : fits) {
      if (!fit.refitted || final.extension.Has(fit.effect) || !FindFault(fit).empty()) continue;
      if (Penalise(fit.outcome.chi2, fit.unknowns, size) < best + kRivalBic) rivals.push_back(fit.effect);
    }
    return rivals;
  }

  const Identification& plain_;
  const DiagnoseOptions& options_;
  std::vector<FitData> data_;
  const Sharing sharing_;
  EffectSearch search_;
  std::vector<const Effect*> catalogue_;
  double samples_ = 0;
  std::vector<EffectFit> singles_;  // the plain model with one effect each
  Diagnosis result_;
};

}  // namespace

const char* Name(Verdict verdict) {
  switch (verdict) {
    case Verdict::kAdequate:
      return "adequate";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kPartlyExplained:
      return "partly_explained";
    case Verdict::kUnexplained:
      return "unexplained";
  }
  return "";
}

Diagnosis Diagnose(const Identification& plain, const DiagnoseOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Diagnosis diagnosis = Diagnoser(plain, options).Run();
  DescribeSymptoms(plain, &diagnosis);
  diagnosis.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return diagnosis;
}

std::vector<ParameterShift> CalcParameterShifts(const Identification& plain, const Diagnosis& diagnosis) {
  std::vector<ParameterShift> shifts;
  const int n = plain.sliders;
  for (int q = 0; q < (n == 1 ? 3 : CountQuantities(n)); ++q) {
    const Estimate& before = plain.quantities[static_cast<std::size_t>(q)];
    const Estimate& after = diagnosis.extended.quantities[static_cast<std::size_t>(q)];
    shifts.push_back({.symbol = QuantityName(n, q),
                      .shift = before.value - after.value,
                      .in_std = before.std > 0 ? (before.value - after.value) / before.std : 0});
  }
  return shifts;
}

}  // namespace uiclink
