// `identify` ends on the wagon: what it prints and writes of that, and what it does where the wagon cannot be run.

#include <cstdlib>
#include <map>
#include <set>

#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

/// Records of both shipped links' lateral direction, fitted quickly.
class IdentifyOnWagon : public IdentifyProgram {
 protected:
  ProgramResult RunOn(std::vector<std::string> words, const std::vector<std::string>& more) const {
    words.insert(words.end(), {"--starts", "0", "--no-report"});
    words.insert(words.end(), more.begin(), more.end());
    return Run(words);
  }
};

std::string SectionOf(const std::string& out) {
  const std::size_t begin = out.find("On the wagon (");
  return begin == std::string::npos ? "" : out.substr(begin);
}

TEST_F(IdentifyOnWagon, TableHasTheIdentifiedSetsBesideSets1And2) {
  const ProgramResult result = RunOn(CopyMeasurements("lateral", 4), {});
  EXPECT_EQ(result.err, "");
  const std::string section = SectionOf(result.out);
  for (const char* part :
       {"On the wagon (Hbbills 311, empty, geometry nominal-1435)\n", "\n  identified  ", "\n  plain model  ",
        "\n  set 1  ", "\n  set 2  ", "at 12 m/s, both wheelsets put 5 mm beside the running equilibrium",
        "the longitudinal direction was not measured: it comes from set 1", "Written: out/parameters.toml"})
    EXPECT_NE(section.find(part), std::string::npos) << part << "\nin\n" << section;
  for (std::size_t begin = 0; begin < section.size();) {
    const std::size_t end = section.find('\n', begin);
    // The rule has three bytes a column.
    const std::string line = section.substr(begin, end - begin);
    EXPECT_TRUE(line.size() <= 110 || line.starts_with("  ─")) << line;
    begin = end + 1;
  }
}

TEST_F(IdentifyOnWagon, JsonHasTheKeyWithEverySetAndItsInputs) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 4);
  const ProgramResult result = RunOn(records, {"--json", "-"});
  const Json wagon = Json::parse(result.out)["wagon"];
  EXPECT_EQ(wagon["set"], "out/parameters.toml");
  EXPECT_EQ(wagon["cargo"], "empty");
  EXPECT_EQ(wagon["geometry"], "nominal-1435");
  EXPECT_TRUE(wagon["failure"].is_null());
  const Json& speed = wagon["linear_critical_speed"];
  EXPECT_LT(speed["low"], speed["value"]);
  EXPECT_GT(speed["high"], speed["value"]);

  std::map<std::string, Json> sets;
  for (const Json& set : wagon["sets"]) sets[set["role"]] = set;
  ASSERT_EQ(sets.size(), 4u);
  EXPECT_EQ(sets.at("identified")["linear_critical_speed"], speed);
  EXPECT_EQ(sets.at("identified_plain")["set"], "out/parameters_plain.toml");
  EXPECT_TRUE(sets.at("set1")["linear_critical_speed"]["low"].is_null()) << "set 1 has no covariance";
  for (const auto& [role, set] : sets) {
    EXPECT_TRUE(set["failures"].empty()) << role;
    EXPECT_GT(set["linear_critical_speed"]["value"], 0) << role;
    for (const char* key :
         {"amplitude_mm", "frequency_hz", "impacts", "minimum_wheel_load_N", "wheel_lift", "derailed"})
      EXPECT_TRUE(set["hunting"].contains(key)) << role << ' ' << key;
  }
  // Set 1 is where the identified sets get their longitudinal direction from.
  EXPECT_NE(sets.at("identified")["notices"][0].get<std::string>().find("comes from set 1"), std::string::npos);

  std::multiset<std::string> roles;
  for (const Json& file : wagon["inputs"]["files"]) {
    roles.insert(file["role"]);
    EXPECT_EQ(file["sha256"].get<std::string>().size(), 64u) << file;
  }
  EXPECT_EQ(roles, (std::multiset<std::string>{"cargo", "geometry", "set", "set", "set", "set", "wagon"}));
}

TEST_F(IdentifyOnWagon, NoWagonSkipsIt) {
  const ProgramResult result = RunOn(CopyMeasurements("lateral", 1), {"--no-wagon"});
  EXPECT_EQ(SectionOf(result.out), "");
  EXPECT_FALSE(ReadJson("out/result.json").contains("wagon"));
}

TEST_F(IdentifyOnWagon, ChecksumIsThatOfTheWrittenSet) {
  RunOn(CopyMeasurements("lateral", 1), {"--no-diagnosis"});
  const Json set = ReadJson("out/result.json")["wagon"]["sets"][0];
  const ProgramResult sum = RunProgram({"/usr/bin/sha256sum", "out/parameters.toml"}, {.folder = Folder()});
  ASSERT_EQ(sum.exit_code, 0);
  EXPECT_EQ(set["sha256"], sum.out.substr(0, 64));
}

