// What the program `identify` prints and writes, and how it is told what to do.

#include <bit>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>

#include "data/parameter_set_file.h"
#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

using testing::Test;

std::vector<std::string> With(std::vector<std::string> words, const std::vector<std::string>& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

/// The result without what depends on the machine.
Json WithoutTimes(Json json) {
  for (const char* part : {"fit", "diagnosis"}) {
    json[part].erase("wall_s");
    for (Json& direction : json["directions"]) direction[part].erase("wall_s");
  }
  return json;
}

void ExpectKeys(const Json& json, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_TRUE(json.contains(key)) << key;
}

// ---------------------------------------------------------------- options that end at once

TEST_F(IdentifyProgram, Version) {
  const ProgramResult result = Run({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, "identify " UICLINK_VERSION " (uiclink)\n");
  EXPECT_EQ(result.err, "");
}

TEST_F(IdentifyProgram, HelpHasExamplesAndExitCodes) {
  const ProgramResult result = Run({"--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
  for (const char* part :
       {"Examples:\n", "  identify measurements/lateral_*.txt\n", "identify compare data/parameter_sets/set1.toml",
        "Exit codes: 0 all done; 1 done, but something was left out or is not trustworthy; 2 nothing could be done."})
    EXPECT_NE(result.out.find(part), std::string::npos) << part;
  for (const char* option :
       {"--out",          "--json",     "--quiet",   "--direction", "--mass",        "--g ",     "--rate",
        "--column",       "--unit",     "--sliders", "--cutoff",    "--starts",      "--seed",   "--threads",
        "--no-diagnosis", "--no-wagon", "--cargo",   "--geometry",  "--wagon-speed", "--version"})
    EXPECT_NE(result.out.find(option), std::string::npos) << option;
}

TEST_F(IdentifyProgram, HelpOfCompare) {
  const ProgramResult result = Run({"compare", "--help"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.out.find("--records"), std::string::npos) << result.out;
}

/// Command lines that make no sense, and a part of the message.
struct Misuse {
  const char* name;
  std::vector<std::string> words;
  const char* message;
};

void PrintTo(const Misuse& misuse, std::ostream* out) { *out << misuse.name; }

class EveryMisuse : public IdentifyProgram, public testing::WithParamInterface<Misuse> {};

TEST_P(EveryMisuse, EndsWithCode2AndAMessage) {
  const ProgramResult result = Run(GetParam().words);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_NE(result.err.find(GetParam().message), std::string::npos) << result.err;
  EXPECT_TRUE(List().empty());
}

INSTANTIATE_TEST_SUITE_P(CommandLines, EveryMisuse,
                         testing::Values(Misuse{"nothing", {}, "records is required"},
                                         Misuse{"unknown_option", {"a.txt", "--frobnicate"}, "--frobnicate"},
                                         Misuse{"negative_mass", {"a.txt", "--mass", "-3"}, "--mass"},
                                         Misuse{"rate_of_words", {"a.txt", "--rate", "fast"}, "--rate"},
                                         Misuse{"column_zero", {"a.txt", "--column", "0"}, "--column"},
                                         Misuse{
                                             "no_such_direction", {"a.txt", "--direction", "vertical"}, "--direction"},
                                         Misuse{"no_such_unit", {"a.txt", "--unit", "furlong"}, "furlong"},
                                         Misuse{"too_many_sliders", {"a.txt", "--sliders", "5"}, "--sliders"},
                                         Misuse{"json_without_file", {"a.txt", "--json"}, "--json"},
                                         Misuse{"compare_nothing", {"compare"}, "sets is required"}),
                         [](const auto& misuse) { return std::string(misuse.param.name); });

// ---------------------------------------------------------------- results

TEST_F(IdentifyProgram, JsonHasTheKeysOfItsSchemaAndNoneThatAreNotComputed) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 3);
  const ProgramResult result = Run(With(records, {"--no-wagon", "--json", "-"}));
  EXPECT_EQ(result.err, "");
  const Json json = Json::parse(result.out);  // throws unless JSON is all there is
  EXPECT_EQ(json["schema"], "identify/1");
  EXPECT_EQ(json["direction"], "lateral");
  EXPECT_FALSE(json.contains("wagon"));

  ASSERT_EQ(json["records"].size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const Json& record = json["records"][i];
    EXPECT_EQ(record["file"], records[i]);
    EXPECT_EQ(record["used"], true);
    EXPECT_TRUE(record["reason"].is_null());
    EXPECT_EQ(record["samples"], 3001);
    EXPECT_EQ(record["sampling_hz"], 200.0);
    ExpectKeys(record, {"release_s", "fit_start_s", "noise_mm", "offset_mm", "rms_mm"});
    ExpectKeys(record["sine_fit"], {"omega_sliding", "omega_rolling", "k", "sum_ki"});
    ExpectKeys(record["fit"], {"k", "k1", "T01"});
  }
  for (const char* name : {"k", "sum_ki", "T0"}) ExpectKeys(json["sine_fit"][name], {"value", "spread"});
  ExpectKeys(json["fit"], {"shared", "parameters", "rms_mm", "noise_mm", "rms_over_noise", "unidentifiable",
                           "evaluations", "wall_s"});
  for (const char* name : {"k", "k1", "T01"}) {
    const Json& parameter = json["fit"]["parameters"][name];
    ExpectKeys(parameter, {"value", "std", "low", "high"});
    EXPECT_LT(parameter["low"], parameter["value"]) << name;
    EXPECT_GT(parameter["high"], parameter["value"]) << name;
    // The shipped links were re-seated between records: they do not share their values.
    EXPECT_EQ(parameter.contains("spread"), json["fit"]["shared"] == false) << name;
  }
}

TEST_F(IdentifyProgram, JsonToAFileIsTheSameAsResultJson) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 1);
  const ProgramResult result = Run(With(records, {"--json", "sub/answer.json", "--quiet"}));
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(Read("sub/answer.json"), Read("out/result.json"));
}

TEST_F(IdentifyProgram, QuietPrintsNothingAndWritesEverything) {
  const ProgramResult result = Run(With(CopyMeasurements("lateral", 1), {"--quiet"}));
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
  for (const char* file :
       {"out/parameters.toml", "out/parameters_plain.toml", "out/result.json", "out/residuals.csv", "out/report.html",
        "out/figures/lateral_models.svg", "out/figures/lateral_models.png", "out/figures/lateral_models.csv"})
    EXPECT_TRUE(Exists(file));
}

TEST_F(IdentifyProgram, OutNamesTheFolderOfTheResults) {
  const ProgramResult result = Run(With(CopyMeasurements("lateral", 1), {"--out", "a/b"}));
  EXPECT_TRUE(
      result.out.ends_with("Written: a/b/parameters.toml a/b/parameters_plain.toml a/b/result.json "
                           "a/b/residuals.csv\nReport: a/b/report.html\n"))
      << result.out;
  EXPECT_TRUE(Exists("a/b/parameters.toml"));
  EXPECT_FALSE(Exists("out"));
}

TEST_F(IdentifyProgram, WithoutReportThereIsNone) {
  const ProgramResult result =
      Run(With(CopyMeasurements("lateral", 1), {"--no-report", "--no-diagnosis", "--no-wagon"}));
  EXPECT_TRUE(result.out.ends_with("out/residuals.csv\n")) << result.out;
  EXPECT_FALSE(Exists("out/report.html"));
  EXPECT_FALSE(Exists("out/figures"));
}

TEST_F(IdentifyProgram, ReportSaysHowToRepeatTheRun) {
  Write("lateral; worn 'a'.txt", PlainDecay{}.Text());
  Run({"lateral; worn 'a'.txt", "--starts", "3", "--no-diagnosis", "--no-wagon"});
  const std::string html = Read("out/report.html");
  // Quoted for a shell, then for HTML.
  EXPECT_NE(html.find("&#39;lateral; worn &#39;\\&#39;&#39;a&#39;\\&#39;&#39;.txt&#39; --starts 3"), std::string::npos);
  EXPECT_NE(html.find("--starts</th><td>3</td>"), std::string::npos);
  EXPECT_NE(html.find("--seed</th><td>1</td>"), std::string::npos) << "defaults are there, too";
}

TEST_F(IdentifyProgram, WithoutGnuplotThePageIsThereAndSaysSo) {
  CopyMeasurements("lateral", 1);
  std::filesystem::create_directory(Folder() / "empty");
  const ProgramResult result = RunProgram({"/usr/bin/env", "PATH=" + (Folder() / "empty").string(), UICLINK_IDENTIFY,
                                           "lateral_01.txt", "--no-diagnosis", "--no-wagon", "-q"},
                                          {.folder = Folder()});
  EXPECT_EQ(result.exit_code, 0) << "the results are all there";
  EXPECT_NE(result.err.find("no pictures beside it: the figure cannot be drawn: gnuplot is not installed"),
            std::string::npos)
      << result.err;
  EXPECT_NE(Read("out/report.html").find("No SVG and PNG files beside this page"), std::string::npos);
  EXPECT_TRUE(Exists("out/figures/lateral_models.csv"));
  EXPECT_FALSE(Exists("out/figures/lateral_models.svg"));
}

// Standard error is no terminal here: no progress and no escape sequences, neither there nor in the tables.
TEST_F(IdentifyProgram, NoTerminalNoEscapeSequences) {
  const ProgramResult result = Run(CopyMeasurements("lateral", 2));
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out.find('\033'), std::string::npos);
  EXPECT_EQ(result.out.find('\r'), std::string::npos);
}

