#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "identify/record.h"
#include "model/closed_form.h"
#include "model/event_solver.h"

namespace uiclink {

/// A ring-down as the experiment makes it: rest, push at resonance, release on the way to an extremum, free decay.
struct PushedRecord {
  Oscillator<double> link;
  double rest_s = 0.4;
  double push = 0.03;          ///< strength P of the push per unit load: P v / hypot(v, w y)
  int half_swings = 5;         ///< the push ends on the way to this extremum
  double release_phase = 0.8;  ///< ... at atan2(w |y|, |v|) = pi/2 - release_phase [rad]
  double late_push = 0;        ///< strength of a push that goes on over one half swing more
  double side = 1;             ///< of the first push
  double duration_s = 15;
  double rate_hz = 200;
  double zero = 0;     ///< reading at y = 0 [m]
  double drift = 0;    ///< of the zero [m/s]
  double noise = 0;    ///< standard deviation [m]
  double quantum = 0;  ///< step of the readings [m]
  double range = 1;    ///< readings are cut at +- this [m]
  unsigned seed = 1;
};

/// A record and what it was made from.
struct SimulatedRecord {
  Record record;
  double release_s = 0;
  std::vector<double> extremum_t;  ///< of the free decay [s]
  std::vector<double> extremum_y;  ///< true displacements [m]
  double noise = 0;                ///< of the readings, quantisation included [m]
};

namespace internal {

/// State of a run at time t.
inline State<double> StateAt(const Trajectory<double>& run, int sliders, double t) {
  State<double> state{.y = run.y(t), .v = run.v(t)};
  for (int i = 0; i < sliders; ++i) {
    const std::size_t j = static_cast<std::size_t>(i);
    state.T[j] = run.T(j, t);
  }
  return state;
}

/// Moves on by h under a constant force F: the solver's own motion about F/k, exact for that force.
inline State<double> StepUnderForce(const Oscillator<double>& link, State<double> state, double F, double h) {
  static thread_local Trajectory<double> run;
  state.y -= F / link.k;
  Solve(link, state, h, &run);
  State<double> next = StateAt(run, link.size(), h);
  for (int i = 0; i < link.size(); ++i) {
    const std::size_t j = static_cast<std::size_t>(i);
    const double limit = link.sliders()[j].T0;
    next.T[j] = std::clamp(next.T[j], -limit, limit);
  }
  next.y += F / link.k;
  return next;
}

}  // namespace internal

/// Adds noise, steps and range to true displacements; reading = y + zero + drift t.
inline Record Measure(const PushedRecord& setup, std::span<const double> y) {
  std::mt19937_64 random(setup.seed);
  std::normal_distribution<double> normal;
  Record record;
  record.g = setup.link.g;
  record.sampling_hz = setup.rate_hz;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double t = static_cast<double>(i) / setup.rate_hz;
    double reading = y[i] + setup.zero + setup.drift * t + setup.noise * normal(random);
    reading = std::clamp(reading, -setup.range, setup.range);
    if (setup.quantum > 0) reading = setup.quantum * std::round(reading / setup.quantum);
    record.t.push_back(t);
    record.y.push_back(reading);
  }
  return record;
}

/// Simulates the whole record: the push in pieces of a quarter millisecond of constant force, the rest exactly.
inline SimulatedRecord Simulate(const PushedRecord& setup) {
  constexpr double kPiece = 0.25e-3;
  SimulatedRecord out;
  const std::size_t n = static_cast<std::size_t>(std::lround(setup.duration_s * setup.rate_hz)) + 1;
  std::vector<double> y(n, 0.0);
  const double w = CalcRollingFrequency(setup.link);
  State<double> state;
  double t = setup.rest_s;
  std::size_t i = static_cast<std::size_t>(std::ceil(t * setup.rate_hz - 1e-9));
  double before = 0;
  for (int swings = 0; setup.half_swings > 0;) {
    const double speed = std::hypot(state.v, w * state.y);
    const double phase = std::atan2(w * std::abs(state.y), std::abs(state.v));  // pi/2 at the extremum
    const bool outward = state.v * state.y > 0;
    const int last = setup.half_swings - (setup.late_push > 0 ? 0 : 1);
    if (swings == last && outward && phase >= std::numbers::pi / 2 - setup.release_phase) break;
    const double push = swings < setup.half_swings ? setup.push : setup.late_push;
    const double F = push * (speed > 0 ? state.v / speed : setup.side);
    before = state.v;
    const double y_before = state.y;
    state = internal::StepUnderForce(setup.link, state, F, kPiece);
    if (before * state.v < 0) ++swings;
    const double t_next = t + kPiece;
    for (; i < n && static_cast<double>(i) / setup.rate_hz <= t_next; ++i)
      y[i] = y_before + (state.y - y_before) * (static_cast<double>(i) / setup.rate_hz - t) / kPiece;
    t = t_next;
  }
  out.release_s = t;
  Trajectory<double> run;
  Solve(setup.link, state, setup.duration_s - t, &run);
  for (; i < n; ++i) y[i] = run.y(static_cast<double>(i) / setup.rate_hz - t);
  const auto add = [&](double s) {
    out.extremum_t.push_back(t + s);
    out.extremum_y.push_back(run.y(s));
  };
  for (const Arc<double>& arc : run.arcs()) {
    if (arc.end == EventKind::kTurning) add(arc.t_end);
    if (arc.end != EventKind::kEnd) continue;
    // The last arc may roll for ever: the turning points of its sine.
    const double half = std::numbers::pi / arc.w, phase = std::atan2(arc.b, arc.a) / arc.w;
    for (double s = phase - half; arc.t_start + s < arc.t_end; s += half)
      if (s > 0.1 * half) add(arc.t_start + s);
  }
  out.record = Measure(setup, y);
  out.noise = std::hypot(setup.noise, setup.quantum / std::sqrt(12.0));
  return out;
}

}  // namespace uiclink
