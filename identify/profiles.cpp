#include "identify/profiles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>

#include "identify/screen.h"
#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr std::array<double, 4> kSteps = {-2, -1, 1, 2};  // standard deviations
// Relative fall of the sum of squares at which a refit stops: a hundredth of its rise at the nearest point, of a record
// of 2500 samples.
constexpr double kTolerance = 1e-6;
constexpr int kIterations = 8;
constexpr double kReach = 0.1;  // of a prediction, in logarithms of what the records hardly determine

/// A fit with one unknown held.
struct Point {
  double value = 0;
  double chi2 = 0;
};

LikelihoodProfile MakeProfile(std::string symbol, std::string unit, int record, Point best, std::vector<Point> points,
                              double variance_factor) {
  LikelihoodProfile profile{
      .symbol = std::move(symbol), .unit = std::move(unit), .record = record, .value = {}, .root = {}};
  points.push_back(best);
  std::ranges::sort(points, {}, &Point::value);
  for (const Point& point : points) {
    if (!std::isfinite(point.chi2)) continue;
    if (!profile.value.empty() && point.value == profile.value.back()) continue;
    const double root = std::sqrt(std::max(0.0, point.chi2 - best.chi2) / variance_factor);
    profile.value.push_back(point.value);
    profile.root.push_back(point.value < best.value ? -root : root);
  }
  return profile;
}

std::string LevelSymbol(int sliders, std::size_t level) {
  if (level == 0) return "k";
  if (sliders == 1) return level == 1 ? "k1" : "T01";
  return level == 1 ? "sum_ki" : "sum_T0i";
}

/// The unknowns of one record, the shared parameters among them.
ExtendedState TakeRecord(const ExtendedState& all, std::size_t record) {
  ExtendedState one;
  one.link.levels = {all.link.LevelsOf(record)};
  one.link.shape = all.link.ShapeOf(record);
  one.link.starts = {all.link.starts[record]};
  one.shared = all.shared;
  if (!all.own.empty()) one.own = {all.own[record]};
  return one;
}

/// Moves all unknowns by a step in the order of the map. Shared ones that are held must not be in it.
void Move(const Eigen::VectorXd& step, const UnknownMap& map, ExtendedState* state) {
  FitState& link = state->link;
  for (std::size_t r = 0; r < link.starts.size(); ++r) {
    const std::vector<Eigen::Index> columns = map.Columns(r);
    std::size_t next = 0;
    // What records have in common is moved with the first of them.
    const auto move = [&](auto& values, bool here) {
      for (double& x : values) {
        if (here) x += step(columns[next]);
        ++next;
      }
    };
    move(link.levels[link.levels.size() == 1 ? 0 : r], r == 0 || link.levels.size() > 1);
    move(link.shapes.empty() ? link.shape : link.shapes[r], r == 0 || !link.shapes.empty());
    move(link.starts[r], true);
    move(state->shared, r == 0);
    if (!state->own.empty()) move(state->own[r], true);
  }
}

/// A fit, and the covariance of its unknowns: where refits with one unknown held start from.
class Surroundings {
 public:
  /// @param fix_shared  the shared parameters of the effects stay as they are
  Surroundings(std::span<const FitData> data, Sharing sharing, const Extension& extension, ExtendedState best,
               double chi2, double variance_factor, bool fix_shared)
      : data_(data),
        sharing_(sharing),
        extension_(extension),
        best_(std::move(best)),
        chi2_(chi2),
        variance_factor_(variance_factor),
        map_(extension, sharing, CountSliders(best_.link.shape), data.size(), !best_.link.shapes.empty()) {
    control_.max_iterations = kIterations;
    control_.function_tolerance = kTolerance;
    control_.fix_shared = fix_shared;
    Eigen::MatrixXd gram = CalcNormal(data, sharing, extension, best_, 1).gram;
    if (fix_shared) {  // known: no way through them
      const auto shared = static_cast<Eigen::Index>(extension.shared().size());
      gram.middleRows(map_.first_shared(), shared).setZero();
      gram.middleCols(map_.first_shared(), shared).setZero();
    }
    // Nearly equal sliders leave directions open in which the linear step would go far beyond where it holds.
    for (std::size_t r = 0; r < data.size(); ++r) {
      const std::vector<Eigen::Index> columns = map_.Columns(r);
      for (std::size_t i = 0; i < 3 + best_.link.shape.size(); ++i)
        gram(columns[i], columns[i]) += variance_factor / (kReach * kReach);
    }
    constexpr double kRounding = 1e-12;
    covariance_ = variance_factor * InvertDetermined(gram, kRounding);
  }

  const UnknownMap& map() const { return map_; }
  const ExtendedState& best() const { return best_; }

  /// @param column  of the unknown in the map
  /// @param hold    says so to the fit
  /// @param value   of the unknown in a state, in its unit; NaN: outside of its bounds
  template <typename Hold, typename Value>
  LikelihoodProfile Profile(std::string symbol, std::string unit, int record, Eigen::Index column, const Hold& hold,
                            const Value& value) const {
    ExtendedControl control = control_;
    hold(&control);
    const double std = std::sqrt(std::max(0.0, covariance_(column, column)));
    std::vector<Point> points;
    for (const double step : kSteps) {
      ExtendedState state = best_;
      if (std > 0) Move(covariance_.col(column) * (step / std), map_, &state);
      const double at = value(state);
      if (!(std > 0) || !std::isfinite(at)) continue;
      points.push_back({at, FitExtended(data_, sharing_, extension_, state, control).chi2});
    }
    return MakeProfile(std::move(symbol), std::move(unit), record, {value(best_), chi2_}, std::move(points),
                       variance_factor_);
  }

