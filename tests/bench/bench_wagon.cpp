// The wagon in motion: what a second of hunting costs, and against CVODE's BDF on the same model.
//
// Set 1, empty, 20 m/s. "smooth": knife-edge rails, wheels with a flange (tests/support/wagon_fixture.h), settled
// hunting with flange contact and guidance impacts. "thesis-equivalent": S1002 on UIC60, contact that jumps.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>

#include "tests/support/wagon_fixture.h"
#include "tests/support/wagon_implicit.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"

namespace uiclink {
namespace {

constexpr double kSpeed = 20;
constexpr double kSeconds = 3;

struct Case {
  Wagon wagon;
  WagonState state;  ///< settled
  WagonState exact;  ///< kSeconds later, tolerance a hundredth of the usual one
  double amplitude = 0;

  explicit Case(const Wagon& made) : wagon(made) {
    SimulationOptions options;
    options.duration = 40;
    const WagonState start =
        Perturb(wagon, FindEquilibrium(wagon, kSpeed), {.front_y = 4e-3, .rear_y = 4e-3, .body_y = 15e-3});
    const SimulationResult settled = Simulate(wagon, kSpeed, start, options);
    state = settled.state;
    amplitude = settled.motions[0].amplitude;
    IntegratorOptions tight;
    tight.tolerance *= 1e-2;
    exact = Run(tight).first;
  }

  std::pair<WagonState, IntegratorCounts> Run(const IntegratorOptions& options) const {
    Integrator integrator(wagon, options);
    integrator.Start(kSpeed, state);
    const double t = state.t + kSeconds;
    while (integrator.state().t < t) integrator.Step(t);
    return {integrator.state(), integrator.counts()};
  }
  double Error(const WagonState& end) const {
    double error = 0;
    for (std::size_t i : {wheelset::kY + 0, kRearWheelset + wheelset::kY, kBody + body::kY})
      error = std::max(error, std::abs(end.x[i] - exact.x[i]));
    return error / amplitude;
  }
};

const Case& Smooth() {
  static const Case one(WagonFixture{}.Make());
  return one;
}
const Case& Jumping() {
  static const Case one(WagonFixture{}.MakeOn("thesis-equivalent"));
  return one;
}

void BM_RightHandSide(benchmark::State& bench) {
  const Case& c = Smooth();
  StateVector<double> x = c.state.x, rate;
  std::size_t i = 0;
  for (auto _ : bench) {
    x[wheelset::kY] = 1e-6 * static_cast<double>(++i % 4000);
    CalcRate(c.wagon, kSpeed, c.state.links, x, &rate);
    benchmark::DoNotOptimize(rate);
  }
  bench.SetItemsProcessed(bench.iterations());
}
BENCHMARK(BM_RightHandSide);

void Hunting(benchmark::State& bench, const Case& c, const std::string& method, double tolerance) {
  IntegratorOptions options;
  options.method = method;
  if (tolerance > 0) options.tolerance = tolerance;
  std::pair<WagonState, IntegratorCounts> end;
  const std::clock_t begin = std::clock();
  for (auto _ : bench) end = c.Run(options);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  bench.counters["times_real_time"] = kSeconds * static_cast<double>(bench.iterations()) / cpu;
  bench.counters["error_of_amplitude"] = c.Error(end.first);
  bench.counters["rhs_per_s_of_wagon"] = static_cast<double>(end.second.rhs_calls) / kSeconds;
  bench.counters["ns_per_rhs"] =
      1e9 * cpu / static_cast<double>(bench.iterations()) / static_cast<double>(end.second.rhs_calls);
  bench.counters["events_per_s"] = static_cast<double>(end.second.events) / kSeconds;
}
void BM_Smooth(benchmark::State& bench, const std::string& method, double tolerance) {
  Hunting(bench, Smooth(), method, tolerance);
}
void BM_Jumping(benchmark::State& bench, const std::string& method, double tolerance) {
  Hunting(bench, Jumping(), method, tolerance);
}
BENCHMARK_CAPTURE(BM_Smooth, default, "", 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Smooth, tolerance_1e_6, "", 1e-6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Smooth, eight_stages_1e_6, "UICLINK_STABLE_8_3_4", 1e-6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Smooth, bogacki_shampine_1e_6, "ARKODE_BOGACKI_SHAMPINE_4_2_3", 1e-6)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Smooth, dormand_prince_1e_7, "ARKODE_DORMAND_PRINCE_7_4_5", 1e-7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Jumping, default, "", 0)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Jumping, tolerance_1e_6, "", 1e-6)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Jumping, dormand_prince_1e_8, "ARKODE_DORMAND_PRINCE_7_4_5", 1e-8)->Unit(benchmark::kMillisecond);

/// The same three seconds through CVODE, dense Jacobian by differences or exact.
void BM_Bdf(benchmark::State& bench, JacobianKind jacobian, double rtol) {
  const Case& c = Smooth();
  WagonState end;
  ImplicitCounts counts;
  const std::clock_t begin = std::clock();
  for (auto _ : bench)
    end = RunImplicit(c.wagon, kSpeed, c.state, c.state.t + kSeconds,
                      {.rtol = rtol, .atol = 1e-2 * rtol, .jacobian = jacobian}, &counts);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  bench.counters["times_real_time"] = kSeconds * static_cast<double>(bench.iterations()) / cpu;
  bench.counters["error_of_amplitude"] = c.Error(end);
  bench.counters["rhs_per_s_of_wagon"] = static_cast<double>(counts.rhs_calls) / kSeconds;
  bench.counters["steps_per_s"] = static_cast<double>(counts.steps) / kSeconds;
}
BENCHMARK_CAPTURE(BM_Bdf, differences_1e_7, JacobianKind::kDifferences, 1e-7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Bdf, differences_1e_9, JacobianKind::kDifferences, 1e-9)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Bdf, exact_1e_7, JacobianKind::kExact, 1e-7)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Bdf, exact_1e_9, JacobianKind::kExact, 1e-9)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace uiclink

BENCHMARK_MAIN();
