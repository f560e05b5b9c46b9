#include "dynamics/cycle.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "tests/support/test_flows.h"

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using std::numbers::pi;

/// x'' - mu (1 - x^2) x' + x = 0.
struct VanDerPol {
  template <typename T>
  void operator()(double /*t*/, const T* z, const T& mu, T* rate) const {
    rate[0] = z[1];
    rate[1] = mu * (1.0 - z[0] * z[0]) * z[1] - z[0];
  }
};

/// Period of van der Pol's cycle and the integral of the divergence over it, by another method: the classical
/// Runge-Kutta rule with a fixed step, from the greatest x to the next, after the transient; the last step ends on the
/// section x' = 0 by stepping in x' instead of t (Henon).
struct Reference {
  double period = 0, divergence = 0, amplitude = 0;
};

Reference CalcReference(double mu, double step) {
  using State = Eigen::Array4d;  // t, x, x', integral of the divergence
  const auto by_time = [mu](const State& s) {
    return State(1, s[2], mu * (1 - s[1] * s[1]) * s[2] - s[1], mu * (1 - s[1] * s[1]));
  };
  const auto by_speed = [&by_time](const State& s) { return State(by_time(s) / by_time(s)[2]); };
  const auto advance = [](const auto& f, const State& s, double h) {
    const State k1 = f(s), k2 = f(s + h / 2 * k1), k3 = f(s + h / 2 * k2), k4 = f(s + h * k3);
    return State(s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4));
  };
  State s(0, 2, 0, 0);
  Reference reference;
  // The distance from the cycle falls by exp(-2 pi mu) a turn: forty turns make 1e-10 of it at mu = 0.1.
  for (int turn = 0; turn < (mu < 0.5 ? 55 : 12); ++turn) {
    s[0] = s[3] = 0;
    State next = advance(by_time, s, step);
    while (!(s[2] > 0 && next[2] <= 0)) {
      s = next;
      next = advance(by_time, s, step);
    }
    s = advance(by_speed, s, -s[2]);
    reference = {s[0], s[3], s[1]};
  }
  return reference;
}

Cycle FindVanDerPol(double mu) {
  SmoothFlow flow(MakeModel<2>(VanDerPol()));
  CycleOptions options;
  options.tolerance = 1e-11;
  return FindCycle(flow, mu, Vector2d(2, 0), CalcReference(mu, 0.01).period * 1.05, options);
}

class VanDerPolCycle : public testing::TestWithParam<double> {};

// Period, amplitude and multiplier against the other method; the multiplier is the exponential of the integral of the
// divergence (Abel, Liouville).
TEST_P(VanDerPolCycle, AgreesWithAnotherMethod) {
  const double mu = GetParam();
  const Cycle cycle = FindVanDerPol(mu);
  const Reference reference = CalcReference(mu, 5e-4);
  // The rule of order 4 has an error of about (5e-4)^4 = 6e-14 times derivatives that grow like mu^5 on the jumps; its
  // own change from a step of 1e-3 is below a tenth of this.
  EXPECT_NEAR(cycle.period, reference.period, mu > 5 ? 1e-8 : 1e-10);
  EXPECT_NEAR(cycle.passage.greatest[0], reference.amplitude, mu > 5 ? 1e-8 : 1e-10);
  ASSERT_EQ(cycle.multipliers.size(), 2u);
  EXPECT_NEAR(cycle.multipliers[1].real(), std::exp(reference.divergence), 1e-9);
  EXPECT_LT(cycle.trivial_error, 1e-9);
  EXPECT_TRUE(cycle.stable());
  EXPECT_LE(cycle.residual, 1e-11);
}
INSTANTIATE_TEST_SUITE_P(Mu, VanDerPolCycle, testing::Values(0.1, 1.0, 10.0));

TEST(Cycle, VanDerPolsPeriodHasItsExpansion) {
  // T = 2 pi (1 + mu^2/16 - 5 mu^4/3072 + O(mu^6)): at mu = 0.1 the rest is some 1e-6 times a coefficient below 1e-3.
  EXPECT_NEAR(FindVanDerPol(0.1).period, 2 * pi * (1 + 0.01 / 16 - 5e-4 / 3072), 6e-9);
  EXPECT_NEAR(FindVanDerPol(1).period, 6.663286859, 1e-9);  // the published figure has so many digits
}

