#include "dynamics/continuation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "dynamics/branch_events.h"
#include "dynamics/branch_point.h"
#include "dynamics/corner.h"
#include "dynamics/newton.h"

namespace uiclink {
namespace {

constexpr double kGrow = 1.5, kShrink = 0.5;
constexpr int kEasy = 8, kHard = 14;     // passages of a point below which the step grows, above which it shrinks
constexpr double kStraight = 0.95;       // cosine between tangents above which the step may grow
constexpr double kCorner = 0.5;          // ... below which a step is taken again, shorter
constexpr double kFarOff = 0.5;          // a correction longer than this part of the step has met another branch
constexpr double kFarOffAtCorner = 1.0;  // ... than this part of a short step, which may go round a corner
constexpr double kBent = 0.05;           // ... one shorter than this does not tell to which side the branch bends
constexpr double kShift = 0.381966;      // of the period: where a cycle is begun afresh when its start sits on an event
constexpr double kSameCycle = 2e-3;      // relative difference of period and extents that closes a branch: memory that
                                         // the way round has left differently shifts means by more, these by less
constexpr double kMaybeSameCycle = 0.1;  // ... at which it is worth a look

std::string AtParameter(const std::string& what, double lambda) {
  char text[64];
  std::snprintf(text, sizeof text, " at parameter %.6g", lambda);
  return what + text;
}

/// Largest relative difference of the periods and of the extents of what is watched.
double CalcDifference(const Cycle& a, const Cycle& b) {
  const Eigen::VectorXd extent = a.passage.greatest - a.passage.least;
  const double difference = std::abs(a.period - b.period) / a.period;
  if (extent.size() == 0) return std::max(difference, (a.state - b.state).norm() / a.state.norm());
  const double unit = std::max(extent.maxCoeff(), 1e-300);
  const Eigen::VectorXd other = b.passage.greatest - b.passage.least;
  return std::max(difference, (extent - other).cwiseAbs().maxCoeff() / unit);
}

class BranchFollower {
 public:
  BranchFollower(Flow& flow, const ContinuationOptions& options)
      : counted_(flow), options_(options), stepper_(counted_, options_), step_(options.first_step) {}

  Branch Run(const Cycle& start, const Cycle* towards) {
    first_ = here_ = stepper_.FirstPoint(start, towards);
    branch_.points.push_back(here_.cycle);
    while (!ended_) {
      if (branch_.points.size() >= options_.max_points) {
        End(BranchEnd::kPoints);
      } else if (DistanceToBound() <= 0) {
        End(BranchEnd::kRange);
      } else {
        Step();
      }
    }
    branch_.passages = counted_.passages();
    branch_.passages_with_derivatives = counted_.with_derivatives();
    return std::move(branch_);
  }

 private:
  void End(BranchEnd end, std::string reason = "") {
    ended_ = true;
    branch_.end = end;
    branch_.reason = std::move(reason);
  }

  /// The bound of the parameter that lies ahead.
  double Bound() const { return here_.tangent.lambda > 0 ? options_.to : options_.from; }

  /// Length of the tangent up to there.
  double DistanceToBound() const {
    const double slope = here_.tangent.lambda;
    return slope == 0 ? std::numeric_limits<double>::infinity() : (Bound() - here_.cycle.lambda) / slope;
  }

  void Step() {
    const double ahead = DistanceToBound();
    try {
      if (ahead <= step_) {
        Take(stepper_.PointAtParameter(here_, Bound()), ahead, true);
        return;
      }
      BranchPoint next = stepper_.PointAhead(here_, step_);
      const double lambda = next.cycle.lambda;
      const bool outside = lambda < options_.from || lambda > options_.to;
      if (outside) {
        Shorten("the branch leaves the range of the parameter");
      } else {
        Take(std::move(next), step_, false);
      }
    } catch (const std::exception& error) {
      Shorten(error.what());
    }
  }

