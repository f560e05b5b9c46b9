#include "data/table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::IsEmpty;

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

// --- values ---

TEST(Table, GivesTypedValues) {
  Table file = Table::Parse(
      "name = \"wagon \\u00e9\"\n"
      "mass = 13000\n"
      "wear = 1.5e-3\n"
      "loaded = true\n"
      "masses = [1, 2.5]\n"
      "panels = [\"left\", \"right\"]\n"
      "inertia = [[1.0, 2.0], [3.0]]\n"
      "[body]\n"
      "height = 0.8\n"
      "[[axles]]\n"
      "x = -4.0\n"
      "[[axles]]\n"
      "x = 4.0\n",
      "wagon.toml");
  EXPECT_EQ(file.String("name"), "wagon \xc3\xa9");
  EXPECT_EQ(file.Number("mass", Range::Positive("kg")), 13000);  // an integer is a number too
  EXPECT_EQ(file.OptionalNumber("wear", Range::Any("m")), 1.5e-3);
  EXPECT_TRUE(file.Bool("loaded"));
  EXPECT_THAT(file.Numbers("masses", Range::Positive("kg")), ElementsAre(1, 2.5));
  EXPECT_THAT(file.Strings("panels"), ElementsAre("left", "right"));
  EXPECT_THAT(file.Rows("inertia", Range::Any("kg m^2")), ElementsAre(ElementsAre(1, 2), ElementsAre(3)));
  std::optional<Table> body = file.OptionalTable("body");
  ASSERT_TRUE(body);
  EXPECT_EQ(body->name(), "body");
  EXPECT_EQ(body->Number("height", Range::Positive("m")), 0.8);
  std::vector<Table> axles = file.Tables("axles");
  ASSERT_EQ(axles.size(), 2);
  EXPECT_EQ(axles[1].name(), "axles[2]");
  EXPECT_EQ(axles[0].Number("x", Range::Any("m")), -4);
  EXPECT_EQ(axles[1].Number("x", Range::Any("m")), 4);
  EXPECT_NO_THROW(file.Finish());
}

TEST(Table, LeavesMissingOptionalKeysEmpty) {
  Table file = Table::Parse("", "empty.toml");
  EXPECT_EQ(file.OptionalNumber("mass", Range::Any("kg")), std::nullopt);
  EXPECT_EQ(file.OptionalString("name"), std::nullopt);
  EXPECT_EQ(file.OptionalBool("loaded"), std::nullopt);
  EXPECT_FALSE(file.OptionalTable("body").has_value());
  EXPECT_THAT(file.OptionalTables("axles"), IsEmpty());
  EXPECT_FALSE(file.Has("mass"));
  EXPECT_NO_THROW(file.Finish());
}

TEST(Table, KeepsTheOrderOfKeys) {
  Table file = Table::Parse("z = 1\na = 2\nm = { y = 1, b = 2 }\n", "f.toml");
  EXPECT_THAT(file.Keys(), ElementsAre("z", "a", "m"));
  EXPECT_THAT(file.OptionalTable("m")->Keys(), ElementsAre("y", "b"));
}

TEST(Table, TakesByteOrderMarkAndWindowsLineEnds) {
  Table file = Table::Parse("\xef\xbb\xbfk = 4.2\r\nT0 = -1\r\n", "f.toml");
  EXPECT_EQ(file.Number("k", Range::Positive("1/m")), 4.2);
  file.Number("T0", Range::NotNegative("-"));
  EXPECT_EQ(MessageOf([&] { file.Finish(); }), "f.toml:2: expected T0 >= 0 [-], found -1");
}

// --- ranges ---

TEST(Range, ContainsItsLimitsOnlyWhereIncluded) {
  EXPECT_FALSE(Range::Positive("m").Contains(0));
  EXPECT_TRUE(Range::NotNegative("m").Contains(0));
  const Range half_open{.unit = "-", .low = 0, .high = 1, .high_included = false};
  EXPECT_TRUE(half_open.Contains(0));
  EXPECT_FALSE(half_open.Contains(1));
  EXPECT_FALSE(Range::Any("m").Contains(NAN));
  EXPECT_FALSE(Range::Any("m").Contains(INFINITY));
}

TEST(Range, DescribesItself) {
  EXPECT_EQ(Range::Positive("1/m").Describe("k"), "k > 0 [1/m]");
  EXPECT_EQ(Range::NotNegative("-").Describe("T0"), "T0 >= 0 [-]");
  EXPECT_EQ(Range::Any("s/m").Describe("c"), "a finite number c [s/m]");
  const Range friction{.unit = "-", .low = 0, .high = 1, .low_included = false};
  EXPECT_EQ(friction.Describe("mu"), "0 < mu <= 1 [-]");
  const Range below{.unit = "m", .high = 3, .high_included = false};
  EXPECT_EQ(below.Describe("h"), "h < 3 [m]");
}

