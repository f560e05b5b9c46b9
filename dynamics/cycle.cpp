#include "dynamics/cycle.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "dynamics/newton.h"

namespace uiclink {
namespace {

/// A cycle whose radius at its start is not this much above the tolerance cannot be told from an equilibrium.
constexpr double kLeastRadius = 10;

void CheckNotEquilibrium(const Flow& flow, const Corrected& found, const CycleOptions& options) {
  const double radius = Norm(flow, found.passage.rate) * found.place.period / (2 * std::numbers::pi);
  if (radius < kLeastRadius * options.tolerance) throw CycleError("the iteration ended in an equilibrium");
}

/// Eigenvalues of the monodromy matrix of the active components, by falling magnitude.
std::vector<std::complex<double>> ActiveMultipliers(const Flow& flow, const Passage& passage) {
  const std::vector<int> active = FreeComponents(passage);
  if (active.empty()) return {};
  const Eigen::VectorXd scale = flow.scales()(active);
  const Eigen::MatrixXd monodromy =
      scale.cwiseInverse().asDiagonal() * passage.by_start(active, active) * scale.asDiagonal();
  if (!monodromy.allFinite()) throw CycleError("the monodromy matrix is not finite");
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(monodromy, false);
  if (solver.info() != Eigen::Success) throw CycleError("the eigenvalues of the monodromy matrix did not converge");
  std::vector<std::complex<double>> values(solver.eigenvalues().begin(), solver.eigenvalues().end());
  std::stable_sort(values.begin(), values.end(),
                   [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  return values;
}

}  // namespace

Cycle FindCycle(Flow& flow, double lambda, const Eigen::VectorXd& guess, double period, const CycleOptions& options) {
  const std::optional<double> forced = flow.ForcedPeriod(lambda);
  Place place{guess, forced.value_or(period), lambda};
  std::optional<Passage> before;
  for (int i = 0; i < options.settle || (i == 0 && !forced); ++i) {
    before = flow.Pass(place.state, place.period, lambda, Flow::Derivatives::kNone);
    if (i < options.settle) place.state = before->end;
  }
  std::vector<Condition> conditions;
  if (!forced) conditions.push_back(StateCondition(flow, ActivePart(*before, before->rate), place));
  Corrected found = Correct(flow, place, conditions, false, options);
  if (!forced) CheckNotEquilibrium(flow, found, options);
  found.passages += forced ? options.settle : std::max(options.settle, 1);
  return MakeCycle(flow, found, options);
}

void CalcMultipliers(const Flow& flow, const CycleOptions& options, Cycle* cycle) {
  std::vector<std::complex<double>>& values = cycle->multipliers;
  values = ActiveMultipliers(flow, cycle->passage);
  cycle->multipliers_one = static_cast<int>(cycle->passage.held.size());
  cycle->multipliers_zero = static_cast<int>(cycle->passage.slaved_start.size());
  cycle->trivial_error = 0;
  auto first = values.begin();
  if (!flow.ForcedPeriod(cycle->lambda) && !values.empty()) {
    const auto trivial = std::min_element(values.begin(), values.end(), [](const auto& a, const auto& b) {
      return std::abs(a - 1.0) < std::abs(b - 1.0);
    });
    cycle->trivial_error = std::abs(*trivial - 1.0);
    std::rotate(values.begin(), trivial, trivial + 1);
    ++first;
  }
  const double most = 1 + std::max(options.unstable_margin, 2 * cycle->trivial_error);
  cycle->unstable = static_cast<int>(
      std::count_if(first, values.end(), [most](const auto& value) { return std::abs(value) > most; }));
}

}  // namespace uiclink
