// The diagram as a page for a terminal.

#include "vehicle/hunting/diagram_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <ranges>

#include "reports/text_table.h"
#include "vehicle/hunting/attractor_report.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

/// "[m/s]", "[-]": below a head.
std::string UnitOf(const BifurcationDiagram& diagram) { return "[" + diagram.parameter.unit + "]"; }

std::string FormatPlace(const BifurcationDiagram& diagram, double value) {
  return diagram.parameter.is_speed() ? fmt::format("{:.3f}", value) : fmt::format("{:.6g}", value);
}

std::string FormatSpeed(double V) { return fmt::format("{:.6f} m/s ({:.1f} km/h)", V, 3.6 * V); }
std::string FormatMillimetres(double m) { return fmt::format("{:.3f}", 1e3 * m); }

double AmplitudeOf(const Cycle& cycle, TrackedMotion motion) { return cycle.Amplitude(static_cast<int>(motion)); }

/// "2.780" or "2.780 to 2.803": over a stretch.
std::string FormatRange(const BranchStretch& stretch, double (*value)(const Cycle&), const char* format) {
  const auto [least, greatest] =
      std::ranges::minmax(stretch.cycles | std::views::transform([&](const Cycle* cycle) { return value(*cycle); }));
  const std::string low = fmt::format(fmt::runtime(format), least), high = fmt::format(fmt::runtime(format), greatest);
  return low == high ? low : low + " to " + high;
}

/// What of a character is about guidance: "rear", "front rear"; "" if none is met.
std::string GuidancePart(const std::string& character) {
  constexpr std::string_view kWord = "guidance ";
  const std::size_t at = character.find(kWord);
  return at == std::string::npos ? "" : character.substr(at + kWord.size());
}

/// The character that holds for most of the way in the parameter, and how many others there are.
std::string MainCharacter(const BranchStretch& stretch) {
  std::map<std::string, double> ways;
  for (std::size_t i = 0; i < stretch.cycles.size(); ++i) {
    const double before = i > 0 ? std::abs(stretch.cycles[i]->lambda - stretch.cycles[i - 1]->lambda) : 0;
    ways[stretch.cycles[i]->passage.character] += before;
  }
  const auto main = std::ranges::max_element(ways, {}, [](const auto& way) { return way.second; });
  if (main == ways.end()) return "";
  return ways.size() == 1 ? main->first : fmt::format("{} (and {} others)", main->first, ways.size() - 1);
}

// ---------------------------------------------------------------- critical speeds

std::string FormatLinear(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  std::string text;
  for (const HopfPoint& hopf : diagram.hopfs) {
    const bool critical = diagram.linear.linear_critical_speed == hopf.crossing.V;
    text += fmt::format("{:<26}{}, {:.3f} Hz{}\n", critical ? "Linear critical speed" : "Further crossing",
                        FormatSpeed(hopf.crossing.V), hopf.crossing.frequency_hz,
                        hopf.crossing.to_unstable ? "" : ", to stable");
    const std::string type = FormatCrossingType(ToCrossingType(hopf, run.options.hopf));
    if (!type.empty()) text += fmt::format("{:<26}{}\n", "", type);
  }
  if (diagram.linear.linear_critical_speed && diagram.hopfs.empty())
    text += fmt::format("{:<26}{}\n", "Linear critical speed", FormatSpeed(*diagram.linear.linear_critical_speed));
  if (diagram.linear.unstable_at_start > 0)
    text += fmt::format("{:<26}unstable already at {:g} m/s\n", "Equilibrium", run.options.from);
  if (diagram.linear.crossings.empty() && diagram.linear.unstable_at_start == 0)
    text +=
        fmt::format("{:<26}none from {:g} to {:g} m/s\n", "Linear critical speed", run.options.from, run.options.to);
  return text;
}

/// At a fixed speed: what the equilibrium does over the range, and what is born where that changes.
std::string FormatEquilibrium(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  std::string text;
  for (const EquilibriumStretch& stretch : ListEquilibriumStretches(diagram, run.options))
    text += fmt::format(
        "{:<26}{} from {:.6g} to {:.6g}\n", text.empty() ? "Equilibrium" : "",
        stretch.unstable > 0 ? fmt::format("unstable ({} eigenvalues)", stretch.unstable) : std::string("stable"),
        stretch.from, stretch.to);
  for (const HopfPoint& hopf : diagram.hopfs) {
    text += fmt::format("{:<26}{}, {:.3f} Hz, to {}\n", "Crossing", DescribeValue(diagram.parameter, hopf.crossing.V),
                        hopf.crossing.frequency_hz, hopf.crossing.to_unstable ? "unstable" : "stable");
    const std::string type = FormatCrossingType(ToCrossingType(hopf, run.options.hopf));
    if (!type.empty()) text += fmt::format("{:<26}{}\n", "", type);
  }
  return text;
}

