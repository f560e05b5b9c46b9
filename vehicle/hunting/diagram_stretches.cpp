// What a branch consists of.

#include <fmt/format.h>

#include <algorithm>

#include "vehicle/hunting/diagram_report.h"

namespace uiclink {
namespace {

bool PartsStretches(BranchEventKind kind) {
  return kind != BranchEventKind::kCharacter && kind != BranchEventKind::kBranchPoint;
}

/// The event between a point and the next that parts them; null where none was found.
const BranchEvent* FindParting(const Branch& branch, std::size_t point) {
  const auto event = std::ranges::find_if(
      branch.events, [&](const BranchEvent& e) { return e.point == point && PartsStretches(e.kind); });
  return event != branch.events.end() ? &*event : nullptr;
}

}  // namespace

std::vector<BranchStretch> ListStretches(const Branch& branch) {
  std::vector<BranchStretch> stretches;
  for (std::size_t i = 0; i < branch.points.size(); ++i) {
    const Cycle& cycle = branch.points[i];
    const BranchEvent* const event = i > 0 ? FindParting(branch, i - 1) : nullptr;
    if (stretches.empty() || event != nullptr || stretches.back().stable != cycle.stable()) {
      BranchStretch next{.stable = cycle.stable(), .unstable = 0, .cycles = {}, .begin = event, .end = nullptr};
      if (!stretches.empty()) stretches.back().end = event;
      if (event != nullptr) {
        stretches.back().cycles.push_back(&event->cycle);
        next.cycles.push_back(&event->cycle);
      }
      stretches.push_back(std::move(next));
    }
    stretches.back().cycles.push_back(&cycle);
    stretches.back().unstable = std::max(stretches.back().unstable, cycle.unstable);
  }
  return stretches;
}

std::vector<EquilibriumStretch> ListEquilibriumStretches(const BifurcationDiagram& diagram,
                                                         const DiagramOptions& options) {
  std::vector<EquilibriumStretch> stretches;
  int unstable = diagram.linear.unstable_at_start;
  double from = options.from;
  for (const Crossing& crossing : diagram.linear.crossings) {
    if (crossing.V > options.to) break;
    stretches.push_back({from, crossing.V, unstable});
    from = crossing.V;
    unstable += (crossing.to_unstable ? 1 : -1) * (crossing.frequency_hz > 0 ? 2 : 1);
  }
  stretches.push_back({from, options.to, unstable});
  return stretches;
}

std::string LabelOf(const DiagramParameter& parameter) {
  const std::string suffix = ColumnWord({.name = "x", .unit = parameter.unit, .values = {}}).substr(1);
  std::string label = parameter.name;
  if (!suffix.empty() && label.ends_with(suffix)) label.resize(label.size() - suffix.size());
  if (label.find('.') == std::string::npos) std::ranges::replace(label, '_', ' ');
  return label;
}

const char* WayName(std::size_t leg) { return leg == kPushed ? "pushed" : leg == 0 ? "down" : "up"; }

const char* BranchEventName(BranchEventKind kind) {
  switch (kind) {
    case BranchEventKind::kFold:
      return "fold";
    case BranchEventKind::kPeriodDoubling:
      return "period doubling";
    case BranchEventKind::kTorus:
      return "torus";
    case BranchEventKind::kBranchPoint:
      return "branch point";
    case BranchEventKind::kCharacter:
      return "character";
  }
  return "?";
}

std::string DescribeEnd(BranchEnd end, const std::string& reason) {
  switch (end) {
    case BranchEnd::kRange:
      return "end of the range";
    case BranchEnd::kPoints:
      return "as many points as were allowed";
    case BranchEnd::kEquilibrium:
      return "shrinks to a point";
    case BranchEnd::kLost:
      return "lost: " + reason;
    case BranchEnd::kClosed:
      return "closed";
    case BranchEnd::kStopped:
      return "interrupted";
  }
  return "?";
}

CrossingType ToCrossingType(const HopfPoint& hopf, const HopfOptions& options) {
  return {.type = hopf.type ? HopfTypeName(*hopf.type) : "",
          .decided_at = options.type_size,
          .other_below = hopf.other_below.value_or(0),
          .reason = hopf.reason};
}

bool IsAtBound(const NonlinearCritical& critical, const DiagramOptions& options) {
  const bool ends_there = critical.by == "end of a branch" || critical.by == "trace";
  return ends_there && critical.speed <= options.from * (1 + 1e-9);
}

double CalcWorstTrivialError(const BifurcationDiagram& diagram) {
  double worst = 0;
  for (const HuntingBranch& hunting : diagram.branches)
    for (const Cycle& cycle : hunting.branch.points) worst = std::max(worst, cycle.trivial_error);
  return worst;
}

}  // namespace uiclink
