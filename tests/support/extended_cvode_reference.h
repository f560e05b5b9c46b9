#pragma once

#include <span>

#include "model/extended_oscillator.h"
#include "model/trajectory.h"

namespace uiclink {

struct ExtendedCvodeCounts {
  long steps = 0;
  long turnings = 0;
  long breakouts = 0;
  long stickings = 0;  ///< before a turning point
};

/// The motion of an extended oscillator by general-purpose means, to check the extended solver against; shares the laws
/// of the effects with it and nothing else.
///
/// State (y, v), integrated by CVODES (Adams) at rtol 1e-12; the position p_i of each slider that does not slide.
///   v' = g (-k y - c v - d T_r - sum k_i S(y - p_i) - d sum k_i y_c,i L_i + stops + forces),  d the direction of
///   travel,
/// the first sum over sliders that do not slide, S the dead zone. Roots: v; y_c,i L_i - d S of each that does not
/// slide; d p_i' of each that slides; and, where a force has only a kink, the kink itself, to start anew there.
///
/// @param y0     start [m], at rest; slider i stands at y0 - sign(y0) deflection[i].
/// @param clock  the record's clock at the start [s].
/// @throws std::runtime_error when CVODES fails.
ExtendedCvodeCounts RunExtendedCvode(const ExtendedOscillator<double>& oscillator, double y0,
                                     std::span<const double> deflection, double clock, const SampleTimes& times,
                                     std::span<double> y);

}  // namespace uiclink
