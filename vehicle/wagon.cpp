#include "vehicle/wagon.h"

#include <stdexcept>

#include "vehicle/vertical_spring.h"

namespace uiclink {
namespace {

/// The links of suspension type 1: their springs with every joint stuck.
DirectionParameters WithoutSliders(const DirectionParameters& links) {
  DirectionParameters springs;
  springs.k = links.k + links.SumOfSliderStiffness();
  return springs;
}

double CalcStaticCompression(const Wagon& wagon, double load) {
  switch (wagon.options.suspension) {
    case Suspension::kLinear:
      return CalcStaticCompression(wagon.linear, load);
    case Suspension::kParabolic:
      return CalcStaticCompression(wagon.parabolic, load);
    case Suspension::kLeaf:
      return CalcStaticCompression(wagon.leaf, load);
  }
  throw std::invalid_argument("a suspension that is none");
}

}  // namespace

Wagon::Wagon(const WagonData& data, const BodyInertia& inertia, bool loaded,
             const std::array<CornerLinks, kCorners>& links, const ContactTable& table, const WagonOptions& chosen)
    : Wagon(data, inertia, loaded, links, ContactCurve(table), chosen) {}

Wagon::Wagon(const WagonData& data, const BodyInertia& inertia, bool loaded,
             const std::array<CornerLinks, kCorners>& links, const ContactCurve& curve, const WagonOptions& chosen)
    : g(data.g),
      b(data.b),
      mu(chosen.mu),
      r0(curve.r0()),
      wheelset(data.wheelset),
      body(inertia),
      guidance(data.guidance),
      options(chosen),
      linear(data.linear_vertical),
      parabolic(data.parabolic),
      parabolic_damping(loaded ? data.parabolic.d_loaded : data.parabolic.d_unloaded),
      leaf(data.leaf),
      contact(curve) {
  for (std::size_t i = 0; i < kCorners; ++i) {
    Corner& corner = corners[i];
    corner.X = EndOf(i) * data.l - body.x;
    corner.Y = SideOf(i) * data.b - body.y;
    // Four equal springs under a rigid body whose static trim makes up for its offset.
    corner.load = 0.25 * body.m * g * (1 + EndOf(i) * body.x / data.l + SideOf(i) * body.y / data.b);
    if (corner.load <= 0) throw std::invalid_argument("the freight lies so far out that a corner of the wagon lifts");
    corner.s_eq = CalcStaticCompression(*this, corner.load);

    const bool springs_only = options.suspension == Suspension::kLinear;
    const CornerLinks& set = links[i];
    longitudinal[i] = Link(springs_only ? WithoutSliders(set.longitudinal) : set.longitudinal, set.g, corner.load);
    lateral[i] = Link(springs_only ? WithoutSliders(set.lateral) : set.lateral, set.g, corner.load);
    all_links_affine_ = all_links_affine_ && longitudinal[i].is_affine() && lateral[i].is_affine();
    fixed_.e_b[i] = SideOf(i) * b;
    fixed_.X[i] = corner.X;
    fixed_.Y[i] = corner.Y;
    fixed_.s_eq[i] = corner.s_eq;
  }
  fixed_.per_m_w = 1 / wheelset.m;
  fixed_.per_I_wx = 1 / wheelset.I_x;
  fixed_.per_I_wy = 1 / wheelset.I_y;
  fixed_.per_I_wz = 1 / wheelset.I_z;
  fixed_.per_m_c = 1 / body.m;
  fixed_.per_I_cx = 1 / body.I_x;
  fixed_.per_I_cz = 1 / body.I_z;
}

}  // namespace uiclink
