// Pages: what is in them, and that nothing of a user's text becomes a part of the page.

#include "reports/html_page.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "reports/chart.h"
#include "reports/escape.h"
#include "reports/inline_svg.h"
#include "reports/thin_figure.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

/// In place of plotly.js.
constexpr std::string_view kScript = "/* draws charts */";

Figure SmallFigure() {
  return {.panels = {{.title = "panel",
                      .x = {.label = "time", .unit = "s"},
                      .y = {.label = "displacement", .unit = "mm"},
                      .series = {{.name = "measured", .x = {0, 1, 2}, .y = {3, 4, 5}}}}}};
}

std::size_t Count(std::string_view what, std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string_view::npos; at += what.size()) ++count;
  return count;
}

TEST(EscapeMarkup, ReplacesWhatHasAMeaning) {
  EXPECT_EQ(EscapeMarkup("a < b & \"c\" > 'd'"), "a &lt; b &amp; &quot;c&quot; &gt; &#39;d&#39;");
  EXPECT_EQ(EscapeMarkup(std::string_view("a\0b\x1b\n\tc", 7)), "a b \n\tc");
  EXPECT_EQ(EscapeMarkup("µm, T₀"), "µm, T₀");
}

TEST(HtmlPage, EscapesTextAndKeepsPicturesApart) {
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

TEST(InlineSvg, SaysOnceWhatGnuplotSaysAtEveryTic) {
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

TEST(InlineSvg, MakesOnePathOfDiscs) {
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

TEST(HtmlPage, HasAContentsOfItsHeadings) {
  HtmlPage page("title");
  page.Heading(2, "one & only", "first");
  page.Heading(3, "part");
  page.Heading(2, "two");
  EXPECT_THAT(page.Format(), Not(HasSubstr("<nav")));  // two are seen at a glance
  page.Heading(2, "three");
  EXPECT_THAT(page.Format(), AllOf(HasSubstr("<li><a href=\"#first\">one &amp; only</a></li>\n"
                                             "<li><a href=\"#section-2\">two</a></li>\n"
                                             "<li><a href=\"#section-3\">three</a></li>\n</ol>"),
                                   HasSubstr("<h2 id=\"first\">one &amp; only</h2>"),
                                   HasSubstr("<h2 id=\"section-2\">two</h2>"), HasSubstr("<h3>part</h3>")));
}

TEST(HtmlPage, ScriptsAreInItOnceAndOnlyForCharts) {
  HtmlPage page("title", kScript);
  page.Paragraph("text");
  EXPECT_THAT(page.Format(), Not(HasSubstr("<script")));
  page.Chart(SmallFigure(), "one", "the first");
  page.Chart(SmallFigure(), "two", "the second");
  const std::string html = page.Format();
  EXPECT_EQ(Count(kScript, html), 1u);
  EXPECT_EQ(Count("<script type=\"application/json\">", html), 2u);
  EXPECT_EQ(Count("<script>", html), 2u);
  EXPECT_EQ(Count("</script>", html), 4u);
  EXPECT_EQ(Count("http", html.substr(0, html.find(kScript))), 0u) << "a page asks nobody for anything";
}

TEST(HtmlPage, TheLicenceStaysWithTheBundle) {
  if (PlotlyBundle().empty()) GTEST_SKIP() << "built without Plotly";
  EXPECT_THAT(std::string(PlotlyLicense()), HasSubstr("Permission is hereby granted"));
  HtmlPage page("title");
  page.Chart(SmallFigure(), "one", "the first");
  const std::string html = page.Format();
  EXPECT_THAT(html, AllOf(HasSubstr("Permission is hereby granted"), HasSubstr("Licensed under the MIT license")));
  EXPECT_EQ(Count(PlotlyBundle(), html), 1u);
  // What would end the script, or make the reader of HTML see another one in it.
  for (const std::string_view end : {"</script", "<!--"}) EXPECT_EQ(Count(end, PlotlyBundle()), 0u) << end;
  for (const std::string_view end : {"</script", "<!--"}) EXPECT_EQ(Count(end, ChartScript()), 0u) << end;
}

TEST(HtmlPage, AChartHasItsDescriptionAndFiles) {
  HtmlPage page("title", kScript);
  page.Chart(SmallFigure(), "one", "k < \"k1\"", {{.text = "CSV", .link = "figures/a&b.csv"}});
  EXPECT_THAT(page.Format(),
              AllOf(HasSubstr("<figure class=\"chart\" id=\"one\">"),
                    HasSubstr("role=\"img\" aria-label=\"k &lt; &quot;k1&quot;\""),
                    HasSubstr("<figcaption>k &lt; &quot;k1&quot; <a href=\"figures/a&amp;b.csv\">CSV</a>")));
}

TEST(HtmlPage, AChartIsAPictureWithoutPlotly) {
  HtmlPage page("title", {});
  page.Chart(SmallFigure(), "one", "the first");
  EXPECT_THAT(page.Format(), AllOf(HasSubstr("built without Plotly"), HasSubstr("<figure id=\"one\">\n<svg "),
                                   HasSubstr("displacement [mm]"), Not(HasSubstr("<script"))));
}

TEST(HtmlPage, SaysInItsPlaceWhyAPictureIsMissing) {
  const TemporaryFolder folder;
  const std::string path = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  HtmlPage page("title", {});
  page.Chart(SmallFigure(), "one", "the first");
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(page.Format(),
              HasSubstr("<figure id=\"one\">\n<p class=\"warning\">the figure cannot be drawn: gnuplot is "
                        "not installed (Debian package gnuplot-nox)</p>\n<figcaption>the first"));
}

TEST(HtmlPage, RefusesIdsThatAreNone) {
  HtmlPage page("title", kScript);
  for (const char* id : {"", "1a", "a b", "a\"b", "ä"})
    EXPECT_THROW(page.Chart(SmallFigure(), id, "d"), std::invalid_argument) << id;
  page.Chart(SmallFigure(), "record-1_a", "d");
  EXPECT_THROW(page.Chart(SmallFigure(), "record-1_a", "d"), std::invalid_argument);
  EXPECT_THROW(page.Chart({}, "none", "d"), std::invalid_argument);
}

TEST(HtmlPage, TheSameCallsGiveTheSameBytes) {
  const auto make = [] {
    HtmlPage page("title");
    page.Heading(2, "heading");
    page.Chart(SmallFigure(), "one", "the first");
    return page.Format();
  };
  EXPECT_EQ(make(), make());
}

TEST(HtmlPage, TakesTablesOfATerminal) {
  TextTable table;
  table.AddColumn("motion", TextTable::Align::kLeft);
  table.AddColumn("error of\nlow");
  table.AddColumn("\nhigh");
  table.AddRow({"  front", "1", "<2>"});
  table.AddRule();
  table.AddRow({"rear", "3", "4"});
  HtmlPage page("t");
  page.Table("c", table);
  EXPECT_THAT(
      page.Format(),
      AllOf(HasSubstr("<tr><th scope=\"col\">motion</th><th scope=\"colgroup\" colspan=\"2\">error of</th></tr>\n"
                      "<tr><th scope=\"col\"></th><th scope=\"col\">low</th><th scope=\"col\">high</th></tr>"),
            HasSubstr("<tr><th scope=\"row\">front</th><td class=\"number\">1</td><td class=\"number\">&lt;2&gt;</td>"
                      "</tr>\n<tr><th scope=\"row\">rear</th>")));
}

TEST(HtmlPage, RunsAScriptOnceHoweverOftenItIsInserted) {
  HtmlPage page("t", "");
  page.Insert("<div id=\"one\"></div>", "/* moves */");
  page.Insert("<div id=\"two\"></div>", "/* moves */");
  const std::string html = page.Format();
  EXPECT_EQ(Count("/* moves */", html), 1u);
  EXPECT_LT(html.find("id=\"two\""), html.find("<script>/* moves */</script>"));
}

TEST(HtmlPage, AStoredChartIsTheOneOfItsFigure) {
  HtmlPage drawn("t", kScript), stored("t", kScript), without("t", ""), empty("t", kScript);
  Figure thin = SmallFigure();
  ThinToPixels(&thin, 4);
  drawn.Chart(SmallFigure(), "one", "d");
  stored.StoredChart(FormatChart(thin), "<svg/>", "one", "d");
  EXPECT_EQ(stored.Format(), drawn.Format());
  without.StoredChart(FormatChart(SmallFigure()), "<svg/>", "one", "d");
  empty.StoredChart("", "<svg/>", "one", "d");
  for (const HtmlPage* page : {&without, &empty})
    EXPECT_THAT(page->Format(), AllOf(HasSubstr("<svg"), Not(HasSubstr("<script"))));
}

TEST(QuoteCommand, KeepsWordsForAShell) {
  const char* const words[] = {"wagon", "--out", "a b", "it's", "", "x=1,y=2"};
  EXPECT_EQ(QuoteCommand(6, words), R"(wagon --out 'a b' 'it'\''s' '' x=1,y=2)");
}

}  // namespace
}  // namespace uiclink
