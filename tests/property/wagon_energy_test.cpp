// The energy of a whole run. In the frame that moves with the wagon the kinetic energy of wheelsets and body changes by
// the power of contact, links, springs, guidance and weight, at every moment to rounding; and over a run the energies
// that are stored change by what joints and dampers lose and the contact puts in, to the integrator's tolerance.
//
// The frame moves at the constant V, so it is inertial: the rails run backwards through it, and what a locomotive
// gives is the power -V X of the contact forces (ContactPower below). Wheelsets turn with chi' = V/r0 + beta.
//
// Rotations are of first order (appendix C: R = 1 + theta x). The equations of motion use R on both sides of a force,
// v + R(w x p): so the virtual power of their forces is exact. The deflections of links, springs and guidance have
// w x p alone. What is between, P . theta x (w x p), is no error of the run but a work of the forces that no spring
// knows: the inverted pendulum of the body on its springs, m_c g h phi phi', and terms of its size with yaw. It is
// computed here for what it is, term by term, so that no tolerance has to cover it.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/wagon_fixture.h"
#include "vehicle/equilibrium.h"
#include "vehicle/simulation.h"
#include "vehicle/vertical_spring.h"

namespace uiclink {
namespace {

using Eigen::Vector3d;

std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

constexpr double kSpeed = 20;

/// A sum with the sum of the sizes of its terms, for a bound on its rounding.
struct Sum {
  double value = 0, size = 0;
  void Add(double term) {
    value += term;
    size += std::abs(term);
  }
  void Add(const Vector3d& a, const Vector3d& b) {
    for (int i = 0; i < 3; ++i) Add(a[i] * b[i]);
  }
};

/// A wheelset or the body: velocity, angles, their rates; angular velocity with the rolling of a wheelset.
struct Body {
  Vector3d v, theta, omega;
};
Body WheelsetOf(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t axle) {
  const auto at = [&](std::size_t i) { return x[axle * wheelset::kSize + i]; };
  return {.v = {at(wheelset::kXRate), at(wheelset::kYRate), at(wheelset::kZRate)},
          .theta = {at(wheelset::kPhi), 0, at(wheelset::kPsi)},
          .omega = {at(wheelset::kPhiRate), V / wagon.r0 + at(wheelset::kBeta), at(wheelset::kPsiRate)}};
}
Body CarOf(const StateVector<double>& x) {
  const auto at = [&](std::size_t i) { return x[kBody + i]; };
  return {.v = {0, at(body::kYRate), at(body::kZRate)},
          .theta = {at(body::kPhi), 0, at(body::kPsi)},
          .omega = {at(body::kPhiRate), 0, at(body::kPsiRate)}};
}
/// Accelerations are the velocities in the rate of the state.
Body AccelerationOfWheelset(const Wagon& wagon, const StateVector<double>& rate, std::size_t axle) {
  return WheelsetOf(wagon, 0, rate, axle);
}

/// What the first-order rotation adds to the velocity w x p of a point.
Vector3d SecondOrderVelocity(const Body& body, const Vector3d& p) { return body.theta.cross(body.omega.cross(p)); }

/// The rate of the kinetic energy.
Sum KineticPower(const Wagon& wagon, double V, const StateVector<double>& x, const StateVector<double>& rate) {
  Sum sum;
  const WheelsetInertia& w = wagon.wheelset;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const Body m = WheelsetOf(wagon, V, x, axle), a = AccelerationOfWheelset(wagon, rate, axle);
    sum.Add(w.m * m.v, a.v);
    sum.Add(Vector3d(w.I_x, w.I_y, w.I_z).cwiseProduct(m.omega), a.omega);
  }
  const Body m = CarOf(x), a = CarOf(rate);
  sum.Add(wagon.body.m * m.v, a.v);
  sum.Add(Vector3d(wagon.body.I_x, 0, wagon.body.I_z).cwiseProduct(m.omega), a.omega);
  return sum;
}

double KineticEnergy(const Wagon& wagon, double V, const StateVector<double>& x) {
  const WheelsetInertia& w = wagon.wheelset;
  double twice = 0;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const Body m = WheelsetOf(wagon, V, x, axle);
    // The pitch from that of V/r0 on: the rest is constant, and 1e5 times as large as what changes.
    const double beta = x[axle * wheelset::kSize + wheelset::kBeta];
    twice += w.m * m.v.squaredNorm() + w.I_x * m.omega.x() * m.omega.x() + w.I_z * m.omega.z() * m.omega.z() +
             w.I_y * beta * (2 * V / wagon.r0 + beta);
  }
  const Body m = CarOf(x);
  return 0.5 * (twice + wagon.body.m * m.v.squaredNorm() + wagon.body.I_x * m.omega.x() * m.omega.x() +
                wagon.body.I_z * m.omega.z() * m.omega.z());
}

