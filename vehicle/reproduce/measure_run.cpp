// Runs at one speed: figures 10.4 to 10.21, 10.26 to 10.30, both tables.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vehicle/equilibrium.h"
#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/running_spectrum_report.h"
#include "vehicle/reproduce/measure.h"
#include "vehicle/reproduce/motion.h"
#include "vehicle/start_state.h"

namespace uiclink::reproduce {
namespace {

constexpr double kOutputHz = 200;       // impacts last some 50 ms
constexpr double kLeastHunting = 1e-2;  // [mm] of the front wheelset
constexpr double kGrown = 40e-3;        // [m] between axle box and body: 28 mm and less where a motion does not grow

/// Where the run at the item's speed begins: at once, or handed down from a higher speed as the thesis's trace does.
WagonState FindStart(const RunTask& task, const Bench& bench, Integrator* integrator) {
  if (!(task.descend_from > task.V)) return MakeRunStart(task.start, bench.wagon, task.V).state;
  SimulationOptions settle;
  settle.duration = task.settle;
  settle.end_at_wheel_lift = false;
  const SimulationResult first = RunOn(bench, integrator, task.descend_from,
                                       MakeRunStart(task.start, bench.wagon, task.descend_from).state, settle);
  TraceOptions down;
  down.from = task.descend_from;
  down.legs = {{task.V, task.step}};
  down.hold = task.hold;
  down.disturbance = 0;
  const Trace trace = TraceOn(bench, first.state, down);
  if (!trace.complete) throw std::runtime_error("the way down ended early: " + trace.end_reason);
  WagonState state = trace.end.state;
  state.t = 0;
  return state;
}

std::string ListLines(const std::vector<double>& lines) {
  std::vector<double> sorted = lines;
  std::ranges::sort(sorted);
  std::string text;
  for (const double line : sorted) text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", line);
  return text.empty() ? "none" : text;
}

void AddMotions(const SimulationResult& run, ItemResult* result) {
  auto& values = result->values;
  values["front_mm"] = HalfWidth(run, TrackedMotion::kFrontLateral);
  values["rear_mm"] = HalfWidth(run, TrackedMotion::kRearLateral);
  values["body_mm"] = HalfWidth(run, TrackedMotion::kBodyLateral);
  values["rear_peak_to_peak_mm"] = 2 * HalfWidth(run, TrackedMotion::kRearLateral);
  values["frequency_hz"] = StrongestLine(run, TrackedMotion::kBodyLateral);
  values["front_hz"] = StrongestLine(run, TrackedMotion::kFrontLateral);
  values["rear_hz"] = StrongestLine(run, TrackedMotion::kRearLateral);
  values["yaw_hz"] = StrongestLine(run, TrackedMotion::kBodyYaw);
  values["roll_hz"] = StrongestLine(run, TrackedMotion::kBodyRoll);
  const std::vector<double>& lines =
      run.motions[static_cast<std::size_t>(TrackedMotion::kFrontLongitudinal)].frequencies;
  values["longitudinal_lines"] = ListLines(lines);
  values["lowest_longitudinal_hz"] = lines.empty() ? Value() : Value(*std::ranges::min_element(lines));
  values["hunts"] = HalfWidth(run, TrackedMotion::kFrontLateral) > kLeastHunting ? "yes" : "no";
  if (values["hunts"] == Value("no")) values["frequency_hz"] = Value();
  values["minimum_load_kN"] = 1e-3 * run.minimum_wheel_load;
}

void AddImpacts(const SimulationResult& run, ItemResult* result) {
  const auto& [front, rear] = run.lateral;
  auto& values = result->values;
  values["impacts"] = NameImpacts(front.impacts_in_window.count > 0, rear.impacts_in_window.count > 0);
  values["longitudinal_impacts"] =
      NameImpacts(run.longitudinal[0].impacts.count > 0, run.longitudinal[1].impacts.count > 0);
  values["peak_front_kN"] = 1e-3 * front.impacts_in_window.peak_N;
  values["peak_rear_kN"] = 1e-3 * rear.impacts_in_window.peak_N;
  const double front_N = front.impacts_in_window.peak_N, rear_N = rear.impacts_in_window.peak_N;
  values["harder"] = front_N > rear_N ? "front" : rear_N > 0 ? "rear" : "none";
  values["clearance_mm"] = 1e3 * std::max(front.clearance_used_in_window, rear.clearance_used_in_window);
  const bool grown = std::max(front.clearance_used_in_window, rear.clearance_used_in_window) > kGrown;
  values["outcome"] = run.wheel_lift || run.derailed ? "a wheel lifts: " + run.end_reason
                      : grown                        ? std::string("grows, no wheel lifts")
                                                     : std::string("stays");
}

/// The free vibration lengthwise with all joints at rest: of the modes that move the wheelsets so, the one that rings.
void AddFreeVibration(const Bench& bench, double V, ItemResult* result) {
  std::vector<FreeVibration> vibrations = FindFreeVibrations(bench.wagon, bench.wagon, V);
  std::erase_if(vibrations, [](const FreeVibration& vibration) { return vibration.name != "longitudinal"; });
  const auto rings = std::ranges::max_element(vibrations, {}, &FreeVibration::decay);
  result->values["free_longitudinal_hz"] = rings != vibrations.end() ? Value(rings->stuck_hz) : Value();
}

/// Base frequency of all lateral motions, yaw and roll.
void AddLocking(const RunningSpectrum& spectrum, ItemResult* result) {
  bool in_step = !spectrum.at_rest;
  for (const char* name :
       {"front_lateral", "rear_lateral", "front_yaw", "rear_yaw", "body_lateral", "body_roll", "body_yaw"}) {
    const std::vector<SpectralLine>& lines = spectrum.motion(name).lines;
    if (!lines.empty()) in_step = in_step && std::abs(lines.front().ratio - 1) < 0.01;
  }
  result->values["in_step"] = in_step ? "yes" : "no";
}

void AddKind(const RunTask& task, const Bench& bench, Integrator* integrator, const WagonState& from,
             ItemResult* result) {
  AttractorOptions options;
  options.settle = 0;
  const RunOutcome outcome = RunToAttractor(*integrator, task.V, from, options);
  if (!bench.GoOn()) throw GivenUp();
  const SectionMotion& motion = outcome.motion;
  result->values["kind"] = std::string(MotionKindName(motion.kind));
  result->values["modulation_period"] = motion.modulation_period > 0 ? Value(motion.modulation_period) : Value();
}

void DrawMotion(const RunTask& task, const Bench& bench, const SimulationResult& run, ItemResult* result) {
  // A run that begins at once shows how it comes to its motion; one that is handed down has it from the first.
  const double shown = task.descend_from > 0 || task.spectra ? task.window : task.duration;
  const WagonInputs& in = bench.inputs;
  Draw(MotionFigure(run, fmt::format("{} at {:g} m/s, {}, {}", in.data.name, task.V, in.freight.name, in.table.name),
                    task.spectra, shown),
       fmt::format("motion at {:g} m/s, {}: the last {:g} s, and closer", task.V, in.freight.name, shown), result);
}

/// Lateral forces and clearances, as figure 10.9 has them; longitudinal forces (figure 10.6) only where there are any.
void DrawImpacts(const SpectrumRun& run, ItemResult* result) {
  Figure figure = ImpactFigure(run);
  const bool none = std::ranges::all_of(run.guidance.longitudinal, [](const auto& guide) {
    return std::ranges::all_of(guide.force, [](double force) { return force == 0; });
  });
  if (none)
    std::erase_if(figure.panels,
                  [](const FigurePanel& panel) { return panel.title.ends_with("longitudinal guide forces"); });
  Draw(figure,
       fmt::format("forces of the guides and clearances used at {:g} m/s{}", run.V,
                   none ? "; longitudinal forces are zero" : ""),
       result);
}

/// Spectra of the last seconds, or forces of the guides and what is used of the clearance.
void DrawWindow(const RunTask& task, const Bench& bench, const SimulationResult& run, ItemResult* result) {
  const auto wanted = static_cast<std::size_t>(std::lround(task.window * kOutputHz));
  const std::size_t first = run.samples.size() > wanted ? run.samples.size() - wanted : 0;
  const std::vector<SimulationSample> samples(run.samples.begin() + static_cast<std::ptrdiff_t>(first),
                                              run.samples.end());
  SpectrumRun spectrum{.inputs = bench.inputs, .V = task.V, .source = task.start};
  if (task.spectra) {
    spectrum.spectrum = CalcRunningSpectrum(samples, kOutputHz);
    AddLocking(spectrum.spectrum, result);
    AddFreeVibration(bench, task.V, result);
    Draw(SpectrumFigure(spectrum), fmt::format("power spectra of the last {:g} s at {:g} m/s", task.window, task.V),
         result);
  } else {
    spectrum.guidance = CalcGuidanceHistory(bench.wagon, samples);
    DrawImpacts(spectrum, result);
  }
}

}  // namespace

void Measure(const RunTask& task, const Bench& bench, ItemResult* result) {
  Integrator integrator(bench.wagon);
  const WagonState start = FindStart(task, bench, &integrator);
  SimulationOptions options;
  options.duration = task.duration;
  options.window = task.window;
  options.output_hz = kOutputHz;
  options.end_at_wheel_lift = task.end_at_wheel_lift;
  const SimulationResult run = RunOn(bench, &integrator, task.V, start, options);
  AddMotions(run, result);
  AddImpacts(run, result);
  DrawMotion(task, bench, run, result);
  DrawWindow(task, bench, run, result);
  if (task.kind) AddKind(task, bench, &integrator, run.state, result);
}

}  // namespace uiclink::reproduce
