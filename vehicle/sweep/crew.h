#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "vehicle/sweep/sweep_plan.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {

/// Threads that do runs of a plan, as many at once as its kind can (RunKind::Work), begun in the order in which they
/// are given. A run that throws is a failed run.
class Crew {
 public:
  Crew(const SweepPlan& plan, int threads);
  ~Crew();  ///< gives up what is not finished
  Crew(const Crew&) = delete;
  Crew& operator=(const Crew&) = delete;

  void Give(const std::vector<std::size_t>& runs);
  /// What was finished since the last call; waits until everything that was given is, at most `patience`.
  std::vector<FinishedRun> Take(std::chrono::milliseconds patience);
  /// Runs that are done at a time.
  int hands() const { return static_cast<int>(threads_.size()) * plan_.campaign().kind->side_by_side(); }

 private:
  class Source;

  void Work();
  std::optional<std::size_t> TakeRun();
  void Finish(FinishedRun done);

  const SweepPlan& plan_;
  std::atomic<bool> stopped_{false};
  std::mutex mutex_;
  std::condition_variable given_, finished_;
  std::deque<std::size_t> to_do_;
  std::size_t unfinished_ = 0;
  std::vector<FinishedRun> done_;
  std::vector<std::jthread> threads_;  // last: they use the others
};

}  // namespace uiclink