TEST_F(IdentifyProgram, BothDirectionsInOneCall) {
  const std::vector<std::string> lateral = CopyMeasurements("lateral", 1), along = CopyMeasurements("longitudinal", 1);
  const ProgramResult result = Run({along[0], lateral[0], "--sliders", "1", "--starts", "0", "--json", "-"});
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["schema"], "identify/1");
  EXPECT_FALSE(json.contains("direction"));
  EXPECT_FALSE(json.contains("records"));
  ASSERT_EQ(json["directions"].size(), 2u);
  EXPECT_EQ(json["directions"][0]["direction"], "lateral");
  EXPECT_EQ(json["directions"][0]["records"][0]["file"], lateral[0]);
  EXPECT_EQ(json["directions"][1]["direction"], "longitudinal");
  EXPECT_EQ(json["directions"][1]["records"][0]["file"], along[0]);
  const ParameterSet set = ReadParameterSet(Folder() / "out/parameters.toml");
  EXPECT_TRUE(set.lateral && set.longitudinal);
}

TEST_F(IdentifyProgram, ParametersReadBackAsInTheJson) {
  Run(With(CopyMeasurements("lateral", 2), {"--starts", "0", "--no-diagnosis"}));
  const ParameterSet set = ReadParameterSet(Folder() / "out/parameters.toml");
  const Json parameters = ReadJson("out/result.json")["fit"]["parameters"];
  ASSERT_TRUE(set.lateral);
  EXPECT_FALSE(set.longitudinal);
  EXPECT_DOUBLE_EQ(set.load_N, 378.2 * 9.82);
  EXPECT_EQ(set.g, 9.82);
  ASSERT_EQ(set.lateral->sliders.size(), 1u);
  const std::map<std::string, double> values = {
      {"k", set.lateral->k}, {"k1", set.lateral->sliders[0].k}, {"T01", set.lateral->sliders[0].T0}};
  ASSERT_TRUE(set.lateral->covariance);
  const Covariance& covariance = *set.lateral->covariance;
  EXPECT_EQ(covariance.order, (std::vector<std::string>{"k", "k1", "T01"}));
  for (std::size_t i = 0; i < covariance.order.size(); ++i) {
    const std::string& name = covariance.order[i];
    const Json& parameter = parameters[name];
    EXPECT_NEAR(values.at(name) / parameter["value"].get<double>(), 1, 1e-12) << name;  // exp(log) rounds
    EXPECT_EQ(set.lateral->std.at(name), parameter["std"]) << name;
    EXPECT_GT(covariance.matrix[i][i], 0) << name;
  }
}

