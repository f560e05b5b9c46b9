#include "vehicle/hunting/diagram.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "model/parallel.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/branch_start.h"

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;

/// Motions by which a traced one is found on a branch: lateral of both wheelsets and the body.
constexpr std::array<TrackedMotion, 3> kCompared{TrackedMotion::kFrontLateral, TrackedMotion::kRearLateral,
                                                 TrackedMotion::kBodyLateral};
struct TracedMotion {
  TraceRow row;
  WagonState state;
};

class DiagramBuilder {
 public:
  DiagramBuilder(const Wagon& wagon, const DiagramOptions& options) : wagon_(wagon), options_(options) {}

  BifurcationDiagram Run() {
    const Clock::time_point begin = Clock::now();
    FindHopfs();
    // The branches that are born and the trace know nothing of each other.
    ParallelFor(2, options_.threads, [&](std::size_t i) { i == 0 ? FollowBorn() : TraceBothWays(); });
    if (!failure_.empty()) diagram_.notices.push_back(failure_);
    FollowTraced();
    CloseWindows();
    FindNonlinearCritical();
    diagram_.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
    return std::move(diagram_);
  }

 private:
  bool Say(const std::string& what) {
    const std::scoped_lock lock(mutex_);
    if (options_.on_progress && !options_.on_progress(what)) stopped_ = true;
    return !stopped_;
  }

  void FindHopfs() {
    StabilityOptions search;
    search.from = options_.from;
    search.to = options_.to;
    diagram_.linear = FindCrossings(wagon_, search);
    HopfOptions hopf = options_.hopf;
    hopf.flow = options_.flow;
    for (const Crossing& crossing : diagram_.linear.crossings) {
      Say(fmt::format("cycles born at {:.3f} m/s", crossing.V));
      diagram_.hopfs.push_back(ExamineHopf(wagon_, crossing, hopf));
    }
  }

  ContinuationOptions MakeContinuation(const std::string& origin) {
    ContinuationOptions continuation = MakeContinuationOptions(options_);
    continuation.on_point = [this, origin, points = 0](const Cycle& cycle) mutable {
      return Say(fmt::format("branch {}: {} points, {:.3f} m/s", origin, ++points, cycle.lambda));
    };
    return continuation;
  }

  void FollowBorn() {
    for (const HopfPoint& hopf : diagram_.hopfs) {
      if (stopped_) continue;
      const std::string origin = fmt::format("born at {:.3f} m/s", hopf.crossing.V);
      try {
        auto branch = FollowBornBranch(FamilyBySpeed(wagon_), hopf, options_, MakeContinuation(origin));
        if (branch) diagram_.branches.push_back({origin, std::move(*branch)});
      } catch (const std::exception& error) {
        diagram_.notices.push_back(fmt::format("branch {}: {}", origin, error.what()));
      }
    }
  }

  /// Hunting at the highest speed, followed down and up again.
  void TraceBothWays() {
    try {
      const Clock::time_point begin = Clock::now();
      SimulationOptions settle;
      settle.duration = options_.start_settle;
      settle.end_at_wheel_lift = false;
      const WagonState start = Perturb(wagon_, FindEquilibrium(wagon_, options_.to),
                                       {.front_y = options_.start_y, .rear_y = options_.start_y});
      Say(fmt::format("hunting at {:g} m/s", options_.to));
      const SimulationResult hunting = Simulate(wagon_, options_.to, start, settle);
      TraceOptions trace;
      trace.from = options_.to;
      trace.legs = {{options_.from, options_.trace_step}, {options_.to, options_.trace_step}};
      trace.hold = options_.trace_hold;
      trace.window = std::min(5.0, options_.trace_hold);
      const Trace traced = TraceBifurcation(
          wagon_, {0, hunting.state}, trace, [this](const TraceRow& row, const TracePoint& at, std::size_t) {
            if (row.half_width[static_cast<std::size_t>(TrackedMotion::kFrontLateral)] > kLeastHunting)
              motions_.push_back({row, at.state});
            return Say(fmt::format("trace: {:.2f} m/s", row.V));
          });
      diagram_.trace = traced.rows;
      diagram_.traced_s = options_.start_settle + static_cast<double>(traced.rows.size()) * options_.trace_hold;
      if (!traced.complete) failure_ = "trace: " + traced.end_reason;
      diagram_.trace_wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
    } catch (const std::exception& error) {
      failure_ = fmt::format("trace: {}", error.what());
    }
  }

  bool IsKnown(double V, const std::array<double, kMotionCount>& half_width) const {
    return std::ranges::any_of(diagram_.branches, [&](const HuntingBranch& hunting) {
      return LiesOn(hunting.branch, V, half_width, options_.same_share, options_.same_motion);
    });
  }

