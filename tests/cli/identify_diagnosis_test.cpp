// The diagnosis as a user gets it: what is named, what is written, what is said.

#include <map>
#include <set>
#include <sstream>

#include "data/parameter_set_file.h"
#include "model/extended_solver.h"
#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// A run on the shipped lateral records, made once for all tests here.
class IdentifyDiagnosis : public IdentifyProgram {
 protected:
  static constexpr int kRecords = 4;

  /// Everything that one run on some lateral records left behind.
  struct Done {
    ProgramResult result;
    Json json;
    std::string set, plain_set, residuals;
  };

  const Done& Lateral() const {
    static const Done done = [this] {
      const TemporaryFolder folder;
      std::vector<std::string> words = {"--starts", "0", "--no-report"};
      for (int i = 1; i <= kRecords; ++i) {
        words.push_back(fmt::format("lateral_{:02}.txt", i));
        std::filesystem::copy_file(std::filesystem::path(UICLINK_SOURCE_DIR) / "measurements" / words.back(),
                                   folder.path() / words.back());
      }
      Done d;
      d.result = RunIn({.folder = folder.path()}, words);
      const std::filesystem::path out = folder.path() / "out";
      d.json = Json::parse(ReadAll(out / "result.json"));
      d.set = ReadAll(out / "parameters.toml"), d.plain_set = ReadAll(out / "parameters_plain.toml");
      d.residuals = ReadAll(out / "residuals.csv");
      return d;
    }();
    return done;
  }
  std::string Shipped(const std::string& set) const { return UICLINK_SOURCE_DIR "/data/parameter_sets/" + set; }
};

// ---------------------------------------------------------------- what is named

TEST_F(IdentifyDiagnosis, NamesWhatTheRigPutIntoTheLateralRecords) {
  EXPECT_EQ(Lateral().result.exit_code, 0);
  EXPECT_EQ(Lateral().result.err, "");
  const Json& diagnosis = Lateral().json["diagnosis"];
  EXPECT_EQ(diagnosis["verdict"], "explained");
  ASSERT_EQ(diagnosis["causes"].size(), 1u);
  const Json& cause = diagnosis["causes"][0];
  EXPECT_EQ(cause["effect"], "rolling_friction");
  EXPECT_TRUE(cause["rivals"].empty());
  EXPECT_LT(diagnosis["rms_over_noise"], 1.05);  // the noise level itself is known to some 2 % per record
  EXPECT_GT(Lateral().json["fit"]["rms_over_noise"], 10);
  EXPECT_GT(cause["held_out_gain"], 0.9);
  // The rig's setting, within four standard deviations.
  const Json& T_r = cause["parameters"]["T_r"];
  EXPECT_NEAR(T_r["value"], 3e-4, 4 * T_r["std"].get<double>());
  EXPECT_EQ(T_r["unit"], "-");
}

TEST_F(IdentifyDiagnosis, TheCauseRepairsTheReadOutsThatItShould) {
  const Json& diagnosis = Lateral().json["diagnosis"];
  const Json& cause = diagnosis["causes"][0];
  EXPECT_GE(cause["repairable"], 2);
  EXPECT_EQ(cause["repaired"].size(), cause["repairable"]);
  std::map<std::string, Json> symptoms;
  for (const Json& symptom : diagnosis["symptoms"]) symptoms[symptom["symptom"]] = symptom;
  for (const std::string id : cause["repaired"]) {
    ASSERT_TRUE(symptoms.contains(id)) << id;
    EXPECT_EQ(symptoms[id]["significant"], true) << id;
    const Json& left = symptoms[id]["z_extended"];
    if (left.is_null()) continue;  // gone: there is nothing left to read out
    EXPECT_LE(std::abs(left.get<double>()), 0.5 * std::abs(symptoms[id]["z"].get<double>())) << id;
  }
  EXPECT_EQ(symptoms.at("frequency_method_bias")["of_model"], false);
}

/// Words of the catalogue for read-outs that have names of their own, as identify/diagnose_symptoms.h has them.
const std::map<std::string, std::string> kFamilies = {{"even_harmonics", "second_harmonic"},
                                                      {"odd_harmonics", "third_harmonic"},
                                                      {"rolling_decay", "rolling_loss"},
                                                      {"backbone_in_time", "frequency_in_time"}};

