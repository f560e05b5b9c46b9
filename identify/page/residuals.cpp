// What the residuals depend on.

#include <fmt/format.h>

#include <algorithm>

#include "identify/page/view.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

const SymptomCurve* FindCurve(const Symptoms& symptoms, const std::string& id) {
  const auto found = std::ranges::find(symptoms.curves, id, &SymptomCurve::id);
  return found == symptoms.curves.end() ? nullptr : &*found;
}

/// "displacement [mm]" as an axis.
FigureAxis MakeAxis(const std::string& label) {
  const std::size_t open = label.rfind(" [");
  if (open == std::string::npos || label.back() != ']') return {.label = label};
  return {.label = label.substr(0, open), .unit = label.substr(open + 2, label.size() - open - 3)};
}

void AddBins(const std::string& name, const SymptomCurve& curve, FigureColour colour, FigureMark mark,
             FigurePanel* panel) {
  std::vector<double> low, high;
  for (std::size_t i = 0; i < curve.x.size(); ++i) {
    low.push_back(curve.measured[i] - 2 * curve.error[i]);
    high.push_back(curve.measured[i] + 2 * curve.error[i]);
  }
  panel->series.push_back(MakeBars("", curve.x, low, high, colour));
  panel->series.push_back(MakeMarks(name, curve.x, curve.measured, colour, mark));
}

FigurePanel MakeBinPanel(const DirectionView& view, const std::string& id) {
  const SymptomCurve* const curve = FindCurve(view.diagnosis->symptoms, id);
  if (curve == nullptr) return {};
  FigurePanel panel{
      .title = curve->title, .x = MakeAxis(curve->x_label), .y = {.label = "mean residual", .unit = "mm"}};
  AddBins("plain model", *curve, kPlainColour, FigureMark::kSquare, &panel);
  if (const SymptomCurve* const left = FindCurve(view.diagnosis->symptoms_left, id); left != nullptr)
    AddBins("extended model", *left, kExtendedColour, FigureMark::kDisc, &panel);
  return panel;
}

FigurePanel MakeSpectrumPanel(const DirectionView& view) {
  const SymptomCurve* const curve = FindCurve(view.diagnosis->symptoms, "residual_spectrum");
  if (curve == nullptr) return {};
  FigurePanel panel{.title = "Spectrum of the residual",
                    .x = {.label = "frequency", .unit = "Hz"},
                    .y = {.label = "power / white noise", .log = true}};
  panel.series.push_back(MakeLine("plain model", curve->x, curve->measured, kPlainColour));
  if (const SymptomCurve* const left = FindCurve(view.diagnosis->symptoms_left, "residual_spectrum"); left != nullptr)
    panel.series.push_back(MakeLine("extended model", left->x, left->measured, kExtendedColour));
  panel.horizontal_guides = {{.value = 1, .text = "white noise"}};
  return panel;
}

FigurePanel MakeMiddlePanel(const DirectionView& view) {
  const SymptomCurve* const curve = FindCurve(view.diagnosis->symptoms, "mid_line");
  FigurePanel panel{.title = "Mid-line of " + view.Typical().label,
                    .x = {.label = "time", .unit = "s"},
                    .y = {.label = "reading", .unit = "mm"}};
  if (curve == nullptr) return panel;
  const auto add = [&](const std::string& name, const SymptomCurve& from, const std::vector<double>& values,
                       FigureColour colour, FigureMark mark) {
    std::vector<double> t, y;
    for (std::size_t i = 0; i < from.x.size(); ++i)
      if (from.record[i] == static_cast<int>(view.typical)) t.push_back(from.x[i]), y.push_back(values[i]);
    panel.series.push_back(MakeLine(name, t, y, colour));
    if (mark == FigureMark::kNone) return;
    panel.series.back().line = FigureLine::kNone;
    panel.series.back().mark = mark;
  };
  add("measured", *curve, curve->measured, kMeasuredColour, FigureMark::kCircle);
  add("plain model", *curve, curve->modelled, kPlainColour, FigureMark::kNone);
  if (const SymptomCurve* const left = FindCurve(view.diagnosis->symptoms_left, "mid_line"); left != nullptr)
    add("extended model", *left, left->modelled, kExtendedColour, FigureMark::kNone);
  return panel;
}

}  // namespace

void AddResiduals(const DirectionView& view, Book* book) {
  if (view.diagnosis == nullptr) {
    book->page().Paragraph("Residuals are taken apart by the diagnosis, which was not asked for (--no-diagnosis).",
                           "quiet");
    return;
  }
  Figure figure{.title = view.Word() + ": residuals, all records together", .columns = 2, .panel_height = 220};
  for (const char* id : {"residual_against_displacement", "residual_against_velocity", "residual_against_phase",
                         "residual_against_time"})
    if (FigurePanel panel = MakeBinPanel(view, id); !panel.series.empty()) figure.panels.push_back(std::move(panel));
  if (FigurePanel panel = MakeSpectrumPanel(view); !panel.series.empty()) figure.panels.push_back(std::move(panel));
  figure.panels.push_back(MakeMiddlePanel(view));
  book->Draw(
      view.Word() + "_diagnostics", figure,
      "Means of measured less modelled over bins of displacement, velocity, phase of the cycle and time since the "
      "first extremum, with two standard errors that respect the correlation of neighbouring samples; the "
      "residual's spectrum; and the middle between turning points. A model that lacks nothing leaves all means "
      "within their errors of zero and a spectrum about 1.");
  constexpr std::size_t kMost = 8;
  const SymptomWords words = DescribeSymptoms(*view.diagnosis, kMost);
  if (words.of_model.empty()) {
    book->page().Paragraph("The plain model gets nothing wrong that an engineer would look for.");
  } else {
    std::vector<HtmlPage::Cells> rows;
    for (const std::string& sentence : words.of_model) rows.push_back({{.text = sentence}});
    if (words.more > 0)
      rows.push_back({{.text = fmt::format("and {} more (result.json: diagnosis.symptoms)", words.more)}});
    book->page().Table(
        fmt::format("What the plain model gets wrong, surest first (z: difference over its standard error; "
                    "chance seldom gives more than {:g})",
                    kSymptomThreshold),
        {}, rows);
  }
  book->Tell(words.of_method, "quiet");
}

}  // namespace uiclink
