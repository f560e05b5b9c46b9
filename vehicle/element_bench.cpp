#include "vehicle/element_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <stdexcept>

#include "vehicle/bench_check.h"
#include "vehicle/event_ode.h"

namespace uiclink {
namespace {

/// Where a force path reversed last.
struct Reversal {
  double s = 0;
  double F = 0;
};

Reversal Travel(const LeafSpring& spring, const Reversal& from, double s) {
  return {.s = s, .F = CalcLeafForce(spring, from.s, from.F, s)};
}

/// Work on the spring along the whole cycle that starts and ends at the upper reversal [J].
double CalcCycleWork(const LeafSpring& spring, const Reversal& top, double low) {
  const Reversal bottom = Travel(spring, top, low);
  return CalcLeafWork(spring, top.s, top.F, low) + CalcLeafWork(spring, bottom.s, bottom.F, top.s);
}

}  // namespace

// --- leaf spring, harmonic ---

double CalcLeafLoopLoss(const LeafSpring& spring, double mean, double a) {
  // The force after a cycle is affine in the force before it, with slope exp(-4 a / beta): two trials give the cycle
  // that repeats itself.
  const double high = mean + a, low = mean - a;
  const auto after_cycle = [&](double F) { return Travel(spring, Travel(spring, {high, F}, low), high).F; };
  const double slope = std::exp(-4 * a / spring.beta);
  const double F = after_cycle(0) / (1 - slope);
  return CalcCycleWork(spring, {high, F}, low);
}

LeafHarmonicRun RunLeafHarmonic(const LeafHarmonicOptions& options) {
  CheckLeaf("RunLeafHarmonic", options.spring);
  CheckPositive("RunLeafHarmonic", "amplitude", options.amplitude, "m");
  CheckAtLeast("RunLeafHarmonic", "cycles", options.cycles, 1);
  CheckAtLeast("RunLeafHarmonic", "samples", options.samples, 4);
  LeafHarmonicRun run{.options = options, .phase = {}, .s = {}, .F = {}};
  const double a = options.amplitude;
  Reversal last{.s = options.mean, .F = 0};
  int half_cycles = 0;  // reversals passed: at phase pi/2 (upper), 3 pi/2 (lower), ...
  const int total = options.cycles * options.samples;
  for (int i = 0; i <= total; ++i) {
    const double phase = 2 * std::numbers::pi * i / options.samples;
    while (phase > (half_cycles + 0.5) * std::numbers::pi) {
      last = Travel(options.spring, last, options.mean + (half_cycles % 2 == 0 ? a : -a));
      ++half_cycles;
    }
    run.phase.push_back(phase);
    run.s.push_back(options.mean + a * std::sin(phase));
    run.F.push_back(CalcLeafForce(options.spring, last.s, last.F, run.s.back()));
  }
  // `last` is the lower reversal of the last cycle; the cycle that ends there begins one earlier.
  Reversal top{.s = options.mean, .F = 0};
  top = Travel(options.spring, top, options.mean + a);
  for (int i = 1; i < options.cycles; ++i)
    top = Travel(options.spring, Travel(options.spring, top, options.mean - a), options.mean + a);
  run.loss = CalcCycleWork(options.spring, top, options.mean - a);
  run.steady_loss = CalcLeafLoopLoss(options.spring, options.mean, a);
  run.envelope_loss = 4 * a * (options.spring.F_r + options.spring.mu0 * options.spring.c * options.mean);
  return run;
}

// --- leaf spring, drop ---

namespace {

enum Drop : std::size_t { kS, kV, kF, kLinearS, kLinearV, kDropSize };

/// The falling load with the direction of motion, and the energy balance from reversal to reversal.
class FallingLoad {
 public:
  FallingLoad(const LeafDropOptions& options, LeafDropRun* run) : options_(options), run_(*run) {}

  EventOde MakeOde() {
    return {.size = kDropSize,
            .guards = 1,
            .rate = [this](double, std::span<const double> y, std::span<double> f) { CalcRates(y, f); },
            .guard = [](double, std::span<const double> y, std::span<double> guards) { guards[0] = y[kV]; },
            .pass = [this](double, std::span<double> y, std::span<const int> crossed) { Reverse(y, crossed[0]); }};
  }

 private:
  void CalcRates(std::span<const double> y, std::span<double> f) const {
    f[kS] = y[kV];
    f[kV] = options_.g - y[kF] / options_.m;
    f[kF] = CalcLeafRate(options_.spring, loading_, y[kF], y[kS], y[kV]);
    f[kLinearS] = y[kLinearV];
    f[kLinearV] = options_.g - CalcSpringForce(options_.linear, y[kLinearS], y[kLinearV]) / options_.m;
  }

  void Reverse(std::span<double> y, int direction) {
    if ((direction > 0) == loading_) return;  // the same crossing, seen again after the restart
    work_ += CalcLeafWork(options_.spring, last_.s, last_.F, y[kS]);
    const double weight = options_.m * options_.g;
    const double balance = 0.5 * options_.m * y[kV] * y[kV] - weight * y[kS] + work_;
    run_.energy_error = std::max(run_.energy_error, std::abs(balance) / (weight * run_.rest));
    run_.largest = std::max(run_.largest, y[kS]);
    ++run_.reversals;
    last_ = {.s = y[kS], .F = y[kF]};
    loading_ = direction > 0;
  }