  /// The next point, unless it is another branch's.
  void Take(BranchPoint next, double distance, bool last) {
    const double turn = RateCosine(next);
    if (turn < -kCorner) return End(BranchEnd::kEquilibrium);
    const double cosine = stepper_.Product(next.cycle.passage, here_.tangent, next.tangent);
    const Place correction = PlaceOf(next.cycle) - (PlaceOf(here_.cycle) + distance * here_.tangent);
    const bool far_off = stepper_.Length(next.cycle.passage, correction) > FarOff(distance) * distance;
    if (turn < 0 || cosine < kCorner || far_off || MayBeOtherSheet(next, distance, correction)) {
      return Shorten("the branch has a corner");
    }
    if (options_.least_extent > 0 && Extent(next.cycle) < options_.least_extent) return End(BranchEnd::kEquilibrium);
    const std::size_t index = branch_.points.size() - 1;
    for (BranchEvent& event : FindEvents(&stepper_, here_, next, distance, index, options_)) {
      branch_.events.push_back(std::move(event));
    }
    const BranchPoint before = std::exchange(here_, std::move(next));
    shifts_ = 0;
    if (Closes(before)) return;
    branch_.points.push_back(here_.cycle);
    AdaptStep(cosine);
    if (last) End(BranchEnd::kRange);
    if (options_.on_point && !options_.on_point(here_.cycle)) End(BranchEnd::kStopped);
  }

  double Extent(const Cycle& cycle) const { return (cycle.passage.greatest - cycle.passage.least).norm(); }

  double FarOff(double distance) const { return distance > options_.first_step ? kFarOff : kFarOffAtCorner; }

  /// May the step have met another sheet behind a corner? There the orientation is the other one although the branch
  /// has not gone straight on, as it does where branches cross. With a long step either is enough, or a tangent that
  /// turns away from the side to which the point was corrected: a short one decides.
  bool MayBeOtherSheet(const BranchPoint& next, double distance, const Place& correction) const {
    const Passage& passage = next.cycle.passage;
    const bool is_long = distance > options_.first_step;
    const Place bend = next.tangent - stepper_.Product(passage, here_.tangent, next.tangent) * here_.tangent;
    const bool is_bent = stepper_.Length(passage, bend) > kBent;
    if (here_.determinant * next.determinant < 0) return is_long || is_bent;
    return is_long && is_bent && stepper_.Length(passage, correction) > kBent * distance &&
           stepper_.Product(passage, correction, bend) < 0;
  }

  /// Cosine between the ways in which the cycles start. On its way through an equilibrium a branch comes back as the
  /// same cycles, begun half a period later: the state moves the other way.
  double RateCosine(const BranchPoint& next) const {
    if (stepper_.forced()) return 1;
    const Passage& passage = next.cycle.passage;
    const Place before{here_.cycle.passage.rate, 0, 0}, after{passage.rate, 0, 0};
    return stepper_.Product(passage, before, after) /
           (stepper_.Length(passage, before) * stepper_.Length(passage, after));
  }

  void AdaptStep(double cosine) {
    if (here_.cycle.iterations <= kEasy && cosine > kStraight) {
      step_ = std::min(step_ * kGrow, options_.max_step);
    } else if (here_.cycle.iterations > kHard) {
      step_ = std::max(step_ * kShrink, options_.min_step);
    }
  }

  void Shorten(const std::string& why) {
    step_ *= kShrink;
    if (step_ >= options_.min_step || Turn()) return;
    if (!stepper_.forced() && shifts_++ == 0 && Shift()) return;
    End(BranchEnd::kLost, AtParameter(why, here_.cycle.lambda));
  }

  /// Round a corner.
  bool Turn() {
    std::optional<Corner> corner = TurnCorner(counted_, &stepper_, here_, options_.min_step, options_.first_step);
    if (!corner || corner->beyond.cycle.lambda < options_.from || corner->beyond.cycle.lambda > options_.to)
      return false;
    AddCorner(*corner);
    step_ = std::max(corner->distance, options_.min_step);
    here_ = std::move(corner->beyond);
    shifts_ = 0;
    branch_.points.push_back(here_.cycle);
    if (options_.on_point && !options_.on_point(here_.cycle)) End(BranchEnd::kStopped);
    return true;
  }

