#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "vehicle/simulation.h"

namespace uiclink {

/// A stretch of a bifurcation trace: from where the last one ended to another speed.
struct TraceLeg {
  double to = 0;       ///< [m/s]
  double step = 0.05;  ///< [m/s], > 0
};

/// The bifurcation trace of the thesis (section 10.1): a speed is held, the largest amplitudes of its last seconds are
/// kept, the speed goes a step further, the state is handed on.
struct TraceOptions {
  double from = 15;                          ///< [m/s]
  std::vector<TraceLeg> legs = {{23}, {8}};  ///< figure 10.1(a): up and down
  double hold = 10;                          ///< seconds a speed is held; the thesis: 5 or 10
  double window = 3;                         ///< the last so many of them count, <= hold
  /// Both wheelsets are put this far aside at the beginning of every step, to the left and to the right in turn [m].
  /// A trace that starts in a perfect equilibrium would else never leave it; in the thesis the error of its solver (its
  /// tolerance was 1e-6) does this.
  double disturbance = 1e-6;
  IntegratorOptions integrator = {};
};

/// What a wagon did at one speed of a trace.
struct TraceRow {
  double V = 0;                                   ///< [m/s]
  std::size_t leg = 0;                            ///< from 0
  std::array<double, kMotionCount> largest{};     ///< max |motion| in the window, by TrackedMotion [m] or [rad]
  std::array<double, kMotionCount> half_width{};  ///< half of peak to peak in the window
  std::array<GuidanceUse, kAxles> lateral{};      ///< in the window: clearance_used and impacts
  std::array<GuidanceUse, kAxles> longitudinal{};
  double minimum_wheel_load = 0;  ///< in the window [N]
  bool wheel_lift = false;        ///< at any time while the speed was held; the trace goes on
  bool derailed = false;          ///< the trace ends here
};

/// Where a trace has come to.
struct TracePoint {
  std::size_t rows = 0;  ///< so many speeds are done
  WagonState state;      ///< at the end of the last of them
};

struct Trace {
  std::vector<TraceRow> rows;  ///< those that this call has made
  TracePoint end;
  bool complete = false;   ///< every speed of every leg
  std::string end_reason;  ///< "derailed at 8.35 m/s, ...", "stopped", what the solver said; empty if complete
  double wall_s = 0;
  IntegratorCounts counts;
};

/// Told after every speed; false stops the trace. `at` is enough to go on from, bit by bit.
using TraceCallback = std::function<bool(const TraceRow& row, const TracePoint& at, std::size_t rows_in_all)>;

/// The speeds of a trace, leg by leg; the end of a leg belongs to it and not to the next one.
struct TraceSpeed {
  double V = 0;
  std::size_t leg = 0;
};
/// @throws std::invalid_argument for options out of range.
std::vector<TraceSpeed> ListTraceSpeeds(const TraceOptions& options);

/// @param start  where the trace is: {0, FindEquilibrium(wagon, options.from)} or a point that a callback was given.
/// The solver giving up ends the trace with its reason. Nothing but the state goes from one speed to the next: its time
/// is set to zero.
/// @throws std::invalid_argument for options out of range.
Trace TraceBifurcation(const Wagon& wagon, const TracePoint& start, const TraceOptions& options,
                       const TraceCallback& on_row = nullptr);

/// A speed at which a motion sets in or dies along a trace.
struct TraceJump {
  enum class Kind { kOnset, kDeath };
  Kind kind = Kind::kOnset;
  std::size_t leg = 0;
  double V = 0;                                ///< of the first row on the other side of the threshold [m/s]
  double before = 0;                           ///< of the last row before it [m/s]: the step of the trace away
  double amplitude = 0, amplitude_before = 0;  ///< half widths there [m] or [rad]
};

struct TraceJumps {
  double threshold = 0;  ///< of the half width; 0: the trace has no two sorts of rows
  std::vector<TraceJump> jumps;
};

/// Where the half width of a motion passes from the small values to the large ones of the trace or back.
///
/// Threshold: the one that parts the logarithms of all half widths best into two classes (largest variance between
/// them; N. Otsu, IEEE Trans. Syst. Man Cybern. 9, 1979). Half widths below 10 um count as 10 um, so that the way down
/// into rounding is no class of its own. None where the classes' means are less than a factor of five apart.
TraceJumps FindTraceJumps(std::span<const TraceRow> rows, TrackedMotion motion = TrackedMotion::kFrontLateral);

}  // namespace uiclink
