#include "vehicle/hunting/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "vehicle/hunting/window_watch.h"

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;

void CheckOptions(const TraceOptions& o) {
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  if (!positive(o.from)) throw std::invalid_argument("a trace: the first speed must be positive");
  for (const TraceLeg& leg : o.legs) {
    if (!positive(leg.to) || !positive(leg.step))
      throw std::invalid_argument("a trace: speed and step of a leg must be positive");
  }
  if (!positive(o.window) || !(o.hold >= o.window) || !std::isfinite(o.hold))
    throw std::invalid_argument("a trace: the window must be positive and not longer than a speed is held");
  if (!(o.disturbance >= 0)) throw std::invalid_argument("a trace: the disturbance must not be negative");
}

/// Holds speeds, one after the other.
class Tracer {
 public:
  Tracer(const Wagon& wagon, const TraceOptions& options)
      : wagon_(wagon), options_(options), integrator_(wagon, options.integrator), watch_(wagon) {}

  /// Holds a speed from a state, which becomes the one at its end.
  TraceRow Hold(const TraceSpeed& at, double disturbance, WagonState* state) {
    TraceRow row{.V = at.V, .leg = at.leg};
    state->t = 0;
    if (disturbance != 0) *state = Perturb(wagon_, *state, {.front_y = disturbance, .rear_y = disturbance});
    integrator_.Start(at.V, *state);
    row.derailed = !Run(options_.hold - options_.window, &row) || !Run(options_.hold, &row);
    *state = integrator_.state();
    row.largest = watch_.CalcLargest();
    row.half_width = watch_.CalcHalfWidths();
    for (const Axle axle : {Axle::kFront, Axle::kRear}) {
      row.lateral[static_cast<std::size_t>(axle)] = watch_.Lateral(axle);
      row.longitudinal[static_cast<std::size_t>(axle)] = watch_.Longitudinal(axle);
    }
    row.minimum_wheel_load = watch_.minimum_wheel_load();
    return row;
  }

  const IntegratorCounts& counts() const { return integrator_.counts(); }

 private:
  /// Up to a time within a speed, watched anew. False when the wagon has derailed.
  bool Run(double until, TraceRow* row) {
    watch_.Begin(integrator_);
    Advance advance = Advance::kStep;
    while (integrator_.state().t < until && advance != Advance::kDerailed) {
      advance = integrator_.Step(until);
      watch_.Add(integrator_);
    }
    row->wheel_lift = row->wheel_lift || watch_.wheel_lift();
    return advance != Advance::kDerailed;
  }

  const Wagon& wagon_;
  const TraceOptions& options_;
  Integrator integrator_;
  WindowWatch watch_;
};

constexpr double kLeastHalfWidth = 1e-5;
constexpr double kLeastRatio = 5;

/// The threshold that parts values best into two classes; 0 where they are too near.
double FindThreshold(std::vector<double> logs) {
  std::ranges::sort(logs);
  const auto n = static_cast<double>(logs.size());
  double all = 0;
  for (const double x : logs) all += x;
  double low = 0, best = 0, threshold = 0, apart = 0;
  for (std::size_t i = 1; i < logs.size(); ++i) {
    low += logs[i - 1];
    if (logs[i] == logs[i - 1]) continue;
    const auto count = static_cast<double>(i);
    const double difference = (all - low) / (n - count) - low / count;
    const double between = count * (n - count) * difference * difference;
    if (between <= best) continue;
    best = between;
    apart = difference;
    threshold = 0.5 * (low / count + (all - low) / (n - count));
  }
  return apart >= std::log(kLeastRatio) ? std::exp(threshold) : 0;
}

}  // namespace

std::vector<TraceSpeed> ListTraceSpeeds(const TraceOptions& options) {
  CheckOptions(options);
  std::vector<TraceSpeed> speeds{{options.from, 0}};
  double from = options.from;
  for (std::size_t leg = 0; leg < options.legs.size(); ++leg) {
    const auto& [to, step] = options.legs[leg];
    const double steps = std::abs(to - from) / step;
    const auto count = static_cast<int>(std::ceil(steps * (1 - 1e-12)));
    const double way = to < from ? -step : step;
    for (int i = 1; i < count; ++i) speeds.push_back({from + i * way, leg});
    if (count > 0) speeds.push_back({to, leg});  // the last step may be shorter
    from = to;
  }
  return speeds;
}

Trace TraceBifurcation(const Wagon& wagon, const TracePoint& start, const TraceOptions& options,
                       const TraceCallback& on_row) {
  const std::vector<TraceSpeed> speeds = ListTraceSpeeds(options);
  const auto begin = Clock::now();
  Tracer tracer(wagon, options);
  Trace trace;
  trace.end = start;
  trace.rows.reserve(speeds.size() - std::min(start.rows, speeds.size()));
  while (trace.end.rows < speeds.size() && trace.end_reason.empty()) {
    const TraceSpeed& at = speeds[trace.end.rows];
    const double disturbance = trace.end.rows % 2 == 0 ? options.disturbance : -options.disturbance;
    WagonState state = trace.end.state;
    try {
      trace.rows.push_back(tracer.Hold(at, disturbance, &state));
    } catch (const std::runtime_error& error) {
      trace.end_reason = fmt::format("at {:g} m/s: {}", at.V, error.what());
      break;
    }
    trace.end = {trace.end.rows + 1, state};
    if (trace.rows.back().derailed)
      trace.end_reason = fmt::format("derailed at {:g} m/s after {:.2f} s", at.V, state.t);
    if (on_row && !on_row(trace.rows.back(), trace.end, speeds.size()) && trace.end_reason.empty())
      trace.end_reason = "stopped";
  }
  trace.complete = trace.end.rows == speeds.size() && trace.end_reason.empty();
  trace.counts = tracer.counts();
  trace.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return trace;
}

TraceJumps FindTraceJumps(std::span<const TraceRow> rows, TrackedMotion motion) {
  const auto size = [motion](const TraceRow& row) { return row.half_width[static_cast<std::size_t>(motion)]; };
  std::vector<double> logs;
  logs.reserve(rows.size());
  for (const TraceRow& row : rows) logs.push_back(std::log(std::max(size(row), kLeastHalfWidth)));
  TraceJumps found{.threshold = FindThreshold(std::move(logs)), .jumps = {}};
  if (found.threshold == 0) return found;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const bool was = size(rows[i - 1]) > found.threshold;
    const bool is = size(rows[i]) > found.threshold;
    if (was == is) continue;
    found.jumps.push_back({.kind = is ? TraceJump::Kind::kOnset : TraceJump::Kind::kDeath,
                           .leg = rows[i].leg,
                           .V = rows[i].V,
                           .before = rows[i - 1].V,
                           .amplitude = size(rows[i]),
                           .amplitude_before = size(rows[i - 1])});
  }
  return found;
}

}  // namespace uiclink
