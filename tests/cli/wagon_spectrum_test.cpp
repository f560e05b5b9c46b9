// wagon spectrum: what it prints and writes, and what it says of input that makes no sense.

#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsSupersetOf;

const std::vector<std::string> kHunting{"spectrum", "--geometry", "thesis-equivalent", "--com", "printed",
                                        "--speed",  "24"};

std::vector<std::string> Hunting(const std::vector<std::string>& more) {
  std::vector<std::string> words = kHunting;
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The first so many lines of a text.
std::string Head(const std::string& text, int lines) {
  std::istringstream in(text);
  std::string head, line;
  for (int i = 0; i < lines && std::getline(in, line); ++i) head += line + "\n";
  return head;
}

TEST_F(WagonProgram, SpectrumOfHuntingIsThatOfTableTenOne) {
  const Json json = RunJson(Hunting({"--settle", "40", "--window", "30", "--out", "out"}));
  EXPECT_EQ(json["schema"], "wagon-spectrum/1");
  // The thesis has 1.07, 2.14 and 4.28 Hz; ours is 1.060 (tests/validation/chapter10.md), settled to 0.2 % by then.
  EXPECT_NEAR(json["base"]["frequency_hz"], 1.060, 3e-3);
  EXPECT_EQ(json["base"]["motion"], "front_lateral");
  const Json& lines = json["motions"]["front_longitudinal"]["lines"];
  ASSERT_GE(lines.size(), 2u);
  EXPECT_EQ(lines[0]["nearest_ratio"], "2:1");
  EXPECT_EQ(lines[0]["locking"], "locked");
  EXPECT_EQ(lines[1]["nearest_ratio"], "4:1");
  // The rear wheelset hits its guides, twice a cycle.
  EXPECT_EQ(json["impacts"]["front_lateral"]["count"], 0);
  EXPECT_NEAR(json["impacts"]["rear_lateral"]["count"], 2 * 30 * 1.06, 1.5);
  EXPECT_LT(json["impacts"]["rear_lateral"]["least_clearance_left_mm"], 0);
  double lost = 0, share = 0;
  for (const Json& part : json["losses"]["parts"]) {
    lost += part["energy_J"].get<double>();
    share += part["share"].get<double>();
  }
  EXPECT_NEAR(share, 1, 1e-9);
  const Json& balance = json["losses"]["balance"];
  EXPECT_NEAR(balance["lost"]["energy_J"], lost, 1e-9 * lost);
  EXPECT_LT(std::abs(balance["residual"]["energy_J"].get<double>()), 1e-3 * lost);
  EXPECT_NEAR(balance["lost"]["per_cycle_J"].get<double>() * json["losses"]["cycles"].get<double>(), lost, 1e-9 * lost);
  EXPECT_THAT(List("out"), IsSupersetOf({"spectrum.csv", "impacts.csv", "losses.csv", "spectrum.json"}));
  EXPECT_THAT(Head(Read("out/losses.csv"), 1), "place,part,corner,energy_J,per_cycle_J,share\n");
  EXPECT_THAT(Head(Read("out/impacts.csv"), 1), HasSubstr("rear_lateral_clearance_left_m,rear_lateral_force_N"));
  EXPECT_THAT(Head(Read("out/spectrum.csv"), 1), HasSubstr("frequency_Hz,front_longitudinal_m2_per_Hz"));
}

TEST_F(WagonProgram, SpectrumOfHistoriesIsThatOfTheRun) {
  std::vector<std::string> run = kHunting;
  run[0] = "simulate";
  run.insert(run.end(), {"--start", "front_lateral=5mm", "--time", "40", "--output-rate", "200", "--out", "run"});
  ASSERT_EQ(Run(run).exit_code, 0);
  const Json file = RunJson(Hunting({"--histories", "run/histories.csv", "--window", "25"}));
  const Json own = RunJson(Hunting({"--settle", "15", "--window", "25"}));
  EXPECT_NEAR(file["base"]["frequency_hz"], own["base"]["frequency_hz"].get<double>(), 1e-3);
  EXPECT_EQ(file["source"]["kind"], "histories");
  EXPECT_TRUE(file["losses"].is_null());
  EXPECT_EQ(file["impacts"]["rear_lateral"]["count"], own["impacts"]["rear_lateral"]["count"]);
  EXPECT_NEAR(file["motions"]["body_roll"]["rms_mrad"], own["motions"]["body_roll"]["rms_mrad"].get<double>(), 1e-2);

  // Another wagon has other forces in the same motion.
  const ProgramResult other = Run(Hunting({"--histories", "run/histories.csv", "--no-guidance", "--quiet"}));
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_THAT(other.err, HasSubstr("is it of another wagon, cargo, or --no-guidance?"));
  EXPECT_THAT(other.err, HasSubstr("less than the window of 60 s: all of it is taken"));

  Write("short.csv", Head(Read("run/histories.csv"), 21));
  const ProgramResult few = Run({"spectrum", "--histories", "short.csv"});
  EXPECT_EQ(few.exit_code, 2);
  EXPECT_EQ(few.err, "short.csv: expected at least 64 samples for a spectrum, found 20\n");

  std::string text = Head(Read("run/histories.csv"), 101);
  text.replace(text.rfind(','), std::string::npos, ",x\n");
  Write("broken.csv", text);
  const ProgramResult broken = Run({"spectrum", "--histories", "broken.csv"});
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_THAT(broken.err, HasSubstr("broken.csv:101: expected a number for"));
}

TEST_F(WagonProgram, SpectrumAtRestHasNoLinesAndSaysSo) {
  const ProgramResult result = Run({"spectrum", "--speed", "10", "--start", "equilibrium", "--settle", "1", "--window",
                                    "10", "--geometry", "thesis-equivalent", "--out", "out"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, HasSubstr("At rest: nothing moves"));
  EXPECT_THAT(result.err, HasSubstr("the wagon is at rest in the window"));
  EXPECT_THAT(List("out"), Contains("spectrum.csv"));
}

TEST_F(WagonProgram, SpectrumNamesWhatMakesNoSense) {
  Write("other.csv", "time_s,displacement_mm\n0,1\n");
  Write("empty.csv", "");
  struct Case {
    std::vector<std::string> words;
    std::string message;
  };
  const std::vector<Case> cases{
      {{"--speed", "0"}, "expected a number from 0.01 to 300 m/s, found \"0\""},
      {{"--histories", "missing.csv"}, "missing.csv: expected a readable file, found"},
      {{"--histories", "other.csv"},
       "other.csv:1: expected the columns of a histories.csv that wagon simulate wrote, found no column front_x_m"},
      {{"--histories", "empty.csv"},
       "empty.csv: expected a histories.csv that wagon simulate wrote, found an empty file"},
      {{"--histories", "other.csv", "--settle", "5"}, "--settle excludes --histories"},
      {{"--window", "0.2"},
       "--window: expected at least 64 samples in each piece of a spectrum, found 40 samples for 1"},
      {{"--window", "10", "--segments", "200"}, "--window: expected at least 64 samples in each piece"},
      {{"--output-rate", "100000"}, "--output-rate: expected at most 1e+06 samples in the window"},
      {{"--start", "front_lateral=5"}, "--start: expected a number with its unit"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> words{"spectrum"};
    words.insert(words.end(), c.words.begin(), c.words.end());
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 2) << c.message;
    EXPECT_THAT(result.err, HasSubstr(c.message));
    EXPECT_EQ(result.out, "");
  }
}

}  // namespace
}  // namespace uiclink