  void AddCorner(const Corner& corner) {
    const std::size_t index = branch_.points.size() - 1;
    const Cycle& beyond = corner.beyond.cycle;
    const bool turns_round = here_.tangent.lambda * corner.beyond.tangent.lambda < 0;
    if (turns_round)
      branch_.events.push_back({BranchEventKind::kFold, corner.lambda, corner.period, index, "", true, here_.cycle});
    if (here_.cycle.passage.character == beyond.passage.character) return;
    branch_.events.push_back({BranchEventKind::kCharacter, corner.lambda, corner.period, index,
                              here_.cycle.passage.character + " -> " + beyond.passage.character, false, beyond});
  }

  /// A start that sits on an event of the flow is begun elsewhere.
  bool Shift() {
    try {
      here_ = stepper_.Shifted(here_, kShift);
      step_ = std::min(options_.first_step, options_.max_step);
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }

  /// Back where it began: the first parameter is passed in the first direction, and the cycle there is the first.
  bool Closes(const BranchPoint& before) {
    const double lambda = first_.cycle.lambda;
    const double a = before.cycle.lambda - lambda, b = here_.cycle.lambda - lambda;
    if (branch_.points.size() < 3 || a * b > 0 || (b - a) * first_.tangent.lambda <= 0) return false;
    if (std::min(CalcDifference(first_.cycle, before.cycle), CalcDifference(first_.cycle, here_.cycle)) >
        kMaybeSameCycle) {
      return false;
    }
    try {
      const BranchPoint& nearest = std::abs(a) < std::abs(b) ? before : here_;
      BranchPoint back = stepper_.PointAtParameter(nearest, lambda);
      if (CalcDifference(first_.cycle, back.cycle) > kSameCycle) return false;
      branch_.points.push_back(std::move(back.cycle));
      End(BranchEnd::kClosed);
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }

  CountedFlow counted_;
  const ContinuationOptions& options_;
  BranchStepper stepper_;
  BranchPoint first_, here_;
  Branch branch_;
  double step_;
  int shifts_ = 0;  ///< of the start since the last point
  bool ended_ = false;
};

/// The branch walked from its other end.
void Reverse(Branch* branch) {
  std::reverse(branch->points.begin(), branch->points.end());
  std::reverse(branch->events.begin(), branch->events.end());
  for (BranchEvent& event : branch->events) {
    event.point = branch->points.size() - 2 - event.point;
    const std::string arrow = " -> ";
    const auto at = event.text.find(arrow);
    if (at != std::string::npos) event.text = event.text.substr(at + arrow.size()) + arrow + event.text.substr(0, at);
  }
}

}  // namespace

Branch FollowBranch(Flow& flow, const Cycle& start, const ContinuationOptions& options, const Cycle* towards) {
  return BranchFollower(flow, options).Run(start, towards);
}

Branch FollowBothWays(Flow& flow, const Cycle& start, const ContinuationOptions& options) {
  ContinuationOptions down = options;
  down.direction = -1;
  Branch branch = FollowBranch(flow, start, down);
  if (branch.end == BranchEnd::kClosed) return branch;
  ContinuationOptions up = options;
  up.direction = 1;
  Branch other = FollowBranch(flow, start, up);
  Reverse(&branch);
  branch.begin = branch.end;
  branch.begin_reason = branch.reason;
  const std::size_t offset = branch.points.size() - 1;
  branch.points.insert(branch.points.end(), other.points.begin() + 1, other.points.end());
  for (BranchEvent& event : other.events) {
    event.point += offset;
    branch.events.push_back(std::move(event));
  }
  branch.end = other.end;
  branch.reason = other.reason;
  branch.passages += other.passages;
  branch.passages_with_derivatives += other.passages_with_derivatives;
  return branch;
}

Cycle FindBornCycle(Flow& flow, double lambda0, double omega, const Eigen::VectorXd& equilibrium,
                    const Eigen::VectorXcd& shape, double size, const CycleOptions& options) {
  const Eigen::VectorXd real = shape.real(), imaginary = shape.imag();
  const Place centre{equilibrium, 2 * std::numbers::pi / omega, lambda0};
  const Place guess = centre + Place{size * real, 0, 0};
  const std::vector<Condition> conditions{StateCondition(flow, real, centre, size * Norm(flow, real)),
                                          StateCondition(flow, imaginary, centre)};
  return MakeCycle(flow, Correct(flow, guess, conditions, true, options), options);
}

}  // namespace uiclink
