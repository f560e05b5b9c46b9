#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "model/scalar.h"

namespace uiclink {

/// Four doubles on which the processor works at once: one for each wheel, or corner, of a wagon, or one for each of
/// four wagons.
///
/// GCC and Clang turn the operations into whatever vectors the processor has; results do not depend on which, because
/// sums of products are never fused (cmake/UiclinkTargets.cmake).
class Lanes {
 public:
  using Vector = double __attribute__((vector_size(32)));
  /// True or false for each lane.
  struct Mask {
    decltype(Vector{} < Vector{}) v;
  };

  Lanes() = default;
  // As one vector: GCC copies structures by halves, which a processor cannot read as a whole before they are in memory.
  [[gnu::always_inline]] Lanes(const Lanes& from) : v_(from.v_) {}
  [[gnu::always_inline]] Lanes& operator=(const Lanes& from) {
    v_ = from.v_;
    return *this;
  }
  [[gnu::always_inline]] Lanes(double same)
      : v_{same, same, same, same} {}  // NOLINT: a number is the same in all lanes
  [[gnu::always_inline]] Lanes(double a, double b, double c, double d) : v_{a, b, c, d} {}
  [[gnu::always_inline]] explicit Lanes(const double* four) { __builtin_memcpy(&v_, four, sizeof v_); }
  [[gnu::always_inline]] double operator[](std::size_t i) const { return v_[i]; }
  [[gnu::always_inline]] void Set(std::size_t i, double value) { v_[i] = value; }
  [[gnu::always_inline]] void Store(double* four) const { __builtin_memcpy(four, &v_, sizeof v_); }

  [[gnu::always_inline]] friend Lanes operator+(const Lanes& a, const Lanes& b) { return Make(a.v_ + b.v_); }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a, const Lanes& b) { return Make(a.v_ - b.v_); }
  [[gnu::always_inline]] friend Lanes operator*(const Lanes& a, const Lanes& b) { return Make(a.v_ * b.v_); }
  [[gnu::always_inline]] friend Lanes operator/(const Lanes& a, const Lanes& b) { return Make(a.v_ / b.v_); }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a) { return Make(-a.v_); }
  [[gnu::always_inline]] friend Mask operator<(const Lanes& a, const Lanes& b) { return {a.v_ < b.v_}; }
  /// Rows become columns.
  [[gnu::always_inline]] static void Transpose(Lanes* a, Lanes* b, Lanes* c, Lanes* d) {
    const Lanes ab_even = Shuffle(*a, *b, Order{0, 4, 2, 6});
    const Lanes ab_odd = Shuffle(*a, *b, Order{1, 5, 3, 7});
    const Lanes cd_even = Shuffle(*c, *d, Order{0, 4, 2, 6});
    const Lanes cd_odd = Shuffle(*c, *d, Order{1, 5, 3, 7});
    *a = Shuffle(ab_even, cd_even, Order{0, 1, 4, 5});
    *b = Shuffle(ab_odd, cd_odd, Order{0, 1, 4, 5});
    *c = Shuffle(ab_even, cd_even, Order{2, 3, 6, 7});
    *d = Shuffle(ab_odd, cd_odd, Order{2, 3, 6, 7});
  }
  /// a where the mask holds, b elsewhere.
  [[gnu::always_inline]] friend Lanes Choose(const Mask& mask, const Lanes& a, const Lanes& b) {
    return Make(mask.v ? a.v_ : b.v_);
  }
  [[gnu::always_inline]] friend Lanes Min(const Lanes& a, const Lanes& b) { return Make(b.v_ < a.v_ ? b.v_ : a.v_); }
  [[gnu::always_inline]] friend Lanes Abs(const Lanes& a) { return Make(a.v_ < Vector{} ? -a.v_ : a.v_); }
  [[gnu::always_inline]] friend Lanes SafeSqrt(const Lanes& a) {
    return {std::sqrt(a.v_[0]), std::sqrt(a.v_[1]), std::sqrt(a.v_[2]), std::sqrt(a.v_[3])};
  }

 private:
  using Order = long long __attribute__((vector_size(32)));
  /// Element i is number order[i] of a, b put end to end.
  [[gnu::always_inline]] static Lanes Shuffle(const Lanes& a, const Lanes& b, const Order& order) {
#if defined(__clang__)
    Lanes lanes;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto from = static_cast<std::size_t>(order[i]);
      lanes.v_[i] = from < 4 ? a[from] : b[from - 4];
    }
    return lanes;
#else
    return Make(__builtin_shuffle(a.v_, b.v_, order));
#endif
  }
  [[gnu::always_inline]] static Lanes Make(const Vector& v) {
    Lanes lanes;
    lanes.v_ = v;
    return lanes;
  }
  Vector v_;
};

// The same for numbers and for scalars with derivatives, so that one formula serves all.
inline double Choose(bool condition, double a, double b) { return condition ? a : b; }
template <int N>
Dual<N> Choose(bool condition, const Dual<N>& a, const Dual<N>& b) {
  return condition ? a : b;
}
/// The square root; at zero its (infinite) derivatives count as zero.
template <int N>
Dual<N> SafeSqrt(const Dual<N>& x) {
  if (x.a <= 0) return Dual<N>(0.0);
  return sqrt(x);
}

}  // namespace uiclink
