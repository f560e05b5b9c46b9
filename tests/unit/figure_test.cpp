// Figures: every series, label and text is in the drawing, where it belongs; what thinning keeps; what is said when
// nothing can be drawn.

#include "reports/figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "reports/figure_layout.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::Not;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Why `text` is no well-formed XML, as far as tags and entities go; empty if it is.
class XmlCheck {
 public:
  explicit XmlCheck(std::string_view text) : rest_(text) {}

  std::string FindFault() {
    while (!rest_.empty() && fault_.empty()) {
      const std::size_t tag = std::min(rest_.find('<'), rest_.size());
      CheckText(rest_.substr(0, tag));
      rest_.remove_prefix(tag);
      if (rest_.empty()) break;
      if (!Skip("<!--", "-->") && !Skip("<![CDATA[", "]]>") && !Skip("<?", "?>")) TakeTag();
    }
    if (fault_.empty() && !open_.empty()) fault_ = "<" + open_.back() + "> is not closed";
    return fault_;
  }

 private:
  void CheckText(std::string_view text) {
    for (std::size_t at = 0; (at = text.find('&', at)) != std::string_view::npos; ++at) {
      const std::string name(text.substr(at + 1, std::min(text.find(';', at), text.size()) - at - 1));
      static const std::set<std::string> known{"amp", "lt", "gt", "quot", "apos"};
      if (!known.contains(name) && !name.starts_with('#')) fault_ = "a bare '&' before " + name.substr(0, 20);
    }
  }

  bool Skip(std::string_view begin, std::string_view end) {
    if (!rest_.starts_with(begin)) return false;
    const std::size_t last = rest_.find(end, begin.size());
    if (last == std::string_view::npos) fault_ = std::string(begin) + " has no end";
    rest_.remove_prefix(std::min(last, rest_.size() - end.size()) + end.size());
    return true;
  }

  /// Attributes must be in quotes; inside of them '>' means nothing.
  void TakeTag() {
    const bool closing = rest_.starts_with("</");
    std::size_t at = closing ? 2 : 1;
    const auto is_name = [](char c) {
      return std::isalnum(static_cast<unsigned char>(c)) || c == ':' || c == '-' || c == '_';
    };
    std::string name;
    while (at < rest_.size() && is_name(rest_[at])) name += rest_[at++];
    char quote = 0, before = 0;
    for (; at < rest_.size() && (quote != 0 || rest_[at] != '>'); ++at) {
      const char c = rest_[at];
      if (c == '<') break;
      if (quote == 0 && (c == '"' || c == '\'')) {
        if (before != '=') fault_ = "a quotation mark without '=' in " + name;
        quote = c;
      } else if (c == quote) {
        quote = 0;
      }
      if (c != ' ') before = c;
    }
    if (name.empty() || at >= rest_.size() || rest_[at] != '>') {
      fault_ = "a '<' that begins no tag: " + std::string(rest_.substr(0, 40));
      return;
    }
    if (closing && (open_.empty() || open_.back() != name))
      fault_ = "</" + name + "> closes " + (open_.empty() ? "nothing" : open_.back());
    if (closing && fault_.empty()) open_.pop_back();
    if (!closing && before != '/') open_.push_back(name);
    rest_.remove_prefix(at + 1);
  }

  std::string_view rest_;
  std::vector<std::string> open_;
  std::string fault_;
};

std::string FindXmlFault(const std::string& text) { return XmlCheck(text).FindFault(); }

struct Point {
  double x, y;
};
using Polyline = std::vector<Point>;

