#pragma once

#include <string>
#include <vector>

#include "reports/figure.h"
#include "reports/text_table.h"
#include "vehicle/hunting/propagation.h"
#include "vehicle/hunting/speed_bounds.h"
#include "vehicle/report_json.h"

namespace uiclink {

/// "95 % bounds and what they come from": a table of scalars, and for each that varies its shares of variance by group.
/// Empty where there are no draws.
std::string FormatBounds(const SetScatter& scatter, const std::vector<ScalarBounds>& all);
/// Parts of it: what was drawn, and a row for each scalar.
std::string DescribeDraws(const SetScatter& scatter);
TextTable MakeBoundsTable(const std::vector<ScalarBounds>& all);
/// What is special to the linear critical speed: first-order bounds, and how much k + sum k_i alone explains.
std::string FormatSpeedBounds(const SetScatter& scatter, const SpeedBounds& bounds);

/// { "value", "low", "high", "mean", "std", errors, "draws", "failed", "failures": [ { "draw", "reason" } ],
///   "shares": { "<group>": .. , "not linear": .. }, "shares_by_parameter": { .. } }; null where there is nothing.
Json BoundsToJson(const ScalarBounds& bounds);
Json SpeedBoundsToJson(const SpeedBounds& bounds);
/// Draws, seed, sampling, coverage and corner scatter that bounds stand on, with the parameters that were drawn.
Json ScatterToJson(const SetScatter& scatter);

/// Each scalar: the draws by rank as a cumulative distribution with bounds, beside the shares of its variance.
Figure BoundsFigure(const std::string& title, const std::vector<ScalarBounds>& all);

/// A row per draw: its parameters, the scalars, and for what failed the reason (comma-separated, RFC 4180).
std::string FormatDraws(const SetScatter& scatter, const std::vector<ScalarBounds>& all);

}  // namespace uiclink
