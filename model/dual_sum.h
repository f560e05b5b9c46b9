#pragma once

#include <cstddef>
#include <type_traits>

#include "model/scalar.h"

namespace uiclink {

/// Weighted sums in one pass over the derivatives. Written with operators, each of them would make a dual number of its
/// own, which is what a walk from event to event then spends its time on.
template <typename T>
struct Term {
  double weight;
  const T& value;
};

/// Sum of weights * values.
template <typename T, std::size_t n>
[[gnu::always_inline]] inline T Sum(const Term<T> (&terms)[n]) {
  double value = 0;
  for (std::size_t i = 0; i < n; ++i) value += terms[i].weight * Value(terms[i].value);
  if constexpr (std::is_same_v<T, double>) {
    return value;
  } else {
    T sum;
    sum.a = value;
    for (int c = 0; c < T::DIMENSION; ++c) {
      double column = 0;
      for (std::size_t i = 0; i < n; ++i) column += terms[i].weight * terms[i].value.v[c];
      sum.v[c] = column;
    }
    return sum;
  }
}

/// A number of which the value and, as weights, the partial derivatives by some quantities are known.
template <typename T, std::size_t n>
[[gnu::always_inline]] inline T Propagate(double value, const Term<T> (&terms)[n]) {
  if constexpr (std::is_same_v<T, double>) {
    return value;
  } else {
    T sum = Sum<T>(terms);
    sum.a = value;
    return sum;
  }
}

/// Zero with all derivatives.
inline bool IsAbsent(double x) { return x == 0; }
template <int N>
bool IsAbsent(const Dual<N>& x) {
  return x.a == 0 && x.v.isZero(0);
}

}  // namespace uiclink
