#include "reports/text_table.h"

#include <gtest/gtest.h>

#include <string>

namespace uiclink {
namespace {

using Align = TextTable::Align;

TEST(TextTable, AlignsNumbersRightAndWordsLeft) {
  TextTable table;
  table.AddColumn("record", Align::kLeft);
  table.AddColumn("k");
  table.AddRow({"a", "3.41"});
  table.AddRow({"lateral_01", "12.5"});
  EXPECT_EQ(table.Format(),
            "record         k\n"
            "────────────────\n"
            "a           3.41\n"
            "lateral_01  12.5\n");
}

TEST(TextTable, HeadsOfTwoLinesStandAboveEachOther) {
  TextTable table;
  table.AddColumn("parameter", Align::kLeft);
  table.AddColumn("rms\n[mm]");
  table.AddColumn("\nhigh");
  table.AddRow({"k", "1", "2"});
  EXPECT_EQ(table.Format(),
            "parameter   rms\n"
            "           [mm]  high\n"
            "─────────────────────\n"
            "k             1     2\n");
}

TEST(TextTable, IndentsEveryLine) {
  TextTable table;
  table.AddColumn("a");
  table.AddRow({"1"});
  table.AddRule();
  table.AddRow({"2"});
  EXPECT_EQ(table.Format(3),
            "   a\n"
            "   ─\n"
            "   1\n"
            "   ─\n"
            "   2\n");
}

TEST(TextTable, RulesSeparateRows) {
  TextTable table;
  table.AddColumn("x", Align::kLeft);
  table.AddRow({"one"});
  table.AddRule();
  table.AddRow({"all"});
  EXPECT_EQ(table.Format(),
            "x\n"
            "───\n"
            "one\n"
            "───\n"
            "all\n");
}

// Bytes are not columns: "±" and "µ" take two bytes and one column each.
TEST(TextTable, CountsCharactersNotBytes) {
  TextTable table;
  table.AddColumn("mean ± spread");
  table.AddColumn("µm");
  table.AddRow({"3.41 ± 0.02", "1"});
  table.AddRow({"3", "12"});
  EXPECT_EQ(table.Format(),
            "mean ± spread  µm\n"
            "─────────────────\n"
            "  3.41 ± 0.02   1\n"
            "            3  12\n");
}

TEST(TextTable, MissingCellsAreEmptyAndLeaveNoBlanksBehind) {
  TextTable table;
  table.AddColumn("a", Align::kLeft);
  table.AddColumn("b");
  table.AddColumn("c");
  table.AddRow({"x"});
  table.AddRow({"y", "", "1"});
  EXPECT_EQ(table.Format(),
            "a  b  c\n"
            "───────\n"
            "x\n"
            "y     1\n");
}

// More cells than columns cannot be shown; they must not shift the others or be read beyond the columns.
TEST(TextTable, SurplusCellsAreDropped) {
  TextTable table;
  table.AddColumn("a");
  table.AddRow({"1", "2", "3"});
  EXPECT_EQ(table.Format(), "a\n─\n1\n");
}

TEST(TextTable, WithoutRowsTheHeadStandsAlone) {
  TextTable table;
  table.AddColumn("record");
  EXPECT_EQ(table.Format(), "record\n──────\n");
}

TEST(DisplayWidth, CountsCodePoints) {
  EXPECT_EQ(DisplayWidth(""), 0u);
  EXPECT_EQ(DisplayWidth("k1"), 2u);
  EXPECT_EQ(DisplayWidth("3.41 ± 0.02"), 11u);
  EXPECT_EQ(DisplayWidth("─µé"), 3u);
}

}  // namespace
}  // namespace uiclink
