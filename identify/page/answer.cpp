// The first screen: what was measured, the values, what is wrong with the model, and what it means for the wagon.

#include <fmt/format.h>

#include <algorithm>

#include "identify/page/view.h"
#include "identify/report_diagnosis.h"
#include "identify/report_tables.h"

namespace uiclink {
namespace {

constexpr double kKmhPerMs = 3.6;

std::string FormatBounds(const Estimate& e, double scale = 1) {
  const auto round = [&](double value) { return Round(scale * value, scale * e.std); };
  return fmt::format("{}{} to {}{}", e.low_open ? "< " : "", round(e.low), e.high_open ? "> " : "", round(e.high));
}

/// "3.382 1/m (95 %: 3.327 to 3.438)"
std::string FormatEstimate(const Estimate& e, const char* unit) {
  return fmt::format("{}{} (95 %: {})", Round(e.value, e.std), unit, FormatBounds(e));
}

const Estimate& Quantity(const DirectionView& view, int quantity) {
  return view.Quantities()[static_cast<std::size_t>(quantity)];
}

bool IsMean(const DirectionView& view) {
  return view.HasCauses() ? view.Final().sharing != Sharing::kLink : !view.id->shared;
}

std::string DescribeMeasured(const DirectionView& view) {
  const std::size_t all = view.id->records.size(), used = view.records.size();
  std::string text = fmt::format("Measured: {} {} ring-down{} of a UIC double link under {:g} kg ({:.0f} N){}.", used,
                                 view.Word(), used == 1 ? "" : "s", view.records[0].result->record.mass_kg, view.load,
                                 all > used ? fmt::format("; {} of {} could not be used", all - used, all) : "");
  if (used == 1) text += " One record says nothing about scatter between records.";
  return text;
}

std::string DescribeValues(const DirectionView& view) {
  const int n = view.Sliders();
  const Estimate &k = Quantity(view, 0), &ki = Quantity(view, SumOfStiffness(n)),
                 &T0 = Quantity(view, SumOfFriction(n));
  const double kilonewton = 1e-3 * view.load;
  return fmt::format(
      "{} k = {} per unit of load, that is {} kN/m; while the joints roll they add {} = {}; they slide under a "
      "friction of {} = {} of the load{}.",
      IsMean(view) ? "The stiffness while all joints slide is on average" : "The stiffness while all joints slide is",
      FormatEstimate(k, " 1/m"), Round(kilonewton * k.value, kilonewton * k.std), n == 1 ? "k1" : "sum ki",
      FormatEstimate(ki, " 1/m"), n == 1 ? "T01" : "sum T0i", FormatEstimate(T0, ""),
      IsMean(view) && k.spread > 0 ? fmt::format("; k of single records scatters by {}", Round(k.spread, k.spread))
                                   : "");
}

std::string DescribeModel(const DirectionView& view) {
  const Identification& id = *view.id;
  if (view.diagnosis == nullptr)
    return fmt::format(
        "The plain dry-friction model leaves {} noise levels ({} mm); 1 is noise alone. What it lacks was not asked "
        "(--no-diagnosis).",
        FormatRatio(id.rms / id.noise), FormatMm(id.rms));
  std::string text = FormatAnswer(*view.diagnosis);
  for (const Cause& cause : view.diagnosis->causes) text += " " + DescribeRivals(cause);
  if (view.diagnosis->missing_force) text += " " + DescribeMissingForce(*view.diagnosis);
  return text;
}

// ---------------------------------------------------------------- the wagon

const ValidationRow* FirstRow(const RunResult& run) {
  return run.wagon && !run.wagon->rows.empty() ? &run.wagon->rows.front() : nullptr;
}

std::string FormatSpeed(double v) { return fmt::format("{:.2f} m/s ({:.1f} km/h)", v, kKmhPerMs * v); }

std::string DescribeSpeed(const ValidationRow& row) {
  if (!row.critical_speed) return "the critical speed could not be found";
  const CriticalSpeed& speed = *row.critical_speed;
  if (speed.unstable_from_start) return "straight running is not stable at any speed that was tried";
  if (!speed.value)
    return "straight running is stable up to " + FormatSpeed(speed.searched_to) + ", the highest speed tried";
  std::string text = "straight running is stable up to " + FormatSpeed(*speed.value);
  if (speed.low && speed.high)
    text += fmt::format("; 95 %, from the link's uncertainty alone: {:.2f} to {:.2f} m/s", *speed.low, *speed.high);
  return text + "; above that it hunts";
}

std::string DescribeHunting(const RunResult& run, const ValidationRow& row) {
  if (!row.hunting) return "";
  const HuntingRun& hunting = *row.hunting;
  const double speed = run.wagon->options.speed;
  if (!hunting.end_reason.empty())
    return fmt::format(" At {:g} m/s the run ended after {:.1f} s: {}.", speed, hunting.simulated, hunting.end_reason);
  const int impacts = hunting.impacts[0] + hunting.impacts[1];
  return fmt::format(
      " At {:g} m/s the front wheelset moves by ±{:.2f} mm, {}.", speed, 1e3 * hunting.wheelset_amplitude[0],
      impacts == 0
          ? std::string("without touching its guidance")
          : fmt::format("with {} impacts on the guidance of up to {:.1f} kN", impacts, 1e-3 * hunting.peak_impact));
}

std::string DescribeOnWagon(const RunResult& run) {
  if (!run.wagon) return "What it means for the wagon was not asked (--no-wagon).";
  const ValidationRow* const row = FirstRow(run);
  if (row == nullptr) return "On the wagon nothing could be done: " + run.wagon->failure;
  std::string text = fmt::format("On the wagon ({}, {}, {}) {}.", run.wagon->wagon, run.wagon->cargo,
                                 run.wagon->geometry, DescribeSpeed(*row));
  text += DescribeHunting(run, *row);
  for (const std::string& notice : row->notices) text += " Note: " + notice + ".";
  if (!row->set.doubt.empty()) text += " Not to be trusted as it stands: " + row->set.doubt + ".";
  return text;
}

// ---------------------------------------------------------------- at a glance

struct Glance {
  std::string text, style;
};

Glance GlanceAtModel(const DirectionView& view) {
  if (view.diagnosis == nullptr) return {"not asked (--no-diagnosis)", ""};
  const std::string left = FormatRatio(view.diagnosis->plain.structure.RmsOverNoise());
  switch (view.diagnosis->verdict) {
    case Verdict::kAdequate:
      return {"yes: it leaves noise alone", "met"};
    case Verdict::kExplained:
      return {fmt::format("no: it misses the readings by {} noise levels; with the named cause by {}", left,
                          FormatRatio(view.diagnosis->extended.structure.RmsOverNoise())),
              "explained"};
    case Verdict::kPartlyExplained:
      return {fmt::format("no: it misses the readings by {} noise levels; with the named causes still by {}", left,
                          FormatRatio(view.diagnosis->extended.structure.RmsOverNoise())),
              "unexplained"};
    case Verdict::kUnexplained:
      break;
  }
  return {fmt::format("no: it misses the readings by {} noise levels, and nothing known accounts for it", left),
          "unexplained"};
}

Glance GlanceAtCause(const DirectionView& view) {
  if (view.diagnosis == nullptr) return {"not asked (--no-diagnosis)", ""};
  if (view.diagnosis->verdict == Verdict::kAdequate) return {"nothing that shows in these records", "met"};
  if (!view.HasCauses()) return {"something that the catalogue of effects does not have", "unexplained"};
  std::string text;
  for (const Cause& cause : view.diagnosis->causes) {
    text += (text.empty() ? "" : "; and ") + std::string(cause.effect->title);
    if (!cause.parameters.empty()) text += ", " + ListParameters(cause.parameters);
    for (const Effect* rival : cause.rivals) text += ", or " + std::string(rival->title);
  }
  if (view.diagnosis->verdict == Verdict::kPartlyExplained) text += "; and something unknown";
  return {text, view.diagnosis->verdict == Verdict::kExplained ? "explained" : "unexplained"};
}

HtmlPage::Cells MakeRow(const std::string& question, std::span<const DirectionView> views,
                        Glance (*answer)(const DirectionView&)) {
  HtmlPage::Cells cells{{.text = question}};
  for (const DirectionView& view : views) {
    const Glance glance = answer(view);
    cells.push_back({.text = glance.text, .style = glance.style});
  }
  return cells;
}

Glance GlanceAtStiffness(const DirectionView& view) {
  const Estimate& k = Quantity(view, 0);
  const double kilonewton = 1e-3 * view.load;
  const bool doubtful = view.diagnosis != nullptr && (view.diagnosis->verdict == Verdict::kUnexplained ||
                                                      view.diagnosis->verdict == Verdict::kPartlyExplained);
  return {fmt::format("{}, or {} kN/m ({}) under {:.0f} N{}", FormatEstimate(k, " 1/m"),
                      Round(kilonewton * k.value, kilonewton * k.std), FormatBounds(k, kilonewton), view.load,
                      doubtful ? "; not to be trusted as it stands" : ""),
          doubtful ? "unexplained" : ""};
}

void AddGlance(const RunResult& run, std::span<const DirectionView> views, Book* book) {
  std::vector<HtmlPage::Cells> head{{{.text = "in short"}}};
  for (const DirectionView& view : views) head[0].push_back({.text = view.Word()});
  std::vector<HtmlPage::Cells> rows{MakeRow("What is the stiffness k?", views, &GlanceAtStiffness),
                                    MakeRow("Is the plain dry-friction model adequate?", views, &GlanceAtModel),
                                    MakeRow("What does it lack?", views, &GlanceAtCause)};
  const ValidationRow* const row = FirstRow(run);
  std::string speed = !run.wagon       ? "not asked (--no-wagon)"
                      : row == nullptr ? "could not be found"
                                       : DescribeSpeed(*row);
  if (row != nullptr && !row->set.doubt.empty()) speed += " (not to be trusted as it stands)";
  rows.push_back({{.text = "How fast may the wagon run?"}, {.text = speed, .columns = views.size()}});
  book->page().Table("", head, rows);
}

}  // namespace

void AddAnswer(const RunResult& run, std::span<const DirectionView> views, Book* book) {
  AddGlance(run, views, book);
  for (const DirectionView& view : views)
    book->page().Paragraph(DescribeMeasured(view) + " " + DescribeValues(view) + " " + DescribeModel(view), "lead");
  book->page().Paragraph(DescribeOnWagon(run), "lead");
}

}  // namespace uiclink
