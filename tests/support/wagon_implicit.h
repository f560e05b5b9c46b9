#pragma once

#include "vehicle/wagon.h"

namespace uiclink {

/// What CVODE took.
struct ImplicitCounts {
  long steps = 0;
  long rhs_calls = 0;  ///< with those for difference Jacobians
  long jacobians = 0;
  long events = 0;
};

enum class JacobianKind { kDifferences, kExact };

struct ImplicitOptions {
  double rtol = 1e-9;
  double atol = 1e-11;  ///< of every component, times CalcErrorScales / 1 mm
  JacobianKind jacobian = JacobianKind::kDifferences;
};

/// Moves a wagon from `start` to t_end with CVODE's BDF and a dense Jacobian, events by its own root finder: the same
/// right-hand side (CalcRate) and links, everything else independent of Integrator.
WagonState RunImplicit(const Wagon& wagon, double V, const WagonState& start, double t_end,
                       const ImplicitOptions& options, ImplicitCounts* counts = nullptr);

}  // namespace uiclink