/// The lines that gnuplot drew as a plot: "1a" is the first one of the first panel. The first line is the sample in the
/// legend, if the plot has a title.
std::vector<Polyline> PlotLines(const std::string& svg, const std::string& plot) {
  std::vector<Polyline> lines;
  const std::size_t begin = svg.find("id=\"gnuplot_plot_" + plot + "\"");
  if (begin == std::string::npos) return lines;
  const std::string part = svg.substr(begin, svg.find("id=\"gnuplot_plot_", begin + 5) - begin);
  for (std::size_t at = 0; (at = part.find("d='", at)) != std::string::npos;) {
    at += 3;
    const std::string d = part.substr(at, part.find('\'', at) - at);
    const char* cursor = d.c_str();
    while (*cursor != 0) {
      if (*cursor == 'M') lines.emplace_back();
      char* end = nullptr;
      const double x = std::strtod(cursor, &end);
      if (end == cursor) {
        ++cursor;
        continue;
      }
      cursor = end + 1;  // the comma
      lines.back().push_back({x, std::strtod(cursor, &end)});
      cursor = end;
    }
  }
  return lines;
}

FigureSeries Line(const std::string& name, std::vector<double> x, std::vector<double> y) {
  return {.name = name, .x = std::move(x), .y = std::move(y)};
}

/// Two panels with everything that a figure can have.
Figure RichFigure() {
  Figure figure{.title = "hunting at 24 m/s", .columns = 2};
  FigurePanel histories{.title = "lateral", .x = {"time", "s"}, .y = {"displacement", "mm"}};
  histories.series = {Line("front wheelset", {0, 1, 2, 3}, {0, 3, -3, 1}),
                      Line("rear wheelset", {0, 1, 2, 3}, {1, -2, 2, 0})};
  histories.series[1].line = FigureLine::kDashed;
  histories.horizontal_guides = {{20, "clearance"}, {-20, ""}};
  FigurePanel work{.title = "work",
                   .x = {.label = "tolerance", .unit = "", .log = true},
                   .y = {.label = "time", .unit = "s", .log = true}};
  work.series = {Line("explicit", {1e-8, 1e-6, 1e-4}, {3, 1, 0.3})};
  work.series[0].mark = FigureMark::kSquare;
  work.vertical_guides = {{1e-6, "default"}};
  work.notes = {{1e-7, 1, "as fast as it gets"}};
  figure.panels = {histories, work};
  return figure;
}

TEST(Figure, HasEverySeriesLabelAndText) {
  const std::string svg = RenderSvg(RichFigure());
  EXPECT_EQ(FindXmlFault(svg), "");
  for (const char* text :
       {"hunting at 24 m/s", "lateral", "work", "time [s]", "displacement [mm]", "tolerance", "front wheelset",
        "rear wheelset", "explicit", "clearance", "default", "as fast as it gets"}) {
    EXPECT_THAT(svg, HasSubstr(">" + std::string(text) + "<")) << text;
  }
  EXPECT_THAT(svg, HasSubstr("<title>hunting at 24 m/s</title>"));
  EXPECT_THAT(svg, Not(HasSubstr("Gnuplot</title>")));
}

TEST(Figure, WideNumbersLeaveTheTitleOfTheAxisInThePicture) {
  // By `set ylabel` gnuplot puts the title left of the numbers as it expects them, and omits one beyond the edge.
  const Figure figure{.panels = {{.x = {.label = "time"},
                                  .y = {.label = "slider force over load"},
                                  .series = {{.x = {0, 1}, .y = {-0.014, 0.014}}}}}};
  EXPECT_THAT(RenderSvg(figure), HasSubstr(">slider force over load<"));
}

TEST(Figure, TheCheckOfWellFormedXmlFindsFaults) {
  EXPECT_EQ(FindXmlFault("<a b='1'><c/>x &amp; y<!-- <d> --></a>"), "");
  EXPECT_NE(FindXmlFault("<a><b></a></b>"), "");
  EXPECT_NE(FindXmlFault("<a>x & y</a>"), "");
  EXPECT_NE(FindXmlFault("<a>1 < 2</a>"), "");
  EXPECT_NE(FindXmlFault("<a>"), "");
}

