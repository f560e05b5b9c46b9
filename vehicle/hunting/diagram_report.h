#pragma once

#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/diagram.h"
#include "vehicle/hunting/trace_report.h"
#include "vehicle/stability_report.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// What `wagon bifurcation` has found, with what it stands on.
struct BifurcationRun {
  const WagonInputs& inputs;
  std::string method;  ///< "continuation", "trace", "both", "attractors"
  DiagramOptions options = {};
  BifurcationDiagram diagram = {};  ///< without continuation: `linear` and `hopfs` alone
  bool continued = false;           ///< the diagram was made
  std::optional<TraceRun> trace = {};
  std::optional<AttractorSurvey> survey = {};
  AttractorOptions survey_options = {};
  bool interrupted = false;
  double wall_s = 0;
};

/// Part of the range on which as many eigenvalues of the running equilibrium are unstable.
struct EquilibriumStretch {
  double from = 0, to = 0;
  int unstable = 0;
};
std::vector<EquilibriumStretch> ListEquilibriumStretches(const BifurcationDiagram& diagram,
                                                         const DiagramOptions& options);

/// A parameter's name without the unit that it may end with: "lateral.k", "lateral clearance".
std::string LabelOf(const DiagramParameter& parameter);

/// Of OpenWindow::leg: "down", "up", "pushed".
const char* WayName(std::size_t leg);

/// Schema "wagon-bifurcation/1" (vehicle/README.md).
std::string FormatBifurcationJson(const BifurcationRun& run);

/// A page for a terminal, and its tables.
std::string FormatBifurcation(const BifurcationRun& run);
TextTable MakeBranchTable(const BifurcationDiagram& diagram);
TextTable MakeStretchTable(const BifurcationDiagram& diagram);
TextTable MakeEventTable(const BifurcationDiagram& diagram);
TextTable MakeWindowTable(const BifurcationDiagram& diagram);

/// Every point of every branch: speed (and parameter), period, amplitudes, stability, leading multipliers; a row each.
std::vector<DataColumn> BranchColumns(const BifurcationRun& run);

/// Half widths of front, rear and body against speed or parameter: branches, what happens on them, the trace beside
/// them.
Figure DiagramFigure(const BifurcationRun& run);
/// Magnitudes of the leading multipliers likewise, a panel for each branch.
Figure MultiplierFigure(const BifurcationRun& run);

/// Part of a branch on which nothing changes its stability.
struct BranchStretch {
  bool stable = false;
  int unstable = 0;  ///< largest number of unstable multipliers on it
  /// In order along the branch; between two stretches that an event parts, its cycle belongs to both.
  std::vector<const Cycle*> cycles;
  const BranchEvent* begin = nullptr;  ///< what parts it from the one before; null: an end of the branch, or unknown
  const BranchEvent* end = nullptr;
};
/// The stretches of a branch, which must outlive them. A fold parts stretches even where both are unstable.
std::vector<BranchStretch> ListStretches(const Branch& branch);

/// "fold", "period doubling", "torus", "branch point", "character".
const char* BranchEventName(BranchEventKind kind);
/// "speed left its range", ...; `reason` of the branch goes with kLost.
std::string DescribeEnd(BranchEnd end, const std::string& reason);

/// The type of a crossing as reports say it.
CrossingType ToCrossingType(const HopfPoint& hopf, const HopfOptions& options);

/// The motions that reports show and by which a trace is compared: lateral of front and rear wheelset and of the body.
inline constexpr std::array<TrackedMotion, 3> kShownMotions{TrackedMotion::kFrontLateral, TrackedMotion::kRearLateral,
                                                            TrackedMotion::kBodyLateral};

/// The branch leaves the range with its hunting still stable: the speed is a bound from above only.
bool IsAtBound(const NonlinearCritical& critical, const DiagramOptions& options);

/// Largest distance of a trivial multiplier from 1, over all points of all branches; 0 without any.
double CalcWorstTrivialError(const BifurcationDiagram& diagram);

}  // namespace uiclink