/// r' = lambda r + r^3 - r^5, theta' = 1.
struct SubcriticalHopf {
  template <typename T>
  void operator()(double /*t*/, const T* z, const T& lambda, T* rate) const {
    const T square = z[0] * z[0] + z[1] * z[1];
    const T growth = lambda + square - square * square;
    rate[0] = growth * z[0] - z[1];
    rate[1] = growth * z[1] + z[0];
  }
};

TEST(Cycle, FindsStableAndUnstableCyclesOfANormalForm) {
  SmoothFlow flow(MakeModel<2>(SubcriticalHopf()));
  CycleOptions options;
  options.tolerance = 1e-11;
  options.settle = 0;
  for (const double lambda : {-0.2, -0.1}) {
    for (const double sign : {-1.0, 1.0}) {
      const double square = 0.5 * (1 + sign * std::sqrt(1 + 4 * lambda));
      const Cycle cycle = FindCycle(flow, lambda, Vector2d(std::sqrt(square) * 1.03, 0), 6, options);
      EXPECT_NEAR(cycle.state.norm(), std::sqrt(square), 1e-9);  // tolerance / |1 - multiplier|, which is above 0.5
      EXPECT_NEAR(cycle.period, 2 * pi, 1e-9);
      const double multiplier = std::exp(2 * pi * (2 * square - 4 * square * square));
      EXPECT_NEAR(cycle.multipliers[1].real() / multiplier, 1, 1e-8);  // the state's error times d log / d r, about 30
      EXPECT_EQ(cycle.unstable, sign < 0 ? 1 : 0);
    }
  }
}

TEST(Cycle, SaysThatItEndedInAnEquilibrium) {
  SmoothFlow flow(MakeModel<2>(SubcriticalHopf()));
  CycleOptions options;
  options.settle = 8;  // at lambda = -0.5 nothing but the origin is left
  try {
    FindCycle(flow, -0.5, Vector2d(0.3, 0), 6, options);
    FAIL() << "found a cycle where there is none";
  } catch (const CycleError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("equilibrium"));
  }
}

TEST(Cycle, SaysThatTheToleranceIsBelowTheFlowsError) {
  SmoothFlow::Model model = MakeModel<2>(VanDerPol());
  model.tolerance = 1e-9;
  SmoothFlow flow(model);
  CycleOptions options;
  options.tolerance = 1e-18;
  try {
    FindCycle(flow, 1, Vector2d(2, 0), 6.6, options);
    FAIL() << "found with a tolerance of 1e-18";
  } catch (const CycleError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("below the flow's own error"));
  }
}

/// A flow that cannot move states beyond a limit.
class FencedFlow : public SmoothFlow {
 public:
  FencedFlow(const Model& model, double fence) : SmoothFlow(model), fence_(fence) {}
  Passage Pass(const VectorXd& start, double T, double lambda, Derivatives wanted) override {
    if (start.cwiseAbs().maxCoeff() > fence_ || T > 3 * pi) throw std::runtime_error("off the rails");
    return SmoothFlow::Pass(start, T, lambda, wanted);
  }

 private:
  double fence_;
};

TEST(Cycle, DampsStepsThatTheFlowCannotFollow) {
  FencedFlow flow(MakeModel<2>(VanDerPol()), 2.05);
  CycleOptions options;
  options.settle = 0;
  const Cycle cycle = FindCycle(flow, 1, Vector2d(1.2, 0), 5.5, options);
  EXPECT_NEAR(cycle.period, 6.663286859, 1e-6);  // options.tolerance = 1e-7 times a period's sensitivity of order one
  EXPECT_THROW(FindCycle(flow, 1, Vector2d(3, 0), 5.5, options), std::runtime_error);
}

TEST(TestFlow, DerivativesAreThoseOfTheMap) {
  SliderFlow slider({.k3 = 0.1});
  SmoothFlow smooth(MakeModel<2>(VanDerPol()));
  struct Case {
    Flow* flow;
    VectorXd start;
    double T, lambda;
  };
  const double w = 1.1;
  for (const Case& c : {Case{&slider, Vector3d(0.2, 0.9, 0.1), 2 * pi / w, w}, Case{&smooth, Vector2d(2, 0), 6, 1.0}}) {
    const Passage passage = c.flow->Pass(c.start, c.T, c.lambda, Flow::Derivatives::kAll);
    const double h = 1e-5;  // central differences: h^2 times third derivatives of order 10, rounding 1e-13 / h
    for (int i = 0; i < c.flow->size(); ++i) {
      const VectorXd d = h * VectorXd::Unit(c.flow->size(), i);
      const VectorXd difference = (c.flow->Pass(c.start + d, c.T, c.lambda, Flow::Derivatives::kNone).end -
                                   c.flow->Pass(c.start - d, c.T, c.lambda, Flow::Derivatives::kNone).end) /
                                  (2 * h);
      EXPECT_LT((difference - passage.by_start.col(i)).norm(), 1e-7);
    }
    const auto end_at = [&](double lambda) {
      return c.flow->Pass(c.start, c.flow->ForcedPeriod(lambda).value_or(c.T), lambda, Flow::Derivatives::kNone).end;
    };
    const VectorXd difference = (end_at(c.lambda + h) - end_at(c.lambda - h)) / (2 * h);
    EXPECT_LT((difference - passage.by_parameter).norm(), 1e-7);
  }
}

