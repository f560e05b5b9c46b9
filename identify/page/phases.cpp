// Records with their phases, and what the frequency method reads from them (thesis, figures 4.6 to 4.8).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/page/view.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

constexpr double kMargin = 0.15;       // of a close-up, beside what it shows [s]
constexpr std::size_t kOutline = 500;  // points of a record where many stand beside each other
constexpr std::size_t kSinePoints = 60;
constexpr double kBeyond = 2.2;  // as far as this many times the arc that is fitted

FigureAxis TimeAxis(std::string link = {}) { return {.label = "time", .unit = "s", .link = std::move(link)}; }
FigureAxis ReadingAxis() { return {.label = "reading", .unit = "mm"}; }

std::vector<double> Millimetres(const std::vector<double>& metres) {
  std::vector<double> mm;
  for (const double y : metres) mm.push_back(1e3 * y);
  return mm;
}

/// Release, first free extremum, begin of rolling.
std::vector<FigureGuide> MarkPhases(const Phases& phases, bool with_words) {
  std::vector<FigureGuide> guides;
  const auto add = [&](double t, const char* words) {
    guides.push_back({.value = t, .text = with_words ? words : ""});
  };
  add(phases.release_s, "");
  if (!phases.extrema.empty()) add(phases.extrema[0].t, "fit begins");
  if (phases.rolling_start < phases.extrema.size()) add(phases.extrema[phases.rolling_start].t, "joints roll");
  return guides;
}

/// The whole record with its extrema (figure 4.6).
FigurePanel MakeRecordPanel(const RecordResult& r) {
  FigurePanel panel{.title = "record with its phases", .x = TimeAxis("record"), .y = ReadingAxis()};
  panel.series.push_back(MakeLine("measured", r.record.t, Millimetres(r.record.y), kMeasuredColour));
  std::vector<double> t, y;
  for (const Extremum& e : r.phases.extrema) t.push_back(e.t), y.push_back(1e3 * e.y);
  panel.series.push_back(MakeMarks("extrema of the free decay", t, y, kExtendedColour, FigureMark::kCircle));
  panel.vertical_guides = MarkPhases(r.phases, true);
  return panel;
}

/// zero + centre + (a - centre) cos w (t - t_extremum), on the way to the extremum: the published method with centre 0.
/// It goes on beyond the cut-off, where the two differ.
FigureSeries MakeArc(std::string name, const SineFit& sine, const SlidingArc& arc, double side, double centre, double w,
                     double duration, FigureColour colour, FigureLine line) {
  std::vector<double> t, y;
  const double longest = std::min(kBeyond * duration, std::numbers::pi / w);
  for (std::size_t i = 0; i <= kSinePoints; ++i) {
    const double before = longest * (1 - static_cast<double>(i) / kSinePoints);
    t.push_back(arc.extremum_t - before);
    y.push_back(1e3 * (sine.zero + centre + (side * arc.extremum - centre) * std::cos(w * before)));
  }
  return MakeLine(std::move(name), std::move(t), std::move(y), colour, line, 2.0);
}

double SideOf(const RecordResult& r, const SlidingArc& arc) {
  const auto nearest =
      std::ranges::min_element(r.phases.extrema, {}, [&](const Extremum& e) { return std::abs(e.t - arc.extremum_t); });
  return nearest->y > r.sine->zero ? 1 : -1;
}

/// The sliding arcs, as published and with the centre free (figure 4.7).
FigurePanel MakeSlidingPanel(const RecordResult& r) {
  const SineFit& sine = *r.sine;
  FigurePanel panel{.title = "sliding: arcs before extrema", .x = TimeAxis(), .y = ReadingAxis()};
  panel.series.push_back(MakeLine("measured", r.record.t, Millimetres(r.record.y), kMeasuredColour));
  for (std::size_t i = 0; i < sine.arcs.size(); ++i) {
    const SlidingArc& arc = sine.arcs[i];
    const double side = SideOf(r, arc), w = arc.omega_published;
    const double duration = std::acos(sine.cutoff / arc.extremum) / w;
    panel.series.push_back(
        MakeArc(i == 0 ? "sine about zero" : "", sine, arc, side, 0, w, duration, kPlainColour, FigureLine::kSolid));
    if (!(arc.k_corrected > 0)) continue;
    panel.series.push_back(MakeArc(i == 0 ? "centre free" : "", sine, arc, side, arc.centre,
                                   std::sqrt(r.record.g * arc.k_corrected), duration, kExtendedColour,
                                   FigureLine::kDashed));
  }
  const SlidingArc &first = sine.arcs.front(), &last = sine.arcs.back();
  panel.x.low = first.extremum_t - 2 * std::acos(sine.cutoff / first.extremum) / first.omega_published - kMargin;
  panel.x.high = last.extremum_t + kMargin;
  panel.horizontal_guides = {{.value = 1e3 * (sine.zero + sine.cutoff), .text = "cut-off"},
                             {.value = 1e3 * sine.zero, .text = "zero"},
                             {.value = 1e3 * (sine.zero - sine.cutoff), .text = ""}};
  return panel;
}

