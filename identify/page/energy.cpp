// Envelope, backbone and loss, and the hysteresis loops.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/force_series.h"
#include "identify/page/view.h"

namespace uiclink {
namespace {

const SymptomCurve* FindCurve(const Symptoms& symptoms, const std::string& id) {
  const auto found = std::ranges::find(symptoms.curves, id, &SymptomCurve::id);
  return found == symptoms.curves.end() ? nullptr : &*found;
}

/// Points of one record, by rising x.
struct Points {
  std::vector<double> x, measured, modelled;
};

Points TakeRecord(const SymptomCurve& curve, int record) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < curve.x.size(); ++i)
    if (curve.record[i] == record) order.push_back(i);
  std::ranges::sort(order, {}, [&](std::size_t i) { return curve.x[i]; });
  Points points;
  for (const std::size_t i : order) {
    points.x.push_back(curve.x[i]);
    points.measured.push_back(curve.measured[i]);
    points.modelled.push_back(curve.modelled[i]);
  }
  return points;
}

/// Somewhat below the least positive value, so that a model that loses nothing does not stretch the axis.
std::optional<double> FindFloor(const std::vector<double>& values) {
  double least = std::numeric_limits<double>::infinity();
  for (const double value : values)
    if (value > 0) least = std::min(least, value);
  return std::isfinite(least) ? std::optional(0.3 * least) : std::nullopt;
}

FigurePanel MakePanel(const DirectionView& view, const std::string& id, FigureAxis x, FigureAxis y) {
  FigurePanel panel{.x = std::move(x), .y = std::move(y)};
  const SymptomCurve* const curve = FindCurve(view.diagnosis->symptoms, id);
  if (curve == nullptr) return panel;
  panel.title = curve->title;
  if (panel.y.log) panel.y.low = FindFloor(curve->measured);
  if (view.records.size() > 1)
    panel.series.push_back(
        MakeMarks("measured, all records", curve->x, curve->measured, FigureColour::kSky, FigureMark::kDot));
  const int typical = static_cast<int>(view.typical);
  const Points plain = TakeRecord(*curve, typical);
  panel.series.push_back(
      MakeMarks("measured, " + view.Typical().label, plain.x, plain.measured, kMeasuredColour, FigureMark::kCircle));
  panel.series.push_back(MakeLine("plain model", plain.x, plain.modelled, kPlainColour));
  if (const SymptomCurve* const left = FindCurve(view.diagnosis->symptoms_left, id); left != nullptr) {
    const Points extended = TakeRecord(*left, typical);
    panel.series.push_back(
        MakeLine("extended model", extended.x, extended.modelled, kExtendedColour, FigureLine::kDashed, 1.8));
  }
  return panel;
}

}  // namespace

void AddEnergy(const DirectionView& view, Book* book) {
  if (view.diagnosis == nullptr) {
    book->page().Paragraph("These curves belong to the diagnosis, which was not asked for (--no-diagnosis).", "quiet");
    return;
  }
  const FigureAxis amplitude{.label = "amplitude", .unit = "mm"};
  Figure figure{.title = view.Word() + ": envelope, backbone, loss",
                .panels = {MakePanel(view, "envelope", {.label = "time", .unit = "s"}, amplitude),
                           MakePanel(view, "backbone", amplitude, {.label = "frequency", .unit = "Hz"}),
                           MakePanel(view, "loss", amplitude, {.label = "loss", .unit = "J/kN", .log = true})},
                .panel_height = 280};
  book->Draw(
      view.Word() + "_energy", figure,
      fmt::format(
          "From the turning points, record and model by the same code. Envelope: half the distance "
          "between neighbouring extrema. Backbone: frequency of the cycle at that amplitude. Loss: energy "
          "of a half cycle and kilonewton of load, on a logarithmic scale (a line that drops out of the picture: the "
          "model loses nothing there). Lines: the models of {} at the measured amplitudes.",
          view.Typical().label));
  const DecayExponent& e = view.diagnosis->symptoms.exponent;
  if (e.known)
    book->page().Paragraph(
        fmt::format("While the joints only roll, from {:.1f} to {:.1f} mm, the loss of a cycle grows "
                    "as amplitude^{:.2f} (95 %: {:.2f} to {:.2f}): 1 is dry friction, 2 viscous "
                    "damping, 3 quadratic drag or micro-slip.",
                    1e3 * e.from, 1e3 * e.to, e.p, e.low, e.high));
}

