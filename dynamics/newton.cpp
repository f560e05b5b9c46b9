#include "dynamics/newton.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

namespace uiclink {
namespace {

constexpr double kChordGain = 5;        // chord steps go on while they divide the residual by this
constexpr double kLeastDamping = 1e-2;  // shorter steps than this part of Newton's are not tried
constexpr int kMostAdoptions = 3;
constexpr double kSmall = 1e-9;  // a residual that integration errors alone may explain

std::string Text(const char* format, double a, double b, int c = 0) {
  char text[256];
  std::snprintf(text, sizeof text, format, a, b, c);
  return text;
}

struct Trial {
  Place place;
  Passage passage;
  double closure = 0;  ///< norm of end - start
  double merit = 0;    ///< the same of the active components alone, with the conditions
};

class Corrector {
 public:
  Corrector(Flow& flow, const std::vector<Condition>& conditions, bool free_lambda, const CycleOptions& options)
      : flow_(flow), conditions_(conditions), free_lambda_(free_lambda), options_(options) {}

  Corrected Run(const Place& guess, const Passage* known) {
    Trial now = Try(guess, known == nullptr ? Flow::Derivatives::kAll : Flow::Derivatives::kNone);
    if (known != nullptr) Linearize(*known, now.place);
    for (int i = 0; i < options_.max_iterations; ++i) {
      if (Arrived(&now)) return {now.place, std::move(now.passage), now.closure, passages_};
      // What is left belongs to joints that slide at the start and stick at the end: Newton cannot move them.
      if (now.merit <= 0.1 * options_.tolerance) {
        Adopt(&now);
      } else if (!Advance(&now)) {
        if (now.passage.slaved_start == now.passage.slaved_end) Throw("the residual does not fall any further", now);
        Adopt(&now);
      }
    }
    if (Arrived(&now)) return {now.place, std::move(now.passage), now.closure, passages_};
    Throw("no convergence", now);
  }

 private:
  [[noreturn]] void Throw(const char* what, const Trial& now) const {
    const bool close = now.closure < std::max(kSmall, 1e3 * options_.tolerance);
    throw CycleError(std::string(what) +
                     Text(": residual %.3g, tolerance %.3g, after %d passages", std::max(now.closure, now.merit),
                          options_.tolerance, passages_) +
                     (close ? "; is the tolerance below the flow's own error?" : ""));
  }

  bool WithinTolerance(const Trial& trial) const {
    return trial.closure <= options_.tolerance && trial.merit <= options_.tolerance;
  }

  /// Whether `now` is a cycle, looked at with a passage with derivatives, whose integration error may be another one.
  bool Arrived(Trial* now) {
    if (!WithinTolerance(*now)) return false;
    if (now->passage.by_start.size() > 0) return true;
    *now = Try(now->place, Flow::Derivatives::kAll);
    if (WithinTolerance(*now)) return true;
    thorough_ = true;
    linearization_.reset();
    return false;
  }

  /// One period straight on: the end state has the memory that belongs to the motion.
  void Adopt(Trial* now) {
    if (++adoptions_ > kMostAdoptions) Throw("joints change between sliding and sticking at the start", *now);
    Place end = now->place;
    end.state = now->passage.end;
    *now = Try(end, Flow::Derivatives::kAll);
    linearization_.reset();
  }

  Trial Try(Place place, Flow::Derivatives wanted) {
    ++passages_;
    if (const auto forced = flow_.ForcedPeriod(place.lambda)) place.period = *forced;
    if (!(place.period > 0)) throw CycleError("the period is not positive");
    Trial trial;
    trial.passage = flow_.Pass(place.state, place.period, place.lambda, wanted);
    trial.place = std::move(place);
    trial.closure = Norm(flow_, trial.passage.end - trial.place.state);
    Eigen::VectorXd closure = Eigen::VectorXd::Zero(flow_.size());
    for (const int i : FreeComponents(trial.passage)) closure[i] = trial.passage.end[i] - trial.place.state[i];
    trial.merit = std::hypot(Norm(flow_, closure), ConditionResiduals(trial.place).norm());
    if (!std::isfinite(trial.closure) || !std::isfinite(trial.merit)) throw CycleError("the end state is not finite");
    return trial;
  }

