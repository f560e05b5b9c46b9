#pragma once

#include <string>
#include <vector>

#include "identify/report.h"
#include "identify/report_json.h"
#include "identify/validate.h"

namespace uiclink {

/// The set of a run as WriteParameterSet writes it to `file`, how wide its bounds are, and whether it can be trusted.
/// @param with_causes  the extended set where causes were named; else that of the plain model.
ValidationSet MakeValidationSet(const RunResult& run, bool with_causes, const std::string& file);

/// The sets on the wagon, a table and what has to be said about it. At most 110 columns.
std::string FormatWagon(const Validation& validation);

/// What was left out of the validation and why, a line each; for standard error.
std::vector<std::string> FormatWagonFailures(const Validation& validation);

/// The key "wagon" of schema "identify/1".
Json WagonToJson(const Validation& validation);

}  // namespace uiclink
