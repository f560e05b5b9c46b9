#pragma once

#include <span>

#include "identify/symptoms.h"

namespace uiclink {

/// Do readings stop at a level that the model goes beyond?  The highest (lowest) reading of all records is the level;
/// where the model lies beyond it, nearly every reading must lie at it. One-sided residuals with the record free to
/// move are no limit.  Adds "readings_clipped"; z is that of the mean distance of the model from the level.
void FindReadingLimits(std::span<const SymptomInput> records, Symptoms* symptoms);

}  // namespace uiclink
