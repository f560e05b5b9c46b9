#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "model/scalar.h"

namespace uiclink {

/// The pair of order 5 and 4 of Dormand and Prince (1980) for y'' = a(t, y, y'), dense in neither: the last stage is
/// the first of the next step.
namespace dormand_prince {

inline constexpr std::size_t kStages = 7;
using Table = std::array<std::array<double, kStages>, kStages>;

inline constexpr std::array<double, kStages> kTimes = {0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1, 1};
/// v_i = v + h sum kVelocity[i][j] a_j; the last row is the step itself.
inline constexpr Table kVelocity = {{{},
                                     {1.0 / 5},
                                     {3.0 / 40, 9.0 / 40},
                                     {44.0 / 45, -56.0 / 15, 32.0 / 9},
                                     {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                                     {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                                     {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}}};
/// y_i = y + h kTimes[i] v + h^2 sum kDisplacement[i][j] a_j: the velocities of the stages put into y_i = y + h sum
/// kVelocity[i][j] v_j.
constexpr Table SquareTable(const Table& table) {
  Table square{};
  for (std::size_t i = 0; i < kStages; ++i)
    for (std::size_t j = 0; j < kStages; ++j)
      for (std::size_t k = 0; k < kStages; ++k) square[i][j] += table[i][k] * table[k][j];
  return square;
}
inline constexpr Table kDisplacement = SquareTable(kVelocity);
/// Difference of the two orders.
inline constexpr std::array<double, kStages> kError = {71.0 / 57600,      0,          -71.0 / 16695, 71.0 / 1920,
                                                       -17253.0 / 339200, 22.0 / 525, -1.0 / 40};

/// Displacement and velocity at stage n, from the accelerations of those before.
template <std::size_t n, typename T>
[[gnu::always_inline]] inline void CalcStage(const T& y, const T& v, const std::array<T, kStages>& a, double h, T* y_n,
                                             T* v_n) {
  const auto calc = [&](double y_part, double v_part, auto part, double* y_out, double* v_out) {
    double to_y = 0, to_v = 0;
    for (std::size_t j = 0; j < n; ++j) {
      const double a_part = part(a[j]);
      to_y += kDisplacement[n][j] * a_part;
      to_v += kVelocity[n][j] * a_part;
    }
    *y_out = y_part + h * (kTimes[n] * v_part + h * to_y);
    *v_out = v_part + h * to_v;
  };
  double y_value = 0, v_value = 0;
  calc(
      Value(y), Value(v), [](const T& x) { return Value(x); }, &y_value, &v_value);
  SetValue(*y_n, y_value);
  SetValue(*v_n, v_value);
  if constexpr (!std::is_same_v<T, double>) {
    for (int c = 0; c < T::DIMENSION; ++c)
      calc(
          y.v[c], v.v[c], [c](const T& x) { return x.v[c]; }, &y_n->v[c], &v_n->v[c]);
  }
}

template <typename T>
struct Step {
  T y{}, v{}, a{};                  ///< at its end
  double y_error = 0, v_error = 0;  ///< [m], [m/s]
};

/// One step h from (y, v), where the acceleration is a; `accelerate(share of h, y, v)` gives it elsewhere.
template <typename T, typename Accelerate>
Step<T> TakeStep(const T& y, const T& v, const T& a, double h, Accelerate accelerate) {
  Step<T> end;
  std::array<T, kStages> as;
  std::array<double, kStages> vs;
  as[0] = a;
  vs[0] = Value(v);
  const auto stage = [&]<std::size_t n>(std::integral_constant<std::size_t, n>) {
    CalcStage<n>(y, v, as, h, &end.y, &end.v);
    vs[n] = Value(end.v);
    as[n] = accelerate(kTimes[n], end.y, end.v);
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) { (stage(std::integral_constant<std::size_t, i + 1>{}), ...); }
  (std::make_index_sequence<kStages - 1>{});
  end.a = as[kStages - 1];
  for (std::size_t i = 0; i < kStages; ++i) {
    end.y_error += h * kError[i] * vs[i];
    end.v_error += h * kError[i] * Value(as[i]);
  }
  return end;
}

}  // namespace dormand_prince

}  // namespace uiclink
