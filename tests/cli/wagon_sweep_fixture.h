#pragma once

#include <chrono>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli/running_program.h"
#include "tests/cli/wagon_fixture.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {

/// Twenty runs for each sample: two loads, ten speeds, links scattered about set 1.
inline std::string MakeCampaign(std::size_t samples) {
  return R"(
name = "many"
seed = 4
[base]
geometry = "thesis-equivalent"
scatter_percent = 5
front_lateral_mm = 4
[grid]
cargo = ["empty", "water"]
speed = { from = 12, to = 30, step = 2 }
[run]
kind = "simulate"
duration = 1
[sample]
n = )" + std::to_string(samples);
}

class WagonSweep : public WagonProgram {
 protected:
  using Words = std::vector<std::string>;

  explicit WagonSweep(std::size_t samples = 10) { Write("many.toml", MakeCampaign(samples)); }

  static Words Sweep(const std::string& store, Words more = {}) {
    Words words{"sweep", "many.toml", "--store", store + ".sqlite"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  std::unique_ptr<Running> Start(Words words) const {
    words.insert(words.begin(), UICLINK_WAGON);
    return std::make_unique<Running>(words, RunOptions{.folder = Folder()});
  }
  std::size_t Count(const std::string& store) const {
    return Exists(store + ".sqlite") ? SweepStore::Count(Folder() / (store + ".sqlite")).total() : 0;
  }
  /// Waits until a store has so many rows or the process has ended.
  void WaitForRows(const std::string& store, std::size_t rows, Running* running) const {
    while (Count(store) < rows && !running->Ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  /// The rows of a store in order, all columns but the time that they took.
  Words Rows(const std::string& store) const {
    std::istringstream csv(SweepStore::FormatCsv(Folder() / (store + ".sqlite")));
    Words rows;
    for (std::string line; std::getline(csv, line);) rows.push_back(line.substr(0, line.rfind(',')));
    EXPECT_TRUE(rows.front().starts_with("id,run,status,reason,sample,")) << rows.front();
    EXPECT_EQ(rows.front().find("wall_s"), std::string::npos);
    rows.erase(rows.begin());
    return rows;
  }
  /// The rows of a sweep that nothing has disturbed.
  Words UndisturbedRows() const {
    const ProgramResult result = Run(Sweep("undisturbed", {"--threads", "1"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Rows("undisturbed");
  }
};

#ifdef UICLINK_MPIRUN

class WagonSweepMpi : public WagonSweep {
 protected:
  using WagonSweep::WagonSweep;

  /// The command under mpirun; as root in a container with two cores it wants to be told that this is meant.
  static Words UnderMpi(int processes, const Words& words, const Words& more = {}) {
    Words all{UICLINK_MPIRUN, "--allow-run-as-root", "--oversubscribe"};
    all.insert(all.end(), more.begin(), more.end());
    all.insert(all.end(), {"-n", std::to_string(processes), UICLINK_WAGON});
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  ProgramResult RunMpi(int processes, const Words& words) const {
    return RunProgram(UnderMpi(processes, words), {.folder = Folder()});
  }

  /// The process of a rank among the children of mpirun; -1 where there is none.
  static pid_t FindRank(pid_t mpirun, int rank) {
    const std::string wanted = "OMPI_COMM_WORLD_RANK=" + std::to_string(rank);
    std::istringstream children(
        ReadAll("/proc/" + std::to_string(mpirun) + "/task/" + std::to_string(mpirun) + "/children"));
    for (pid_t child = 0; children >> child;) {
      std::istringstream environment(ReadAll("/proc/" + std::to_string(child) + "/environ"));
      for (std::string entry; std::getline(environment, entry, '\0');)
        if (entry == wanted) return child;
    }
    return -1;
  }
};

#endif

}  // namespace uiclink