  /// What the trace has met and no branch has: from the middle of each stretch, where it is farthest from what ends it.
  void FollowTraced() {
    std::vector<TracedMotion> open;
    for (TracedMotion& motion : motions_) open.push_back(std::move(motion));
    std::vector<std::pair<TracedMotion, std::string>> given_up;
    while (!open.empty() && !stopped_) {
      std::erase_if(open, [&](const TracedMotion& motion) { return IsKnown(motion.row.V, motion.row.half_width); });
      if (open.empty()) break;
      std::size_t end = 1;
      while (end < open.size() && open[end].row.leg == open[0].row.leg &&
             std::abs(open[end].row.V - open[end - 1].row.V) < 1.5 * options_.trace_step)
        ++end;
      const std::size_t middle = end / 2;
      const std::string why = diagram_.branches.size() < options_.max_branches ? FollowFrom(open[middle])
                                                                               : "as many branches as were allowed";
      if (!why.empty()) given_up.emplace_back(open[middle], why);
      open.erase(open.begin() + static_cast<std::ptrdiff_t>(middle));
    }
    for (auto& [motion, why] : given_up)
      if (!IsKnown(motion.row.V, motion.row.half_width)) unfollowed_.emplace_back(std::move(motion), why);
  }

  /// @return why there is no branch; empty if there is.
  std::string FollowFrom(const TracedMotion& motion) {
    const std::string origin = fmt::format("traced at {:g} m/s", motion.row.V);
    try {
      WagonFlow flow(FamilyBySpeed(wagon_), motion.row.V, options_.flow);
      const std::optional<WagonFlow::Guess> guess = flow.GuessCycle(motion.state, motion.row.V, kGuessSettle);
      if (!guess) return "it has died away";
      CycleOptions cycle;
      cycle.tolerance = options_.tolerance;
      const Cycle start = FindCycle(flow, motion.row.V, guess->state, guess->period, cycle);
      if (IsOnABranch(flow, diagram_.branches, start, options_)) return {};
      diagram_.branches.push_back({origin, FollowBothWays(flow, start, MakeContinuation(origin))});
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  /// Neighbours that no branch passes make a window; its middle is looked at closely.
  void CloseWindows() {
    std::ranges::sort(unfollowed_, {},
                      [](const auto& open) { return std::pair(open.first.row.leg, open.first.row.V); });
    for (std::size_t begin = 0; begin < unfollowed_.size() && !stopped_;) {
      std::size_t end = begin + 1;
      while (end < unfollowed_.size() && unfollowed_[end].first.row.leg == unfollowed_[begin].first.row.leg &&
             unfollowed_[end].first.row.V - unfollowed_[end - 1].first.row.V < 1.5 * options_.trace_step)
        ++end;
      const auto& [motion, why] = unfollowed_[(begin + end) / 2];
      OpenWindow window{.from = unfollowed_[begin].first.row.V,
                        .to = unfollowed_[end - 1].first.row.V,
                        .leg = motion.row.leg,
                        .why = why,
                        .speed = motion.row.V,
                        .outcome = {},
                        .lyapunov = {}};
      LookInto(motion, &window);
      if (!WasPassing(window)) diagram_.windows.push_back(std::move(window));
      begin = end;
    }
  }

  /// The trace went by while the motion was on its way to rest or to a branch: no window.
  bool WasPassing(const OpenWindow& window) const {
    if (window.outcome.end != RunEnd::kSettled) return false;
    const MotionKind kind = window.outcome.motion.kind;
    return kind == MotionKind::kEquilibrium ||
           (kind == MotionKind::kPeriodic && IsKnown(window.speed, window.outcome.half_width));
  }

  void LookInto(const TracedMotion& motion, OpenWindow* window) {
    Say(fmt::format("motion at {:g} m/s", motion.row.V));
    Integrator integrator(wagon_, options_.attractor.integrator);
    window->outcome = RunToAttractor(integrator, motion.row.V, motion.state, options_.attractor);
    const MotionKind kind = window->outcome.motion.kind;
    if (kind != MotionKind::kModulated && kind != MotionKind::kIrregular) return;
    try {
      WagonFlow flow(FamilyBySpeed(wagon_), motion.row.V, options_.flow);
      window->lyapunov = FindLargestExponent(flow, flow.FromWagonState(window->outcome.state), motion.row.V,
                                             options_.attractor.lyapunov);
    } catch (const std::exception& error) {
      diagram_.notices.push_back(fmt::format("Lyapunov exponent at {:g} m/s: {}", motion.row.V, error.what()));
    }
  }

  void Offer(const NonlinearCritical& candidate) {
    if (!diagram_.nonlinear || candidate.speed < diagram_.nonlinear->speed) diagram_.nonlinear = candidate;
  }

  void FindNonlinearCritical() {
    for (std::size_t i = 0; i < diagram_.branches.size(); ++i) OfferLowest(i);
    for (const OpenWindow& window : diagram_.windows) {
      const bool goes_on = window.outcome.end == RunEnd::kSettled &&
                           window.outcome.motion.kind != MotionKind::kEquilibrium &&
                           window.outcome.motion.kind != MotionKind::kSettling;
      if (goes_on) Offer({.speed = window.from, .by = "trace", .branch = 0});
    }
  }

  double NearestHopf(double V) const {
    const auto nearest = std::ranges::min_element(diagram_.hopfs, {},
                                                  [&](const HopfPoint& hopf) { return std::abs(hopf.crossing.V - V); });
    return nearest != diagram_.hopfs.end() ? nearest->crossing.V : V;
  }

  /// The lowest stable cycle of a branch, and what ends stability there.
  void OfferLowest(std::size_t number) {
    const Branch& branch = diagram_.branches[number].branch;
    std::size_t lowest = branch.points.size();
    for (std::size_t i = 0; i < branch.points.size(); ++i) {
      if (!branch.points[i].stable()) continue;
      if (lowest == branch.points.size() || branch.points[i].lambda < branch.points[lowest].lambda) lowest = i;
    }
    if (lowest == branch.points.size()) return;
    NonlinearCritical found{.speed = branch.points[lowest].lambda, .by = "end of a branch", .branch = number};
    if (lowest == 0 && diagram_.branches[number].origin.starts_with("born")) {
      found.by = "hopf";
      found.speed = NearestHopf(found.speed);
    }
    for (const BranchEvent& event : branch.events) {
      const bool beside = event.point == lowest || event.point + 1 == lowest;
      if (!beside || event.kind == BranchEventKind::kCharacter || event.kind == BranchEventKind::kBranchPoint) continue;
      // A corner is where two tangents meet: as well known as the points beside it.
      const bool lower = event.lambda <= found.speed || event.at_corner;
      if (event.kind == BranchEventKind::kFold && lower) found.speed = event.lambda;
      found.by = event.kind == BranchEventKind::kFold    ? "fold"
                 : event.kind == BranchEventKind::kTorus ? "torus"
                                                         : "period doubling";
    }
    Offer(found);
  }

  const Wagon& wagon_;
  const DiagramOptions& options_;
  BifurcationDiagram diagram_;
  std::vector<TracedMotion> motions_;
  std::vector<std::pair<TracedMotion, std::string>> unfollowed_;
  std::string failure_;
  std::mutex mutex_;
  bool stopped_ = false;
};

void Check(const DiagramOptions& options) {
  if (!(options.from > 0 && options.to > options.from && std::isfinite(options.to)))
    throw std::invalid_argument("expected speeds 0 < from < to");
  if (!(options.trace_step > 0 && options.trace_hold > 0 && options.start_settle > 0))
    throw std::invalid_argument("expected a step and times of the trace above 0");
}

}  // namespace

bool MovesAlike(const std::array<double, kMotionCount>& a, const std::array<double, kMotionCount>& b, double share,
                double least) {
  return std::ranges::all_of(kCompared, [&](TrackedMotion motion) {
    const double there = a[static_cast<std::size_t>(motion)], here = b[static_cast<std::size_t>(motion)];
    return std::abs(there - here) <= share * std::max(there, here) + least;
  });
}

bool LiesOn(const Branch& branch, double V, const std::array<double, kMotionCount>& half_width, double share,
            double least) {
  for (std::size_t i = 0; i + 1 < branch.points.size(); ++i) {
    const Cycle& a = branch.points[i];
    const Cycle& b = branch.points[i + 1];
    if ((V - a.lambda) * (V - b.lambda) > 0) continue;
    const double t = a.lambda != b.lambda ? (V - a.lambda) / (b.lambda - a.lambda) : 0.5;
    std::array<double, kMotionCount> between = HalfWidthsOf(a);
    const std::array<double, kMotionCount> end = HalfWidthsOf(b);
    for (std::size_t k = 0; k < kMotionCount; ++k) between[k] += t * (end[k] - between[k]);
    if (MovesAlike(between, half_width, share, least)) return true;
  }
  return false;
}

std::string DescribeValue(const DiagramParameter& parameter, double value) {
  return parameter.is_speed()
             ? fmt::format("{:.3f} m/s", value)
             : fmt::format("{} = {:.6g}{}", parameter.name, value, parameter.unit == "-" ? "" : " " + parameter.unit);
}

BifurcationDiagram CalcDiagram(const Wagon& wagon, const DiagramOptions& options) {
  Check(options);
  return DiagramBuilder(wagon, options).Run();
}

}  // namespace uiclink
