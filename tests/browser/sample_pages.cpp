// Writes the pages that the browser tests open, into the folder given: every feature of a figure (features.html), forty
// figures of long records (forty.html), text and tables only (plain.html), and a chart whose data are not there to be
// seen (empty.html), which the check of pages must find; and what a page is without Plotly (pictures.html).

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include "reports/figure.h"
#include "reports/html_page.h"

namespace uiclink {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A decay with noise, 200 readings a second [s, mm].
FigureSeries Decay(const std::string& name, double seconds, double frequency, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0, 0.0133);
  FigureSeries series{.name = name};
  for (double t = 0; t < seconds; t += 0.005) {
    series.x.push_back(t);
    series.y.push_back(38 * std::exp(-t / 6) * std::cos(2 * std::numbers::pi * frequency * t) + noise(generator));
  }
  return series;
}

FigureSeries Noise(const std::string& name, double seconds, unsigned seed) {
  FigureSeries series = Decay(name, seconds, 1, seed);
  std::mt19937 generator(seed);
  std::normal_distribution<double> noise(0, 0.0133);
  for (double& y : series.y) y = noise(generator);
  return series;
}

/// A record with its phases above, what the model leaves of it below: one axis of time.
Figure RecordFigure(unsigned number) {
  FigureSeries model = Decay("model", 15, 1.02, 0);
  model.line = FigureLine::kDashed;
  return {.panels = {{.title = "record " + std::to_string(number),
                      .x = {.label = "time", .unit = "s", .link = "time"},
                      .y = {.label = "displacement", .unit = "mm"},
                      .series = {Decay("measured", 15, 1.02, number), model},
                      .vertical_guides = {{0.2, "release"}, {1.1, "sliding"}, {8.5, "rolling"}}},
                     {.title = "measured - model",
                      .x = {.label = "time", .unit = "s", .link = "time"},
                      .y = {.label = "residual", .unit = "mm"},
                      .series = {Noise("residual", 15, number)},
                      .horizontal_guides = {{0, ""}, {0.0266, "2 x noise"}}}},
          .panel_height = 200};
}

/// Every mark and every line.
FigurePanel MarksPanel() {
  FigurePanel panel{
      .title = "marks and lines", .x = {.label = "amplitude", .unit = "mm"}, .y = {.label = "loss", .unit = "J"}};
  constexpr FigureMark kMarks[] = {FigureMark::kDot,    FigureMark::kCircle,   FigureMark::kDisc,
                                   FigureMark::kSquare, FigureMark::kTriangle, FigureMark::kCross};
  int row = 0;
  for (const FigureMark mark : kMarks) {
    FigureSeries series{.name = "mark " + std::to_string(row), .line = FigureLine::kNone, .mark = mark};
    for (int i = 0; i < 12; ++i) {
      series.x.push_back(i);
      series.y.push_back(row + 0.05 * i);
    }
    panel.series.push_back(series);
    ++row;
  }
  for (const FigureLine line : {FigureLine::kSolid, FigureLine::kDashed, FigureLine::kDotted}) {
    panel.series.push_back(
        {.name = "line " + std::to_string(row), .x = {0, 5, 11}, .y = {row + 0.0, row + 0.8, row + 0.1}, .line = line});
    ++row;
  }
  panel.series.push_back(
      {.name = "with marks", .x = {0, 4, 8, 11}, .y = {10, 10.5, kNaN, 10}, .mark = FigureMark::kDisc});
  return panel;
}