std::string FormatNonlinear(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  if (!run.continued) return "";
  if (!diagram.nonlinear)
    return fmt::format("{:<26}no lasting hunting was found from {:g} to {:g} m/s\n", "Nonlinear critical speed",
                       run.options.from, run.options.to);
  const NonlinearCritical& critical = *diagram.nonlinear;
  const bool at_bound = IsAtBound(critical, run.options);
  const std::string where = critical.by == "trace" ? "lowest speed of the trace that hunts, on no branch"
                            : at_bound ? fmt::format("branch {} goes on below the range", critical.branch + 1)
                                       : fmt::format("{}, branch {}", critical.by, critical.branch + 1);
  std::string text = fmt::format("{:<26}{}{}, {}\n", "Nonlinear critical speed", at_bound ? "at most " : "",
                                 FormatSpeed(critical.speed), where);
  const std::optional<double> linear = diagram.linear.linear_critical_speed;
  if (linear && critical.speed < *linear)
    text += fmt::format("{:<26}hunting can last from {:.2f} m/s, rest is lost at {:.2f} m/s only\n", "Hysteresis",
                        critical.speed, *linear);
  return text;
}

// ---------------------------------------------------------------- branches

void AddStretchRow(const BifurcationDiagram& diagram, const BranchStretch& stretch, std::size_t branch,
                   TextTable* table) {
  table->AddRow(
      {fmt::format("{}", branch + 1), stretch.stable ? "stable" : fmt::format("unstable, {}", stretch.unstable),
       FormatPlace(diagram, stretch.cycles.front()->lambda), FormatPlace(diagram, stretch.cycles.back()->lambda),
       FormatRange(
           stretch, [](const Cycle& c) { return c.period; }, "{:.3f}"),
       FormatRange(
           stretch, [](const Cycle& c) { return 1e3 * AmplitudeOf(c, TrackedMotion::kFrontLateral); }, "{:.2f}"),
       FormatRange(
           stretch, [](const Cycle& c) { return 1e3 * AmplitudeOf(c, TrackedMotion::kRearLateral); }, "{:.2f}"),
       FormatRange(
           stretch, [](const Cycle& c) { return 1e3 * AmplitudeOf(c, TrackedMotion::kBodyLateral); }, "{:.2f}"),
       stretch.end ? BranchEventName(stretch.end->kind) : "", MainCharacter(stretch)});
}

// ---------------------------------------------------------------- events

/// A change of character that an engineer looks for: guidance is met, or no longer. "" for any other.
std::string GuidanceChange(const BranchEvent& event) {
  const std::size_t arrow = event.text.find(" -> ");
  if (arrow == std::string::npos) return "";
  const std::string before = GuidancePart(event.text.substr(0, arrow));
  const std::string after = GuidancePart(event.text.substr(arrow + 4));
  const auto name = [](const std::string& part) { return part.empty() ? std::string("none") : part; };
  return before == after ? "" : fmt::format("{} -> {}", name(before), name(after));
}

/// At a torus point: the period of the modulation that is born, 2 pi T/theta of the pair on the unit circle [s].
std::string FormatModulation(const BranchEvent& event) {
  double best = 1, angle = 0;
  for (const std::complex<double>& multiplier : event.cycle.multipliers) {
    if (multiplier.imag() <= 0 || std::abs(std::abs(multiplier) - 1) >= best) continue;
    best = std::abs(std::abs(multiplier) - 1);
    angle = std::arg(multiplier);
  }
  return angle > 0 ? fmt::format("modulation of {:.3g} s", 2 * std::numbers::pi * event.period / angle) : "";
}

// ---------------------------------------------------------------- windows

std::string FormatExponent(const std::optional<LyapunovResult>& lyapunov) {
  return lyapunov ? fmt::format("{:.4f} +- {:.4f}", lyapunov->exponent, lyapunov->error) : "-";
}

std::string FormatWindows(const BifurcationDiagram& diagram) {
  if (diagram.windows.empty()) return "";
  return std::string(diagram.parameter.is_speed() ? "\nTraced" : "\nPushed") +
         " hunting that lies on no branch (looked at by its section)\n" + MakeWindowTable(diagram).Format();
}

