#include "vehicle/four_wagons.h"

#include <algorithm>

#include "vehicle/contact_lanes.h"
#include "vehicle/corner_force.h"
#include "vehicle/guidance.h"
#include "vehicle/processors.h"

namespace uiclink {
namespace {

constexpr std::size_t kWagons = FourWagons::kWagons;

// Sums are in the order of wagon_rate.cpp.

[[gnu::always_inline]] inline WheelForces<Lanes> CalcWheels(const FourWagons& four, const WheelsetMotion<Lanes>& m) {
  const WheelSettingsOf<Lanes> settings{
      .per_V = four.per_V, .mu = four.mu, .printed_roll = four.wagons[0]->options.printed_roll};
  return CalcWheels(
      [&](std::size_t lane) -> const ContactCurve& { return four.wagons[lane]->contact; }, m, settings,
      [&](const WheelContact<Lanes>& c, const KinematicPose<Lanes>& pose) { return CalcApproach(m, c, pose); });
}

/// What of the links is not affine.
[[gnu::noinline]] void AddOther(const FourWagons& four, bool longitudinal, std::size_t corner, const Lanes& d,
                                const Lanes& v, Lanes* F) {
  for (std::size_t lane = 0; lane < kWagons; ++lane) {
    if (four.states[lane] == nullptr) continue;
    const Wagon& wagon = *four.wagons[lane];
    const Link& link = (longitudinal ? wagon.longitudinal : wagon.lateral)[corner];
    const LinkState& state = (longitudinal ? four.states[lane]->longitudinal : four.states[lane]->lateral)[corner];
    if (!link.is_affine()) F->Set(lane, (*F)[lane] + state.CalcOther(link, d[lane], v[lane]));
  }
}

[[gnu::always_inline]] inline Lanes CalcLinks(const FourWagons& four, bool longitudinal, std::size_t corner,
                                              const Lanes& d, const Lanes& v) {
  const FourWagons::Links& links = longitudinal ? four.longitudinal : four.lateral;
  Lanes F = links.C[corner] - links.K[corner] * d - links.c[corner] * v;
  if (!four.all_affine) [[unlikely]] {
    Lanes sum = F;
    AddOther(four, longitudinal, corner, d, v, &sum);
    F = sum;
  }
  return F;
}

/// A corner of all four.
struct Motions {
  using V = Lanes;
  const FourStates& x;
  std::size_t corner;

  [[gnu::always_inline]] const Lanes& Axle(std::size_t i) const { return x[AxleOf(corner) * wheelset::kSize + i]; }
  [[gnu::always_inline]] const Lanes& Body(std::size_t i) const { return x[kBody + i]; }
  [[gnu::always_inline]] double Side() const { return SideOf(corner); }
};

[[gnu::always_inline]] inline CornerTotals<Lanes> CalcCorner(const FourWagons& four, const Motions& at,
                                                             const SineCosine<Lanes>& roll, Lanes* leaf_rate,
                                                             FourWheelLoads* loads) {
  WheelForces<Lanes> wheel = CalcWheels(four, SeeFromWheel(at, roll, four.pitch_rate));
  Mirror(at.Side(), &wheel.total);
  loads->Q[at.corner] = wheel.total.z;
  loads->q[at.corner] = wheel.q;
  const CornerPlace<Lanes>& place = four.places[at.corner];
  const CornerDeflection<Lanes> d = CalcDeflection(four.h, at, place);
  const Lanes P_x = CalcLinks(four, true, at.corner, d.dx, d.vx) + CalcStopForce(four.longitudinal_stop, d.dx);
  const Lanes P_y = CalcLinks(four, false, at.corner, d.dy, d.vy) + CalcStopForce(four.lateral_stop, d.dy);
  Lanes spring(0.0);
  *leaf_rate = Lanes(0.0);
  CalcSpring(four.wagons[0]->options.suspension, four, d.s, d.vs, at.x[kLeafForces + at.corner], &spring, leaf_rate);
  CornerTotals<Lanes> totals = CalcCorner(four.h, at, place, P_x, P_y, -spring);
  Resultant<Lanes>& sum = totals.on_wheelset;
  sum = {wheel.total.x + sum.x,       wheel.total.y + sum.y, wheel.total.z + sum.z,
         wheel.total.roll + sum.roll, wheel.total.pitch,     wheel.total.yaw + sum.yaw};
  return totals;
}

[[gnu::always_inline]] inline Resultant<Lanes> Add(const Resultant<Lanes>& a, const Resultant<Lanes>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z, a.roll + b.roll, a.pitch + b.pitch, a.yaw + b.yaw};
}

UICLINK_FOR_EACH_PROCESSOR
void CalcRatesOfFour(const FourWagons& four, const FourStates& x, FourStates* rate, FourWheelLoads* loads) {
  std::array<CornerTotals<Lanes>, kCorners> at;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const SineCosine<Lanes> roll = CalcSineCosine(x[axle * wheelset::kSize + wheelset::kPhi]);
    for (std::size_t i = 2 * axle; i < 2 * axle + 2; ++i)
      at[i] = CalcCorner(four, Motions{x, i}, roll, &(*rate)[kLeafForces + i], loads);
  }
  const auto sum = [&](Lanes CornerTotals<Lanes>::*part) {
    return (at[0].*part + at[1].*part) + (at[2].*part + at[3].*part);
  };
  const BodyTotals<Lanes> on_body{sum(&CornerTotals<Lanes>::body_y), sum(&CornerTotals<Lanes>::body_z),
                                  sum(&CornerTotals<Lanes>::body_roll), sum(&CornerTotals<Lanes>::body_yaw)};
  const std::array<Resultant<Lanes>, kAxles> axles{Add(at[0].on_wheelset, at[1].on_wheelset),
                                                   Add(at[2].on_wheelset, at[3].on_wheelset)};
  Assemble(four, four.g, x, axles, on_body, rate);
}

