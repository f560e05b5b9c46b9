#pragma once

#include <span>

#include "identify/symptoms.h"

namespace uiclink {

/// What the residual (record less model) depends on: means over bins of displacement, velocity, phase of the motion and
/// time since the first extremum; whether it is white, how large it is, and whether readings stop at a level.
///
/// The error of a bin's mean respects the residual's own correlation: its variance, never below that of the noise,
/// over as many observations as are independent (CalcEffectiveSize). Such z are smaller than those of read-outs.
void FindResidualPatterns(std::span<const SymptomInput> records, Symptoms* symptoms);

}  // namespace uiclink
