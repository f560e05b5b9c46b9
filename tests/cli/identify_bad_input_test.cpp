// Wrong input to `identify`: alone it ends with code 2 and a message; beside good records it is named, left out and
// counted (code 1), and the others are used as if it were not there.

#include <sys/stat.h>

#include "tests/cli/identify_fixture.h"

namespace uiclink {
namespace {

/// A file of tests/cli/bad_records and the whole message about it, its name left off.
struct BadRecord {
  const char* name;
  const char* message;
};

const BadRecord kBadRecords[] = {
    {"empty.txt", ": expected lines of time [s] and displacement [mm], found an empty file"},
    {"comments_only.txt", ":5: expected lines of time [s] and displacement [mm], found only comments"},
    {"text.txt", ":1: expected lines of time [s] and displacement [mm], found text: \"Dear colleague,\""},
    {"binary.txt", ":1: expected text, found binary data (a NUL byte); export the record as text, or as .mat"},
    {"spreadsheet.xlsx.txt", ": expected text, found a spreadsheet or zip archive; export the sheet as CSV"},
    {"damaged.mat", ": expected a MATLAB file with a record, found no variable that can be read (damaged?)"},
    {"one_column.txt",
     ":1: expected time and displacement, found one column; give the sampling rate with --rate HZ, or in the file: "
     "\"# sampling_hz: HZ\""},
    {"nan.txt",
     ":405: expected a displacement, found \"nan\"; cut or interpolate such lines, or mark them as comments with #; "
     "and "
     "2 more lines like it"},
    {"gap.txt",
     ":605: expected a sample about 5 ms after 2.995 s, found the next one after 305 ms (about 60 missing); use the "
     "part "
     "before or after the gap, or give --rate HZ if only the time stamps are wrong"},
    {"backwards_time.txt",
     ":306: expected a time after 1.505 s, found 1.5 s: time runs backwards; keep one run per file, in the order of "
     "time"},
    {"repeated_time.txt",
     ":306: expected a time after 1.5 s, found 1.5 s: time repeats; write time with more decimals, or give --rate HZ "
     "to "
     "ignore the time column"},
    {"five_samples.txt", ":9: expected at least 16 samples, found 5; is this the whole record?"},
    {"all_zeros.txt",
     ":5: expected a displacement that moves, found 0 mm in all 1000 samples; is column 2 the displacement (--column "
     "N), "
     "was the sensor connected?"},
    {"clipped.txt",
     ": expected a free decay within the sensor's range, found 23 extrema cut flat at -7.00 mm, the last at 9.88 s; "
     "push less, or keep only what comes later"},
    {"no_free_decay.txt",
     ": expected a free decay, found the same amplitude of 18.00 mm from the first extremum to the last; record the "
     "motion after letting go"},
    {"never_slides.txt",
     ": expected a free decay, found the same amplitude of 4.00 mm from the first extremum to the last; record the "
     "motion after letting go"},
    {"two_per_period.txt",
     ": expected a ring-down with at least 12 samples in a period, found readings that jump like noise within 43.1 mm, "
     "5.8 samples from peak to peak; sample faster, or check sensor and column"},
    {"unknown_direction.txt", ":1: expected direction lateral or longitudinal, found \"vertical\""},
    {"wrong_unit.txt", ":4: expected a displacement unit (mm, cm, m, um, in, mrad, rad, deg), found \"furlong\""},
    {"bad_mass.txt", ":2: expected a mass in kg above 0, found \"heavy\""},
};

void PrintTo(const BadRecord& record, std::ostream* out) { *out << record.name; }

/// Without wagon and report, which have tests of their own and would take most of the time.
class BadInput : public IdentifyProgram {
 protected:
  ProgramResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--no-wagon", "--no-report"});
    return IdentifyProgram::Run(arguments);
  }
};

class EveryBadRecord : public BadInput, public testing::WithParamInterface<BadRecord> {};

TEST_P(EveryBadRecord, AloneEndsTheRunWithItsMessage) {
  const BadRecord& bad = GetParam();
  CopyBadRecord(bad.name);
  const ProgramResult result = Run({bad.name});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, std::string(bad.name) + bad.message + "\nidentify: the record cannot be used\n");
  EXPECT_EQ(List(), std::vector<std::string>{bad.name}) << "nothing is written when nothing could be done";
}

TEST_P(EveryBadRecord, BesideGoodRecordsIsNamedAndLeftOut) {
  const BadRecord& bad = GetParam();
  const std::string message = bad.name + std::string(bad.message);
  const std::vector<std::string> good = CopyMeasurements("lateral", 2);
  CopyBadRecord(bad.name);
  const ProgramResult result = Run({good[0], bad.name, good[1], "--starts", "0"});
  EXPECT_EQ(result.exit_code, 1);
  // Notes on what was assumed when it was read may follow.
  EXPECT_TRUE(result.err == message + "\n" || result.err.starts_with(message + "\n" + bad.name + ": note: "))
      << result.err;
  EXPECT_NE(result.out.find("Left out (1):\n  " + message + "\n"), std::string::npos) << result.out;

  const Json json = ReadJson("out/result.json");
  ASSERT_EQ(json["records"].size(), 3u);
  for (const Json& record : json["records"]) {
    SCOPED_TRACE(record["file"]);
    if (record["file"] == bad.name) {
      EXPECT_EQ(record["used"], false);
      // A message of the reader is complete; one about what was read goes without the name, which stands beside it.
      const std::string reason = record["reason"];
      EXPECT_TRUE(reason == message || ": " + reason == bad.message) << reason;
    } else {
      EXPECT_EQ(record["used"], true);
      EXPECT_TRUE(record["reason"].is_null());
    }
  }
}

