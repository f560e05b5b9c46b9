#include "identify/effect_search.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "identify/parallel.h"
#include "identify/record_fit.h"
#include "identify/start_values.h"

namespace uiclink {
namespace {

constexpr double kWorthARefit = 6;    // promised fall of the sum of squares: less is what noise gives
constexpr double kLeavesMuch = 1.05;  // mean square over noise from which a linear screen is no longer trusted alone
constexpr std::size_t kCorrectionStride = 8;
constexpr std::size_t kLines = 4;  // of a spectrum that are tried

/// Where a fit of one effect starts: coordinates of its shared and own unknowns.
struct StartPoint {
  std::vector<double> shared, own;
  double promised = 0;
};

double LargestSwing(std::span<const FitData> data) {
  double swing = 0;
  for (const FitData& d : data) swing = std::max(swing, d.swing);
  return swing;
}

/// Largest reading of the fitted parts, by size [m].
double LargestReading(std::span<const FitData> data) {
  double largest = 0;
  for (const FitData& d : data)
    for (std::size_t i = 0; i < d.size; ++i) largest = std::max(largest, std::abs(d.record->y[d.first + i]));
  return largest;
}

/// A size that is neutral at infinity (the level of a sensor that clips) has no sensitivity there.
bool HasNoScore(const Effect& effect) {
  return std::isinf(effect.neutral) && effect.parameters[0].coordinate == Coordinate::kLinear;
}

/// All combinations of the start values of an effect's parameters, in coordinates.
class StartGrid {
 public:
  StartGrid(std::span<const FitData> data, const FitState& link, std::span<const std::vector<float>> residuals)
      : data_(data), link_(link), residuals_(residuals) {}

  std::vector<StartPoint> Make(const Effect& effect) const {
    std::vector<std::vector<double>> points = {{}};
    for (std::size_t p = 0; p < effect.parameters.size(); ++p) {
      const EffectParameter& parameter = effect.parameters[p];
      std::vector<double> values = {0.0};
      const bool is_size = p == 0 || (effect.quadrature && p == 1);
      if (!is_size || HasNoScore(effect)) {
        values = Values(effect, parameter);
      } else {
        values = {p == 0 ? NearNeutral(effect) : 0.0};
      }
      std::vector<std::vector<double>> longer;
      for (const std::vector<double>& point : points)
        for (const double value : values) {
          longer.push_back(point);
          longer.back().push_back(value);
        }
      points = std::move(longer);
    }
    std::vector<StartPoint> starts;
    for (const std::vector<double>& point : points) {
      StartPoint start;
      for (std::size_t p = 0; p < point.size(); ++p)
        (effect.parameters[p].scope == Scope::kLink ? start.shared : start.own).push_back(point[p]);
      starts.push_back(start);
    }
    return starts;
  }

  /// Where the size is linearised. Sizes of one sign only (losses) just beside the neutral value: without any loss a
  /// link with k1 < k slips for ever, ever less, and the least loss ends that, so that the tangent at zero knows
  /// nothing of the tail of the record.
  double NearNeutral(const Effect& effect) const {
    constexpr double kBeside = 1e-5;  // of a size that shows clearly: below what any record resolves
    const EffectParameter& size = effect.parameters[0];
    const double neutral = ToCoordinate(size, effect.neutral);
    const bool one_sided = size.coordinate == Coordinate::kLinear && size.low == effect.neutral;
    return one_sided ? neutral + kBeside * Values(effect, size)[0] : neutral;
  }

  /// Start values of a parameter, in coordinates.
  std::vector<double> Values(const Effect& effect, const EffectParameter& parameter) const {
    std::vector<double> values;
    if (parameter.start_scale == StartScale::kSpectrum) {
      for (const double decay : {0.0, 0.5}) {
        const double nyquist = 0.5 * data_[0].record->sampling_hz;
        const bool steady = effect.parameters.size() <= 3;
        // A steady tone may be folded onto the very end of the spectrum; one that dies away needs room about it.
        const double low = parameter.low, high = std::min(parameter.high, (steady ? 1.0 : 0.98) * nyquist);
        if (steady && decay > 0) continue;
        for (const double f : FindLines(residuals_, data_[0].record->sampling_hz, low, high, decay, kLines))
          values.push_back(f);
      }
    } else {
      double scale = 1;
      if (parameter.start_scale == StartScale::kSwing)
        scale = effect.stage == ReadingStage::kClipped ? LargestReading(data_) : LargestSwing(data_);
      if (parameter.start_scale == StartScale::kSpeed) scale = LargestSwing(data_) * Frequency();
      for (const double start : parameter.starts)
        values.push_back(std::clamp(start * scale, parameter.low, parameter.high));
    }
    for (double& value : values) value = ToCoordinate(parameter, value);
    return values;
  }

