#include "tests/support/wagon_samples.h"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <utility>

namespace uiclink {
namespace {

constexpr double kFlange = 6.5e-3;       // where the flange begins [m] ...
constexpr double kFlangeWidth = 0.3e-3;  // ... and how gently [m]

double FlangeShare(double y) { return 1 / (1 + std::exp(-(y - kFlange) / kFlangeWidth)); }
/// Its integral: 0 on the tread, y - kFlange on the flange.
double FlangeRise(double y) { return kFlangeWidth * std::log1p(std::exp((y - kFlange) / kFlangeWidth)); }

ContactRow MakeRow(double y, int jumps) {
  const double flange = FlangeShare(y);
  ContactRow row;
  row.y = y;
  row.delta = 0.04 + 8 * y + flange + 0.05 * jumps;
  row.r = 0.46 + 0.04 * y + 4 * y * y + 2 * FlangeRise(y) + 3e-4 * jumps;
  row.a_wheel = 0.752 - 1.5 * y - 0.02 * flange - (jumps > 0 ? 8e-3 : 0) - (jumps > 1 ? 3e-3 : 0);
  row.z_lift = -1e-4 + 3 * y * y + 0.5 * (FlangeRise(y) + FlangeRise(-y));
  row.phi_roll = 0.03 * y + 0.7 * (FlangeRise(y) - FlangeRise(-y));
  row.a_rail = y + row.a_wheel + row.r * row.phi_roll;
  row.z_rail = -1e-3 - 0.02 * y;
  row.c11 = 4.1 + 20 * y;
  row.c22 = 3.6 + 25 * y;
  row.c23 = 1.45 + 30 * y;
  row.a_e = 5.5e-3 * (1 + 30 * y - 0.5 * flange) * (1 - 0.1 * jumps);
  row.b_e = 4.0e-3 * (1 - 20 * y) * (1 - 0.15 * jumps);
  row.q0 = 7e-5 * (1 - 10 * y + 0.2 * flange) * (1 + 0.1 * jumps);
  row.n0 = 4e4 * (1 + 5 * y);
  return row;
}

WagonData MakeData() {
  WagonData data;
  data.name = "sample";
  data.g = 9.82;
  data.b = 1.074;
  data.l = 5.0;
  data.wheelset = {.m = 1022, .I_x = 678, .I_y = 80, .I_z = 678};
  data.guidance = {.longitudinal = {.clearance = 0.0225, .k = 3e7}, .lateral = {.clearance = 0.020, .k = 1.5e6}};
  data.linear_vertical = {.k = 0.65e6, .d = 34.44e3};
  data.parabolic = {.F0 = 41.1e3, .s0 = 62.9e-3, .k2 = 1.82e6, .d_unloaded = 34.44e3, .d_loaded = 50.652e3};
  data.leaf = {.c = 0.65e6, .mu0 = 0.07, .F_r = 4350, .beta = 1e-3};
  return data;
}

CornerLinks MakeLinks(SampleLinks kind, std::size_t corner) {
  const double stiffer = kind == SampleLinks::kAlike ? 1 : 1 + 0.1 * static_cast<double>(corner);
  CornerLinks links;
  links.lateral.k = 3.4 * stiffer;
  links.lateral.sliders = {{.k = 2.2, .T0 = 0.018 / stiffer}};
  links.longitudinal.k = 5.5;
  links.longitudinal.sliders = {
      {.k = 2.0, .T0 = 6e-3}, {.k = 0.5 * stiffer, .T0 = 3e-3}, {.k = 0.37, .T0 = 2e-3}, {.k = 0.6, .T0 = 2e-3}};
  if (kind == SampleLinks::kExtended) {
    links.lateral.effects = {{"viscous_damping", {{"c", 0.012}}}, {"cubic_stiffness", {{"k3", 300}}}};
    links.longitudinal.effects = {{"viscous_damping", {{"c", 0.02}}}, {"quadratic_drag", {{"d", 0.4}}}};
  }
  return links;
}

BodyInertia MakeBody(const WagonSample& sample) {
  BodyInertia body{.m = 13563, .I_x = 32500, .I_z = 363000, .h = 0.9157, .x = 0, .y = 0, .I_xz = 0};
  if (sample.loaded) body = {.m = 35800, .I_x = 57900, .I_z = 854000, .h = 1.228, .x = 0, .y = 0, .I_xz = 0};
  if (sample.off_centre) {
    body.x = 0.4;
    body.y = 0.06;
  }
  return body;
}

constexpr std::size_t Opposite(std::size_t corner) { return corner ^ 1U; }

/// A link in the mirror: `sign` is -1 for lateral ones. @param to  the link that shows the image.
LinkState MirrorLink(const Link& from, const LinkState& state, const Link& to, double d, double v, double sign) {
  std::vector<double> T;
  for (std::size_t i = 0; i < from.sliders().size(); ++i) T.push_back(sign * state.CalcJointForce(from, i, d, v));
  return LinkState::WithForces(to, sign * d, sign * v, T);
}

}  // namespace

ContactTable MakeSampleTable(bool jumps) {
  ContactTable table{.name = "sample", .r0 = 0.46, .shear_modulus = 8.2e10, .rows = {}};
  const std::vector<double> at = jumps ? std::vector<double>{0.23e-3, 5.04e-3} : std::vector<double>{};
  std::size_t passed = 0;
  for (int i = -100; i <= 100; ++i) {
    const double y = i * 1e-4;
    for (; passed < at.size() && at[passed] < y; ++passed) {
      table.rows.push_back(MakeRow(at[passed], static_cast<int>(passed)));
      table.rows.push_back(MakeRow(at[passed], static_cast<int>(passed) + 1));
    }
    table.rows.push_back(MakeRow(y, static_cast<int>(passed)));
  }
  return table;
}

ContactTable MakeCylinderTable() {
  ContactTable table{.name = "cylinders", .r0 = 0.46, .shear_modulus = 8.2e10, .rows = {}};
  for (int i = -100; i <= 100; ++i) {
    ContactRow row;
    row.y = i * 1e-4;
    row.a_wheel = 0.75;
    row.a_rail = 0.75 + row.y;
    row.r = 0.46;
    row.c11 = 4.2;
    row.c22 = 3.7;
    row.c23 = 1.5;
    row.a_e = 6e-3;
    row.b_e = 4e-3;
    row.q0 = 70e-6;
    row.n0 = 40e3;
    table.rows.push_back(row);
  }
  return table;
}

std::vector<WagonSample> WagonSamples() {
  using enum Suspension;
  using enum Penetration;
  using enum SampleLinks;
  const auto with = [](Suspension suspension, Penetration penetration, bool printed_roll, bool guidance, double mu) {
    return WagonOptions{.suspension = suspension,
                        .penetration = penetration,
                        .guidance = guidance,
                        .mu = mu,
                        .printed_roll = printed_roll};
  };
  return {
      {"parabolic", false, false, false, kPlain, with(kParabolic, kTouching, false, true, 0.15)},
      {"parabolic_loaded_off_centre", true, true, true, kExtended, with(kParabolic, kTouching, false, true, 0.3)},
      {"parabolic_printed", false, true, false, kAlike, with(kParabolic, kPrinted, true, false, 0.15)},
      {"leaf", true, false, false, kPlain, with(kLeaf, kTouching, false, true, 0.15)},
      {"leaf_printed_off_centre", false, false, true, kExtended, with(kLeaf, kPrinted, false, true, 0.2)},
      {"linear", false, false, true, kPlain, with(kLinear, kTouching, true, true, 0.15)},
      {"linear_no_guidance", true, true, false, kAlike, with(kLinear, kTouching, false, false, 0.4)},
      {"parabolic_printed_jumps", true, false, false, kPlain, with(kParabolic, kPrinted, false, true, 0.15)},
      {"leaf_alike", false, false, false, kAlike, with(kLeaf, kTouching, false, true, 0.15)},
  };
}

void PrintTo(const WagonSample& sample, std::ostream* out) { *out << sample.name; }

Wagon MakeWagon(const WagonSample& sample, const ContactTable& table) {
  std::array<CornerLinks, kCorners> links;
  for (std::size_t i = 0; i < kCorners; ++i) links[i] = MakeLinks(sample.links, i);
  return {MakeData(), MakeBody(sample), sample.loaded, links, table, sample.options};
}
Wagon MakeWagon(const WagonSample& sample) { return MakeWagon(sample, MakeSampleTable(sample.jumps)); }

double RandomStates::Spread(double size) {
  const double sign = Uniform(-1, 1) < 0 ? -1 : 1;
  return sign * size * std::pow(10, Uniform(-3, 0));
}

WagonState RandomStates::Draw(const Wagon& wagon, double V, Region region) {
  WagonState state;
  DrawBody(region, &state.x);
  for (std::size_t axle = 0; axle < kAxles; ++axle) DrawWheelset(wagon, V, region, axle, &state.x);
  for (std::size_t i = 0; i < kCorners; ++i) {
    state.x[kLeafForces + i] = wagon.corners[i].load * Uniform(0.6, 1.4);
    const CornerDeflection<double> d = CalcDeflection(wagon, state.x, i);
    state.links.longitudinal[i] = DrawLink(wagon.longitudinal[i], d.dx, d.vx);
    state.links.lateral[i] = DrawLink(wagon.lateral[i], d.dy, d.vy);
  }
  return state;
}

double RandomStates::DrawDisplacement(const ContactCurve& curve, Region region) {
  const double side = Uniform(-1, 1) < 0 ? -1 : 1;
  if (region == Region::kFlange) return side * Uniform(5e-3, 9.5e-3);
  if (region == Region::kJump) {
    std::vector<std::size_t> cells;
    for (std::size_t cell = 0; cell < curve.cells(); ++cell)
      if (curve.after_jump(cell) != nullptr) cells.push_back(cell);
    if (!cells.empty()) {
      const std::size_t cell = cells[static_cast<std::size_t>(random_() % cells.size())];
      return side * (curve.y_min() + (static_cast<double>(cell) + Uniform(0, 1)) * curve.width());
    }
  }
  return Uniform(-5e-3, 5e-3);
}

void RandomStates::DrawWheelset(const Wagon& wagon, double V, Region region, std::size_t axle, StateVector<double>* x) {
  const auto at = [&](wheelset::Index i) -> double& { return (*x)[axle * wheelset::kSize + i]; };
  at(wheelset::kX) = Uniform(-5e-3, 5e-3);
  if (region == Region::kGuides) at(wheelset::kX) *= 8;
  const ContactCurve& curve = wagon.contact;
  at(wheelset::kY) = DrawDisplacement(curve, region);
  const double y = at(wheelset::kY);
  const ContactCurve::Place place = curve.Find(y);
  const KinematicPose<double> touching = ContactCurve::Evaluate(curve.pose_cubic(place.cell), curve.Local(y, place));
  const bool printed = wagon.options.penetration == Penetration::kPrinted;  // z and phi count from the static state
  at(wheelset::kZ) = (printed ? 0 : touching.z) - Uniform(2e-5, 1.2e-4);
  at(wheelset::kPhi) = touching.phi * (printed ? Uniform(0, 1) : 1) + Uniform(-3e-5, 3e-5);
  if (region == Region::kLifted) {
    at(wheelset::kZ) += Uniform(-1e-4, 3e-4);
    at(wheelset::kPhi) += Uniform(-4e-4, 4e-4);
  }

  at(wheelset::kPsi) = Spread(8e-3);
  at(wheelset::kXRate) = Spread(0.01 * V);
  at(wheelset::kYRate) = Spread(0.01 * V);
  at(wheelset::kZRate) = Spread(0.05);
  at(wheelset::kPhiRate) = Spread(0.05);
  at(wheelset::kBeta) = Spread(0.01 * V / wagon.r0);
  at(wheelset::kPsiRate) = Spread(0.01 * V);
}

void RandomStates::DrawBody(Region region, StateVector<double>* x) {
  const auto at = [&](body::Index i) -> double& { return (*x)[kBody + i]; };
  const double far = region == Region::kGuides ? 3 : 1;
  at(body::kY) = far * Uniform(-0.01, 0.01);
  at(body::kZ) = Uniform(-0.02, 0.02);  // passes the stage of the parabolic spring
  at(body::kPhi) = Uniform(-0.01, 0.01);
  at(body::kPsi) = Uniform(-1e-3, 1e-3);
  at(body::kYRate) = Uniform(-0.2, 0.2);
  at(body::kZRate) = Uniform(-0.1, 0.1);
  at(body::kPhiRate) = Uniform(-0.1, 0.1);
  at(body::kPsiRate) = Uniform(-0.03, 0.03);
}

LinkState RandomStates::DrawLink(const Link& link, double d, double v) {
  std::vector<double> T;
  for (const ExtendedSlider<double>& slider : link.sliders()) {
    const double bound = link.load() * slider.k * slider.y_c;
    // A third slides if the motion goes that way, a third is at the bound against it or sticks anywhere.
    T.push_back(bound * std::clamp(Uniform(-1.5, 1.5), -1.0, 1.0));
  }
  return LinkState::WithForces(link, d, v, T);
}

bool ChangesSignInMirror(std::size_t i) {
  if (i >= kMotions) return false;
  if (i >= kBody) {
    const std::size_t own = i - kBody;
    return own != body::kZ && own != body::kZRate;
  }
  const std::size_t own = i % wheelset::kSize;
  return own == wheelset::kY || own == wheelset::kYRate || own == wheelset::kPhi || own == wheelset::kPhiRate ||
         own == wheelset::kPsi || own == wheelset::kPsiRate;
}

StateVector<double> Mirror(const StateVector<double>& x) {
  StateVector<double> image{};
  for (std::size_t i = 0; i < kMotions; ++i) image[i] = ChangesSignInMirror(i) ? -x[i] : x[i];
  for (std::size_t i = 0; i < kCorners; ++i) image[kLeafForces + i] = x[kLeafForces + Opposite(i)];
  return image;
}

WagonState Mirror(const Wagon& wagon, const WagonState& state) {
  WagonState image;
  image.t = state.t;
  image.x = Mirror(state.x);
  for (std::size_t i = 0; i < kCorners; ++i) {
    const std::size_t j = Opposite(i);
    const CornerDeflection<double> d = CalcDeflection(wagon, state.x, i);
    image.links.longitudinal[j] =
        MirrorLink(wagon.longitudinal[i], state.links.longitudinal[i], wagon.longitudinal[j], d.dx, d.vx, 1);
    image.links.lateral[j] = MirrorLink(wagon.lateral[i], state.links.lateral[i], wagon.lateral[j], d.dy, d.vy, -1);
  }
  return image;
}

}  // namespace uiclink
