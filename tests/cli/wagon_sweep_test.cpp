// wagon sweep: killed, interrupted, refused, on one thread, several, and several processes under mpirun.

#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <memory>
#include <random>
#include <sstream>
#include <thread>

#include "tests/cli/wagon_fixture.h"
#include "vehicle/sweep/sweep_store.h"

namespace uiclink {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;
using Words = std::vector<std::string>;

/// A program that is at work beside the test. Killed at the end, if it still is.
class Running {
 public:
  Running(const Words& words, const RunOptions& options)
      : out_(internal::OpenUnnamed()), err_(internal::OpenUnnamed()) {
    pid_ = fork();
    if (pid_ == 0) internal::RunChild(words, options, out_, err_);
  }
  ~Running() {
    if (pid_ > 0) Signal(SIGKILL), Wait();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int signal) const { kill(pid_, signal); }
  bool Ended() {
    return pid_ <= 0 || waitid(P_PID, static_cast<id_t>(pid_), &info_, WEXITED | WNOHANG | WNOWAIT) != 0 ||
           info_.si_pid != 0;
  }
  ProgramResult Wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return {.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            .out = internal::TakeAll(out_),
            .err = internal::TakeAll(err_)};
  }

 private:
  int out_, err_;
  pid_t pid_ = -1;
  siginfo_t info_{};
};

/// 200 runs: two loads, ten speeds, ten links scattered about set 1.
constexpr const char* kCampaign = R"(
name = "many"
seed = 4
[base]
geometry = "thesis-equivalent"
scatter_percent = 5
front_lateral_mm = 4
[grid]
cargo = ["empty", "water"]
speed = { from = 12, to = 30, step = 2 }
[sample]
n = 10
[run]
kind = "simulate"
duration = 1
)";
constexpr std::size_t kRuns = 200;

class WagonSweep : public WagonProgram {
 protected:
  WagonSweep() { Write("many.toml", kCampaign); }

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
    while (Count(store) < rows && !running->Ended()) std::this_thread::sleep_for(5ms);
  }

  /// The rows of a store in order, all columns but the time that they took.
  Words Rows(const std::string& store) const {
    std::istringstream csv(SweepStore::FormatCsv(Folder() / (store + ".sqlite")));
    Words rows;
    for (std::string line; std::getline(csv, line);) rows.push_back(line.substr(0, line.rfind(',')));
    EXPECT_THAT(rows.front(), AllOf(StartsWith("id,run,status,reason,sample,"), Not(HasSubstr("wall_s"))));
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

// ---------------------------------------------------------------- ending, and going on

TEST_F(WagonSweep, KilledAgainAndAgainItEndsAsIfNothingHadHappened) {
  std::mt19937 random(1);
  std::size_t before = 0;
  int kills = 0;
  while (kills < 5) {
    const auto running = Start(Sweep("killed", {"--threads", "1"}));
    WaitForRows("killed", before + 1 + random() % 20, running.get());
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 30000));
    running->Signal(SIGKILL);
    if (running->Wait().exit_code == 0) break;  // a quick machine: it was done before
    ++kills;
    const std::size_t rows = Count("killed");
    EXPECT_GT(rows, before) << "every start gets further";
    before = rows;
  }
  EXPECT_GE(kills, 2);
  before = Count("killed");
  const ProgramResult last = Run(Sweep("killed"));
  EXPECT_EQ(last.exit_code, 0) << last.err;
  EXPECT_THAT(last.out, HasSubstr("200 of 200 runs: 200 done\n" + std::to_string(kRuns - before) + " runs in "))
      << "what was done is not done again";
  EXPECT_TRUE(Rows("killed") == UndisturbedRows());
  EXPECT_THAT(List(), Not(testing::Contains(HasSubstr("killed.sqlite-")))) << "neither log nor lock is left";
}

TEST_F(WagonSweep, InterruptedItWritesWhatIsDoneAndSaysHowToGoOn) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string store = "stopped" + std::to_string(signal);
    const auto running = Start(Sweep(store, {"--threads", "1"}));
    WaitForRows(store, 5, running.get());
    running->Signal(signal);
    const ProgramResult result = running->Wait();
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr("wagon: interrupted; resume with the same command\n"));
    EXPECT_THAT(result.out, HasSubstr(std::to_string(Count(store)) + " of 200 runs: "));
    EXPECT_EQ(Run(Sweep(store)).exit_code, 0);
    EXPECT_EQ(Count(store), kRuns);
  }
}

TEST_F(WagonSweep, ThreadsDoNotMatter) {
  const Words rows = UndisturbedRows();
  ASSERT_THAT(rows, SizeIs(kRuns));
  EXPECT_EQ(Run(Sweep("two", {"--threads", "2"})).exit_code, 0);
  EXPECT_TRUE(Rows("two") == rows);
  EXPECT_EQ(Run(Sweep("five", {"--threads", "5"})).exit_code, 0);
  EXPECT_TRUE(Rows("five") == rows);
}

