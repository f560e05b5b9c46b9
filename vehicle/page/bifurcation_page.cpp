// The page of `wagon bifurcation`.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "vehicle/hunting/attractor_report.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

double FrontMillimetres(const Cycle& cycle) {
  return 1e3 * cycle.Amplitude(static_cast<int>(TrackedMotion::kFrontLateral));
}

/// The stable cycle with the largest motion of the front wheelset; null without any.
const Cycle* FindLargest(const BifurcationDiagram& diagram) {
  const Cycle* largest = nullptr;
  for (const HuntingBranch& hunting : diagram.branches)
    for (const Cycle& cycle : hunting.branch.points)
      if (cycle.stable() && (largest == nullptr || FrontMillimetres(cycle) > FrontMillimetres(*largest)))
        largest = &cycle;
  return largest;
}

std::string DescribeLargest(const BifurcationDiagram& diagram) {
  const Cycle* const largest = FindLargest(diagram);
  if (largest == nullptr) return "";
  const double lambda = largest->lambda;
  return fmt::format(
      "The largest lasting hunting that was followed moves the front wheelset {:.1f} mm to either side, at {}.",
      FrontMillimetres(*largest),
      diagram.parameter.is_speed() ? FormatSpeedTwice(lambda) : DescribeValue(diagram.parameter, lambda));
}

// ---------------------------------------------------------------- by speed

/// "sets in with a jump", "sets in gently".
std::string DescribeOnset(const BifurcationRun& run, double linear) {
  for (const HopfPoint& hopf : run.diagram.hopfs) {
    if (hopf.crossing.V != linear) continue;
    const std::string type = ToCrossingType(hopf, run.options.hopf).type;
    if (type == "subcritical") return "with a jump";
    if (type == "supercritical") return "gently";
  }
  return "";
}

std::string DescribeBoth(const BifurcationRun& run, double nonlinear, double linear) {
  const std::string wagon = DescribeLoadedWagon(run.inputs), onset = DescribeOnset(run, linear);
  const bool at_bound = IsAtBound(*run.diagram.nonlinear, run.options);
  if (nonlinear < linear)
    return fmt::format(
        "{} {} every motion dies out{}. From there on hunting can last once something has set it off, and from {} on "
        "{} "
        "hunts by itself{}. In between it may run quietly or hunt: which of them depends on what it has been through.",
        at_bound ? "Somewhere below" : "Up to", FormatSpeedTwice(nonlinear),
        at_bound ? " (the range that was searched ends there)" : "", FormatSpeedTwice(linear), wagon,
        onset.empty() ? "" : ", setting in " + onset);
  return fmt::format("Up to {} {} runs quietly. Above it hunts by itself{}; no hunting was found below.",
                     FormatSpeedTwice(linear), wagon, onset.empty() ? "" : ", setting in " + onset);
}

std::string DescribeBySpeed(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  const std::optional<double> linear = diagram.linear.linear_critical_speed;
  const std::string wagon = DescribeLoadedWagon(run.inputs);
  if (diagram.nonlinear && linear) return DescribeBoth(run, diagram.nonlinear->speed, *linear);
  if (diagram.nonlinear)
    return fmt::format("From {} on hunting of {} can last.", FormatSpeedTwice(diagram.nonlinear->speed), wagon);
  const std::string searched = fmt::format("from {:g} to {:g} m/s", run.options.from, run.options.to);
  const std::string quiet =
      linear ? fmt::format("Above {} {} no longer runs straight by itself", FormatSpeedTwice(*linear), wagon)
             : fmt::format("Small motions of {} die out", wagon);
  return run.continued ? fmt::format("{}; no lasting hunting was found {}.", quiet, searched) : quiet + ".";
}

