#pragma once

#include "identify/identification.h"

namespace uiclink {

/// Fits the prepared records of a direction with 1 to 4 sliders and keeps the number that the data support.
///
/// A further slider must lower the penalised likelihood (BIC with independent observations, not samples, and 2 log 4
/// for having four numbers to choose from) and, where there are records enough, the rms on records that its shape was
/// not fitted to. `result->choices` says what each number gave.
void ChooseSliders(const IdentifyOptions& options, Identification* result);

}  // namespace uiclink