TEST_F(WagonSweep, RepeatsWhatWagonSimulateSays) {
  Write("one.toml",
        "name = \"one\"\n[base]\nspeed = 24\nstart = \"front_lateral=4mm\"\ngeometry = \"thesis-equivalent\"\n"
        "[run]\nkind = \"simulate\"\nduration = 3\n");
  ASSERT_EQ(Run({"sweep", "one.toml", "--csv", "one.csv"}).exit_code, 0);
  const Json result = RunJson({"simulate", "--speed", "24", "--time", "3", "--start", "front_lateral=4mm", "--window",
                               "3", "--geometry", "thesis-equivalent", "--out", "", "--quiet"});
  std::istringstream csv(Read("one.csv"));
  std::string head, row;
  std::getline(csv, head), std::getline(csv, row);
  const auto cell = [&](const std::string& column) {
    std::istringstream heads(head), cells(row);
    for (std::string name, value; std::getline(heads, name, ',') && std::getline(cells, value, ',');)
      if (name == column) return std::stod(value);
    ADD_FAILURE() << "no column " << column;
    return 0.0;
  };
  // Sweeps go through the lanes (vehicle/side_by_side.h): the same method, not the same last digits. Over three seconds
  // both keep some 1e-6 of the amplitude (tests/bench); the load is the least of those at the ends of steps.
  const auto expect_near = [&](const std::string& column, const Json& one, double tolerance) {
    EXPECT_NEAR(cell(column), one.get<double>(), tolerance * one.get<double>()) << column;
  };
  expect_near("amplitude_front_lateral_mm", result["amplitude_mm"]["front_lateral"], 1e-5);
  expect_near("minimum_wheel_load_N", result["minimum_wheel_load_N"], 1e-2);
  expect_near("steps", result["steps"], 0.1);
}

// ---------------------------------------------------------------- what goes wrong

TEST_F(WagonSweep, ARunThatFailsIsARowWithItsReason) {
  Write("bad.toml",
        "name = \"bad\"\n[grid]\nback_to_back_mm = [1360, 1460]\nspeed = [10, 20]\n[run]\nkind = \"modes\"\n");
  const ProgramResult result = Run({"sweep", "bad.toml", "--csv", "bad.csv"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("4 of 4 runs: 2 done, 2 failed\n"), HasSubstr("  failed 2 times: ")));
  EXPECT_THAT(Read("bad.csv"), HasSubstr(",failed,"));
  EXPECT_THAT(Run({"sweep", "bad.toml"}).out, HasSubstr("\n0 runs in ")) << "it fails for good";
}

TEST_F(WagonSweep, ASecondProcessIsRefusedAndMayLook) {
  const auto running = Start(Sweep("one", {"--threads", "1"}));
  WaitForRows("one", 1, running.get());
  const ProgramResult second = Run(Sweep("one"));
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_EQ(second.err,
            "one.sqlite: expected to be the only process that writes this store, found another one at work on "
            "it (process " +
                std::to_string(running->pid()) + "); --status looks at it meanwhile\n");
  const ProgramResult status = Run(Sweep("one", {"--status", "--csv", "part.csv"}));
  EXPECT_EQ(status.exit_code, 1) << status.err;
  EXPECT_THAT(status.out, HasSubstr(" of 200 runs: "));
  EXPECT_THAT(Read("part.csv"), HasSubstr(",done,"));
  EXPECT_FALSE(running->Ended());
  EXPECT_EQ(running->Wait().exit_code, 0);
  EXPECT_EQ(Count("one"), kRuns);
}

TEST_F(WagonSweep, AChangedCampaignIsRefusedAndAGrownOneGoesOn) {
  const std::string text = "name = \"a\"\n[grid]\nspeed = [10, 20]\n[run]\nkind = \"modes\"\n";
  Write("many.toml", text);
  ASSERT_EQ(Run(Sweep("a")).exit_code, 0);
  Write("many.toml", "seed = 1\n" + text);
  EXPECT_THAT(Run(Sweep("a")).out, HasSubstr("\n0 runs in ")) << "nothing is drawn";
  Write("many.toml", "name = \"a\"\n[grid]\nspeed = [10, 15, 20]\n[run]\nkind = \"modes\"\n");
  EXPECT_THAT(Run(Sweep("a")).out, HasSubstr("3 of 3 runs: 3 done\n1 run in "));
  Write("many.toml", "name = \"a\"\n[grid]\nspeed = [10, 15]\n[run]\nkind = \"modes\"\n");
  const ProgramResult changed = Run(Sweep("a"));
  EXPECT_EQ(changed.exit_code, 2);
  EXPECT_THAT(changed.err,
              AllOf(StartsWith("a.sqlite: expected the campaign that the store was begun with, found 1 of "),
                    HasSubstr("--restart")));
  EXPECT_EQ(Count("a"), 3u);
  EXPECT_EQ(Run(Sweep("a", {"--restart"})).exit_code, 0);
  EXPECT_EQ(Count("a"), 2u);
}