// --- faults ---

TEST(Table, ReportsAllFaultsOfAFileAtOnceInItsOrder) {
  Table file = Table::Parse(
      "# a comment\n"
      "k = -3\n"
      "mass = \"heavy\"\n"
      "gravity = inf\n"
      "slope = nan\n"
      "wear = [1.0, -2.0, \"x\"]\n"
      "name = 7\n"
      "loaded = \"yes\"\n"
      "axles = [ { x = 1.0 }, 3 ]\n"
      "sldiers = []\n"
      "zzz = 1979-05-27\n"
      "[body]\n"
      "hight = 0.8\n",
      "w.toml");
  EXPECT_TRUE(std::isnan(file.Number("k", Range::Positive("1/m"))));
  file.Number("mass", Range::Positive("kg"));
  file.Number("gravity", Range::Positive("m/s^2"));
  file.Number("slope", Range::Any("-"));
  EXPECT_EQ(file.Numbers("wear", Range::NotNegative("mm")).size(), 3);
  EXPECT_EQ(file.String("name"), "");
  EXPECT_FALSE(file.Bool("loaded"));
  for (Table& axle : file.Tables("axles")) axle.Number("x", Range::Any("m"));
  file.OptionalTables("sliders");
  file.OptionalTable("body")->Number("height", Range::Positive("m"));
  file.Number("load_N", Range::Positive("N"));
  EXPECT_EQ(
      MessageOf([&] { file.Finish(); }),
      "w.toml: expected load_N > 0 [N], found nothing\n"
      "w.toml:2: expected k > 0 [1/m], found -3\n"
      "w.toml:3: expected mass > 0 [kg], found \"heavy\"\n"
      "w.toml:4: expected gravity > 0 [m/s^2] and finite, found inf\n"
      "w.toml:5: expected a finite number slope [-], found nan\n"
      "w.toml:6: expected wear[2] >= 0 [mm], found -2\n"
      "w.toml:6: expected wear[3] >= 0 [mm], found \"x\"\n"
      "w.toml:7: expected name = \"text\", found 7\n"
      "w.toml:8: expected loaded = true or false, found \"yes\"\n"
      "w.toml:9: expected a table axles[2], found 3\n"
      "w.toml:10: expected a known key, found \"sldiers\" (did you mean \"sliders\"?)\n"
      "w.toml:11: expected a known key, found \"zzz\" (known: axles, body, gravity, k, load_N, loaded, mass, name, "
      "sliders, slope, wear)\n"
      "w.toml:12: expected height > 0 [m] in body, found nothing\n"
      "w.toml:13: expected a known key in body, found \"hight\" (did you mean \"height\"?)");
}

TEST(Table, SaysTheLineOfTheFirstFault) {
  Table file = Table::Parse("\n\nk = 0\n", "f.toml");
  file.Number("k", Range::Positive("1/m"));
  try {
    file.Finish();
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_EQ(error.line(), 3);
  }
}

TEST(Table, NamesKeysThatNobodyKnowsInNestedTables) {
  Table file = Table::Parse("[a]\nb = { c = 1, d = { e = 2 } }\n", "f.toml");
  Table b = *file.OptionalTable("a")->OptionalTable("b");
  b.Number("c", Range::Any("m"));
  EXPECT_EQ(MessageOf([&] { file.Finish(); }), "f.toml:2: expected a known key in a.b, found \"d\" (known: c)");
}

TEST(Table, DoesNotGuessAtUnrelatedKeys) {
  Table file = Table::Parse("xy = 1\n", "f.toml");
  file.OptionalNumber("T0", Range::Any("-"));
  EXPECT_EQ(MessageOf([&] { file.Finish(); }), "f.toml:1: expected a known key, found \"xy\" (known: T0)");
}

TEST(Table, SaysWhatStandsInPlaceOfATableOrArray) {
  Table file = Table::Parse("body = 3\naxles = { x = 1 }\nrow = [[1.0], 2.0]\nlist = []\n", "f.toml");
  EXPECT_FALSE(file.OptionalTable("body"));
  EXPECT_THAT(file.Tables("axles"), IsEmpty());
  file.Rows("row", Range::Any("m"));
  file.Number("list", Range::Any("m"));
  EXPECT_EQ(MessageOf([&] { file.Finish(); }),
            "f.toml:1: expected a table body, found 3\n"
            "f.toml:2: expected axles = [tables], found a table\n"
            "f.toml:3: expected row[2] = [numbers], found 2\n"
            "f.toml:4: expected a finite number list [m], found an empty array");
}

TEST(Table, TakesFaultsThatTheCallerFinds) {
  Table file = Table::Parse("low = 2.0\nhigh = 1.0\n", "f.toml");
  file.Number("low", Range::Any("m"));
  file.Number("high", Range::Any("m"));
  file.Report("high", "high > low", "1 <= 2");
  EXPECT_EQ(MessageOf([&] { file.Finish(); }), "f.toml:2: expected high > low, found 1 <= 2");
}

