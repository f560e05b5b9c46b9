// The wagon in motion: what a second of hunting costs, and against CVODE's BDF on the same model.
//
// Set 1, empty, 20 m/s, settled hunting, with guidance impacts but on "rigid". "smooth": knife-edge rails, wheels with
// a flange (tests/support/wagon_fixture.h). "rigid", "elastic": the geometries thesis-equivalent-rigid (S1002 on UIC60,
// whose contact jumps) and thesis-equivalent (elastic contact, which does not). Processor time; errors are the largest
// difference of the lateral motions, at 300 moments, from the run whose tolerance is a hundredth of the default one.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/support/wagon_fixture.h"
#include "tests/support/wagon_implicit.h"
#include "vehicle/equilibrium.h"
#include "vehicle/four_integrators.h"
#include "vehicle/side_by_side.h"
#include "vehicle/simulation.h"

namespace uiclink {
namespace {

constexpr double kSpeed = 20;
constexpr double kSeconds = 3;

/// Lateral motions of wheelsets and body 100 times a second.
using Trace = std::vector<std::array<double, 3>>;
std::array<double, 3> LateralMotions(const StateVector<double>& x) {
  return {x[wheelset::kY], x[kRearWheelset + wheelset::kY], x[kBody + body::kY]};
}
constexpr int kMoments = 300;

struct Case {
  Wagon wagon;
  WagonState state;  ///< settled
  Trace exact;       ///< tolerance a hundredth of the usual one
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
    Integrator integrator(wagon, tight);
    exact.reserve(kMoments);
    Run(integrator, &exact);
    std::printf("amplitude of the front wheelset %.3g mm, %d impacts of the rear one in the last 10 s\n",
                1e3 * amplitude, settled.lateral[1].impacts_in_window.count);
  }

  double Moment(int i) const { return state.t + kSeconds * i / kMoments; }
  /// @param trace  with memory for kMoments, or null.
  void Run(Integrator& integrator, Trace* trace) const {
    integrator.Start(kSpeed, state);
    int next = 1;
    while (next <= kMoments) {
      integrator.Step(Moment(kMoments));
      for (; next <= kMoments && Moment(next) <= integrator.state().t; ++next) {
        if (trace == nullptr) continue;
        StateVector<double> x;
        integrator.Interpolate(Moment(next), &x);
        trace->push_back(LateralMotions(x));
      }
    }
  }
  double ErrorAtEnd(const std::array<double, 3>& motions) const {
    double error = 0;
    for (std::size_t k = 0; k < 3; ++k) error = std::max(error, std::abs(motions[k] - exact.back()[k]));
    return error / amplitude;
  }
  /// Largest difference, of the amplitude.
  double Error(const Trace& trace) const {
    double error = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) error = std::max(error, std::abs(trace[i][k] - exact[i][k]));
    return error / amplitude;
  }
};

