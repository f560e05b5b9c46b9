#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace uiclink {

/// One side of a comparison: its name and a function that runs it and says how long one run took [s].
struct Side {
  std::string name;
  std::function<double()> seconds;
};

/// A side that is timed here, as the mean of `runs` runs, so that the clock's own time does not count.  In processor
/// time: on a busy machine a long run is interrupted and a short one slips through, which would flatter whoever is
/// faster.
inline Side Timed(std::string name, int runs, std::function<void()> run) {
  return {std::move(name), [runs, run = std::move(run)] {
            const std::clock_t start = std::clock();
            for (int i = 0; i < runs; ++i) run();
            return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / runs;
          }};
}

/// Two ways to the same result, measured in turn, so that whatever else the machine does hits both.
struct Comparison {
  std::string name;
  Side ours;
  Side theirs;
  double least_ratio = 0;  ///< what we promise of theirs / ours
  /// Largest difference between the two results, and what it may be: speed means nothing where the results differ.
  std::function<double()> difference;
  double largest_difference = 0;
  const char* unit = "";
  int iterations = 0;  ///< times that both sides run; 0: as long as Google Benchmark finds it worth while
};

/// Medians of a comparison.
struct RatioResult {
  double ours = 0;    ///< [s]
  double theirs = 0;  ///< [s]
  double difference = 0;
  double Ratio() const { return theirs / ours; }
};

inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Google Benchmark's loop: every iteration runs both sides once.  The medians and their ratio are counters, so they
/// are in `--benchmark_out=FILE` (JSON), too.
inline RatioResult Measure(benchmark::State& state, const Comparison& comparison) {
  std::vector<double> ours, theirs;
  for ([[maybe_unused]] auto iteration : state) {
    ours.push_back(comparison.ours.seconds());
    theirs.push_back(comparison.theirs.seconds());
    state.SetIterationTime(ours.back() + theirs.back());
  }
  const RatioResult result{Median(ours), Median(theirs), comparison.difference()};
  state.counters["ours_s"] = result.ours;
  state.counters["theirs_s"] = result.theirs;
  state.counters["ratio"] = result.Ratio();
  state.counters["least_ratio"] = comparison.least_ratio;
  state.counters["difference"] = result.difference;
  return result;
}

/// "12.3 us"
inline std::string FormatDuration(double seconds) {
  const char* unit = seconds < 1e-3 ? "us" : seconds < 1 ? "ms" : "s";
  char text[32];
  std::snprintf(text, sizeof text, "%.3g %s", seconds * (seconds < 1e-3 ? 1e6 : seconds < 1 ? 1e3 : 1.0), unit);
  return text;
}

/// Main program of a benchmark: measures all comparisons (or those that `--benchmark_filter` names) and ends with a
/// table.  @returns the exit code: 1 when a ratio is below its promise or two results differ by too much.
inline int RunComparisons(int argc, char** argv, const std::vector<Comparison>& comparisons) {
  std::vector<RatioResult> results(comparisons.size());
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    auto* registered = benchmark::RegisterBenchmark(
        comparisons[i].name.c_str(),
        [&comparisons, &results, i](benchmark::State& state) { results[i] = Measure(state, comparisons[i]); });
    registered->UseManualTime()->Unit(benchmark::kMillisecond);
    if (comparisons[i].iterations > 0) registered->Iterations(comparisons[i].iterations);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();

  int status = 0;
  std::printf("\n%-48s %10s %10s %7s %9s  %s\n", "", "ours", "theirs", "ratio", "promised", "they differ by");
  for (std::size_t i = 0; i < comparisons.size(); ++i) {
    const Comparison& comparison = comparisons[i];
    const RatioResult& result = results[i];
    if (result.ours == 0) continue;  // filtered out
    const bool slow = result.Ratio() < comparison.least_ratio;
    const bool differs = !(result.difference <= comparison.largest_difference);
    std::printf("%-48s %10s %10s %7.0f %9.0f  %.1e %s%s%s\n", comparison.name.c_str(),
                FormatDuration(result.ours).c_str(), FormatDuration(result.theirs).c_str(), result.Ratio(),
                comparison.least_ratio, result.difference, comparison.unit, slow ? "  TOO SLOW" : "",
                differs ? "  RESULTS DIFFER" : "");
    std::printf("    %s against %s\n", comparison.ours.name.c_str(), comparison.theirs.name.c_str());
    if (slow || differs) status = 1;
  }
  return status;
}

}  // namespace uiclink
