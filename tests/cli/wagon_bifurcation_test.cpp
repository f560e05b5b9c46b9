// `wagon bifurcation`, and the type of the linear critical speed that `wagon stability` says.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The knee of set 1 at 18.4 m/s, within a narrow range: seconds.
const std::vector<std::string> kContinuation{
    "bifurcation", "--geometry", "thesis-equivalent", "--com", "printed",      "--from", "18", "--to", "18.6",
    "--settle",    "10",         "--trace-hold",      "5",     "--max-points", "4"};
const std::vector<std::string> kTrace{
    "bifurcation", "--method", "trace",  "--geometry", "thesis-equivalent", "--legs", "20:20.4:20.2",
    "--step",      "0.1",      "--hold", "4"};

TEST_F(WagonProgram, BifurcationByContinuationHasItsFilesAndTheKeysOfItsSchema) {
  // Four points do not reach the end of the range: code 1, and a note that says so.
  const Json json = RunJson(kContinuation, 1);
  EXPECT_EQ(json["schema"], "wagon-bifurcation/1");
  EXPECT_EQ(json["method"], "continuation");
  EXPECT_NEAR(json["linear_critical_speed"]["value"], 18.400, 0.001);
  EXPECT_TRUE(json["linear_critical_speed"]["type"].is_string());
  ASSERT_FALSE(json["branches"].empty());
  for (const Json& branch : json["branches"]) {
    EXPECT_TRUE(branch["stable"].is_boolean());
    for (const Json& point : branch["points"]) {
      EXPECT_GE(point["speed"], 17.9999);
      EXPECT_GT(point["amplitude_mm"]["front_lateral"], 0.01);
      EXPECT_NEAR(point["period_s"], 1.04, 0.12);
      // Cycles that close to 1e-6 have their trivial multiplier right to a thousandth.
      EXPECT_LT(point["trivial_error"], 1e-3);
      EXPECT_EQ(point["multipliers"][0].size(), 2u);
    }
  }
  EXPECT_TRUE(json["folds"].is_array());
  EXPECT_TRUE(json["events"].is_array());
  EXPECT_THAT(List("out"), ElementsAre("bifurcation.csv", "bifurcation.json", "bifurcation.svg",
                                       "bifurcation_report.html", "multipliers.svg", "trace.csv"));
}

TEST_F(WagonProgram, BifurcationByTraceSaysWhatItDid) {
  const ProgramResult result = Run(kTrace);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, HasSubstr("4 s at every speed, the last 3 s count; 7 speeds in "));
  EXPECT_THAT(List("out"), ElementsAre("bifurcation.json", "bifurcation.svg", "bifurcation_report.html", "trace.csv"));
  const std::string csv = Read("out/trace.csv");
  EXPECT_EQ(std::ranges::count(csv, '\n'), 8);
  EXPECT_THAT(csv, StartsWith("leg,speed_m_per_s,front_lateral_amplitude_mm,front_lateral_largest_mm,"));
}

TEST_F(WagonProgram, ATraceGoesOnFromWhatAnInterruptedOneHasLeft) {
  std::vector<std::string> longer = kTrace;
  *std::ranges::find(longer, "20:20.4:20.2") = "20:29:20";
  // The folder is made when the work begins; the trace takes some two seconds of a whole core.
  std::vector<std::string> interrupted{"/bin/sh", "-c",
                                       "\"$@\" & while ! [ -e out ]; do sleep 0.02; done; sleep 0.5; kill $!; wait $!",
                                       "sh", UICLINK_WAGON};
  interrupted.insert(interrupted.end(), longer.begin(), longer.end());
  const ProgramResult first = RunProgram(interrupted, {.folder = Folder()});
  ASSERT_EQ(first.exit_code, 1) << first.err;
  EXPECT_THAT(first.err, HasSubstr("interrupted; the same command goes on where it was"));
  EXPECT_THAT(List("out"), Contains("trace.progress"));
  const auto rows_before = std::ranges::count(Read("out/trace.csv"), '\n') - 1;
  EXPECT_GT(rows_before, 0);
  const std::string begun = Read("out/trace.csv");

  const ProgramResult rest = Run(longer);
  EXPECT_EQ(rest.exit_code, 0) << rest.err;
  EXPECT_THAT(List("out"), testing::Not(Contains("trace.progress")));
  EXPECT_EQ(Read("out/trace.csv").substr(0, begun.size()), begun) << "rows that were done are not done again";
  EXPECT_EQ(std::ranges::count(Read("out/trace.csv"), '\n'), 182);

  // Bit by bit as one that was not interrupted.
  Run(With(longer, {"--out", "whole"}));
  EXPECT_EQ(Read("whole/trace.csv"), Read("out/trace.csv"));
}