TEST_F(IdentifyProgram, ResidualsAreMeasuredMinusModelled) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 2);
  Run(With(records, {"--starts", "0", "--no-diagnosis"}));
  const Json json = ReadJson("out/result.json");
  std::istringstream csv(Read("out/residuals.csv"));
  std::string line;
  ASSERT_TRUE(std::getline(csv, line));
  EXPECT_EQ(line, "file,time_s,measured_mm,modelled_mm,residual_mm");
  std::map<std::string, std::pair<double, int>> squares;
  while (std::getline(csv, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream fields(line);
    std::string file;
    double t = 0, measured = 0, modelled = 0, residual = 0;
    ASSERT_TRUE(fields >> file >> t >> measured >> modelled >> residual) << line;
    ASSERT_NEAR(measured - modelled, residual, 1.51e-5) << line;  // three numbers rounded at 0.5e-5
    squares[file].first += residual * residual;
    ++squares[file].second;
  }
  ASSERT_EQ(squares.size(), 2u);
  for (const Json& record : json["records"]) {
    const auto& [sum, samples] = squares.at(record["file"]);
    EXPECT_NEAR(std::sqrt(sum / samples), record["rms_mm"], 1e-5);  // rounding of the residuals
    EXPECT_GT(samples, 2000);
  }
}

