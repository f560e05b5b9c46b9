#include <algorithm>
#include <cmath>
#include <cstdint>

#include "vehicle/bench_check.h"
#include "vehicle/element_bench.h"
#include "vehicle/event_ode.h"

namespace uiclink {
namespace {

WheelsetPosition<double> PositionOf(std::span<const double> y) { return {.x = y[0], .y = y[2], .psi = y[4]}; }

double CalcEnergy(const WheelsetBetweenGuides& w, std::span<const double> y) {
  const WheelsetPosition<double> at = PositionOf(y);
  return 0.5 * w.m * (y[1] * y[1] + y[3] * y[3]) + 0.5 * w.I_z * y[5] * y[5] +
         CalcGuideEnergy(w, FindGuideContacts(w, at), at);
}

/// The wheelset with the contacts that it has.
class Impacts {
 public:
  Impacts(const WheelsetBetweenGuides& wheelset, const GuidanceState& start, GuidanceRun* run)
      : w_(wheelset), run_(*run), contacts_(FindGuideContacts(wheelset, PositionOf(start))) {}

  EventOde MakeOde() {
    return {.size = std::tuple_size_v<GuidanceState>,
            .guards = kGuideContacts,
            .rate = [this](double, std::span<const double> y, std::span<double> f) { CalcRates(y, f); },
            .guard =
                [this](double, std::span<const double> y, std::span<double> guards) {
                  std::ranges::copy(CalcPenetrations(w_, PositionOf(y)), guards.begin());
                },
            .pass = [this](double, std::span<double>, std::span<const int> crossed) { Touch(crossed); }};
  }

 private:
  void CalcRates(std::span<const double> y, std::span<double> f) const {
    const GuideForce<double> force = CalcGuideForce(w_, contacts_, PositionOf(y));
    f[0] = y[1];
    f[1] = force.x / w_.m;
    f[2] = y[3];
    f[3] = force.y / w_.m;
    f[4] = y[5];
    f[5] = force.psi / w_.I_z;
  }

  /// The direction of the crossing decides, so that a crossing seen twice changes nothing.
  void Touch(std::span<const int> crossed) {
    for (std::size_t i = 0; i < kGuideContacts; ++i) {
      const GuideContacts bit = GuideContacts{1} << i;
      if (crossed[i] > 0 && !(contacts_ & bit)) {
        contacts_ |= bit;
        ++(i < 4 ? run_.impacts_longitudinal : run_.impacts_lateral);
      } else if (crossed[i] < 0) {
        contacts_ &= ~bit;
      }
    }
  }

