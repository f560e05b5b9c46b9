#pragma once

#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/ratio.h"

namespace uiclink {

/// What one run cost.
struct Cost {
  double wall_s = 0;   ///< from start to end; on a busy machine it says more about the others
  double cpu_s = 0;    ///< processor time of all threads
  double peak_MB = 0;  ///< most memory in use (resident), of a program; 0: not measured
};

/// Cost of a function call.
inline Cost MeasureCall(const std::function<void()>& run) {
  const auto begin = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  run();
  return {.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          .cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC};
}

/// Cost of a program from start to end, its output thrown away. The kernel counts the memory that this process has in
/// use at the fork as the child's, so callers stay small. @throws std::runtime_error unless it ends with exit code 0 or
/// 1 ("done, but something is to be said").
inline Cost MeasureProgram(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const auto begin = std::chrono::steady_clock::now();
  const pid_t child = fork();
  if (child == 0) {
    const int nothing = open("/dev/null", O_RDWR);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
    execv(argv[0], argv.data());
    _exit(126);
  }
  int status = 0;
  rusage used{};
  if (child < 0 || wait4(child, &status, 0, &used) != child || !WIFEXITED(status) || WEXITSTATUS(status) > 1)
    throw std::runtime_error(words[0] + " failed");
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return {.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
          .cpu_s = seconds(used.ru_utime) + seconds(used.ru_stime),
          .peak_MB = static_cast<double>(used.ru_maxrss) / 1024};
}

/// Something whose cost we promise.
struct Limit {
  std::string name;
  std::function<Cost()> measure;
  double most_wall_s = 0;   ///< 0: nothing promised
  double most_peak_MB = 0;  ///< 0: nothing promised
  int iterations = 5;
};

/// Fastest run, median processor time and largest peak. What a run takes beyond the fastest was taken by others.
inline Cost Measure(benchmark::State& state, const Limit& limit) {
  std::vector<double> cpu;
  Cost cost{.wall_s = std::numeric_limits<double>::infinity()};
  for ([[maybe_unused]] auto iteration : state) {
    const Cost one = limit.measure();
    cost.wall_s = std::min(cost.wall_s, one.wall_s);
    cpu.push_back(one.cpu_s);
    cost.peak_MB = std::max(cost.peak_MB, one.peak_MB);
    state.SetIterationTime(one.wall_s);
  }
  cost.cpu_s = Median(cpu);
  state.counters["wall_s"] = cost.wall_s;
  state.counters["cpu_s"] = cost.cpu_s;
  state.counters["peak_MB"] = cost.peak_MB;
  return cost;
}

/// Main program of a benchmark with limits. @returns the exit code: 1 when a promise is not kept.
inline int RunLimits(int argc, char** argv, const std::vector<Limit>& limits) {
  std::vector<Cost> costs(limits.size());
  for (std::size_t i = 0; i < limits.size(); ++i) {
    benchmark::RegisterBenchmark(
        limits[i].name.c_str(), [&limits, &costs, i](benchmark::State& state) { costs[i] = Measure(state, limits[i]); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->Iterations(limits[i].iterations);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();

  int status = 0;
  std::printf("\n%-52s %9s %9s %9s %9s %9s\n", "", "wall", "promised", "processor", "peak MB", "promised");
  const auto promise = [](double value, const std::string& text) { return value > 0 ? text : std::string("-"); };
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const Limit& limit = limits[i];
    const Cost& cost = costs[i];
    if (cost.wall_s == 0) continue;  // filtered out
    const bool slow = limit.most_wall_s > 0 && cost.wall_s > limit.most_wall_s;
    const bool large = limit.most_peak_MB > 0 && cost.peak_MB > limit.most_peak_MB;
    char peak[32], most_peak[32];
    std::snprintf(peak, sizeof peak, "%.0f", cost.peak_MB);
    std::snprintf(most_peak, sizeof most_peak, "%.0f", limit.most_peak_MB);
    std::printf("%-52s %9s %9s %9s %9s %9s%s%s\n", limit.name.c_str(), FormatDuration(cost.wall_s).c_str(),
                promise(limit.most_wall_s, FormatDuration(limit.most_wall_s)).c_str(),
                FormatDuration(cost.cpu_s).c_str(), promise(cost.peak_MB, peak).c_str(),
                promise(limit.most_peak_MB, most_peak).c_str(), slow ? "  TOO SLOW" : "", large ? "  TOO LARGE" : "");
    if (slow || large) status = 1;
  }
  return status;
}

}  // namespace uiclink
