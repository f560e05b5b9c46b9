#include "vehicle/hunting/attractors.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <random>
#include <stdexcept>
#include <utility>

#include "model/parallel.h"
#include "vehicle/equilibrium.h"
#include "vehicle/hunting/wagon_flow.h"

namespace uiclink {
namespace {

using Clock = std::chrono::steady_clock;

void CheckOptions(const AttractorOptions& o) {
  if (!(o.settle > 0) || !(o.observe > 0) || !(o.longest >= o.settle + o.observe))
    throw std::invalid_argument("attractors: settle and observe must be positive and fit into the longest time");
  if (!(o.least_motion > 0) || !(o.same_share >= 0) || !(o.same_motion >= 0) || !(o.same_frequency >= 0))
    throw std::invalid_argument("attractors: least motion and tolerances must be positive");
  if (!(o.box.least_factor > 0 && o.box.least_factor <= 1))
    throw std::invalid_argument("attractors: the least factor of start states must be above 0 and at most 1");
}

/// Motions whose extremes depend on when one looks.
bool Wanders(MotionKind kind) { return kind == MotionKind::kModulated || kind == MotionKind::kIrregular; }

bool AreSame(const RunOutcome& a, const RunOutcome& b, const AttractorOptions& o) {
  if (a.end != b.end || a.motion.kind != b.motion.kind) return false;
  if (a.end == RunEnd::kDerailed || a.end == RunEnd::kFailed) return false;
  if (a.motion.kind == MotionKind::kEquilibrium) return true;
  const double wide = Wanders(a.motion.kind) ? 3 : 1;
  if (!Wanders(a.motion.kind) && a.motion.k != b.motion.k) return false;
  if (std::abs(a.frequency - b.frequency) > wide * o.same_frequency * std::max(a.frequency, b.frequency)) return false;
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    if (IsLongitudinal(i)) continue;
    const double larger = std::max(a.half_width[i], b.half_width[i]);
    if (std::abs(a.half_width[i] - b.half_width[i]) > wide * (o.same_share * larger + o.same_motion)) return false;
  }
  return true;
}

/// Groups of runs that are the same, directly or through others.
std::vector<std::vector<std::size_t>> Cluster(const std::vector<RunOutcome>& runs, const AttractorOptions& options) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (runs[i].end == RunEnd::kDerailed || runs[i].end == RunEnd::kFailed) continue;
    std::vector<std::size_t> joined{i};
    std::erase_if(groups, [&](const std::vector<std::size_t>& group) {
      const bool same = std::ranges::any_of(group, [&](std::size_t j) { return AreSame(runs[i], runs[j], options); });
      if (same) joined.insert(joined.end(), group.begin(), group.end());
      return same;
    });
    std::ranges::sort(joined);
    groups.push_back(std::move(joined));
  }
  return groups;
}

/// The run of a group whose half widths are nearest to the medians of the group's.
std::size_t FindTypical(const std::vector<RunOutcome>& runs, const std::vector<std::size_t>& group) {
  std::array<double, kMotionCount> medians{};
  for (std::size_t i = 0; i < kMotionCount; ++i) {
    std::vector<double> values;
    for (const std::size_t run : group) values.push_back(runs[run].half_width[i]);
    std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
    medians[i] = values[values.size() / 2];
  }
  return *std::ranges::min_element(group, {}, [&](std::size_t run) {
    double distance = 0;
    for (std::size_t i = 0; i < kMotionCount; ++i) {
      if (IsLongitudinal(i)) continue;
      const double larger = std::max(medians[i], 1e-9);
      distance = std::max(distance, std::abs(runs[run].half_width[i] - medians[i]) / larger);
    }
    return distance;
  });
}

/// Met with its middle to the left and to the right, beyond what friction and the moment of looking make.
bool IsMirrored(const std::vector<RunOutcome>& runs, const std::vector<std::size_t>& group) {
  bool left = false, right = false;
  for (const std::size_t run : group) {
    if (runs[run].motion.kind == MotionKind::kEquilibrium) continue;
    for (std::size_t i = 0; i < 2; ++i) {  // the wheelsets
      const double least = 0.05 * runs[run].half_width[i];
      left = left || runs[run].middle[i] > least;
      right = right || runs[run].middle[i] < -least;
    }
  }
  return left && right;
}

void AddExponent(const Wagon& wagon, double V, const AttractorOptions& options, Attractor* attractor) {
  if (!Wanders(attractor->typical.motion.kind) || options.lyapunov.intervals == 0) return;
  try {
    WagonFlow flow(FamilyBySpeed(wagon), V);
    attractor->lyapunov = FindLargestExponent(flow, flow.FromWagonState(attractor->typical.state), V, options.lyapunov);
  } catch (const std::runtime_error& error) {
    attractor->lyapunov_failure = error.what();
  }
}