TEST(Table, RefusesWhatIsNoToml) {
  EXPECT_EQ(
      MessageOf([] { Table::Parse("k = 1.0\nk = 2.0\n", "f.toml"); }),
      "f.toml:2: expected TOML, found: Error while parsing key-value pair: cannot redefine existing floating-point "
      "'k'");
  EXPECT_THAT(MessageOf([] { Table::Parse("k = \n", "f.toml"); }),
              testing::StartsWith("f.toml:1: expected TOML, found: "));
  EXPECT_THAT(MessageOf([] { Table::Parse(std::string("\0\1\2\xff", 4), "f.toml"); }),
              testing::StartsWith("f.toml:1: expected TOML, found: "));
}

// --- files ---

class Files : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("uiclink_table_test_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename().string());
    return names;
  }

  fs::path folder_;
};

TEST_F(Files, ReadBackAsWritten) {
  const fs::path path = folder_ / "a" / "b" / "file.bin";
  const std::string content("\0\r\n\xff text", 9);
  WriteFileWhole(path, content);
  EXPECT_EQ(ReadFileWhole(path), content);
  WriteFileWhole(path, "");
  EXPECT_EQ(ReadFileWhole(path), "");
  const std::string large(1 << 20, 'x');
  WriteFileWhole(path, large);
  EXPECT_EQ(ReadFileWhole(path), large);
}

TEST_F(Files, LeaveNothingBesideThem) {
  WriteFileWhole(folder_ / "file.txt", "one");
  WriteFileWhole(folder_ / "file.txt", "two");
  EXPECT_THAT(Names(), ElementsAre("file.txt"));
}

TEST_F(Files, KeepSymbolicLinks) {
  WriteFileWhole(folder_ / "target", "old");
  fs::create_symlink("target", folder_ / "link");
  WriteFileWhole(folder_ / "link", "new");
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(ReadFileWhole(folder_ / "target"), "new");
}

TEST_F(Files, LeaveDevicesInPlace) {
  WriteFileWhole("/dev/null", "text");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(Files, SayWhyTheyCannotBeRead) {
  EXPECT_EQ(MessageOf([&] { ReadFileWhole(folder_); }),
            folder_.string() + ": expected a readable file, found a directory");
  EXPECT_EQ(MessageOf([&] { ReadFileWhole(folder_ / "none"); }),
            (folder_ / "none").string() + ": expected a readable file, found nothing of that name");
  WriteFileWhole(folder_ / "file", "x");
  EXPECT_EQ(
      MessageOf([&] { Table::Read(folder_ / "file" / "below"); }),
      (folder_ / "file" / "below").string() + ": expected a readable file, found a file where its path has a folder");
}

TEST_F(Files, SayThatPermissionIsMissing) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may read and write everything";
  WriteFileWhole(folder_ / "file", "x");
  fs::permissions(folder_ / "file", fs::perms::none);
  EXPECT_EQ(MessageOf([&] { ReadFileWhole(folder_ / "file"); }),
            (folder_ / "file").string() + ": expected a readable file, found no permission");
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_EQ(MessageOf([&] { WriteFileWhole(folder_ / "new", "x"); }),
            (folder_ / "new").string() + ": expected a file that can be written, found no permission");
}

TEST_F(Files, SayWhyTheyCannotBeWritten) {
  EXPECT_EQ(MessageOf([&] { WriteFileWhole(folder_, "x"); }),
            folder_.string() + ": expected a file that can be written, found a directory");
  WriteFileWhole(folder_ / "file", "old");
  EXPECT_EQ(MessageOf([&] { WriteFileWhole(folder_ / "file" / "below", "x"); }),
            (folder_ / "file" / "below").string() +
                ": expected a file that can be written, found a file where its path has a folder");
  EXPECT_EQ(MessageOf([&] { WriteFileWhole("/dev/full", "x"); }),
            "/dev/full: expected a file that can be written, found no space left");
  EXPECT_EQ(ReadFileWhole(folder_ / "file"), "old");
}

TEST(Table, TellsTablesFromOtherValuesAndTakesKeysAsKnown) {
  Table file = Table::Parse("a = { x = 1 }\nb = [1, 2]\nextra = 3\n", "f.toml");
  EXPECT_TRUE(file.HasTable("a"));
  EXPECT_FALSE(file.HasTable("b"));
  EXPECT_FALSE(file.HasTable("c"));
  EXPECT_THROW(file.Finish(), InputError) << "looking is not asking";
  file.Know({"a", "b", "extra", "never there"});
  EXPECT_NO_THROW(file.Finish());
}

}  // namespace
}  // namespace uiclink
