#include "identify/record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/record_samples.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// What the reader says about a text that it cannot use.
std::string Fault(const std::string& text, const ReadOptions& options = {}) {
  try {
    ParseRecord(text, "r.txt", options);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no fault";
}

std::string WithLine(int line, const std::string& content) {  // 1-based
  std::string text = MakeRows(Plain);
  std::size_t start = 0;
  for (int i = 1; i < line; ++i) start = text.find('\n', start) + 1;
  return text.replace(start, text.find('\n', start) - start, content);
}

// --- how files are written -----------------------------------------------------------------------------------------

TEST(RecordTextTest, ReadsTheDesignsFormat) {
  const Record record = ParseRecord(
      "# direction: longitudinal\n"
      "# mass_kg: 400.5\n"
      "% g: 9.81\n"
      "#sampling_hz: 200\n"
      "# source: bench 3, dry\n"
      "# displacement_unit: mm\n" +
          MakeRows(Plain),
      "some.txt");
  ExpectStandard(record);
  EXPECT_EQ(record.file, "some.txt");
  EXPECT_EQ(record.direction, Direction::kLongitudinal);
  EXPECT_EQ(record.mass_kg, 400.5);
  EXPECT_EQ(record.g, 9.81);
  EXPECT_EQ(record.source, "bench 3, dry");
  EXPECT_THAT(record.notices, IsEmpty());
}

TEST(RecordTextTest, TakesEverySeparator) {
  for (const char* const separator : {"\t", " ", "   ", ",", ", ", ";", " ; ", " \t ", ",\t"}) {
    ExpectStandard(MakeRows([=](double t, double y) { return fmt::format("{:.3f}{}{:.3f}\n", t, separator, y); }));
    ExpectStandard(MakeRows([=](double t, double y) { return fmt::format("  {:.3f}{}{:.3f}  \n", t, separator, y); }));
  }
}

TEST(RecordTextTest, TakesDecimalCommas) {
  for (const char* const separator : {"\t", " ", ";", "; "}) {
    ExpectStandard(
        WithCommas(MakeRows([=](double t, double y) { return fmt::format("{:.3f}{}{:.3f}\n", t, separator, y); })));
  }
  ExpectStandard(WithCommas(MakeRows([](double, double y) { return fmt::format("{:.3f}\n", y); })), {.rate_hz = 200});
}

TEST(RecordTextTest, IntegersAmongDecimalsChangeNothing) {
  ExpectStandard(WithCommas(MakeRows([](double t, double y) { return fmt::format("{:g};{:g}\n", t, y); })));
  ExpectStandard(MakeRows([](double t, double y) { return fmt::format("{:g},{:g}\n", t, y); }));
}

TEST(RecordTextTest, TellsColumnsOfIntegersFromDecimals) {
  const std::string counts =
      "n,reading\n" + MakeRows([](double t, double y) { return fmt::format("{:.0f},{:.0f}\n", 200 * t, 1000 * y); });
  const Record record = ParseRecord(counts, "x", {.rate_hz = 200, .displacement_unit = "um"});
  ExpectStandard(record, 1e-3);
  EXPECT_THAT(Fault(MakeRows([](double t, double y) { return WithCommas(fmt::format("{:.3f},{:.3f}\n", t, y)); })),
              HasSubstr("commas that may be decimal signs or separate columns"));
}

TEST(RecordTextTest, TakesEveryLineEndAndByteOrderMark) {
  const std::string text = "# direction: lateral\n" + MakeRows(Plain);
  ExpectStandard(Replace(text, "\n", "\r\n"));
  ExpectStandard(Replace(text, "\n", "\r\r\n"));  // written twice through text mode
  ExpectStandard(Replace(text, "\n", "\r"));
  ExpectStandard(Replace(text, "\n", "\n\n"));
  ExpectStandard("\xEF\xBB\xBF" + text);
  ExpectStandard(text.substr(0, text.size() - 1));  // no line end at the end
  std::string little = "\xFF\xFE";
  std::string big = "\xFE\xFF";
  for (const char c : text) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  ExpectStandard(little);
  ExpectStandard(big);
}

TEST(RecordTextTest, TakesSignsAndExponents) {
  ExpectStandard(MakeRows([](double t, double y) { return fmt::format("{:.6e} {:+.3f}\n", t, y); }));
  ExpectStandard(MakeRows([](double t, double y) {  // Fortran
    return Replace(fmt::format("{:.6e} {:.6E}\n", t, y), "E", "D");
  }));
}

TEST(RecordTextTest, TakesCommentsAnywhere) {
  ExpectStandard(MakeRows(
      [](double t, double y) { return fmt::format("% a word at {0:g} s\n{0:.3f} {1:.3f} # and another\n", t, y); }));
}

TEST(RecordTextTest, TakesNamesAndUnitsOfColumns) {
  ExpectStandard("time displacement\n" + MakeRows(Plain));
  ExpectStandard("Test of March 2003, four links, sandblasted\n\ntime;displacement\n" + MakeRows(Plain));
  ExpectStandard("t [ms]; y [cm]\n" +
                 MakeRows([](double t, double y) { return fmt::format("{:.1f};{:.4f}\n", 1000 * t, y / 10); }));
  ExpectStandard("t\ty\nms\tum\n" +
                 MakeRows([](double t, double y) { return fmt::format("{:.1f}\t{:.0f}\n", 1000 * t, 1000 * y); }));
  ExpectStandard("# time (s), displacement (m)\n" +
                 MakeRows([](double t, double y) { return fmt::format("{:.3f},{:.6f}\n", t, y / 1000); }));
  EXPECT_EQ(ParseRecord("t;longitudinal\n" + MakeRows(Plain), "x").direction, Direction::kLongitudinal);
}

TEST(RecordTextTest, ConvertsEveryUnit) {
  const std::vector<std::pair<std::string, double>> units = {
      {"mm", 1e-3},   {"cm", 1e-2},   {"m", 1},   {"um", 1e-6},        {"\xC2\xB5m", 1e-6},
      {"in", 0.0254}, {"mrad", 1e-3}, {"rad", 1}, {"deg", M_PI / 180}, {"MM", 1e-3}};
  for (const auto& [unit, metres] : units) {
    const std::string text = "# displacement_unit: " + unit + "\n" + MakeRows([](double t, double y) {
                               return fmt::format("{:.3f} {:.6f}\n", t, y / 10);  // 2.5 of any unit is believable
                             });
    const Record record = ParseRecord(text, "x");
    EXPECT_NEAR(record.y[0], 2.5 * metres, 1e-15) << unit;
  }
}

TEST(RecordTextTest, ReadsOneColumnWithARate) {
  const std::string text = MakeRows([](double, double y) { return fmt::format("{:.3f}\n", y); });
  ExpectStandard(text, {.rate_hz = 200});
  ExpectStandard("# sampling_hz: 200 Hz\n" + text);
  EXPECT_EQ(Fault(text),
            "r.txt:1: expected time and displacement, found one column; give the sampling rate with --rate HZ, or in "
            "the file: \"# sampling_hz: HZ\"");
}

TEST(RecordTextTest, ReadsTheChosenColumn) {
  const std::string text =
      MakeRows([](double t, double y) { return fmt::format("{:.3f};10:15:03;{:.3f};ok\n", t, y); });
  ExpectStandard(text, {.column = 3});
  ExpectStandard(text, {.rate_hz = 200, .column = 3});
  EXPECT_THAT(Fault(text), HasSubstr("r.txt:1: expected a displacement, found \"10:15:03\""));
  EXPECT_THAT(Fault(text, {.column = 7}), HasSubstr("column 7 (--column 7), found 4 columns"));
  EXPECT_THAT(Fault(text, {.column = 1}), HasSubstr("--rate HZ"));
}

TEST(RecordTextTest, ARateFromTheUserBeatsTheTimeColumn) {
  const std::string text =
      MakeRows([](double t, double y) { return fmt::format("{:.0f} {:.3f}\n", 200 * t, y); });  // counts samples
  const Record record = ParseRecord(text, "lateral", {.rate_hz = 200});
  ExpectStandard(record);
  EXPECT_THAT(record.notices, testing::Contains(HasSubstr("column 1 is not used as time")));
  // Two displacements and no time: the reader must not choose.
  const std::string two = MakeRows([](double, double y) { return fmt::format("{:.3f} {:.3f}\n", y, 2 * y); });
  EXPECT_THAT(Fault(two, {.rate_hz = 200}), HasSubstr("--column N"));
  ExpectStandard(two, {.rate_hz = 200, .column = 1});
}

TEST(RecordTextTest, ValuesBelowTheHeadersNamesAreNoSample) {
  const std::string data = MakeRows([](double, double y) { return fmt::format("{:.3f}\n", y); });
  const Record record = ParseRecord("start, sample_rate, duration\n90, 200, 5 \n" + data, "x");
  ExpectStandard(record);
  EXPECT_THAT(record.notices, testing::Contains("sampling rate 200 Hz taken from the header (line 2)"));
  // Without the names there is nothing that says what such a line is.
  EXPECT_EQ(Fault("90, 200, 5\n" + data, {.rate_hz = 200}),
            "r.txt:1: expected 1 column as in most lines, found 3 in \"90, 200, 5\"; mark lines that are no data as "
            "comments with #");
  // As many columns as the data: a sample like any other.
  EXPECT_EQ(ParseRecord("t y\n" + MakeRows(Plain), "x").t.size(), kSamples);
}

TEST(RecordTextTest, TakesGapsThatTheRecordSaysItHas) {
  const std::string text = MakeRows([](double t, double y) { return t > 0.0999 && t < 0.1249 ? "" : Plain(t, y); });
  const Record record = ParseRecord("# missing_samples: 5\n# mass_kg: 378.2\n" + text, "r.txt");
  EXPECT_FALSE(record.uniform);
  EXPECT_DOUBLE_EQ(record.sampling_hz, 200);
  EXPECT_THAT(record.notices, testing::Contains("samples are missing, as the record says: 1 gap of up to 30 ms"));
}

TEST(RecordTextTest, KeepsIrregularTimes) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> jitter(0, 0.004);
  std::vector<double> times;
  const std::string text = MakeRows([&](double t, double y) {
    times.push_back(std::round(1e6 * (t + jitter(random))) / 1e6);
    return fmt::format("{:.6f} {:.3f}\n", times.back(), y);
  });
  const Record record = ParseRecord(text, "x");
  EXPECT_FALSE(record.uniform);
  EXPECT_EQ(record.t, times);
  EXPECT_NEAR(record.sampling_hz, (kSamples - 1) / (times.back() - times.front()), 1e-9);
  EXPECT_THAT(record.notices, testing::Contains(HasSubstr("not equally spaced")));
}

