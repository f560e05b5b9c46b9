// Figures of the diagram.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "vehicle/hunting/diagram_report.h"

namespace uiclink {
namespace {

constexpr double kGap = std::numeric_limits<double>::quiet_NaN();
/// Panels of multipliers: more branches than this fill no page that one reads.
constexpr std::size_t kMostPanels = 6;

double Millimetres(const Cycle& cycle, TrackedMotion motion) { return 1e3 * cycle.Amplitude(static_cast<int>(motion)); }

/// The stable or the unstable parts of all branches, with gaps between them.
FigureSeries BranchSeries(const BifurcationDiagram& diagram, TrackedMotion motion, bool stable) {
  FigureSeries series{.name = stable ? "stable hunting" : "unstable",
                      .line = stable ? FigureLine::kSolid : FigureLine::kDashed,
                      .colour = stable ? FigureColour::kBlue : FigureColour::kVermilion,
                      .width = stable ? 2.2 : 1.4};
  for (const HuntingBranch& hunting : diagram.branches) {
    for (const BranchStretch& stretch : ListStretches(hunting.branch)) {
      if (stretch.stable != stable) continue;
      for (const Cycle* const cycle : stretch.cycles) {
        series.x.push_back(cycle->lambda);
        series.y.push_back(Millimetres(*cycle, motion));
      }
      series.x.push_back(kGap);
      series.y.push_back(kGap);
    }
  }
  return series;
}

struct EventMark {
  BranchEventKind kind;
  FigureMark mark;
  FigureColour colour;
};
constexpr std::array<EventMark, 4> kEventMarks{
    {{BranchEventKind::kFold, FigureMark::kDisc, FigureColour::kBlack},
     {BranchEventKind::kTorus, FigureMark::kTriangle, FigureColour::kGreen},
     {BranchEventKind::kPeriodDoubling, FigureMark::kCross, FigureColour::kPurple},
     {BranchEventKind::kBranchPoint, FigureMark::kCircle, FigureColour::kPurple}}};

FigureSeries EventSeries(const BifurcationDiagram& diagram, TrackedMotion motion, const EventMark& mark) {
  FigureSeries series{
      .name = BranchEventName(mark.kind), .line = FigureLine::kNone, .mark = mark.mark, .colour = mark.colour};
  for (const HuntingBranch& hunting : diagram.branches) {
    for (const BranchEvent& event : hunting.branch.events) {
      if (event.kind != mark.kind) continue;
      series.x.push_back(event.lambda);
      series.y.push_back(Millimetres(event.cycle, motion));
    }
  }
  return series;
}

FigureSeries HopfSeries(const BifurcationDiagram& diagram) {
  FigureSeries series{
      .name = "Hopf", .line = FigureLine::kNone, .mark = FigureMark::kSquare, .colour = FigureColour::kBlack};
  for (const HopfPoint& hopf : diagram.hopfs) {
    series.x.push_back(hopf.crossing.V);
    series.y.push_back(0);
  }
  return series;
}

/// The running equilibrium: where its linearisation is stable, or where it is not.
FigureSeries EquilibriumSeries(const BifurcationRun& run, bool stable) {
  FigureSeries series{.name = "",
                      .line = stable ? FigureLine::kSolid : FigureLine::kDashed,
                      .colour = stable ? FigureColour::kBlue : FigureColour::kVermilion,
                      .width = stable ? 2.2 : 1.4};
  for (const EquilibriumStretch& stretch : ListEquilibriumStretches(run.diagram, run.options)) {
    if ((stretch.unstable <= 0) != stable) continue;
    series.x.insert(series.x.end(), {stretch.from, stretch.to, kGap});
    series.y.insert(series.y.end(), {0, 0, kGap});
  }
  return series;
}

FigureSeries TraceSeries(const std::vector<TraceRow>& rows, TrackedMotion motion, bool up) {
  constexpr std::size_t kDense = 200;  // points so near each other that dots make a line
  FigureSeries series{.name = up ? "trace up" : "trace down",
                      .line = FigureLine::kNone,
                      .mark = rows.size() > kDense ? FigureMark::kDot
                              : up                 ? FigureMark::kTriangle
                                                   : FigureMark::kCircle,
                      .colour = up ? FigureColour::kOrange : FigureColour::kSky};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    // The way is that of the step to a speed; of the first speed, that of the step from it.
    const std::size_t to = i > 0 ? i : 1;
    if (to >= rows.size() || (rows[to].V > rows[to - 1].V) != up) continue;
    series.x.push_back(rows[i].V);
    series.y.push_back(1e3 * rows[i].half_width[static_cast<std::size_t>(motion)]);
  }
  return series;
}

FigureAxis ParameterAxis(const DiagramParameter& parameter) {
  return {.label = LabelOf(parameter), .unit = parameter.unit == "-" ? "" : parameter.unit};
}

FigurePanel MakePanel(const BifurcationRun& run, TrackedMotion motion, const std::string& title) {
  const BifurcationDiagram& diagram = run.diagram;
  FigurePanel panel{.title = title,
                    .x = ParameterAxis(diagram.parameter),
                    .y = {.label = "half of peak to peak", .unit = "mm"},
                    .series = {}};
  panel.x.low = run.options.from;
  panel.x.high = run.options.to;
  const auto add = [&panel](FigureSeries series) {
    if (!series.x.empty()) panel.series.push_back(std::move(series));
  };
  const std::vector<TraceRow>& rows = run.trace ? run.trace->rows : diagram.trace;
  add(EquilibriumSeries(run, true));
  add(EquilibriumSeries(run, false));
  add(BranchSeries(diagram, motion, true));
  add(BranchSeries(diagram, motion, false));
  add(TraceSeries(rows, motion, true));
  add(TraceSeries(rows, motion, false));
  add(HopfSeries(diagram));
  for (const EventMark& mark : kEventMarks) add(EventSeries(diagram, motion, mark));
  double largest = 0;
  for (const FigureSeries& series : panel.series)
    for (const double y : series.y)
      if (y > largest) largest = y;
  panel.y.low = -0.04 * std::max(largest, 0.01);  // the line of the equilibrium stands clear of the frame
  return panel;
}

/// Magnitudes by falling size, the trivial one apart; a pair counts once.
std::vector<double> ListMagnitudes(const Cycle& cycle) {
  std::vector<double> magnitudes;
  for (std::size_t i = 1; i < cycle.multipliers.size(); ++i)
    if (cycle.multipliers[i].imag() >= 0) magnitudes.push_back(std::abs(cycle.multipliers[i]));
  std::ranges::sort(magnitudes, std::greater{});
  return magnitudes;
}

FigurePanel MakeMultiplierPanel(const HuntingBranch& hunting, std::size_t number, const DiagramParameter& parameter) {
  constexpr double kLinear = 4;  // above it, one that runs away would press the others onto the axis
  FigurePanel panel{.title = fmt::format("branch {}, {}", number, hunting.origin),
                    .x = ParameterAxis(parameter),
                    .y = {.label = "magnitude", .low = 0},
                    .series = {{.name = "largest"}, {.name = "second"}, {.name = "third"}, {.name = "fourth"}},
                    .horizontal_guides = {{1, ""}}};
  double largest = 0;
  for (const Cycle& cycle : hunting.branch.points) {
    const std::vector<double> magnitudes = ListMagnitudes(cycle);
    for (std::size_t rank = 0; rank < panel.series.size(); ++rank) {
      panel.series[rank].x.push_back(cycle.lambda);
      panel.series[rank].y.push_back(rank < magnitudes.size() ? magnitudes[rank] : kGap);
    }
    if (!magnitudes.empty()) largest = std::max(largest, magnitudes[0]);
  }
  if (largest > kLinear) {
    panel.y.log = true;
    panel.y.low = 0.1;
  }
  return panel;
}

}  // namespace

