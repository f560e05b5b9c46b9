#pragma once

#include <string>
#include <vector>

#include "reports/csv.h"
#include "reports/text_table.h"
#include "vehicle/hunting/attractors.h"

namespace uiclink {

/// Attractors with their shares, for a terminal.
std::string FormatSurvey(const AttractorSurvey& survey, const AttractorOptions& options);
/// Parts of it: what the start states were, and a row for each attractor.
std::string DescribeStarts(const AttractorSurvey& survey, const AttractorOptions& options);
TextTable MakeSurveyTable(const AttractorSurvey& survey);
/// A row for every start state: displacements, which attractor it led to (0: none), half widths; millimetres and
/// milliradians.
std::vector<DataColumn> SurveyColumns(const AttractorSurvey& survey);

/// "periodic, twice round", "modulated, 8.1 s", ...
std::string DescribeMotion(const RunOutcome& run);

}  // namespace uiclink