TEST(RecordTextTest, UndoesTheRoundingOfTimes) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += fmt::format("{:.3f} {:.3f}\n", i / 333.0, DisplacementMm(i));
  const Record record = ParseRecord(text, "x");
  EXPECT_TRUE(record.uniform);
  // A line through errors of at most q / 2 is tilted by at most (q / 2) sum|x| / sum x^2 = 1.5 q / n a step.
  EXPECT_NEAR(record.sampling_hz / 333, 1, 1.5 * 0.001 / (300 / 333.0));
  EXPECT_THAT(record.notices, testing::Contains(HasSubstr("rounded to 1 ms")));
  EXPECT_DOUBLE_EQ(ParseRecord("# sampling_hz: 333\n" + text, "x").sampling_hz, 333);
}

TEST(RecordTextTest, LeavesOutALastLineThatIsCutShort) {
  const Record record = ParseRecord(MakeRows(Plain) + "0.2", "x");
  EXPECT_EQ(record.t.size(), kSamples);
  EXPECT_THAT(record.notices, testing::Contains("line 41 left out: the file ends within it (\"0.2\")"));
}

// --- what is known about the measurement ----------------------------------------------------------------------------

TEST(RecordHeaderTest, DirectionFallsBackToTheFileName) {
  const std::string text = MakeRows(Plain);
  const auto direction = [&](const std::string& file) { return ParseRecord(text, file).direction; };
  EXPECT_EQ(direction("lateral_01.txt"), Direction::kLateral);
  EXPECT_EQ(direction("a/b/Longitudinal-7.csv"), Direction::kLongitudinal);
  EXPECT_EQ(direction("2003_LATERAL_dry.txt"), Direction::kLateral);
  EXPECT_EQ(direction("lateral/03.txt"), std::nullopt) << "the folder is not the file's name";
  EXPECT_EQ(direction("collateral.txt"), std::nullopt);
  EXPECT_EQ(direction("lateral_longitudinal.txt"), std::nullopt);
  EXPECT_EQ(ParseRecord("# direction: Longitudinal\n" + text, "lateral_1.txt").direction, Direction::kLongitudinal);
  EXPECT_EQ(ParseRecord("# direction: lateral\n" + text, "x", {.direction = Direction::kLongitudinal}).direction,
            Direction::kLongitudinal);
}