  /// A trial that is allowed to fail.
  std::optional<Trial> TryOrNone(const Place& place) {
    try {
      return Try(place, thorough_ ? Flow::Derivatives::kAll : Flow::Derivatives::kNone);
    } catch (const std::exception&) {
      return std::nullopt;
    }
  }

  Eigen::VectorXd ConditionResiduals(const Place& place) const {
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(conditions_.size()));
    for (Eigen::Index i = 0; i < residuals.size(); ++i) {
      residuals[i] = conditions_[static_cast<std::size_t>(i)].Residual(place);
    }
    return residuals;
  }

  void Linearize(const Passage& passage, const Place& place) {
    linearization_.emplace(flow_, passage, place, conditions_, free_lambda_);
    fresh_ = false;
  }

  void LinearizeAt(Trial* now) {
    if (now->passage.by_start.size() == 0) *now = Try(now->place, Flow::Derivatives::kAll);
    Linearize(now->passage, now->place);
    fresh_ = true;
  }

  Place NewtonStep(const Trial& now) const {
    return linearization_->Solve(now.passage.end - now.place.state, -ConditionResiduals(now.place));
  }

  /// One step that brings the residual down; false when there is none.
  bool Advance(Trial* now) {
    if (!linearization_ || linearization_->active() != FreeComponents(now->passage)) LinearizeAt(now);
    if (StepDown(now)) return true;
    if (fresh_) return false;
    LinearizeAt(now);
    return StepDown(now);
  }

  /// Damped only with a derivative taken here: a chord step that fails says nothing about the length.
  bool StepDown(Trial* now) {
    const Place step = NewtonStep(*now);
    const double most = 0.5 * now->place.period;  // the period must stay positive, and the branch the same
    double damping = std::abs(step.period) > most ? most / std::abs(step.period) : 1;
    for (; damping >= kLeastDamping; damping *= 0.5) {
      Place place = now->place + damping * step;
      flow_.Follow(now->place.state, now->passage.slaved_start, &place.state);
      std::optional<Trial> trial = TryOrNone(place);
      if (trial && trial->merit < now->merit) {
        const bool slow = trial->merit * kChordGain > now->merit;
        *now = std::move(*trial);
        fresh_ = false;
        if (slow) linearization_.reset();
        return true;
      }
      if (!fresh_) return false;
    }
    return false;
  }

  Flow& flow_;
  const std::vector<Condition>& conditions_;
  bool free_lambda_;
  const CycleOptions& options_;
  std::optional<Linearization> linearization_;
  bool fresh_ = false;     ///< linearization_ was made where the search stands
  bool thorough_ = false;  ///< only passages with derivatives count
  int adoptions_ = 0;
  int passages_ = 0;
};

}  // namespace

Place operator+(const Place& a, const Place& b) {
  return {a.state + b.state, a.period + b.period, a.lambda + b.lambda};
}

Place operator-(const Place& a, const Place& b) {
  return {a.state - b.state, a.period - b.period, a.lambda - b.lambda};
}

Place operator*(double factor, const Place& a) { return {factor * a.state, factor * a.period, factor * a.lambda}; }

Place PlaceOf(const Cycle& cycle) { return {cycle.state, cycle.period, cycle.lambda}; }

double Norm(const Flow& flow, const Eigen::VectorXd& difference) {
  return difference.cwiseQuotient(flow.scales()).norm() / std::sqrt(static_cast<double>(flow.size()));
}

Condition StateCondition(const Flow& flow, const Eigen::VectorXd& direction, const Place& at, double offset) {
  const double length = Norm(flow, direction);
  if (!(length > 0)) throw CycleError("no direction for the phase: the state does not move, it is an equilibrium");
  Condition condition;
  condition.by_state = direction.cwiseQuotient(flow.scales().cwiseAbs2()) / (length * flow.size());
  condition.value = condition.by_state.dot(at.state) + offset;
  return condition;
}

