#include "reports/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace uiclink {
namespace {

TEST(ColumnWord, IsNameAndUnitAsOneWordOfMatlab) {
  EXPECT_EQ(ColumnWord({"time", "s", {}}), "time_s");
  EXPECT_EQ(ColumnWord({"front_lateral", "mm", {}}), "front_lateral_mm");
  EXPECT_EQ(ColumnWord({"speed", "m/s", {}}), "speed_m_per_s");
  EXPECT_EQ(ColumnWord({"acceleration", "m/s^2", {}}), "acceleration_m_per_s2");
  EXPECT_EQ(ColumnWord({"damping", "N s/m", {}}), "damping_N_s_per_m");
  EXPECT_EQ(ColumnWord({"real_part", "1/s", {}}), "real_part_per_s");
  EXPECT_EQ(ColumnWord({"share", "%", {}}), "share_percent");
  EXPECT_EQ(ColumnWord({"conicity", "-", {}}), "conicity");
  EXPECT_EQ(ColumnWord({"conicity", "", {}}), "conicity");
  EXPECT_EQ(ColumnWord({"2nd wheel", "mm", {}}), "x2nd_wheel_mm");
  EXPECT_EQ(ColumnWord({"", "", {}}), "x");
  EXPECT_EQ(ColumnWord({std::string(100, 'a'), "m", {}}).size(), 63u);
}

TEST(FormatCsv, NumbersReadBackAsTheSameDouble) {
  const double third = 1.0 / 3, tiny = std::numeric_limits<double>::denorm_min();
  const std::vector<DataColumn> columns{{"time", "s", {0, 0.1 + 0.2, 1e300}}, {"y", "m", {third, -tiny, std::nan("")}}};
  const std::string csv = FormatCsv(columns);
  EXPECT_EQ(csv, "time_s,y_m\n0,0.3333333333333333\n0.30000000000000004,-5e-324\n1e+300,\n");
  EXPECT_EQ(std::stod("0.3333333333333333"), third);
}

TEST(FormatCsv, WithoutRowsOrColumns) {
  EXPECT_EQ(FormatCsv({}), "");
  const std::vector<DataColumn> empty{{"time", "s", {}}};
  EXPECT_EQ(FormatCsv(empty), "time_s\n");
}

TEST(FormatCsv, NamesColumnsThatDoNotFit) {
  const std::vector<DataColumn> ragged{{"time", "s", {0, 1}}, {"y", "m", {0}}};
  EXPECT_THROW(
      {
        try {
          FormatCsv(ragged);
        } catch (const std::invalid_argument& error) {
          EXPECT_STREQ(error.what(), "FormatCsv: column y_m has 1 rows, column time_s has 2");
          throw;
        }
      },
      std::invalid_argument);
  const std::vector<DataColumn> twice{{"y", "m", {}}, {"y_m", "", {}}};
  EXPECT_THROW(FormatCsv(twice), std::invalid_argument);
}

TEST(CsvCell, IsQuotedWhereItMustBe) {
  EXPECT_EQ(CsvCell("front wheelset"), "front wheelset");
  EXPECT_EQ(CsvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvCell("say \"so\""), "\"say \"\"so\"\"\"");
  EXPECT_EQ(CsvCell("two\nlines"), "\"two\nlines\"");
}

}  // namespace
}  // namespace uiclink
