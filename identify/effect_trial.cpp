#include "identify/effect_trial.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/start_values.h"

namespace uiclink {
namespace {

constexpr double kWorthARefit = 6;    // promised fall of the sum of squares: less is what noise gives
constexpr double kLeavesMuch = 1.05;  // mean square over noise from which a linear screen is no longer trusted alone
constexpr std::size_t kCorrectionStride = 8;

/// Puts a start of one effect into a state that has neutral values for it.
void Put(const Extension& extension, const Effect* effect, const StartPoint& start, ExtendedState* state) {
  const Extension::Range shared = extension.SharedOf(effect), own = extension.OwnOf(effect);
  std::copy(start.shared.begin(), start.shared.end(),
            state->shared.begin() + static_cast<std::ptrdiff_t>(shared.first));
  for (std::vector<double>& values : state->own)
    std::copy(start.own.begin(), start.own.end(), values.begin() + static_cast<std::ptrdiff_t>(own.first));
}

SizeUnknowns FindSizes(const Extension& extension, const Effect* effect, const UnknownMap& map, int link,
                       std::size_t records) {
  SizeUnknowns sizes;
  const auto is_size = [&](const Extension::Unknown& u) {
    return u.effect == effect && (u.parameter == 0 || (effect->quadrature && u.parameter == 1));
  };
  for (std::size_t i = 0; i < extension.shared().size(); ++i) {
    if (!is_size(extension.shared()[i])) continue;
    sizes.numbers.push_back(map.Columns(0)[static_cast<std::size_t>(link) + 3 + i]);
    sizes.places.push_back({.shared = true, .index = i});
  }
  for (std::size_t r = 0; r < records; ++r)
    for (std::size_t i = 0; i < extension.own().size(); ++i) {
      if (!is_size(extension.own()[i])) continue;
      sizes.numbers.push_back(map.Columns(r)[static_cast<std::size_t>(link) + 3 + extension.shared().size() + i]);
      sizes.places.push_back({.shared = false, .record = r, .index = i});
    }
  return sizes;
}

/// Moves the sizes by a linear step, within their bounds.
void Step(const Extension& extension, const SizeUnknowns& sizes, const Eigen::VectorXd& step, double share,
          ExtendedState* state) {
  for (std::size_t i = 0; i < sizes.places.size(); ++i) {
    const SizeUnknowns::Place& place = sizes.places[i];
    const Extension::Unknown& unknown = place.shared ? extension.shared()[place.index] : extension.own()[place.index];
    double& value = place.shared ? state->shared[place.index] : state->own[place.record][place.index];
    value = std::clamp(value + share * step(static_cast<Eigen::Index>(i)), unknown.low, unknown.high);
  }
}

}  // namespace

ExtendedState TakeRecord(const ExtendedState& all, std::size_t record, std::size_t donor) {
  ExtendedState one;
  one.shared = all.shared;
  one.own = {all.own[record]};
  one.link.shape = all.link.shape;
  one.link.levels = {all.link.levels[donor]};
  one.link.shapes = {all.link.shapes[donor]};
  one.link.starts = {all.link.starts[record]};
  return one;
}

void PutRecord(const ExtendedState& one, std::size_t record, ExtendedState* all) {
  all->link.levels[record] = one.link.levels[0];
  all->link.shapes[record] = one.link.shapes[0];
  all->link.starts[record] = one.link.starts[0];
  all->own[record] = one.own[0];
}

Trial::Trial(std::span<const FitData> data, Sharing sharing, const Extension& current, const ExtendedOutcome& now,
             const Effect* effect)
    : data_(data), sharing_(sharing), effect_(effect), sliders_(CountSliders(now.state.link.shape)), now_(now) {
  fit_.effect = effect;
  fit_.extension = current.With(effect);
  neutral_ = Convert(current, now.state, fit_.extension);
  sizes_ = FindSizes(fit_.extension, effect,
                     UnknownMap(fit_.extension, sharing, sliders_, data.size(), !now.state.link.shapes.empty()),
                     2 * sliders_ + 1, data.size());
  fit_.unknowns =
      static_cast<int>(fit_.extension.SharedOf(effect).size + fit_.extension.OwnOf(effect).size * data.size());
  double samples = 0;
  for (const FitData& d : data) samples += static_cast<double>(d.size);
  leaves_much_ = now.chi2 > kLeavesMuch * samples;
}

void Trial::Explore(std::span<const std::vector<float>> residuals) {
  Screen(residuals);
  if (scored_.empty()) return;
  FindCorrection();
  if (leaves_much_ || HasNoScore() || fit_.score >= kWorthARefit) RefitQuickly();
}

double Trial::chi2() const {
  return found_ ? best_.chi2 * static_cast<double>(stride_) : std::numeric_limits<double>::infinity();
}

void Trial::Finish(double best_of_all) {
  const double far_behind = sliders_ == 1 ? 25 : 2;  // fits of several sliders take long
  if (!found_) return;
  const int iterations = chi2() > far_behind * best_of_all ? 0 : 60;
  fit_.outcome = FitExtended(data_, sharing_, fit_.extension, best_.state, {.max_iterations = iterations});
  fit_.outcome.evaluations += evaluations_;
  fit_.refitted = std::isfinite(fit_.outcome.chi2);
  if (fit_.refitted && fit_.outcome.chi2 <= now_.chi2) return;
  // The search has strayed: the effect gains nothing that it could find.
  fit_.outcome.state = neutral_;
  fit_.outcome.chi2 = now_.chi2;
  fit_.outcome.chi2_of_record = now_.chi2_of_record;
}

ExtendedState Trial::StateAt(const StartPoint& start) const {
  ExtendedState state = neutral_;
  Put(fit_.extension, effect_, start, &state);
  return state;
}

void Trial::Screen(std::span<const std::vector<float>> residuals) {
  for (const StartPoint& start : StartGrid(data_, now_.state.link, residuals).Make(*effect_)) {
    const Normal normal = CalcNormal(data_, sharing_, fit_.extension, StateAt(start), 1);
    Score score;
    if (normal.gram.allFinite() && normal.gradient.allFinite()) score = TestScore(normal, sizes_.numbers);
    if (!HasNoScore()) score.statistic = std::max(0.0, score.statistic + now_.chi2 - normal.chi2);
    scored_.emplace_back(start, score);
  }
  fit_.alternatives = CountAlternatives();
  std::stable_sort(scored_.begin(), scored_.end(),
                   [](const auto& a, const auto& b) { return a.second.statistic > b.second.statistic; });
  if (scored_.empty()) return;
  fit_.score = scored_[0].second.statistic;
  fit_.visibility = scored_[0].second.visibility;
}

double Trial::CountAlternatives() const {
  const double rate = data_[0].record->sampling_hz, seconds = static_cast<double>(data_[0].size) / rate;
  for (const EffectParameter& p : effect_->parameters)
    if (p.start_scale == StartScale::kSpectrum)
      return std::max(1.0, 2 * seconds * (std::min(p.high, rate / 2) - p.low));
  return static_cast<double>(std::max<std::size_t>(1, scored_.size()));
}

void Trial::FindCorrection() {
  const UnknownMap map(fit_.extension, sharing_, sliders_, data_.size(), !now_.state.link.shapes.empty());
  const ExtendedState state = StateAt(scored_[0].first);
  const Eigen::VectorXd& step = scored_[0].second.step;
  for (std::size_t r = 0; r < data_.size(); ++r) {
    const Linearisation at = LineariseExtended(data_[r], fit_.extension, state, r, kCorrectionStride);
    const std::vector<Eigen::Index> columns = map.Columns(r);
    Eigen::VectorXd change = Eigen::VectorXd::Zero(at.residuals.size());
    for (std::size_t i = 0; i < sizes_.numbers.size() && i < static_cast<std::size_t>(step.size()); ++i) {
      const auto found = std::find(columns.begin(), columns.end(), sizes_.numbers[i]);
      if (found == columns.end()) continue;
      change += at.jacobian.col(found - columns.begin()) * step(static_cast<Eigen::Index>(i));
    }
    if (!change.allFinite()) change.setZero();
    const Eigen::MatrixXd base = at.jacobian.leftCols(2 * sliders_ + 4);
    change -= base * base.colPivHouseholderQr().solve(change);
    for (const double x : change) fit_.correction.push_back(static_cast<float>(x));
  }
}

std::vector<ExtendedState> Trial::SpreadSizes(const StartPoint& start, const Score& score) const {
  std::vector<ExtendedState> states;
  if (HasNoScore()) return {StateAt(start)};
  for (const double share : {1.0, 0.2}) {
    states.push_back(StateAt(start));
    if (score.step.size() > 0) Step(fit_.extension, sizes_, score.step, share, &states.back());
    if (!leaves_much_ || effect_->quadrature) return states;
  }
  const EffectParameter& size = effect_->parameters[0];
  if (size.scope != Scope::kLink || size.starts.empty()) return states;
  const std::size_t index = sizes_.places[0].index;
  const Extension::Unknown& unknown = fit_.extension.shared()[index];
  const double shows = StartGrid(data_, now_.state.link, {}).Values(*effect_, size)[0];
  for (const double share : {1.0, 0.2, -0.2, -1.0}) {
    const double value = share * shows;
    if (value < unknown.low || value > unknown.high) continue;
    states.push_back(StateAt(start));
    states.back().shared[index] = value;
  }
  return states;
}

void Trial::ChooseRecords() {
  const std::size_t enough = sliders_ == 1 ? 4 : 2;
  std::vector<std::size_t> order(data_.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return data_[a].swing > data_[b].swing; });
  if (order.size() > enough) order.resize(enough);
  chosen_ = order;
  for (const std::size_t r : chosen_) chosen_data_.push_back(data_[r]);
}

