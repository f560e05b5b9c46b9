#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "vehicle/hunting/attractors.h"
#include "vehicle/hunting/trace.h"
#include "vehicle/report_json.h"

namespace uiclink {

// What a long computation has done so far, as text to go on from: numbers read back bit by bit. `of` says what is
// computed (inputs with their checksums, options, version).

struct TraceProgress {
  TracePoint at;
  std::vector<TraceRow> rows;  ///< at.rows of them
  double wall_s = 0;
};
std::string FormatTraceProgress(const Wagon& wagon, const Json& of, const TraceProgress& progress);
/// None where it is of something else. @throws InputError for what is no such text.
std::optional<TraceProgress> ParseTraceProgress(const std::string& text, const std::string& file, const Wagon& wagon,
                                                const Json& of);

/// Runs of a survey by number of the start state (AttractorOptions::known).
using KnownRuns = std::map<std::size_t, RunOutcome>;
std::string FormatRunProgress(const Wagon& wagon, const Json& of, const KnownRuns& runs);
std::optional<KnownRuns> ParseRunProgress(const std::string& text, const std::string& file, const Wagon& wagon,
                                          const Json& of);

}  // namespace uiclink
