// `identify compare`: parameter sets side by side.

#include <numbers>

#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

class IdentifyCompare : public IdentifyProgram {
 protected:
  void WriteSet(const std::string& file, const std::string& name, double k, double k1, double T0, double g = 9.82,
                const std::string& more = "") const {
    Write(file, fmt::format("name = \"{}\"\nsource = \"made for a test\"\nload_N = 3714.0\ng = {}\n[lateral]\nk = {}\n"
                            "sliders = [ {{ k = {}, T0 = {} }} ]\n{}",
                            name, g, k, k1, T0, more));
  }
  /// The truth of a decay, and a set that is wrong in every value.
  void WriteTruthAndWrong(const PlainDecay& decay) const {
    WriteSet("truth.toml", "truth", decay.k, decay.k1, decay.T0);
    WriteSet("wrong.toml", "wrong", 1.2 * decay.k, 0.8 * decay.k1, 0.7 * decay.T0);
  }
  std::string Shipped(const std::string& set) const { return UICLINK_SOURCE_DIR "/data/parameter_sets/" + set; }
};

TEST_F(IdentifyCompare, TheTruthLeavesNothingButNoise) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  WriteTruthAndWrong(decay);
  const ProgramResult result = Run({"compare", "wrong.toml", "truth.toml", "--records", "lateral.txt", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["schema"], "identify-compare/1");
  ASSERT_EQ(json["directions"].size(), 1u);
  const Json& lateral = json["directions"][0];
  EXPECT_EQ(lateral["best"], "truth");
  const Json& results = lateral["records"][0]["results"];
  // Three unknowns in 2300 samples: rms = noise within the 1.5 % of the rms and the 2 % of the noise level.
  EXPECT_NEAR(results[1]["rms_over_noise"], 1, 0.06);
  EXPECT_GT(results[0]["rms_over_noise"], 50);
  EXPECT_EQ(results[1]["converged"], true);
  EXPECT_EQ(lateral["overall"], Json::array({{{"rms_mm", results[0]["rms_mm"]},
                                              {"rms_over_noise", results[0]["rms_over_noise"]},
                                              {"converged", results[0]["converged"]}},
                                             {{"rms_mm", results[1]["rms_mm"]},
                                              {"rms_over_noise", results[1]["rms_over_noise"]},
                                              {"converged", results[1]["converged"]}}}))
      << "one record is all records";
}

TEST_F(IdentifyCompare, FrequencyAndLossOfTheTruthAreThoseMeasured) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  WriteTruthAndWrong(decay);
  const ProgramResult result = Run({"compare", "truth.toml", "wrong.toml", "--records", "lateral.txt", "--json", "-"});
  const Json points = Json::parse(result.out)["directions"][0]["points"];
  ASSERT_GE(points.size(), 4u);
  double last = 1;
  for (const Json& point : points) {
    const Json& f = point["frequency_hz"];
    const Json& loss = point["loss_per_half_cycle_mm"];
    // Extrema are located within some 2 ms and 0.005 mm (noise of 0.0125 mm over a window): 0.3 % of a period.
    EXPECT_NEAR(f["sets"][0].get<double>() / f["measured"].get<double>(), 1, 0.003) << point;
    EXPECT_NEAR(loss["sets"][0], loss["measured"], 0.02) << point;
    EXPECT_NEAR(point["loss_per_cycle_mm"]["measured"], 2 * loss["measured"].get<double>(), 1e-12);
    EXPECT_LT(point["amplitude_mm"].get<double>() / 1e3, last) << "by falling amplitude";
    last = point["amplitude_mm"].get<double>() / 1e3;
  }
  // A set with 30 % less friction loses about that much less.
  const Json& loss = points[0]["loss_per_half_cycle_mm"];
  EXPECT_LT(loss["sets"][1].get<double>(), 0.8 * loss["measured"].get<double>());
}