// The good ones come out as if the bad one had not been there.
TEST_P(EveryBadRecord, DoesNotChangeTheOthers) {
  const BadRecord& bad = GetParam();
  const std::vector<std::string> good = CopyMeasurements("lateral", 2);
  CopyBadRecord(bad.name);
  Run({good[0], good[1], "--starts", "0", "--out", "without"});
  Run({good[0], good[1], bad.name, "--starts", "0", "--out", "with"});
  EXPECT_EQ(ReadJson("with/result.json")["fit"]["parameters"], ReadJson("without/result.json")["fit"]["parameters"]);
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryBadRecord, testing::ValuesIn(kBadRecords), [](const auto& bad) {
  std::string name = bad.param.name;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
  return name;
});

/// What is no file that can be read, under `name`; the message goes on behind the name.
class UnreadableFile : public BadInput {
 protected:
  void ExpectRefused(const std::string& name, const std::string& message, bool as_nobody = false) {
    const std::vector<std::string> good = CopyMeasurements("lateral", 2);
    const auto run = [&](const std::vector<std::string>& arguments) {
      return as_nobody ? RunAsNobody(arguments) : Run(arguments);
    };
    const ProgramResult alone = run({name});
    EXPECT_EQ(alone.exit_code, 2);
    EXPECT_EQ(alone.out, "");
    EXPECT_EQ(alone.err, name + message + "\nidentify: the record cannot be used\n");
    EXPECT_FALSE(Exists("out"));

    const ProgramResult beside = run({good[0], name, good[1], "--starts", "0"});
    EXPECT_EQ(beside.exit_code, 1);
    EXPECT_EQ(beside.err, name + message + "\n");
    const Json json = ReadJson("out/result.json");
    ASSERT_EQ(json["records"].size(), 3u);
    EXPECT_EQ(json["records"][2]["file"], name);
    EXPECT_EQ(json["records"][2]["used"], false);
    EXPECT_EQ(json["records"][2]["reason"], name + message);
  }
};

TEST_F(UnreadableFile, Missing) {
  ExpectRefused("lateral_99.txt", ": expected a readable file, found nothing of that name");
}

TEST_F(UnreadableFile, Directory) {
  std::filesystem::create_directory(Folder() / "lateral");
  ExpectRefused("lateral", ": expected a readable file, found a directory");
}

TEST_F(UnreadableFile, BehindAFile) {
  Write("notes", "");
  ExpectRefused("notes/lateral.txt", ": expected a readable file, found a file where its path has a folder");
}

TEST_F(UnreadableFile, Device) { ExpectRefused("/dev/zero", ": expected a record, found a device"); }

// Root may read everything, so root gives its rights up for this test; who is not root has none to begin with.
TEST_F(UnreadableFile, WithoutPermission) {
  const bool root = geteuid() == 0;
  Write("lateral_secret.txt", PlainDecay{}.Text());
  chmod((Folder() / "lateral_secret.txt").c_str(), 0);
  chmod(Folder().c_str(), 0777);
  if (root && RunAsNobody({"--version"}).exit_code != 0)
    GTEST_SKIP() << "root cannot give up its rights here, or nobody cannot run the program: root reads every file";
  ExpectRefused("lateral_secret.txt", ": expected a readable file, found no permission", root);
}

// A decay below the limit of sliding after a push: k + sum k_i can be told from it, friction cannot.
TEST_F(BadInput, DecayThatNeverSlides) {
  std::mt19937_64 random(2);
  std::normal_distribution<double> noise(0, 0.0125);
  const double w = std::sqrt(9.82 * 5.62);  // k + k1 = 5.62 1/m
  std::string text = "# direction: lateral\n# mass_kg: 378.2\n";
  for (int i = 0; i < 3000; ++i) {
    const double t = i / 200.0, amplitude = 6 * std::clamp((t - 1) / 2, 0.0, 1.0);
    text += fmt::format("{:.3f} {:.3f}\n", t, amplitude * std::sin(w * (t - 1)) + noise(random));
  }
  Write("rolling.txt", text);
  const ProgramResult alone = Run({"rolling.txt"});
  EXPECT_EQ(alone.exit_code, 2);
  // 1.1824 Hz = w/2 pi and 5.62 1/m were put in; the last half swing of so soft a push counts as free, which is 0.05 %.
  EXPECT_EQ(alone.err,
            "rolling.txt: expected a decay that slides at first, found one that only rolls, at 1.183 Hz: k + sum k_i = "
            "5.63 1/m, and nothing about k and friction; push farther\nidentify: the record cannot be used\n");
  const std::vector<std::string> good = CopyMeasurements("lateral", 2);
  EXPECT_EQ(Run({good[0], good[1], "rolling.txt", "--starts", "0"}).exit_code, 1);
  EXPECT_EQ(ReadJson("out/result.json")["records"][2]["used"], false);
}