ExtendedState Trial::ChooseFrom(const ExtendedState& all) const {
  ExtendedState state;
  state.link.shape = all.link.shape;
  state.shared = all.shared;
  if (sharing_ == Sharing::kLink) state.link.levels = all.link.levels;
  for (const std::size_t r : chosen_) {
    if (sharing_ == Sharing::kShape) state.link.levels.push_back(all.link.levels[r]);
    if (!all.link.shapes.empty()) state.link.shapes.push_back(all.link.shapes[r]);
    state.link.starts.push_back(all.link.starts[r]);
    state.own.push_back(all.own[r]);
  }
  return state;
}

ExtendedOutcome Trial::FitTheOthers(const ExtendedOutcome& chosen, const ExtendedState& from,
                                    const ExtendedControl& control) {
  ExtendedOutcome all;
  all.state = from;
  all.state.link.shape = chosen.state.link.shape;
  all.state.shared = chosen.state.shared;
  if (sharing_ == Sharing::kLink) all.state.link.levels = chosen.state.link.levels;
  for (std::size_t i = 0; i < chosen_.size(); ++i) {
    const std::size_t r = chosen_[i];
    if (sharing_ == Sharing::kShape) all.state.link.levels[r] = chosen.state.link.levels[i];
    if (!chosen.state.link.shapes.empty()) all.state.link.shapes[r] = chosen.state.link.shapes[i];
    all.state.link.starts[r] = chosen.state.link.starts[i];
    all.state.own[r] = chosen.state.own[i];
  }
  if (chosen_.size() == data_.size()) {
    all.chi2 = chosen.chi2;
    return all;
  }
  if (!all.state.link.shapes.empty()) StartFromChosen(chosen, control, &all.state);
  return Fit(data_, all.state, control);
}

