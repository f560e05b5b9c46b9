#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// Parts of the JSON of the schemas "wagon-.../1".
using Json = nlohmann::ordered_json;

Json NumberOrNull(double value);  ///< null where it is not finite: JSON has no infinity

/// What a result stands on: files with their checksums, options, the body that they make, notices.
/// Parts that were not read (ReadWagonBody alone, say) are left out.
Json InputsToJson(const WagonInputs& inputs);

/// { "schema": "wagon-<command>/1", "version": ..., "inputs": ... }, to be filled with results.
Json BeginResult(const std::string& command, const WagonInputs& inputs);

/// "links: set 1 (data/parameter_sets/set1.toml)", a line for each set, with the links that it is used for where there
/// are several; for a terminal.
std::string FormatSets(const WagonInputs& inputs);

/// As the programs print it: indented by 2, a line end last.
std::string FormatJson(const Json& json);

// The words of options, in JSON and on the command line.
const char* Name(Suspension suspension);    ///< "linear", "parabolic", "leaf"
const char* Name(Penetration penetration);  ///< "touching", "printed"
const char* Name(CentreOfMass com);         ///< "printed", "corrected"
const char* Name(Partitions partitions);    ///< "at-ends", "spread"
const char* Name(ContactModel contact);     ///< "rigid", "elastic"

}  // namespace uiclink
