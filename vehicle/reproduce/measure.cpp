#include "vehicle/reproduce/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "reports/chart.h"
#include "reports/thin_figure.h"
#include "vehicle/equilibrium.h"
#include "vehicle/reproduce/motion.h"
#include "vehicle/stability.h"
#include "vehicle/start_state.h"

namespace uiclink::reproduce {

ItemResult Measure(const Task& task, const Bench& bench) {
  ItemResult result;
  const auto begin = std::chrono::steady_clock::now();
  try {
    std::visit([&](const auto& one) { Measure(one, bench, &result); }, task);
  } catch (const GivenUp&) {
    throw;
  } catch (const std::exception& error) {
    result.failure = error.what();
  }
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

void Draw(const Figure& figure, const std::string& title, ItemResult* result) {
  try {
    constexpr double kMagnified = 4;  // as HtmlPage::Chart
    Figure thin = figure, chart = figure;
    ThinToPixels(&thin);
    ThinToPixels(&chart, kMagnified);
    result->pictures.push_back({title, RenderSvg(thin), FormatChart(chart)});
  } catch (const FigureError& error) {
    result->drawn = false;
    result->notices.push_back(fmt::format("a picture is missing ({}): {}", title, error.what()));
  }
}

SimulationResult RunOn(const Bench& bench, Integrator* integrator, double V, const WagonState& start,
                       SimulationOptions options) {
  options.on_progress = [&bench](double /*t*/) { return bench.GoOn(); };
  SimulationResult run = Simulate(*integrator, V, start, options);
  if (run.end == SimulationEnd::kStopped) throw GivenUp();
  return run;
}

Trace TraceOn(const Bench& bench, const WagonState& start, const TraceOptions& options) {
  Trace trace = TraceBifurcation(
      bench.wagon, {0, start}, options,
      [&bench](const TraceRow& /*row*/, const TracePoint& /*at*/, std::size_t /*rows*/) { return bench.GoOn(); });
  if (!bench.GoOn()) throw GivenUp();
  return trace;
}

std::optional<double> FindCritical(const Wagon& wagon, double to) {
  StabilityOptions options;
  options.to = to;
  options.first_only = true;
  return FindCrossings(wagon, options).linear_critical_speed;
}

double HalfWidth(const SimulationResult& run, TrackedMotion motion) {
  return 1e3 * run.motions[static_cast<std::size_t>(motion)].amplitude;
}

Value StrongestLine(const SimulationResult& run, TrackedMotion motion) {
  const std::vector<double>& lines = run.motions[static_cast<std::size_t>(motion)].frequencies;
  return lines.empty() ? Value() : Value(lines.front());
}

std::string NameImpacts(bool front, bool rear) {
  return front && rear ? "both" : rear ? "rear" : front ? "front" : "none";
}

// --- tasks that need no file of their own ----------------------------------------------------------------------------

void Measure(const DelayTask& task, const Bench& bench, ItemResult* result) {
  for (const double hold : task.holds) {
    TraceOptions options;
    options.from = task.from;
    options.legs = {{task.to}};
    options.hold = hold;
    const Trace trace = TraceOn(bench, FindEquilibrium(bench.wagon, task.from), options);
    const std::vector<TraceJump> jumps = FindTraceJumps(trace.rows).jumps;
    const auto onset = std::ranges::find(jumps, TraceJump::Kind::kOnset, &TraceJump::kind);
    result->values[fmt::format("onset_{:g}", hold)] = onset != jumps.end() ? Value(onset->V) : Value();
  }
  result->values["linear_critical_speed"] = ToValue(FindCritical(bench.wagon));
}

void Measure(const ToleranceTask& task, const Bench& bench, ItemResult* result) {
  const WagonState start = MakeRunStart(task.start, bench.wagon, task.V).state;
  for (const double tolerance : task.tolerances) {
    Integrator integrator(bench.wagon, {.tolerance = tolerance, .method = {}});
    SimulationOptions options;
    options.duration = task.duration;
    options.window = std::min(20.0, task.duration);
    const SimulationResult run = RunOn(bench, &integrator, task.V, start, options);
    result->values[fmt::format("frequency_{:g}", tolerance)] = StrongestLine(run, TrackedMotion::kBodyLateral);
    result->values[fmt::format("front_{:g}", tolerance)] = HalfWidth(run, TrackedMotion::kFrontLateral);
  }
}

}  // namespace uiclink::reproduce