TEST(RecordHeaderTest, MassIsAssumedWithANotice) {
  const Record record = ParseRecord(MakeRows(Plain), "lateral");
  EXPECT_EQ(record.mass_kg, 378.2);
  EXPECT_EQ(record.g, kThesisGravity);
  EXPECT_THAT(record.notices, ElementsAre("mass 378.2 kg assumed (as in the thesis); the file has no \"# mass_kg:\""));
  const Record given = ParseRecord("# mass_kg: 3\n" + MakeRows(Plain), "x", {.mass_kg = 500, .g = 9.8});
  EXPECT_EQ(given.mass_kg, 500);
  EXPECT_EQ(given.g, 9.8);
  EXPECT_THAT(given.notices, IsEmpty());
}

TEST(RecordHeaderTest, FreeCommentsAreLeftAlone) {
  const Record record = ParseRecord(
      "# measured at 12:30, mass of beam: 100\n#\n# http://x.y\n# mass: 400\n" + MakeRows(Plain), "x", {.mass_kg = 1});
  EXPECT_THAT(record.notices, ElementsAre("line 4: header key \"mass\" is not used; did you mean \"mass_kg\"?"));
}

TEST(RecordHeaderTest, WrongValuesAreNamed) {
  const std::string rows = MakeRows(Plain);
  EXPECT_EQ(Fault("# mass_kg: heavy\n" + rows), "r.txt:1: expected a mass in kg above 0, found \"heavy\"");
  EXPECT_THAT(Fault("\n# mass_kg: -3\n" + rows), HasSubstr("r.txt:2: expected a mass in kg above 0"));
  EXPECT_EQ(Fault("# direction: up\n" + rows), "r.txt:1: expected direction lateral or longitudinal, found \"up\"");
  EXPECT_EQ(Fault("# displacement_unit: V\n" + rows),
            "r.txt:1: expected a displacement unit (mm, cm, m, um, in, mrad, rad, deg), found \"V\"");
  EXPECT_THAT(Fault("t [s];y [V]\n" + rows), HasSubstr("r.txt:1: expected a displacement unit"));
  EXPECT_THAT(Fault("# sampling_hz: 0\n" + rows), HasSubstr("a sampling rate in Hz above 0"));
}

