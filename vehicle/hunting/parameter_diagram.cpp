#include "vehicle/hunting/parameter_diagram.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

#include "vehicle/equilibrium.h"
#include "vehicle/hunting/branch_start.h"

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;

/// Parts of the range at whose ends the wagon is pushed.
constexpr int kParts = 8;
/// Of the range: the change of the parameter that counts as one in the norm.
constexpr double kScale = 0.05;
/// Crossings are searched in steps of so much of the range; they and events are located to so much of it.
constexpr double kSearchStep = 0.01, kLocated = 1e-7;

class ParameterDiagramBuilder {
 public:
  ParameterDiagramBuilder(const WagonFamily& family, double own, const DiagramOptions& options)
      : family_(family), own_(std::clamp(own, options.from, options.to)), options_(options) {
    diagram_.parameter = {.name = family.name, .unit = family.unit, .speed = family.speed, .own = own};
  }

  BifurcationDiagram Run() {
    const Clock::time_point begin = Clock::now();
    FindHopfs();
    for (const HopfPoint& hopf : diagram_.hopfs) FollowBorn(hopf);
    for (const double value : ListValues()) {
      if (stopped_) break;
      PushAt(value);
    }
    diagram_.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
    return std::move(diagram_);
  }

 private:
  double range() const { return options_.to - options_.from; }
  std::string Describe(double value) const { return DescribeValue(diagram_.parameter, value); }

  bool Say(const std::string& what) {
    if (options_.on_progress && !options_.on_progress(what)) stopped_ = true;
    return !stopped_;
  }

  void FindHopfs() {
    StabilityOptions search;
    search.from = options_.from;
    search.to = options_.to;
    search.step = kSearchStep * range();
    search.tolerance = kLocated * range();
    diagram_.linear =
        FindCrossings([&](double value) { return Linearize(*family_.make(value), family_.speed); }, search);
    HopfOptions hopf = options_.hopf;
    hopf.flow = options_.flow;
    for (const Crossing& crossing : diagram_.linear.crossings) {
      if (!Say("cycles born at " + Describe(crossing.V))) return;
      diagram_.hopfs.push_back(ExamineHopf(family_, crossing, hopf));
    }
  }

  ContinuationOptions MakeContinuation(const std::string& origin) {
    ContinuationOptions continuation = MakeContinuationOptions(options_);
    continuation.parameter_scale = kScale * range();
    continuation.fold_tolerance = kLocated * range();
    continuation.on_point = [this, origin, points = 0](const Cycle& cycle) mutable {
      return Say(fmt::format("branch {}: {} points, {}", origin, ++points, Describe(cycle.lambda)));
    };
    return continuation;
  }

  void FollowBorn(const HopfPoint& hopf) {
    const std::string origin = "born at " + Describe(hopf.crossing.V);
    try {
      if (auto branch = FollowBornBranch(family_, hopf, options_, MakeContinuation(origin)); branch && !stopped_)
        diagram_.branches.push_back({origin, std::move(*branch)});
    } catch (const std::exception& error) {
      diagram_.notices.push_back(fmt::format("branch {}: {}", origin, error.what()));
    }
  }

  /// Its own value first, then from one end to the other.
  std::vector<double> ListValues() const {
    std::vector<double> values{own_};
    for (int i = 0; i <= kParts; ++i) values.push_back(options_.from + range() * i / kParts);
    return values;
  }

  bool IsKnown(double value, const std::array<double, kMotionCount>& half_width) const {
    return std::ranges::any_of(diagram_.branches, [&](const HuntingBranch& hunting) {
      return LiesOn(hunting.branch, value, half_width, options_.same_share, options_.same_motion);
    });
  }

  /// What a pushed wagon comes to do: at rest, on a branch, the begin of a new one, or a window.
  void PushAt(double value) {
    if (!Say("hunting at " + Describe(value))) return;
    try {
      const std::shared_ptr<const Wagon> wagon = family_.make(value);
      SimulationOptions settle;
      settle.duration = options_.start_settle;
      settle.end_at_wheel_lift = false;
      const WagonState start = Perturb(*wagon, FindEquilibrium(*wagon, family_.speed),
                                       {.front_y = options_.start_y, .rear_y = options_.start_y});
      const SimulationResult run = Simulate(*wagon, family_.speed, start, settle);
      if (run.derailed) throw std::runtime_error("the pushed wagon derails");
      const std::string why = FollowFrom(run.state, value);
      if (!why.empty()) LookInto(*wagon, run.state, value, why);
    } catch (const std::exception& error) {
      diagram_.notices.push_back(fmt::format("hunting at {}: {}", Describe(value), error.what()));
    }
  }

  /// @return why there is no branch; empty if there is, or the motion has died away.
  std::string FollowFrom(const WagonState& state, double value) {
    try {
      WagonFlow flow(family_, value, options_.flow);
      const std::optional<WagonFlow::Guess> guess = flow.GuessCycle(state, value, kGuessSettle);
      if (!guess) return {};
      CycleOptions cycle;
      cycle.tolerance = options_.tolerance;
      const Cycle start = FindCycle(flow, value, guess->state, guess->period, cycle);
      if (IsOnABranch(flow, diagram_.branches, start, options_)) return {};
      if (diagram_.branches.size() >= options_.max_branches) return "as many branches as were allowed";
      const std::string origin = "pushed at " + Describe(value);
      diagram_.branches.push_back({origin, FollowBothWays(flow, start, MakeContinuation(origin))});
      return {};
    } catch (const std::exception& error) {
      return error.what();
    }
  }

  void LookInto(const Wagon& wagon, const WagonState& state, double value, const std::string& why) {
    Say("motion at " + Describe(value));
    Integrator integrator(wagon, options_.attractor.integrator);
    OpenWindow window{
        .from = value, .to = value, .leg = kPushed, .why = why, .speed = value, .outcome = {}, .lyapunov = {}};
    window.outcome = RunToAttractor(integrator, family_.speed, state, options_.attractor);
    const MotionKind kind = window.outcome.motion.kind;
    if (kind == MotionKind::kEquilibrium ||
        (kind == MotionKind::kPeriodic && IsKnown(value, window.outcome.half_width)))
      return;
    if (kind == MotionKind::kModulated || kind == MotionKind::kIrregular) FindExponent(value, &window);
    diagram_.windows.push_back(std::move(window));
  }

  void FindExponent(double value, OpenWindow* window) {
    try {
      WagonFlow flow(family_, value, options_.flow);
      window->lyapunov =
          FindLargestExponent(flow, flow.FromWagonState(window->outcome.state), value, options_.attractor.lyapunov);
    } catch (const std::exception& error) {
      diagram_.notices.push_back(fmt::format("Lyapunov exponent at {}: {}", Describe(value), error.what()));
    }
  }

  const WagonFamily& family_;
  double own_;
  const DiagramOptions& options_;
  BifurcationDiagram diagram_;
  bool stopped_ = false;
};

}  // namespace

BifurcationDiagram CalcParameterDiagram(const WagonFamily& family, double own, const DiagramOptions& options) {
  if (family.varies_speed) throw std::invalid_argument("expected a family by another parameter than the speed");
  if (!(options.to > options.from)) throw std::invalid_argument("expected from < to");
  return ParameterDiagramBuilder(family, own, options).Run();
}

}  // namespace uiclink
