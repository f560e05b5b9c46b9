#pragma once

#include <functional>
#include <span>

#include "model/trajectory.h"
#include "vehicle/link.h"

namespace uiclink {

struct LinkSwingOptions {
  double tolerance = 1e-12;  ///< relative; absolute 1e-2 of it in m and m/s
  /// [s]. The interpolation that roots are looked for on, of degree 5, is off by (w h)^6/46080 of the amplitude: 1e-14
  /// of it at w = 14 rad/s, the stiffest of the published links.
  double max_step = 2e-3;
  /// Called before and after each change of the joints, where it is set.
  std::function<void(const LinkState& before, const LinkState& after, double d, double v)> on_switch = {};
};

struct LinkSwingCounts {
  long steps = 0;
  long changes = 0;  ///< events at which the force law changed
  long turns = 0;    ///< events at which it did not: reversals while all joints stick
};

/// One mass on one link, as on the bench:  M y'' = F(y, y'),  M = load/g, integrated by SUNDIALS' ERKStep (order 5)
/// from event to event, which it finds as roots of LinkState::CalcMargin; started anew at each.
///
/// @param state  of the joints at the start; holds that at the end afterwards.
/// @param y      displacements at the sample times [m].
/// @throws std::runtime_error when ERKStep fails, or the joints change for ever.
LinkSwingCounts SwingLink(const Link& link, LinkState* state, double y0, double v0, const SampleTimes& times,
                          std::span<double> y, const LinkSwingOptions& options = {});

}  // namespace uiclink
