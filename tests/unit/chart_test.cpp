// What page/chart.js is told of a figure: every feature, text that stays text, data at drawing precision.

#include "reports/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "reports/chart_data.h"

namespace uiclink {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

json Chart(const Figure& figure) { return json::parse(FormatChart(figure)); }
json ChartOf(const FigurePanel& panel) { return Chart({.panels = {panel}}); }

/// The numbers again, as page/chart.js unpacks them.
std::vector<double> Unpack(const PackedValues& packed, bool log) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned> bytes;
  unsigned bits = 0, count = 0;
  for (const char c : packed.numbers) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(letters.find(c));
    if ((count += 6) < 8) continue;
    count -= 8;
    bytes.push_back(bits >> count & 255);
  }
  std::vector<double> values;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) {
    const unsigned n = bytes[i] + 256 * bytes[i + 1];
    const double value = packed.from + (packed.to - packed.from) * n / 65534;
    values.push_back(n == 65535 ? kNaN : log ? std::pow(10, value) : value);
  }
  return values;
}

std::vector<double> Unpack(const json& values) {
  return Unpack({values["from"], values["to"], values["u16"]}, values["log"]);
}

TEST(EncodeBase64, IsThatOfRfc4648) {
  EXPECT_EQ(EncodeBase64(""), "");
  EXPECT_EQ(EncodeBase64("f"), "Zg==");
  EXPECT_EQ(EncodeBase64("fo"), "Zm8=");
  EXPECT_EQ(EncodeBase64("foo"), "Zm9v");
  EXPECT_EQ(EncodeBase64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(EncodeBase64("\xff\xfe\xfd"), "//79");
}

TEST(PackValues, KeepsExtremesExactlyAndTheRestToHalfAStep) {
  const std::vector<double> values{-3.25, 0, 0.1, 1e-3, kNaN, 7.5, kInfinity, -kInfinity};
  const std::vector<double> back = Unpack(PackValues(values, false), false);
  ASSERT_EQ(back.size(), values.size());
  EXPECT_EQ(back[0], -3.25);
  EXPECT_EQ(back[5], 7.5);
  const double half_a_step = 0.5 * 10.75 / 65534 * (1 + 1e-9);  // and rounding
  for (const std::size_t i : {1, 2, 3}) EXPECT_NEAR(back[i], values[i], half_a_step);
  for (const std::size_t i : {4, 6, 7}) EXPECT_TRUE(std::isnan(back[i]));
}

TEST(PackValues, OnALogarithmicAxisErrorsAreRelative) {
  const std::vector<double> values{1e-6, 3e-6, 0, 2, -1, 1e4};
  const std::vector<double> back = Unpack(PackValues(values, true), true);
  const double half_a_step = std::pow(10, 0.5 * 10 / 65534) - 1;
  for (const std::size_t i : {0, 1, 3, 5}) EXPECT_NEAR(back[i] / values[i], 1, 1.001 * half_a_step);
  for (const std::size_t i : {2, 4}) EXPECT_TRUE(std::isnan(back[i]));
}

TEST(PackValues, AConstantAndNothingAtAll) {
  EXPECT_THAT(Unpack(PackValues({5, 5, 5}, false), false), testing::ElementsAre(5, 5, 5));
  EXPECT_TRUE(std::isnan(Unpack(PackValues({kNaN}, false), false).at(0)));
  EXPECT_EQ(PackValues({}, false).numbers, "");
  const double most = std::numeric_limits<double>::max();
  EXPECT_EQ(PackValues({-most, 0, most}, false).numbers, EncodeBase64(std::string("\0\0\xff\x7f\xfe\xff", 6)));
}

TEST(Chart, ShortSeriesAreNumbersAndLongOnesPacked) {
  const json few = ChartOf({.series = {{.x = {0, 0.1, 1.0 / 3}, .y = {1, kNaN, kInfinity}}}});
  EXPECT_EQ(few["data"][0]["x"], json({0, 0.1, 0.333333}));
  EXPECT_EQ(few["data"][0]["y"], json({1, nullptr, nullptr}));
  FigureSeries many;
  for (int i = 0; i < 1000; ++i) {
    many.x.push_back(0.005 * i);
    many.y.push_back(std::sin(0.1 * i));
  }
  const json data = ChartOf({.series = {many}})["data"][0];
  const std::vector<double> x = Unpack(data["x"]), y = Unpack(data["y"]);
  ASSERT_EQ(x.size(), 1000u);
  for (std::size_t i = 0; i < x.size(); ++i) {
    EXPECT_NEAR(x[i], many.x[i], 4.995 / 65534);
    EXPECT_NEAR(y[i], many.y[i], 2.0 / 65534);
  }
}

TEST(Chart, NumbersFarFromZeroKeepTheirDifferences) {
  const json data = ChartOf({.series = {{.x = {1000000.25, 1000000.5}, .y = {1, 2}}}})["data"][0];
  EXPECT_EQ(data["x"], json({1000000.25, 1000000.5}));
}

TEST(Chart, LinesMarksAndColours) {
  FigurePanel panel;
  panel.series = {{.name = "a", .x = {1}, .y = {1}, .width = 2.5},
                  {.name = "b", .x = {1}, .y = {1}, .line = FigureLine::kDashed, .mark = FigureMark::kTriangle},
                  {.name = "c",
                   .x = {1},
                   .y = {1},
                   .line = FigureLine::kNone,
                   .mark = FigureMark::kCircle,
                   .colour = FigureColour::kBlack},
                  {.x = {1}, .y = {1}, .line = FigureLine::kDotted}};
  const json data = ChartOf(panel)["data"];
  EXPECT_EQ(data[0]["mode"], "lines");
  EXPECT_EQ(data[0]["line"], json({{"color", "#0072b2"}, {"width", 2.5}, {"dash", "solid"}}));
  EXPECT_EQ(data[1]["mode"], "lines+markers");
  EXPECT_EQ(data[1]["line"]["dash"], "7px,4px");
  EXPECT_EQ(data[1]["marker"]["symbol"], "triangle-up-open");
  EXPECT_EQ(data[1]["marker"]["color"], "#d55e00");
  EXPECT_EQ(data[2]["mode"], "markers");
  EXPECT_EQ(data[2]["marker"]["symbol"], "circle-open");
  EXPECT_EQ(data[2]["marker"]["color"], "#000000");
  EXPECT_FALSE(data[2].contains("line"));
  EXPECT_EQ(data[3]["line"]["color"], "#009e73");
  EXPECT_EQ(data[3]["line"]["dash"], "1.5px,3px");
  EXPECT_EQ(data[3]["showlegend"], false);
}

TEST(Chart, TheEighthSeriesIsDashed) {
  FigurePanel panel;
  for (int i = 0; i < 8; ++i) panel.series.push_back({.x = {1}, .y = {1}});
  const json data = ChartOf(panel)["data"];
  EXPECT_EQ(data[6]["line"]["dash"], "solid");
  EXPECT_EQ(data[7]["line"]["dash"], "7px,4px");
  EXPECT_EQ(data[7]["line"]["color"], data[0]["line"]["color"]);
}

TEST(Chart, AxesHaveUnitsScalesAndRanges) {
  FigurePanel panel{.x = {.label = "frequency", .unit = "Hz", .log = true, .low = 0.1, .high = 100.0},
                    .y = {.label = "places", .reversed = true, .numbers = false, .low = 0.0, .high = 4.0},
                    .series = {{.x = {0.1, 100}, .y = {1, 2}}}};
  const json chart = ChartOf(panel);
  const json x = chart["layout"]["xaxis"], y = chart["layout"]["yaxis"];
  EXPECT_EQ(x["title"]["text"], "frequency [Hz]");
  EXPECT_EQ(x["type"], "log");
  EXPECT_NEAR(x["range"][0].get<double>(), -1, 1e-12);
  EXPECT_NEAR(x["range"][1].get<double>(), 2, 1e-12);
  EXPECT_EQ(y["type"], "linear");
  EXPECT_EQ(y["range"], json({4, 0}));
  EXPECT_EQ(y["showticklabels"], false);
  EXPECT_FALSE(x.contains("showticklabels"));
  EXPECT_EQ(chart["data"][0]["hovertemplate"], "%{x:.5~g} Hz, %{y:.5~g}<extra></extra>");
}

TEST(Chart, EqualScales) {
  FigurePanel panel{.series = {{.x = {0, 1}, .y = {0, 5}}}, .equal_scales = true};
  const json layout = ChartOf(panel)["layout"];
  EXPECT_EQ(layout["yaxis"]["scaleanchor"], "x");
  EXPECT_NEAR(layout["xaxis"]["range"][1].get<double>(), 1, 0.1);  // widened by Plotly, not by us
}

TEST(Chart, GuidesAreLinesWithTexts) {
  FigurePanel panel{.x = {.label = "x", .log = true},
                    .series = {{.x = {1, 1000}, .y = {0, 1}}},
                    .horizontal_guides = {{5, "limit"}, {kNaN, "none"}},
                    .vertical_guides = {{100, "here"}, {-1, "not on this axis"}, {10, ""}}};
  const json chart = ChartOf(panel);
  const json shapes = chart["layout"]["shapes"], texts = chart["layout"]["annotations"];
  ASSERT_EQ(shapes.size(), 3u);
  EXPECT_EQ(shapes[0]["yref"], "y");
  EXPECT_EQ(shapes[0]["y0"], 5);
  EXPECT_EQ(shapes[0]["xref"], "x domain");
  EXPECT_EQ(shapes[0]["layer"], "above") << "a line of the grid would hide it, and a dense record";
  EXPECT_EQ(shapes[1]["x1"], 100);
  ASSERT_EQ(texts.size(), 2u);
  EXPECT_EQ(texts[0]["text"], "limit");
  EXPECT_EQ(texts[1]["text"], "here");
  EXPECT_NEAR(texts[1]["x"].get<double>(), 2, 1e-12) << "texts count in decades, lines do not";
  EXPECT_EQ(chart["grid"]["panels"][0]["guides"], json({1}));
  EXPECT_GE(chart["layout"]["yaxis"]["range"][1].get<double>(), 5) << "the axis reaches to a guide";
}

TEST(Chart, NotesAreInDataCoordinates) {
  const json texts =
      ChartOf({.y = {.label = "y", .log = true}, .notes = {{3, 0.1, "n"}, {kNaN, 1, ""}}})["layout"]["annotations"];
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_EQ(texts[0]["x"], 3);
  EXPECT_NEAR(texts[0]["y"].get<double>(), -1, 1e-12);
  EXPECT_EQ(texts[0]["text"], "n");
}

TEST(Chart, EveryPanelHasAxesATitleAndALegend) {
  const FigurePanel panel{
      .title = "t",
      .series = {{.name = "a", .x = {1}, .y = {1}}, {.x = {1}, .y = {1}}, {.name = "b", .x = {1}, .y = {1}}}};
  const json chart = Chart({.title = "whole", .panels = {panel, panel, panel}, .columns = 2, .panel_height = 300});
  EXPECT_EQ(chart["grid"]["columns"], 2);
  EXPECT_EQ(chart["grid"]["panel_height"], 300);
  EXPECT_EQ(chart["grid"]["title"], "whole");
  EXPECT_EQ(chart["grid"]["panels"][2],
            json({{"x", "xaxis3"}, {"y", "yaxis3"}, {"title", 2}, {"legend", {6, 8}}, {"guides", json::array()}}));
  EXPECT_EQ(chart["data"][8]["xaxis"], "x3");
  EXPECT_EQ(chart["data"][8]["legend"], "legend6");
  EXPECT_EQ(chart["layout"]["yaxis2"]["anchor"], "x2");
}

TEST(Chart, AxesOfTimeZoomTogether) {
  const auto panel = [](FigureAxis x, double end) {
    return FigurePanel{.x = std::move(x), .series = {{.x = {0, end}, .y = {0, 1}}}};
  };
  const FigureAxis time{.label = "time", .unit = "s"};
  FigureAxis zoomed = time, other = time;
  zoomed.high = 1;
  other.unit = "ms";
  const json chart = Chart({.panels = {panel(time, 10), panel(zoomed, 10), panel(time, 15), panel(other, 3)}});
  const json layout = chart["layout"];
  EXPECT_FALSE(layout["xaxis"].contains("matches"));
  EXPECT_FALSE(layout["xaxis2"].contains("matches")) << "other bounds";
  EXPECT_EQ(layout["xaxis3"]["matches"], "x");
  EXPECT_FALSE(layout["xaxis4"].contains("matches")) << "another unit";
  EXPECT_EQ(layout["xaxis"]["range"], json({0, 15})) << "all that one of them shows";
  EXPECT_EQ(layout["xaxis3"]["range"], json({0, 15}));
  EXPECT_TRUE(chart["links"].empty());
}

TEST(Chart, AWordLinksAxesOfOnePage) {
  FigureAxis a{.label = "time", .unit = "s", .link = "t"}, b{.label = "time after release", .unit = "s", .link = "t"};
  const FigureSeries series{.x = {0, 1}, .y = {0, 1}};
  const json chart = Chart({.panels = {{.x = a, .series = {series}},
                                       {.x = {.label = "time", .unit = "s"}, .series = {series}},
                                       {.x = b, .series = {series}}}});
  EXPECT_EQ(chart["links"], json({{"t", {"xaxis", "xaxis3"}}}));
  EXPECT_EQ(chart["layout"]["xaxis3"]["matches"], "x");
  EXPECT_FALSE(chart["layout"]["xaxis2"].contains("matches"));
}

TEST(Chart, TextIsTextAndEndsNoScript) {
  const std::string evil = "</script><script>alert(1)</script><!-- \"quoted\" 'single' & %{x} \\ \n";
  const std::string text = FormatChart({.title = evil,
                                        .panels = {{.title = evil,
                                                    .x = {.label = evil, .unit = evil},
                                                    .series = {{.name = evil, .x = {1}, .y = {1}}},
                                                    .horizontal_guides = {{1, evil}},
                                                    .notes = {{1, 1, evil}}}}});
  EXPECT_THAT(text, Not(HasSubstr("<")));
  const json chart = json::parse(text);
  const std::string escaped =
      "&lt;/script&gt;&lt;script&gt;alert(1)&lt;/script&gt;&lt;!-- \"quoted\" 'single' &amp; &#37;{x} \\  ";
  EXPECT_EQ(chart["data"][0]["name"], escaped);
  EXPECT_EQ(chart["grid"]["title"], escaped);
  for (const json& annotation : chart["layout"]["annotations"]) EXPECT_EQ(annotation["text"], escaped);
  EXPECT_EQ(chart["layout"]["xaxis"]["title"]["text"], escaped + " [" + escaped + "]");
  EXPECT_THAT(chart["data"][0]["hovertemplate"].get<std::string>(), HasSubstr(" &lt;/script&gt;"));
}

TEST(Chart, BytesThatAreNoUtf8AreReplaced) {
  const json chart = ChartOf({.title = "a\xff"
                                       "b"});
  EXPECT_EQ(chart["layout"]["annotations"][0]["text"],
            "a\xef\xbf\xbd"
            "b");
}

TEST(Chart, NamesWhatMakesNoSense) {
  EXPECT_THROW(FormatChart({}), std::invalid_argument);
  EXPECT_THROW(FormatChart({.panels = {{.series = {{.x = {1, 2}, .y = {1}}}}}}), std::invalid_argument);
}

TEST(Chart, APanelWithoutPointsHasAxes) {
  const json layout = ChartOf({.series = {{.name = "none", .x = {kNaN}, .y = {kNaN}}}})["layout"];
  EXPECT_LT(layout["xaxis"]["range"][0].get<double>(), layout["xaxis"]["range"][1].get<double>());
}

}  // namespace
}  // namespace uiclink
