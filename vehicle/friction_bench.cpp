#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "model/closed_form.h"
#include "model/event_solver.h"
#include "vehicle/bench_check.h"
#include "vehicle/element_bench.h"

namespace uiclink {
namespace {

/// Pulled out slowly from the origin, where all is relaxed: T_i = -min(k_i |y|, T0i) sign y.
State<double> PulledOut(const Oscillator<double>& oscillator, double y) {
  State<double> state{.y = y};
  for (std::size_t i = 0; i < oscillator.sliders().size(); ++i) {
    const Slider<double>& slider = oscillator.sliders()[i];
    state.T[i] = std::clamp(-slider.k * y, -slider.T0, slider.T0);
  }
  return state;
}

State<double> StateAt(const Trajectory<double>& run, std::size_t sliders, double t) {
  State<double> state{.y = run.y(t), .v = run.v(t)};
  for (std::size_t i = 0; i < sliders; ++i) state.T[i] = run.T(i, t);
  return state;
}

void CollectSwings(const Oscillator<double>& oscillator, const Trajectory<double>& arcs, DryFrictionRun* run) {
  const std::size_t sliders = oscillator.sliders().size();
  const double start = CalcEnergy(oscillator, StateAt(arcs, sliders, 0));
  for (const Arc<double>& arc : arcs.arcs()) {
    if (arc.end != EventKind::kTurning) continue;
    run->extremum_t.push_back(arc.t_end);
    run->extremum_y.push_back(arcs.y(arc.t_end));
    const double balance = CalcEnergy(oscillator, StateAt(arcs, sliders, arc.t_end)) +
                           CalcDissipation(oscillator, arcs, arc.t_end) - start;
    if (start > 0) run->energy_error = std::max(run->energy_error, std::abs(balance) / start);
  }
}

/// The last swing: free for ever once no arc of a whole cycle has a sliding joint.
void DescribeEnd(const Trajectory<double>& arcs, DryFrictionRun* run) {
  const Arc<double>& last = arcs.arcs().back();
  run->frequency = last.w / (2 * std::numbers::pi);
  run->amplitude = std::hypot(last.a, last.b);
  run->offset = last.c;
  const double cycle = 2 * std::numbers::pi / last.w;
  run->locked = last.sliding == 0 && run->t.back() >= cycle;
  for (auto arc = arcs.arcs().rbegin(); arc != arcs.arcs().rend() && arc->t_end > run->t.back() - cycle; ++arc)
    run->locked = run->locked && arc->sliding == 0;
}

}  // namespace

DryFrictionRun RunDryFriction(const DryFrictionOptions& options) {
  CheckPositive("RunDryFriction", "element.k", options.element.k, "1/m");
  CheckPositive("RunDryFriction", "g", options.g, "m/s^2");
  if (!std::isfinite(options.pull)) throw std::invalid_argument("RunDryFriction: pull must be a finite number [m]");
  if (!options.element.effects.empty())
    throw std::invalid_argument("RunDryFriction: element has effects, must be the plain dry-friction element");
  const std::size_t samples = CountSamples("RunDryFriction", options.duration, options.step);
  const Oscillator<double> oscillator = MakeOscillator(options.element, options.g);
  Trajectory<double> arcs;
  if (Solve(oscillator, PulledOut(oscillator, options.pull), options.duration, &arcs) != SolveStatus::kOk)
    throw std::invalid_argument("RunDryFriction: the event solver gave up; k_i and T0i must be finite and >= 0");
  DryFrictionRun run{.options = options, .t = {}, .y = {}, .v = {}, .T = {}, .extremum_t = {}, .extremum_y = {}};
  run.T.resize(oscillator.sliders().size());
  for (std::size_t i = 0; i < samples; ++i) {
    const double t = static_cast<double>(i) * options.step;
    run.t.push_back(t);
    run.y.push_back(arcs.y(t));
    run.v.push_back(arcs.v(t));
    for (std::size_t j = 0; j < run.T.size(); ++j) run.T[j].push_back(arcs.T(j, t));
  }
  CollectSwings(oscillator, arcs, &run);
  DescribeEnd(arcs, &run);
  return run;
}

}  // namespace uiclink
