#pragma once

#include "vehicle/hunting/diagram.h"
#include "vehicle/hunting/wagon_flow.h"

namespace uiclink {

/// The bifurcation diagram of a wagon at a fixed speed by another of its numbers, from options.from to options.to (in
/// the parameter's unit):
///   1. crossings of eigenvalues; at each the born cycles and the branch that they begin;
///   2. hunting after a push (options.start_y, options.start_settle) at the parameter's own value, at both ends of the
///      range and at seven values between: whatever is on no branch yet is made a cycle of and followed both ways;
///   3. what cannot be made a cycle of is a window, looked at by its section and its Lyapunov exponent.
/// A twentieth of the range counts as much as 1 mm and 1 mrad of the state (options.max_step).
/// Neither the trace nor the nonlinear critical speed of the result is set.
/// @param own  the parameter's own value; pushed first, at the nearest end where it is outside of the range.
/// @throws std::invalid_argument for a family by speed or an empty range; what FindEquilibrium throws.
BifurcationDiagram CalcParameterDiagram(const WagonFamily& family, double own, const DiagramOptions& options);

}  // namespace uiclink