 private:
  double Frequency() const {
    return std::sqrt(data_[0].g * (std::exp(link_.levels[0][0]) + 0.5 * std::exp(link_.levels[0][1])));
  }

  std::span<const FitData> data_;
  const FitState& link_;
  std::span<const std::vector<float>> residuals_;
};

/// Puts a start of one effect into a state that has neutral values for it.
void Put(const Extension& extension, const Effect* effect, const StartPoint& start, ExtendedState* state) {
  const Extension::Range shared = extension.SharedOf(effect), own = extension.OwnOf(effect);
  std::copy(start.shared.begin(), start.shared.end(),
            state->shared.begin() + static_cast<std::ptrdiff_t>(shared.first));
  for (std::vector<double>& values : state->own)
    std::copy(start.own.begin(), start.own.end(), values.begin() + static_cast<std::ptrdiff_t>(own.first));
}

/// The sizes of an effect among all unknowns: parameter 0, with `quadrature` 0 and 1; own ones of every record.
struct SizeUnknowns {
  std::vector<Eigen::Index> numbers;
  struct Place {
    bool shared = true;
    std::size_t record = 0, index = 0;
  };
  std::vector<Place> places;
};

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

namespace {

/// The state of one record of several, taken by itself, with the link of `donor`.
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

void SortOwnSliders(ExtendedState* state) {
  for (std::size_t r = 0; r < state->link.shapes.size(); ++r) {
    FitState one{.levels = {state->link.levels[r]}, .shape = state->link.shapes[r], .starts = {}};
    SortSliders(&one);
    state->link.levels[r] = one.levels[0];
    state->link.shapes[r] = one.shape;
  }
}

}  // namespace

namespace {

/// The trial of one effect: screen, quick refits from many starts, the best of them to the end.
class Trial {
 public:
  Trial(std::span<const FitData> data, Sharing sharing, const Extension& current, const ExtendedOutcome& now,
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

  /// Screen, and quick refits where they are worth it.
  void Explore(std::span<const std::vector<float>> residuals) {
    Screen(residuals);
    if (scored_.empty()) return;
    FindCorrection();
    if (leaves_much_ || HasNoScore() || fit_.score >= kWorthARefit) RefitQuickly();
  }

  /// Sum of squares of the best quick refit, in units of all samples.
  double chi2() const {
    return found_ ? best_.chi2 * static_cast<double>(stride_) : std::numeric_limits<double>::infinity();
  }

  /// The best quick refit to the end, or as it is where it is far behind the best of all effects.
  void Finish(double best_of_all) {
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

  EffectFit Take() { return std::move(fit_); }

 private:
  bool HasNoScore() const { return uiclink::HasNoScore(*effect_); }

  ExtendedState StateAt(const StartPoint& start) const {
    ExtendedState state = neutral_;
    Put(fit_.extension, effect_, start, &state);
    return state;
  }

  void Screen(std::span<const std::vector<float>> residuals) {
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

  /// Places that were tried; for tones all frequencies that the records can tell apart.
  double CountAlternatives() const {
    const double rate = data_[0].record->sampling_hz, seconds = static_cast<double>(data_[0].size) / rate;
    for (const EffectParameter& p : effect_->parameters)
      if (p.start_scale == StartScale::kSpectrum)
        return std::max(1.0, 2 * seconds * (std::min(p.high, rate / 2) - p.low));
    return static_cast<double>(std::max<std::size_t>(1, scored_.size()));
  }

  /// What the effect would change in the readings by the linear screen, less what the link and the starts absorb.
  void FindCorrection() {
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

  /// Sizes to start from: the linear step, and, where the fit is far from its minimum and the step means little, parts
  /// of it and sizes that show clearly, on either side.
  std::vector<ExtendedState> SpreadSizes(const StartPoint& start, const Score& score) const {
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

  /// The most telling records, as many as a search needs: those with the largest swings.
  void ChooseRecords() {
    const std::size_t enough = sliders_ == 1 ? 4 : 2;
    std::vector<std::size_t> order(data_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return data_[a].swing > data_[b].swing; });
    if (order.size() > enough) order.resize(enough);
    chosen_ = order;
    for (const std::size_t r : chosen_) chosen_data_.push_back(data_[r]);
  }

  ExtendedState ChooseFrom(const ExtendedState& all) const {
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

  /// The same for all records: those that were not chosen start from the effect's size and their own link.
  ExtendedOutcome FitTheOthers(const ExtendedOutcome& chosen, const ExtendedState& from,
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

  /// Records that were not chosen may have settled where their sliders imitate the effect: each starts from its own
  /// link or from that of a chosen record, whichever describes it better beside the effect.
  void StartFromChosen(const ExtendedOutcome& chosen, const ExtendedControl& control, ExtendedState* all) {
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

  ExtendedOutcome Fit(std::span<const FitData> data, const ExtendedState& state, const ExtendedControl& control) {
    ExtendedOutcome outcome = FitExtended(data, sharing_, fit_.extension, state, control);
    evaluations_ += outcome.evaluations;
    return outcome;
  }

  /// A record that the plain model describes badly may have ended at a link that no other record has, and does not come
  /// back: it starts from the median of all. @returns whether there was one.
  static bool FetchStrays(ExtendedState* state) {
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

  /// Several sliders that were fitted without the effect have often settled where they imitate it, and do not come
  /// back. So the link is grown once more, from one slider with the effect at its side to as many as it has.
  ExtendedOutcome Regrow(const ExtendedControl& glance, const ExtendedControl& quick) {
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

  /// The shape with one slider split in two; the levels stay.
  void Split(const Levels& levels, const Shape& shape, int split, double spread, Shape* result) const {
    Levels same;
    FromOscillator(SplitSlider(ToOscillator(levels, shape, data_[0].g), split, spread), &same, result);
  }

  void RefitQuickly() {
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

}  // namespace

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

std::vector<double> FindLines(std::span<const std::vector<float>> residuals, double sampling_hz, double low_hz,
                              double high_hz, double decay, std::size_t count) {
  constexpr std::size_t kLanes = 8;
  std::size_t longest = 0;
  for (const std::vector<float>& r : residuals) longest = std::max(longest, r.size());
  const double step_hz = 0.4 * sampling_hz / static_cast<double>(std::max<std::size_t>(longest, 1));
  const auto size = static_cast<std::size_t>(std::max(0.0, (high_hz - low_hz) / step_hz)) + 1;
  std::vector<double> power(size + kLanes - 1);
  for (const std::vector<float>& series : residuals) {
    std::vector<double> weighted(series.begin(), series.end());
    for (std::size_t i = 0; i < weighted.size(); ++i)
      weighted[i] *= std::exp(-decay * static_cast<double>(i) / sampling_hz);
    // Goertzel: one multiplication a sample. One frequency alone would wait for its own last sum.
    for (std::size_t k = 0; k < size; k += kLanes) {
      std::array<double, kLanes> twice{}, s1{}, s2{};
      for (std::size_t l = 0; l < kLanes; ++l)
        twice[l] = 2 * std::cos(2 * std::numbers::pi * (low_hz + static_cast<double>(k + l) * step_hz) / sampling_hz);
      for (const double x : weighted)
        for (std::size_t l = 0; l < kLanes; ++l) {
          const double s0 = x + twice[l] * s1[l] - s2[l];
          s2[l] = s1[l];
          s1[l] = s0;
        }
      for (std::size_t l = 0; l < kLanes; ++l) power[k + l] += s1[l] * s1[l] + s2[l] * s2[l] - twice[l] * s1[l] * s2[l];
    }
  }
  power.resize(size);
  // The top of a peak lies between the frequencies that were tried.
  const auto find_top = [&](std::size_t k) {
    const double at = low_hz + static_cast<double>(k) * step_hz;
    if (k == 0 || k + 1 == size) return at;
    const double bend = power[k - 1] - 2 * power[k] + power[k + 1];
    return at + (bend < 0 ? 0.5 * (power[k - 1] - power[k + 1]) / bend : 0.0) * step_hz;
  };
  std::vector<std::size_t> peaks;
  for (std::size_t k = 0; k < size; ++k)
    if ((k == 0 || power[k] >= power[k - 1]) && (k + 1 == size || power[k] > power[k + 1])) peaks.push_back(k);
  std::sort(peaks.begin(), peaks.end(), [&](std::size_t a, std::size_t b) { return power[a] > power[b]; });
  std::vector<double> lines;
  for (const std::size_t k : peaks) {
    if (lines.size() == count) break;
    const double f = find_top(k);
    const bool near =
        std::any_of(lines.begin(), lines.end(), [&](double other) { return std::abs(other - f) < 3 * step_hz; });
    if (!near) lines.push_back(f);
  }
  return lines;
}

}  // namespace uiclink