  LikelihoodProfile ProfileLevel(std::size_t level, int record) const {
    return Profile(
        LevelSymbol(CountSliders(best_.link.shape), level), level == 2 ? "-" : "1/m", record, map_.Columns(0)[level],
        [&](ExtendedControl* control) { control->held_level = static_cast<int>(level); },
        [&](const ExtendedState& state) { return std::exp(state.link.levels[0][level]); });
  }

  LikelihoodProfile ProfileShared(std::size_t index) const {
    const Extension::Unknown& unknown = extension_.shared()[index];
    const EffectParameter& parameter = unknown.Parameter();
    return Profile(
        std::string(unknown.effect->id) + "." + std::string(parameter.symbol), std::string(parameter.unit), -1,
        map_.first_shared() + static_cast<Eigen::Index>(index),
        [&](ExtendedControl* control) { control->held_shared = static_cast<int>(index); },
        [&](const ExtendedState& state) {
          const double x = state.shared[index];
          return unknown.low <= x && x <= unknown.high ? FromCoordinate(parameter, x) : std::nan("");
        });
  }

 private:
  std::span<const FitData> data_;
  Sharing sharing_;
  const Extension& extension_;
  ExtendedState best_;
  double chi2_, variance_factor_;
  UnknownMap map_;
  ExtendedControl control_;
  Eigen::MatrixXd covariance_;
};

/// The levels of a record by itself, the effects' shared parameters as they are.
std::vector<LikelihoodProfile> ProfileRecord(const FitData& data, const ExtendedResult& fit, std::size_t record) {
  const std::span<const FitData> one(&data, 1);
  ExtendedControl control;
  control.max_iterations = kIterations;
  control.function_tolerance = kTolerance;
  control.fix_shared = true;
  ExtendedOutcome best =
      FitExtended(one, Sharing::kLink, fit.extension, TakeRecord(fit.outcome.state, record), control);
  const Surroundings surroundings(one, Sharing::kLink, fit.extension, std::move(best.state), best.chi2,
                                  fit.variance_factor, /*fix_shared=*/true);
  std::vector<LikelihoodProfile> profiles;
  for (std::size_t level = 0; level < 3; ++level)
    profiles.push_back(surroundings.ProfileLevel(level, static_cast<int>(record)));
  return profiles;
}

}  // namespace

bool LikelihoodProfile::IsSound() const {
  return value.size() >= 3 && std::ranges::is_sorted(root, std::ranges::less_equal{}) && root.front() < 0 &&
         root.back() > 0;
}

double LikelihoodProfile::Root(double at) const {
  double sum = 0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    double term = root[i];
    for (std::size_t j = 0; j < value.size(); ++j)
      if (j != i) term *= (at - value[j]) / (value[i] - value[j]);
    sum += term;
  }
  return sum;
}

std::optional<double> LikelihoodProfile::Find(double goal) const {
  if (!IsSound()) return std::nullopt;
  const double width = value.back() - value.front();
  double low = value.front() - 0.5 * width, high = value.back() + 0.5 * width;
  if (!(Root(low) < goal && goal < Root(high))) return std::nullopt;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (Root(middle) < goal ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

std::vector<LikelihoodProfile> CalcProfiles(const Identification& id, const ExtendedResult& fit,
                                            std::span<const std::size_t> records, int threads) {
  const std::vector<FitData> data = CollectData(id);
  const std::size_t shared = fit.extension.shared().size();
  const bool one_link = fit.sharing == Sharing::kLink;
  std::optional<Surroundings> all;
  if (one_link || shared > 0)
    all.emplace(data, fit.sharing, fit.extension, fit.outcome.state, fit.outcome.chi2, fit.variance_factor, false);
  const std::size_t of_link = one_link ? 3 : records.size();
  std::vector<std::vector<LikelihoodProfile>> parts(of_link + shared);
  ParallelFor(parts.size(), threads, [&](std::size_t i) {
    if (i >= of_link) {
      parts[i].push_back(all->ProfileShared(i - of_link));
    } else if (one_link) {
      parts[i].push_back(all->ProfileLevel(i, -1));
    } else {
      parts[i] = ProfileRecord(data[records[i]], fit, records[i]);
    }
  });
  std::vector<LikelihoodProfile> profiles;
  for (std::vector<LikelihoodProfile>& part : parts) std::ranges::move(part, std::back_inserter(profiles));
  return profiles;
}

ExtendedResult DescribePlain(const Identification& id) {
  const Sharing sharing = id.shared ? Sharing::kLink : Sharing::kShape;
  const std::vector<FitData> data = CollectData(id);
  ExtendedOutcome outcome;
  outcome.state.link = CollectState(id, sharing);
  outcome.state.own.resize(data.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    double squares = 0;
    for (const double x : CalcExtendedResiduals(data[r], {}, outcome.state, r)) squares += x * x;
    outcome.chi2_of_record.push_back(squares / (data[r].sigma * data[r].sigma));
    outcome.chi2 += outcome.chi2_of_record.back();
  }
  return Describe(data, sharing, {}, outcome);
}

}  // namespace uiclink