// The closed forms, by hand: below T0/k1 the link rolls, W = 4 T0 (A - T0/k1) above.
TEST_F(IdentifyCompare, WithoutRecordsBackboneAndLossStandSideBySide) {
  const ProgramResult result = Run({"compare", Shipped("set1.toml"), Shipped("set2.toml"), "--json", "-"});
  EXPECT_EQ(result.exit_code, 0);
  const Json json = Json::parse(result.out);
  ASSERT_EQ(json["directions"].size(), 2u);
  const Json& lateral = json["directions"][0];
  EXPECT_EQ(lateral["parameters"][0], Json::parse(R"({"k": 4.2010, "k1": 1.4222, "T01": 0.014, "sum_ki": 1.4222,
                                                      "sum_T0i": 0.014})"));
  EXPECT_FALSE(lateral.contains("best"));
  ASSERT_EQ(lateral["backbone"].size(), 7u);
  const Json& at_5_mm = lateral["backbone"][1];
  EXPECT_EQ(at_5_mm["amplitude_mm"], 5.0);
  const double rolling = std::sqrt(9.82 * (4.2010 + 1.4222)) / (2 * std::numbers::pi);
  EXPECT_NEAR(at_5_mm["frequency_hz"][0], rolling, 1e-12);
  EXPECT_EQ(at_5_mm["energy_per_cycle_mm"][0], 0.0);
  EXPECT_NEAR(at_5_mm["energy_per_cycle_mm"][1], 4 * 0.018 * (5 - 18 / 10.503), 1e-12);
}

TEST_F(IdentifyCompare, TextNamesTheBetterSetInOneSentence) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  WriteTruthAndWrong(decay);
  const ProgramResult result = Run({"compare", "wrong.toml", "truth.toml", "--records", "lateral.txt"});
  EXPECT_TRUE(result.out.starts_with("  set    file        load        g  source\n")) << result.out;
  EXPECT_NE(result.out.find("\nlateral: 1 record\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("  truth does best: rms 0.01"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("; it is the closest on 1 of 1 records.\n"), std::string::npos) << result.out;
  EXPECT_EQ(Run({"compare", "wrong.toml", "truth.toml", "--records", "lateral.txt", "--quiet"}).out, "");
}

// The same link, normalised with another g: k g is what was measured, so nothing changes on the record.
TEST_F(IdentifyCompare, ASetOfAnotherGravityMovesTheSame) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  const double scale = 9.82 / 9.81;
  WriteSet("a.toml", "a", decay.k, decay.k1, decay.T0);
  WriteSet("b.toml", "b", decay.k * scale, decay.k1 * scale, decay.T0 * scale, 9.81);
  const ProgramResult result = Run({"compare", "a.toml", "b.toml", "--records", "lateral.txt", "--json", "-"});
  const Json results = Json::parse(result.out)["directions"][0]["records"][0]["results"];
  const double a = results[0]["rms_mm"], b = results[1]["rms_mm"];
  EXPECT_NEAR(a / b, 1, 1e-6);  // both stop when the sum of squares falls by less than 1e-9
}

