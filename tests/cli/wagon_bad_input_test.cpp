// What a user can get wrong: every fault ends with code 2, a message that names the file or the option and what was
// expected, and nothing written.

#include <gmock/gmock.h>

#include <array>
#include <sstream>

#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// A file of data/ in which `key = ...` has another value.
std::string WithValue(const std::string& file, const std::string& key, const std::string& value) {
  std::string text = ReadAll(DataFile(file));
  const std::size_t at = text.find("\n" + key + " = ") + 1;
  if (at == 0) throw std::runtime_error(file + " has no " + key);
  const std::size_t end = text.find_first_of("#\n", at);
  return text.replace(at, end - at, key + " = " + value + " ");
}

class WagonBadInput : public WagonProgram {
 protected:
  /// The message of a command that must fail.
  std::string FaultOf(const std::vector<std::string>& words) const {
    const ProgramResult result = Run(words);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_FALSE(Exists("out")) << "nothing is written";
    return result.err;
  }
};

// ---------------------------------------------------------------- options

TEST_F(WagonBadInput, NumbersOutsideWhatTheModelMeansAreRefused) {
  const std::vector<std::array<std::string, 3>> cases{
      {"simulate", "--speed", "1e9"},       {"simulate", "--speed", "1e-300"},
      {"simulate", "--speed", "20m/s"},     {"simulate", "--time", "nan"},
      {"simulate", "--time", "1e300"},      {"simulate", "--window", "-1"},
      {"simulate", "--tolerance", "1e9"},   {"simulate", "--tolerance", "1e-300"},
      {"simulate", "--output-rate", "inf"}, {"simulate", "--friction", "1e300"},
      {"simulate", "--friction", "0"},      {"stability", "--from", "1e-300"},
      {"stability", "--to", "1e300"},       {"stability", "--step", "1e-300"},
      {"stability", "--tolerance", "1e300"}};
  for (const auto& [command, option, value] : cases) {
    EXPECT_THAT(FaultOf({command, option, value}),
                AllOf(StartsWith(option + ": expected a number from "), HasSubstr(", found \"" + value + "\"")));
  }
  for (const char* option : {"--beta", "--amplitude", "--mass", "--frequency", "--mu", "--perturbation", "--pull"}) {
    for (const char* value : {"nan", "1e300"})
      EXPECT_THAT(FaultOf({"element", "guidance", option, value}), HasSubstr("expected a number from "));
  }
}

