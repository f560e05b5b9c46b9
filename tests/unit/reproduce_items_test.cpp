// What `wagon reproduce` covers of chapter 10, how it compares, and its pages.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "reports/escape.h"
#include "tests/cli/temporary_folder.h"
#include "vehicle/reproduce/item.h"
#include "vehicle/reproduce/pages.h"
#include "vehicle/reproduce/result.h"

namespace uiclink::reproduce {
namespace {

using testing::HasSubstr;
using testing::Not;

/// "figure 10.5(a)" and "table 10.1, empty" are parts of "figure 10.5" and "table 10.1".
bool Covers(const std::string& covered, const std::string& published) {
  return covered == published || covered.starts_with(published + "(") || covered.starts_with(published + ",");
}

TEST(ReproduceItems, CoverEveryFigureAndTableOfTheChapter) {
  EXPECT_EQ(ListPublished().size(), 32u);
  for (const std::string& published : ListPublished()) {
    EXPECT_TRUE(std::ranges::any_of(Items(), [&](const Item& item) {
      return std::ranges::any_of(item.covers, [&](const std::string& c) { return Covers(c, published); });
    })) << published;
  }
  for (const char* part : {"figure 10.1(a)", "figure 10.1(b)", "figure 10.1(c)", "figure 10.1(d)", "figure 10.2(d)",
                           "figure 10.3(d)", "figure 10.5(f)", "figure 10.22(c)", "figure 10.23(b)", "figure 10.25(b)",
                           "table 10.1, packed", "table 10.2, water"}) {
    EXPECT_TRUE(std::ranges::any_of(Items(), [&](const Item& item) {
      return std::ranges::find(item.covers, part) != item.covers.end();
    })) << part;
  }
}

TEST(ReproduceItems, HaveIdsOfTheirOwnAndASection) {
  std::set<std::string> ids, covered;
  for (const Item& item : Items()) {
    EXPECT_TRUE(ids.insert(item.id).second) << item.id;
    for (const std::string& what : item.covers) EXPECT_TRUE(covered.insert(what).second) << what << " twice";
    EXPECT_NE(std::ranges::find(Sections(), item.section, &Section::number), Sections().end()) << item.id;
    EXPECT_FALSE(item.rows.empty()) << item.id;
    for (const Row& row : item.rows) EXPECT_EQ(row.theirs == "-", row.place.empty()) << item.id << ": " << row.what;
  }
  for (const Statement& statement : Statements()) {
    EXPECT_TRUE(ids.contains(statement.item)) << statement.item;
    EXPECT_TRUE(statement.than.empty() || ids.contains(statement.than)) << statement.than;
  }
}

ItemResult ResultOf(const Value& value) {
  ItemResult result;
  result.values["x"] = value;
  return result;
}

TEST(ReproduceComparison, SaysMetExplainedOrUnexplained) {
  const Row row{.what = "", .theirs = "18.4", .place = "10", .value = "x", .published = 18.4, .met_within = 0.05};
  const ItemResult met = ResultOf(18.43), off = ResultOf(19.32);
  EXPECT_EQ(Compare(row, "thesis-equivalent", &met).verdict, Verdict::kMet);
  EXPECT_EQ(Compare(row, "thesis-equivalent", &off).verdict, Verdict::kUnexplained);
  EXPECT_EQ(Compare(row, "thesis-equivalent", &off).difference, "+5.0 %");
  EXPECT_EQ(Compare(row, "nominal-1435", &off).verdict, Verdict::kOtherGeometry);
  EXPECT_EQ(Compare(row, "thesis-equivalent", nullptr).verdict, Verdict::kMissing);
  Row reason = row;
  reason.why = "because";
  EXPECT_EQ(Compare(reason, "thesis-equivalent", &off).verdict, Verdict::kExplained);
  EXPECT_EQ(Compare(reason, "thesis-equivalent", &off).why, "because");
  // What never happens is not met, and says so.
  const ItemResult never = ResultOf({});
  EXPECT_EQ(Compare(row, "thesis-equivalent", &never).verdict, Verdict::kUnexplained);
  EXPECT_EQ(Compare(row, "thesis-equivalent", &never).ours, "none");
}

TEST(ReproduceComparison, WordsAndRanges) {
  const Row word{.what = "", .theirs = "rear", .place = "10", .value = "x", .met_words = {"rear"}};
  const ItemResult rear = ResultOf("rear"), both = ResultOf("both"), high = ResultOf(25.4), low = ResultOf(17.0);
  EXPECT_EQ(Compare(word, "thesis-equivalent", &rear).verdict, Verdict::kMet);
  EXPECT_EQ(Compare(word, "thesis-equivalent", &both).verdict, Verdict::kUnexplained);
  const Row range{.what = "", .theirs = "above 20", .place = "10", .value = "x", .met_range = {{20, 300}}};
  EXPECT_EQ(Compare(range, "thesis-equivalent", &high).verdict, Verdict::kMet);
  EXPECT_EQ(Compare(range, "thesis-equivalent", &low).verdict, Verdict::kUnexplained);
  const Row nothing{.what = "", .theirs = "-", .place = "", .value = "x"};
  EXPECT_EQ(Compare(nothing, "thesis-equivalent", &high).verdict, Verdict::kNotCompared);
}

TEST(ReproduceStore, KeepsResultsBitByBitAndForgetsThoseOfOtherInputs) {
  const TemporaryFolder folder;
  const ResultStore store(folder.path());
  ItemResult result;
  result.values = {{"a", 0.1 + 0.2}, {"b", std::string("rear")}, {"c", Value()}};
  result.pictures = {{"t", "<svg/>", "{\"data\": []}"}};
  result.notices = {"n"};
  store.Write("g", "id", "key", result);
  const std::optional<ItemResult> read = store.Read("g", "id", "key");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->values, result.values);
  EXPECT_EQ(read->pictures[0].svg, "<svg/>");
  EXPECT_EQ(read->pictures[0].chart, "{\"data\": []}");
  EXPECT_FALSE(store.Read("g", "id", "other key"));
  EXPECT_FALSE(store.Read("g", "other", "key"));
  folder.Write("results/g/id.json", "{ \"schema\": \"wagon-rep");
  EXPECT_FALSE(store.Read("g", "id", "key"));
  result.drawn = false;  // to be done again once gnuplot is there
  store.Write("g", "id", "key", result);
  EXPECT_FALSE(store.Read("g", "id", "key"));
}

TEST(ReproducePages, AreOneForEachSectionWithEveryRow) {
  Reproduction reproduction;
  reproduction.geometries = {"thesis-equivalent", "nominal-1435"};
  for (const Item& item : Items()) reproduction.items.push_back(&item);
  for (const std::string& geometry : reproduction.geometries) reproduction.geometry_words[geometry] = "words";
  const auto pages = FormatPages(reproduction);
  EXPECT_EQ(pages.size(), 8u);  // seven sections and the index
  for (const Item& item : Items()) {
    const std::string& page = pages.at(item.section + ".html");
    EXPECT_THAT(page, HasSubstr("id=\"" + item.id + "\""));
    for (const Row& row : item.rows) EXPECT_THAT(page, HasSubstr(EscapeMarkup(row.what)));
  }
  for (const auto& [name, page] : pages) EXPECT_THAT(page, Not(HasSubstr("<script")));
}

}  // namespace
}  // namespace uiclink::reproduce
