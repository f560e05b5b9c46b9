// Campaign files: what they say, and every way in which they can be wrong.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "data/input_error.h"
#include "vehicle/sweep/campaign.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kRun = "[run]\nkind = \"simulate\"\nduration = 5\n";

Campaign Parse(const std::string& text) { return ParseCampaign(text, "folder/c.toml"); }

std::string Fault(const std::string& text) {
  try {
    Parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::vector<double> Numbers(const Campaign::Grid& grid) {
  std::vector<double> numbers;
  for (const AxisValue& value : grid.values) numbers.push_back(std::get<double>(value));
  return numbers;
}

TEST(Campaign, ReadsBaseGridAndSample) {
  const Campaign campaign = Parse(
      "name = \"all\"\nseed = 12\n[base]\ncargo = \"water\"\nfriction = 0.3\n"
      "[grid]\nspeed = { from = 0.1, to = 0.5, step = 0.1 }\nset = [\"set1\", \"set2\"]\n"
      "[sample]\nn = 7\ndraws = \"own\"\nfront_lateral_mm = { distribution = \"normal\", mean = 1, std = 0.5 }\n" +
      std::string(kRun));
  EXPECT_EQ(campaign.name, "all");
  EXPECT_EQ(campaign.seed, 12u);
  EXPECT_EQ(campaign.folder, "folder");
  EXPECT_EQ(campaign.base[*FindAxis("cargo")], AxisValue("water"));
  EXPECT_EQ(campaign.base[*FindAxis("friction")], AxisValue(0.3));
  EXPECT_EQ(campaign.base[*FindAxis("geometry")], AxisValue("nominal-1435"));
  ASSERT_EQ(campaign.grid.size(), 2u);
  EXPECT_EQ(campaign.grid[0].axis, *FindAxis("set")) << "what is costly to change comes first";
  EXPECT_THAT(Numbers(campaign.grid[1]), ElementsAre(0.1, 0.2, 0.3, 0.4, 0.5)) << "decimal numbers, without rounding";
  EXPECT_EQ(campaign.samples, 7u);
  EXPECT_TRUE(campaign.own_draws);
  ASSERT_EQ(campaign.sampled.size(), 1u);
  EXPECT_EQ(campaign.kind->name(), "simulate");
}

TEST(Campaign, TellsAllFaultsAtOnceWithTheirLines) {
  const std::string fault = Fault(
      "name = \"bad\"\nspeed = 3\n[base]\ncargo = 5\nsped = 3\nstart = \"front_lateral=5\"\n"
      "[grid]\nspeed = [10, -1, 10]\ncargo = [\"empty\"]\nguidance = [\"on\", \"maybe\"]\nset = []\n"
      "[sample]\nn = 2.5\nfriction = { distribution = \"even\", low = 0.1, high = 0.2 }\n"
      "[run]\nkind = \"simulate\"\nwindow = 10\n");
  EXPECT_THAT(fault, HasSubstr("folder/c.toml:2: expected a known key, found \"speed\""));
  EXPECT_THAT(fault, HasSubstr("c.toml:4: expected cargo = \"text\", found 5"));
  EXPECT_THAT(fault, HasSubstr("c.toml:5: expected a known key in base, found \"sped\" (did you mean \"speed\"?)"));
  EXPECT_THAT(fault, HasSubstr("c.toml:6: expected start with a number with its unit (cm, m, mm)"));
  EXPECT_THAT(fault, HasSubstr("c.toml:8: expected 0.01 <= speed[2] <= 300 [m/s], found -1"));
  EXPECT_THAT(fault, HasSubstr("c.toml:8: expected each value of speed once, found 10 twice"));
  EXPECT_THAT(fault, HasSubstr("c.toml:9: expected cargo in one table alone, found it in [base] too"));
  EXPECT_THAT(fault, HasSubstr("c.toml:10: expected guidance one of on, off, found \"maybe\""));
  EXPECT_THAT(fault, HasSubstr("c.toml:11: expected set with one value at least, found none"));
  EXPECT_THAT(fault, HasSubstr("c.toml:13: expected a whole number n, found 2.5"));
  EXPECT_THAT(fault, HasSubstr("c.toml:14: expected distribution = uniform, normal, log-normal or choice, found"));
  EXPECT_THAT(fault, HasSubstr("c.toml:15: expected 0.001 <= duration <= 10000000 [s] in run, found nothing"));
}

TEST(Campaign, FindsWhatMakesNoSense) {
  EXPECT_THAT(Fault("name = \"a\"\n"), HasSubstr("expected a table run, found nothing"));
  EXPECT_EQ(Fault("name = \"a\"\n[run]\nkind = \"dance\"\nduration = 3\n"),
            "folder/c.toml:3: expected kind = one of modes, simulate, stability, found \"dance\"");
  EXPECT_THAT(Fault("name = \"a\"\n[grid]\nspeed = [1, 2]\n[run]\nkind = \"stability\"\n"),
              HasSubstr("expected axes that runs of kind stability use, found speed"));
  EXPECT_THAT(Fault(std::string("name = \"a\"\n[sample]\nn = 5\n") + kRun),
              HasSubstr("expected something to draw in [sample], scatter_percent or draw, found nothing"));
  EXPECT_THAT(Fault(std::string("name = \"a\"\n[base]\ndraw = \"all\"\n") + kRun),
              HasSubstr("c.toml:3: expected draw one of nothing, set, corners, set+corners, found \"all\""));
  EXPECT_THAT(Fault(std::string("name = \"a\"\n[grid]\nspeed = { from = 1, to = 100, step = 1e-6 }\n") + kRun),
              HasSubstr("expected at most 1000000 values, found step = 1e-06"));
  EXPECT_THAT(
      Fault(std::string("name = \"a\"\n[grid]\nspeed = { from = 1, to = 100, step = 0.001 }\nfriction = { from = "
                        "0.1, to = 0.2, step = 0.001 }\n") +
            kRun),
      HasSubstr("expected at most 1000000 runs, found 9999101"));
  EXPECT_THAT(Fault(std::string("name = \"a\"\n[grid]\nspeed = { from = 5, to = 4, step = 1 }\n") + kRun),
              HasSubstr("expected to >= from = 5, found 4"));
  EXPECT_THAT(Fault("name = \"a\"\n[run]\nkind = \"simulate\"\nduration = 5\nwindow = 6\n"),
              HasSubstr("expected window <= duration = 5 [s], found 6"));
  EXPECT_THAT(Fault("name = \"a\"\n[run]\nkind = \"stability\"\nfrom = 5\nto = 4\n"),
              HasSubstr("expected to > from = 5 [m/s], found 4"));
}

TEST(Campaign, SamplesMayBeThereForScatterOrDrawAlone) {
  EXPECT_EQ(Fault(std::string("name = \"a\"\n[base]\nscatter_percent = 5\n[sample]\nn = 5\n") + kRun), "");
  EXPECT_EQ(Fault(std::string("name = \"a\"\n[base]\ndraw = \"set\"\n[sample]\nn = 5\n") + kRun), "");
}

}  // namespace
}  // namespace uiclink
