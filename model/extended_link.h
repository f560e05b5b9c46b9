#pragma once

#include "model/extended_oscillator.h"
#include "model/parameter_set.h"

namespace uiclink {

/// The oscillator of one direction of an extended parameter set: its link with every effect on the mechanics that the
/// set lists. Effects on the reading are left out; an effect at its neutral size adds nothing, whatever its other
/// parameters are. Written for T = double and Dual<6> (whose derivatives are all zero).
///
/// @throws std::invalid_argument for an effect that is not in the catalogue, a parameter that an effect does not have,
///         lacks, has twice or has outside its bounds, a slider that is not k >= 0, T0 >= 0 (both finite), and for more
///         sliders, forces, stops or friction laws than an ExtendedOscillator holds.
template <typename T>
ExtendedOscillator<T> MakeExtendedOscillator(const DirectionParameters& parameters, double g);

}  // namespace uiclink