TEST(Figure, DrawsPointsWhereTheyAre) {
  Figure figure{.panels = {{.x = {.label = "x", .low = 0, .high = 4}, .y = {.label = "y", .low = -1, .high = 3}}}};
  figure.panels[0].series = {Line("a", {0, 1, 4}, {-1, 3, 1})};
  const PanelBox box = CalcLayout(figure).panels[0].box;
  const std::vector<Polyline> lines = PlotLines(RenderSvg(figure), "1a");
  ASSERT_EQ(lines.size(), 2u) << "the legend's sample and the line";
  const Polyline& drawn = lines[1];
  ASSERT_EQ(drawn.size(), 3u);
  const double per_x = (box.right - box.left) / 4, per_y = (box.bottom - box.top) / 4;
  const std::vector<Point> expected{
      {box.left, box.bottom}, {box.left + per_x, box.top}, {box.right, box.top + 2 * per_y}};
  for (std::size_t i = 0; i < 3; ++i) {
    // gnuplot's terminal has 100 units a pixel, and places the axes on whole ones.
    EXPECT_NEAR(drawn[i].x, expected[i].x, 0.6) << i;
    EXPECT_NEAR(drawn[i].y, expected[i].y, 0.6) << i;
  }
}

TEST(Figure, TextIsNeitherMarkupNorACommand) {
  Figure figure = RichFigure();
  const std::string nasty = "it's 5 < 6 & \"`date`\" $HOME {/Bold x}^2_3 %d \\n @y";
  figure.title = nasty;
  figure.panels[0].title = nasty;
  figure.panels[0].x.label = nasty;
  figure.panels[0].series[0].name = nasty + "\nsecond line";
  figure.panels[0].horizontal_guides[0].text = nasty;
  figure.panels[1].notes[0].text = nasty;
  const std::string svg = RenderSvg(figure);
  EXPECT_EQ(FindXmlFault(svg), "");
  const std::string expected = "it's 5 &lt; 6 &amp; &quot;`date`&quot; $HOME {/Bold x}^2_3 %d \\n @y";
  std::size_t count = 0;
  std::string unified = std::regex_replace(svg, std::regex("&#39;|&apos;"), "'");
  unified = std::regex_replace(unified, std::regex("&quot;"), "\"");
  const std::string wanted = std::regex_replace(expected, std::regex("&quot;"), "\"");
  for (std::size_t at = 0; (at = unified.find(wanted, at)) != std::string::npos; ++at) ++count;
  EXPECT_GE(count, 6u) << svg;
}

TEST(Figure, ALongSeriesKeepsItsSpike) {
  constexpr std::size_t kPoints = 200000, kSpike = 123457;
  Figure figure{.panels = {{.x = {"t", "s"}, .y = {.label = "y", .low = 0, .high = 10}}}};
  FigureSeries noise{.name = "noise"};
  for (std::size_t i = 0; i < kPoints; ++i) {
    noise.x.push_back(static_cast<double>(i));
    noise.y.push_back(i == kSpike ? 10 : 1 + std::sin(0.1 * static_cast<double>(i)));
  }
  figure.panels[0].series = {noise};
  const std::string svg = RenderSvg(figure);
  EXPECT_LT(svg.size(), 600000u) << "thinned";
  const PanelBox box = CalcLayout(figure).panels[0].box;
  const std::vector<Polyline> lines = PlotLines(svg, "1a");
  ASSERT_EQ(lines.size(), 2u);
  const Polyline& drawn = lines[1];
  const Point highest = *std::ranges::min_element(drawn, {}, &Point::y);
  EXPECT_NEAR(highest.y, box.top, 0.6);
  EXPECT_NEAR(highest.x, box.left + (box.right - box.left) * static_cast<double>(kSpike) / (kPoints - 1), 0.6);
}

TEST(Figure, TheSameFigureGivesTheSameBytes) {
  EXPECT_EQ(RenderSvg(RichFigure()), RenderSvg(RichFigure()));
  const std::string png = RenderPng(RichFigure());
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  EXPECT_EQ(png, RenderPng(RichFigure()));
}

