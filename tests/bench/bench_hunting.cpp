// What the derivatives of a period of hunting cost beside the period itself: set 1, empty, 24 m/s, elastic contact of
// S1002 on UIC60 and parabolic springs, or leaf springs; guidance impacts. Processor time.

#include <benchmark/benchmark.h>

#include <ctime>
#include <stdexcept>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/wagon_flow.h"
#include "vehicle/rate_slopes.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

constexpr double kSpeed = 24;

struct Case {
  Wagon wagon;
  WagonFlow flow;
  WagonFlow::Guess guess;

  explicit Case(Suspension suspension) : wagon(MakeWagon(suspension)), flow(FamilyBySpeed(wagon), kSpeed) {
    const WagonState start = Perturb(wagon, FindEquilibrium(wagon, kSpeed), {.front_y = 5e-3, .rear_y = 5e-3});
    const auto found = flow.GuessCycle(start, kSpeed, 20);
    if (!found) throw std::runtime_error("the wagon does not hunt");
    guess = *found;
  }
  static Wagon MakeWagon(Suspension suspension) {
    WagonFixture fixture;
    fixture.options.suspension = suspension;
    return fixture.MakeOn("thesis-equivalent");
  }
  /// Processor time of so many passages, each [s].
  double Time(Flow::Derivatives wanted, int times) {
    const std::clock_t begin = std::clock();
    for (int i = 0; i < times; ++i) flow.Pass(guess.state, guess.period, kSpeed, wanted);
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / times;
  }
};

void BM_Passage(benchmark::State& bench, Suspension suspension, Flow::Derivatives wanted) {
  Case one(suspension);
  for (auto _ : bench) benchmark::DoNotOptimize(one.flow.Pass(one.guess.state, one.guess.period, kSpeed, wanted));
  bench.counters["period_s"] = one.guess.period;
  if (wanted == Flow::Derivatives::kNone) return;
  bench.counters["times_without"] = one.Time(wanted, 4) / one.Time(Flow::Derivatives::kNone, 8);
}
using enum Flow::Derivatives;
BENCHMARK_CAPTURE(BM_Passage, parabolic, Suspension::kParabolic, kNone)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Passage, parabolic_with_derivatives, Suspension::kParabolic, kAll)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Passage, leaf, Suspension::kLeaf, kNone)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Passage, leaf_with_derivatives, Suspension::kLeaf, kAll)->Unit(benchmark::kMillisecond);

void BM_RateSlopes(benchmark::State& bench) {
  Case one(Suspension::kParabolic);
  WagonState state = one.flow.ToWagonState(one.guess.state, kSpeed);
  RateSlopes slopes;
  for (auto _ : bench) {
    state.x[wheelset::kY] += 1e-9;
    CalcRateSlopes(one.wagon, kSpeed, state.links, state.x, &slopes);
    benchmark::DoNotOptimize(slopes);
  }
}
BENCHMARK(BM_RateSlopes);

/// The same by a scalar with 34 derivatives.
void BM_RateOfDuals(benchmark::State& bench) {
  Case one(Suspension::kParabolic);
  WagonState state = one.flow.ToWagonState(one.guess.state, kSpeed);
  StateVector<Dual<kMaxState>> x, rate;
  for (auto _ : bench) {
    state.x[wheelset::kY] += 1e-9;
    for (std::size_t i = 0; i < kMaxState; ++i) x[i] = Dual<kMaxState>(state.x[i], static_cast<int>(i));
    CalcRate(one.wagon, kSpeed, state.links, x, &rate);
    benchmark::DoNotOptimize(rate);
  }
}
BENCHMARK(BM_RateOfDuals);

}  // namespace
}  // namespace uiclink

BENCHMARK_MAIN();