TEST_F(IdentifyProgram, FileNamesWithCommasAreQuotedInTheResiduals) {
  Write("lateral, worn.txt", PlainDecay{}.Text());
  Run({"lateral, worn.txt", "--starts", "0"});
  const std::string csv = Read("out/residuals.csv");
  EXPECT_NE(csv.find("\n\"lateral, worn.txt\",0"), std::string::npos) << csv.substr(0, 200);
}

TEST_F(IdentifyProgram, TwoRunsGiveTheSameResult) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 3);
  Run(With(records, {"--no-wagon", "--out", "first"}));
  Run(With(records, {"--no-wagon", "--out", "second"}));
  EXPECT_EQ(WithoutTimes(ReadJson("first/result.json")), WithoutTimes(ReadJson("second/result.json")));
  EXPECT_EQ(Read("first/residuals.csv"), Read("second/residuals.csv"));
  EXPECT_EQ(Read("first/parameters.toml"), Read("second/parameters.toml"));
}

TEST_F(IdentifyProgram, TheNumberOfThreadsDoesNotChangeResults) {
  const std::vector<std::string> records = CopyMeasurements("lateral", 3);
  Run(With(records, {"--no-wagon", "--threads", "1", "--out", "one"}));
  Run(With(records, {"--no-wagon", "--threads", "3", "--out", "three"}));
  EXPECT_EQ(WithoutTimes(ReadJson("one/result.json")), WithoutTimes(ReadJson("three/result.json")));
  EXPECT_EQ(Read("one/residuals.csv"), Read("three/residuals.csv"));
}

// ---------------------------------------------------------------- what the caller knows about a record

/// A run on one file, and the fitted parameters.
class OneRecord : public IdentifyProgram {
 protected:
  Json Fit(const std::vector<std::string>& words) const {
    const ProgramResult result = Run(With(words, {"--starts", "0", "--json", "-"}));
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return Json::parse(result.out);
  }

  /// The truth is within four standard deviations: one in 16000 values is not.
  static void ExpectTruth(const Json& json, const PlainDecay& truth) {
    for (const auto& [name, value] : {std::pair{"k", truth.k}, {"k1", truth.k1}, {"T01", truth.T0}}) {
      const Json& parameter = json["fit"]["parameters"][name];
      EXPECT_NEAR(parameter["value"], value, 4 * parameter["std"].get<double>()) << name;
    }
  }
};

TEST_F(OneRecord, PlainDecayGivesItsTruth) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  const Json json = Fit({"lateral.txt"});
  ExpectTruth(json, decay);
  // 2400 samples: the rms has a relative deviation of 1.5 %, the noise level one of 2 %.
  EXPECT_NEAR(json["fit"]["rms_over_noise"], 1, 0.06);
}

TEST_F(OneRecord, OneColumnWithARate) {
  const PlainDecay decay;
  std::string text;
  for (const double y : decay.CalcReadingsMm()) text += fmt::format("{:.4f}\n", y);
  Write("decay.txt", text);
  ExpectTruth(Fit({"decay.txt", "--rate", "200", "--direction", "lateral", "--mass", "378.2"}), decay);
}

TEST_F(OneRecord, ColumnAndUnitAndDecimalCommas) {
  const PlainDecay decay;
  const std::vector<double> y = decay.CalcReadingsMm();
  std::string text = "Zeit;Kraft;Weg\r\n";
  for (std::size_t i = 0; i < y.size(); ++i) {
    std::string row = fmt::format("{:.3f};{:.1f};{:.5f}\r\n", static_cast<double>(i) / 200, 3714.0, y[i] / 10);
    std::replace(row.begin(), row.end(), '.', ',');
    text += row;
  }
  Write("quer.csv", text);
  ExpectTruth(Fit({"quer.csv", "--column", "3", "--unit", "cm", "--direction", "lateral", "--mass", "378.2"}), decay);
}

/// A MATLAB file of level 4: five 32-bit numbers, the name, the matrix column by column.
std::string MatFile(const std::string& name, const std::vector<std::vector<double>>& columns) {
  static_assert(std::endian::native == std::endian::little, "the type code 0 below says little-endian doubles");
  const std::int32_t head[] = {0, static_cast<std::int32_t>(columns[0].size()),
                               static_cast<std::int32_t>(columns.size()), 0,
                               static_cast<std::int32_t>(name.size() + 1)};
  std::string file(reinterpret_cast<const char*>(head), sizeof head);
  file.append(name.c_str(), name.size() + 1);
  for (const std::vector<double>& column : columns)
    file.append(reinterpret_cast<const char*>(column.data()), column.size() * sizeof(double));
  return file;
}