void Trial::StartFromChosen(const ExtendedOutcome& chosen, const ExtendedControl& control, ExtendedState* all) {
  ExtendedControl given = control;
  given.fix_shared = true;
  for (std::size_t r = 0; r < data_.size(); ++r) {
    if (std::find(chosen_.begin(), chosen_.end(), r) != chosen_.end()) continue;
    ExtendedState own = TakeRecord(*all, r, r);
    ExtendedOutcome best;
    best.chi2 = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i <= chosen_.size(); ++i) {
      const bool from_own = i == chosen_.size();
      own.link.levels = {from_own ? all->link.levels[r] : chosen.state.link.levels[i]};
      own.link.shapes = {from_own ? all->link.shapes[r] : chosen.state.link.shapes[i]};
      ExtendedOutcome outcome = FitExtended({&data_[r], 1}, sharing_, fit_.extension, own, given);
      evaluations_ += outcome.evaluations;
      if (outcome.chi2 < best.chi2) best = std::move(outcome);
    }
    if (!std::isfinite(best.chi2)) continue;
    PutRecord(best.state, r, all);
  }
}

ExtendedOutcome Trial::Fit(std::span<const FitData> data, const ExtendedState& state, const ExtendedControl& control) {
  ExtendedOutcome outcome = FitExtended(data, sharing_, fit_.extension, state, control);
  evaluations_ += outcome.evaluations;
  return outcome;
}

bool Trial::FetchStrays(ExtendedState* state) {
  constexpr double kStray = 0.3;  // of a logarithm: ten times what seats differ by
  std::vector<Levels>& levels = state->link.levels;
  if (levels.size() < 3) return false;
  Levels median{};
  for (std::size_t j = 0; j < median.size(); ++j) {
    std::vector<double> values;
    for (const Levels& of_record : levels) values.push_back(of_record[j]);
    std::sort(values.begin(), values.end());
    median[j] = values[values.size() / 2];
  }
  bool any = false;
  for (Levels& of_record : levels) {
    double farthest = 0;
    for (std::size_t j = 0; j < median.size(); ++j) farthest = std::max(farthest, std::abs(of_record[j] - median[j]));
    if (farthest < kStray) continue;
    of_record = median;
    any = true;
  }
  return any;
}