TEST_F(IdentifyOnWagon, CargoGeometryAndSpeedAreAsAsked) {
  RunOn(CopyMeasurements("lateral", 1),
        {"--no-diagnosis", "--cargo", "packed", "--geometry", "thesis-equivalent", "--wagon-speed", "25"});
  const Json wagon = ReadJson("out/result.json")["wagon"];
  EXPECT_EQ(wagon["cargo"], "packed");
  EXPECT_EQ(wagon["geometry"], "thesis-equivalent");
  EXPECT_EQ(wagon["hunting_run"]["speed"], 25.0);
  RunOn({"lateral_01.txt"}, {"--no-diagnosis"});
  EXPECT_NE(ReadJson("out/result.json")["wagon"]["linear_critical_speed"]["value"],
            wagon["linear_critical_speed"]["value"]);
}

TEST_F(IdentifyOnWagon, OptionsThatMakeNoSenseAreSaidBeforeAnythingIsDone) {
  for (const auto& [option, value] : {std::pair{"--cargo", "feathers"},
                                      {"--geometry", "nowhere.toml"},
                                      {"--wagon-speed", "0"},
                                      {"--wagon-speed", "nan"},
                                      {"--wagon-speed", "inf"}}) {
    const ProgramResult result = Run({"a.txt", option, value});
    EXPECT_EQ(result.exit_code, 2) << option;
    EXPECT_NE(result.err.find(option), std::string::npos) << result.err;
    EXPECT_TRUE(List().empty());
  }
}

// Without its data files the wagon is left out; what was identified is there all the same.
TEST_F(IdentifyOnWagon, MissingDataTakeNothingElseDown) {
  Write("lateral.txt", PlainDecay{}.Text());
  std::filesystem::create_directory(Folder() / "no_data");
  setenv("UICLINK_DATA", (Folder() / "no_data").c_str(), 1);
  const ProgramResult result = RunOn({"lateral.txt"}, {});
  unsetenv("UICLINK_DATA");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(result.err.starts_with("on the wagon: nothing could be done: ")) << result.err;
  EXPECT_NE(result.out.find("On the wagon: nothing could be done."), std::string::npos) << result.out;
  const Json json = ReadJson("out/result.json");
  EXPECT_TRUE(json["fit"]["parameters"].contains("k"));
  EXPECT_FALSE(json["wagon"]["failure"].is_null());
  EXPECT_TRUE(json["wagon"]["linear_critical_speed"]["value"].is_null());
  EXPECT_TRUE(Exists("out/parameters.toml"));
  EXPECT_TRUE(Exists("out/residuals.csv"));
}

// The link that made the record, beside the link that was found: within the stated bounds.
TEST_F(IdentifyOnWagon, AKnownLinkHasItsCriticalSpeedWithinTheBounds) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  Write("truth.toml", fmt::format("name = \"truth\"\nsource = \"made\"\nload_N = 3714.0\n[lateral]\nk = {}\n"
                                  "sliders = [ {{ k = {}, T0 = {} }} ]\n",
                                  decay.k, decay.k1, decay.T0));
  const ProgramResult found = RunOn({"lateral.txt"}, {"--json", "-"});
  EXPECT_EQ(found.exit_code, 0) << found.err;
  const Json speed = Json::parse(found.out)["wagon"]["linear_critical_speed"];
  const ProgramResult truth =
      RunProgram({UICLINK_WAGON, "stability", "--set", "truth.toml", "--first", "--json", "-"}, {.folder = Folder()});
  ASSERT_EQ(truth.exit_code, 0) << truth.err;
  const double value = Json::parse(truth.out)["linear_critical_speed"]["value"];
  // 95 % bounds: twice as wide they miss once in ten thousand studies.
  const double half = speed["high"].get<double>() - speed["value"].get<double>();
  EXPECT_NEAR(speed["value"], value, 2 * half);
  EXPECT_LT(half, 0.01 * value) << "bounds that say nothing would hold anything";
}

TEST_F(IdentifyOnWagon, TheNumberOfThreadsDoesNotChangeIt) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 1);
  std::vector<Json> wagons;
  for (const char* threads : {"1", "2"}) {
    RunOn(records, {"--threads", threads});
    wagons.push_back(ReadJson("out/result.json")["wagon"]);
    wagons.back().erase("wall_s");
  }
  EXPECT_EQ(wagons[0], wagons[1]);
}

}  // namespace
}  // namespace uiclink