/// None where on_run has stopped them.
std::optional<std::vector<RunOutcome>> RunAll(const Wagon& wagon, double V, const std::vector<WagonState>& starts,
                                              const AttractorOptions& options) {
  std::vector<RunOutcome> runs(starts.size());
  std::mutex mutex;
  std::atomic<bool> go_on{true};
  ParallelFor(
      starts.size(), options.threads,
      [&](std::size_t i) {
        if (const auto known = options.known.find(i); known != options.known.end()) {
          runs[i] = known->second;
          return;
        }
        if (!go_on) return;
        Integrator integrator(wagon, options.integrator);
        runs[i] = RunToAttractor(integrator, V, starts[i], options);
        const std::scoped_lock lock(mutex);
        if (options.on_run && !options.on_run(i, runs[i])) go_on = false;
      },
      [&](std::size_t done) {
        if (options.on_progress) options.on_progress(done, starts.size());
      });
  if (!go_on) return std::nullopt;
  return runs;
}

std::vector<Attractor> MakeAttractors(const std::vector<RunOutcome>& runs, const AttractorOptions& options) {
  std::vector<Attractor> attractors;
  for (const std::vector<std::size_t>& group : Cluster(runs, options)) {
    const ShareBounds bounds = CalcShareBounds(group.size(), runs.size());
    const std::size_t typical = FindTypical(runs, group);
    attractors.push_back({.runs = group,
                          .share = static_cast<double>(group.size()) / static_cast<double>(runs.size()),
                          .low = bounds.low,
                          .high = bounds.high,
                          .representative = typical,
                          .typical = runs[typical],
                          .mirrored = IsMirrored(runs, group),
                          .lyapunov = {},
                          .lyapunov_failure = {}});
  }
  std::ranges::sort(attractors, [](const Attractor& a, const Attractor& b) {
    return a.runs.size() != b.runs.size() ? a.runs.size() > b.runs.size() : a.runs[0] < b.runs[0];
  });
  return attractors;
}

}  // namespace

Perturbation DrawStart(const StartBox& box, std::uint64_t seed, std::size_t index) {
  // One generator a start state: number 17 is the same whoever draws it, and however many are drawn.
  std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(index)};
  std::mt19937_64 random(words);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };  // on every standard library
  const double factor = std::pow(box.least_factor, uniform());
  const auto draw = [&](double limit) { return factor * limit * (2 * uniform() - 1); };
  Perturbation by;
  by.front_y = draw(box.wheelset_y);
  by.rear_y = draw(box.wheelset_y);
  by.body_y = draw(box.body_y);
  by.body_phi = draw(box.body_phi);
  by.body_psi = draw(box.body_psi);
  by.front_psi = draw(box.wheelset_psi);
  by.rear_psi = draw(box.wheelset_psi);
  return by;
}

AttractorSurvey FindAttractors(const Wagon& wagon, double V, const std::vector<WagonState>& starts,
                               const AttractorOptions& options) {
  CheckOptions(options);
  const auto begin = Clock::now();
  AttractorSurvey survey;
  survey.V = V;
  std::optional<std::vector<RunOutcome>> runs = RunAll(wagon, V, starts, options);
  survey.stopped = !runs;
  if (survey.stopped) return survey;
  survey.runs = std::move(*runs);
  const auto count = [&](RunEnd end) {
    return static_cast<std::size_t>(std::ranges::count(survey.runs, end, &RunOutcome::end));
  };
  survey.derailed = count(RunEnd::kDerailed);
  survey.failed = count(RunEnd::kFailed);
  survey.unsettled = count(RunEnd::kUnsettled);
  survey.attractors = MakeAttractors(survey.runs, options);
  ParallelFor(survey.attractors.size(), options.threads,
              [&](std::size_t i) { AddExponent(wagon, V, options, &survey.attractors[i]); });
  survey.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return survey;
}

AttractorSurvey FindAttractors(const Wagon& wagon, double V, const AttractorOptions& options) {
  const WagonState equilibrium = FindEquilibrium(wagon, V);
  std::vector<WagonState> starts;
  std::vector<Perturbation> drawn;
  for (std::size_t i = 0; i < options.starts; ++i) {
    drawn.push_back(DrawStart(options.box, options.seed, i));
    starts.push_back(Perturb(wagon, equilibrium, drawn.back()));
  }
  AttractorSurvey survey = FindAttractors(wagon, V, starts, options);
  if (survey.stopped) return survey;
  for (std::size_t i = 0; i < drawn.size(); ++i) survey.runs[i].start = drawn[i];
  for (Attractor& attractor : survey.attractors) attractor.typical.start = drawn[attractor.representative];
  return survey;
}

ShareBounds CalcShareBounds(std::size_t count, std::size_t of) {
  if (of == 0) return {};
  constexpr double z = 1.959963984540054;  // of 95 %
  const auto n = static_cast<double>(of);
  const double p = static_cast<double>(count) / n;
  const double middle = p + z * z / (2 * n);
  const double half = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  const double scale = 1 + z * z / n;
  return {.low = count == 0 ? 0 : (middle - half) / scale, .high = count == of ? 1 : (middle + half) / scale};
}

}  // namespace uiclink
