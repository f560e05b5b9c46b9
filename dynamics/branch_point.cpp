#include "dynamics/branch_point.h"

#include <cmath>
#include <utility>

namespace uiclink {
BranchStepper::BranchStepper(Flow& flow, const ContinuationOptions& options) : flow_(flow), options_(options) {}

double BranchStepper::Product(const Passage& passage, const Place& a, const Place& b) const {
  double sum = 0;
  for (const int i : FreeComponents(passage)) {
    sum += a.state[i] * b.state[i] / (flow_.scales()[i] * flow_.scales()[i]);
  }
  return sum / flow_.size() + a.lambda * b.lambda / (options_.parameter_scale * options_.parameter_scale);
}

std::vector<Condition> BranchStepper::PhaseConditions(const Cycle& cycle) const {
  if (flow_.ForcedPeriod(cycle.lambda)) return {};
  return {StateCondition(flow_, ActivePart(cycle.passage, cycle.passage.rate), PlaceOf(cycle))};
}

Condition BranchStepper::Across(const Passage& passage, const Place& tangent, const Place& at) const {
  Condition condition;
  condition.by_state = ActivePart(passage, tangent.state).cwiseQuotient(flow_.scales().cwiseAbs2()) / flow_.size();
  condition.by_lambda = tangent.lambda / (options_.parameter_scale * options_.parameter_scale);
  condition.value = condition.by_state.dot(at.state) + condition.by_lambda * at.lambda;
  return condition;
}

BranchPoint BranchStepper::PointAt(Cycle cycle, const Place& direction) const {
  const Passage& passage = cycle.passage;
  std::vector<Condition> conditions = PhaseConditions(cycle);
  conditions.push_back(Across(passage, direction, PlaceOf(cycle)));
  const Linearization linearization(flow_, passage, PlaceOf(cycle), conditions, true);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(conditions.size()));
  right[right.size() - 1] = 1;
  Place tangent = linearization.Solve(Eigen::VectorXd::Zero(flow_.size()), right);
  const double length = Length(passage, tangent);
  if (!(length > 0)) throw CycleError("the branch has no direction");
  tangent = (1 / length) * tangent;
  // Slaved components have no freedom at the start, but a rate along the branch: that of their end.
  const std::vector<int>& slaved = passage.slaved_start;
  const Eigen::VectorXd end_by_branch =
      passage.by_start * tangent.state + passage.rate * tangent.period + passage.by_parameter * tangent.lambda;
  tangent.state(slaved) = end_by_branch(slaved);
  return {std::move(cycle), std::move(tangent), linearization.Determinant()};
}

BranchPoint BranchStepper::FirstPoint(const Cycle& start, const Cycle* towards) {
  Cycle cycle = start;
  if (cycle.passage.by_start.size() == 0) {
    cycle.passage = flow_.Pass(cycle.state, cycle.period, cycle.lambda, Flow::Derivatives::kAll);
    CalcMultipliers(flow_, options_.cycle, &cycle);
  }
  if (towards != nullptr) {
    return PointAt(std::move(cycle), {towards->state - start.state, 0, towards->lambda - start.lambda});
  }
  return PointAt(std::move(cycle), {Eigen::VectorXd::Zero(flow_.size()), 0, options_.direction < 0 ? -1.0 : 1.0});
}

Place BranchStepper::Predict(const Cycle& from, const Place& way) const {
  Place place = PlaceOf(from) + way;
  flow_.Follow(from.state, from.passage.slaved_start, &place.state);
  return place;
}

BranchPoint BranchStepper::PointAhead(const BranchPoint& from, double distance) {
  const Place guess = Predict(from.cycle, distance * from.tangent);
  std::vector<Condition> conditions = PhaseConditions(from.cycle);
  conditions.push_back(Across(from.cycle.passage, from.tangent, guess));
  const Corrected found = Correct(flow_, guess, conditions, true, options_.cycle, &from.cycle.passage);
  return PointAt(MakeCycle(flow_, found, options_.cycle), from.tangent);
}

BranchPoint BranchStepper::PointAtParameter(const BranchPoint& from, double lambda) {
  Place guess = Predict(from.cycle, (lambda - from.cycle.lambda) / from.tangent.lambda * from.tangent);
  guess.lambda = lambda;
  const Corrected found =
      Correct(flow_, guess, PhaseConditions(from.cycle), false, options_.cycle, &from.cycle.passage);
  return PointAt(MakeCycle(flow_, found, options_.cycle), from.tangent);
}

BranchPoint BranchStepper::Shifted(const BranchPoint& from, double part) {
  const Cycle& cycle = from.cycle;
  const Passage passage = flow_.Pass(cycle.state, part * cycle.period, cycle.lambda, Flow::Derivatives::kAll);
  Place tangent = from.tangent;
  tangent.state = passage.by_start * from.tangent.state + passage.rate * (part * from.tangent.period) +
                  passage.by_parameter * from.tangent.lambda;
  const Place guess{passage.end, cycle.period, cycle.lambda};
  const Corrected found =
      Correct(flow_, guess, {StateCondition(flow_, ActivePart(passage, passage.rate), guess)}, false, options_.cycle);
  return PointAt(MakeCycle(flow_, found, options_.cycle), tangent);
}

}  // namespace uiclink
