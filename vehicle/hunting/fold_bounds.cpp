#include "vehicle/hunting/fold_bounds.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "dynamics/continuation.h"

namespace uiclink {
namespace {

using Eigen::Index;

/// The left null vector of the linearised equations of a fold, over the free components of end - start.
Eigen::VectorXd FindLeftNull(const Cycle& fold, const std::vector<Index>& free, const Eigen::VectorXd& scales) {
  const auto size = static_cast<Index>(free.size());
  const Eigen::VectorXd scale = scales(free);
  const Eigen::VectorXd rate = fold.passage.rate(free).cwiseQuotient(scale);
  Eigen::MatrixXd equations = Eigen::MatrixXd::Zero(size + 1, size + 1);
  equations.topLeftCorner(size, size) =
      scale.cwiseInverse().asDiagonal() * fold.passage.by_start(free, free) * scale.asDiagonal();
  equations.topLeftCorner(size, size).diagonal().array() -= 1;
  equations.topRightCorner(size, 1) = rate;
  equations.bottomLeftCorner(1, size) = rate.transpose();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(equations, Eigen::ComputeFullU);
  return svd.matrixU().col(size).head(size).cwiseQuotient(scale);
}

/// A little beyond the fold its cycle is stable on one side; followed from there it turns round within so many points.
constexpr std::size_t kPointsToFold = 60;

constexpr double kSettle = 30;  // [s]

/// The cycle that draws begin from is at least so far above the fold, and so many standard deviations of the fold's
/// speed: not so near that a draw's fold may lie beyond it.
constexpr double kLeastWay = 0.05;  // [m/s]
constexpr double kStdsBeyond = 4;

/// The nearest stable cycle more than `away` above the fold.
const Cycle& FindBeyond(std::span<const Cycle> branch, double fold, double away) {
  const Cycle* beyond = nullptr;
  for (const Cycle& cycle : branch)
    if (cycle.stable() && cycle.lambda > fold + away && (!beyond || cycle.lambda < beyond->lambda)) beyond = &cycle;
  if (beyond == nullptr)
    throw CycleError(fmt::format("the branch has no stable cycle from {:.3f} m/s on", fold + away));
  return *beyond;
}

/// At a corner the equations have no null vector: the corner of a wagon that is a little different is found.
Eigen::VectorXd CalcCornerGradient(const SetScatter& scatter, const Wagon& wagon, double fold,
                                   std::span<const Cycle> branch, const WagonFlowOptions& options) {
  const Cycle& beyond = FindBeyond(branch, fold, kLeastWay);
  return DifferentiateByParameters(scatter, [&](const Eigen::VectorXd& values) {
    return FindFoldNear(WithLinks(wagon, scatter.LinksAt(values)), beyond, fold, JointMemory::kCarried, options);
  });
}

}  // namespace

Eigen::VectorXd CalcFoldGradient(const SetScatter& scatter, const Wagon& wagon, const Cycle& fold,
                                 const WagonFlowOptions& options) {
  const double V = fold.lambda;
  const WagonFlow nominal(FamilyBySpeed(wagon), V, options);
  const std::vector<int> components = FreeComponents(fold.passage);
  const std::vector<Index> free(components.begin(), components.end());
  const Eigen::VectorXd w = FindLeftNull(fold, free, nominal.scales());
  const double by_speed = w.dot(fold.passage.by_parameter(free));
  if (!(std::abs(by_speed) > 0)) throw std::runtime_error("the speed does not act on the fold");
  const Eigen::VectorXd by_parameters = DifferentiateByParameters(scatter, [&](const Eigen::VectorXd& values) {
    WagonFlow flow(FamilyBySpeed(WithLinks(wagon, scatter.LinksAt(values))), V, options);
    return w.dot(flow.Pass(fold.state, fold.period, V, Flow::Derivatives::kNone).end(free));
  });
  return -by_parameters / by_speed;
}

double FindFoldNear(const Wagon& wagon, const Cycle& beyond, double fold, JointMemory memory,
                    const WagonFlowOptions& options) {
  WagonFlow flow(FamilyBySpeed(wagon), beyond.lambda, options);
  ContinuationOptions continuation;
  const double way = beyond.lambda - fold;
  continuation.direction = way > 0 ? -1 : 1;
  continuation.from = std::max(0.1 * fold, fold - 20 * std::abs(way));
  continuation.to = fold + 20 * std::abs(way);
  continuation.cycle.tolerance = 5e-6;  // DiagramOptions::tolerance
  continuation.max_points = kPointsToFold;
  continuation.min_step = 1e-4;  // as there
  continuation.first_step = 0.25 * std::abs(way);
  continuation.max_step = 0.5;
  double before = beyond.lambda;
  continuation.on_point = [&](const Cycle& cycle) {  // on until it has turned round
    const bool goes_on = (cycle.lambda - before) * way < 0;
    before = cycle.lambda;
    return goes_on;
  };
  std::optional<WagonFlow::Guess> guess = WagonFlow::Guess{beyond.state, beyond.period};
  if (memory == JointMemory::kSettled) {
    guess = flow.GuessCycle(flow.ToWagonState(beyond.state, beyond.lambda), beyond.lambda, kSettle);
  }
  if (!guess) throw CycleError(fmt::format("hunting dies at {:.3f} m/s already", beyond.lambda));
  const Cycle start = FindCycle(flow, beyond.lambda, guess->state, guess->period, continuation.cycle);
  const Branch branch = FollowBranch(flow, start, continuation);
  for (const BranchEvent& event : branch.events)
    if (event.kind == BranchEventKind::kFold) return event.lambda;
  throw CycleError(fmt::format("no fold was met up to {:.3f} m/s{}{}", branch.points.back().lambda,
                               branch.reason.empty() ? "" : ": ", branch.reason));
}

FoldBounds CalcFoldBounds(const SetScatter& scatter, const Wagon& wagon, const BranchEvent& fold,
                          std::span<const Cycle> branch, const PropagateOptions& options,
                          const WagonFlowOptions& flow) {
  const auto begin = std::chrono::steady_clock::now();
  FoldBounds bounds;
  if (!scatter.empty()) {
    bounds.gradient = fold.at_corner ? CalcCornerGradient(scatter, wagon, fold.lambda, branch, flow)
                                     : CalcFoldGradient(scatter, wagon, fold.cycle, flow);
  }
  if (scatter.size() > 0) {
    const double std = std::sqrt(bounds.gradient.dot(scatter.covariance() * bounds.gradient));
    const Cycle& beyond = FindBeyond(branch, fold.lambda, std::max(kLeastWay, kStdsBeyond * std));
    bounds.speed = PropagateScalar(
        "nonlinear critical speed", "m/s",
        [&](const Wagon& drawn) { return FindFoldNear(drawn, beyond, fold.lambda, JointMemory::kSettled, flow); },
        scatter, wagon, options);
  }
  bounds.speed.name = "nonlinear critical speed";
  bounds.speed.unit = "m/s";
  bounds.speed.nominal = fold.lambda;
  if (!scatter.empty()) AddShares(scatter, bounds.gradient, &bounds.speed);
  bounds.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return bounds;
}

}  // namespace uiclink
