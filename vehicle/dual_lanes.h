#pragma once

#include <cstddef>

#include "vehicle/lanes.h"

namespace uiclink {

/// Four numbers with their derivatives with respect to N quantities, on which the processor works at once: Dual<N> for
/// Lanes. The rules of differentiation are those of ceres::Jet.
template <int N>
class DualLanes {
 public:
  DualLanes() = default;
  // Lane by lane: left to itself GCC copies by a string instruction, which takes longer than a product.
  [[gnu::always_inline]] DualLanes(const DualLanes& f) { *this = f; }
  [[gnu::always_inline]] DualLanes& operator=(const DualLanes& f) {
    a = f.a;
#pragma GCC unroll 16
    for (std::size_t i = 0; i < N; ++i) v[i] = f.v[i];
    return *this;
  }
  /// Constants.
  [[gnu::always_inline]] explicit DualLanes(double same) : DualLanes(Lanes(same)) {}
  [[gnu::always_inline]] explicit DualLanes(const Lanes& value) : a(value) {
#pragma GCC unroll 16
    for (std::size_t i = 0; i < N; ++i) v[i] = Lanes(0.0);
  }
  /// Quantity i of the N itself, or what changes with it alone.
  [[gnu::always_inline]] DualLanes(const Lanes& value, std::size_t i, const Lanes& slope = 1.0) : DualLanes(value) {
    v[i] = slope;
  }

  [[gnu::always_inline]] friend DualLanes operator+(const DualLanes& f, const DualLanes& g) {
    return Make(f.a + g.a, [&](std::size_t i) { return f.v[i] + g.v[i]; });
  }
  [[gnu::always_inline]] friend DualLanes operator-(const DualLanes& f, const DualLanes& g) {
    return Make(f.a - g.a, [&](std::size_t i) { return f.v[i] - g.v[i]; });
  }
  [[gnu::always_inline]] friend DualLanes operator*(const DualLanes& f, const DualLanes& g) {
    return Make(f.a * g.a, [&](std::size_t i) { return f.a * g.v[i] + f.v[i] * g.a; });
  }
  [[gnu::always_inline]] friend DualLanes operator/(const DualLanes& f, const DualLanes& g) {
    const Lanes per_g = Lanes(1.0) / g.a;
    const Lanes ratio = f.a * per_g;
    return Make(ratio, [&](std::size_t i) { return (f.v[i] - ratio * g.v[i]) * per_g; });
  }
  [[gnu::always_inline]] friend DualLanes operator-(const DualLanes& f) {
    return Make(-f.a, [&](std::size_t i) { return -f.v[i]; });
  }

  [[gnu::always_inline]] friend DualLanes operator+(const DualLanes& f, const Lanes& c) {
    return Make(f.a + c, [&](std::size_t i) { return f.v[i]; });
  }
  [[gnu::always_inline]] friend DualLanes operator+(const Lanes& c, const DualLanes& f) { return f + c; }
  [[gnu::always_inline]] friend DualLanes operator-(const DualLanes& f, const Lanes& c) { return f + (-c); }
  [[gnu::always_inline]] friend DualLanes operator-(const Lanes& c, const DualLanes& f) { return (-f) + c; }
  [[gnu::always_inline]] friend DualLanes operator*(const DualLanes& f, const Lanes& c) {
    return Make(f.a * c, [&](std::size_t i) { return f.v[i] * c; });
  }
  [[gnu::always_inline]] friend DualLanes operator*(const Lanes& c, const DualLanes& f) { return f * c; }
  [[gnu::always_inline]] friend DualLanes operator/(const Lanes& c, const DualLanes& f) {
    const Lanes per_f = Lanes(1.0) / f.a;
    const Lanes ratio = c * per_f;
    const Lanes slope = -(ratio * per_f);
    return Make(ratio, [&](std::size_t i) { return slope * f.v[i]; });
  }

  [[gnu::always_inline]] friend Lanes::Mask operator<(const DualLanes& f, const DualLanes& g) { return f.a < g.a; }
  [[gnu::always_inline]] friend DualLanes Choose(const Lanes::Mask& mask, const DualLanes& f, const DualLanes& g) {
    return Make(Choose(mask, f.a, g.a), [&](std::size_t i) { return Choose(mask, f.v[i], g.v[i]); });
  }
  /// As SafeSqrt of Dual: where the root is zero its derivatives count as zero.
  [[gnu::always_inline]] friend DualLanes SafeSqrt(const DualLanes& f) {
    const Lanes zero(0.0);
    const Lanes root = SafeSqrt(f.a);
    const Lanes slope = Choose(zero < f.a, 0.5 / root, zero);
    return Make(Choose(zero < f.a, root, zero), [&](std::size_t i) { return slope * f.v[i]; });
  }

  Lanes a;     ///< the numbers
  Lanes v[N];  ///< their derivatives

 private:
  template <typename F>
  [[gnu::always_inline]] static DualLanes Make(const Lanes& value, const F& slope) {
    DualLanes f;
    f.a = value;
#pragma GCC unroll 16
    for (std::size_t i = 0; i < N; ++i) f.v[i] = slope(i);
    return f;
  }
};

}  // namespace uiclink
