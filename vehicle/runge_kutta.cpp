#include "vehicle/runge_kutta.h"

#include <algorithm>

namespace uiclink {

const RungeKuttaPair* FindRungeKuttaPair(std::string_view name) {
  static const std::vector<RungeKuttaPair> pairs{
      // The classical method. Every b^ = (1/6, 1/3, 1/3, 1/6 - e, e) has order 3; e = 1/10.
      {.name = "UICLINK_RUNGE_KUTTA_5_3_4",
       .order = 4,
       .embedded_order = 3,
       .rows = {{0.5}, {0, 0.5}, {0, 0, 1}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}},
       .embedded = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 15, 1.0 / 10},
       .real_extent = kClassicalRealExtent,
       .imaginary_extent = kClassicalImaginaryExtent},
      // Two pairs of ours. The stability polynomials were found by maximising the step at which creep (real) and Hertz
      // contact (nearly imaginary) are stable, at real : imaginary = 2.2 and 5, with |R| <= 0.9 along the real axis;
      // then
      // coefficients with that polynomial, order 4 and the least error of order 5 (norm of eight conditions 1.6e-4 and
      // 5e-5; the classical method has 2e-2), by Gauss-Newton from random starts. The embedded solution has order 3 and
      // the smallest error polynomial over the region of stability.
      {.name = "UICLINK_STABLE_7_3_4",
       .order = 4,
       .embedded_order = 3,
       .rows = {{0.21223393683108893},
                {-0.19974101118475149, 0.76952498961388682},
                {0.29539473276331851, -0.13778047085281814, 0.70899706518076844},
                {0.19887078162692354, -0.053054159277624871, 0.062055132030669133, 0.020655564066489916},
                {-0.066792657562025015, 0.097015327061924755, -0.27497512117980016, 0.10046863318258424,
                 0.4996598164368265},
                {0.09365755041919302, 0.069633193021089057, 0.16446985056360966, 0.3151095173572403,
                 0.06688031829562302, 0.290249570343245}},
       .embedded = {0.13284473252321732, 0.05708454316059592, 0.35067550591479785, 0.22155887675252289,
                    0.049358081692130955, 0.16085023845588164, 0.027628021500853493},
       .real_extent = 7.95,
       .imaginary_extent = 3.6},
      {.name = "UICLINK_STABLE_8_3_4",
       .order = 4,
       .embedded_order = 3,
       .rows = {{0.41178231042034347},
                {0.12571561123505542, 0.80250748681144524},
                {0.0096419989360239343, 0.083613220943430225, 0.29303902160206513},
                {-0.015997763581335731, 0.32684803961760317, -0.050330547211208707, 0.004694759227279314},
                {-0.041096338637536423, 0.021212724711617368, 0.20957029384961279, 0.13303163045863317,
                 0.45742233716202818},
                {0.11524206301353057, 0.020714517408684473, -0.062540769304097577, -0.17529538852589804,
                 0.21518073176821961, 0.24372253805244717},
                {0.099847331846618259, 0.15510093539885808, 0.11454987949996991, -0.10128340639437836,
                 0.16374964254081861, 0.28998738657318796, 0.27804823053492561}},
       .embedded = {0.075773905321595128, 0.023528949142740202, 0.12925431725600023, -0.23578830702039696,
                    0.4418828381030061, 0.46433981634125387, 0.18513055266149758, -0.084122071805696128},
       .real_extent = 12.6,
       .imaginary_extent = 2.5},
  };
  const auto pair = std::find_if(pairs.begin(), pairs.end(), [&](const RungeKuttaPair& p) { return p.name == name; });
  return pair == pairs.end() ? nullptr : &*pair;
}

}  // namespace uiclink
