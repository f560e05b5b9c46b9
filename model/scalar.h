#pragma once

#include <ceres/jet.h>

namespace uiclink {

/// The dual scalar of all exact derivatives: a value and its derivatives with respect to N quantities.
template <int N>
using Dual = ceres::Jet<double, N>;

/// The value of a scalar, without its derivatives: what decides which way the solver goes.
inline double Value(double x) { return x; }
template <int N>
double Value(const Dual<N>& x) {
  return x.a;
}

/// Replaces the value of a scalar and keeps its derivatives.
inline void SetValue(double& x, double value) { x = value; }
template <int N>
void SetValue(Dual<N>& x, double value) {
  x.a = value;
}

}  // namespace uiclink
