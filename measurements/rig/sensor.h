#pragma once

#include <vector>

#include "measurements/rig/random.h"
#include "measurements/rig/rig.h"

namespace uiclink::rig {

/// Sends the true displacement [m], one value for each sample of the converter, down the measurement chain:
/// motion at the sensor (cross axis, rig mode), sensor curve, zero offset, drift, hum, noise, saturation, converter,
/// decimation. Returns the kept readings [mm].
std::vector<double> Measure(const std::vector<double>& y, const Truth& truth, const Sensor& sensor,
                            NormalGenerator& normal);

}  // namespace uiclink::rig