/// Amplitude by harmonic balance with one harmonic: the slider as a spring and a damper that depend on the amplitude.
double HarmonicBalance(const SliderOscillator& o, double w) {
  const auto mismatch = [&](double A) {
    double stiffness = o.k0 + o.k1, loss = 2 * o.zeta * w;
    if (o.k1 * A > o.T0) {
      const double angle = std::acos(1 - 2 * o.T0 / (o.k1 * A));
      stiffness = o.k0 + o.k1 / pi * (angle - 0.5 * std::sin(2 * angle));
      loss += 4 * o.T0 * (A - o.T0 / o.k1) / (pi * A * A);
    }
    stiffness += 0.75 * o.k3 * A * A;
    return A * std::hypot(stiffness - w * w, loss) - o.force;
  };
  double low = 1e-9, high = 100;
  while (high - low > 1e-12) (mismatch(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
  return low;
}

/// Half a period of the linear oscillator with one slider, in closed form. It begins at the greatest displacement A,
/// where sliding has just ended, sticks until x = A - 2 T0/k1, and slides until x' = 0 at x = -A.
class SymmetricMotion {
 public:
  SymmetricMotion(const SliderOscillator& oscillator, double w) : o_(oscillator), w_(w) {
    // From harmonic balance by Newton's method for (A, phase, time of sticking) with differences.
    const double A = HarmonicBalance(oscillator, w);
    u_ = {A, std::atan2(2 * o_.zeta * w + 4 * o_.T0 / (pi * A), o_.k0 - w * w), 0.25 * pi / w};
    for (int i = 0; i < 60; ++i) {
      const Vector3d r = Residual(u_);
      Eigen::Matrix3d jacobian;
      for (int j = 0; j < 3; ++j) {
        const Vector3d d = 1e-6 * Vector3d::Unit(j);
        jacobian.col(j) = (Residual(u_ + d) - Residual(u_ - d)) / 2e-6;
      }
      Vector3d step = jacobian.partialPivLu().solve(-r);
      while (Residual(u_ + step).norm() > r.norm() && step.norm() > 1e-14) step *= 0.5;
      u_ += step;
    }
  }
  double amplitude() const { return u_[0]; }
  double residual() const { return Residual(u_).norm(); }
  double stuck_for() const { return u_[2]; }

 private:
  /// x'' + 2 zeta x' + k x = constant + force cos(w t + phase) from (x, v) at t0, after a time s.
  Vector2d Move(double k, double constant, double phase, double t0, const Vector2d& from, double s) const {
    const double rate = std::sqrt(k - o_.zeta * o_.zeta), real = k - w_ * w_, imaginary = 2 * o_.zeta * w_;
    const double gain = o_.force / std::hypot(real, imaginary), lag = std::atan2(imaginary, real);
    const auto forced = [&](double t) {
      const double angle = w_ * t + phase - lag;
      return Vector2d(constant / k + gain * std::cos(angle), -gain * w_ * std::sin(angle));
    };
    const Vector2d free = from - forced(t0);
    const double c = std::cos(rate * s), n = std::sin(rate * s) / rate, decay = std::exp(-o_.zeta * s);
    return forced(t0 + s) +
           decay * Vector2d(free[0] * (c + o_.zeta * n) + free[1] * n, free[1] * (c - o_.zeta * n) - k * free[0] * n);
  }

  Vector3d Residual(const Vector3d& u) const {
    const double A = u[0], phase = u[1], end = pi / w_;
    const Vector2d slip = Move(o_.k0 + o_.k1, o_.k1 * (A - o_.T0 / o_.k1), phase, 0, Vector2d(A, 0), u[2]);
    const Vector2d turn = Move(o_.k0, o_.T0, phase, u[2], slip, end - u[2]);
    return {slip[0] - (A - 2 * o_.T0 / o_.k1), turn[0] + A, turn[1]};
  }

  const SliderOscillator& o_;
  double w_;
  Vector3d u_;
};

TEST(SliderCycle, AgreesWithTheClosedForm) {
  const SliderOscillator oscillator{.force = 0.8};
  SliderFlow flow(oscillator);
  CycleOptions options;
  options.tolerance = 1e-11;
  double worst = 0, worst_balance = 0;
  for (double w = 1.0; w < 1.36; w += 0.05) {
    const SymmetricMotion exact(oscillator, w);
    ASSERT_LT(exact.residual(), 1e-12) << w;
    ASSERT_GT(exact.stuck_for(), 0) << w;
    options.settle = 5;
    const Cycle cycle = FindCycle(flow, w, Vector3d::Zero(), 0, options);
    worst = std::max(worst, std::abs(cycle.Amplitude(0) - exact.amplitude()));
    worst_balance = std::max(worst_balance, std::abs(HarmonicBalance(oscillator, w) / exact.amplitude() - 1));
    // The memory is wiped out by sliding: one multiplier is zero, counted if it slides at phase zero, else to rounding.
    EXPECT_EQ(cycle.multipliers_one, 0);
    EXPECT_EQ(cycle.multipliers.size() + static_cast<std::size_t>(cycle.multipliers_zero), 3u);
    if (cycle.multipliers_zero == 0) {
      EXPECT_LT(std::abs(cycle.multipliers.back()), 1e-12);
    }
    EXPECT_EQ(cycle.multipliers_zero, static_cast<int>(cycle.passage.slaved_start.size()));
    EXPECT_TRUE(cycle.stable());
  }
  EXPECT_LT(worst, 1e-10);         // ten times the tolerance: (I - monodromy)^-1 is below 10 here
  EXPECT_LT(worst_balance, 0.02);  // what one harmonic leaves out
}

// Guesses whose memory is of the wrong kind: a slider that slides at the start though it sticks there on the cycle
// (w = 1.3), and the other way round (w = 1.1).
TEST(SliderCycle, FindsTheMemoryThatBelongsToTheMotion) {
  const SliderOscillator oscillator{.force = 0.8};
  SliderFlow flow(oscillator);
  CycleOptions options;
  options.tolerance = 1e-10;
  for (const double w : {1.1, 1.3}) {
    const double exact = SymmetricMotion(oscillator, w).amplitude();
    for (const Vector3d& guess : {Vector3d(1, 1, 0.5), Vector3d(1, 0, 1), Vector3d(-1, -1, -0.5), Vector3d(0, 1, 0)}) {
      for (const int settle : {0, 1}) {
        options.settle = settle;
        const Cycle cycle = FindCycle(flow, w, guess, 0, options);
        EXPECT_NEAR(cycle.Amplitude(0), exact, 1e-9);  // ten times the tolerance, as above
        EXPECT_EQ(cycle.passage.slaved_start, cycle.passage.slaved_end);
        EXPECT_LE(cycle.residual, options.tolerance);
      }
    }
  }
}

TEST(SliderCycle, KeepsMemoryThatNothingTouches) {
  const SliderOscillator oscillator{.force = 0.05};
  SliderFlow flow(oscillator);
  CycleOptions options;
  options.tolerance = 1e-12;
  options.settle = 0;
  const double w = 0.7, stiffness = oscillator.k0 + oscillator.k1;
  const Cycle cycle = FindCycle(flow, w, Vector3d(0, 0, 0.1), 0, options);
  EXPECT_EQ(cycle.multipliers_one, 1);
  EXPECT_EQ(cycle.multipliers_zero, 0);
  EXPECT_EQ(cycle.state[2], 0.1);  // kept to the last bit
  // A linear oscillator about k1 p / (k0 + k1): multipliers exp((-zeta +- i sqrt(k - zeta^2)) T).
  EXPECT_NEAR(cycle.Amplitude(0), 0.05 / std::hypot(stiffness - w * w, 2 * oscillator.zeta * w), 1e-11);
  EXPECT_NEAR(cycle.passage.greatest[0] + cycle.passage.least[0], 2 * 0.1 * oscillator.k1 / stiffness, 1e-11);
  ASSERT_EQ(cycle.multipliers.size(), 2u);
  EXPECT_NEAR(std::abs(cycle.multipliers[0]), std::exp(-oscillator.zeta * 2 * pi / w), 1e-11);
}

}  // namespace
}  // namespace uiclink