TEST(Figure, PanelsWithoutPointsAreDrawn) {
  Figure figure{.panels = {{.title = "nothing", .x = {"x", "m"}, .y = {"y", "m"}}}};
  EXPECT_THAT(RenderSvg(figure), HasSubstr(">x [m]<"));
  figure.panels[0].series = {Line("gap", {kNaN, 1}, {1, kNaN}), Line("none", {}, {})};
  EXPECT_THAT(RenderSvg(figure), HasSubstr(">gap<"));
  figure.panels[0].y.log = true;
  figure.panels[0].series = {Line("negative", {1, 2}, {-1, 0})};
  EXPECT_THAT(RenderSvg(figure), HasSubstr(">negative<"));
  figure.panels[0].y.log = false;
  figure.panels[0].series = {Line("one point", {1}, {5})};
  EXPECT_THAT(RenderSvg(figure), HasSubstr(">one point<"));
}

TEST(Figure, AGapBreaksTheLine) {
  Figure figure{.panels = {{.x = {.label = "x", .low = 0, .high = 4}, .y = {.label = "y", .low = 0, .high = 1}}}};
  figure.panels[0].series = {Line("a", {0, 1, 2, 3, 4}, {0, 1, kNaN, 1, 0})};
  const std::vector<Polyline> lines = PlotLines(RenderSvg(figure), "1a");
  ASSERT_EQ(lines.size(), 3u) << "the legend's sample and two halves";
  EXPECT_EQ(lines[1].size(), 2u);
  EXPECT_EQ(lines[2].size(), 2u);
}

TEST(FigureLayout, EqualScalesMakeAPixelTheSameLengthBothWays) {
  Figure figure{.panels = {{.equal_scales = true}, {.equal_scales = true}}, .columns = 2};
  figure.panels[0].series = {Line("wide", {0, 100}, {0, 1})};
  figure.panels[1].series = {Line("tall", {0, 1}, {-5, 100})};
  for (const PanelLayout& panel : CalcLayout(figure).panels) {
    const double per_x = (panel.x.high - panel.x.low) / (panel.box.right - panel.box.left);
    const double per_y = (panel.y.high - panel.y.low) / (panel.box.bottom - panel.box.top);
    EXPECT_NEAR(per_x / per_y, 1, 1e-12);  // rounding
  }
}

TEST(FigureLayout, AxesReachToGuidesAndKeepGivenBounds) {
  Figure figure{.panels = {{.x = {.label = "x"}, .y = {.label = "y", .low = -1}}}};
  figure.panels[0].series = {Line("a", {0, 1}, {0, 1})};
  figure.panels[0].horizontal_guides = {{20, ""}};
  const AxisRange y = CalcLayout(figure).panels[0].y;
  EXPECT_EQ(y.low, -1);
  EXPECT_GT(y.high, 20);
}

/// Sets an environment variable while it lives.
class ScopedPath {
 public:
  explicit ScopedPath(const std::string& path) : before_(std::getenv("PATH")) { setenv("PATH", path.c_str(), 1); }
  ~ScopedPath() { setenv("PATH", before_.c_str(), 1); }
  ScopedPath(const ScopedPath&) = delete;
  ScopedPath& operator=(const ScopedPath&) = delete;

 private:
  std::string before_;
};

