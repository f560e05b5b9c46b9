#pragma once

#include <nlohmann/json_fwd.hpp>

#include "identify/diagnosis.h"

namespace uiclink {

/// Parts of the JSON of schema "identify/1", for the files that write it.
using Json = nlohmann::ordered_json;

Json OrNull(double value);  ///< null where it is not finite: JSON has no infinity
Json ToJson(const Estimate& estimate);
Json DiagnosisToJson(const Identification& id, const Diagnosis& diagnosis);
Json ExtendedToJson(const Identification& id, const ExtendedResult& extended);

}  // namespace uiclink
