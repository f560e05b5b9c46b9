#include "vehicle/turn.h"

#include <algorithm>
#include <cmath>

namespace uiclink {

std::optional<Turn> FindTurn(double h, double f0, double r0, double f1, double r1) {
  if (!(r0 * r1 < 0)) return std::nullopt;
  // f = f0 + b t + c t^2 + d t^3 on 0 <= t <= 1
  const double b = h * r0;
  const double e = h * r1;
  const double c = 3 * (f1 - f0) - 2 * b - e;
  const double d = 2 * (f0 - f1) + b + e;
  // b + 2 c t + 3 d t^2 = 0 has one root in between; this form does not cancel for small d.
  const double root = std::sqrt(std::max(c * c - 3 * b * d, 0.0));
  double t = -b / (c + (c >= 0 ? root : -root));
  if (!(t >= 0 && t <= 1)) t = d != 0 ? (-c - (c >= 0 ? root : -root)) / (3 * d) : 0.5;
  if (!(t >= 0 && t <= 1)) t = b / (b - e);
  return Turn{.share = t, .value = f0 + t * (b + t * (c + t * d))};
}

}  // namespace uiclink
