#pragma once

#include <memory>
#include <string>

#include "vehicle/sweep/sweep.h"

namespace uiclink {

/// Whether this process was started by mpirun (or a batch system's starter) beside others. Looks at the environment
/// alone: a program started by hand does not touch MPI.
bool StartedByMpi();

/// The processes that mpirun started. Process 0 plans, hands out and writes; the others only do runs.
///
/// Messages, to process 0: finished runs (none: a sign of life); from it: numbers of runs, signs of life, the end.
/// Nobody waits for a message while there is work, and one thread of a process speaks. A process that was silent for
/// ten seconds is lost: its runs are done by others, and what it should still send is taken if it comes first. Where
/// process 0 was silent for a minute, the others end. By default mpirun ends all processes when one dies by a signal,
/// and asks them two seconds before; with --enable-recovery it does not, and the sweep goes on without it.
class MpiSession {
 public:
  /// MPI_Init. @throws UsageError where the program was built without MPI.
  MpiSession();
  /// MPI_Finalize, which waits for all processes: where one was lost, this one ends without it, process 0 with code 1,
  /// and the others too where process 0 itself is lost.
  ~MpiSession();
  MpiSession(const MpiSession&) = delete;
  MpiSession& operator=(const MpiSession&) = delete;

  int rank() const;
  int size() const;
  /// The text of process 0, to all.
  std::string Broadcast(const std::string& text) const;
  /// Whether `text` is the same everywhere; to all.
  bool SameEverywhere(const std::string& text) const;

  /// Process 0, once: all of them as a team.
  std::unique_ptr<Team> MakeTeam(const SweepPlan& plan, int threads);
  /// The others: does runs until process 0 says that there are no more, or is gone.
  void Serve(const SweepPlan& plan, int threads);

 private:
  bool lost_ = false;   ///< some process
  bool alone_ = false;  ///< process 0 is
};

}  // namespace uiclink