TEST(RecordHeaderTest, DisagreementOfRatesIsNoticed) {
  const Record record = ParseRecord("# sampling_hz: 1000\n" + MakeRows(Plain), "x");
  EXPECT_NEAR(record.sampling_hz, 200, 1e-9);
  EXPECT_THAT(record.notices,
              testing::Contains("the header says 1000 Hz, the time column 200 Hz: the time column is used"));
}

// --- faults ----------------------------------------------------------------------------------------------------------

TEST(RecordFaultTest, NothingToRead) {
  EXPECT_EQ(Fault(""), "r.txt: expected lines of time [s] and displacement [mm], found an empty file");
  EXPECT_EQ(Fault(" \n\n"), "r.txt: expected lines of time [s] and displacement [mm], found an empty file");
  EXPECT_EQ(Fault("# a\n% b\n"), "r.txt:2: expected lines of time [s] and displacement [mm], found only comments");
  EXPECT_EQ(Fault("\nDear colleague,\n"),
            "r.txt:2: expected lines of time [s] and displacement [mm], found text: \"Dear colleague,\"");
  EXPECT_THAT(Fault(std::string("0 1\n0\0", 6)), HasSubstr("r.txt:2: expected text, found binary data"));
  EXPECT_THAT(Fault("\x89\x90\x91 \x01\n"), HasSubstr("found text: \"\\x89\\x90\\x91 \\x01\""));
}