TEST_F(WagonProgram, ProgressOfAnotherTraceIsNotTaken) {
  std::filesystem::create_directory(Folder() / "out");
  Write("out/trace.progress", "{\"schema\": \"wagon-trace-progress/1\", \"of\": 1}");
  const ProgramResult other = Run(kTrace);
  EXPECT_EQ(other.exit_code, 0);
  EXPECT_EQ(other.err, "note: out/trace.progress is of something else: begun anew\n");
  Write("out/trace.progress", "none");
  const ProgramResult broken = Run(kTrace);
  EXPECT_EQ(broken.exit_code, 2);
  EXPECT_EQ(broken.err,
            "out/trace.progress: expected wagon-trace-progress/1 as a run leaves it, found something else\n");
  EXPECT_EQ(Run(With(kTrace, {"--restart"})).exit_code, 0);
}

TEST_F(WagonProgram, BifurcationListsAttractors) {
  const Json json = RunJson({"bifurcation", "--method", "attractors", "--geometry", "thesis-equivalent", "--speed",
                             "24", "--attractors", "3"});
  EXPECT_EQ(json["survey"]["starts"], 3);
  double share = 0;
  for (const Json& attractor : json["survey"]["attractors"]) share += attractor["share"].get<double>();
  EXPECT_NEAR(share, 1, 1e-12);
  EXPECT_THAT(List("out"), ElementsAre("attractors.csv", "bifurcation.json", "bifurcation_report.html"));
}

TEST_F(WagonProgram, BifurcationInAParameterHasItsNameAndUnitEverywhere) {
  // Four points do not reach the ends of the range: code 1.
  const Json json = RunJson({"bifurcation", "--geometry", "thesis-equivalent", "--com", "printed", "--parameter",
                             "lateral.k", "--range", "4,4.4", "--speed", "14", "--settle", "10", "--max-points", "4"},
                            1);
  EXPECT_EQ(json["schema"], "wagon-bifurcation/1");
  EXPECT_EQ(json["parameter"], Json({{"name", "lateral.k"}, {"unit", "1/m"}, {"own_value", 4.201}, {"speed", 14}}));
  EXPECT_TRUE(json["linear_critical_speed"].is_null());
  EXPECT_EQ(json["equilibrium"], Json::array({Json({{"from", 4}, {"to", 4.4}, {"unstable", 0}})}));
  ASSERT_FALSE(json["branches"].empty());
  for (const Json& branch : json["branches"]) {
    for (const Json& point : branch["points"]) {
      EXPECT_EQ(point["speed"], 14);
      EXPECT_GE(point["value"], 4);
      EXPECT_LE(point["value"], 4.4);
      EXPECT_LT(point["trivial_error"], 1e-3);  // as above
    }
  }
  EXPECT_THAT(List("out"), ElementsAre("bifurcation.csv", "bifurcation.json", "bifurcation.svg",
                                       "bifurcation_report.html", "multipliers.svg"));
  EXPECT_THAT(Read("out/bifurcation.csv"), StartsWith("branch,speed_m_per_s,lateral_k_per_m,period_s,"));
  EXPECT_THAT(Read("out/bifurcation.svg"), HasSubstr("lateral.k [1/m]"));
}

struct Misuse {
  const char* name;
  std::vector<std::string> words;
  const char* message;
};
void PrintTo(const Misuse& misuse, std::ostream* out) { *out << misuse.name; }

class EveryMisuseOfBifurcation : public WagonProgram, public testing::WithParamInterface<Misuse> {};

TEST_P(EveryMisuseOfBifurcation, EndsWithCode2AndAMessage) {
  const ProgramResult result = Run(With({"bifurcation"}, GetParam().words));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_THAT(List(), IsEmpty()) << "nothing is written";
}