std::string DescribeTrace(const BifurcationRun& run) {
  if (!run.trace) return "";
  std::string text;
  for (const LegFigures& leg : CalcLegFigures(*run.trace)) {
    const char* const way = leg.to > leg.from ? "faster" : "slower";
    if (leg.onset)
      text += fmt::format("{}getting {}, it begins to hunt at {:.4g} m/s", text.empty() ? "" : "; ", way, *leg.onset);
    if (leg.death)
      text += fmt::format("{}getting {}, it stops at {:.4g} m/s", text.empty() ? "" : "; ", way, *leg.death);
  }
  return text.empty() ? "In the trace nothing begins or ends." : "In the trace: " + text + ".";
}

// ---------------------------------------------------------------- by another parameter, of attractors

std::string DescribeByParameter(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  std::string stable;
  for (const EquilibriumStretch& stretch : ListEquilibriumStretches(diagram, run.options))
    if (stretch.unstable <= 0)
      stable += fmt::format("{}from {:.4g} to {:.4g}", stable.empty() ? "" : " and ", stretch.from, stretch.to);
  const std::string unit = diagram.parameter.unit == "-" ? "" : " " + diagram.parameter.unit;
  return fmt::format("At {}, with {} from {:g} to {:g}{}, {} {}.", FormatSpeedTwice(*diagram.parameter.speed),
                     LabelOf(diagram.parameter), run.options.from, run.options.to, unit,
                     DescribeLoadedWagon(run.inputs),
                     stable.empty() ? "never runs straight by itself" : "runs straight by itself " + stable + unit);
}

std::string DescribeSurvey(const AttractorSurvey& survey, const WagonInputs& inputs) {
  const auto describe = [](const Attractor& attractor) {
    return fmt::format("{}, front wheelset {:.2f} mm to either side", DescribeMotion(attractor.typical),
                       1e3 * attractor.typical.half_width[static_cast<std::size_t>(TrackedMotion::kFrontLateral)]);
  };
  std::string text = fmt::format("At {} {} start states of {} led to", FormatSpeedTwice(survey.V), survey.runs.size(),
                                 DescribeLoadedWagon(inputs));
  if (survey.attractors.empty()) return text + " no motion that lasts.";
  if (survey.attractors.size() == 1) return text + " one and the same motion: " + describe(survey.attractors[0]) + ".";
  text += fmt::format(" {} different motions:", survey.attractors.size());
  for (std::size_t i = 0; i < survey.attractors.size(); ++i)
    text += fmt::format("{} {:.0f} % {}", i == 0 ? "" : ";", 100 * survey.attractors[i].share,
                        describe(survey.attractors[i]));
  return text + ".";
}

std::string DescribeBounds(const PageBounds& bounds) {
  if (bounds.scatter == nullptr || bounds.all->empty() || !bounds.all->front().exists()) return "";
  const ScalarBounds& speed = bounds.all->front();
  return fmt::format("With what is known of the links, 95 % of the draws have the {} between {:.4g} and {:.4g} {}.",
                     speed.name, speed.low.value, speed.high.value, speed.unit);
}

std::string DescribeBifurcation(const BifurcationRun& run, const PageBounds& bounds) {
  std::vector<std::string> sentences;
  if (run.interrupted) sentences.emplace_back("Interrupted: this is what was done.");
  if (run.survey) sentences.push_back(DescribeSurvey(*run.survey, run.inputs));
  if (!run.diagram.parameter.is_speed()) {
    sentences.push_back(DescribeByParameter(run));
  } else if (!run.survey) {
    sentences.push_back(DescribeBySpeed(run));
  }
  sentences.insert(sentences.end(), {DescribeTrace(run), DescribeLargest(run.diagram), DescribeBounds(bounds)});
  return JoinSentences(sentences);
}

// ---------------------------------------------------------------- figures