TEST(RecordFaultTest, BadLinesAreNamedAndCounted) {
  EXPECT_EQ(Fault(WithLine(7, "0.030\tnan")),
            "r.txt:7: expected a displacement, found \"nan\"; cut or interpolate such lines, or mark them as comments "
            "with #");
  EXPECT_THAT(Fault(WithLine(7, "0.030\tinf")), HasSubstr("r.txt:7: expected a displacement, found \"inf\""));
  EXPECT_THAT(Fault(WithLine(7, "0.030\t1e999")), HasSubstr("r.txt:7: expected a displacement, found \"1e999\""));
  EXPECT_THAT(Fault(WithLine(7, "0.030\t--")), HasSubstr("r.txt:7: expected a displacement, found \"--\""));
  EXPECT_THAT(Fault(WithLine(7, "oops\t1")), HasSubstr("r.txt:7: expected a time in seconds, found \"oops\""));
  EXPECT_THAT(Fault(WithLine(7, "0.030")), HasSubstr("r.txt:7: expected 2 columns as in most lines, found 1"));
  EXPECT_THAT(Fault(WithLine(7, "0.030\t1\t2")), HasSubstr("r.txt:7: expected 2 columns as in most lines, found 3"));
  EXPECT_THAT(Fault(WithLine(1, "0.000\tnan")), HasSubstr("r.txt:1: expected a displacement, found \"nan\""));
  EXPECT_THAT(Fault(Replace(WithLine(7, "0.030\t"), "\t", ";")), HasSubstr("r.txt:7: expected 2 columns"));
  EXPECT_THAT(Fault(Replace(WithLine(7, "\t3.0"), "\t", " ; ")),
              HasSubstr("r.txt:7: expected a time in seconds, found an empty field"));
  const std::string text = MakeRows([](double t, double y) { return t > 0.0999 ? "0.1\tnan\n" : Plain(t, y); });
  EXPECT_THAT(Fault(text), HasSubstr("r.txt:21: expected a displacement"));
  EXPECT_THAT(Fault(text), HasSubstr("; and 19 more lines like it"));
  EXPECT_THAT(Fault(Replace(WithLine(7, "0.030\tnan"), "0.100", "x")), HasSubstr("; and 1 line with other faults"));
}

TEST(RecordFaultTest, TimeThatDoesNotIncrease) {
  EXPECT_EQ(Fault(WithLine(7, "0.020\t1.0")),
            "r.txt:7: expected a time after 0.025 s, found 0.02 s: time runs backwards; keep one run per file, in the "
            "order of time");
  EXPECT_EQ(Fault(WithLine(7, "0.025\t1.0")),
            "r.txt:7: expected a time after 0.025 s, found 0.025 s: time repeats; write time with more decimals, or "
            "give --rate HZ to ignore the time column");
  EXPECT_THAT(Fault(MakeRows([](double t, double y) { return fmt::format("{} {}\n", y, t); })),
              HasSubstr("expected increasing times in column 1"));
  EXPECT_THAT(Fault(MakeRows([](double t, double y) { return fmt::format("{:.3f} {}\n", 1.7e12 + 1e3 * t, y); })),
              HasSubstr("r.txt:1: expected a time in seconds, found 1.7e+12"));
}

TEST(RecordFaultTest, Gaps) {
  const std::string text = MakeRows([](double t, double y) { return t > 0.0999 && t < 0.1249 ? "" : Plain(t, y); });
  EXPECT_EQ(
      Fault(text),
      "r.txt:21: expected a sample about 5 ms after 0.095 s, found the next one after 30 ms (about 5 missing); use "
      "the part before or after the gap, or give --rate HZ if only the time stamps are wrong");
  EXPECT_THAT(Fault("# one line more\n" + text), HasSubstr("r.txt:22:"));
  EXPECT_THAT(Fault("# missing_samples: some\n" + text), HasSubstr("r.txt:1: expected a number of missing samples"));
  EXPECT_THAT(Fault("# missing_samples: 0\n" + text), HasSubstr("r.txt:22:"));
}