Figure DiagramFigure(const BifurcationRun& run) {
  const std::optional<double>& speed = run.diagram.parameter.speed;
  Figure figure{.title = fmt::format("{}, {}, {}{}", run.inputs.data.name, run.inputs.freight.name,
                                     run.inputs.table.name, speed ? fmt::format(", {:g} m/s", *speed) : ""),
                .panels = {},
                .width = 800,
                .panel_height = 330};
  figure.panels.push_back(MakePanel(run, TrackedMotion::kFrontLateral, "front wheelset, lateral"));
  figure.panels.push_back(MakePanel(run, TrackedMotion::kRearLateral, "rear wheelset, lateral"));
  figure.panels.push_back(MakePanel(run, TrackedMotion::kBodyLateral, "body, lateral"));
  for (std::size_t i = 1; i < figure.panels.size(); ++i)  // one legend serves all
    for (FigureSeries& series : figure.panels[i].series) series.name.clear();
  return figure;
}

Figure MultiplierFigure(const BifurcationRun& run) {
  Figure figure{.title = "multipliers, the trivial one apart", .panels = {}, .width = 800, .panel_height = 300};
  for (std::size_t i = 0; i < run.diagram.branches.size() && figure.panels.size() < kMostPanels; ++i) {
    const HuntingBranch& hunting = run.diagram.branches[i];
    if (hunting.branch.points.size() < 2) continue;
    figure.panels.push_back(MakeMultiplierPanel(hunting, i + 1, run.diagram.parameter));
  }
  return figure;
}

}  // namespace uiclink