INSTANTIATE_TEST_SUITE_P(
    WagonProgram, EveryMisuseOfBifurcation,
    testing::ValuesIn(std::vector<Misuse>{
        {"RangeTheWrongWay", {"--from", "30", "--to", "20"}, "--to: expected more than --from, 30 m/s, found 20"},
        {"StepOfZero", {"--method", "trace", "--step", "0"}, "--step: expected a number from 0.0001 to 100 m/s"},
        {"SpeedOfZero", {"--method", "attractors", "--speed", "0"}, "--speed: expected a number from 0.01 to 300 m/s"},
        {"UnknownMethod", {"--method", "guess"}, "--method"},
        {"ParameterWithoutSpeed",
         {"--parameter", "lateral.k", "--range", "3,6"},
         "--parameter: expected --speed V beside it"},
        {"ParameterWithoutRange", {"--parameter", "lateral.k", "--speed", "14"}, "expected --range LOW,HIGH beside it"},
        {"RangeWithoutParameter", {"--range", "3,6"}, "--range: expected --parameter NAME beside it"},
        {"RangeWithWords",
         {"--parameter", "friction", "--speed", "14", "--range", "0.1,much"},
         "--range: expected two numbers LOW,HIGH with LOW < HIGH, found \"0.1,much\""},
        {"UnknownParameter",
         {"--parameter", "lateral.k9", "--speed", "14", "--range", "1,2"},
         "--parameter lateral.k9: expected one of lateral.k, lateral.k1, "},
        {"ParameterOfContact",
         {"--parameter", "gauge_mm", "--speed", "14", "--range", "1430,1440"},
         "--parameter gauge_mm: it acts through the contact table"},
        {"ParameterTraced",
         {"--parameter", "friction", "--speed", "14", "--range", "0.1,0.4", "--method", "trace"},
         "--parameter: expected --method continuation beside it"},
        {"NoSpeed", {"--method", "attractors"}, "--method attractors: expected --speed V beside it"},
        {"SpeedWithoutAttractors", {"--speed", "20"}, "--speed: expected --method attractors or --parameter beside it"},
        {"StartsWithoutAttractors", {"--attractors", "3"}, "--attractors: expected --method attractors beside it"},
        {"LegsWithoutTrace", {"--legs", "15:23"}, "--legs: expected --method trace or both beside it"},
        {"LegsWithWords", {"--method", "trace", "--legs", "15:up"}, "--legs: expected speeds from 0.01 to 300 m/s"},
        {"OneLeg", {"--method", "trace", "--legs", "15"}, "--legs: expected at least two speeds, found \"15\""},
        {"LegOfNoLength", {"--method", "trace", "--legs", "15:15:8"}, "found 15 twice"},
        {"WindowLongerThanHold", {"--method", "trace", "--hold", "2"}, "--window: expected at most the 2 s of --hold"},
        {"TooManySpeeds",
         {"--method", "trace", "--legs", "1:300:1", "--step", "0.0001"},
         "--step: expected at most 1e+06 speeds"},
        {"FolderThatIsAFile", {"--out", "/dev/null"}, "/dev/null: expected a folder for results"},
    }),
    [](const auto& misuse) { return std::string(misuse.param.name); });

// ---------------------------------------------------------------- stability

TEST_F(WagonProgram, StabilitySaysTheTypeOfItsCrossings) {
  const std::vector<std::string> words{
      "stability", "--geometry", "thesis-equivalent", "--com", "printed", "--from", "18", "--to", "19"};
  const Json json = RunJson(words);
  const Json& critical = json["linear_critical_speed"];
  ASSERT_TRUE(critical["type"].is_string()) << critical;
  EXPECT_THAT(critical["type"].get<std::string>(), testing::AnyOf("supercritical", "subcritical"));
  EXPECT_DOUBLE_EQ(critical["type_decided_at_mm"], 0.1);
  EXPECT_EQ(json["crossings"][0]["type"], critical["type"]);
  EXPECT_THAT(Run(words).out, HasSubstr("Hopf bifurcation: " + critical["type"].get<std::string>() +
                                        ", decided by the cycle of 0.1 mm"));

  const Json without = RunJson(With(words, {"--no-type"}));
  EXPECT_TRUE(without["linear_critical_speed"]["type"].is_null());
  EXPECT_TRUE(without["crossings"][0]["type"].is_null());
  EXPECT_EQ(without["linear_critical_speed"]["value"], critical["value"]);
}

}  // namespace
}  // namespace uiclink
