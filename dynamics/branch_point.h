#pragma once

#include "dynamics/continuation.h"
#include "dynamics/newton.h"

namespace uiclink {

/// A cycle of a branch with the direction of the branch there: one long in the norm of (state, parameter/scale).
struct BranchPoint {
  Cycle cycle;
  Place tangent;
  /// Determinant of the bordered equations: changes its sign where branches cross, not at folds.
  double determinant = 0;
};

/// Counts what another flow does.
class CountedFlow : public Flow {
 public:
  explicit CountedFlow(Flow& flow) : flow_(flow) {}
  int size() const override { return flow_.size(); }
  const Eigen::VectorXd& scales() const override { return flow_.scales(); }
  const std::vector<std::string>& watched() const override { return flow_.watched(); }
  std::optional<double> ForcedPeriod(double lambda) const override { return flow_.ForcedPeriod(lambda); }
  Passage Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) override {
    ++(wanted == Derivatives::kAll ? with_derivatives_ : plain_);
    return flow_.Pass(start, T, lambda, wanted);
  }
  void Follow(const Eigen::VectorXd& from, const std::vector<int>& slaved, Eigen::VectorXd* state) const override {
    flow_.Follow(from, slaved, state);
  }
  long passages() const { return plain_ + with_derivatives_; }
  long with_derivatives() const { return with_derivatives_; }

 private:
  Flow& flow_;
  long plain_ = 0, with_derivatives_ = 0;
};

/// Steps along a branch of cycles.
class BranchStepper {
 public:
  BranchStepper(Flow& flow, const ContinuationOptions& options);

  /// The point of a branch at a cycle; its tangent points to the side of `direction`.
  BranchPoint PointAt(Cycle cycle, const Place& direction) const;
  /// The first point: which way is said by `towards`, or by options.direction if that is null.
  BranchPoint FirstPoint(const Cycle& start, const Cycle* towards);
  /// The point at a distance along the tangent, corrected in the plane across it.
  BranchPoint PointAhead(const BranchPoint& from, double distance);
  /// The point that the tangent meets at a value of the parameter, corrected there.
  BranchPoint PointAtParameter(const BranchPoint& from, double lambda);
  /// The same cycle, begun a part of the period later. Only without excitation.
  BranchPoint Shifted(const BranchPoint& from, double part);

  /// A cycle moved along a way; what is slaved follows.
  Place Predict(const Cycle& from, const Place& way) const;

  bool forced() const { return flow_.ForcedPeriod(options_.from).has_value(); }

  /// sum of products in the norm of (state, parameter/scale), of the active components.
  double Product(const Passage& passage, const Place& a, const Place& b) const;
  double Length(const Passage& passage, const Place& a) const { return std::sqrt(Product(passage, a, a)); }

 private:
  std::vector<Condition> PhaseConditions(const Cycle& cycle) const;
  Condition Across(const Passage& passage, const Place& tangent, const Place& at) const;

  Flow& flow_;
  const ContinuationOptions& options_;
};

}  // namespace uiclink
