// The store: rows that stay, campaigns that grow, changes that are refused, files that are no store.

#include "vehicle/sweep/sweep_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <numeric>

#include "data/input_error.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

class Store : public testing::Test {
 protected:
  static SweepPlan Plan(const std::string& speeds, const std::string& more = "") {
    return SweepPlan(ParseCampaign(
        "name = \"test\"\n[grid]\nspeed = " + speeds + "\n" + more + "\n[run]\nkind = \"modes\"\n", "c.toml"));
  }
  std::filesystem::path Path() const { return folder_.path() / "a.sqlite"; }

  std::vector<std::size_t> Missing(const SweepPlan& plan, const std::string& version = "1") const {
    return SweepStore(Path(), plan, version, SweepStore::Existing::kGoOn).missing();
  }
  std::string Fault(const SweepPlan& plan, const std::string& version = "1",
                    SweepStore::Existing existing = SweepStore::Existing::kGoOn) const {
    try {
      const SweepStore store(Path(), plan, version, existing);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  void Write(const SweepPlan& plan, const std::vector<FinishedRun>& runs) const {
    SweepStore(Path(), plan, "1", SweepStore::Existing::kGoOn).Write(runs);
  }

  TemporaryFolder folder_;
};

FinishedRun Done(std::size_t run, double value) {
  return {.run = run, .outcome = {.values = {value, std::numeric_limits<double>::infinity(), 3}}, .wall_s = 0.5};
}

TEST_F(Store, KeepsRowsBitByBit) {
  const SweepPlan plan = Plan("[10, 20, 30]");
  EXPECT_THAT(Missing(plan), ElementsAre(0, 1, 2));
  Write(plan, {Done(1, 0.1), {.run = 2, .outcome = {.status = RunStatus::kFailed, .reason = "a \"reason\", or two"}}});
  EXPECT_THAT(Missing(plan), ElementsAre(0));
  const std::string csv = SweepStore::FormatCsv(Path());
  EXPECT_THAT(
      csv, AllOf(HasSubstr("id,run,status,reason,sample,geometry,cargo,set,speed,growth_per_s,"
                           "growth_frequency_hz,unstable_modes,wall_s\n"),
                 HasSubstr(plan.Id(1) + ",1,done,,,nominal-1435,empty,set1,20,0.1,,3,0.5\n"),
                 HasSubstr(plan.Id(2) + ",2,failed,\"a \"\"reason\"\", or two\",,nominal-1435,empty,set1,30,,,,0\n")));
  const StoreCounts counts = SweepStore::Count(Path());
  EXPECT_EQ(counts.total(), 2u);
  EXPECT_EQ(counts[RunStatus::kFailed], 1u);
  EXPECT_EQ(counts.reasons.at("a \"reason\", or two"), 1u);
}

TEST_F(Store, KeepsTheFirstRowOfARun) {
  const SweepPlan plan = Plan("[10]");
  Write(plan, {Done(0, 1)});
  Write(plan, {Done(0, 2)});
  EXPECT_THAT(SweepStore::FormatCsv(Path()), HasSubstr(",1,,3,0.5\n"));
}

TEST_F(Store, GrowsWithTheCampaign) {
  Write(Plan("[10, 20]"), {Done(0, 1), Done(1, 2)});
  const SweepPlan more = Plan("[5, 10, 20]", "friction = [0.1, 0.15]");
  EXPECT_THAT(Missing(more), SizeIs(4));
  const std::string csv = SweepStore::FormatCsv(Path());
  EXPECT_THAT(csv, HasSubstr(",wall_s,friction\n")) << "a column more";
  EXPECT_THAT(csv, HasSubstr("4,done,,,nominal-1435,empty,set1,10,1,,3,0.5,0.15\n")) << "its number has moved";
}

TEST_F(Store, RefusesAChangeAndSaysWhich) {
  Write(Plan("[10, 20]"), {Done(0, 1), Done(1, 2)});
  EXPECT_THAT(Fault(Plan("[10, 30]")),
              AllOf(HasSubstr("expected the campaign that the store was begun with, found 1 of its 2 runs not in it"),
                    HasSubstr("values in [base], [grid] or [sample] have changed or gone"), HasSubstr("--restart")));
  EXPECT_THAT(Fault(Plan("[10, 20]"), "2"), HasSubstr("version of the program was \"1\", is \"2\""));
  EXPECT_THAT(Fault(SweepPlan(ParseCampaign("name = \"test\"\n[run]\nkind = \"stability\"\n", "c.toml"))),
              HasSubstr("[run] was \"kind=modes\", is \"kind=stability"));
  EXPECT_EQ(Fault(Plan("[10, 30]"), "1", SweepStore::Existing::kReplace), "");
  EXPECT_EQ(SweepStore::Count(Path()).total(), 0u) << "begun anew";
}

TEST_F(Store, NamesTheFileThatHasChanged) {
  const auto write = [&](const char* k) {
    folder_.Write("link.toml", std::string("name = \"l\"\nsource = \"test\"\nload_N = 3714.0\n[lateral]\nk = ") + k +
                                   "\nsliders = []\n[longitudinal]\nk = 6.0\nsliders = []\n");
  };
  const std::string more = "set = [\"" + (folder_.path() / "link.toml").string() + "\"]";
  write("4.0");
  Write(Plan("[10]", more), {Done(0, 1)});
  write("5.0");
  EXPECT_THAT(Fault(Plan("[10]", more)), HasSubstr("link.toml has changed: sha256 was "));
}

TEST_F(Store, LeavesOtherFilesAlone) {
  folder_.Write("a.sqlite", "a letter that somebody wrote, long enough to be taken for something\n");
  for (const auto existing : {SweepStore::Existing::kGoOn, SweepStore::Existing::kReplace}) {
    EXPECT_THAT(Fault(Plan("[10]"), "1", existing), HasSubstr("expected a store of wagon sweep"));
  }
  {
    std::filesystem::remove(Path());
    Sqlite other(Path(), Sqlite::Mode::kCreate);
    other.Execute("CREATE TABLE recipes (name TEXT)");
  }
  EXPECT_THAT(Fault(Plan("[10]"), "1", SweepStore::Existing::kReplace), HasSubstr("found another file"));
}

TEST_F(Store, HasOneWriter) {
  const SweepPlan plan = Plan("[10]");
  const SweepStore store(Path(), plan, "1", SweepStore::Existing::kGoOn);
  EXPECT_THAT(Fault(plan), HasSubstr("expected to be the only process that writes this store, found another one"));
}

}  // namespace
}  // namespace uiclink