TEST_F(OneRecord, MatlabFile) {
  const PlainDecay decay;
  std::vector<std::vector<double>> columns(2);
  columns[1] = decay.CalcReadingsMm();
  for (std::size_t i = 0; i < columns[1].size(); ++i) columns[0].push_back(static_cast<double>(i) / 200);
  Write("lateral.mat", MatFile("decay", columns));
  ExpectTruth(Fit({"lateral.mat", "--mass", "378.2"}), decay);
}

TEST_F(OneRecord, MassIsTheLoadOfTheSet) {
  Write("lateral.txt", PlainDecay{}.Text());
  Fit({"lateral.txt", "--mass", "400"});
  EXPECT_DOUBLE_EQ(ReadParameterSet(Folder() / "out/parameters.toml").load_N, 400 * 9.82);
}

TEST_F(OneRecord, AssumedMassIsNoticed) {
  Write("lateral.txt", PlainDecay{}.Text("# direction: lateral\n"));
  EXPECT_EQ(Run({"lateral.txt", "--starts", "0"}).err,
            "lateral.txt: note: mass 378.2 kg assumed (as in the thesis); the file has no \"# mass_kg:\"\n");
}

// The motion determines g k: the same record with another g gives other normalised values and the same motion.
TEST_F(OneRecord, GravityScalesTheParameters) {
  Write("lateral.txt", PlainDecay{}.Text());
  const Json thesis = Fit({"lateral.txt"})["fit"], other = Fit({"lateral.txt", "--g", "9.81"})["fit"];
  EXPECT_EQ(ReadParameterSet(Folder() / "out/parameters.toml").g, 9.81);
  for (const char* name : {"k", "k1", "T01"}) {
    const double a = thesis["parameters"][name]["value"], b = other["parameters"][name]["value"];
    // Both fits stop when the sum of squares falls by less than 1e-9 of itself, far within a standard deviation.
    EXPECT_NEAR(b * 9.81, a * 9.82, 0.01 * 9.82 * thesis["parameters"][name]["std"].get<double>()) << name;
  }
}

TEST_F(OneRecord, SlidersAreChosenFromTheData) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  const Json fit = Fit({"lateral.txt", "--sliders", "auto"})["fit"];
  EXPECT_EQ(fit["sliders"], 1) << fit["slider_choice"];
  EXPECT_GE(fit["slider_choice"].size(), 2u);
}

TEST_F(OneRecord, SlidersAreAsManyAsTold) {
  const PlainDecay decay;
  Write("lateral.txt", decay.Text());
  const ProgramResult result = Run({"lateral.txt", "--sliders", "2", "--starts", "0", "--json", "-"});
  const Json fit = Json::parse(result.out)["fit"];
  EXPECT_EQ(fit["sliders"], 2);
  ExpectKeys(fit["parameters"], {"k", "k1", "k2", "T01", "T02", "sum_ki", "sum_T0i"});
  EXPECT_FALSE(fit["unidentifiable"].empty()) << "one slider made the record: the split into two is not in the data";
}

// ---------------------------------------------------------------- folders that cannot be written

TEST_F(IdentifyProgram, OutputFolderIsAFile) {
  Write("taken", "");
  const ProgramResult result = Run(With(CopyMeasurements("lateral", 1), {"--out", "taken", "--starts", "0"}));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err,
            "taken/parameters.toml: expected a file that can be written, found a file where its path has a folder\n");
}

TEST_F(IdentifyProgram, OutputFolderWithoutPermission) {
  const std::vector<std::string> words = With(CopyMeasurements("lateral", 1), {"--starts", "0"});
  const bool root = geteuid() == 0;
  std::filesystem::permissions(Folder(), static_cast<std::filesystem::perms>(0555));  // root may write all the same
  if (root && RunAsNobody({"--version"}).exit_code != 0)
    GTEST_SKIP() << "root cannot give up its rights here, or nobody cannot run the program: root writes everywhere";
  const ProgramResult result = root ? RunAsNobody(words) : Run(words);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "out/parameters.toml: expected a file that can be written, found no permission\n");
  std::filesystem::permissions(Folder(), static_cast<std::filesystem::perms>(0755));
}

}  // namespace
}  // namespace uiclink