ExtendedOutcome Trial::Regrow(const ExtendedControl& glance, const ExtendedControl& quick) {
  constexpr double kFirstSplit = 3, kLaterSplit = 1.6;  // ratios of the critical displacements of the two halves
  ExtendedOutcome best;
  best.chi2 = std::numeric_limits<double>::infinity();
  const auto keep = [&](ExtendedOutcome outcome) {
    if (outcome.chi2 < best.chi2) best = std::move(outcome);
  };
  const std::size_t starts = std::min<std::size_t>(scored_.size(), 3);
  for (std::size_t i = 0; i < starts; ++i)
    for (const ExtendedState& state : SpreadSizes(scored_[i].first, scored_[i].second)) {
      ExtendedState one = ChooseFrom(state);
      one.link.shape.clear();
      for (Shape& shape : one.link.shapes) shape.clear();
      keep(Fit(chosen_data_, one, glance));
    }
  if (!std::isfinite(best.chi2)) return best;
  best = Fit(chosen_data_, best.state, quick);
  for (int n = 2; n <= sliders_; ++n) {
    const ExtendedState fewer = best.state;
    best.chi2 = std::numeric_limits<double>::infinity();
    for (int split = 0; split + 1 < n; ++split) {
      ExtendedState grown = fewer;
      const double spread = n == 2 ? kFirstSplit : kLaterSplit;
      Split(fewer.link.levels[0], fewer.link.shape, split, spread, &grown.link.shape);
      for (std::size_t r = 0; r < grown.link.shapes.size(); ++r)
        Split(fewer.link.levels[r], fewer.link.shapes[r], split, spread, &grown.link.shapes[r]);
      keep(Fit(chosen_data_, grown, quick));
    }
    if (!std::isfinite(best.chi2)) return best;
  }
  return best;
}

void Trial::Split(const Levels& levels, const Shape& shape, int split, double spread, Shape* result) const {
  Levels same;
  FromOscillator(SplitSlider(ToOscillator(levels, shape, data_[0].g), split, spread), &same, result);
}

void Trial::RefitQuickly() {
  constexpr std::size_t kFewStarts = 2, kManyStarts = 12, kKept = 2;
  ChooseRecords();
  stride_ = effect_->quadrature || HasNoScore() ? 1 : 4;
  const ExtendedControl glance{
      .stride = stride_, .max_iterations = 4, .function_tolerance = 1e-3, .step_tolerance = 1e-6};
  const ExtendedControl quick{
      .stride = stride_, .max_iterations = 15, .function_tolerance = 1e-4, .step_tolerance = 1e-6};
  struct Attempt {
    ExtendedOutcome outcome;
    ExtendedState from;
  };
  std::vector<Attempt> attempts;
  const auto sort = [&] {
    std::erase_if(attempts, [](const Attempt& a) { return !std::isfinite(a.outcome.chi2); });
    std::sort(attempts.begin(), attempts.end(),
              [](const Attempt& a, const Attempt& b) { return a.outcome.chi2 < b.outcome.chi2; });
  };
  const bool many = sliders_ == 1 && (leaves_much_ || HasNoScore());
  const std::size_t starts = std::min(scored_.size(), many ? kManyStarts : kFewStarts);
  for (std::size_t i = 0; i < starts; ++i)
    for (const ExtendedState& state : SpreadSizes(scored_[i].first, scored_[i].second))
      attempts.push_back({Fit(chosen_data_, ChooseFrom(state), glance), state});
  if (sliders_ > 1 && leaves_much_) attempts.push_back({Regrow(glance, quick), neutral_});
  sort();
  if (attempts.size() > kKept) attempts.resize(kKept);
  for (std::size_t i = 0, kept = attempts.size(); i < kept; ++i) {
    ExtendedState fetched = attempts[i].outcome.state;
    if (!FetchStrays(&fetched)) continue;
    attempts.push_back(attempts[i]);
    attempts.back().outcome.state = std::move(fetched);
  }
  for (Attempt& attempt : attempts) attempt.outcome = Fit(chosen_data_, attempt.outcome.state, quick);
  sort();
  if (attempts.empty()) return;
  best_ = FitTheOthers(attempts[0].outcome, attempts[0].from, quick);
  found_ = std::isfinite(best_.chi2);
}

}  // namespace uiclink