const Case& Smooth() {
  static const Case one(WagonFixture{}.Make());
  return one;
}
const Case& Rigid() {
  static const Case one(WagonFixture{}.MakeOn("thesis-equivalent-rigid"));
  return one;
}
const Case& Elastic() {
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

/// As the integrator calls it: with the forces, for wheel loads.
void BM_RightHandSideWithForces(benchmark::State& bench) {
  const Case& c = Smooth();
  StateVector<double> x = c.state.x, rate;
  WagonForces forces;
  std::size_t i = 0;
  for (auto _ : bench) {
    x[wheelset::kY] = 1e-6 * static_cast<double>(++i % 4000);
    CalcForces(c.wagon, kSpeed, c.state.links, x, &rate, &forces);
    benchmark::DoNotOptimize(rate);
    benchmark::DoNotOptimize(forces);
  }
  bench.SetItemsProcessed(bench.iterations());
}
BENCHMARK(BM_RightHandSideWithForces);

/// Four wagons in the lanes instead of four wheels; "time" is that of all four.
void BM_RightHandSideOfFour(benchmark::State& bench) {
  const Case& c = Smooth();
  FourWagons four;
  FourStates x, rates;
  FourWheelLoads loads;
  for (std::size_t lane = 0; lane < FourWagons::kWagons; ++lane) {
    four.SetWagon(lane, c.wagon, kSpeed);
    four.SetLinks(lane, c.state.links);
    for (std::size_t i = 0; i < kMaxState; ++i) x[i].Set(lane, c.state.x[i]);
  }
  std::size_t i = 0;
  for (auto _ : bench) {
    ++i;
    for (std::size_t lane = 0; lane < FourWagons::kWagons; ++lane)
      x[wheelset::kY].Set(lane, 1e-6 * static_cast<double>((i + 1000 * lane) % 4000));
    CalcRates(four, x, &rates, &loads);
    benchmark::DoNotOptimize(rates);
    benchmark::DoNotOptimize(loads);
  }
  bench.SetItemsProcessed(4 * bench.iterations());
}
BENCHMARK(BM_RightHandSideOfFour);

using GetCase = const Case& (*)();

void BM_Hunting(benchmark::State& bench, GetCase get, const std::string& method, double tolerance) {
  const Case& c = get();
  IntegratorOptions options;
  options.method = method;
  if (tolerance > 0) options.tolerance = tolerance;
  Integrator integrator(c.wagon, options);
  Trace trace;
  trace.reserve(kMoments);
  c.Run(integrator, &trace);
  const IntegratorCounts before = integrator.counts();
  const std::clock_t begin = std::clock();
  std::size_t allocated = 0;
  for (auto _ : bench) {
    const std::size_t already = CountAllocations();
    c.Run(integrator, nullptr);
    allocated += CountAllocations() - already;
  }
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const double seconds = kSeconds * static_cast<double>(bench.iterations());
  const auto calls = static_cast<double>(integrator.counts().rhs_calls - before.rhs_calls);
  bench.counters["times_real_time"] = seconds / cpu;
  bench.counters["error_of_amplitude"] = c.Error(trace);
  bench.counters["error_of_amplitude_at_end"] = c.ErrorAtEnd(trace.back());
  bench.counters["rhs_per_s_of_wagon"] = calls / seconds;
  bench.counters["rhs_per_s"] = calls / cpu;
  bench.counters["ns_per_rhs"] = 1e9 * cpu / calls;
  bench.counters["events_per_s"] = static_cast<double>(integrator.counts().events - before.events) / seconds;
  bench.counters["allocations"] = static_cast<double>(allocated);
}

/// Four wagons at 20 to 20.3 m/s from the same state, for three seconds: in the lanes side by side against one after
/// the other, in turn.
void BM_SideBySide(benchmark::State& bench, GetCase get) {
  constexpr std::size_t kWagons = FourIntegrators::kWagons;
  const Case& c = get();
  const auto speed = [](std::size_t i) { return kSpeed + 0.1 * static_cast<double>(i); };
  Integrator integrator(c.wagon);
  FourIntegrators four;
  std::array<double, kWagons> stop;
  stop.fill(c.Moment(kMoments));
  double one_by_one = 0, together = 0;
  std::size_t allocated = 0;
  for (auto _ : bench) {
    const std::clock_t begin = std::clock();
    for (std::size_t i = 0; i < kWagons; ++i) {
      integrator.Start(speed(i), c.state);
      while (integrator.Step(stop[i]) != Advance::kStopTime) {
      }
    }
    const std::clock_t middle = std::clock();
    const std::size_t already = CountAllocations();
    for (std::size_t i = 0; i < kWagons; ++i) four.Start(i, c.wagon, speed(i), c.state);
    for (std::size_t running = kWagons; running > 0;) {
      const FourIntegrators::Advances advances = four.Step(stop);
      for (std::size_t i = 0; i < kWagons; ++i) {
        if (advances[i] != Advance::kStopTime) continue;
        four.Stop(i);
        --running;
      }
    }
    allocated += CountAllocations() - already;
    one_by_one += static_cast<double>(middle - begin) / CLOCKS_PER_SEC;
    together += static_cast<double>(std::clock() - middle) / CLOCKS_PER_SEC;
  }
  const double seconds = kWagons * kSeconds * static_cast<double>(bench.iterations());
  bench.counters["times_real_time_one_by_one"] = seconds / one_by_one;
  bench.counters["times_real_time_side_by_side"] = seconds / together;
  bench.counters["ratio"] = one_by_one / together;
  bench.counters["error_of_amplitude_at_end"] = c.ErrorAtEnd(LateralMotions(four.state(0).x));
  bench.counters["allocations"] = static_cast<double>(allocated);
}

/// As a sweep has them: sixteen runs of ten seconds from 18 to 25.5 m/s, with their figures, through lanes that are
/// filled again, against one after the other.
void BM_SweepLike(benchmark::State& bench, GetCase get) {
  constexpr std::size_t kRuns = 16;
  const Case& c = get();
  std::vector<SimulationTask> tasks(kRuns);
  for (std::size_t i = 0; i < kRuns; ++i) {
    tasks[i].wagon = std::shared_ptr<const Wagon>(std::shared_ptr<void>(), &c.wagon);
    tasks[i].V = 18 + 0.5 * static_cast<double>(i);
    tasks[i].start = c.state;
    tasks[i].options.duration = 10;
    tasks[i].options.end_at_wheel_lift = false;
  }
  double one_by_one = 0, together = 0, difference = 0;
  int impacts = 0;
  for (auto _ : bench) {
    const std::clock_t begin = std::clock();
    std::vector<SimulationResult> ones;
    for (const SimulationTask& task : tasks) ones.push_back(Simulate(*task.wagon, task.V, task.start, task.options));
    const std::clock_t middle = std::clock();
    const std::vector<SimulationResult> lanes = SimulateSideBySide(tasks);
    one_by_one += static_cast<double>(middle - begin) / CLOCKS_PER_SEC;
    together += static_cast<double>(std::clock() - middle) / CLOCKS_PER_SEC;
    for (std::size_t i = 0; i < kRuns; ++i) {
      const double one = ones[i].motions[0].amplitude;
      difference = std::max(difference, std::abs(lanes[i].motions[0].amplitude - one) / c.amplitude);
      impacts += std::abs(lanes[i].lateral[1].impacts.count - ones[i].lateral[1].impacts.count);
    }
  }
  const double runs = kRuns * static_cast<double>(bench.iterations());
  bench.counters["runs_per_s_one_by_one"] = runs / one_by_one;
  bench.counters["runs_per_s_side_by_side"] = runs / together;
  bench.counters["ratio"] = one_by_one / together;
  bench.counters["difference_of_amplitudes"] = difference;
  bench.counters["difference_of_impacts"] = impacts;
}

/// The same three seconds through CVODE, dense Jacobian by differences or exact. The error is that at the end.
void BM_Bdf(benchmark::State& bench, GetCase get, JacobianKind jacobian, double rtol) {
  const Case& c = get();
  WagonState end;
  ImplicitCounts counts;
  const std::clock_t begin = std::clock();
  for (auto _ : bench)
    end = RunImplicit(c.wagon, kSpeed, c.state, c.Moment(kMoments),
                      {.rtol = rtol, .atol = 1e-2 * rtol, .jacobian = jacobian}, &counts);
  const double cpu = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  bench.counters["times_real_time"] = kSeconds * static_cast<double>(bench.iterations()) / cpu;
  bench.counters["error_of_amplitude_at_end"] = c.ErrorAtEnd(LateralMotions(end.x));
  bench.counters["rhs_per_s_of_wagon"] = static_cast<double>(counts.rhs_calls) / kSeconds;
  bench.counters["steps_per_s"] = static_cast<double>(counts.steps) / kSeconds;
}

struct Named {
  const char* name;
  GetCase get;
};

void Register() {
  const auto add = [](const std::string& name, auto function, auto... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), function, arguments...)->Unit(benchmark::kMillisecond);
  };
  for (const Named& one : {Named{"smooth", &Smooth}, Named{"rigid", &Rigid}, Named{"elastic", &Elastic}}) {
    const std::string name = one.name;
    add(name + "/default", &BM_Hunting, one.get, std::string(), 0.0);
    add(name + "/side_by_side", &BM_SideBySide, one.get);
    add(name + "/sweep", &BM_SweepLike, one.get);
    add(name + "/seven_stages_1e-7", &BM_Hunting, one.get, std::string("UICLINK_STABLE_7_3_4"), 1e-7);
    add(name + "/eight_stages_1e-7", &BM_Hunting, one.get, std::string("UICLINK_STABLE_8_3_4"), 1e-7);
    add(name + "/bogacki_shampine_1e-7", &BM_Hunting, one.get, std::string("ARKODE_BOGACKI_SHAMPINE_4_2_3"), 1e-7);
    add(name + "/dormand_prince_1e-7", &BM_Hunting, one.get, std::string("ARKODE_DORMAND_PRINCE_7_4_5"), 1e-7);
    add(name + "/zonneveld_2e-6", &BM_Hunting, one.get, std::string("ARKODE_ZONNEVELD_5_3_4"), 2e-6);
    for (const double rtol : {1e-7, 1e-9}) {
      const std::string at = rtol == 1e-7 ? "_1e-7" : "_1e-9";
      add(name + "/bdf_differences" + at, &BM_Bdf, one.get, JacobianKind::kDifferences, rtol);
      add(name + "/bdf_exact" + at, &BM_Bdf, one.get, JacobianKind::kExact, rtol);
    }
  }
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  uiclink::Register();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
