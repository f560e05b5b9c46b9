// Stiffness and friction record by record (thesis, figure 4.9), and model against measurement (4.12).

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>

#include "identify/page/view.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

constexpr std::size_t kOutline = 500;  // points of a record where many stand beside each other

/// One quantity of a link over the records.
struct Compared {
  std::string title, unit;
  int quantity = 0;  ///< CountQuantities
  double SineFit::*published;
  double SineFit::*centre_free;
};

std::vector<Compared> ListCompared(int n) {
  return {{"k", "1/m", 0, &SineFit::k, &SineFit::k_corrected},
          {n == 1 ? "k1" : "sum ki", "1/m", SumOfStiffness(n), &SineFit::sum_ki, &SineFit::sum_ki_corrected},
          {n == 1 ? "T01" : "sum T0i", "", SumOfFriction(n), &SineFit::T0, &SineFit::T0_corrected}};
}

FigurePanel MakePanel(const DirectionView& view, const Compared& what) {
  FigurePanel panel{.title = what.title, .x = {.label = "record"}, .y = {.label = what.title, .unit = what.unit}};
  std::vector<double> number, published, free, plain, low, high, final_value;
  for (std::size_t r = 0; r < view.records.size(); ++r) {
    const RecordResult& record = *view.records[r].result;
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const auto q = static_cast<std::size_t>(what.quantity);
    number.push_back(static_cast<double>(r + 1));
    published.push_back(record.sine ? (*record.sine).*what.published : kNone);
    free.push_back(record.sine ? (*record.sine).*what.centre_free : kNone);
    const bool has_own = q < record.own_quantities.size();
    plain.push_back(has_own ? record.own_quantities[q].value : CalcQuantity(record.link, what.quantity));
    low.push_back(has_own ? record.own_quantities[q].low : kNone);
    high.push_back(has_own ? record.own_quantities[q].high : kNone);
    final_value.push_back(CalcQuantity(view.FinalLink(r), what.quantity));
  }
  panel.series.push_back(
      MakeMarks("frequency method, as published", number, published, FigureColour::kOrange, FigureMark::kTriangle));
  panel.series.push_back(
      MakeMarks("frequency method, centre free", number, free, FigureColour::kGreen, FigureMark::kCross));
  panel.series.push_back(MakeBars("", number, low, high, kPlainColour));
  panel.series.push_back(
      MakeMarks("plain model, its own fit with 95 %", number, plain, kPlainColour, FigureMark::kSquare));
  if (view.HasCauses())
    panel.series.push_back(MakeMarks("extended model", number, final_value, kExtendedColour, FigureMark::kDisc));
  const double mean = view.Quantities()[static_cast<std::size_t>(what.quantity)].value;
  panel.horizontal_guides.push_back({.value = mean, .text = ""});
  panel.x.low = 0.5;
  panel.x.high = static_cast<double>(view.records.size()) + 0.5;
  return panel;
}

std::string ListNumbers(const DirectionView& view) {
  std::string list;
  for (std::size_t r = 0; r < view.records.size(); ++r)
    list += fmt::format("{}{} {}", r == 0 ? "" : ", ", r + 1, view.records[r].label);
  return list;
}

}  // namespace

void AddStiffness(const DirectionView& view, Book* book) {
  Figure figure{.title = view.Word() + ": stiffness and friction by record", .panel_height = 210};
  for (const Compared& what : ListCompared(view.Sliders())) figure.panels.push_back(MakePanel(view, what));
  book->Draw(
      view.Word() + "_stiffness", figure,
      fmt::format("Stiffness and friction of each record per unit of load, read in {} ways. Dotted: the value of "
                  "this report{}. Records: {}.",
                  view.HasCauses() ? "four" : "three", view.HasCauses() ? ", of the extended model" : "",
                  ListNumbers(view)));
  book->Show(MakeRecordTable(*view.id), "Frequency method and plain model, record by record");
}

// ---------------------------------------------------------------- model against measurement

