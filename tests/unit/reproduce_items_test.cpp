// What `wagon reproduce` covers of chapter 10, how it compares, and its pages.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "tests/cli/temporary_folder.h"
#include "vehicle/reproduce/html.h"
#include "vehicle/reproduce/item.h"
#include "vehicle/reproduce/pages.h"
#include "vehicle/reproduce/result.h"
#include "vehicle/reproduce/thin.h"

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
  result.pictures = {{"t", "<svg/>"}};
  result.notices = {"n"};
  store.Write("g", "id", "key", result);
  const std::optional<ItemResult> read = store.Read("g", "id", "key");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->values, result.values);
  EXPECT_EQ(read->pictures[0].svg, "<svg/>");
  EXPECT_FALSE(store.Read("g", "id", "other key"));
  EXPECT_FALSE(store.Read("g", "other", "key"));
  folder.Write("results/g/id.json", "{ \"schema\": \"wagon-rep");
  EXPECT_FALSE(store.Read("g", "id", "key"));
  result.drawn = false;  // to be done again once gnuplot is there
  store.Write("g", "id", "key", result);
  EXPECT_FALSE(store.Read("g", "id", "key"));
}

TEST(ReproduceHtml, EscapesTextAndKeepsPicturesApart) {
  HtmlPage page("a < b");
  page.Table("x & y", {{{"<th>"}}}, {{{"\"quoted\""}}});
  const std::string svg = "<?xml?><svg width='9'><path id='p'/><use xlink:href='#p' fill='url(#p)'/></svg>";
  page.Picture(svg, "one");
  page.Picture(svg, "two");
  const std::string html = page.Format();
  EXPECT_THAT(html, HasSubstr("<html lang=\"en\">"));
  EXPECT_THAT(html, HasSubstr("<title>a &lt; b</title>"));
  EXPECT_THAT(html, HasSubstr("<th scope=\"col\">&lt;th&gt;</th>"));
  EXPECT_THAT(html, HasSubstr("&quot;quoted&quot;"));
  EXPECT_THAT(html, HasSubstr("<svg role=\"img\" aria-label=\"one\" width='9'><path id='p1-p'/><use "
                              "xlink:href='#p1-p' fill='url(#p1-p)'/></svg>"));
  EXPECT_THAT(html, HasSubstr("id='p2-p'"));
  EXPECT_THAT(html, Not(HasSubstr("<?xml")));
}

TEST(ReproduceHtml, SaysOnceWhatGnuplotSaysAtEveryTic) {
  const std::string group =
      "<g fill=\"none\" color=\"black\" stroke=\"currentColor\" stroke-width=\"0.80\" stroke-linecap=\"butt\" "
      "stroke-linejoin=\"miter\">";
  const std::string html =
      InlineSvg("<svg><g id=\"gnuplot_canvas\">\n<rect fill=\"#ffffff\"/>" + group + "\n</g>\n" + group +
                    "<path d='M1.25,10.00 L3.00,4.56  '/><text>18.40 m/s</text></g></g></svg>",
                "p-", "d");
  EXPECT_EQ(html,
            "<svg role=\"img\" aria-label=\"d\"><g id=\"p-gnuplot_canvas\" fill=\"none\" color=\"black\" "
            "stroke=\"currentColor\" stroke-linecap=\"butt\" stroke-linejoin=\"miter\" font-family=\"Helvetica\">\n"
            "<rect fill=\"#ffffff\" stroke=\"none\"/><g stroke-width=\"0.80\">"
            "<path d='M1.2,10.0 L3.0,4.5  "
            "'/><text>18.40 m/s</text></g></g></svg>");
}

TEST(ReproduceHtml, MakesOnePathOfDiscs) {
  const auto disc = [](const char* at, const char* colour) {
    return fmt::format("\t<use xlink:href='#gpPt6' transform='translate({}) scale(1.50)' color='{}'/>\n", at, colour);
  };
  const std::string html = InlineSvg("<svg><g id=\"gnuplot_canvas\">\n" + disc("1.5,2.5", "red") +
                                         disc("3.5,4.5", "red") + disc("5.5,6.5", "blue") + "</g></svg>\n",
                                     "p-", "d");
  EXPECT_THAT(html,
              HasSubstr("<path stroke-width='3' stroke-linecap='round' stroke='red' d='M1.5,2.5 h0M3.5,4.5 h0'/>\n"
                        "<path stroke-width='3' stroke-linecap='round' stroke='blue' d='M5.5,6.5 h0'/>\n</g></svg>"));
}

/// Value of the line at x, between its points.
double LineAt(const FigureSeries& line, double x) {
  const auto right = static_cast<std::size_t>(std::ranges::lower_bound(line.x, x) - line.x.begin());
  if (right == 0) return line.y.front();
  const double t = (x - line.x[right - 1]) / (line.x[right] - line.x[right - 1]);
  return (1 - t) * line.y[right - 1] + t * line.y[right];
}

TEST(ReproduceThinning, LinesStayWithinHalfAPixelAndGapsStay) {
  Figure figure{.panels = {{.series = {{}, {.line = FigureLine::kNone, .mark = FigureMark::kDot}}}},
                .width = 600,
                .panel_height = 200};
  FigureSeries &line = figure.panels[0].series[0], &dots = figure.panels[0].series[1];
  constexpr int kPoints = 1000;  // ten periods; fewer than are brought to their outline before
  for (int i = 0; i <= kPoints; ++i) {
    const double x = static_cast<double>(i) / kPoints;
    line.x.push_back(x);
    line.y.push_back(std::sin(20 * std::numbers::pi * x));
    dots.x.push_back(x);
    dots.y.push_back(0);
  }
  const FigureSeries whole = line;
  Figure broken = figure;
  ThinToPixels(&figure);
  EXPECT_LT(line.x.size(), 250u);
  // Half a pixel across the line is more along y where it is steepest: 100 px of amplitude, 10 periods in 600 px.
  const double bound = 0.5 * std::hypot(1, 20 * std::numbers::pi * 100 / 600) / 100;
  for (std::size_t i = 0; i < whole.x.size(); ++i)
    EXPECT_NEAR(LineAt(line, whole.x[i]), whole.y[i], bound) << whole.x[i];
  EXPECT_EQ(*std::ranges::max_element(line.y), *std::ranges::max_element(whole.y));
  EXPECT_NEAR(static_cast<double>(dots.x.size()), 600 / 2.0, 2);  // one in two pixels

  FigureSeries& with_gap = broken.panels[0].series[0];
  with_gap.y[500] = std::numeric_limits<double>::quiet_NaN();
  ThinToPixels(&broken);
  const auto gap = std::ranges::find_if(with_gap.y, [](double y) { return std::isnan(y); }) - with_gap.y.begin();
  ASSERT_LT(static_cast<std::size_t>(gap) + 1, with_gap.x.size());
  EXPECT_EQ(with_gap.x[static_cast<std::size_t>(gap) - 1], 0.499);
  EXPECT_EQ(with_gap.x[static_cast<std::size_t>(gap) + 1], 0.501);
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
    for (const Row& row : item.rows) EXPECT_THAT(page, HasSubstr(EscapeHtml(row.what)));
  }
  for (const auto& [name, page] : pages) EXPECT_THAT(page, Not(HasSubstr("<script")));
}

}  // namespace
}  // namespace uiclink::reproduce
