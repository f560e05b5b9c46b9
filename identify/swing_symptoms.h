#pragma once

#include <span>

#include "identify/symptoms.h"

namespace uiclink {

/// Symptoms that show at turns and half swings: loss and frequency against amplitude, frequency against time, the three
/// readings of T0, mid-line and rest, harmonics, decay exponent; and their curves.
void FindSwingSymptoms(std::span<const SymptomInput> records, Symptoms* symptoms);

}  // namespace uiclink
