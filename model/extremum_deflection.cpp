#include "model/extremum_deflection.h"

#include <array>
#include <cmath>

namespace uiclink {
namespace {

/// Shares of T0 by the speed terms that joints have at an extremum at distance A [m] that they reached sliding.
///
/// A joint that sticks at the speed v before the extremum, a way x before it, has the share of v there and what its
/// spring takes on the way.  v follows from the deceleration a where it sticks, and x from  v^2 = 2 a x + g K x^2,  K
/// the stiffness with that joint stuck; both depend on each other weakly, so a few passes do.
template <typename T>
std::array<T, kMaxExtendedSliders> CalcSharesAtExtremum(const ExtendedOscillator<T>& o, const T& A) {
  using std::sqrt;
  constexpr int kPasses = 6;
  const auto sliders = o.sliders.items();
  std::array<T, kMaxExtendedSliders> share{}, way{};
  for (int pass = 0; pass < kPasses; ++pass) {
    T K = o.k, friction{};
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      friction += sliders[i].k * sliders[i].y_c * (T(1) + share[i]);
      if (Value(way[i]) > 0) K += sliders[i].k;
    }
    for (std::size_t i = 0; i < sliders.size(); ++i) {
      if (!sliders[i].joint) continue;
      const T a = o.g * (o.k * (A - way[i]) + friction);
      share[i] = way[i] = T(0);
      for (const SpeedTerm<T>& term : o.speed_terms.items()) {
        const T v2 = term.sticking_speed_squared(term.p, sliders[i].y_c, a);
        const bool sticks = Value(v2) > 0;
        share[i] += term.sliding(term.p, sticks ? T(sqrt(v2)) : T(0));
        if (sticks) way[i] = (sqrt(a * a + o.g * K * v2) - a) / (o.g * K);
      }
    }
  }
  for (std::size_t i = 0; i < sliders.size(); ++i)
    if (Value(way[i]) > 0) share[i] += way[i] / sliders[i].y_c;
  return share;
}

}  // namespace

template <typename T>
T CalcDeflectionAtExtremum(const ExtendedOscillator<T>& o, std::size_t slider, const T& y0, double clock) {
  const ExtendedSlider<T>& s = o.sliders.items()[slider];
  if (!s.joint) return s.y_c;
  const double side = Value(y0) < 0 ? -1 : 1;
  T factor(1);
  if (!o.speed_terms.empty()) factor += CalcSharesAtExtremum(o, T(side * y0))[slider];
  factor *= (T(1) + o.drift * clock) * (T(1) + side * o.asymmetry);
  T reach = s.y_c * factor;
  if (o.has_gap) reach += o.gap;
  return reach;
}

template double CalcDeflectionAtExtremum(const ExtendedOscillator<double>&, std::size_t, const double&, double);
template Dual<6> CalcDeflectionAtExtremum(const ExtendedOscillator<Dual<6>>&, std::size_t, const Dual<6>&, double);
template Dual<8> CalcDeflectionAtExtremum(const ExtendedOscillator<Dual<8>>&, std::size_t, const Dual<8>&, double);
template Dual<12> CalcDeflectionAtExtremum(const ExtendedOscillator<Dual<12>>&, std::size_t, const Dual<12>&, double);
template Dual<16> CalcDeflectionAtExtremum(const ExtendedOscillator<Dual<16>>&, std::size_t, const Dual<16>&, double);

}  // namespace uiclink