Figure FeatureFigure() {
  FigureSeries spectrum{.name = "spectrum"}, loop{.name = "loop"};
  for (int i = 1; i <= 2000; ++i) {
    const double f = 0.01 * i;
    spectrum.x.push_back(f);
    spectrum.y.push_back(1e-3 / (std::abs(f * f - 1.1) + 0.01) + (i == 900 ? -1 : 0));
    loop.x.push_back(10 * std::cos(0.00314 * i));
    loop.y.push_back(6 * std::sin(0.00314 * i));
  }
  return {
      .title = "Everything a figure has",
      .panels =
          {MarksPanel(),
           {.title = "logarithmic",
            .x = {.label = "frequency", .unit = "Hz", .log = true},
            .y = {.label = "amplitude", .unit = "mm", .log = true},
            .series = {spectrum},
            .horizontal_guides = {{1e-3, "sensor"}},
            .vertical_guides = {{1.05, "resonance"}, {1.2, "a second guide"}, {18, "at the edge"}},
            .notes = {{0.05, 2e-3, "a note in data coordinates"}}},
           {.title = "equal scales",
            .x = {.label = "x", .unit = "mm"},
            .y = {.label = "y", .unit = "mm"},
            .series =
                {loop,
                 {.name = "points", .x = {0, 3}, .y = {0, 4}, .line = FigureLine::kNone, .mark = FigureMark::kCross}},
            .equal_scales = true},
           {.title = "reversed, <b>no</b> tag & no %{x}",
            .x = {.label = "\"quoted\" 'text'", .unit = "m/s\u00b2", .reversed = true, .low = -5.0, .high = 5.0},
            .y = {.label = "places", .numbers = false},
            .series = {{.name = "</script><script>alert(1)</script>", .x = {-4, -2, 0, 2, 4}, .y = {1, 2, kNaN, 2, 1}},
                       {.name = "infinite",
                        .x = {-4, 0, 4},
                        .y = {3, std::numeric_limits<double>::infinity(), 3},
                        .mark = FigureMark::kSquare}},
            .notes = {{2, 2.5, "<i>x</i> < y"}}}},
      .columns = 2,
      .panel_height = 300};
}

void Write(const std::filesystem::path& file, const HtmlPage& page) {
  std::ofstream stream(file, std::ios::binary);
  stream << page.Format();
}

void AppendText(HtmlPage* page) {
  page->Paragraph("k = 4.20 1/m (4.19 to 4.21), k1 = 1.42 1/m, T01 = 0.0140: the plain model is adequate.", "lead");
  page->Heading(2, "Records", "records");
  page->Table(
      "Records", {{{"record"}, {"samples"}, {"used"}, {"why not"}}},
      {{{"lateral_01.txt"}, {"3001", "number"}, {"yes", "met"}, {""}},
       {{"lateral_02.txt"}, {"12", "number"}, {"no", "unexplained"}, {"too short: 12 samples, 200 are needed"}}});
  page->Heading(2, "To repeat it");
  page->Code("identify lateral_01.txt lateral_02.txt --out out");
  page->Heading(2, "Notes");
  page->Paragraph("A page of text.", "quiet");
}

}  // namespace

void WriteSamplePages(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  HtmlPage features("Features");
  AppendText(&features);
  features.Chart(FeatureFigure(), "features", "every feature of a figure", {{.text = "CSV", .link = "features.csv"}});
  for (unsigned i = 1; i <= 2; ++i)
    features.Chart(RecordFigure(i), "record-" + std::to_string(i), "a record and its residual");
  Write(folder / "features.html", features);

  HtmlPage forty("Forty figures");
  AppendText(&forty);
  for (unsigned i = 1; i <= 40; ++i)
    forty.Chart(RecordFigure(i), "record-" + std::to_string(i), "a record and its residual");
  Write(folder / "forty.html", forty);

  HtmlPage plain("Plain");
  AppendText(&plain);
  Write(folder / "plain.html", plain);

  HtmlPage empty("Empty");
  FigureSeries unseen = Decay("beyond the axes", 1, 1, 1);
  empty.Chart({.panels = {{.x = {.label = "time", .unit = "s", .low = 100.0, .high = 200.0}, .series = {unseen}}}},
              "empty", "nothing");
  Write(folder / "empty.html", empty);

  HtmlPage pictures("Pictures", {});
  pictures.Chart(FeatureFigure(), "features", "every feature of a figure");
  Write(folder / "pictures.html", pictures);
}

}  // namespace uiclink

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  uiclink::WriteSamplePages(argv[1]);
}
