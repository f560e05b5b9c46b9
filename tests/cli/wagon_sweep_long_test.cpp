// Two thousand runs, killed ten times at random: the same rows, bit by bit, as those of a sweep that nothing disturbed.

#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "tests/cli/wagon_sweep_fixture.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr std::size_t kSamples = 100, kRuns = 20 * kSamples;
constexpr int kKills = 10;

/// Starts the command again and again, each time to be killed.
/// @return the rows that were there after each time.
template <typename Start, typename Kill, typename Count>
std::vector<std::size_t> KillAgainAndAgain(const Start& start, const Kill& kill, const Count& count) {
  std::mt19937 random(5);
  std::vector<std::size_t> rows;
  for (int i = 0; i < kKills; ++i) {
    const auto running = start();
    // Of the runs that are left, at random as many as leave some for those that follow.
    const std::size_t before = count(), left = kRuns - before;
    const std::size_t until = before + random() % (2 * left / static_cast<std::size_t>(kKills - i + 2));
    while (count() < until && !running->Ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 100000));
    EXPECT_FALSE(running->Ended()) << "kill " << i << " came too late";
    kill(running.get());
    rows.push_back(count());
  }
  return rows;
}

class WagonSweepLong : public WagonSweep {
 protected:
  WagonSweepLong() : WagonSweep(kSamples) {}
};

TEST_F(WagonSweepLong, TwoThousandRunsKilledTenTimes) {
  const std::vector<std::size_t> rows = KillAgainAndAgain(
      [&] {
        return Start(Sweep("killed", {"--threads", "1"}));
      },
      [](Running* running) { running->Signal(SIGKILL), running->Wait(); }, [&] { return Count("killed"); });
  EXPECT_TRUE(std::ranges::is_sorted(rows)) << "a row that is written stays";
  const ProgramResult last = Run(Sweep("killed"));
  EXPECT_THAT(last.out, HasSubstr("2000 of 2000 runs: 2000 done\n" + std::to_string(kRuns - rows.back()) + " runs in "))
      << last.err;
  EXPECT_THAT(Rows("killed"), SizeIs(kRuns));
  EXPECT_TRUE(Rows("killed") == UndisturbedRows());
}

#ifdef UICLINK_MPIRUN

class WagonSweepMpiLong : public WagonSweepMpi {
 protected:
  WagonSweepMpiLong() : WagonSweepMpi(kSamples) {}
};

TEST_F(WagonSweepMpiLong, TwoThousandRunsOfFourProcessesKilledTenTimes) {
  const auto kill_all = [](Running* running) {
    std::vector<pid_t> ranks;
    for (int rank = 0; rank < 4; ++rank) ranks.push_back(FindRank(running->pid(), rank));
    running->Signal(SIGKILL);  // mpirun first, that it may not do so politely
    for (const pid_t rank : ranks)
      if (rank > 0) kill(rank, SIGKILL);
    running->Wait();
  };
  const auto start = [&] {
    return std::make_unique<Running>(UnderMpi(4, Sweep("killed")), RunOptions{.folder = Folder()});
  };
  const std::vector<std::size_t> rows = KillAgainAndAgain(start, kill_all, [&] { return Count("killed"); });
  EXPECT_TRUE(std::ranges::is_sorted(rows)) << "a row that is written stays";
  const ProgramResult last = RunMpi(4, Sweep("killed"));
  EXPECT_THAT(last.out, HasSubstr("2000 of 2000 runs: 2000 done\n" + std::to_string(kRuns - rows.back()) + " runs in "))
      << last.err;
  EXPECT_THAT(Rows("killed"), SizeIs(kRuns));
  EXPECT_TRUE(Rows("killed") == UndisturbedRows());
}

TEST_F(WagonSweepMpiLong, WithRecoveryTheOthersEndWhenProcessZeroIsKilled) {
  Running running(UnderMpi(4, Sweep("rest"), {"--enable-recovery"}), {.folder = Folder()});
  WaitForRows("rest", 100, &running);
  kill(FindRank(running.pid(), 0), SIGKILL);
  EXPECT_THAT(running.Wait().err, HasSubstr("wagon: process 0 lost; resume with the same command\n"));
  const std::size_t rows = Count("rest");
  EXPECT_GE(rows, 100u);
  EXPECT_THAT(Run(Sweep("rest")).out, HasSubstr("\n" + std::to_string(kRuns - rows) + " runs in "));
  EXPECT_TRUE(Rows("rest") == UndisturbedRows());
}

#endif

}  // namespace
}  // namespace uiclink
