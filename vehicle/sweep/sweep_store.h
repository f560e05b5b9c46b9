#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/sweep/run_kind.h"
#include "vehicle/sweep/sqlite.h"
#include "vehicle/sweep/store_lock.h"
#include "vehicle/sweep/sweep_plan.h"

namespace uiclink {

/// A run with its result.
struct FinishedRun {
  std::size_t run = 0;
  SweepOutcome outcome;
  double wall_s = 0;
};

/// How many rows a store has, by status, and why runs failed.
struct StoreCounts {
  std::array<std::size_t, kRunStatuses> by_status{};
  std::map<std::string, std::size_t> reasons;  ///< of failed runs

  std::size_t operator[](RunStatus status) const { return by_status[static_cast<std::size_t>(status)]; }
  std::size_t total() const;
};

/// The results of a campaign in an SQLite file, a row a run.
///
///   campaign     key, value       name, seed, run, text (the file), version, schema "wagon-sweep/1"
///   input_files  role, name, path, sha256
///   runs         id, run, status, reason, sample, seed, the axes, the results of the kind, wall_s
///
/// Rows are appended in transactions; with a write-ahead log a process that is killed loses no transaction, and one
/// that was not complete never happened. (After a power cut the last second may be missing, and is computed again.)
class SweepStore {
 public:
  enum class Existing { kGoOn, kReplace };

  /// Opens or creates the store for this plan and takes its lock.
  /// @throws InputError if another process writes it; if the file is no store; if it was begun by another version, or
  /// its rows belong to no run of the plan: a campaign or a file has changed, and the message says which. New runs are
  /// no change.
  SweepStore(const std::filesystem::path& path, const SweepPlan& plan, const std::string& version, Existing existing);

  /// The runs without a row, in order.
  const std::vector<std::size_t>& missing() const { return missing_; }
  void Write(const std::vector<FinishedRun>& runs);  ///< in one transaction; a run that has its row keeps it

  /// For looking at a store, which another process may be writing.
  static StoreCounts Count(const std::filesystem::path& path);
  /// All runs in order, as CSV.
  static std::string FormatCsv(const std::filesystem::path& path);

 private:
  void Create();
  void Compare(const std::string& version);
  std::vector<std::string> FindChanges(const std::string& version);
  void Extend();
  void WriteCampaign(const std::string& version);
  void BindAxes(SqliteStatement* statement, std::size_t run) const;

  std::filesystem::path path_;
  const SweepPlan& plan_;
  StoreLock lock_;
  std::vector<std::size_t> axes_;
  std::vector<std::string> ids_;
  std::vector<std::size_t> missing_;
  std::unique_ptr<Sqlite> database_;
  std::unique_ptr<SqliteStatement> insert_;
};

}  // namespace uiclink