void SetStop(std::size_t lane, const GuidanceStop& from, bool there, FourWagons::Stop* stop) {
  stop->k.Set(lane, there ? from.k : 0);
  stop->clearance.Set(lane, from.clearance);
}

}  // namespace

bool CanShareLanes(const WagonOptions& a, const WagonOptions& b) {
  return a.suspension == b.suspension && a.printed_roll == b.printed_roll && a.penetration == Penetration::kTouching &&
         b.penetration == Penetration::kTouching;
}

void FourWagons::SetWagon(std::size_t lane, const Wagon& w, double V) {
  wagons[lane] = &w;
  states[lane] = nullptr;
  const Wagon::Fixed& fixed = w.fixed();
  per_V.Set(lane, 1 / V);
  pitch_rate.Set(lane, V / w.r0);
  mu.Set(lane, w.mu);
  g.Set(lane, w.g);
  h.Set(lane, w.body.h);
  per_m_w.Set(lane, fixed.per_m_w);
  per_I_wx.Set(lane, fixed.per_I_wx);
  per_I_wy.Set(lane, fixed.per_I_wy);
  per_I_wz.Set(lane, fixed.per_I_wz);
  per_m_c.Set(lane, fixed.per_m_c);
  per_I_cx.Set(lane, fixed.per_I_cx);
  per_I_cz.Set(lane, fixed.per_I_cz);
  for (std::size_t i = 0; i < kCorners; ++i) {
    places[i].e_b.Set(lane, fixed.e_b[i]);
    places[i].X.Set(lane, fixed.X[i]);
    places[i].Y.Set(lane, fixed.Y[i]);
    places[i].s_eq.Set(lane, fixed.s_eq[i]);
  }
  linear.k.Set(lane, w.linear.k);
  linear.d.Set(lane, w.linear.d);
  parabolic.stiffness.Set(lane, w.parabolic.k1());
  parabolic.k2.Set(lane, w.parabolic.k2);
  parabolic.F0.Set(lane, w.parabolic.F0);
  parabolic.s0.Set(lane, w.parabolic.s0);
  parabolic_damping.Set(lane, w.parabolic_damping);
  leaf.c.Set(lane, w.leaf.c);
  leaf.mu0.Set(lane, w.leaf.mu0);
  leaf.F_r.Set(lane, w.leaf.F_r);
  leaf.beta.Set(lane, w.leaf.beta);
  SetStop(lane, w.guidance.longitudinal, w.options.guidance, &longitudinal_stop);
  SetStop(lane, w.guidance.lateral, w.options.guidance, &lateral_stop);
}

void FourWagons::SetLinks(std::size_t lane, const LinkStates& links) {
  states[lane] = wagons[lane]->all_links_affine() ? nullptr : &links;
  all_affine = std::ranges::all_of(states, [](const LinkStates* other) { return other == nullptr; });
  const auto set = [lane](const std::array<LinkState, kCorners>& from, Links* to) {
    for (std::size_t i = 0; i < kCorners; ++i) {
      to->K[i].Set(lane, from[i].K);
      to->C[i].Set(lane, from[i].C);
      to->c[i].Set(lane, from[i].c);
    }
  };
  set(links.longitudinal, &longitudinal);
  set(links.lateral, &lateral);
}

void CalcRates(const FourWagons& four, const FourStates& x, FourStates* rate, FourWheelLoads* loads) {
  CalcRatesOfFour(four, x, rate, loads);
}

}  // namespace uiclink
