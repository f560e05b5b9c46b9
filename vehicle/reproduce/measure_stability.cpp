// Eigenvalues: figures 10.2 and 10.24. And what grows out of the centre: figures 10.3 and 10.25.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/hunting/hopf.h"
#include "vehicle/reproduce/measure.h"
#include "vehicle/reproduce/motion.h"
#include "vehicle/stability.h"
#include "vehicle/stability_report.h"
#include "vehicle/start_state.h"

namespace uiclink::reproduce {
namespace {

/// Sizes of cycles that are looked at [m]: those of `wagon stability`.
const std::vector<double> kSizes{1e-5, 3e-5, 1e-4};

void AddType(const Wagon& wagon, const Crossing& crossing, ItemResult* result) {
  HopfOptions options;
  options.sizes = kSizes;
  const HopfPoint hopf = ExamineHopf(wagon, crossing, options);
  std::string type = hopf.type ? HopfTypeName(*hopf.type) : "not known: " + hopf.reason;
  if (hopf.other_below) type += fmt::format(" (but not below {:g} mm)", 1e3 * *hopf.other_below);
  result->values["type"] = type;
  for (const BornCycle& born : hopf.born) result->values[fmt::format("cycle_{:g}_mm_at", 1e3 * born.size)] = born.speed;
}

/// Close steps on both sides of the crossing: the slow eigenvalues as they pass.
void DrawCloseUp(const StabilityTask& task, const Bench& bench, double critical, ItemResult* result) {
  std::vector<RootsAtSpeed> roots;
  StabilityOptions options;
  options.from = std::max(task.from, critical - task.picture_around);
  options.to = critical + task.picture_around;
  options.step = (options.to - options.from) / 40;
  options.on_speed = [&](double V, const std::vector<std::complex<double>>& values) { roots.push_back({V, values}); };
  const StabilityResult found = FindCrossings(bench.wagon, options);
  const StabilityRun run{bench.inputs, found, roots, options, 0, {}};
  Draw(RootLocusFigure(run), fmt::format("eigenvalues around {:.2f} m/s", critical), result);
}

}  // namespace

void Measure(const StabilityTask& task, const Bench& bench, ItemResult* result) {
  std::vector<RootsAtSpeed> roots;
  StabilityOptions options;
  options.from = task.from;
  options.to = task.to;
  options.step = task.step;
  options.on_speed = [&](double V, const std::vector<std::complex<double>>& values) { roots.push_back({V, values}); };
  const StabilityResult found = FindCrossings(bench.wagon, options);
  result->values["linear_critical_speed"] = ToValue(found.linear_critical_speed);
  const StabilityRun run{bench.inputs, found, roots, options, 0, {}};
  Draw(RootLocusFigure(run), fmt::format("slow eigenvalues from {:g} to {:g} m/s", task.from, task.to), result);
  if (!found.linear_critical_speed) return;
  const auto first = std::ranges::find(found.crossings, *found.linear_critical_speed, &Crossing::V);
  result->values["frequency_hz"] = first->frequency_hz;
  result->values["pair"] = first->frequency_hz > 0 ? "yes" : "no";
  const auto second = std::find_if(first + 1, found.crossings.end(), [](const Crossing& c) { return c.to_unstable; });
  result->values["second_crossing"] = second != found.crossings.end() ? Value(second->V) : Value();
  AddType(bench.wagon, *first, result);
  DrawCloseUp(task, bench, first->V, result);
}

namespace {

constexpr double kPiece = 5;  // [s]: some cycles, of which one half width is taken
constexpr double kOutputHz = 50;
constexpr double kSmallMotion = 1.0;  // [mm]: what is smaller is a small cycle about the centre
constexpr double kRest = 2e-3;        // [mm]

/// Half widths of the front wheelset, piece by piece [mm].
std::vector<double> CalcEnvelope(const SimulationResult& run) {
  const std::size_t place = kMotionIndex[static_cast<std::size_t>(TrackedMotion::kFrontLateral)];
  const auto per_piece = static_cast<std::size_t>(kPiece * kOutputHz);
  std::vector<double> envelope;
  for (std::size_t i = 0; i + per_piece <= run.samples.size(); i += per_piece) {
    const auto [low, high] = std::minmax_element(
        run.samples.begin() + static_cast<std::ptrdiff_t>(i),
        run.samples.begin() + static_cast<std::ptrdiff_t>(i + per_piece),
        [&](const SimulationSample& a, const SimulationSample& b) { return a.x[place] < b.x[place]; });
    envelope.push_back(0.5e3 * (high->x[place] - low->x[place]));
  }
  return envelope;
}

Figure GrowthFigure(const SimulationResult& run, double V) {
  constexpr double kCloseUp = 10;
  const std::size_t place = kMotionIndex[static_cast<std::size_t>(TrackedMotion::kFrontLateral)];
  FigureSeries whole{.name = "", .width = 0.6}, end{.name = ""};
  for (const SimulationSample& sample : run.samples) {
    whole.x.push_back(sample.t);
    whole.y.push_back(1e3 * sample.x[place]);
    if (sample.t < run.samples.back().t - kCloseUp) continue;
    end.x.push_back(sample.t);
    end.y.push_back(1e3 * sample.x[place]);
  }
  const FigureAxis time{"time", "s"}, y{"front wheelset, lateral", "mm"};
  return {.title = fmt::format("out of the centre at {:.2f} m/s", V),
          .panels = {{.title = "whole", .x = time, .y = y, .series = {whole}},
                     {.title = "end", .x = time, .y = y, .series = {end}}},
          .columns = 2,
          .width = 1200,
          .panel_height = 260};
}

}  // namespace

void Measure(const GrowthTask& task, const Bench& bench, ItemResult* result) {
  double V = task.V;
  if (!(V > 0)) {
    const std::optional<double> critical = FindCritical(bench.wagon);
    if (!critical) throw std::runtime_error("no linear critical speed up to 60 m/s");
    V = *critical + task.above_hopf;
  }
  Integrator integrator(bench.wagon);
  SimulationOptions options;
  options.duration = task.duration;
  options.output_hz = kOutputHz;
  options.end_at_wheel_lift = false;
  const SimulationResult run = RunOn(bench, &integrator, V, MakeRunStart(task.start, bench.wagon, V).state, options);
  const std::vector<double> envelope = CalcEnvelope(run);
  if (envelope.size() < 3) throw std::runtime_error("the run ended early: " + run.end_reason);
  const double last = envelope.back();
  const double rate = std::log(last / envelope[envelope.size() - 3]) / (2 * kPiece);
  const bool settled = std::abs(rate) < 1e-3;  // less than 1 % in ten seconds
  result->values["speed"] = V;
  result->values["final_mm"] = last;
  const char* motion = last < kRest ? "the centre" : last < kSmallMotion ? "a small cycle" : "large hunting";
  result->values["ends_on"] =
      settled || last < kRest ? std::string(motion) : fmt::format("not settled after {:g} s", task.duration);
  const auto there = std::ranges::find_if(envelope, [&](double width) { return width >= 0.95 * last; });
  result->values["time_to_95"] =
      settled && last > kRest ? Value(kPiece * static_cast<double>(there - envelope.begin() + 1)) : Value();
  Draw(GrowthFigure(run, V), fmt::format("lateral motion of the front wheelset out of the centre at {:.2f} m/s", V),
       result);
}

}  // namespace uiclink::reproduce