void AddContactPower(const Wagon& wagon, double V, const StateVector<double>& x, const WagonForces& forces, Sum* sum) {
  for (std::size_t i = 0; i < kCorners; ++i) {
    const WagonForces::Wheel& f = forces.wheels[i];
    const Body m = WheelsetOf(wagon, V, x, AxleOf(i));
    sum->Add({f.X, f.Y, f.Q}, m.v);
    sum->Add({f.roll, f.pitch, f.yaw}, m.omega);
  }
}

/// Force of link, guidance and spring on the wheelset.
Vector3d ForceAt(const WagonForces& f, std::size_t i) {
  return {f.link_x[i] + f.guide_x[i], f.link_y[i] + f.guide_y[i], -f.spring[i]};
}
Vector3d DeflectionRate(const Wagon& wagon, const StateVector<double>& x, std::size_t i) {
  const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
  return {d.vx, d.vy, d.vs};
}
Vector3d SecondOrderDeflectionRate(const Wagon& wagon, double V, const StateVector<double>& x, std::size_t i) {
  const Vector3d on_axle(0, SideOf(i) * wagon.b, 0);
  const Vector3d on_car(wagon.corners[i].X, wagon.corners[i].Y, -wagon.body.h);
  return SecondOrderVelocity(WheelsetOf(wagon, V, x, AxleOf(i)), on_axle) - SecondOrderVelocity(CarOf(x), on_car);
}

void AddWeightPower(const Wagon& wagon, const StateVector<double>& x, Sum* sum) {
  for (std::size_t axle = 0; axle < kAxles; ++axle)
    sum->Add(-wagon.wheelset.m * wagon.g * x[axle * wheelset::kSize + wheelset::kZRate]);
  sum->Add(-wagon.body.m * wagon.g * x[kBody + body::kZRate]);
}

// ---------------------------------------------------------------------------------------------------------------------

struct Choice {
  const char* name;
  const char* set;
  const char* freight;
  const char* geometry;  ///< null: the knife edges of the fixture
  Suspension suspension = Suspension::kParabolic;
  double off_centre = 0;  ///< of the freight, to the left and (four times as far) ahead [m]
  bool impacts = true;    ///< of the rear wheelset, in settled hunting at 20 m/s
};
void PrintTo(const Choice& choice, std::ostream* out) { *out << choice.name; }

Wagon MakeWagon(const Choice& choice) {
  WagonFixture fixture{.set = choice.set, .freight = choice.freight, .options = {}};
  fixture.options.suspension = choice.suspension;
  const ContactTable table = choice.geometry == nullptr
                                 ? MakeHandMadeTable()
                                 : CalcContactTable(ReadTrackGeometry(WagonFixture::Data() / "geometry" /
                                                                      (std::string(choice.geometry) + ".toml")));
  const CornerLinks links = fixture.ReadLinks();
  BodyInertia body = fixture.ReadBody();
  body.y = choice.off_centre;
  body.x = 4 * choice.off_centre;
  return Wagon(fixture.ReadData(), body, fixture.freight != "empty", {links, links, links, links}, table,
               fixture.options);
}

constexpr Perturbation kPush{.front_y = 4e-3, .rear_y = 4e-3, .body_y = 18e-3, .body_phi = 2e-3};

class WagonPower : public testing::TestWithParam<Choice> {};

