#pragma once

#include "identify/diagnosis.h"

namespace uiclink {

/// What the fits of a finished diagnosis get wrong: fills `symptoms`, `symptoms_left`, `missing_force` and the repairs
/// of the causes.  Never throws for what is in the records.
void DescribeSymptoms(const Identification& plain, Diagnosis* diagnosis);

/// Does a word of Effect::repairs mean this symptom?  The catalogue, which knows no read-outs, speaks of families
/// ("even_harmonics"); a word is either such a family or how the symptom's id begins.
bool IsRepairOf(std::string_view word, std::string_view symptom);

}  // namespace uiclink