TEST_F(WagonBadInput, AnOptionThatMeansNothingToABenchIsNoted) {
  const ProgramResult result = Run({"element", "leaf-drop", "--time", "0.5", "--pull", "3", "--quiet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "note: --pull means nothing to leaf-drop; it is for dry-friction\n");
}

TEST_F(WagonBadInput, MoreSamplesThanMemoryHoldsAreRefused) {
  EXPECT_THAT(FaultOf({"simulate", "--time", "1e6", "--output-rate", "1e5"}),
              HasSubstr("--output-rate: expected at most 1e+06 samples, 1 Hz over 1e+06 s, found 100000 Hz"));
}

TEST_F(WagonBadInput, StartsBesideTheRailsAreRefused) {
  EXPECT_THAT(
      FaultOf({"simulate", "--start", "rear_lateral=-20mm"}),
      HasSubstr("--start: expected wheelsets within the contact table, 9 mm to either side, found one at -20 mm"));
  EXPECT_THAT(FaultOf({"simulate", "--start", "body_roll=90deg"}), HasSubstr("expected at most 100 mrad"));
}

// ---------------------------------------------------------------- files

TEST_F(WagonBadInput, NoFileIsToldFromAFolderAndFromBytes) {
  Write("empty", "");
  Write("bytes", std::string("\x00\xff\xfe\x01\n\x80", 6));
  std::filesystem::create_directory(Folder() / "folder");
  const std::vector<std::vector<std::string>> commands{{"stability", "--set"},      {"stability", "--contact-table"},
                                                       {"stability", "--geometry"}, {"inertia", "--cargo"},
                                                       {"inertia", "--wagon"},      {"simulate", "--start"}};
  for (const std::vector<std::string>& command : commands) {
    for (const char* file : {"./empty", "./bytes", "./folder", "./none"}) {
      const std::string message = FaultOf({command[0], command[1], file});
      EXPECT_THAT(message, AllOf(StartsWith(file), HasSubstr("expected "), HasSubstr("found"))) << command[1];
      EXPECT_THAT(message, Not(HasSubstr("\xff"))) << "bytes of a file have no place on a terminal";
    }
  }
}

TEST_F(WagonBadInput, FilesOfOtherSystemsAreRead) {
  std::string cargo = "\xef\xbb\xbf";
  for (const char c : ReadAll(DataFile("freight/water.toml"))) cargo += c == '\n' ? "\r\n" : std::string(1, c);
  Write("water.toml", cargo);
  EXPECT_EQ(RunJson({"inertia", "--cargo", "./water.toml"})["freights"],
            RunJson({"inertia", "--cargo", "water"})["freights"]);
}

TEST_F(WagonBadInput, LengthsInOtherUnitsAreFoundByKey) {
  const std::vector<std::array<std::string, 2>> cases{
      {"r0_mm", "0.46"},   {"gauge_mm", "1.435"},      {"back_to_back_mm", "1"}, {"tape_circle_mm", "0.07"},
      {"young", "210000"}, {"rail_offset_mm", "1000"}, {"y_max_mm", "0.009"},    {"wheel_load_N", "0"}};
  for (const auto& [key, value] : cases) {
    Write("track.toml", WithValue("geometry/nominal-1435.toml", key, value));
    EXPECT_THAT(FaultOf({"contact", "--geometry", "track.toml"}),
                AllOf(StartsWith("track.toml:"), HasSubstr(" <= " + key + " <= ")))
        << key;
  }
}

TEST_F(WagonBadInput, WheelsThatDoNotFitOnTheRailsAreRefused) {
  const std::vector<std::array<std::string, 3>> cases{
      {"gauge_mm", "1676", "a wheel has no rail below it"},
      {"gauge_mm", "1400", "expected wheels that stand on their treads"},
      {"back_to_back_mm", "1430", "expected wheels that stand on their treads"},
      {"rail_offset_mm", "-20", "expected wheels that stand on their treads"},
      {"gauge_depth_mm", "60", "the profile ends"},
      {"y_max_mm", "100", "the profile is too short"}};
  for (const auto& [key, value, message] : cases) {
    Write("track.toml", WithValue("geometry/nominal-1435.toml", key, value));
    EXPECT_THAT(FaultOf({"stability", "--geometry", "track.toml"}),
                AllOf(StartsWith("track.toml: "), HasSubstr(message)))
        << key;
  }
  for (const auto& [key, value] : {std::pair{"gauge_mm", "1430"},
                                   {"gauge_mm", "1445"},
                                   {"cant", "0"},
                                   {"cant", "0.05"},
                                   {"rail", "\"60E1\""},
                                   {"wheel_load_N", "1000"},
                                   {"wheel_load_N", "200000"}}) {
    Write("track.toml", WithValue("geometry/nominal-1435.toml", key, value));
    EXPECT_EQ(Run({"contact", "--geometry", "track.toml", "--quiet"}).exit_code, 0) << key << " = " << value;
  }
}

TEST_F(WagonBadInput, AWagonWithoutInertiaIsRefused) {
  for (const auto& [key, value] :
       {std::pair{"I_y", "0"}, {"I_z", "1e-9"}, {"m", "1e-3"}, {"g", "-9.82"}, {"l", "5000"}}) {
    Write("wagon.toml", WithValue("wagons/hbbills311.toml", key, value));
    EXPECT_THAT(FaultOf({"stability", "--wagon", "wagon.toml"}),
                AllOf(StartsWith("wagon.toml:"), HasSubstr(std::string(" <= ") + key + " <= ")))
        << key;
  }
}

// ---------------------------------------------------------------- contact tables

class WagonContactTable : public WagonBadInput {
 protected:
  void SetUp() override {
    ASSERT_EQ(Run({"contact", "--quiet", "--out", "table.txt"}).exit_code, 0);
    std::istringstream text(Read("table.txt"));
    for (std::string line; std::getline(text, line);) (line.starts_with('#') ? head_ : rows_).push_back(line);
  }
  /// The table with one column of all its rows (or of some) changed.
  void WriteWith(const std::string& column, double (*change)(double)) const {
    std::string text;
    for (const std::string& line : head_) text += line + "\n";
    std::istringstream names(rows_[0]);
    std::size_t at = 0;
    for (std::string name; names >> name && name != column;) ++at;
    text += rows_[0] + "\n";
    for (std::size_t i = 1; i < rows_.size(); ++i) {
      std::istringstream row(rows_[i]);
      std::size_t place = 0;
      for (double value = 0; row >> value; ++place) {
        std::ostringstream number;
        number.precision(17);
        number << (place == at ? change(value) : value) << " ";
        text += number.str();
      }
      text += "\n";
    }
    Write("changed.txt", text);
  }
  std::vector<std::string> head_, rows_;
};

TEST_F(WagonContactTable, ItsOwnTableReadBackGivesTheSameCriticalSpeed) {
  const Json direct = RunJson({"stability", "--from", "2", "--to", "30"});
  const Json again = RunJson({"stability", "--from", "2", "--to", "30", "--contact-table", "table.txt"});
  EXPECT_EQ(direct["crossings"], again["crossings"]);
}

TEST_F(WagonContactTable, ColumnsInOtherUnitsAreFound) {
  const auto in_mm = [](double value) { return 1e3 * value; };
  WriteWith("r", in_mm);
  EXPECT_THAT(FaultOf({"stability", "--contact-table", "changed.txt"}),
              StartsWith("changed.txt: expected r [m] from 0.23"));
  WriteWith("y", in_mm);
  EXPECT_THAT(FaultOf({"stability", "--contact-table", "changed.txt"}),
              StartsWith("changed.txt: expected y from 0.1 mm to 200 mm to either side"));
  WriteWith("c22", [](double) { return 1e30; });
  EXPECT_THAT(FaultOf({"stability", "--contact-table", "changed.txt"}),
              StartsWith("changed.txt: expected Kalker's coefficients from 0 to 1000, found 1e+30"));
  WriteWith("n0", [](double) { return 1e-30; });
  EXPECT_THAT(FaultOf({"stability", "--contact-table", "changed.txt"}), StartsWith("changed.txt: expected n0 [N]"));
}

// ---------------------------------------------------------------- sets

TEST_F(WagonBadInput, FaultsOfASetThatOnlyTheModelSeesNameItsFile) {
  const std::string head = "name = \"x\"\nsource = \"\"\nload_N = 1.0\n[lateral]\nk = 4.0\n";
  const auto fault = [&](const std::string& rest) {
    Write("set.toml", head + rest);
    return FaultOf({"stability", "--set", "set.toml"});
  };
  EXPECT_EQ(fault("sliders = []\neffects = [ { id = \"magic\" } ]\n"),
            "set.toml: [lateral] expected an effect of the catalogue, found \"magic\"\n");
  EXPECT_THAT(fault("sliders = []\neffects = [ { id = \"viscous_damping\", c = 5.0 } ]\n"),
              StartsWith("set.toml: [lateral] viscous_damping: c: expected from 0"));
  std::string sliders = "sliders = [";
  for (int i = 0; i < 40; ++i) sliders += "{ k = 0.2, T0 = 0.001 }, ";
  EXPECT_EQ(fault(sliders + "]\n"), "set.toml: [lateral] 40 sliders, must be at most 16\n");
}

/// Every effect of the catalogue at a size that an identification may find, or with nothing where all it has belongs
/// to a record.
struct EffectCase {
  const char* id;
  const char* values;
  bool acts;  ///< on the wagon
};
constexpr std::array<EffectCase, 20> kEffects{{{"viscous_damping", ", c = 0.01", true},
                                               {"quadratic_drag", ", d = 0.5", true},
                                               {"rolling_friction", ", T_r = 0.0003", true},
                                               {"micro_slip", ", k = 3.0, y_max = 0.01", true},
                                               {"extra_slider", ", k = 3.0, y_c = 0.001", true},
                                               {"cubic_stiffness", ", k3 = 500.0", true},
                                               {"quadratic_stiffness", ", k2 = -10.0", true},
                                               {"stribeck_friction", ", s = 0.3, v_s = 0.05", true},
                                               {"velocity_strengthening", ", b = 2.0", true},
                                               {"friction_drift", ", rate = 0.01", false},
                                               {"asymmetric_friction", ", a = 0.2", true},
                                               {"pendulum_geometry", ", l = 0.3", true},
                                               {"clearance", ", gap = 0.0005", true},
                                               {"end_stop", ", k = 5.0, position = 0.002", true},
                                               {"cross_axis_motion", ", f = 1.0, decay = 0.1", false},
                                               {"rig_mode", ", f = 30.0, zeta = 0.1", false},
                                               {"sensor_drift", "", false},
                                               {"sensor_saturation", ", level = 0.01", false},
                                               {"sensor_nonlinearity", ", e = 1.0", false},
                                               {"mains_hum", ", f = 50.0", false}}};

TEST_F(WagonBadInput, EveryEffectRunsOrIsSaidToBeLeftOut) {
  const auto set = [](const std::string& effects) {
    return "name = \"x\"\nsource = \"\"\nload_N = 3714.0\n[lateral]\nk = 4.201\nsliders = [ { k = 1.4222, T0 = 0.014 } "
           "]\n" +
           effects + "[longitudinal]\nk = 6.4763\nsliders = [ { k = 2.0, T0 = 6e-3 } ]\n" + effects;
  };
  const auto run = [&](const std::string& effects, std::string* notes) {
    Write("set.toml", set(effects));
    const ProgramResult result = Run({"simulate", "--set", "set.toml", "--speed", "24", "--time", "2", "--window", "2",
                                      "--start", "front_lateral=6mm", "--output-rate", "0", "--json", "-"});
    EXPECT_EQ(result.exit_code, 0) << effects << result.err;
    *notes = result.err;
    return Json::parse(result.out, nullptr, false)["amplitude_mm"];
  };
  std::string notes;
  const Json plain = run("", &notes);
  EXPECT_EQ(notes, "");
  for (const EffectCase& effect : kEffects) {
    const std::string line = std::string("effects = [ { id = \"") + effect.id + "\"" + effect.values + " } ]\n";
    const Json amplitudes = run(line, &notes);
    EXPECT_EQ(amplitudes == plain, !effect.acts) << effect.id << " acts, or does not";
    const std::string left_out =
        std::string("note: effect ") + effect.id + " of set.toml has no place on a wagon and is left out (all links)\n";
    EXPECT_EQ(notes, effect.acts ? "" : left_out);
    const ProgramResult stability = Run({"stability", "--set", "set.toml", "--to", "10", "--quiet"});
    EXPECT_EQ(stability.exit_code, 0) << effect.id << stability.err;
  }
}

// ---------------------------------------------------------------- freight

TEST_F(WagonBadInput, FreightThatNoTrackTakesIsNotedAndOneThatTurnsTheWagonOverRefused) {
  Write("heavy.toml", "name = \"heavy\"\nsource = \"\"\n[even]\nmass = 200000.0\ndensity = 7800.0\n");
  EXPECT_THAT(Run({"inertia", "--cargo", "heavy.toml"}).err, HasSubstr("note: heavy makes an axle load of 10"));
  Write("far.toml",
        "name = \"far\"\nsource = \"\"\n[[boxes]]\nmass = 1e4\nlength = 1.0\nwidth = 1.0\nheight = 1.0\nx = 50.0\n");
  EXPECT_THAT(FaultOf({"stability", "--cargo", "far.toml"}), HasSubstr("a corner of the wagon lifts"));
}

// ---------------------------------------------------------------- states and results

TEST_F(WagonBadInput, AResumedRunNamesTheInputsThatDiffer) {
  const std::vector<std::string> begin{"simulate", "--time",  "0.3",   "--window", "0.2",          "--output-rate",
                                       "0",        "--quiet", "--out", "first",    "--save-state", "run.state"};
  ASSERT_EQ(Run(begin).exit_code, 0);
  const std::vector<std::string> resume{"simulate", "--time", "0.6", "--save-state", "run.state", "--resume"};
  const auto fault = [&](std::vector<std::string> more) {
    more.insert(more.begin(), resume.begin(), resume.end());
    return FaultOf(more);
  };
  const std::string head = "run.state:2: expected a state of the same inputs, ";
  EXPECT_EQ(fault({"--speed", "21"}), head + "'speed=21', found one of 'speed=20'\n");
  EXPECT_THAT(fault({"--tolerance", "1e-4"}), StartsWith(head + "'tolerance=0.0001', found one of 'tolerance="));
  EXPECT_EQ(fault({"--start", "front_lateral=5mm"}),
            head + "'start=front_lateral=5mm', found one of 'start=equilibrium'\n");
  EXPECT_EQ(fault({"--suspension", "leaf", "--no-guidance"}),
            head + "'suspension=leaf guidance=no', found one of 'suspension=parabolic guidance=yes'\n");
  EXPECT_THAT(fault({"--cargo", "packed"}), StartsWith(head + "'cargo="));
  EXPECT_THAT(fault({"--set", "set2"}), StartsWith(head + "'set="));

  const std::string state = Read("run.state");
  Write("run.state", state.substr(0, 700));
  EXPECT_THAT(fault({}), StartsWith("run.state:"));
  Write("run.state", state.substr(0, state.find("\nt: ") + 1) + "t: nan" + state.substr(state.find("\nfront_x: ")));
  EXPECT_EQ(fault({}), "run.state:4: expected a finite number, found nan\n");
}

TEST_F(WagonBadInput, PlacesThatCannotBeWrittenAreFoundBeforeTheRun) {
  Write("file", "");
  EXPECT_THAT(FaultOf({"simulate", "--time", "1e6", "--output-rate", "1", "--out", "file/results"}),
              StartsWith("file/results: expected a folder for results, found the file "));
  EXPECT_THAT(FaultOf({"simulate", "--time", "1e6", "--output-rate", "1", "--save-state", "."}),
              StartsWith(".: expected a file that can be written, found a directory"));
  EXPECT_THAT(FaultOf({"stability", "--json", "file/result.json"}), HasSubstr("expected a folder for results"));
}

TEST_F(WagonBadInput, AResultThatFindsNoRoomIsNoSuccess) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full";
  for (const char* command : {"inertia", "contact --json -"}) {
    const ProgramResult result = RunProgram(
        {"/bin/sh", "-c", "'" UICLINK_WAGON "' " + std::string(command) + " > /dev/full"}, {.folder = Folder()});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_EQ(result.err, "standard output: expected room for the result, found none\n");
  }
  EXPECT_EQ(FaultOf({"inertia", "--json", "/dev/full", "--quiet"}),
            "/dev/full: expected a file that can be written, found no space left\n");
}

}  // namespace
}  // namespace uiclink