TEST_P(WagonPower, OfAllForcesIsTheRateOfTheKineticEnergy) {
  const Wagon wagon = MakeWagon(GetParam());
  Integrator integrator(wagon);
  integrator.Start(kSpeed, Perturb(wagon, FindEquilibrium(wagon, kSpeed), kPush));
  double worst = 0, largest = 0;
  while (integrator.state().t < 3) {
    integrator.Step(3);
    const StateVector<double>& x = integrator.state().x;
    const WagonForces& forces = integrator.forces();
    const Sum kinetic = KineticPower(wagon, kSpeed, x, integrator.rate());
    Sum power;
    AddContactPower(wagon, kSpeed, x, forces, &power);
    for (std::size_t i = 0; i < kCorners; ++i)
      power.Add(ForceAt(forces, i), DeflectionRate(wagon, x, i) + SecondOrderDeflectionRate(wagon, kSpeed, x, i));
    AddWeightPower(wagon, x, &power);
    // Each term is a product of three or four numbers, and there are some ninety of them, most of which cancel.
    const double rounding = 100 * std::numeric_limits<double>::epsilon() * (power.size + kinetic.size);
    ASSERT_NEAR(kinetic.value, power.value, rounding) << "at " << integrator.state().t << " s";
    worst = std::max(worst, std::abs(kinetic.value - power.value) / rounding);
    largest = std::max(largest, std::abs(kinetic.value));
  }
  EXPECT_GT(largest, 100);  // W
  Measured() << GetParam().name << ": up to " << largest << " W, off by " << worst << " of what rounding explains\n";
}

/// Where the power of a wheel goes: creep takes V (F_x xi_x + F_y xi_y), the approach N times the speed along the
/// normal, the rails give -V X, and the contact frame is turned against the track (f_R - f_W):
///   X x' + .. + yaw psi' = V (F_x xi_x + F_y xi_y) + N v_n - V X + (f_R - f_W) . v
TEST_P(WagonPower, OfAWheelIsCreepApproachAndTraction) {
  const Wagon wagon = MakeWagon(GetParam());
  Integrator integrator(wagon);
  integrator.Start(kSpeed, Perturb(wagon, FindEquilibrium(wagon, kSpeed), kPush));
  long looked_at = 0;
  while (integrator.state().t < 3) {
    integrator.Step(3);
    const StateVector<double>& x = integrator.state().x;
    for (std::size_t i = 0; i < kCorners; ++i) {
      const double e = SideOf(i);
      const ContactCurve::Place place = wagon.contact.Find(e * x[AxleOf(i) * wheelset::kSize + wheelset::kY]);
      if (wagon.contact.after_jump(place.cell) != nullptr) continue;  // two contacts
      ++looked_at;
      const WheelContact<double> c = ContactCurve::Evaluate(wagon.contact.cubic(place.cell), place.t);
      const WagonForces::Wheel& f = integrator.forces().wheels[i];
      const Body m = WheelsetOf(wagon, kSpeed, x, AxleOf(i));
      const Vector3d p(0, e * c.a, -c.r), normal(0, -e * c.sin_delta, c.cos_delta);
      const Vector3d across(0, c.cos_delta, e * c.sin_delta);
      const Vector3d f_R(f.X, f.Y, f.Q), f_W = Vector3d(f.F_x, 0, 0) + f.F_y * across + f.N * normal;
      const Vector3d point = Vector3d(kSpeed, -kSpeed * m.theta.z(), 0) + m.v + m.omega.cross(p);
      Sum power, parts;
      power.Add(f_R, m.v);
      power.Add({f.roll, f.pitch, f.yaw}, m.omega);
      parts.Add(kSpeed * f.F_x * f.xi_x);
      parts.Add(kSpeed * f.F_y * f.xi_y);
      parts.Add(f.N * normal, point);
      parts.Add(-kSpeed * f.X);
      parts.Add(f_R - f_W, m.v);
      // xi_x is the difference of numbers of the order of one.
      const double rounding = 100 * std::numeric_limits<double>::epsilon() *
                              (power.size + parts.size + kSpeed * (std::abs(f.F_x) + std::abs(f.F_y) + f.N));
      ASSERT_NEAR(power.value, parts.value, rounding) << "corner " << i << " at " << integrator.state().t << " s";
    }
  }
  EXPECT_GT(looked_at, 1000);
}

