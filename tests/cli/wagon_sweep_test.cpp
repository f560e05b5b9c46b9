// wagon sweep: killed, interrupted, refused, on one thread, several, and several processes under mpirun.

#include <gmock/gmock.h>

#include <map>
#include <random>

#include "tests/cli/wagon_sweep_fixture.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;
using testing::StartsWith;

constexpr std::size_t kRuns = 200;

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

TEST_F(WagonSweep, ARowDoesNotDependOnWhatSharesItsLanes) {
  std::map<std::string, std::string> rows;  // by id, from the load on: the number of the run is the campaign's
  const auto tail = [](const std::string& row) { return row.substr(row.find(",thesis-equivalent,")); };
  for (const std::string& row : UndisturbedRows()) rows[row.substr(0, row.find(','))] = tail(row);
  std::string other = MakeCampaign(3);
  const std::string speeds = "{ from = 12, to = 30, step = 2 }";
  other.replace(other.find(speeds), speeds.size(), "[13, 30, 22, 12.5, 14]");
  Write("many.toml", other);
  ASSERT_EQ(Run(Sweep("other", {"--threads", "3"})).exit_code, 0);
  std::size_t common = 0;
  for (const std::string& row : Rows("other")) {
    const auto same = rows.find(row.substr(0, row.find(',')));
    if (same == rows.end()) continue;
    ++common;
    EXPECT_EQ(tail(row), same->second);
  }
  EXPECT_EQ(common, 18u) << "three speeds, two loads, three samples";
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
