// What the program `wagon` prints and writes, and how it is told what to do.

#include <gmock/gmock.h>

#include <cmath>
#include <set>
#include <sstream>

#include "data/checksum.h"
#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

const std::vector<std::string> kCommands{"simulate", "stability", "bifurcation", "spectrum", "contact",
                                         "inertia",  "element",   "sweep",       "reproduce"};

// ---------------------------------------------------------------- options that end at once

TEST_F(WagonProgram, Version) {
  const ProgramResult result = Run({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "wagon " UICLINK_VERSION " (uiclink)\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(WagonProgram, HelpHasCommandsExamplesAndExitCodes) {
  const ProgramResult result = Run({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  for (const std::string& command : kCommands) EXPECT_THAT(result.out, HasSubstr("\n  " + command + " ")) << command;
  EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:\n  wagon stability --set set1\n"),
                                HasSubstr("Exit codes: 0 all done; 1 done, but something was left out or is not "
                                          "trustworthy; 2 nothing could be done.")));
}

TEST_F(WagonProgram, EveryCommandExplainsItself) {
  for (const std::string& command : kCommands) {
    const ProgramResult result = Run({command, "--help"});
    EXPECT_EQ(result.exit_code, 0) << command;
    EXPECT_EQ(result.err, "") << command;
    EXPECT_THAT(result.out, AllOf(HasSubstr("Examples:\n  wagon " + command), HasSubstr("--json"), HasSubstr("--quiet"),
                                  HasSubstr(command == "sweep" ? "--store" : "--out")))
        << command;
  }
}

TEST_F(WagonProgram, HelpOfSimulateHasTheCommonOptionsWithTheirChoices) {
  const std::string help = Run({"simulate", "--help"}).out;
  for (const char* option :
       {"--set", "--cargo", "--geometry", "--contact-table", "--com", "--suspension", "--no-guidance", "--penetration",
        "--speed", "--time", "--start", "--window", "--output-rate", "--save-state", "--resume", "--wagon"})
    EXPECT_THAT(help, HasSubstr(std::string(option) + " ")) << option;
  EXPECT_THAT(help,
              AllOf(HasSubstr("empty, gold, packed, water"), HasSubstr("nominal-1435"), HasSubstr("thesis-equivalent"),
                    HasSubstr("linear|parabolic|leaf"), HasSubstr("printed|corrected"), HasSubstr("touching|printed")));
}

// ---------------------------------------------------------------- misuse

/// Command lines that make no sense, and a part of the message.
struct Misuse {
  const char* name;
  std::vector<std::string> words;
  const char* message;
};

void PrintTo(const Misuse& misuse, std::ostream* out) { *out << misuse.name; }

class EveryMisuseOfWagon : public WagonProgram, public testing::WithParamInterface<Misuse> {};

TEST_P(EveryMisuseOfWagon, EndsWithCode2AndAMessage) {
  const ProgramResult result = Run(GetParam().words);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_THAT(List(), IsEmpty()) << "nothing is written";
}

INSTANTIATE_TEST_SUITE_P(
    WagonProgram, EveryMisuseOfWagon,
    testing::ValuesIn(std::vector<Misuse>{
        {"NoCommand", {}, "subcommand is required"},
        {"UnknownCommand", {"simulat"}, ", found \"simulat\"\n"},
        {"UnknownOption", {"simulate", "--speeed", "20"}, "--speeed"},
        {"SpeedBelowZero", {"simulate", "--speed", "-1"}, "--speed"},
        {"SpeedNoNumber", {"simulate", "--speed", "fast"}, "--speed"},
        {"UnknownSuspension", {"stability", "--suspension", "soft"}, "--suspension"},
        {"UnknownCargo",
         {"inertia", "--cargo", "sand"},
         "sand: expected a file or one of empty, gold, packed, water, found neither"},
        {"UnknownGeometry", {"contact", "--geometry", "broad"}, "broad: expected a file or one of nominal-1435, "},
        {"UnknownSet", {"stability", "--set", "set3"}, "set3: expected a file or one of set1, set2, found neither"},
        {"UnknownPlaceOfASet", {"stability", "--set", "front-middle=set1"}, "before '=', found \"front-middle\""},
        {"TwoSetsForOnePlace", {"stability", "--set", "set1", "--set", "set2"}, "expected one set for each place"},
        {"StartWithoutUnit", {"simulate", "--start", "front_lateral=5"}, "expected a number with its unit (cm, m, mm)"},
        {"StartOfNothing",
         {"simulate", "--start", "none.state"},
         "none.state: expected a readable file, found nothing of that name"},
        {"ResumeWithoutFile", {"simulate", "--resume"}, "--resume: expected --save-state FILE beside it"},
        {"RangeTheWrongWay",
         {"stability", "--from", "30", "--to", "20"},
         "--to: expected more than --from, 30 m/s, found 20"},
        {"TableAndGeometry", {"contact", "--geometry", "nominal-1435", "--contact-table", "t.txt"}, "--contact-table"},
        {"MissingTable",
         {"contact", "--contact-table", "t.txt"},
         "t.txt: expected a readable file, found nothing of that name"},
        {"UnknownBench", {"element", "hammer"}, "hammer"},
        {"NoBench", {"element"}, "bench is required"},
    }),
    [](const auto& misuse) { return std::string(misuse.param.name); });

TEST_F(WagonProgram, FaultsOfFilesAreNamedWithFileAndLine) {
  Write("bad_set.toml", "name = \"bad\"\nsource = \"\"\nload_N = 1.0\n[lateral]\nk = -3.0\nsliders = []\n");
  const ProgramResult set = Run({"stability", "--set", "lateral=bad_set.toml"});
  EXPECT_EQ(set.exit_code, 2);
  EXPECT_EQ(set.err, "bad_set.toml:5: expected k > 0 [1/m], found -3\n");

  Write("bad_cargo.toml", "name = \"bad\"\nsource = \"\"\n[even]\nmass = 100.0\ndensity = 0.0\n");
  const ProgramResult cargo = Run({"inertia", "--cargo", "bad_cargo.toml"});
  EXPECT_EQ(cargo.exit_code, 2);
  EXPECT_THAT(cargo.err, StartsWith("bad_cargo.toml:5: expected "));

  Write("bad_table.txt", "# name: bad\ny a_wheel\n1 2\n");
  const ProgramResult table = Run({"contact", "--contact-table", "bad_table.txt"});
  EXPECT_EQ(table.exit_code, 2);
  EXPECT_THAT(table.err, StartsWith("bad_table.txt:"));

  const std::string nominal = ReadAll(DataFile("geometry/nominal-1435.toml"));
  const std::size_t at = nominal.find("\ngauge_mm = ") + 1;
  ASSERT_GT(at, 0u);
  Write("bad_geometry.toml",
        nominal.substr(0, at) + "gauge_mm = -1" + nominal.substr(nominal.find_first_of("#\n", at)));
  const auto line = 1 + std::count(nominal.begin(), nominal.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  const ProgramResult geometry = Run({"contact", "--geometry", "bad_geometry.toml"});
  EXPECT_EQ(geometry.exit_code, 2);
  EXPECT_THAT(geometry.err, StartsWith("bad_geometry.toml:" + std::to_string(line) +
                                       ": expected 300 <= gauge_mm <= 3000 [mm], found -1"));
}

// ---------------------------------------------------------------- inertia, element, contact

TEST_F(WagonProgram, InertiaPrintsTheFreightsAskedForAndWritesNothingUnasked) {
  const ProgramResult result = Run({"inertia", "--cargo", "water", "gold"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, AllOf(HasSubstr("water"), HasSubstr("gold"), Not(HasSubstr("packed"))));
  EXPECT_THAT(List(), IsEmpty());
  EXPECT_EQ(Run({"inertia", "--quiet"}).out, "");
}

TEST_F(WagonProgram, ResultsRepeatTheirInputsWithChecksums) {
  const Json json = RunJson({"inertia", "--cargo", "water", "gold"});
  EXPECT_EQ(json["schema"], "wagon-inertia/1");
  const Json& files = json["inputs"]["files"];
  ASSERT_EQ(files.size(), 3u) << files;
  const std::vector<std::string> expected{"wagons/hbbills311.toml", "freight/water.toml", "freight/gold.toml"};
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_EQ(files[i]["sha256"], CalcFileSha256(DataFile(expected[i])));
  EXPECT_EQ(json["freights"].size(), 2u);
}

TEST_F(WagonProgram, ElementWritesTablesFiguresAndJson) {
  const ProgramResult result = Run({"element", "leaf-drop", "--beta", "1", "--time", "0.5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const std::vector<std::string> files = List("out");
  const auto count = [&](const std::string& extension) {
    return std::ranges::count_if(files, [&](const std::string& name) { return name.ends_with(extension); });
  };
  EXPECT_GE(count(".csv"), 1);
  EXPECT_GE(count(".svg"), 1);
  EXPECT_EQ(count(".json"), 1);
  for (const std::string& file : files) EXPECT_THAT(result.out, HasSubstr("out/" + file));
  EXPECT_EQ(Json::parse(Read("out/element_leaf-drop.json"))["schema"], "wagon-element/1");
}

TEST_F(WagonProgram, EveryBenchRuns) {
  for (const std::string bench : {"leaf-harmonic", "leaf-drop", "parabolic", "guidance", "dry-friction"}) {
    const Json json = RunJson({"element", bench, "--out", bench, "--time", "1"});
    EXPECT_EQ(json["bench"], bench);
    EXPECT_FALSE(List(bench).empty()) << bench;
  }
}

TEST_F(WagonProgram, AContactTableIsWrittenAndPutBack) {
  const ProgramResult written = Run({"contact", "--out", "table.txt"});
  EXPECT_EQ(written.exit_code, 0) << written.err;
  EXPECT_THAT(List(), AllOf(testing::Contains("table.txt"), testing::Contains("table_quantities.svg"),
                            testing::Contains("table_conicity.svg")));
  const Json direct = RunJson({"contact"});
  const Json again = RunJson({"contact", "--contact-table", "table.txt"});
  EXPECT_EQ(direct["schema"], "wagon-contact/1");
  EXPECT_EQ(direct["rows"], again["rows"]);
  EXPECT_EQ(again["inputs"]["files"][0]["role"], "contact_table");
  EXPECT_EQ(again["inputs"]["files"][0]["sha256"], CalcFileSha256(Folder() / "table.txt"));
}

// ---------------------------------------------------------------- stability

TEST_F(WagonProgram, StabilityWritesItsFilesAndSaysWhatItFound) {
  const ProgramResult result = Run({"stability", "--from", "5", "--to", "8", "--step", "1"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(List("out"), ElementsAre("eigenvalues.csv", "root_locus.svg", "stability.json", "stability_report.html"));
  EXPECT_THAT(result.out, HasSubstr("Written: out/eigenvalues.csv out/root_locus.svg out/stability.json "
                                    "out/stability_report.html\n"));
  const Json json = Json::parse(Read("out/stability.json"));
  EXPECT_EQ(json["schema"], "wagon-stability/1");
  for (const char* key :
       {"version", "inputs", "linear_critical_speed", "crossings", "structural_zeros", "searched", "wall_s"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["structural_zeros"], 20);
}

// ---------------------------------------------------------------- simulate

/// Short enough for a test; long enough for a few periods.
const std::vector<std::string> kShortRun{"simulate", "--speed", "20",      "--time",           "2",
                                         "--window", "1",       "--start", "front_lateral=2mm"};

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST_F(WagonProgram, SimulateHasAllKeysOfItsSchema) {
  const Json json = RunJson(kShortRun);
  EXPECT_EQ(json["schema"], "wagon-simulate/1");
  for (const char* key :
       {"amplitude_mm", "frequency_hz", "clearance_used_mm", "impacts", "minimum_wheel_load_N", "wheel_lift",
        "derailed", "simulated_s", "wall_s", "rhs_calls", "steps", "events", "inputs", "speed", "start", "window_s"})
    EXPECT_TRUE(json.contains(key)) << key;
  for (const char* key : {"front_lateral", "rear_lateral", "body_lateral", "front_longitudinal", "rear_longitudinal"})
    EXPECT_TRUE(json["amplitude_mm"][key].is_number()) << key;
  for (const char* key : {"front_lateral", "rear_lateral", "front_longitudinal", "rear_longitudinal"}) {
    EXPECT_TRUE(json["clearance_used_mm"][key].is_number()) << key;
    EXPECT_TRUE(json["impacts"][key]["count"].is_number_integer()) << key;
    EXPECT_TRUE(json["impacts"][key]["peak_N"].is_number()) << key;
  }
  EXPECT_TRUE(json["frequency_hz"]["front_longitudinal"].is_array());
  EXPECT_EQ(json["simulated_s"], 2.0);
  EXPECT_EQ(json["wheel_lift"], false);
  EXPECT_THAT(List("out"), ElementsAre("histories.csv", "histories.mat", "histories.svg", "simulation.json",
                                       "simulation_report.html"));
  EXPECT_EQ(Json::parse(Read("out/simulation.json"))["amplitude_mm"], json["amplitude_mm"]);
}

/// Rows of a CSV file, the head first.
std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST_F(WagonProgram, HistoriesHaveARowForEverySampleAndUnitsInTheirHead) {
  Run(With(kShortRun, {"--output-rate", "50"}));
  const std::vector<std::string> lines = Lines(Read("out/histories.csv"));
  ASSERT_EQ(lines.size(), 1u + 101u);  // 2 s at 50 Hz, both ends
  EXPECT_THAT(lines[0], AllOf(StartsWith("time_s,front_x_m,front_x_rate_m_per_s,front_y_m,"),
                              HasSubstr(",body_phi_rad,"), HasSubstr(",front_left_wheel_load_N,")));
  EXPECT_THAT(lines[1], StartsWith("0,"));
  EXPECT_THAT(lines.back(), StartsWith("2,"));
  Run(With(kShortRun, {"--output-rate", "0", "--out", "bare", "--no-report"}));
  EXPECT_THAT(List("bare"), ElementsAre("simulation.json"));
}

TEST_F(WagonProgram, ARunThatIsResumedGoesOnBitByBit) {
  const auto run = [&](const std::string& time, const std::vector<std::string>& more) {
    return RunJson(
        With({"simulate", "--speed", "20", "--start", "front_lateral=2mm", "--window", "1", "--time", time}, more));
  };
  const Json whole = run("4", {"--out", "whole"});
  run("2", {"--out", "parts", "--save-state", "run.state"});
  const Json rest = run("4", {"--out", "parts", "--save-state", "run.state", "--resume"});
  EXPECT_EQ(rest["start"]["time_s"], 2.0);
  // An extreme at the window's edge is that of a sample, whose time, the start plus i/200 s, rounds differently.
  for (const auto& [motion, amplitude] : whole["amplitude_mm"].items())
    EXPECT_NEAR(rest["amplitude_mm"][motion].get<double>(), amplitude.get<double>(), 1e-12 * amplitude.get<double>())
        << motion;
  EXPECT_THAT(List("parts"),
              ElementsAre("histories.csv", "histories.mat", "histories.svg", "histories_from_2s.csv",
                          "histories_from_2s.mat", "histories_from_2s.svg", "simulation.json",
                          "simulation_from_2s.json", "simulation_report.html", "simulation_report_from_2s.html"));
  // The last sample: every motion and force to the last bit.
  EXPECT_EQ(Lines(Read("parts/histories_from_2s.csv")).back(), Lines(Read("whole/histories.csv")).back());
}

TEST_F(WagonProgram, AStateOfAnotherWagonIsNotResumed) {
  Run({"simulate", "--time", "1", "--window", "1", "--save-state", "run.state", "--quiet"});
  const ProgramResult result =
      Run({"simulate", "--time", "2", "--save-state", "run.state", "--resume", "--set", "set2"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, StartsWith("run.state:"));
  const ProgramResult started = Run({"simulate", "--time", "1", "--window", "1", "--start", "run.state", "--cargo",
                                     "water", "--out", "other", "--quiet"});
  EXPECT_EQ(started.exit_code, 0) << "--start takes any state: " << started.err;
}

TEST_F(WagonProgram, QuietAndJsonLeaveStandardOutputAlone) {
  EXPECT_EQ(Run(With(kShortRun, {"--quiet"})).out, "");
  const ProgramResult result = Run(With(kShortRun, {"--json", "result.json", "--quiet"}));
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(Json::parse(Read("result.json"))["schema"], "wagon-simulate/1");
}

TEST_F(WagonProgram, WithoutGnuplotPicturesAreLeftOutWithANotice) {
  const ProgramResult result = RunProgram({"/usr/bin/env", "PATH=" + Folder().string(), UICLINK_WAGON, "stability",
                                           "--from", "5", "--to", "6", "--step", "1"},
                                          {.folder = Folder()});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err,
            "note: root_locus.svg is left out: the figure cannot be drawn: gnuplot is not installed (Debian package "
            "gnuplot-nox)\n");
  EXPECT_THAT(List("out"), ElementsAre("eigenvalues.csv", "stability.json", "stability_report.html"));
}

}  // namespace
}  // namespace uiclink