INSTANTIATE_TEST_SUITE_P(
    Wagons, WagonPower,
    testing::Values(Choice{"set1_empty_edges", "set1", "empty", nullptr},
                    Choice{"set2_packed_edges", "set2", "packed", nullptr},
                    Choice{"set1_empty_profiles", "set1", "empty", "thesis-equivalent"},
                    Choice{"set1_linear", "set1", "empty", "thesis-equivalent-rigid", Suspension::kLinear},
                    Choice{"set2_leaf", "set2", "empty", "nominal-1435", Suspension::kLeaf},
                    Choice{"set1_uneven", "set1", "packed", "thesis-equivalent", Suspension::kParabolic, 0.05}),
    [](const auto& test) { return std::string(test.param.name); });

// ---------------------------------------------------------------------------------------------------------------------
// Whole runs.

/// Energy of main springs and joints of a link [J].
double LinkEnergy(const Link& link, const LinkState& state, double d, double v) {
  double energy = 0.5 * link.load() * link.law().k * d * d;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    const double spring = d - state.CalcPosition(link, i, d, v);
    energy += 0.5 * link.load() * link.sliders()[i].k * spring * spring;
  }
  return energy;
}

/// What the joints lose while the link moves from d0 to d1 in one mode [J].
double SlipLoss(const Link& link, const LinkState& state, double d0, double v0, double d1, double v1) {
  double loss = 0;
  for (std::size_t i = 0; i < link.sliders().size(); ++i) {
    const ExtendedSlider<double>& slider = link.sliders()[i];
    const double slip = state.CalcPosition(link, i, d1, v1) - state.CalcPosition(link, i, d0, v0);
    loss += link.load() * slider.k * slider.y_c * std::abs(slip);
  }
  return loss;
}

double GuideEnergy(const GuidanceStop& stop, double d) {
  const double beyond = std::max(std::abs(d) - stop.clearance, 0.0);
  return 0.5 * stop.k * beyond * beyond;
}

/// What springs, links, guidance and height store [J].
double StoredEnergy(const Wagon& wagon, const StateVector<double>& x, const LinkStates& links) {
  double energy = wagon.body.m * wagon.g * x[kBody + body::kZ];
  for (std::size_t axle = 0; axle < kAxles; ++axle)
    energy += wagon.wheelset.m * wagon.g * x[axle * wheelset::kSize + wheelset::kZ];
  for (std::size_t i = 0; i < kCorners; ++i) {
    const CornerDeflection<double> d = CalcDeflection(wagon, x, i);
    energy += wagon.options.suspension == Suspension::kParabolic ? CalcSpringEnergy(wagon.parabolic, d.s)
                                                                 : 0.5 * wagon.linear.k * d.s * d.s;
    energy += LinkEnergy(wagon.longitudinal[i], links.longitudinal[i], d.dx, d.vx);
    energy += LinkEnergy(wagon.lateral[i], links.lateral[i], d.dy, d.vy);
    energy += GuideEnergy(wagon.guidance.longitudinal, d.dx) + GuideEnergy(wagon.guidance.lateral, d.dy);
  }
  return energy;
}

/// Powers that are integrated along a run [W].
struct Powers {
  double contact = 0, dampers = 0, second_order = 0, traction = 0;
  Powers& operator+=(const Powers& p) {
    contact += p.contact;
    dampers += p.dampers;
    second_order += p.second_order;
    traction += p.traction;
    return *this;
  }
  friend Powers operator*(double s, const Powers& p) {
    return {s * p.contact, s * p.dampers, s * p.second_order, s * p.traction};
  }
};
Powers CalcPowers(const Wagon& wagon, double V, const StateVector<double>& x, const WagonForces& forces) {
  Powers p;
  Sum contact;
  AddContactPower(wagon, V, x, forces, &contact);
  p.contact = contact.value;
  const double d = wagon.options.suspension == Suspension::kParabolic ? wagon.parabolic_damping : wagon.linear.d;
  for (std::size_t i = 0; i < kCorners; ++i) {
    const double vs = CalcDeflection(wagon, x, i).vs;
    p.dampers += d * vs * vs;
    p.second_order += ForceAt(forces, i).dot(SecondOrderDeflectionRate(wagon, V, x, i));
    p.traction -= V * forces.wheels[i].X;
  }
  return p;
}