  const WheelsetBetweenGuides& w_;
  GuidanceRun& run_;
  GuideContacts contacts_;
};

/// Slope of log(size) over t by least squares.
double FitGrowth(const std::vector<double>& t, const std::vector<double>& size) {
  double n = 0, mean_t = 0, mean_l = 0, tt = 0, tl = 0;
  for (std::size_t i = 0; i < size.size(); ++i) {
    if (!(size[i] > 0)) continue;
    const double l = std::log(size[i]);
    n += 1;
    const double dt = t[i] - mean_t;
    mean_t += dt / n;
    mean_l += (l - mean_l) / n;
    tt += dt * (t[i] - mean_t);
    tl += dt * (l - mean_l);
  }
  return tt > 0 ? tl / tt : 0;
}

void Compare(GuidanceBenchRun* run) {
  const WheelsetBetweenGuides& w = run->options.wheelset;
  const std::array<double, 3> scale{w.b, w.c, w.b / w.a};
  std::array<double, 3> largest{}, square{}, square_plain{};
  std::vector<double> times, sizes;
  bool small = true;
  const std::size_t n = run->t.size(), tail = n - std::max<std::size_t>(1, n / 5);
  for (std::size_t i = 0; i < n; ++i) {
    double size = 0;
    for (std::size_t j = 0; j < 3; ++j) {
      const double plain = run->plain.states[i][2 * j];
      const double difference = run->perturbed.states[i][2 * j] - plain;
      largest[j] = std::max(largest[j], std::abs(difference));
      run->largest_difference[j].push_back(largest[j]);
      size = std::max(size, std::abs(difference) / scale[j]);
      if (i >= tail) {
        square[j] += difference * difference;
        square_plain[j] += plain * plain;
      }
    }
    small = small && size < 0.1;
    if (!small) continue;
    times.push_back(run->t[i]);
    sizes.push_back(size);
    run->growth_until = run->t[i];
  }
  for (std::size_t j = 0; j < 3; ++j)
    run->relative_difference[j] = square_plain[j] > 0 ? std::sqrt(square[j] / square_plain[j]) : 0;
  run->growth_rate = FitGrowth(times, sizes);
}

}  // namespace

WheelsetBetweenGuides Table61() {
  return {.m = 1022, .I_z = 678, .a = 1.074, .b = 0.5, .c = 0.2, .k_x = 1e11, .k_y = 1.5e6};
}

WheelsetBetweenGuides TrueClearances() {
  WheelsetBetweenGuides wheelset = Table61();
  wheelset.b = 0.0225;
  wheelset.c = 0.020;
  return wheelset;
}

GuidanceRun RunGuidance(const WheelsetBetweenGuides& wheelset, const GuidanceState& start, double duration, double step,
                        double rtol) {
  CheckPositive("RunGuidance", "wheelset.m", wheelset.m, "kg");
  CheckPositive("RunGuidance", "wheelset.I_z", wheelset.I_z, "kg m^2");
  CheckPositive("RunGuidance", "wheelset.a", wheelset.a, "m");
  CheckPositive("RunGuidance", "wheelset.b", wheelset.b, "m");
  CheckPositive("RunGuidance", "wheelset.c", wheelset.c, "m");
  CheckPositive("RunGuidance", "wheelset.k_x", wheelset.k_x, "N/m");
  CheckPositive("RunGuidance", "wheelset.k_y", wheelset.k_y, "N/m");
  CheckPositive("RunGuidance", "rtol", rtol, "-");
  const std::size_t samples = CountSamples("RunGuidance", duration, step);
  GuidanceRun run;
  Impacts impacts(wheelset, start, &run);
  run.energy_start = CalcEnergy(wheelset, start);
  // A step must not jump over a contact: at the speed that all energy would give, it goes a twentieth of a clearance.
  const double fastest =
      std::sqrt(2 * run.energy_start / std::min(wheelset.m, wheelset.I_z / (wheelset.a * wheelset.a)));
  const double clearance = std::min(wheelset.b, wheelset.c);
  const EventOdeOptions options{
      .rtol = rtol, .atol = {rtol * clearance}, .max_step = fastest > 0 ? 0.05 * clearance / fastest : step};
  run.steps = SolveEventOde(
                  impacts.MakeOde(), start, step, samples,
                  [&](std::size_t, double, std::span<const double> y) {
                    run.states.emplace_back();
                    std::ranges::copy(y, run.states.back().begin());
                    const double error = std::abs(CalcEnergy(wheelset, y) - run.energy_start);
                    if (run.energy_start > 0) run.energy_error = std::max(run.energy_error, error / run.energy_start);
                  },
                  options)
                  .steps;
  return run;
}

GuidanceBenchRun RunGuidanceBench(const GuidanceBenchOptions& options) {
  GuidanceBenchRun run{.options = options, .t = {}, .plain = {}, .perturbed = {}, .largest_difference = {}};
  GuidanceState perturbed = options.start;
  for (std::size_t i = 0; i < perturbed.size(); ++i) perturbed[i] += options.perturbation[i];
  run.plain = RunGuidance(options.wheelset, options.start, options.duration, options.step, options.rtol);
  run.perturbed = RunGuidance(options.wheelset, perturbed, options.duration, options.step, options.rtol);
  for (std::size_t i = 0; i < run.plain.states.size(); ++i) run.t.push_back(static_cast<double>(i) * options.step);
  Compare(&run);
  return run;
}

}  // namespace uiclink