std::string FormatEvents(const BifurcationDiagram& diagram) {
  const TextTable table = MakeEventTable(diagram);
  return table.rows().empty() ? "" : "\nWhat happens on the branches\n" + table.Format();
}

// ---------------------------------------------------------------- accuracy, trace

std::string FormatAccuracy(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  const bool by_speed = diagram.parameter.is_speed();
  long passages = 0, with_derivatives = 0;
  for (const HuntingBranch& hunting : diagram.branches) {
    passages += hunting.branch.passages;
    with_derivatives += hunting.branch.passages_with_derivatives;
  }
  return fmt::format(
      "\nAccuracy: every trivial multiplier is within {:.1e} of 1; cycles close to {:.0e} mm or mrad (root mean "
      "square);\n"
      "events are located to {} on their branch. Joints that never slip keep what the start has left in them, and\n"
      "{} of events depend on that. Half widths: half of peak to peak over a period.\n"
      "Computing: {:.1f} s; {} passages of a period, {} of them with derivatives{}.\n",
      CalcWorstTrivialError(diagram), run.options.tolerance, by_speed ? "1e-6 m/s" : "1e-7 of the range",
      by_speed ? "speeds" : "values", diagram.wall_s, passages, with_derivatives,
      by_speed ? fmt::format("; coarse trace ({:g} m/s, {:g} s a\nspeed) {:.1f} s for {:g} s", run.options.trace_step,
                             run.options.trace_hold, diagram.trace_wall_s, diagram.traced_s)
               : "");
}

/// "8 to 30 m/s", "lateral.k 3 to 6 1/m (own value 4.201) at 24 m/s".
std::string FormatRangeOfDiagram(const BifurcationRun& run) {
  const DiagramParameter& parameter = run.diagram.parameter;
  if (parameter.is_speed()) return fmt::format("{:g} to {:g} m/s", run.options.from, run.options.to);
  return fmt::format("{} {:g} to {:g} {} (own value {:g}) at {:g} m/s", parameter.name, run.options.from,
                     run.options.to, parameter.unit, parameter.own, *parameter.speed);
}

std::string FormatDelay(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  const TraceDelay delay = CalcTraceDelay(CalcLegFigures(*run.trace), diagram.linear.linear_critical_speed,
                                          diagram.nonlinear ? std::optional(diagram.nonlinear->speed) : std::nullopt);
  std::string text;
  if (delay.onset)
    text += fmt::format("Onset on the way up less the linear critical speed: {:+.2f} m/s.\n", *delay.onset);
  if (delay.death)
    text += fmt::format("Death on the way down less the nonlinear critical speed: {:+.2f} m/s.\n", *delay.death);
  return text;
}

}  // namespace

TextTable MakeBranchTable(const BifurcationDiagram& diagram) {
  TextTable table;
  table.AddColumn("no");
  table.AddColumn("branch", TextTable::Align::kLeft);
  table.AddColumn("points");
  table.AddColumn((diagram.parameter.is_speed() ? "speeds\n" : "values\n") + UnitOf(diagram));
  table.AddColumn("ends", TextTable::Align::kLeft);
  for (std::size_t i = 0; i < diagram.branches.size(); ++i) {
    const HuntingBranch& hunting = diagram.branches[i];
    const auto [low, high] = std::ranges::minmax(hunting.branch.points | std::views::transform(&Cycle::lambda));
    std::string ends = DescribeEnd(hunting.branch.end, hunting.branch.reason);
    if (hunting.branch.begin) ends = DescribeEnd(*hunting.branch.begin, hunting.branch.begin_reason) + "; " + ends;
    table.AddRow({fmt::format("{}", i + 1), hunting.origin, fmt::format("{}", hunting.branch.points.size()),
                  FormatPlace(diagram, low) + " to " + FormatPlace(diagram, high), ends});
  }
  return table;
}

TextTable MakeStretchTable(const BifurcationDiagram& diagram) {
  TextTable table;
  table.AddColumn("no");
  table.AddColumn("", TextTable::Align::kLeft);
  for (const char* head : {"from\n", "to\n"}) table.AddColumn(head + UnitOf(diagram));
  for (const char* head : {"period\n[s]", "front\n[mm]", "rear\n[mm]", "body\n[mm]"}) table.AddColumn(head);
  table.AddColumn("ends with", TextTable::Align::kLeft);
  table.AddColumn("joints that slip in a period, guidance that is met", TextTable::Align::kLeft);
  for (std::size_t i = 0; i < diagram.branches.size(); ++i) {
    if (i > 0) table.AddRule();
    for (const BranchStretch& stretch : ListStretches(diagram.branches[i].branch))
      AddStretchRow(diagram, stretch, i, &table);
  }
  return table;
}

