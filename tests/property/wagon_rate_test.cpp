// The right-hand side of the wagon against a second one, written from the thesis in vector form
// (tests/support/wagon_reference.h), and against what must hold whatever its formulas are.

#include "vehicle/wagon_rate.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "tests/support/wagon_reference.h"
#include "tests/support/wagon_samples.h"

namespace uiclink {
namespace {

using Matrix = Eigen::Matrix<double, kMaxState, kMaxState>;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

StateVector<double> Rate(const Wagon& wagon, double V, const WagonState& state) {
  StateVector<double> rate{};
  CalcRate(wagon, V, state.links, state.x, &rate);
  return rate;
}

/// |a - b| by `size`; zero where they are equal, infinite where there is no number.
double Distance(double a, double b, double size) {
  const double difference = std::abs(a - b);
  if (difference == 0) return 0;
  return std::isfinite(difference) ? difference / size : kInfinity;
}

/// The largest of many distances and where it was.
struct Worst {
  double distance = 0;
  std::string where;

  void Add(double candidate, const std::string& place) {
    if (candidate <= distance) return;
    distance = candidate;
    where = place;
  }
};

/// A seed of its own for every wagon.
unsigned SeedOf(const WagonSample& sample, unsigned seed) {
  for (const char c : sample.name) seed = 31 * seed + static_cast<unsigned char>(c);
  return seed;
}

/// Speeds and states of all regions for one wagon, one after the other.
template <typename Visit>
void ForEachState(const Wagon& wagon, unsigned seed, int per_region, Visit visit) {
  RandomStates random(seed);
  for (const Region region : kRegions) {
    for (int i = 0; i < per_region; ++i) {
      const double V = random.Uniform(1, 50);
      const WagonState state = random.Draw(wagon, V, region);
      visit(V, state, "region " + std::to_string(static_cast<int>(region)) + ", state " + std::to_string(i));
    }
  }
}

bool IsAtJump(const Wagon& wagon, const StateVector<double>& x, std::size_t corner) {
  const double y = SideOf(corner) * x[AxleOf(corner) * wheelset::kSize + wheelset::kY];
  return wagon.contact.after_jump(wagon.contact.Find(y).cell) != nullptr;
}

class EveryWagon : public testing::TestWithParam<WagonSample> {
 protected:
  const Wagon wagon_ = MakeWagon(GetParam());
};

// Both sides round differently: some 1e-16 of the terms themselves, more where these are differences already. In the
// touching form the approach is one of 1e-3 m; the creepages, down to 1e-6, are differences from 1. Found: 1e-10. In
// the printed form the approach is a difference of distances of 0.75 m: 1e-16 m of as little as 3e-7 m. Found: 5e-10.
constexpr double kAgreement = 1e-9;

TEST_P(EveryWagon, HasTheRateOfTheReference) {
  Worst worst;
  for (const unsigned seed : {1U, 2U, 3U}) {
    ForEachState(
        wagon_, SeedOf(GetParam(), seed), 200, [&](double V, const WagonState& state, const std::string& place) {
          const StateVector<double> rate = Rate(wagon_, V, state);
          const ReferenceRate expected = CalcReferenceRate(wagon_, V, state.links, state.x);
          for (std::size_t i = 0; i < wagon_.size(); ++i) {
            worst.Add(Distance(rate[i], expected.rate[i], expected.largest[i]),
                      std::string("rate of ") + kStateNames[i] + " at seed " + std::to_string(seed) + ", " + place);
          }
        });
  }
  EXPECT_LE(worst.distance, kAgreement) << worst.where;
  RecordProperty("worst", std::to_string(worst.distance * 1e12) + "e-12");
}

TEST_P(EveryWagon, HasTheForcesOfTheReference) {
  Worst worst;
  ForEachState(wagon_, SeedOf(GetParam(), 4), 200, [&](double V, const WagonState& state, const std::string& place) {
    StateVector<double> rate{};
    WagonForces forces;
    CalcForces(wagon_, V, state.links, state.x, &rate, &forces);
    EXPECT_EQ(rate, Rate(wagon_, V, state));
    const ReferenceRate expected = CalcReferenceRate(wagon_, V, state.links, state.x);
    for (std::size_t i = 0; i < kCorners; ++i) {
      const WagonForces::Wheel& wheel = forces.wheels[i];
      const ReferenceRate::Wheel& reference = expected.wheels[i];
      const auto compare = [&](double a, double b, double size, const char* what) {
        worst.Add(Distance(a, b, size), std::string(what) + " of corner " + std::to_string(i) + " at " + place);
      };
      const double load = std::max(reference.N, 1e3);
      compare(wheel.Q, reference.force.z(), load, "Q");
      compare(wheel.Y, reference.force.y(), load, "Y");
      compare(forces.guide_x[i], expected.guide[i].x(), 1e3, "guide_x");
      compare(forces.guide_y[i], expected.guide[i].y(), 1e3, "guide_y");
      if (IsAtJump(wagon_, state.x, i)) continue;  // two contacts: what is said of them is not compared
      compare(wheel.q, reference.q, 1e-5, "q");
      if (reference.q <= 0) continue;  // a lifted wheel has no creepage
      compare(wheel.N, reference.N, load, "N");
      compare(wheel.F_x, reference.F_x, load, "F_x");
      compare(wheel.F_y, reference.F_y, load, "F_y");
      compare(wheel.xi_x, reference.xi_x, 1e-3, "xi_x");
      compare(wheel.xi_y, reference.xi_y, 1e-3, "xi_y");
      compare(wheel.xi_s, reference.xi_s, 1e-1, "xi_s");
    }
  });
  EXPECT_LE(worst.distance, kAgreement) << worst.where;
}

/// Steps for differences by state: positions, then velocities; small beside approach (1e-5 m) and creep (1e-3 V).
double StepOf(std::size_t i) {
  if (i >= kMotions) return 10;  // N
  const bool body = i >= kBody;
  const std::size_t own = body ? i - kBody : i % wheelset::kSize;
  const bool velocity = body ? own % 2 == 1 : own % 2 == (own > wheelset::kBeta ? 0 : 1) || own == wheelset::kBeta;
  if (velocity) return body ? 1e-5 : 1e-6;
  return body ? 1e-7 : 2e-8;
}

/// Derivative of the reference by state j, central differences of fourth order.
Eigen::Matrix<double, kMaxState, 1> Differentiate(const Wagon& wagon, double V, const WagonState& state, std::size_t j,
                                                  double step) {
  const auto at = [&](double shift) {
    StateVector<double> x = state.x;
    x[j] += shift;
    const ReferenceRate all = CalcReferenceRate(wagon, V, state.links, x);
    return Eigen::Matrix<double, kMaxState, 1>(all.rate.data());
  };
  return (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
}

Matrix DifferentiateAll(const Wagon& wagon, double V, const WagonState& state, double steps) {
  Matrix J = Matrix::Zero();
  for (std::size_t j = 0; j < wagon.size(); ++j)
    J.col(static_cast<Eigen::Index>(j)) = Differentiate(wagon, V, state, j, steps * StepOf(j));
  return J;
}

/// By the dual scalar.
Matrix CalcJacobian(const Wagon& wagon, double V, const WagonState& state, StateVector<double>* value) {
  StateVector<Dual<kMaxState>> x, rate;
  for (std::size_t i = 0; i < kMaxState; ++i) x[i] = Dual<kMaxState>(state.x[i], static_cast<int>(i));
  CalcRate(wagon, V, state.links, x, &rate);
  Matrix J = Matrix::Zero();
  for (std::size_t i = 0; i < wagon.size(); ++i) {
    (*value)[i] = rate[i].a;
    J.row(static_cast<Eigen::Index>(i)) = rate[i].v.transpose();
  }
  return J;
}

/// Largest difference of two Jacobians; what a step of each state does to an equation is measured by the largest that
/// any state's step does.
double Distance(const Matrix& a, const Matrix& b, std::string* where) {
  Eigen::Matrix<double, kMaxState, 1> step;
  for (std::size_t j = 0; j < kMaxState; ++j) step[static_cast<Eigen::Index>(j)] = StepOf(j);
  const Matrix effect = b * step.asDiagonal();
  const Matrix difference = (a - b) * step.asDiagonal();
  double worst = 0;
  for (Eigen::Index i = 0; i < difference.rows(); ++i) {
    for (Eigen::Index j = 0; j < difference.cols(); ++j) {
      const double distance = Distance(difference(i, j), 0, effect.row(i).cwiseAbs().maxCoeff());
      if (distance <= worst) continue;
      worst = distance;
      *where = std::string("rate of ") + kStateNames[static_cast<std::size_t>(i)] + " by " +
               kStateNames[static_cast<std::size_t>(j)];
    }
  }
  return worst;
}

TEST_P(EveryWagon, HasAnExactJacobian) {
  // Fourth order: where differences with a step and its double agree to 1e-7, that with the step is right to 7e-9, and
  // to rounding: 1e-16 m of the printed approach by a step of 2e-8 m, 5e-9. Where they do not, a bend of the right-hand
  // side lies between (a wheel that touches, a guide, the stage of a spring, the end of a cell of the contact curve);
  // such states are left out.
  constexpr double kSmooth = 1e-7;
  constexpr double kRight = 2e-8;
  Worst worst;
  int smooth = 0;
  int all = 0;
  ForEachState(wagon_, SeedOf(GetParam(), 5), 15, [&](double V, const WagonState& state, const std::string& place) {
    ++all;
    std::string where;
    const Matrix reference = DifferentiateAll(wagon_, V, state, 1);
    if (Distance(DifferentiateAll(wagon_, V, state, 2), reference, &where) > kSmooth) return;
    ++smooth;
    StateVector<double> value{};
    const Matrix J = CalcJacobian(wagon_, V, state, &value);
    const double distance = Distance(J, reference, &where);
    worst.Add(distance, where + " at " + place);
    const StateVector<double> rate = Rate(wagon_, V, state);
    const ReferenceRate expected = CalcReferenceRate(wagon_, V, state.links, state.x);
    for (std::size_t i = 0; i < wagon_.size(); ++i)
      EXPECT_NEAR(value[i], rate[i], kAgreement * expected.largest[i]) << kStateNames[i] << " at " << place;
  });
  EXPECT_LE(worst.distance, kRight) << worst.where;
  EXPECT_GT(smooth, all * 3 / 4);
}

// Newton's third law: what acts between wheelsets and body does not move them all. Lateral and vertical, to rounding
// (found: 1e-14 of the weight).
TEST_P(EveryWagon, IsMovedAsAWholeByRailsAndWeightAlone) {
  Worst worst;
  ForEachState(wagon_, SeedOf(GetParam(), 6), 100, [&](double V, const WagonState& state, const std::string& place) {
    StateVector<double> rate{};
    WagonForces forces;
    CalcForces(wagon_, V, state.links, state.x, &rate, &forces);
    const auto sum = [&](std::size_t of_wheelset, std::size_t of_body) {
      return wagon_.wheelset.m * (rate[of_wheelset] + rate[kRearWheelset + of_wheelset]) +
             wagon_.body.m * rate[kBody + of_body];
    };
    double Q = 0;
    double Y = 0;
    for (const WagonForces::Wheel& wheel : forces.wheels) {
      Q += wheel.Q;
      Y += wheel.Y;
    }
    const double weight = (wagon_.body.m + 2 * wagon_.wheelset.m) * wagon_.g;
    worst.Add(Distance(sum(wheelset::kYRate, body::kYRate), Y, weight), "lateral at " + place);
    worst.Add(Distance(sum(wheelset::kZRate, body::kZRate), Q - weight, weight), "vertical at " + place);
  });
  EXPECT_LE(worst.distance, 1e-13) << worst.where;
}

INSTANTIATE_TEST_SUITE_P(Samples, EveryWagon, testing::ValuesIn(WagonSamples()),
                         [](const auto& sample) { return sample.param.name; });

// The states above would prove little if they missed what bends the right-hand side.
TEST(WagonRate, SamplesReachEverything) {
  std::map<std::string, int> count;
  for (const WagonSample& sample : WagonSamples()) {
    const Wagon wagon = MakeWagon(sample);
    ForEachState(wagon, SeedOf(sample, 1), 200, [&](double V, const WagonState& state, const std::string&) {
      const ReferenceRate all = CalcReferenceRate(wagon, V, state.links, state.x);
      for (std::size_t i = 0; i < kCorners; ++i) {
        const ReferenceRate::Wheel& wheel = all.wheels[i];
        count[wheel.q > 0 ? "a wheel on its rail" : "a wheel lifted"]++;
        if (wheel.q > 0) count[wheel.saturation >= 3 ? "sliding" : wheel.saturation < 1 ? "creeping" : "between"]++;
        count["a jump"] += IsAtJump(wagon, state.x, i);
        count["a guide ahead or behind"] += all.guide[i].x() != 0;
        count["a guide beside"] += all.guide[i].y() != 0;
        count[state.links.longitudinal[i].AllStick() ? "joints stick" : "joints slide"]++;
        if (sample.options.suspension == Suspension::kParabolic)
          count[CalcDeflection(wagon, state.x, i).s < wagon.parabolic.s0 ? "main leaf" : "supplementary leaf"]++;
      }
    });
  }
  EXPECT_EQ(count.size(), 12U);
  for (const auto& [what, times] : count) EXPECT_GE(times, 100) << what;
}

// --- mirror ---

std::vector<WagonSample> MirrorImages() {
  std::vector<WagonSample> alike;
  for (const WagonSample& sample : WagonSamples())
    if (sample.links == SampleLinks::kAlike && !sample.off_centre) alike.push_back(sample);
  return alike;
}

class EveryEvenWagon : public EveryWagon {};

// The image's right wheel is computed from the numbers of the original's left one. What differs is the order in which
// four corners are summed up, and the places where the image's joints stick, computed from their forces.
TEST_P(EveryEvenWagon, HasTheMirroredRateInTheMirror) {
  Worst worst;
  ForEachState(wagon_, SeedOf(GetParam(), 7), 200, [&](double V, const WagonState& state, const std::string& place) {
    const StateVector<double> expected = Mirror(Rate(wagon_, V, state));
    const WagonState image = Mirror(wagon_, state);
    const StateVector<double> rate = Rate(wagon_, V, image);
    const ReferenceRate terms = CalcReferenceRate(wagon_, V, image.links, image.x);
    for (std::size_t i = 0; i < wagon_.size(); ++i)
      worst.Add(Distance(rate[i], expected[i], terms.largest[i]), std::string(kStateNames[i]) + " at " + place);
  });
  EXPECT_LE(worst.distance, 1e-14) << worst.where;
}

TEST_P(EveryEvenWagon, StaysEvenWhenItIs) {
  RandomStates random(8);
  for (int i = 0; i < 200; ++i) {
    const double V = random.Uniform(1, 50);
    WagonState state = random.Draw(wagon_, V, Region::kTread);
    for (std::size_t j = 0; j < kMotions; ++j)
      if (ChangesSignInMirror(j)) state.x[j] = 0;
    for (const std::size_t left : {0U, 2U}) {
      state.x[kLeafForces + left + 1] = state.x[kLeafForces + left];
      state.links.longitudinal[left + 1] = state.links.longitudinal[left];
    }
    for (std::size_t corner = 0; corner < kCorners; ++corner)
      state.links.lateral[corner] = LinkState::AtRest(wagon_.lateral[corner], 0);
    const StateVector<double> rate = Rate(wagon_, V, state);
    // Left and right are computed from the same numbers, so they cancel without a remainder.
    for (std::size_t j = 0; j < kMotions; ++j)
      EXPECT_TRUE(rate[j] == 0 || !ChangesSignInMirror(j)) << kStateNames[j] << ' ' << rate[j];
    if (wagon_.size() == kMotions) continue;
    for (const std::size_t left : {0U, 2U}) EXPECT_EQ(rate[kLeafForces + left], rate[kLeafForces + left + 1]);
  }
}

INSTANTIATE_TEST_SUITE_P(Samples, EveryEvenWagon, testing::ValuesIn(MirrorImages()),
                         [](const auto& sample) { return sample.param.name; });

// --- closed forms, on cylinders ---

/// A wheelset of cylinders pressed on rails by n0 per wheel, rolling without slip.
class Cylinders : public testing::Test {
 protected:
  static constexpr double kSpeed = 20;
  const ContactTable table_ = MakeCylinderTable();
  const ContactRow& row_ = table_.rows.front();
  const Wagon wagon_ = MakeWagon(WagonSample{}, table_);

  Cylinders() {
    for (std::size_t axle = 0; axle < kAxles; ++axle) state_.x[axle * wheelset::kSize + wheelset::kZ] = -row_.q0;
    for (std::size_t i = 0; i < kCorners; ++i) {
      state_.links.longitudinal[i] = LinkState::AtRest(wagon_.longitudinal[i], 0);
      state_.links.lateral[i] = LinkState::AtRest(wagon_.lateral[i], 0);
    }
  }
  WagonForces::Wheel FrontLeftWith(wheelset::Index i, double value) const {
    StateVector<double> x = state_.x;
    x[i] = value;
    StateVector<double> rate{};
    WagonForces forces;
    CalcForces(wagon_, kSpeed, state_.links, x, &rate, &forces);
    return forces.wheels[0];
  }
  WagonState state_;
};

TEST_F(Cylinders, HertzGivesTheForceOfTheTable) {
  // The approach is a difference of 70 um from 0.46 m or less: 1e-12.
  EXPECT_NEAR(FrontLeftWith(wheelset::kX, 0).N, row_.n0, 1e-10 * row_.n0);
  EXPECT_NEAR(FrontLeftWith(wheelset::kZ, -2 * row_.q0).N, std::pow(2, 1.5) * row_.n0, 1e-10 * row_.n0);
  EXPECT_EQ(FrontLeftWith(wheelset::kZ, 1e-9).N, 0);
}

TEST_F(Cylinders, CreepBeginsWithKalkersCoefficients) {
  // (3.1) takes off u/3, u = force over mu N = 1e-4 at most here; the creepages are rounded to 1e-16 of 1.
  constexpr double kCreep = 1e-8;
  const double Gab = table_.shear_modulus * row_.a_e * row_.b_e;
  const double tolerance = 1e-4;
  const double F_x = FrontLeftWith(wheelset::kXRate, kCreep * kSpeed).F_x;
  EXPECT_NEAR(F_x / (-Gab * row_.c11 * kCreep), 1, tolerance);
  const double F_y = FrontLeftWith(wheelset::kYRate, kCreep * kSpeed).F_y;
  EXPECT_NEAR(F_y / (-Gab * row_.c22 * kCreep), 1, tolerance);
  // Yawing, the wheel also slips lengthwise by a psi'/V = 0.75 m xi_s, some 100 times what spin alone does.
  const double per_spin = Gab * std::sqrt(row_.a_e * row_.b_e) * row_.c23;
  const WagonForces::Wheel yawing = FrontLeftWith(wheelset::kPsiRate, kCreep * kSpeed);
  EXPECT_NEAR(yawing.F_y / (-per_spin * kCreep), 1, tolerance);
  EXPECT_NEAR(yawing.F_x / (Gab * row_.c11 * row_.a_wheel * kCreep), 1, tolerance);
  // Yaw by psi at speed V is a lateral velocity -V psi, which the rail resists to the left.
  EXPECT_NEAR(FrontLeftWith(wheelset::kPsi, kCreep).F_y / (Gab * row_.c22 * kCreep), 1, tolerance);
  // A faster spin of the wheelset pushes it forward.
  const WagonForces::Wheel spinning = FrontLeftWith(wheelset::kBeta, kCreep * kSpeed / table_.r0);
  EXPECT_NEAR(spinning.F_x / (Gab * row_.c11 * kCreep), 1, tolerance);
}

TEST_F(Cylinders, CreepEndsInSliding) {
  for (const double creep : {0.05, -0.05}) {
    const WagonForces::Wheel along = FrontLeftWith(wheelset::kXRate, creep * kSpeed);
    EXPECT_NEAR(along.F_x, -std::copysign(wagon_.mu * along.N, creep), 1e-12 * along.N);
    const WagonForces::Wheel across = FrontLeftWith(wheelset::kYRate, creep * kSpeed);
    EXPECT_NEAR(across.F_y, -std::copysign(wagon_.mu * across.N, creep), 1e-12 * across.N);
  }
  // Just where the cubic of (3.1) ends it is mu N, and beyond it does not grow.
  const double full = 3 * wagon_.mu * row_.n0 / (table_.shear_modulus * row_.a_e * row_.b_e * row_.c11);
  for (const double share : {0.999999, 1.0, 1.000001, 2.0}) {
    const WagonForces::Wheel wheel = FrontLeftWith(wheelset::kXRate, -share * full * kSpeed);
    EXPECT_NEAR(wheel.F_x, wagon_.mu * wheel.N, 1e-10 * wheel.N) << share;  // slope zero: (1e-6)^2 is lost
  }
}

// --- equilibrium ---

/// Newton's method on all motions; `state` is a start near the equilibrium. Returns the largest step left.
double FindEquilibrium(const Wagon& wagon, double V, WagonState* state) {
  constexpr auto n = static_cast<Eigen::Index>(kMotions);
  double size = kInfinity;
  for (int iteration = 0; iteration < 30 && size > 1e-13; ++iteration) {
    StateVector<double> rate{};
    const Matrix J = CalcJacobian(wagon, V, *state, &rate);
    const Eigen::Map<const Eigen::Matrix<double, kMotions, 1>> residual(rate.data());
    const Eigen::VectorXd step = J.topLeftCorner(n, n).fullPivLu().solve(-residual);
    for (std::size_t i = 0; i < kMotions; ++i) state->x[i] += step[static_cast<Eigen::Index>(i)];
    size = step.cwiseAbs().maxCoeff();
  }
  return size;
}

WagonState StandOnTouchingHeight(const Wagon& wagon) {
  WagonState state;
  const ContactCurve::Place centre = wagon.contact.Find(0);
  const double z = ContactCurve::Evaluate(wagon.contact.pose_cubic(centre.cell), centre.t).z - 6e-5;
  for (std::size_t axle = 0; axle < kAxles; ++axle) state.x[axle * wheelset::kSize + wheelset::kZ] = z;
  state.x[kBody + body::kZ] = z;
  for (std::size_t i = 0; i < kCorners; ++i) {
    state.links.longitudinal[i] = LinkState::AtRest(wagon.longitudinal[i], 0);
    state.links.lateral[i] = LinkState::AtRest(wagon.lateral[i], 0);
  }
  return state;
}

TEST(WagonRate, WheelLoadsAtRestAreTheWeight) {
  for (WagonSample sample : WagonSamples()) {
    if (sample.options.suspension == Suspension::kLeaf || sample.options.penetration == Penetration::kPrinted) continue;
    SCOPED_TRACE(sample.name);
    sample.jumps = false;
    const Wagon wagon = MakeWagon(sample);
    WagonState state = StandOnTouchingHeight(wagon);
    ASSERT_LE(FindEquilibrium(wagon, 20, &state), 1e-13);
    StateVector<double> rate{};
    WagonForces forces;
    CalcForces(wagon, 20, state.links, state.x, &rate, &forces);
    const double weight = (wagon.body.m + 2 * wagon.wheelset.m) * wagon.g;
    double sum = 0;
    for (const WagonForces::Wheel& wheel : forces.wheels) sum += wheel.Q;
    // A step of 1e-13 m is 1e-4 N at a wheel (Hertz: 1e9 N/m).
    EXPECT_NEAR(sum, weight, 1e-3);
    if (sample.off_centre) continue;
    for (const WagonForces::Wheel& wheel : forces.wheels) EXPECT_NEAR(wheel.Q, weight / 4, 1e-3);
  }
}

}  // namespace
}  // namespace uiclink
