#pragma once

#include <optional>

namespace uiclink {

/// Where a quantity turns round within a step, by the cubic through values and rates at both ends.
struct Turn {
  double share = 0;  ///< of the step that is behind, 0 to 1
  double value = 0;  ///< there
};

/// @param h       length of the step.
/// @param f0, r0  value and rate at its begin.
/// @param f1, r1  the same at its end.
/// @return none where the rates have the same sign.
std::optional<Turn> FindTurn(double h, double f0, double r0, double f1, double r1);

}  // namespace uiclink