// ---------------------------------------------------------------- hysteresis

namespace {

/// Restoring force per unit load -y''/g over displacement from the zero of the fit, both averaged over short windows.
struct Loop {
  std::vector<double> y, force;  // [mm], [-]
};

/// The weak form of ForceSeries on a spring alone: -y''/g = K y - f, whatever K.
Loop MakeLoop(const RecordResult& r, const std::vector<double>& readings_mm) {
  Record record = r.record;
  const FitData data = r.Data();
  for (std::size_t i = 0; i < readings_mm.size(); ++i) record.y[data.first + i] = 1e-3 * readings_mm[i];
  MissingForceInput input{.record = &record,
                          .first = data.first,
                          .size = data.size,
                          .sigma = data.sigma,
                          .offset = r.start[2],
                          .y0 = r.start[0],
                          .t0 = r.start[1]};
  input.link.g = data.g;
  input.link.k = CalcQuantity(r.link, 0) + CalcQuantity(r.link, SumOfStiffness(r.link.size()));
  Loop loop;
  const std::optional<ForceSeries> series = ForceSeries::Make(input);
  if (!series) return loop;
  const Eigen::VectorXd y = series->Average([](const Moment& at) { return at.y; });
  for (std::size_t i = 0; i < series->size(); ++i) {
    const double at = y[static_cast<Eigen::Index>(i)];
    loop.y.push_back(1e3 * at);
    loop.force.push_back(input.link.k * at - series->windows()[i].f);
  }
  return loop;
}

}  // namespace

void AddLoops(const DirectionView& view, Book* book) {
  const RecordView& record = view.Typical();
  const Loop measured = MakeLoop(*record.result, record.measured), plain = MakeLoop(*record.result, record.plain);
  if (measured.y.empty()) {
    book->page().Paragraph("The record is too short for the force to be read from it.", "quiet");
    return;
  }
  // Without the main spring, which would make a needle of the loop.
  const double k = view.FinalLink(view.typical).k;
  const auto free = [&](const Loop& loop) {
    std::vector<double> left;
    for (std::size_t i = 0; i < loop.y.size(); ++i) left.push_back(loop.force[i] - 1e-3 * k * loop.y[i]);
    return left;
  };
  const FigureAxis y{.label = "displacement", .unit = "mm"};
  FigurePanel whole{.title = "restoring force", .x = y, .y = {.label = "force / M g"}};
  FigurePanel friction{.title = "without the main spring", .x = y, .y = {.label = "force / M g - k y"}};
  const auto add = [&](const std::string& name, const Loop& loop, FigureColour colour, FigureLine line, double width) {
    whole.series.push_back(MakeLine(name, loop.y, loop.force, colour, line, width));
    friction.series.push_back(MakeLine(name, loop.y, free(loop), colour, line, width));
  };
  add("measured", measured, kMeasuredColour, FigureLine::kSolid, 2.0);
  add("plain model", plain, kPlainColour, FigureLine::kSolid, 1.2);
  if (view.HasCauses() && !record.extended.empty())
    add("extended model", MakeLoop(*record.result, record.extended), FigureColour::kSky, FigureLine::kDashed, 1.4);
  Figure figure{.title = record.label + ": hysteresis", .panels = {whole, friction}, .columns = 2, .panel_height = 380};
  book->Draw(
      view.Word() + "_loops", figure,
      fmt::format("Restoring force -y''/g of {} over displacement, from the readings and in the same way from the "
                  "models' readings: means over windows of about a tenth of a second, no reading is "
                  "differentiated. Right: less the main spring, k = {:.3f} 1/m, so that the joints are left.",
                  record.label, k));
}

}  // namespace uiclink