/// The periods that are counted (figure 4.8).
FigurePanel MakeRollingPanel(const RecordResult& r) {
  const SineFit& sine = *r.sine;
  FigurePanel panel{.title = "rolling: periods counted", .x = TimeAxis(), .y = ReadingAxis()};
  panel.series.push_back(MakeLine("measured", r.record.t, Millimetres(r.record.y), kMeasuredColour));
  const double y = 1e3 * r.phases.centre;
  panel.series.push_back(MakeMarks("first and last crossing", {sine.rolling_from, sine.rolling_to}, {y, y},
                                   kPlainColour, FigureMark::kSquare));
  panel.x.low = sine.rolling_from - 5 * kMargin;
  panel.x.high = sine.rolling_to + 5 * kMargin;
  const double largest = 1e3 * std::abs(r.phases.extrema[r.phases.rolling_start].y - r.phases.centre);
  panel.y.low = y - 1.3 * largest;
  panel.y.high = y + 1.3 * largest;
  return panel;
}

std::string DescribeMethod(const RecordResult& r) {
  const SineFit& sine = *r.sine;
  return fmt::format(
      "The frequency method on {}: omega sliding {:.3f} rad/s from the arc before the largest extremum (cut-off {:.1f} "
      "mm), so k = {:.3f} 1/m; omega rolling {:.3f} rad/s over {} periods ({:.2f} to {:.2f} s), so sum ki = {:.3f} "
      "1/m. "
      "With the centre free: k = {:.3f} 1/m, sum ki = {:.3f} 1/m.",
      FileName(r.record.file), sine.omega_sliding, 1e3 * sine.cutoff, sine.k, sine.omega_rolling, sine.rolling_periods,
      sine.rolling_from, sine.rolling_to, sine.sum_ki, sine.k_corrected, sine.sum_ki_corrected);
}

void DrawTypical(const DirectionView& view, Book* book) {
  const RecordResult& r = *view.Typical().result;
  Figure figure{.title = view.Typical().label, .panels = {MakeRecordPanel(r)}, .panel_height = 300};
  book->Draw(
      view.Word() + "_phases", figure,
      fmt::format("{}, {}: pushed, released at {:.2f} s, fitted from the first free extremum at {:.2f} s on; {}. "
                  "Of {} used record{} the one whose final rms is the middle one.",
                  FileName(r.record.file), view.Word(), r.phases.release_s, r.phases.extrema[0].t,
                  r.phases.rolling_start < r.phases.extrema.size()
                      ? fmt::format("from {:.2f} s on the joints only roll, or nearly so",
                                    r.phases.extrema[r.phases.rolling_start].t)
                      : "its joints slide to the end",
                  view.records.size(), view.records.size() == 1 ? "" : "s"));
  if (!r.sine) {
    book->page().Paragraph("The frequency method finds no sliding arc or no full period of rolling in this record.",
                           "quiet");
    return;
  }
  Figure method{.title = view.Typical().label + ": frequency method",
                .panels = {MakeSlidingPanel(r), MakeRollingPanel(r)},
                .columns = 2,
                .panel_height = 300};
  book->Draw(view.Word() + "_frequencies", method, DescribeMethod(r));
}

FigurePanel MakeSmallPanel(const RecordResult& r, const std::string& word) {
  const std::vector<double> y = Millimetres(r.record.y);
  std::vector<double> t, thin;
  for (const std::size_t i : ThinForDrawing(r.record.t, y, kOutline)) t.push_back(r.record.t[i]), thin.push_back(y[i]);
  FigurePanel panel{.title = FileName(r.record.file) + (r.used ? "" : " (left out)"),
                    .x = TimeAxis(word + "-all"),
                    .y = ReadingAxis()};
  panel.series.push_back(MakeLine("", t, thin, r.used ? kMeasuredColour : kPlainColour, FigureLine::kSolid, 1.0));
  if (r.used) panel.vertical_guides = MarkPhases(r.phases, false);
  return panel;
}

void DrawAll(const DirectionView& view, Book* book) {
  if (view.id->records.size() < 2) return;
  Figure figure{.title = view.Word() + " records", .columns = 2, .panel_height = 150};
  for (const RecordResult& r : view.id->records) figure.panels.push_back(MakeSmallPanel(r, view.Word()));
  book->Draw(
      view.Word() + "_records", figure,
      "Every record of this direction. Vertical lines: release, first free extremum, begin of rolling. Thinned to "
      "its outline; all samples of the fit are in residuals.csv.");
}

}  // namespace

void AddPhases(const DirectionView& view, Book* book) {
  DrawTypical(view, book);
  DrawAll(view, book);
  if (const std::string bias = DescribeBias(*view.id); !bias.empty()) {
    book->page().Paragraph(bias);
    book->Show(MakeBiasTable(*view.id), "The published k by the extremum that it is read from");
  }
}

}  // namespace uiclink