/// Start states by where they led to.
Figure SurveyFigure(const AttractorSurvey& survey) {
  const std::vector<FigureMark> marks{FigureMark::kDisc, FigureMark::kTriangle, FigureMark::kSquare, FigureMark::kCross,
                                      FigureMark::kCircle};
  FigurePanel starts{.title = "start states",
                     .x = {.label = "front wheelset, lateral", .unit = "mm"},
                     .y = {.label = "body, lateral", .unit = "mm"}};
  FigurePanel ends{.title = "where they led to",
                   .x = {.label = "front wheelset, half of peak to peak", .unit = "mm", .low = 0},
                   .y = {.label = "body, half of peak to peak", .unit = "mm", .low = 0}};
  for (std::size_t i = 0; i < survey.attractors.size(); ++i) {
    FigureSeries from{.name = fmt::format("{}: {}", i + 1, DescribeMotion(survey.attractors[i].typical)),
                      .line = FigureLine::kNone,
                      .mark = marks[i % marks.size()]};
    FigureSeries to = from;
    to.name.clear();
    for (const std::size_t run : survey.attractors[i].runs) {
      const RunOutcome& outcome = survey.runs[run];
      from.x.push_back(1e3 * outcome.start.front_y);
      from.y.push_back(1e3 * outcome.start.body_y);
      to.x.push_back(1e3 * outcome.half_width[static_cast<std::size_t>(TrackedMotion::kFrontLateral)]);
      to.y.push_back(1e3 * outcome.half_width[static_cast<std::size_t>(TrackedMotion::kBodyLateral)]);
    }
    starts.series.push_back(std::move(from));
    ends.series.push_back(std::move(to));
  }
  Figure figure{
      .title = fmt::format("attractors at {:g} m/s", survey.V), .columns = 2, .width = 1200, .panel_height = 380};
  if (!starts.series.empty()) figure.panels = {std::move(starts), std::move(ends)};
  return figure;
}

void AddDiagram(const BifurcationRun& run, WagonBook* book) {
  if (!run.continued && !run.trace) return;
  const BifurcationDiagram& diagram = run.diagram;
  book->page().Heading(2, "The diagram", "diagram");
  book->Draw("bifurcation", DiagramFigure(run),
             "Half of peak to peak of every motion that was found. Solid blue: it lasts; dashed orange-red: it is a "
             "border between motions that last. Small marks: the trace, speed up and down step by step.");
  if (!diagram.branches.empty()) {
    book->page().Table("Branches of hunting", MakeBranchTable(diagram));
    book->page().Table("Their stretches, half widths", MakeStretchTable(diagram));
  }
  if (const TextTable events = MakeEventTable(diagram); !events.rows().empty())
    book->page().Table("What happens on the branches", events);
  if (!diagram.windows.empty()) book->page().Table("Hunting that lies on no branch", MakeWindowTable(diagram));
  if (run.trace) book->page().Table("Legs of the trace", MakeTraceTable(*run.trace));
}

}  // namespace

std::string ComposeBifurcationPage(const BifurcationRun& run, const PageBounds& bounds, const PageOrigin& origin) {
  WagonBook book("Hunting: " + DescribeWagonOnRails(run.inputs), origin);
  book.Answer(DescribeBifurcation(run, bounds));
  book.Notices(run.inputs.notices);
  book.Notices(run.diagram.notices);
  AddDiagram(run, &book);
  if (run.survey) {
    book.page().Heading(2, "Attractors", "attractors");
    book.page().Paragraph(DescribeStarts(*run.survey, run.survey_options));
    book.Draw("attractors", SurveyFigure(*run.survey), "Each mark is a start state, by the motion that it led to.");
    book.page().Table("Motions that last", MakeSurveyTable(*run.survey));
  }
  if (const Figure multipliers = MultiplierFigure(run); !multipliers.panels.empty()) {
    book.page().Heading(2, "Multipliers", "multiplier-section");
    book.Draw(
        "multipliers", multipliers,
        "By how much a small disturbance of a cycle grows in a period: above one (grey line) the cycle does not last.");
  }
  book.Bounds("nonlinear critical speed, " + run.inputs.freight.name, bounds);
  return book.Finish(run.inputs);
}

}  // namespace uiclink
