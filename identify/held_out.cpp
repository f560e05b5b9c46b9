#include "identify/held_out.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr std::size_t kMostFolds = 5;
constexpr double kFittedShare = 0.6;  // of a single record
// The minimum is near and its place matters only to a part of its error.
const ExtendedControl kQuick{.max_iterations = 15, .function_tolerance = 1e-6};

struct Part {
  std::vector<FitData> data;
  ExtendedState state;
};

/// The records of one side of a split, with their unknowns.
Part Select(std::span<const FitData> data, const ExtendedState& state, Sharing sharing, std::size_t folds,
            std::size_t fold, bool held_out) {
  Part part;
  part.state.link.shape = state.link.shape;
  part.state.shared = state.shared;
  if (sharing == Sharing::kLink) part.state.link.levels = state.link.levels;
  for (std::size_t r = 0; r < data.size(); ++r) {
    if ((r % folds == fold) != held_out) continue;
    part.data.push_back(data[r]);
    part.state.link.starts.push_back(state.link.starts[r]);
    if (sharing == Sharing::kShape) part.state.link.levels.push_back(state.link.levels[r]);
    if (!state.link.shapes.empty()) part.state.link.shapes.push_back(state.link.shapes[r]);
    part.state.own.push_back(state.own.empty() ? std::vector<double>{} : state.own[r]);
  }
  return part;
}

/// Sum of squares [m^2] on the records of a fold, predicted from the others.
double PredictFold(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                   const ExtendedState& state, std::size_t folds, std::size_t fold) {
  const Part others = Select(data, state, sharing, folds, fold, false);
  const ExtendedOutcome fitted = FitExtended(others.data, sharing, extension, others.state, kQuick);
  Part held = Select(data, state, sharing, folds, fold, true);
  held.state.shared = fitted.state.shared;
  if (sharing == Sharing::kLink) held.state.link.levels = fitted.state.link.levels;
  held.state.link.shape = fitted.state.link.shape;
  ExtendedControl control = kQuick;
  control.fix_shared = true;
  control.fix_link = sharing == Sharing::kLink;
  const ExtendedOutcome predicted = FitExtended(held.data, sharing, extension, held.state, control);
  double squares = 0;
  for (std::size_t r = 0; r < held.data.size(); ++r)
    squares += predicted.chi2_of_record[r] * held.data[r].sigma * held.data[r].sigma;
  return squares;
}

/// Sum of squares on the later part of a record that was fitted to its first part.
double PredictRest(const FitData& data, const Extension& extension, const ExtendedState& state, std::size_t fitted) {
  FitData first = data;
  first.size = fitted;
  const ExtendedOutcome outcome = FitExtended({&first, 1}, Sharing::kLink, extension, state, kQuick);
  const std::vector<double> residuals = CalcExtendedResiduals(data, extension, outcome.state, 0);
  double squares = 0;
  for (std::size_t i = fitted; i < residuals.size(); ++i) squares += residuals[i] * residuals[i];
  return squares;
}

}  // namespace

HeldOut PredictHeldOut(std::span<const FitData> data, Sharing sharing, const Extension& without,
                       const ExtendedState& before, const Extension& with, const ExtendedState& after, int threads) {
  HeldOut result;
  double squares_before = 0, squares_after = 0, samples = 0;
  if (data.size() == 1) {
    const auto fitted = static_cast<std::size_t>(kFittedShare * static_cast<double>(data[0].size));
    squares_before = PredictRest(data[0], without, before, fitted);
    squares_after = PredictRest(data[0], with, after, fitted);
    samples = static_cast<double>(data[0].size - fitted);
    result.folds = 1;
    result.by_time = true;
  } else {
    const std::size_t folds = std::min(data.size(), kMostFolds);
    std::mutex adding;
    ParallelFor(folds, threads, [&](std::size_t fold) {
      const double squares_without = PredictFold(data, sharing, without, before, folds, fold);
      const double squares_with = PredictFold(data, sharing, with, after, folds, fold);
      const std::lock_guard lock(adding);
      squares_before += squares_without;
      squares_after += squares_with;
    });
    for (const FitData& d : data) samples += static_cast<double>(d.size);
    result.folds = static_cast<int>(folds);
  }
  result.rms_before = std::sqrt(squares_before / samples);
  result.rms_after = std::sqrt(squares_after / samples);
  result.known = std::isfinite(result.rms_before) && std::isfinite(result.rms_after) && result.rms_before > 0;
  return result;
}

}  // namespace uiclink
