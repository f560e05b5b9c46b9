#pragma once

#include <string>

#include "reports/figure.h"
#include "vehicle/reproduce/result.h"
#include "vehicle/simulation.h"

namespace uiclink::reproduce {

// Figures of a run as items want them.
double HalfWidth(const SimulationResult& run, TrackedMotion motion);     ///< [mm] or [mrad]
Value StrongestLine(const SimulationResult& run, TrackedMotion motion);  ///< [Hz]; nothing at rest
/// Lateral motion and yaw, for `spectra` also the motions whose spectra are shown; left the last `shown` seconds, right
/// a close view of the last five.
Figure MotionFigure(const SimulationResult& run, const std::string& title, bool spectra, double shown);
std::string NameImpacts(bool front, bool rear);  ///< "both", "rear", "front", "none"

}  // namespace uiclink::reproduce