// The header says lateral, the link was longitudinal: its stiffness gives it away, once three others agree.
TEST_F(BadInput, WrongDirectionBesideGoodRecords) {
  std::vector<std::string> words = CopyMeasurements("lateral", 3);
  CopyBadRecord("wrong_direction.txt");
  words.insert(words.end(), {"wrong_direction.txt", "--starts", "0"});
  const ProgramResult result = Run(words);
  EXPECT_EQ(result.exit_code, 1);
  const Json record = ReadJson("out/result.json")["records"][3];
  EXPECT_EQ(record["used"], false);
  const std::string reason = record["reason"];
  EXPECT_EQ(result.err, "wrong_direction.txt: " + reason + "\n");
  EXPECT_TRUE(reason.starts_with("expected the link of the other lateral records, k + sum k_i about 5.")) << reason;
  EXPECT_TRUE(reason.ends_with("is it a longitudinal record, or of another link?")) << reason;
}

// Two records that differ: nobody can say which is the wrong one, so both stay, and the result is not to be trusted.
TEST_F(BadInput, TwoRecordsThatCannotBeOfOneLink) {
  const std::vector<std::string> good = CopyMeasurements("lateral", 1);
  CopyBadRecord("wrong_direction.txt");
  const ProgramResult result = Run({good[0], "wrong_direction.txt", "--starts", "0"});
  EXPECT_EQ(result.exit_code, 1);
  const Json warnings = ReadJson("out/result.json")["fit"]["warnings"];
  EXPECT_NE(warnings.dump().find("are they all of one link and one direction?"), std::string::npos) << warnings;
  EXPECT_NE(result.out.find("warning: k + sum k_i of the records is between"), std::string::npos) << result.out;
}

TEST_F(BadInput, HeaderAndNameThatDisagreeAreNoticed) {
  Write("longitudinal_07.txt", PlainDecay{}.Text());
  const ProgramResult result = Run({"longitudinal_07.txt", "--starts", "0"});
  EXPECT_EQ(result.err,
            "longitudinal_07.txt: note: taken as lateral, as the file says, although its name says longitudinal\n");
  EXPECT_EQ(ReadJson("out/result.json")["direction"], "lateral");
}

TEST_F(BadInput, RecordWithoutDirection) {
  const std::string message =
      "decay.txt: expected a direction (header \"# direction: lateral\", a file name with lateral or longitudinal, or "
      "--direction), found none\n";
  Write("decay.txt", PlainDecay{}.Text("# mass_kg: 378.2\n"));
  const ProgramResult without = Run({"decay.txt"});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_EQ(without.err, message + "identify: the record cannot be used\n");
  EXPECT_EQ(Run({"decay.txt", "--direction", "lateral"}).exit_code, 0);
}

// A record given twice would count twice and make the bounds too narrow.
TEST_F(BadInput, RecordGivenTwice) {
  const std::vector<std::string> good = CopyMeasurements("lateral", 2);
  const ProgramResult result = Run({good[0], good[1], "./" + good[0], "--starts", "0"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.err, "./lateral_01.txt: expected every record once, found it a second time\n");
  EXPECT_EQ(ReadJson("out/result.json")["records"][2]["used"], false);
}

// Samples beyond what a fit needs are averaged: a million of them must neither take a minute nor half a gigabyte, nor
// change the answer.
TEST_F(BadInput, MillionSamplesInFifteenSeconds) {
  const PlainDecay decay{.rate_hz = 1e6 / 15, .duration_s = 15, .noise_mm = 0.05};
  Write("dense.txt", decay.Text());
  const ProgramResult result = Run({"dense.txt"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "dense.txt: note: 1000000 samples, averaged in groups of 17 to 58823 at 3921.57 Hz\n");
  const Json fit = ReadJson("out/result.json")["fit"];
  for (const auto& [name, truth] : {std::pair{"k", decay.k}, {"k1", decay.k1}, {"T01", decay.T0}}) {
    const Json value = fit["parameters"][name];
    EXPECT_LE(value["low"], truth) << name;
    EXPECT_GE(value["high"], truth) << name;
  }
}

TEST_F(BadInput, MillionSamplesInFiveThousandSeconds) {
  const PlainDecay decay{.duration_s = 5000};
  Write("long.txt", decay.Text());
  const ProgramResult result = Run({"long.txt", "--starts", "0"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(result.err.starts_with("long.txt: note: 99") &&
              result.err.ends_with(" samples of the decay, the first 300 s are fitted\n"))
      << result.err;
}

}  // namespace
}  // namespace uiclink
