#pragma once

#include <memory>

#include "dynamics/flow.h"

namespace uiclink {

/// Small smooth flows with known Lyapunov exponents: Runge-Kutta of order 4 with a fixed step, derivatives by the
/// variational equation on the same steps. States of two or three numbers, scales 1; watched: the first coordinate.

/// x' = sigma (y - x), y' = x (rho - z) - y, z' = x y - beta z; sigma = 10, beta = 8/3, the parameter is rho.
/// rho = 28: 0.9056 (Sprott, Chaos and Time-Series Analysis, 2003, appendix A).
std::unique_ptr<Flow> MakeLorenz();
/// x' = -y - z, y' = x + a y, z' = b + z (x - c); a = b = 0.2, the parameter is c. c = 5.7: 0.0714 (the same source).
std::unique_ptr<Flow> MakeRoessler();
/// x' = y, y' = mu (1 - x^2) y - x; the parameter is mu. 0 on its cycle.
std::unique_ptr<Flow> MakeSmoothVanDerPol();
/// x' = y, y' = -x - 2 zeta y; the parameter is zeta < 1. Both exponents are -zeta.
std::unique_ptr<Flow> MakeDampedOscillator();

}  // namespace uiclink
