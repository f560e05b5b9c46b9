// Which runs a campaign has, what identifies them, and what is drawn for them.

#include "vehicle/sweep/sweep_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;

constexpr const char* kModes = "\n[run]\nkind = \"modes\"\n";

SweepPlan Plan(const std::string& text, const std::filesystem::path& folder = {}) {
  return SweepPlan(ParseCampaign("name = \"test\"\n" + text + kModes, folder / "c.toml"));
}

std::vector<std::string> Ids(const SweepPlan& plan) {
  std::vector<std::string> ids;
  for (std::size_t run = 0; run < plan.size(); ++run) ids.push_back(plan.Id(run));
  return ids;
}

double Number(const SweepPlan& plan, std::size_t run, const char* axis) {
  return std::get<double>(*plan.Values(run)[*FindAxis(axis)]);
}

TEST(SweepPlan, HasEveryPointWithEverySampleOnceAndRunsOfOneWagonTogether) {
  const SweepPlan plan = Plan(
      "[grid]\nspeed = [10, 20, 30]\ncargo = [\"empty\", \"water\"]\n"
      "[sample]\nn = 4\nfriction = { distribution = \"uniform\", low = 0.1, high = 0.4 }\n");
  ASSERT_EQ(plan.size(), 24u);
  const std::vector<std::string> ids = Ids(plan);
  EXPECT_EQ(std::set<std::string>(ids.begin(), ids.end()).size(), ids.size());
  for (std::size_t run = 0; run < plan.size(); run += 3) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(Number(plan, run + i, "speed"), 10.0 * static_cast<double>(i + 1));
      EXPECT_EQ(plan.shelf().Get(plan.Setup(run)), plan.shelf().Get(plan.Setup(run + i))) << "one wagon for all speeds";
    }
  }
}

TEST(SweepPlan, GrowsWithoutChangingTheRunsThatItHad) {
  const std::string sample = "[sample]\nn = 3\nfriction = { distribution = \"uniform\", low = 0.1, high = 0.4 }\n";
  const std::vector<std::string> small = Ids(Plan("[grid]\nspeed = [10, 20]\n" + sample));
  EXPECT_THAT(Ids(Plan("[grid]\nspeed = [5, 10, 15, 20]\n" + sample)), IsSupersetOf(small)) << "values";
  EXPECT_THAT(Ids(Plan("[grid]\nspeed = [10, 20]\ncargo = [\"water\", \"empty\"]\n" + sample)), IsSupersetOf(small))
      << "an axis, with the value that it had";
  EXPECT_THAT(Ids(Plan("[grid]\nspeed = [10, 20]\n[sample]\nn = 5\nfriction = { distribution = \"uniform\", low = 0.1, "
                       "high = 0.4 }\n")),
              IsSupersetOf(small))
      << "samples";
}

TEST(SweepPlan, IdentifiesARunByEverythingThatItStandsOn) {
  const std::string one = "[grid]\nspeed = [10]\n";
  const std::string id = Plan(one).Id(0);
  EXPECT_EQ(Plan("seed = 5\n" + one).Id(0), id) << "nothing is drawn";
  for (const char* const change : {"cargo = \"water\"", "set = \"set2\"", "geometry = \"thesis-equivalent\"",
                                   "friction = 0.2", "guidance = \"off\"", "gauge_mm = 1434", "com = \"printed\"",
                                   "lateral_clearance_mm = 5", "wheel_profile = \"S1002\"", "scatter_percent = 1"}) {
    EXPECT_NE(Plan(one + "[base]\n" + change + "\n").Id(0), id) << change;
  }
  const std::string drawn = "[sample]\nn = 1\nfriction = { distribution = \"uniform\", low = 0.1, high = 0.4 }\n";
  EXPECT_NE(Plan("seed = 5\n" + drawn).Id(0), Plan("seed = 6\n" + drawn).Id(0));
  EXPECT_NE(SweepPlan(ParseCampaign("name = \"t\"\n[run]\nkind = \"stability\"\n", "c.toml")).Id(0),
            SweepPlan(ParseCampaign("name = \"t\"\n[run]\nkind = \"stability\"\nto = 49\n", "c.toml")).Id(0));
}