TEST(RecordFaultTest, UnbelievableReadings) {
  EXPECT_EQ(Fault(WithLine(9, "0.040\t1.4e4")),
            "r.txt:9: expected a displacement within +-5000 mm, found 14000 mm (is the unit right? Set it in the file, "
            "for example \"# displacement_unit: um\")");
  EXPECT_THAT(Fault(MakeRows([](double t, double) { return fmt::format("{:.3f} 0.000\n", t); })),
              HasSubstr("r.txt:1: expected a displacement that moves, found 0 mm in all 40 samples"));
  const Record metres = ParseRecord(
      MakeRows([](double t, double y) { return fmt::format("{:.3f} {:.6f}\n", t, y / 1000); }), "x", {.mass_kg = 1});
  EXPECT_THAT(metres.notices, ElementsAre(HasSubstr("the record swings by +-0.0")));
}

TEST(RecordFaultTest, TooFewSamples) {
  EXPECT_EQ(Fault(MakeRows(Plain, 5)), "r.txt:5: expected at least 16 samples, found 5; is this the whole record?");
  EXPECT_EQ(ParseRecord(MakeRows(Plain, 16), "x").t.size(), 16U);
}

TEST(RecordFaultTest, OptionsOutOfRangeAreTheCallersFault) {
  const std::string text = MakeRows(Plain);
  EXPECT_THROW(ParseRecord(text, "x", {.rate_hz = 0}), std::invalid_argument);
  EXPECT_THROW(ParseRecord(text, "x", {.rate_hz = std::nan("")}), std::invalid_argument);
  EXPECT_THROW(ParseRecord(text, "x", {.column = 0}), std::invalid_argument);
  EXPECT_THROW(ParseRecord(text, "x", {.mass_kg = -1}), std::invalid_argument);
  EXPECT_THROW(ParseRecord(text, "x", {.displacement_unit = "V"}), std::invalid_argument);
}

// --- files ---------------------------------------------------------------------------------------------------------

TEST_F(RecordFileTest, ReadsAFile) { ExpectStandard(ReadRecord(Write("lateral_1.txt", MakeRows(Plain)))); }

TEST_F(RecordFileTest, NamesWhatIsNoReadableFile) {
  EXPECT_THAT(FileFault(Path("none.txt")), HasSubstr("none.txt: expected a readable file, found nothing"));
  EXPECT_THAT(FileFault(Path("")), HasSubstr("found a directory"));
  EXPECT_THAT(FileFault("/dev/zero"), HasSubstr("found a device"));
  const auto path = Write("locked.txt", MakeRows(Plain));
  std::filesystem::permissions(path, std::filesystem::perms::none);
  if (geteuid() != 0) {  // root may read everything
    EXPECT_THAT(FileFault(path), HasSubstr("found no permission"));
  }
}

TEST_F(RecordFileTest, ReadsAMillionSamplesInPassing) {
  std::string text;
  for (int i = 0; i < 1'000'000; ++i) text += fmt::format("{:.4f}\t{:.3f}\n", i * 1e-4, DisplacementMm(i % 1000));
  const auto path = Write("lateral_long.txt", text);
  const auto start = std::chrono::steady_clock::now();
  const Record record = ReadRecord(path);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(record.t.size(), 1'000'000U);
  EXPECT_TRUE(record.uniform);
  // Measured 0.1 s in a release build; the limit only tells linear from quadratic, under sanitizers on a busy machine.
  EXPECT_LT(seconds, 10);
  std::printf("[          ] %.3f s, %.0f MB/s\n", seconds, 1e-6 * static_cast<double>(text.size()) / seconds);
}

TEST_F(RecordFileTest, TextNamedMatIsText) { ExpectStandard(ReadRecord(Write("x.mat", MakeRows(Plain)))); }

}  // namespace
}  // namespace uiclink
