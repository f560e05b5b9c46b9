#pragma once

#include <cstddef>

#include "model/extended_oscillator.h"

namespace uiclink {

/// Deflection of slider i when the mass turns round at y0, having slid towards it: y_c L + gap [m].
/// @param y0     [m], not 0
/// @param clock  the record's clock at the extremum [s]
template <typename T>
T CalcDeflectionAtExtremum(const ExtendedOscillator<T>& oscillator, std::size_t slider, const T& y0, double clock);

}  // namespace uiclink
