// Threads at their runs: what they have in hand, when it is handed in, and what an interruption leaves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <numeric>

#include "tests/cli/temporary_folder.h"
#include "vehicle/side_by_side.h"
#include "vehicle/sweep/sweep.h"

namespace uiclink {
namespace {

using namespace std::chrono_literals;

/// Another kind that counts the runs which are begun and not finished.
class Counting : public RunKind {
 public:
  explicit Counting(std::shared_ptr<const RunKind> kind) : kind_(std::move(kind)) {}

  const std::string& name() const override { return kind_->name(); }
  const std::vector<ResultColumn>& columns() const override { return kind_->columns(); }
  std::string Identity() const override { return kind_->Identity(); }
  int side_by_side() const override { return kind_->side_by_side(); }
  void Work(RunSource& source) const override {
    Source counted(*this, source);
    kind_->Work(counted);
  }
  int most() const { return most_; }

 private:
  class Source : public RunSource {
   public:
    Source(const Counting& kind, RunSource& source) : kind_(kind), source_(source) {}
    std::optional<RunJob> Next() override {
      std::optional<RunJob> job = source_.Next();
      if (job) {
        const int now = ++kind_.in_hand_;
        for (int most = kind_.most_; now > most && !kind_.most_.compare_exchange_weak(most, now);) {
        }
      }
      return job;
    }
    void Finish(const RunJob& job, SweepOutcome outcome, double wall_s) override {
      --kind_.in_hand_;
      source_.Finish(job, std::move(outcome), wall_s);
    }

   private:
    const Counting& kind_;
    RunSource& source_;
  };

  std::shared_ptr<const RunKind> kind_;
  mutable std::atomic<int> in_hand_{0}, most_{0};
};

/// Sixteen runs.
Campaign MakeCampaign(const std::string& run) {
  return ParseCampaign(
      "name = \"test\"\n[base]\ngeometry = \"thesis-equivalent\"\nfront_lateral_mm = 4\n"
      "[grid]\nspeed = { from = 12, to = 27, step = 1 }\n[run]\nkind = \"simulate\"\n" +
          run,
      "c.toml");
}

std::vector<std::size_t> All(const SweepPlan& plan) {
  std::vector<std::size_t> runs(plan.size());
  std::iota(runs.begin(), runs.end(), std::size_t{0});
  return runs;
}

TEST(Crew, HasFourRunsInHandPerThreadAndHandsInEachAsItEnds) {
  for (const int threads : {1, 2}) {
    Campaign campaign = MakeCampaign("duration = 20\nsettle = 1\n");
    const auto counting = std::make_shared<Counting>(campaign.kind);
    campaign.kind = counting;
    const SweepPlan plan(std::move(campaign));
    Crew crew(plan, threads);
    EXPECT_EQ(crew.hands(), threads * static_cast<int>(kSideBySide));
    crew.Give(All(plan));
    std::size_t done = 0, most_at_once = 0;
    while (done < plan.size()) {
      const std::size_t now = crew.Take(1ms).size();
      done += now;
      most_at_once = std::max(most_at_once, now);
    }
    EXPECT_LE(counting->most(), crew.hands()) << "what a process that is killed has to do again";
    EXPECT_GE(counting->most(), static_cast<int>(kSideBySide));
    EXPECT_LT(most_at_once, plan.size()) << "rows come while other runs are on their way";
  }
}

TEST(RunSweep, InterruptedItWritesWhatIsHandedOutIfThatIsShort) {
  const TemporaryFolder folder;
  for (const auto& [duration, is_short] : {std::pair("1", true), std::pair("1000000", false)}) {
    const SweepPlan plan(MakeCampaign(std::string("duration = ") + duration + "\n"));
    SweepStore store(folder.path() / (std::string(duration) + ".sqlite"), plan, "1", SweepStore::Existing::kGoOn);
    LocalTeam team(plan, 1);
    int asked = 0;
    const auto begin = std::chrono::steady_clock::now();
    const SweepResult result = RunSweep(
        &team, &store, [&] { return ++asked <= 1; }, nullptr);
    EXPECT_TRUE(result.interrupted);
    EXPECT_EQ(result.done, is_short ? kSideBySide : 0) << "before the first has ended, one for each hand is given out";
    // A second, and what a busy computer adds.
    EXPECT_LT(std::chrono::steady_clock::now() - begin, 5s);
  }
}

}  // namespace
}  // namespace uiclink
