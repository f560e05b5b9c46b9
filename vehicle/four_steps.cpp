#include "vehicle/four_steps.h"

#include "vehicle/processors.h"

namespace uiclink {
namespace {

constexpr std::size_t kUsed = kFourStages - 1;
constexpr double kRows[kUsed][kUsed] = {
    {0.5}, {0, 0.5}, {0, 0, 1}, {5.0 / 32, 7.0 / 32, 13.0 / 32, -1.0 / 32}, {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6, 0}};
/// The solution's weights less those of the embedded one, -1/2, 7/3, 7/3, 13/6, -16/3.
constexpr double kError[kUsed] = {1.0 / 6 + 1.0 / 2, 1.0 / 3 - 7.0 / 3, 1.0 / 3 - 7.0 / 3, 1.0 / 6 - 13.0 / 6,
                                  16.0 / 3};

UICLINK_FOR_EACH_PROCESSOR
void Combine(const FourStates& x, const FourStages& k, std::size_t stage, const Lanes& h, FourStates* to) {
  std::array<Lanes, kUsed> a;
  a.fill(Lanes(0.0));
  std::size_t which[kUsed] = {};
  std::size_t terms = 0;
  for (std::size_t j = 0; j < stage; ++j) {
    if (kRows[stage - 1][j] == 0) continue;
    a[terms] = h * kRows[stage - 1][j];
    which[terms++] = j;
  }
  for (std::size_t i = 0; i < kMaxState; ++i) {
    Lanes sum = x[i];
    for (std::size_t j = 0; j < terms; ++j) sum = sum + a[j] * k[which[j]][i];
    (*to)[i] = sum;
  }
}

UICLINK_FOR_EACH_PROCESSOR
void Errors(const FourStages& k, const FourStates& weights, const Lanes& h, Lanes* errors) {
  Lanes squares[2] = {Lanes(0.0), Lanes(0.0)};
  for (std::size_t i = 0; i < kMaxState; ++i) {
    Lanes e = kError[0] * k[0][i];
    for (std::size_t j = 1; j < kUsed; ++j) e = e + kError[j] * k[j][i];
    e = h * e * weights[i];
    squares[i % 2] = squares[i % 2] + e * e;
  }
  *errors = SafeSqrt((squares[0] + squares[1]) * (1.0 / kMaxState));
}

UICLINK_FOR_EACH_PROCESSOR
void Copy(const Lanes& share, const FourStates& from, FourStates* to) {
  for (std::size_t i = 0; i < kMaxState; ++i) (*to)[i] = Choose(Lanes(0.5) < share, from[i], (*to)[i]);
}

/// A guard seen from its side; one that the wagon does not have (side 0) is far from zero.
[[gnu::always_inline]] inline Lanes SeeFrom(const Lanes& side, const Lanes& value) {
  return side * value + (1.0 - side * side);
}

[[gnu::always_inline]] inline Lanes CalcLinkMargin(const FourGuards::Bounds& bounds, std::size_t corner, const Lanes& d,
                                                   const Lanes& v) {
  const Lanes within = Min(bounds.upper[corner] - d, d - bounds.lower[corner]);
  return Min(within, bounds.travel[corner] * v + LinkState::kAtRest);
}

UICLINK_FOR_EACH_PROCESSOR
void LeastGuards(const FourWagons& four, const FourGuards& guards, const FourStates& x, Lanes* least) {
  Lanes m = Min(guards.track - Abs(x[wheelset::kY]), guards.track - Abs(x[kRearWheelset + wheelset::kY]));
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<Lanes> d = CalcDeflection(four, x, i);
    m = Min(m, CalcLinkMargin(guards.longitudinal, i, d.dx, d.vx));
    m = Min(m, CalcLinkMargin(guards.lateral, i, d.dy, d.vy));
    m = Min(m, SeeFrom(guards.longitudinal_stop[i], Abs(d.dx) - guards.longitudinal_clearance));
    m = Min(m, SeeFrom(guards.lateral_stop[i], Abs(d.dy) - guards.lateral_clearance));
    m = Min(m, SeeFrom(guards.stage[i], d.s - guards.stage_compression));
    m = Min(m, guards.leaf[i] * d.vs + guards.leaf_rest[i]);
  }
  *least = m;
}

}  // namespace

void CombineStages(const FourStates& x, const FourStages& k, std::size_t stage, const Lanes& h, FourStates* to) {
  Combine(x, k, stage, h, to);
}
void CalcErrors(const FourStages& k, const FourStates& weights, const Lanes& h, Lanes* errors) {
  Errors(k, weights, h, errors);
}
void CopyLanes(const Lanes& share, const FourStates& from, FourStates* to) { Copy(share, from, to); }
void CalcLeastGuards(const FourWagons& four, const FourGuards& guards, const FourStates& x, Lanes* least) {
  LeastGuards(four, guards, x, least);
}

}  // namespace uiclink