TextTable MakeEventTable(const BifurcationDiagram& diagram) {
  TextTable table;
  table.AddColumn("no");
  table.AddColumn("event", TextTable::Align::kLeft);
  table.AddColumn((diagram.parameter.is_speed() ? "speed\n" : "value\n") + UnitOf(diagram));
  for (const char* head : {"period\n[s]", "front\n[mm]", "rear\n[mm]", "body\n[mm]"}) table.AddColumn(head);
  table.AddColumn("", TextTable::Align::kLeft);
  for (std::size_t i = 0; i < diagram.branches.size(); ++i) {
    for (const BranchEvent& event : diagram.branches[i].branch.events) {
      const bool character = event.kind == BranchEventKind::kCharacter;
      const std::string remark = character                               ? GuidanceChange(event)
                                 : event.kind == BranchEventKind::kTorus ? FormatModulation(event)
                                 : event.at_corner                       ? "at a corner of the branch"
                                                                         : "";
      if (character && remark.empty()) continue;
      table.AddRow({fmt::format("{}", i + 1), character ? "guidance" : BranchEventName(event.kind),
                    fmt::format(fmt::runtime(diagram.parameter.is_speed() ? "{:.6f}" : "{:.8g}"), event.lambda),
                    fmt::format("{:.4f}", event.period),
                    FormatMillimetres(AmplitudeOf(event.cycle, TrackedMotion::kFrontLateral)),
                    FormatMillimetres(AmplitudeOf(event.cycle, TrackedMotion::kRearLateral)),
                    FormatMillimetres(AmplitudeOf(event.cycle, TrackedMotion::kBodyLateral)), remark});
    }
  }
  return table;
}

TextTable MakeWindowTable(const BifurcationDiagram& diagram) {
  TextTable table;
  for (const char* head : {"from\n", "to\n"}) table.AddColumn(head + UnitOf(diagram));
  table.AddColumn("way", TextTable::Align::kLeft);
  table.AddColumn("at\n" + UnitOf(diagram));
  table.AddColumn("motion\n(period of modulation)", TextTable::Align::kLeft);
  for (const char* head : {"front\n[mm]", "rear\n[mm]", "body\n[mm]", "Lyapunov exponent\n[1/s]"})
    table.AddColumn(head);
  table.AddColumn("why no branch passes", TextTable::Align::kLeft);
  for (const OpenWindow& window : diagram.windows) {
    const auto& half_width = window.outcome.half_width;
    table.AddRow({FormatPlace(diagram, window.from), FormatPlace(diagram, window.to), WayName(window.leg),
                  FormatPlace(diagram, window.speed), DescribeMotion(window.outcome),
                  FormatMillimetres(half_width[static_cast<std::size_t>(TrackedMotion::kFrontLateral)]),
                  FormatMillimetres(half_width[static_cast<std::size_t>(TrackedMotion::kRearLateral)]),
                  FormatMillimetres(half_width[static_cast<std::size_t>(TrackedMotion::kBodyLateral)]),
                  FormatExponent(window.lyapunov), window.why});
  }
  return table;
}

std::string FormatBifurcation(const BifurcationRun& run) {
  const BifurcationDiagram& diagram = run.diagram;
  std::string text = fmt::format("{}, cargo {}, contact {}, {}\n", run.inputs.data.name, run.inputs.freight.name,
                                 run.inputs.table.name, FormatRangeOfDiagram(run)) +
                     FormatSets(run.inputs) + "\n" +
                     (diagram.parameter.is_speed() ? FormatLinear(run) + FormatNonlinear(run) : FormatEquilibrium(run));
  if (!diagram.branches.empty())
    text += "\nBranches of hunting\n" + MakeBranchTable(diagram).Format() + "\nStretches (half widths)\n" +
            MakeStretchTable(diagram).Format();
  text += FormatEvents(diagram) + FormatWindows(diagram);
  if (run.continued) text += FormatAccuracy(run);
  if (run.trace) text += "\nTrace\n" + FormatTraceLegs(*run.trace) + FormatDelay(run);
  if (run.survey) text += "\nAttractors\n" + FormatSurvey(*run.survey, run.survey_options);
  if (run.interrupted) text += "\nInterrupted: this is what was done.\n";
  return text;
}

}  // namespace uiclink
