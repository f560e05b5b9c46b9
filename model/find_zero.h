#pragma once

#include <cmath>

namespace uiclink {

/// A time at which a function that is positive at s0 and not positive at s1 is zero, or as good as: regula falsi
/// after Anderson and Bjorck (1973), with a bisection wherever the bracket has not shrunk enough.
template <typename Function>
double FindZero(Function f, double s0, double f0, double s1, double f1, double tiny) {
  double width = s1 - s0;
  bool was_positive = false;
  for (int i = 0; i < 200 && s1 - s0 > 1e-16 + 4e-16 * s1; ++i) {
    double s = s0 + (s1 - s0) * f0 / (f0 - f1);
    if (i % 4 == 3) {
      if (s1 - s0 > 0.25 * width) s = 0.5 * (s0 + s1);
      width = s1 - s0;
    }
    if (!(s > s0 && s < s1)) s = 0.5 * (s0 + s1);
    const double value = f(s);
    if (std::abs(value) <= tiny) return s;
    const bool positive = value > 0;
    if (i > 0 && positive == was_positive) {  // the other end has stayed: it counts for less
      const double fall = 1 - value / (positive ? f0 : f1);
      (positive ? f1 : f0) *= fall > 0 ? fall : 0.5;
    }
    (positive ? s0 : s1) = s;
    (positive ? f0 : f1) = value;
    was_positive = positive;
  }
  return s1;
}

}  // namespace uiclink