TEST_F(WagonSweep, ListsWithoutDoingAnything) {
  const ProgramResult list = Run(Sweep("none", {"--list"}));
  EXPECT_EQ(list.exit_code, 0) << list.err;
  EXPECT_THAT(list.out, AllOf(StartsWith("many: 200 runs, kind simulate\n0  "), HasSubstr("\n... 190 more\n"),
                              HasSubstr("cargo=empty"), HasSubstr("speed=12"), HasSubstr("sample=0"),
                              HasSubstr("Store: none.sqlite (not begun)\n")));
  EXPECT_FALSE(Exists("none.sqlite"));
  EXPECT_EQ(RunJson(Sweep("none", {"--list"}))["runs"], 200);
}

TEST_F(WagonSweep, FaultsAreToldBeforeAnythingIsWritten) {
  Write("many.toml", "name = 5\n[grid]\nsped = [1]\n[run]\nkind = \"modes\"\n");
  const ProgramResult bad = Run(Sweep("bad"));
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_EQ(bad.err,
            "many.toml:1: expected name = \"text\", found 5\n"
            "many.toml:3: expected a known key in grid, found \"sped\" (did you mean \"speed\"?)\n");
  Write("many.toml", "name = \"a\"\n[grid]\ncargo = [\"empty\", \"feathers\"]\n[run]\nkind = \"modes\"\n");
  EXPECT_THAT(Run(Sweep("bad")).err, HasSubstr("feathers"));
  EXPECT_EQ(Run({"sweep", "nothing.toml"}).exit_code, 2);
  EXPECT_THAT(List(), Not(testing::Contains(HasSubstr("sqlite"))));
}

// ---------------------------------------------------------------- under mpirun

#ifdef UICLINK_MPIRUN

class WagonSweepMpi : public WagonSweep {
 protected:
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

TEST_F(WagonSweepMpi, ProcessesDoNotMatter) {
  const Words rows = UndisturbedRows();
  for (const int processes : {1, 2, 4}) {
    const std::string store = "mpi" + std::to_string(processes);
    const ProgramResult result = RunMpi(processes, Sweep(store));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_THAT(result.out, StartsWith("200 of 200 runs: 200 done\n")) << "one process speaks";
    EXPECT_TRUE(Rows(store) == rows);
  }
}

TEST_F(WagonSweepMpi, AKilledRankCostsItsRunInHandAndTheSameCommandGoesOn) {
  Running running(UnderMpi(3, Sweep("rank")), {.folder = Folder()});
  WaitForRows("rank", 10, &running);
  const pid_t worker = FindRank(running.pid(), 2);
  ASSERT_GT(worker, 0);
  kill(worker, SIGKILL);
  EXPECT_NE(running.Wait().exit_code, 0) << "mpirun ends all of them by default";
  const std::size_t rows = Count("rank");
  EXPECT_GE(rows, 10u);
  EXPECT_LT(rows, kRuns);
  EXPECT_THAT(Run(Sweep("rank")).out, HasSubstr("\n" + std::to_string(kRuns - rows) + " runs in "));
  EXPECT_TRUE(Rows("rank") == UndisturbedRows());
}

TEST_F(WagonSweepMpi, WithRecoveryTheOthersDoTheRunsOfAKilledRank) {
  Running running(UnderMpi(3, Sweep("rest"), {"--enable-recovery"}), {.folder = Folder()});
  WaitForRows("rest", 10, &running);
  const pid_t worker = FindRank(running.pid(), 2);
  ASSERT_GT(worker, 0);
  kill(worker, SIGKILL);
  const ProgramResult result = running.Wait();
  EXPECT_THAT(result.out, StartsWith("200 of 200 runs: 200 done\n"));
  EXPECT_THAT(result.err, HasSubstr("wagon: 1 process lost; the others did their runs\n"));
  EXPECT_TRUE(Rows("rest") == UndisturbedRows());
}

TEST_F(WagonSweepMpi, AFaultIsToldOnce) {
  Write("many.toml", "name = 5\n[run]\nkind = \"modes\"\n");
  const ProgramResult result = RunMpi(3, Sweep("bad"));
  EXPECT_EQ(result.exit_code, 2);
  const std::string fault = "many.toml:1: expected name = \"text\", found 5\n";
  const std::size_t first = result.err.find(fault);
  ASSERT_NE(first, std::string::npos) << result.err;
  EXPECT_EQ(result.err.find(fault, first + 1), std::string::npos);
}

#else

TEST(WagonSweepMpi, IsNotTested) { GTEST_SKIP() << "built without MPI (Debian: openmpi-bin libopenmpi-dev)"; }

#endif

}  // namespace
}  // namespace uiclink
