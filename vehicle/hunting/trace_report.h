#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/text_table.h"
#include "vehicle/hunting/trace.h"

namespace uiclink {

/// A trace, all of it: rows of earlier calls and of this one.
struct TraceRun {
  TraceOptions options;
  std::vector<TraceRow> rows;
  bool complete = false;
  std::string end_reason;  ///< Trace::end_reason
  double wall_s = 0;       ///< of all calls
};

/// Where hunting sets in and dies on one leg, by the front wheelset's half width (FindTraceJumps).
struct LegFigures {
  double from = 0, to = 0;      ///< first and last speed [m/s]
  std::optional<double> onset;  ///< first speed with hunting after one without [m/s]
  std::optional<double> death;  ///< first speed without hunting after the last one with [m/s]
  double largest = 0;           ///< half width of the front wheelset on the leg [m]
  double at = 0;                ///< speed of it [m/s]
};
std::vector<LegFigures> CalcLegFigures(const TraceRun& run);

/// Jumps of a trace less those of the diagram [m/s]: what waiting for so short a time costs.
struct TraceDelay {
  std::optional<double> onset;  ///< first onset on a leg upwards less the linear critical speed
  std::optional<double> death;  ///< death on the first leg downwards less the nonlinear critical speed
};
TraceDelay CalcTraceDelay(const std::vector<LegFigures>& legs, std::optional<double> linear_critical,
                          std::optional<double> nonlinear_critical);

/// Table of the legs, for a terminal.
std::string FormatTraceLegs(const TraceRun& run);
TextTable MakeTraceTable(const TraceRun& run);
/// A row for every speed; millimetres and milliradians.
std::vector<DataColumn> TraceColumns(const std::vector<TraceRow>& rows);

}  // namespace uiclink