TEST(SweepPlan, KnowsAFileByItsContentAndFindsItBesideTheCampaign) {
  const TemporaryFolder folder;
  const auto write = [&](double k) {
    folder.Write("link.toml", "name = \"l\"\nsource = \"test\"\nload_N = 3714.0\n[lateral]\nk = " + std::to_string(k) +
                                  "\nsliders = []\n[longitudinal]\nk = 6.0\nsliders = []\n");
  };
  const std::string text = "[base]\nset = \"lateral=link.toml\"\n";
  write(4);
  const SweepPlan before = Plan(text, folder.path());
  EXPECT_THAT(before.Identity(0), HasSubstr("set=lateral=link.toml\n"));
  EXPECT_THAT(before.Identity(0), Not(HasSubstr(folder.path().string()))) << "the folder may move";
  EXPECT_EQ(before.shelf().Get(before.Setup(0))->lateral[0].law().k, 4);
  write(5);
  EXPECT_NE(Plan(text, folder.path()).Id(0), before.Id(0));
}

TEST(SweepPlan, GivesAllPointsTheSameDrawsUnlessAskedForTheirOwn) {
  const std::string text =
      "friction = { distribution = \"uniform\", low = 0.1, high = 0.4 }\n[grid]\nspeed = [10, 20]\n";
  const SweepPlan common = Plan("[sample]\nn = 2\n" + text), own = Plan("[sample]\nn = 2\ndraws = \"own\"\n" + text);
  EXPECT_EQ(Number(common, 0, "friction"), Number(common, 1, "friction"));
  EXPECT_NE(Number(common, 0, "friction"), Number(common, 2, "friction")) << "another sample";
  EXPECT_NE(Number(own, 0, "friction"), Number(own, 1, "friction"));
}

TEST(SweepPlan, ReplacesWhatTheFilesSay) {
  const SweepPlan plan = Plan(
      "[base]\nlateral_clearance_mm = 5\nlongitudinal_stop_N_per_m = 2e6\nfriction = 0.3\nguidance = \"off\"\n"
      "back_to_back_mm = 1359\n");
  const SweepPlan plain = Plan("");
  const auto wagon = plan.shelf().Get(plan.Setup(0)), as_in_files = plain.shelf().Get(plain.Setup(0));
  EXPECT_EQ(wagon->guidance.lateral.clearance, 5e-3);
  EXPECT_EQ(wagon->guidance.longitudinal.k, 2e6);
  EXPECT_EQ(wagon->guidance.longitudinal.clearance, as_in_files->guidance.longitudinal.clearance);
  EXPECT_EQ(wagon->mu, 0.3);
  EXPECT_FALSE(wagon->options.guidance);
  const auto radius = [](const Wagon& w) {
    const ContactCurve::Place place = w.contact.Find(1e-3);
    return ContactCurve::Evaluate(w.contact.pose_cubic(place.cell), place.t).z;
  };
  EXPECT_NE(radius(*wagon), radius(*as_in_files)) << "wheels 1 mm closer together stand elsewhere on the rails";
}

TEST(ScatterLinks, DrawsEveryParameterWithMeanOneAndTheSpreadAskedFor) {
  RunSetup setup;
  setup.scatter = 0.1;
  setup.seed = 3;
  constexpr int kRuns = 4000;
  double sum = 0, squares = 0, product = 0;
  for (int i = 0; i < kRuns; ++i) {
    setup.sample = static_cast<std::uint32_t>(i);
    std::array<CornerLinks, kCorners> links;
    for (CornerLinks& corner : links) corner.longitudinal.k = corner.lateral.k = 1;
    ScatterLinks(setup, &links);
    sum += links[0].lateral.k, squares += std::pow(links[0].lateral.k - 1, 2);
    product += (links[0].lateral.k - 1) * (links[1].lateral.k - 1);
  }
  // Four standard errors.
  EXPECT_NEAR(sum / kRuns, 1, 4 * 0.1 / std::sqrt(kRuns));
  EXPECT_NEAR(std::sqrt(squares / kRuns), 0.1, 4 * 0.1 / std::sqrt(kRuns));
  EXPECT_NEAR(product / kRuns, 0, 4 * 0.01 / std::sqrt(kRuns)) << "corners are independent";
}

TEST(SweepPlan, SaysWhatHasToBeSaidOnce) {
  EXPECT_THAT(Plan("").notices(), IsEmpty());
  EXPECT_EQ(Plan("[base]\nset = \"lateral=set2\"\n[grid]\ncargo = [\"empty\", \"water\"]\n").notices().size(), 1u);
}

}  // namespace
}  // namespace uiclink
