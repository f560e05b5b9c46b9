#pragma once

#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/trace_report.h"
#include "vehicle/report_json.h"

namespace uiclink {

// Parts of "wagon-bifurcation/1" (vehicle/README.md).

/// Motions by name: amplitudes in mm, yaw and roll in mrad.
Json AmplitudesToJson(const std::array<double, kMotionCount>& half_widths);
Json LyapunovToJson(const std::optional<LyapunovResult>& lyapunov);  ///< null without
/// Kind, returns, periods; modulation_period_s null without.
Json MotionToJson(const SectionMotion& motion);
Json TraceToJson(const TraceRun& run);
Json SurveyToJson(const AttractorSurvey& survey, const AttractorOptions& options);

}  // namespace uiclink