namespace {

FigureSeries Thin(FigureSeries series) {
  std::vector<double> x, y;
  for (const std::size_t i : ThinForDrawing(series.x, series.y, kOutline))
    x.push_back(series.x[i]), y.push_back(series.y[i]);
  series.x = std::move(x);
  series.y = std::move(y);
  return series;
}

FigurePanel MakeReadings(const DirectionView& view, const RecordView& record) {
  FigurePanel panel{.title = "readings", .x = {.label = "time", .unit = "s"}, .y = {.label = "reading", .unit = "mm"}};
  panel.series.push_back(MakeLine("measured", record.t, record.measured, kMeasuredColour, FigureLine::kSolid, 2.4));
  panel.series.push_back(MakeLine("plain model", record.t, record.plain, kPlainColour));
  if (view.HasCauses())
    panel.series.push_back(
        MakeLine("extended model", record.t, record.extended, FigureColour::kSky, FigureLine::kDashed, 1.6));
  return panel;
}

FigurePanel MakeResiduals(const DirectionView& view, const RecordView& record, const std::string& title) {
  FigurePanel panel{
      .title = title, .x = {.label = "time", .unit = "s"}, .y = {.label = "measured less model", .unit = "mm"}};
  panel.series.push_back(
      MakeLine("plain model", record.t, record.plain_residual, kPlainColour, FigureLine::kSolid, 1.0));
  if (view.HasCauses() && !record.extended_residual.empty())
    panel.series.push_back(
        MakeLine("extended model", record.t, record.extended_residual, kExtendedColour, FigureLine::kSolid, 1.0));
  return panel;
}

void DrawAllResiduals(const DirectionView& view, Book* book) {
  if (view.records.size() < 2) return;
  Figure figure{.title = view.Word() + ": what the models leave", .columns = 2, .panel_height = 150};
  for (const RecordView& record : view.records) {
    FigurePanel panel = MakeResiduals(
        view, record,
        view.HasCauses() ? fmt::format("{}: {} -> {} noise levels", record.label, FormatRatio(record.plain_rms),
                                       FormatRatio(record.extended_rms))
                         : fmt::format("{}: {} noise levels", record.label, FormatRatio(record.plain_rms)));
    panel.y.label = "residual";
    panel.x.link = view.Word() + "-residuals";
    for (FigureSeries& series : panel.series) {
      series = Thin(std::move(series));
      series.name.clear();
    }
    figure.panels.push_back(std::move(panel));
  }
  book->Draw(
      view.Word() + "_residuals", figure,
      fmt::format("Measured less modelled, every used record: plain model{}. Thinned to its outline; all samples "
                  "are in residuals.csv.",
                  view.HasCauses() ? " (vermilion) and extended model (blue)" : ""));
}

std::string DescribeEnding(const DirectionView& view, const RecordView& record) {
  const double noise = 1e3 * record.result->noise.sigma;
  std::string text = fmt::format("{}: the plain model misses the readings by {:.4f} mm rms, {} times their noise",
                                 record.label, record.plain_rms * noise, FormatRatio(record.plain_rms));
  if (view.HasCauses()) {
    text += fmt::format(
        "; the model with {} by {:.4f} mm, {} times",
        view.diagnosis->causes.size() == 1 ? std::string(view.diagnosis->causes[0].effect->title) : "the named causes",
        record.extended_rms * noise, FormatRatio(record.extended_rms));
  }
  return text + ". Frequency and decay are fitted together, to every sample at once.";
}

}  // namespace

void AddModels(const DirectionView& view, Book* book) {
  const RecordView& record = view.Typical();
  Figure figure{.title = record.label + ": measured and modelled",
                .panels = {MakeReadings(view, record), MakeResiduals(view, record, "what the models leave")},
                .panel_height = 280};
  book->Draw(view.Word() + "_models", figure, DescribeEnding(view, record));
  DrawAllResiduals(view, book);
  if (view.HasCauses())
    book->Show(MakeGainTable(*view.id, *view.diagnosis), "Gain by size of the motion, all records together");
}

}  // namespace uiclink