/// The change of stored and kinetic energy and of what joints have lost with the end of a step, along the scales of the
/// error control: what an error of size one would make of it [J].
double CalcSensitivity(const Wagon& wagon, double V, const StateVector<double>& x, const StateVector<double>& rate,
                       const WagonForces& forces, const StateVector<double>& scales) {
  StateVector<double> gradient{};
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    const std::size_t at = axle * wheelset::kSize;
    const WheelsetInertia& w = wagon.wheelset;
    const Body m = WheelsetOf(wagon, V, x, axle), a = AccelerationOfWheelset(wagon, rate, axle);
    Vector3d force = -w.m * a.v, moment = -Vector3d(w.I_x, w.I_y, w.I_z).cwiseProduct(a.omega);
    for (const std::size_t i : {2 * axle, 2 * axle + 1}) {
      const WagonForces::Wheel& f = forces.wheels[i];
      force += Vector3d(f.X, f.Y, f.Q);
      moment += Vector3d(f.roll, f.pitch, f.yaw);
    }
    gradient[at + wheelset::kX] = force.x();
    gradient[at + wheelset::kY] = force.y();
    gradient[at + wheelset::kZ] = force.z();
    gradient[at + wheelset::kPhi] = moment.x();
    gradient[at + wheelset::kPsi] = moment.z();
    gradient[at + wheelset::kXRate] = w.m * m.v.x();
    gradient[at + wheelset::kYRate] = w.m * m.v.y();
    gradient[at + wheelset::kZRate] = w.m * m.v.z();
    gradient[at + wheelset::kPhiRate] = w.I_x * m.omega.x();
    gradient[at + wheelset::kBeta] = w.I_y * m.omega.y();
    gradient[at + wheelset::kPsiRate] = w.I_z * m.omega.z();
  }
  const Body m = CarOf(x), a = CarOf(rate);
  const BodyInertia& b = wagon.body;
  gradient[kBody + body::kY] = -b.m * a.v.y();
  gradient[kBody + body::kZ] = -b.m * a.v.z();
  gradient[kBody + body::kPhi] = -b.I_x * a.omega.x();
  gradient[kBody + body::kPsi] = -b.I_z * a.omega.z();
  gradient[kBody + body::kYRate] = b.m * m.v.y();
  gradient[kBody + body::kZRate] = b.m * m.v.z();
  gradient[kBody + body::kPhiRate] = b.I_x * m.omega.x();
  gradient[kBody + body::kPsiRate] = b.I_z * m.omega.z();
  double square = 0;
  for (std::size_t i = 0; i < kMotions; ++i) square += gradient[i] * gradient[i] * scales[i] * scales[i];
  return std::sqrt(square);
}

struct Balance {
  double residual = 0;   ///< largest along the run [J]
  double bound = 0;      ///< at the end [J]
  double exchanged = 0;  ///< what the joints have lost [J]
  Powers work;           ///< [J]
  double largest_second_order = 0;
  long events = 0, impacts = 0;
};