// Otherwise a cause could never repair anything, and nobody would notice.
TEST_F(IdentifyDiagnosis, EveryReadOutThatTheCatalogueSpeaksOfExists) {
  std::vector<std::string> ids;
  for (const Json& symptom : Lateral().json["diagnosis"]["symptoms"]) ids.push_back(symptom["symptom"]);
  for (const Json& effect : Json::parse(Run({"effects", "--json", "-"}).out)["effects"])
    for (const std::string word : effect["repairs"]) {
      if (word == "residual_spectrum") continue;  // lines are there only where the residual has them
      const auto family = kFamilies.find(word);
      const std::string& begin = family == kFamilies.end() ? word : family->second;
      EXPECT_TRUE(std::any_of(ids.begin(), ids.end(), [&](const std::string& id) { return id.starts_with(begin); }))
          << effect["id"] << ": " << word;
    }
}

TEST_F(IdentifyDiagnosis, PlainDecayIsAdequateAndNothingIsNamed) {
  Write("lateral.txt", PlainDecay{}.Text());
  const ProgramResult result = Run({"lateral.txt", "--starts", "0"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const Json json = ReadJson("out/result.json");
  EXPECT_EQ(json["diagnosis"]["verdict"], "adequate");
  EXPECT_TRUE(json["diagnosis"]["causes"].empty());
  EXPECT_FALSE(json["diagnosis"].contains("missing_force"));
  EXPECT_FALSE(Exists("out/parameters_plain.toml"));
  EXPECT_TRUE(ReadParameterSet(Folder() / "out/parameters.toml").lateral->effects.empty());
  EXPECT_NE(result.out.find("\n  Verdict: adequate."), std::string::npos) << result.out;
}

TEST_F(IdentifyDiagnosis, OneRecordAloneIsEnough) {
  Run(With(CopyMeasurements("lateral", 1), {"--starts", "0"}));
  const Json diagnosis = ReadJson("out/result.json")["diagnosis"];
  ASSERT_EQ(diagnosis["causes"].size(), 1u) << diagnosis["verdict"];
  EXPECT_EQ(diagnosis["causes"][0]["effect"], "rolling_friction");
  EXPECT_EQ(diagnosis["causes"][0]["held_out_by"], "time");
}

// ---------------------------------------------------------------- JSON

void ExpectNumbers(const Json& json, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_TRUE(json.contains(key) && json[key].is_number()) << key << " in " << json;
}

TEST_F(IdentifyDiagnosis, JsonHasTheKeysOfItsSchema) {
  const Json& diagnosis = Lateral().json["diagnosis"];
  EXPECT_GE(diagnosis["symptoms"].size(), 15u);
  for (const Json& symptom : diagnosis["symptoms"]) {
    ExpectNumbers(symptom, {"measured", "modelled", "z"});
    for (const char* key : {"symptom", "sentence", "unit"}) EXPECT_TRUE(symptom[key].is_string()) << symptom;
    EXPECT_TRUE(symptom["of_model"].is_boolean());
    EXPECT_TRUE(symptom["z_extended"].is_number() || symptom["z_extended"].is_null());
  }
  for (const Json& cause : diagnosis["causes"]) {
    EXPECT_TRUE(cause["effect"].is_string());
    ExpectNumbers(cause, {"p_value", "delta_bic", "rms_before_mm", "rms_after_mm", "held_out_gain"});
    EXPECT_TRUE(cause["rivals"].is_array());
    for (const Json& parameter : cause["parameters"]) ExpectNumbers(parameter, {"value", "std", "low", "high"});
  }
  ExpectNumbers(diagnosis["parameter_shift"], {"k", "k1", "T01"});
  ExpectNumbers(diagnosis["parameter_shift_in_std"], {"k", "k1", "T01"});
  ExpectNumbers(diagnosis, {"rms_over_noise", "wall_s", "evaluations"});
  const Json& extended = Lateral().json["extended_fit"];
  ExpectNumbers(extended, {"rms_mm", "rms_over_noise"});
  for (const char* name : {"k", "k1", "T01", "rolling_friction.T_r"})
    ExpectNumbers(extended["parameters"][name], {"value", "std", "low", "high"});
  ASSERT_EQ(diagnosis["unseen"].size(), 1u);
  EXPECT_EQ(diagnosis["unseen"][0]["effect"], "asymmetric_friction");
}

TEST_F(IdentifyDiagnosis, ParameterShiftIsPlainLessExtended) {
  const Json& json = Lateral().json;
  for (const char* name : {"k", "k1", "T01"}) {
    const double plain = json["fit"]["parameters"][name]["value"];
    const double extended = json["extended_fit"]["parameters"][name]["value"];
    const double std = json["fit"]["parameters"][name]["std"];
    // Numbers of the JSON have all their digits.
    EXPECT_NEAR(json["diagnosis"]["parameter_shift"][name], plain - extended, 1e-12) << name;
    EXPECT_NEAR(json["diagnosis"]["parameter_shift_in_std"][name], (plain - extended) / std, 1e-9) << name;
  }
}

TEST_F(IdentifyDiagnosis, GainByAmplitudeAddsUpToTheRms) {
  const Json& json = Lateral().json;
  const Json& ranges = json["diagnosis"]["gain_by_amplitude"];
  ASSERT_EQ(ranges.size(), 3u);
  double before = 0, after = 0, samples = 0, last = 1e3;
  for (const Json& range : ranges) {
    const double n = range["samples"], rms_before = range["rms_before_mm"], rms_after = range["rms_after_mm"];
    samples += n, before += n * rms_before * rms_before, after += n * rms_after * rms_after;
    EXPECT_LT(rms_after, 0.1 * rms_before) << range;
    EXPECT_NEAR(range["high_mm"], last == 1e3 ? range["high_mm"].get<double>() : last, 1e-9) << "ranges join";
    last = range["low_mm"];
  }
  const Json& cause = json["diagnosis"]["causes"][0];  // the only one: before it is the plain model
  EXPECT_NEAR(std::sqrt(before / samples) / cause["rms_before_mm"].get<double>(), 1, 1e-9);
  EXPECT_NEAR(std::sqrt(after / samples) / json["extended_fit"]["rms_mm"].get<double>(), 1, 1e-9);
}

TEST_F(IdentifyDiagnosis, WithoutDiagnosisThereIsNone) {
  const ProgramResult result = Run(With(CopyMeasurements("lateral", 2), {"--starts", "0", "--no-diagnosis"}));
  EXPECT_EQ(result.exit_code, 0);
  const Json json = ReadJson("out/result.json");
  for (const char* key : {"diagnosis", "extended_fit"}) EXPECT_FALSE(json.contains(key)) << key;
  EXPECT_FALSE(Exists("out/parameters_plain.toml"));
  EXPECT_TRUE(Read("out/residuals.csv").starts_with("file,time_s,measured_mm,modelled_mm,residual_mm\n"));
  EXPECT_EQ(result.out.find("Verdict"), std::string::npos);
}

TEST_F(IdentifyDiagnosis, BothDirectionsHaveTheirOwn) {
  const std::vector<std::string> lateral = CopyMeasurements("lateral", 1), along = CopyMeasurements("longitudinal", 1);
  const ProgramResult result = Run({along[0], lateral[0], "--sliders", "1", "--starts", "0", "--json", "-"});
  const Json json = Json::parse(result.out);
  bool trustworthy = true;
  for (const Json& direction : json["directions"]) {
    const std::string verdict = direction["diagnosis"]["verdict"];
    EXPECT_TRUE((std::set<std::string>{"adequate", "explained", "partly_explained", "unexplained"}.contains(verdict)));
    EXPECT_TRUE(direction.contains("extended_fit"));
    const bool open = verdict == "partly_explained" || verdict == "unexplained";
    EXPECT_EQ(direction["diagnosis"].contains("missing_force"), open) << verdict;
    trustworthy &= !open;
  }
  // One slider cannot be what four made: whatever the verdict, code and message agree with it.
  EXPECT_EQ(result.exit_code, trustworthy ? 0 : 1);
  EXPECT_EQ(result.err.find("are not to be trusted as they stand\n") != std::string::npos, !trustworthy) << result.err;
}

/// A local force that pushes outwards about 9 mm on both sides: a worn profile has such a place, the catalogue has not.
template <typename T>
T LocalForce(const LawParameters<T>& p, const Motion<T>& motion) {
  const T distance = (abs(motion.y) - 0.009) / 0.001;
  return (motion.y > 0 ? p[0] : -p[0]) * exp(-distance * distance);
}

/// A free decay with that force, of `size` loads.
std::string DecayWithLocalForce(double size) {
  const PlainDecay plain;
  Oscillator<double> link;
  link.k = plain.k;
  link.Add({.k = plain.k1, .T0 = plain.T0});
  ExtendedOscillator<double> extended = Extend(link);
  extended.forces.Add({.p = {size}, .force = &LocalForce<double>});
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(extended, 0.025, 0.0, plain.duration_s, &run), SolveStatus::kOk);
  std::mt19937_64 random(plain.seed);
  std::normal_distribution<double> noise(0, plain.noise_mm);
  std::string text = "# direction: lateral\n# mass_kg: 378.2\n";
  for (double t = 0; t < plain.duration_s; t += 1 / plain.rate_hz)
    text += fmt::format("{:.6f}\t{:.4f}\n", t, 1e3 * run.y(t) + noise(random));
  return text;
}

TEST_F(IdentifyDiagnosis, WhatTheCatalogueDoesNotHaveShowsAsAForce) {
  Write("lateral.txt", DecayWithLocalForce(0.002));
  const ProgramResult result = Run({"lateral.txt", "--starts", "0"});
  const Json diagnosis = ReadJson("out/result.json")["diagnosis"];
  const std::string verdict = diagnosis["verdict"];
  ASSERT_TRUE(verdict == "unexplained" || verdict == "partly_explained") << verdict;
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(result.err.starts_with("lateral: warning: the model leaves structure in the residuals, and "))
      << result.err;
  EXPECT_EQ(ReadJson("out/result.json")["wagon"]["trustworthy"], false);
  EXPECT_NE(result.out.find("\n  * identified: not to be trusted as it stands. lateral: "), std::string::npos);
  const Json& force = diagnosis["missing_force"];
  EXPECT_TRUE(force["words"].is_string());
  for (const char* part : {"map", "over_y", "over_v", "over_t"}) EXPECT_FALSE(force[part].empty()) << part;
  ExpectNumbers(force["shares"], {"displacement", "velocity", "time"});
  ExpectNumbers(force["map"][0], {"displacement_mm", "velocity_mm_s", "force", "error", "count"});
  const std::string words = force["words"];
  // Line breaks aside, the report says what the JSON says.
  std::string flat = result.out;
  for (std::size_t at = flat.find("\n  "); at != std::string::npos; at = flat.find("\n  ", at))
    flat.replace(at, 3, " ");
  EXPECT_NE(flat.find(words), std::string::npos) << words << "\n" << result.out;
}

// ---------------------------------------------------------------- what is written

TEST_F(IdentifyDiagnosis, ExtendedSetHoldsTheEffectWithItsCovariance) {
  Write("extended.toml", Lateral().set), Write("plain.toml", Lateral().plain_set);
  const ParameterSet set = ReadParameterSet(Folder() / "extended.toml");
  const ParameterSet plain = ReadParameterSet(Folder() / "plain.toml");
  EXPECT_TRUE(set.source.ends_with(", with rolling_friction")) << set.source;
  EXPECT_EQ(plain.name, "identified, plain model");
  EXPECT_TRUE(plain.lateral->effects.empty());
  const Json& parameters = Lateral().json["extended_fit"]["parameters"];
  ASSERT_EQ(set.lateral->effects.size(), 1u);
  EXPECT_EQ(set.lateral->effects[0].id, "rolling_friction");
  ASSERT_EQ(set.lateral->effects[0].parameters.size(), 1u);
  EXPECT_EQ(set.lateral->effects[0].parameters[0].first, "T_r");
  EXPECT_EQ(set.lateral->effects[0].parameters[0].second, parameters["rolling_friction.T_r"]["value"]);
  ASSERT_TRUE(set.lateral->covariance);
  const Covariance& covariance = *set.lateral->covariance;
  EXPECT_EQ(covariance.order, (std::vector<std::string>{"k", "k1", "T01", "rolling_friction.T_r"}));
  for (std::size_t i = 0; i < covariance.order.size(); ++i) {
    const double std = parameters[covariance.order[i]]["std"];
    EXPECT_NEAR(std::sqrt(covariance.matrix[i][i]) / std, 1, 1e-12) << covariance.order[i];  // rounding of the square
    EXPECT_NEAR(set.lateral->std.at(covariance.order[i]) / std, 1, 1e-12);
  }
}

TEST_F(IdentifyDiagnosis, ExtendedSetBeatsTheOthersOnRecordsThatItHasNotSeen) {
  Write("extended.toml", Lateral().set), Write("plain.toml", Lateral().plain_set);
  std::vector<std::string> words = {"compare", Shipped("set1.toml"), "plain.toml", "extended.toml", "--records"};
  std::vector<std::string> records = CopyMeasurements("lateral", 8);
  records.erase(records.begin(), records.begin() + kRecords);
  const ProgramResult result = Run(With(With(words, records), {"--json", "-"}));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const Json lateral = Json::parse(result.out)["directions"][0];
  EXPECT_EQ(lateral["best"], "identified");
  const Json& overall = lateral["overall"];
  EXPECT_LT(overall[2]["rms_mm"], overall[1]["rms_mm"]);
  EXPECT_LT(overall[1]["rms_mm"], overall[0]["rms_mm"]);
  // The tail, which rolling friction shortens: the records lose what the extended set loses and the plain one does not.
  const Json& tail = lateral["points"].back()["loss_per_half_cycle_mm"];
  EXPECT_NEAR(tail["sets"][2].get<double>() / tail["measured"].get<double>(), 1, 0.05);  // links seat anew, k by 2 %
  EXPECT_LT(tail["sets"][1].get<double>(), 0.2 * tail["measured"].get<double>());
}

TEST_F(IdentifyDiagnosis, ResidualsOfTheExtendedModelAreNoise) {
  std::istringstream csv(Lateral().residuals);
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  EXPECT_EQ(line, "file,time_s,measured_mm,modelled_mm,residual_mm,extended_mm,extended_residual_mm");
  double squares = 0, n = 0;
  while (std::getline(csv, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::string file;
    double t = 0, measured = 0, modelled = 0, residual = 0, extended = 0, left = 0;
    ASSERT_TRUE(fields >> file >> t >> measured >> modelled >> residual >> extended >> left) << line;
    ASSERT_NEAR(measured - extended, left, 1.51e-5) << line;  // three numbers rounded at 0.5e-5
    squares += left * left, ++n;
  }
  EXPECT_NEAR(std::sqrt(squares / n), Lateral().json["extended_fit"]["rms_mm"], 1e-5);  // rounding of the residuals
}

// The plain set of a run before would be taken for this run's.
TEST_F(IdentifyDiagnosis, PlainSetOfAnEarlierRunIsRemoved) {
  Write("lateral.txt", PlainDecay{}.Text());
  Write("out/parameters_plain.toml", "old");
  Run({"lateral.txt", "--starts", "0", "--quiet"});
  EXPECT_FALSE(Exists("out/parameters_plain.toml"));
}

// ---------------------------------------------------------------- what is said

TEST_F(IdentifyDiagnosis, TheAnswerComesFirstAndLinesAreNoWiderThanATerminal) {
  const std::string& out = Lateral().result.out;
  const std::size_t verdict = out.find("\n  Verdict: explained. The plain model lacks friction of the rolling joints");
  ASSERT_NE(verdict, std::string::npos) << out;
  std::istringstream lines(out.substr(verdict + 1));
  std::string line;
  while (std::getline(lines, line)) {
    const auto width = std::count_if(line.begin(), line.end(), [](unsigned char c) { return (c & 0xC0) != 0x80; });
    if (line.starts_with("Written: ")) continue;
    EXPECT_LE(width, 110) << line;
  }
  for (const char* part : {"How far the plain model's values were off",
                           "What the extended model gains while the motion has some amplitude",
                           "What the plain model gets wrong", "a bias of the method, which no model repairs",
                           "Every effect of the catalogue", "Not to be seen in such records"})
    EXPECT_NE(out.find(part, verdict), std::string::npos) << part;
}

}  // namespace
}  // namespace uiclink
