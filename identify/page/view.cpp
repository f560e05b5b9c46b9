#include "identify/page/view.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

#include "identify/report_tables.h"

namespace uiclink {
namespace {

RecordView MakeRecordView(const RecordResult& r, const std::vector<double>& plain,
                          const std::vector<double>& extended) {
  RecordView view;
  view.result = &r;
  view.label = std::filesystem::path(r.record.file).stem().string();
  const FitData data = r.Data();
  const auto rms = [&](const std::vector<double>& residuals) {
    double squares = 0;
    for (const double x : residuals) squares += x * x;
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, residuals.size()))) / data.sigma;
  };
  view.plain_rms = rms(plain);
  view.extended_rms = rms(extended);
  for (std::size_t i = 0; i < data.size; ++i) {
    const double reading = 1e3 * r.record.y[data.first + i];
    view.t.push_back(r.record.t[data.first + i]);
    view.measured.push_back(reading);
    view.plain_residual.push_back(-1e3 * plain[i]);
    view.plain.push_back(reading + 1e3 * plain[i]);
    if (extended.size() != data.size) continue;  // the model has no solution
    view.extended_residual.push_back(-1e3 * extended[i]);
    view.extended.push_back(reading + 1e3 * extended[i]);
  }
  return view;
}

std::size_t FindTypical(const std::vector<RecordView>& records) {
  std::vector<std::size_t> order(records.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return records[i].extended_rms; });
  return order[(order.size() - 1) / 2];
}

DirectionView MakeView(const RunResult& run, std::size_t d, std::span<const ValidationSet> sets,
                       const ReadingResiduals& residuals, int threads) {
  DirectionView view;
  view.id = &run.directions[d];
  view.diagnosis = run.diagnoses.empty() ? nullptr : &run.diagnoses[d];
  if (!sets.empty()) {
    const std::optional<DirectionParameters>& parameters = sets.front().set[view.id->direction];
    if (parameters) view.parameters = &*parameters;
    view.load = sets.front().set.load_N;
  }
  const std::vector<std::size_t> used = view.id->UsedIndices();
  for (std::size_t r = 0; r < used.size(); ++r)
    view.records.push_back(MakeRecordView(view.id->records[used[r]], residuals.plain[r], residuals.extended[r]));
  view.typical = FindTypical(view.records);
  if (view.diagnosis == nullptr) view.plain = DescribePlain(*view.id);
  // Refits of several sliders take long, and one record shows what there is to be seen.
  std::vector<std::size_t> profiled{view.typical};
  if (view.Sliders() == 1) {
    profiled.resize(view.records.size());
    std::iota(profiled.begin(), profiled.end(), std::size_t{0});
  }
  view.profiles = CalcProfiles(*view.id, view.Final(), profiled, threads);
  return view;
}

}  // namespace

Oscillator<double> DirectionView::FinalLink(std::size_t r) const {
  const FitState& link = Final().outcome.state.link;
  return ToOscillator(link.LevelsOf(r), link.ShapeOf(r), id->g);
}

std::vector<DirectionView> MakeViews(const RunResult& run, std::span<const ValidationSet> sets,
                                     std::span<const ReadingResiduals> residuals, int threads) {
  std::vector<DirectionView> views;
  for (std::size_t d = 0; d < run.directions.size(); ++d)
    if (run.directions[d].CountUsed() > 0) views.push_back(MakeView(run, d, sets, residuals[d], threads));
  return views;
}

// ---------------------------------------------------------------- the book

void Book::Draw(const std::string& name, Figure figure, const std::string& description) {
  HtmlPage::Cells files;
  for (const auto& [word, ending] : {std::pair{"SVG", ".svg"}, std::pair{"PNG", ".png"}, std::pair{"CSV", ".csv"}})
    if (pictures_ || ending == std::string(".csv")) files.push_back({.text = word, .link = "figures/" + name + ending});
  page_.Chart(figure, name, description, files);
  figures_.push_back({name, std::move(figure)});
}

void Book::Show(const TextTable& table, const std::string& caption) { page_.Table(caption, table); }

void Book::Tell(std::span<const std::string> paragraphs, const std::string& style) {
  for (const std::string& paragraph : paragraphs) page_.Paragraph(paragraph, style);
}

ReportPage Book::Finish() { return {page_.Format(), std::move(figures_)}; }

// ---------------------------------------------------------------- parts of figures

FigureSeries MakeLine(std::string name, std::vector<double> x, std::vector<double> y, FigureColour colour,
                      FigureLine line, double width) {
  FigureSeries series;
  series.name = std::move(name);
  series.x = std::move(x);
  series.y = std::move(y);
  series.colour = colour;
  series.line = line;
  series.width = width;
  return series;
}

FigureSeries MakeMarks(std::string name, std::vector<double> x, std::vector<double> y, FigureColour colour,
                       FigureMark mark) {
  FigureSeries series = MakeLine(std::move(name), std::move(x), std::move(y), colour, FigureLine::kNone);
  series.mark = mark;
  return series;
}

FigureSeries MakeBars(std::string name, const std::vector<double>& x, const std::vector<double>& low,
                      const std::vector<double>& high, FigureColour colour) {
  constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
  FigureSeries series = MakeLine(std::move(name), {}, {}, colour);
  for (std::size_t i = 0; i < x.size(); ++i) {
    series.x.insert(series.x.end(), {x[i], x[i], kGap});
    series.y.insert(series.y.end(), {low[i], high[i], kGap});
  }
  return series;
}

}  // namespace uiclink