Eigen::VectorXd ActivePart(const Passage& passage, const Eigen::VectorXd& values) {
  const std::vector<int> active = FreeComponents(passage);
  Eigen::VectorXd part = Eigen::VectorXd::Zero(values.size());
  part(active) = values(active);
  return part;
}

Linearization::Linearization(const Flow& flow, const Passage& passage, const Place& place,
                             const std::vector<Condition>& conditions, bool free_lambda)
    : active_(FreeComponents(passage)),
      scales_(flow.scales() * std::sqrt(static_cast<double>(flow.size()))),
      period_(place.period),
      free_period_(!flow.ForcedPeriod(place.lambda).has_value()),
      free_lambda_(free_lambda) {
  const auto states = static_cast<Eigen::Index>(active_.size());
  const auto rows = states + static_cast<Eigen::Index>(conditions.size());
  const Eigen::VectorXd scale = scales_(active_);
  Eigen::MatrixXd& m = matrix_;
  m.setZero(rows, states + (free_period_ ? 1 : 0) + (free_lambda_ ? 1 : 0));
  m.topLeftCorner(states, states) =
      Eigen::MatrixXd::Identity(states, states) -
      Eigen::MatrixXd(scale.cwiseInverse().asDiagonal() * passage.by_start(active_, active_) * scale.asDiagonal());
  for (std::size_t i = 0; i < conditions.size(); ++i) {
    const Eigen::VectorXd by_active = conditions[i].by_state(active_);
    m.row(states + static_cast<Eigen::Index>(i)).head(states) = by_active.cwiseProduct(scale);
  }
  Eigen::Index column = states;
  if (free_period_) m.col(column++).head(states) = -period_ * passage.rate(active_).cwiseQuotient(scale);
  if (free_lambda_) {
    m.col(column).head(states) = -passage.by_parameter(active_).cwiseQuotient(scale);
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      m(states + static_cast<Eigen::Index>(i), column) = conditions[i].by_lambda;
    }
  }
  column_lengths_ = m.colwise().norm().transpose();
  if (!m.allFinite() || column_lengths_.minCoeff() <= 0) throw CycleError("the derivatives are not finite, or vanish");
  m = m * column_lengths_.cwiseInverse().asDiagonal();
  factors_.compute(m);
}

Place Linearization::Solve(const Eigen::VectorXd& closure, const Eigen::VectorXd& conditions) const {
  const auto states = static_cast<Eigen::Index>(active_.size());
  Eigen::VectorXd right(states + conditions.size());
  right << closure(active_).cwiseQuotient(scales_(active_)), conditions;
  const Eigen::VectorXd scaled = factors_.solve(right).cwiseQuotient(column_lengths_);
  if (!scaled.allFinite()) throw CycleError("the equations of Newton's method are singular");
  Place step{Eigen::VectorXd::Zero(scales_.size()), 0, 0};
  step.state(active_) = scaled.head(states).cwiseProduct(scales_(active_));
  Eigen::Index column = states;
  if (free_period_) step.period = period_ * scaled[column++];
  if (free_lambda_) step.lambda = scaled[column];
  return step;
}

Corrected Correct(Flow& flow, const Place& guess, const std::vector<Condition>& conditions, bool free_lambda,
                  const CycleOptions& options, const Passage* known) {
  return Corrector(flow, conditions, free_lambda, options).Run(guess, known);
}

Cycle MakeCycle(const Flow& flow, const Corrected& corrected, const CycleOptions& options) {
  Cycle cycle;
  cycle.lambda = corrected.place.lambda;
  cycle.state = corrected.place.state;
  cycle.period = corrected.place.period;
  cycle.residual = corrected.residual;
  cycle.passage = corrected.passage;
  cycle.iterations = corrected.passages;
  CalcMultipliers(flow, options, &cycle);
  return cycle;
}

}  // namespace uiclink