  const LeafDropOptions& options_;
  LeafDropRun& run_;
  bool loading_ = true;
  Reversal last_;
  double work_ = 0;
};

int CountCrossings(const std::vector<double>& s, double level) {
  int crossings = 0;
  for (std::size_t i = 1; i < s.size(); ++i) crossings += (s[i - 1] < level) != (s[i] < level);
  return crossings;
}

void SummariseDrop(LeafDropRun* run) {
  const std::size_t from = run->s.size() - std::max<std::size_t>(1, run->s.size() / 10);
  const auto [low, high] = std::minmax_element(run->s.begin() + static_cast<std::ptrdiff_t>(from), run->s.end());
  run->settled_within = std::max(std::abs(*low - run->rest), std::abs(*high - run->rest));
  run->swing = *high - *low;
  for (const double s : run->s) run->largest = std::max(run->largest, s);
  run->rest_crossings = CountCrossings(run->s, run->rest);
  run->rest_crossings_linear =
      CountCrossings(run->s_linear, CalcStaticCompression(run->options.linear, run->options.m * run->options.g));
}

}  // namespace

LeafDropRun RunLeafDrop(const LeafDropOptions& options) {
  CheckLeaf("RunLeafDrop", options.spring);
  CheckPositive("RunLeafDrop", "m", options.m, "kg");
  CheckPositive("RunLeafDrop", "g", options.g, "m/s^2");
  CheckPositive("RunLeafDrop", "linear.k", options.linear.k, "N/m");
  CheckPositive("RunLeafDrop", "rtol", options.rtol, "-");
  const std::size_t samples = CountSamples("RunLeafDrop", options.duration, options.step);
  LeafDropRun run{.options = options, .t = {}, .s = {}, .v = {}, .F = {}, .s_linear = {}};
  run.rest = CalcStaticCompression(options.spring, options.m * options.g);
  FallingLoad load(options, &run);
  // Absolute tolerances: the relative one of the natural scales of a fall, m g / c, sqrt(g m g / c) and m g.
  const double scale_s = options.rtol * run.rest, scale_v = options.rtol * std::sqrt(options.g * run.rest);
  const EventOdeOptions ode_options{.rtol = options.rtol,
                                    .atol = {scale_s, scale_v, options.rtol * options.m * options.g, scale_s, scale_v},
                                    .max_step = options.step};
  const std::array<double, kDropSize> start{};
  const EventOdeCounts counts = SolveEventOde(
      load.MakeOde(), start, options.step, samples,
      [&](std::size_t, double t, std::span<const double> y) {
        run.t.push_back(t);
        run.s.push_back(y[kS]);
        run.v.push_back(y[kV]);
        run.F.push_back(y[kF]);
        run.s_linear.push_back(y[kLinearS]);
      },
      ode_options);
  run.steps = counts.steps;
  SummariseDrop(&run);
  return run;
}

// --- parabolic spring, harmonic ---

ParabolicLoopRun RunParabolicLoop(const ParabolicLoopOptions& options) {
  CheckPositive("RunParabolicLoop", "m", options.m, "kg");
  CheckPositive("RunParabolicLoop", "g", options.g, "m/s^2");
  CheckPositive("RunParabolicLoop", "mu", options.mu, "-");
  CheckPositive("RunParabolicLoop", "frequency", options.frequency, "Hz");
  CheckPositive("RunParabolicLoop", "spring.F0", options.spring.F0, "N");
  CheckPositive("RunParabolicLoop", "spring.s0", options.spring.s0, "m");
  CheckPositive("RunParabolicLoop", "spring.k2", options.spring.k2, "N/m");
  CheckAtLeast("RunParabolicLoop", "samples", options.samples, 4);
  ParabolicLoopRun run{.options = options, .s = {}, .F = {}, .F_static = {}};
  const double weight = options.m * options.g, w = 2 * std::numbers::pi * options.frequency;
  run.static_compression = CalcStaticCompression(options.spring, weight);
  run.amplitude = run.static_compression / 2;
  run.friction_work = CalcFrictionWork(options.mu, weight, run.amplitude);
  run.damping = CalcEquivalentDamping(options.mu, weight, run.amplitude, w);
  run.damping_of_file = DampingOf(options.spring, weight);
  run.loop_loss_of_file = std::numbers::pi * run.damping_of_file * w * run.amplitude * run.amplitude;
  for (int i = 0; i <= options.samples; ++i) {
    const double phase = 2 * std::numbers::pi * i / options.samples;
    const double s = run.static_compression + run.amplitude * std::sin(phase);
    const double v = run.amplitude * w * std::cos(phase);
    run.s.push_back(s);
    run.F.push_back(CalcSpringForce(options.spring, run.damping, s, v));
    run.F_static.push_back(CalcStaticForce(options.spring, s));
  }
  for (std::size_t i = 0; i + 1 < run.s.size(); ++i)
    run.loop_loss += 0.5 * (run.F[i] + run.F[i + 1]) * (run.s[i + 1] - run.s[i]);
  return run;
}

}  // namespace uiclink