Balance RunBalance(const Wagon& wagon, const WagonState& start, double duration, double tolerance) {
  IntegratorOptions options;
  options.tolerance = tolerance;
  Integrator integrator(wagon, options);
  integrator.Start(kSpeed, start);
  const StateVector<double> scales = CalcErrorScales(wagon);
  const double end = start.t + duration;
  StateVector<double> before = integrator.state().x;
  double energy = StoredEnergy(wagon, before, integrator.state().links) + KineticEnergy(wagon, kSpeed, before);
  const double at_start = energy;
  Powers power = CalcPowers(wagon, kSpeed, before, integrator.forces());
  Balance balance;
  bool touched = false;
  // The rounding of the largest single energy, that of the springs under the wagon's weight: 1e4 J.
  balance.bound = 1e-11;
  while (integrator.state().t < end) {
    const double t = integrator.state().t;
    const Advance advance = integrator.Step(end);
    const double h = integrator.state().t - t;
    const StateVector<double>& x = integrator.state().x;
    const LinkStates& mode = integrator.step_links();
    for (std::size_t i = 0; i < kCorners; ++i) {
      const CornerDeflection<double> d0 = CalcDeflection(wagon, before, i), d1 = CalcDeflection(wagon, x, i);
      balance.exchanged += SlipLoss(wagon.longitudinal[i], mode.longitudinal[i], d0.dx, d0.vx, d1.dx, d1.vx);
      balance.exchanged += SlipLoss(wagon.lateral[i], mode.lateral[i], d0.dy, d0.vy, d1.dy, d1.vy);
    }
    // Simpson's rule; the middle, from the interpolant, is as good as a step of order 4. The trapezoidal rule corrected
    // by the slopes of the powers, which interpolates nothing, gives the same residuals to 3 %: they are the run's own.
    StateVector<double> middle, unused;
    WagonForces forces;
    integrator.Interpolate(t + 0.5 * h, &middle);
    CalcForces(wagon, kSpeed, mode, middle, &unused, &forces);
    const Powers now = CalcPowers(wagon, kSpeed, x, integrator.forces());
    balance.work += (h / 6) * power;
    balance.work += (4 * h / 6) * CalcPowers(wagon, kSpeed, middle, forces);
    balance.work += (h / 6) * now;
    power = now;
    before = x;
    energy = StoredEnergy(wagon, x, integrator.state().links) + KineticEnergy(wagon, kSpeed, x);
    balance.largest_second_order = std::max(balance.largest_second_order, std::abs(balance.work.second_order));
    const double residual =
        energy - at_start + balance.exchanged + balance.work.dampers - balance.work.contact - balance.work.second_order;
    balance.residual = std::max(balance.residual, std::abs(residual));
    balance.bound += tolerance * std::sqrt(static_cast<double>(kMaxState)) *
                     CalcSensitivity(wagon, kSpeed, x, integrator.rate(), integrator.forces(), scales);
    balance.events += advance == Advance::kEvent;
    const bool touches = integrator.forces().guide_y[2] != 0;
    balance.impacts += touches && !touched;
    touched = touches;
  }
  return balance;
}

class WagonEnergy : public testing::TestWithParam<Choice> {};

TEST_P(WagonEnergy, IsKeptOverARun) {
  const Wagon wagon = MakeWagon(GetParam());
  SimulationOptions settle;
  settle.duration = 20;
  const WagonState start = Simulate(wagon, kSpeed, Perturb(wagon, FindEquilibrium(wagon, kSpeed), kPush), settle).state;
  std::vector<double> residuals;
  for (const double tolerance : {1e-6, 1e-7, 1e-8, 1e-9}) {
    const Balance b = RunBalance(wagon, start, 4, tolerance);
    Measured() << GetParam().name << ", tolerance " << tolerance << ": residual " << b.residual << " J, bound "
               << b.bound << " J; joints lost " << b.exchanged << " J, dampers " << b.work.dampers
               << " J, contact gave " << b.work.contact << " J (of " << b.work.traction
               << " J from the rails), second-order rotation " << b.work.second_order << " J (largest "
               << b.largest_second_order << " J); " << b.events << " events, " << b.impacts
               << " impacts of the rear wheelset\n";
    // The error of a step is kept to the tolerance in the root mean square over the state, by the scales; the bound is
    // what that can make of the energy, all errors in the worst direction.
    EXPECT_LT(b.residual, b.bound);
    EXPECT_GT(b.exchanged, 1);
    EXPECT_GT(b.events, 20);
    EXPECT_EQ(b.impacts > 3, GetParam().impacts);
    residuals.push_back(b.residual);
  }
  // In proportion to the tolerance it would fall by 1000; it does by 110 to 2100, because steps that are bound by
  // stability do not shrink with the tolerance, and the corners of the contact curves have an order of their own.
  EXPECT_LT(residuals.back(), residuals.front() / 50);
}

INSTANTIATE_TEST_SUITE_P(Wagons, WagonEnergy,
                         testing::Values(Choice{"set1_empty_edges", "set1", "empty", nullptr},
                                         Choice{"set1_empty_profiles", "set1", "empty", "thesis-equivalent"},
                                         Choice{.name = "set1_empty_rigid",
                                                .set = "set1",
                                                .freight = "empty",
                                                .geometry = "thesis-equivalent-rigid",
                                                .suspension = Suspension::kParabolic,
                                                .off_centre = 0,
                                                .impacts = false},
                                         Choice{"set1_packed_edges", "set1", "packed", nullptr}),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace uiclink
