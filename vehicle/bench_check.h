#pragma once

#include <cstddef>

#include "vehicle/wagon_data.h"

namespace uiclink {

// What the benches ask of their options. All throw std::invalid_argument "function: name = value unit, must be ...".
void CheckPositive(const char* function, const char* name, double value, const char* unit);
void CheckAtLeast(const char* function, const char* name, int value, int least);
/// c, beta > 0, F_r >= 0, 0 <= mu0 < 1.
void CheckLeaf(const char* function, const LeafSpring& spring);
/// Samples at 0, step, ..., duration: at most ten million.
std::size_t CountSamples(const char* function, double duration, double step);

}  // namespace uiclink