std::string FaultOfRendering(const Figure& figure) {
  try {
    RenderSvg(figure);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(Figure, SaysWhichPackageIsMissing) {
  const TemporaryFolder folder;
  const ScopedPath path(folder.path());
  EXPECT_EQ(FaultOfRendering(RichFigure()),
            "the figure cannot be drawn: gnuplot is not installed (Debian package gnuplot-nox)");
}

TEST(Figure, RepeatsWhatGnuplotSays) {
  const TemporaryFolder folder;
  folder.Write("gnuplot", "#!/bin/sh\necho 'line 7: no such terminal' >&2\nexit 1\n");
  std::filesystem::permissions(folder.path() / "gnuplot", std::filesystem::perms::owner_all);
  const ScopedPath path(folder.path());
  EXPECT_EQ(FaultOfRendering(RichFigure()), "the figure cannot be drawn: gnuplot says:\nline 7: no such terminal\n");
}

TEST(Figure, NamesWhatMakesNoSense) {
  EXPECT_THAT(FaultOfRendering({.title = "bare"}), HasSubstr("\"bare\" has no panel"));
  Figure figure = RichFigure();
  figure.panels[0].series[1].y.pop_back();
  EXPECT_THAT(FaultOfRendering(figure), HasSubstr("series \"rear wheelset\": 4 values of x, 3 of y"));
  figure = RichFigure();
  figure.panels[1].x.low = 0;
  EXPECT_THAT(FaultOfRendering(figure), HasSubstr("a bound of a logarithmic axis must be > 0"));
  figure = RichFigure();
  figure.panels[1].equal_scales = true;
  EXPECT_THAT(FaultOfRendering(figure), HasSubstr("equal scales need linear axes"));
  figure = RichFigure();
  figure.panels[0].y.low = 2;
  figure.panels[0].y.high = 2;
  EXPECT_THAT(FaultOfRendering(figure), HasSubstr("must be below high"));
}

TEST(ThinForDrawing, KeepsAllOfAShortSeries) {
  EXPECT_THAT(ThinForDrawing({0, 1, 2, 3}, {5, 5, 5, 5}, 4), testing::ElementsAre(0, 1, 2, 3));
  EXPECT_TRUE(ThinForDrawing({}, {}).empty());
}

TEST(ThinForDrawing, KeepsExtremesOfEveryBlockOfACurveThatTurnsBack) {
  // A spiral: neither x nor y is monotone.
  std::vector<double> x, y;
  for (int i = 0; i < 100000; ++i) {
    const double t = 0.01 * i;
    x.push_back(t * std::cos(t));
    y.push_back(t * std::sin(t));
  }
  const std::vector<std::size_t> kept = ThinForDrawing(x, y, 6000);
  EXPECT_LE(kept.size(), 6000u);
  EXPECT_TRUE(std::ranges::is_sorted(kept));
  EXPECT_EQ(std::ranges::adjacent_find(kept), kept.end()) << "no index twice";
  for (const std::vector<double>* values : {&x, &y}) {
    const auto [low, high] = std::ranges::minmax_element(*values);
    for (const auto& extreme : {low, high}) {
      EXPECT_TRUE(std::ranges::binary_search(kept, static_cast<std::size_t>(extreme - values->begin())));
    }
  }
  EXPECT_EQ(kept.front(), 0u);
  EXPECT_EQ(kept.back(), x.size() - 1);
}

TEST(ThinForDrawing, KeepsOneIndexOfAGap) {
  EXPECT_THAT(ThinForDrawing({0, 1, 2, 3, 4}, {0, kNaN, kNaN, 3, 4}, 100), testing::ElementsAre(0, 1, 3, 4));
}

TEST(FigureData, HasEveryPointInFull) {
  Figure figure = RichFigure();
  figure.panels[0].series[0].y[1] = 0.1 + 0.2;  // needs 17 digits
  figure.panels[0].title = "lateral, \"both\"";
  const std::string csv = FormatFigureData(figure);
  EXPECT_THAT(csv, testing::StartsWith("panel,series,x,y,x_axis,y_axis\n"));
  EXPECT_THAT(csv,
              HasSubstr("\"lateral, \"\"both\"\"\",front wheelset,1,0.30000000000000004,time [s],displacement [mm]\n"));
  EXPECT_THAT(csv, HasSubstr("work,explicit,1e-08,3,tolerance,time [s]\n"));
  EXPECT_EQ(std::ranges::count(csv, '\n'), 1 + 4 + 4 + 3);
}

}  // namespace
}  // namespace uiclink