// An effect of no size changes nothing: the simulated cycles and fits are those of the closed form.
TEST_F(IdentifyCompare, AnEffectOfNoSizeIsThePlainModel) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  WriteSet("plain.toml", "plain", decay.k, decay.k1, decay.T0);
  WriteSet("extended.toml", "extended", decay.k, decay.k1, decay.T0, 9.82,
           "effects = [ { id = \"viscous_damping\", c = 0.0 } ]\n");
  const ProgramResult result =
      Run({"compare", "plain.toml", "extended.toml", "--records", "lateral.txt", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const Json lateral = Json::parse(result.out)["directions"][0];
  const Json& results = lateral["records"][0]["results"];
  // Both fits stop when the sum of squares falls by less than 1e-9.
  EXPECT_NEAR(results[1]["rms_mm"].get<double>() / results[0]["rms_mm"].get<double>(), 1, 1e-6);
  for (const Json& point : lateral["points"]) {
    const Json &f = point["frequency_hz"]["sets"], &loss = point["loss_per_half_cycle_mm"]["sets"];
    // Between simulated cycles, which lie about half a millimetre apart, by straight lines.
    EXPECT_NEAR(f[1].get<double>() / f[0].get<double>(), 1, 2e-3) << point;
    EXPECT_NEAR(loss[1], loss[0], 0.03) << point;
  }
  for (const Json& point : lateral["backbone"]) {
    EXPECT_NEAR(point["frequency_hz"][1], point["frequency_hz"][0], 1e-9) << point;  // turning points to 1e-12 periods
    EXPECT_EQ(point["energy_per_cycle_mm"][1], point["energy_per_cycle_mm"][0]) << point;
  }
  EXPECT_EQ(lateral["parameters"][1]["effects"], Json::parse(R"([{"id": "viscous_damping", "c": 0.0}])"));
}

// W = pi c w A^2 beside the sliders' loss.
TEST_F(IdentifyCompare, LossOfAnEffectAddsToThatOfTheSliders) {
  const PlainDecay decay;
  WriteSet("plain.toml", "plain", decay.k, decay.k1, decay.T0);
  WriteSet("extended.toml", "extended", decay.k, decay.k1, decay.T0, 9.82,
           "effects = [ { id = \"viscous_damping\", c = 0.012 } ]\n");
  const ProgramResult result = Run({"compare", "plain.toml", "extended.toml", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  for (const Json& point : Json::parse(result.out)["directions"][0]["backbone"]) {
    const double A = point["amplitude_mm"], f = point["frequency_hz"][1];
    const Json& energy = point["energy_per_cycle_mm"];
    const double damping = std::numbers::pi * 0.012 * 2 * std::numbers::pi * f * 1e-3 * A * A;
    EXPECT_NEAR(energy[1], energy[0].get<double>() + damping, 1e-9) << point;  // digits of the JSON
  }
}

TEST_F(IdentifyCompare, EffectsStandAmongTheParameters) {
  WriteSet("plain.toml", "plain", 3.41, 2.21, 0.018);
  WriteSet("extended.toml", "extended", 3.41, 2.21, 0.018, 9.82,
           "effects = [ { id = \"viscous_damping\", c = 0.012 }, { id = \"sensor_drift\" } ]\n");
  const ProgramResult result = Run({"compare", "plain.toml", "extended.toml"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("\n  viscous_damping.c  s/m       -     0.012\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("\n  sensor_drift                 -       yes\n"), std::string::npos) << result.out;
}

/// Effects of a set that make no sense, and the message.
struct WrongEffect {
  const char *name, *effect, *message;
};

void PrintTo(const WrongEffect& wrong, std::ostream* out) { *out << wrong.name; }

class EveryWrongEffect : public IdentifyCompare, public testing::WithParamInterface<WrongEffect> {};

TEST_P(EveryWrongEffect, EndsTheRunWithFileAndReason) {
  WriteSet("plain.toml", "plain", 3.41, 2.21, 0.018);
  WriteSet("wrong.toml", "wrong", 3.41, 2.21, 0.018, 9.82, fmt::format("effects = [ {{ {} }} ]\n", GetParam().effect));
  const ProgramResult result = Run({"compare", "plain.toml", "wrong.toml"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, fmt::format("wrong.toml: [lateral] effects: {}\n", GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Sets, EveryWrongEffect,
    testing::Values(
        WrongEffect{"unknown_effect", "id = \"viscous_dampng\", c = 0.012",
                    "expected an effect of the catalogue (see identify effects), found \"viscous_dampng\""},
        WrongEffect{"unknown_parameter", "id = \"viscous_damping\", d = 0.012",
                    "viscous_damping: expected parameters among c, found \"d\""},
        WrongEffect{"missing_parameter", "id = \"viscous_damping\"",
                    "viscous_damping: expected a value of c [s/m], found none"},
        WrongEffect{"beyond_its_bounds", "id = \"viscous_damping\", c = -0.1",
                    "viscous_damping: expected c from 0 to 0.3 s/m, found -0.1"},
        WrongEffect{"of_a_record", "id = \"sensor_drift\", rate = 1e-5",
                    "sensor_drift: expected parameters among none, found rate, which belongs to a record and not to a "
                    "link"}),
    [](const auto& wrong) { return std::string(wrong.param.name); });

TEST_F(IdentifyCompare, FiveSlidersAreListedOnly) {
  Write("five.toml",
        "name = \"five\"\nsource = \"\"\nload_N = 3714.0\n[lateral]\nk = 4.0\nsliders = [ {k=1.0, T0=0.01}, "
        "{k=1.0, T0=0.01}, {k=1.0, T0=0.01}, {k=1.0, T0=0.01}, {k=1.0, T0=0.01} ]\n");
  const ProgramResult result = Run({"compare", "five.toml", Shipped("set1.toml")});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err.substr(0, result.err.find('\n') + 1),
            "five.toml: expected at most 4 sliders, found 5: the lateral parameters are listed only\n");
  EXPECT_NE(result.out.find("\n  k5 "), std::string::npos) << result.out;
}

TEST_F(IdentifyCompare, SetWithoutTheDirectionIsNamed) {
  Write("longitudinal.txt", PlainDecay{}.Text("# direction: longitudinal\n# mass_kg: 378.2\n"));
  WriteSet("lateral_only.toml", "lateral only", 3.41, 2.21, 0.018);
  const ProgramResult result =
      Run({"compare", "lateral_only.toml", Shipped("set1.toml"), "--records", "longitudinal.txt"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(
      result.err,
      "lateral_only.toml: expected a table [longitudinal], found none: not simulated in longitudinal direction\n");
}

// No slider, and a slider without friction: the same free oscillation, which loses nothing.
TEST_F(IdentifyCompare, SetsWithoutFriction) {
  Write("lateral.txt", PlainDecay{}.Text());
  Write("none.toml", "name = \"none\"\nsource = \"\"\nload_N = 3714.0\n[lateral]\nk = 5.62\nsliders = []\n");
  WriteSet("slippery.toml", "slippery", 5.62, 1.0, 0.0);
  const ProgramResult result =
      Run({"compare", "none.toml", "slippery.toml", "--records", "lateral.txt", "--json", "-"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const Json lateral = Json::parse(result.out)["directions"][0];
  const Json& results = lateral["records"][0]["results"];
  EXPECT_EQ(results[0]["rms_mm"], results[1]["rms_mm"]);
  EXPECT_NEAR(lateral["backbone"][6]["frequency_hz"][1], std::sqrt(9.82 * 5.62) / (2 * std::numbers::pi), 1e-9);
}

TEST_F(IdentifyCompare, BadRecordsAreNamedAndLeftOut) {
  Write("lateral.txt", PlainDecay{}.Text());
  WriteTruthAndWrong({});
  CopyBadRecord("no_free_decay.txt");
  CopyBadRecord("empty.txt");
  const std::vector<std::string> words = {"compare",   "truth.toml",        "wrong.toml",
                                          "--records", "no_free_decay.txt", "empty.txt"};
  const std::string messages =
      "empty.txt: expected lines of time [s] and displacement [mm], found an empty file\n"
      "no_free_decay.txt: expected a free decay, found the same amplitude of 18.00 mm from the first extremum to the "
      "last; "
      "record the motion after letting go\n";
  const ProgramResult alone = Run(words);
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_EQ(alone.out, "");
  EXPECT_EQ(alone.err, messages + "identify: none of the 2 records can be used\n");

  std::vector<std::string> beside = words;
  beside.insert(beside.end(), {"lateral.txt", "--json", "out.json"});
  const ProgramResult result = Run(beside);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, messages);
  const Json json = ReadJson("out.json");
  EXPECT_EQ(json["unread"][0]["file"], "empty.txt");
  EXPECT_EQ(json["directions"][0]["records"][0]["used"], true);
  EXPECT_EQ(json["directions"][0]["records"][1]["file"], "no_free_decay.txt");
  EXPECT_EQ(json["directions"][0]["records"][1]["used"], false);
}

TEST_F(IdentifyCompare, UnreadableSetEndsTheRun) {
  const ProgramResult result = Run({"compare", "nowhere.toml", Shipped("set1.toml")});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "nowhere.toml: expected a readable file, found nothing of that name\n");
}

// What `identify` writes can be compared, and is the best description of the records that it came from.
TEST_F(IdentifyCompare, IdentifiedSetBeatsTheThesis) {
  std::vector<std::string> records = CopyMeasurements("lateral", 2);
  Run({records[0], records[1], "--starts", "0", "--quiet"});
  const ProgramResult result = Run({"compare", Shipped("set1.toml"), Shipped("set2.toml"), "out/parameters.toml",
                                    "--records", records[0], records[1], "--json", "-"});
  EXPECT_EQ(Json::parse(result.out)["directions"][0]["best"], "identified");
}

}  // namespace
}  // namespace uiclink
