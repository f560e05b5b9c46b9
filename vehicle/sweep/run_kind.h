#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/table.h"
#include "vehicle/sweep/sweep_axis.h"
#include "vehicle/wagon.h"

namespace uiclink {

enum class RunStatus { kDone, kFailed, kWheelLift, kDerailed };
inline constexpr int kRunStatuses = 4;
const char* Name(RunStatus status);  ///< "done", "failed", "wheel_lift", "derailed"

/// What came out of a run.
struct SweepOutcome {
  RunStatus status = RunStatus::kDone;
  std::string reason = {};          ///< empty for kDone
  std::vector<double> values = {};  ///< by column of the kind; NaN or missing: none
};

/// A column of results in the store.
struct ResultColumn {
  std::string name;  ///< with its unit
  bool integer = false;
};

/// What a run finds: its wagon, and whether it is to go on.
struct RunBench {
  std::shared_ptr<const Wagon> wagon;
  std::function<bool()> go_on;  ///< asked now and then by long runs; false: give up
};

/// A run that a thread has taken.
struct RunJob {
  std::size_t run = 0;
  RunSetup setup;
  RunBench bench;
  double prepared_s = 0;  ///< what its wagon took to make
};

/// Where a thread's runs come from, and where their results go.
class RunSource {
 public:
  virtual ~RunSource() = default;
  /// None when none is waiting now.
  virtual std::optional<RunJob> Next() = 0;
  /// @param wall_s  without its preparation.
  virtual void Finish(const RunJob& job, SweepOutcome outcome, double wall_s) = 0;
};

/// The runs of a campaign: [run] kind = "...", with the keys of the kind beside it. A new kind is a file with such a
/// class and a line in RunKinds() of run_kind.cpp. Constant; used by all threads.
class RunKind {
 public:
  virtual ~RunKind() = default;
  virtual const std::string& name() const = 0;
  virtual const std::vector<ResultColumn>& columns() const = 0;
  /// All options on one line: part of the identity of every run.
  virtual std::string Identity() const = 0;
  virtual bool UsesSpeed() const { return true; }
  virtual bool UsesStart() const { return true; }
  /// Does runs until none is waiting. Results must depend neither on their order nor on what runs beside them.
  /// @throws RunGivenUp when a bench says so.
  virtual void Work(RunSource& source) const = 0;
  /// How many a thread does at once.
  virtual int side_by_side() const { return 1; }
};

/// Runs one after the other.
class OneByOne : public RunKind {
 public:
  void Work(RunSource& source) const override;
  /// @throws RunGivenUp when the bench says so; any other std::exception is the reason of a failed run.
  virtual SweepOutcome Run(const RunBench& bench, const RunSetup& setup) const = 0;
};

/// A run that was interrupted from outside. It has no result and is done again.
class RunGivenUp : public std::exception {};

/// Faults go to the table.
/// @return null after a fault in `kind` itself.
std::shared_ptr<const RunKind> ReadRunKind(Table* run);

// The kinds that there are, with the keys that each one reads.
std::shared_ptr<const RunKind> ReadSimulateKind(Table* run);   ///< duration, settle, window, tolerance, wheel_lift
std::shared_ptr<const RunKind> ReadStabilityKind(Table* run);  ///< from, to, step, tolerance
std::shared_ptr<const RunKind> ReadModesKind(Table* run);      ///< none

}  // namespace uiclink
