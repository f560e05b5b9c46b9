#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <vector>

#include "vehicle/sweep/crew.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {

/// Those who do the runs: threads of this process, or processes of a cluster. A member is a process.
class Team {
 public:
  virtual ~Team() = default;
  virtual std::size_t members() const = 0;
  virtual int Hands(std::size_t member) const = 0;  ///< runs that it does at a time; 0 once it is lost
  virtual void Give(std::size_t member, const std::vector<std::size_t>& runs) = 0;
  /// What was finished since the last call; waits a few milliseconds.
  virtual std::vector<FinishedRun> Take() = 0;
};

/// The threads of this process alone.
class LocalTeam : public Team {
 public:
  LocalTeam(const SweepPlan& plan, int threads) : crew_(plan, threads) {}
  std::size_t members() const override { return 1; }
  int Hands(std::size_t /*member*/) const override { return crew_.hands(); }
  void Give(std::size_t /*member*/, const std::vector<std::size_t>& runs) override { crew_.Give(runs); }
  std::vector<FinishedRun> Take() override { return crew_.Take(std::chrono::milliseconds(5)); }

 private:
  Crew crew_;
};

struct SweepProgress {
  std::size_t done = 0;   ///< of this call
  std::size_t total = 0;  ///< of this call: those that had no row before
  double elapsed_s = 0;
  double left_s = 0;  ///< at the pace so far; 0 before the first run has finished
};

struct SweepResult {
  std::size_t done = 0;  ///< runs of this call
  double wall_s = 0;
  double run_s = 0;  ///< time of the runs themselves, added up over the threads
  std::size_t lost_members = 0;
  bool interrupted = false;
};

/// Hands out the runs that the store lacks, a quarter of a second of work ahead of every thread, and writes what comes
/// back, five times a second. Runs of a member that is lost go to the others.
/// @param go_on  asked every few milliseconds; false ends the sweep: nothing more is handed out, and what is finished
/// within a second is written. May be null.
/// @param on_progress  called after every transaction. May be null.
/// @throws SqliteError where the store cannot be written; std::runtime_error when no member is left.
SweepResult RunSweep(Team* team, SweepStore* store, const std::function<bool()>& go_on,
                     const std::function<void(const SweepProgress&)>& on_progress);

}  // namespace uiclink
