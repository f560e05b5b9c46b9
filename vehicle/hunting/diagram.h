#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/continuation.h"
#include "dynamics/lyapunov.h"
#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/hopf.h"
#include "vehicle/hunting/trace.h"
#include "vehicle/stability.h"

namespace uiclink {

/// What a diagram is drawn over.
struct DiagramParameter {
  std::string name = "speed";   ///< of a WagonFamily
  std::string unit = "m/s";     ///< of its values
  std::optional<double> speed;  ///< [m/s] at which it is varied; none: it is the speed
  double own = 0;               ///< value of the wagon as it was chosen; not for the speed

  bool is_speed() const { return !speed.has_value(); }
};
/// "18.400 m/s", "lateral.k = 4.25 1/m".
std::string DescribeValue(const DiagramParameter& parameter, double value);

struct DiagramOptions {
  double from = 5, to = 30;  ///< range of speeds [m/s], or of the parameter
  /// Hunting is looked for by a coarse trace, down from `to` and up again.
  double trace_step = 0.5;       ///< [m/s]
  double trace_hold = 20;        ///< seconds at every speed
  double start_y = 5e-3;         ///< both wheelsets beside the equilibrium, where the trace begins [m]
  double start_settle = 60;      ///< and how long before it [s]
  std::size_t max_points = 300;  ///< of a branch
  std::size_t max_branches = 12;
  double max_step = 0.5;  ///< along a branch: m/s (a twentieth of the range), or norm one in the state
  /// Of a cycle (CycleOptions): some times what events and step control leave of a flow at 1e-8, up to 1.6e-6.
  double tolerance = 5e-6;
  double same_share = 0.03;   ///< a traced motion is on a branch whose amplitudes agree by this share ...
  double same_motion = 2e-5;  ///< ... and this [m]
  HopfOptions hopf;
  WagonFlowOptions flow;
  AttractorOptions attractor;  ///< how motions that are on no branch are told apart
  int threads = 0;
  /// Told what is being done, from any thread but one at a time; false stops after what is being done. May be null.
  std::function<bool(const std::string& what)> on_progress;
};

/// A branch of hunting.
struct HuntingBranch {
  std::string origin;  ///< "born at 18.400 m/s", "traced at 24 m/s", "pushed at lateral.k = 4.2 1/m"
  Branch branch;
};

inline constexpr std::size_t kPushed = 2;

/// Speeds, or values of the parameter, at which a traced motion lies on no branch of cycles.
struct OpenWindow {
  double from = 0, to = 0;  ///< first and last speed of the trace [m/s]
  std::size_t leg = 0;      ///< 0 down, 1 up; kPushed: not traced
  std::string why;          ///< no cycle could be found from it
  double speed = 0;         ///< where it was looked at closely
  RunOutcome outcome;       ///< kind of motion, modulation period, amplitudes there
  std::optional<LyapunovResult> lyapunov;
};

/// The lowest speed at which the wagon can hunt for ever.
struct NonlinearCritical {
  double speed = 0;        ///< [m/s]
  std::string by;          ///< "fold", "hopf", "period doubling", "torus", "end of a branch", "trace"
  std::size_t branch = 0;  ///< of it; not for "trace"
};

struct BifurcationDiagram {
  DiagramParameter parameter;  ///< where it is not the speed, speeds below are values of it
  StabilityResult linear;
  std::vector<HopfPoint> hopfs;
  std::vector<HuntingBranch> branches;
  std::vector<TraceRow> trace;
  std::vector<OpenWindow> windows;
  std::optional<NonlinearCritical> nonlinear;  ///< none: no stable hunting was found in the range
  std::vector<std::string> notices;            ///< what was left undone and why
  double wall_s = 0, trace_wall_s = 0;
  double traced_s = 0;  ///< simulated by the trace
};

/// The bifurcation diagram of a wagon by speed:
///   1. crossings of eigenvalues; at each the born cycles and the branch that they begin;
///   2. a coarse trace down and up; whatever it meets that is on no branch yet is made a cycle of and followed both
///   ways;
///   3. what cannot be made a cycle of is a window: looked at by its section and its Lyapunov exponent.
/// Stable and unstable parts, folds, torus and period-doubling points are the branches' own (dynamics/continuation.h).
BifurcationDiagram CalcDiagram(const Wagon& wagon, const DiagramOptions& options);

/// Whether two motions with these half widths (by TrackedMotion) are the same: lateral ones of wheelsets and body
/// differ by less than a share of the larger one and `least` [m].
bool MovesAlike(const std::array<double, kMotionCount>& a, const std::array<double, kMotionCount>& b, double share,
                double least);

/// Whether a motion with these half widths (by TrackedMotion) at speed V lies on the branch, between its points.
bool LiesOn(const Branch& branch, double V, const std::array<double, kMotionCount>& half_width, double share,
            double least);

}  // namespace uiclink
