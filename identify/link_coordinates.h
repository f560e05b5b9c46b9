#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "model/oscillator.h"

namespace uiclink {

/// Most sliders that a fit can have (one lateral, four longitudinal in the thesis).
inline constexpr int kMaxFittedSliders = 4;

/// The link in the coordinates of a fit.  Logarithms keep everything positive; the levels are what a ring-down
/// determines well, the shape (how stiffness and friction are spread over the sliders) what it hardly determines.
///   levels = log k, log sum k_i, log sum T0i
///   shape  = u_2..u_n, v_2..v_n:   k_i = sum k_i exp(u_i)/sum exp(u_j),  T0i = sum T0i exp(v_i)/sum exp(v_j),  u_1 =
///   v_1 = 0
using Levels = std::array<double, 3>;
using Shape = std::vector<double>;  // 2 (n - 1)

int CountSliders(const Shape& shape);
Oscillator<double> ToOscillator(const Levels& levels, const Shape& shape, double g);
/// The same from bare memory: three levels and, for n > 1, 2 (n - 1) numbers of the shape; n <= kMaxFittedSliders. A
/// dual has the derivatives by these coordinates, in this order from its first one on.
template <typename T = double>
Oscillator<T> ToOscillator(const double* levels, const double* shape, int n, double g);
void FromOscillator(const Oscillator<double>& oscillator, Levels* levels, Shape* shape);
/// Derivatives of (k, k1..kn, T01..T0n) with respect to (levels, shape).
Eigen::MatrixXd CalcNaturalDerivatives(const Oscillator<double>& link);

/// Quantities of a link with n sliders that have a name: k, k1..kn, T01..T0n, sum_ki, sum_T0i; and beyond these
/// CountQuantities the shares k_i / sum k_i and T0i / sum T0i, which records with own levels can have in common.
int CountQuantities(int sliders);
inline int SumOfStiffness(int sliders) { return 2 * sliders + 1; }
inline int SumOfFriction(int sliders) { return 2 * sliders + 2; }
/// Share of quantity 1..2n (k_i or T0i) in its sum.
inline int ShareOf(int sliders, int quantity) { return CountQuantities(sliders) + quantity - 1; }
double CalcQuantity(const Oscillator<double>& link, int quantity);
/// d log(quantity) by (levels, shape).
Eigen::RowVectorXd CalcLogGradient(const Oscillator<double>& link, int quantity);
std::string QuantityName(int sliders, int quantity);

}  // namespace uiclink
