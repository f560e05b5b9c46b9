#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>
#include <vector>

#include "dynamics/continuation.h"
#include "tests/support/test_flows.h"

namespace uiclink {
namespace {

using Eigen::Vector2d;
using std::numbers::pi;

/// Symmetric motion of the oscillator with one slider and a cubic spring by half a period from its greatest
/// displacement A, with the force's phase given: unknown A and frequency. While x falls from A the slider's force is
/// max(k1 (x - A) + T0, -T0). Classical Runge-Kutta, with a step in x onto the corner (Henon): another method in all.
class HalfPeriod {
 public:
  explicit HalfPeriod(const SliderOscillator& oscillator) : o_(oscillator) {}

  /// (A, w) at a phase, from a guess.
  Vector2d Solve(double phase, Vector2d u) const {
    for (int i = 0; i < 30; ++i) {
      const Vector2d r = Residual(phase, u);
      Eigen::Matrix2d jacobian;
      for (int j = 0; j < 2; ++j) {
        const Vector2d d = 1e-6 * Vector2d::Unit(j);
        jacobian.col(j) = (Residual(phase, u + d) - Residual(phase, u - d)) / 2e-6;
      }
      const Vector2d step = jacobian.inverse() * -r;
      u += step;
      if (step.norm() < 1e-12) return u;
    }
    ADD_FAILURE() << "no symmetric motion at phase " << phase;
    return u;
  }

 private:
  using State = Eigen::Array3d;  // t, x, x'

  template <typename Rate>
  static State Advance(const Rate& rate, const State& s, double h) {
    const State k1 = rate(s), k2 = rate(s + h / 2 * k1), k3 = rate(s + h / 2 * k2), k4 = rate(s + h * k3);
    return s + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

  Vector2d Residual(double phase, const Vector2d& u) const {
    const double A = u[0], w = u[1], end = pi / w;
    const int steps = 2000;
    State s(0, A, 0);
    const double corner = A - 2 * o_.T0 / o_.k1;
    bool slides = false;
    const auto by_time = [&](const State& z) {
      const double slider = slides ? -o_.T0 : o_.k1 * (z[1] - A) + o_.T0;
      return State(1, z[2],
                   o_.force * std::cos(w * z[0] + phase) - 2 * o_.zeta * z[2] - o_.k0 * z[1] -
                       o_.k3 * z[1] * z[1] * z[1] - slider);
    };
    const auto by_place = [&](const State& z) { return State(by_time(z) / z[2]); };
    const double h = end / steps;
    for (;;) {
      State next = Advance(by_time, s, std::min(h, end - s[0]));
      if (!slides && next[1] < corner) {
        // From just above the corner the speed is far from zero, so x can take the place of time.
        next = Advance(by_place, s, corner - s[1]);
        slides = true;
      }
      s = next;
      if (end - s[0] < 1e-14) break;
    }
    return {s[1] + A, s[2]};
  }

  const SliderOscillator& o_;
};

/// The frequency is stationary along the phase: golden section between two phases.
double FindStationaryFrequency(const HalfPeriod& half, double low, double high, Vector2d guess, double sign) {
  const double part = 0.5 * (std::sqrt(5) - 1);
  double a = high - part * (high - low), b = low + part * (high - low);
  const auto value = [&](double phase) {
    guess = half.Solve(phase, guess);
    return sign * guess[1];
  };
  double at_a = value(a), at_b = value(b);
  while (high - low > 1e-6) {
    if (at_a > at_b) {
      high = std::exchange(b, a);
      at_b = at_a;
      at_a = value(a = high - part * (high - low));
    } else {
      low = std::exchange(a, b);
      at_a = at_b;
      at_b = value(b = low + part * (high - low));
    }
  }
  return guess[1];
}

/// Phase of the force at the greatest displacement, to half a degree.
double FindPhaseOfMaximum(Flow* flow, const Cycle& cycle) {
  double greatest = 0, phase = 0;
  const int parts = 720;
  for (int i = 1; i < parts; ++i) {
    const double t = cycle.period * i / parts;
    const double x = flow->Pass(cycle.state, t, cycle.lambda, Flow::Derivatives::kNone).end[0];
    if (x <= greatest) continue;
    greatest = x;
    phase = 2 * pi * i / parts;
  }
  return phase;
}

// The frequency response of an oscillator with a slider and a hardening spring leans over: two folds.
TEST(FrequencyResponse, FindsTheFoldsOfAFrequencyResponse) {
  const SliderOscillator oscillator{.zeta = 0.05, .k0 = 1, .k1 = 0.5, .k3 = 0.1, .T0 = 0.3, .force = 0.9};
  SliderFlow flow(oscillator);
  ContinuationOptions options;
  options.from = 0.6;
  options.to = 3;
  options.max_step = 0.3;
  options.fold_tolerance = 1e-9;
  options.cycle.tolerance = 1e-11;
  options.max_points = 1000;
  options.cycle.settle = 10;
  const Cycle start = FindCycle(flow, 0.7, Eigen::Vector3d::Zero(), 0, options.cycle);
  const Branch branch = FollowBranch(flow, start, options);
  EXPECT_EQ(branch.end, BranchEnd::kRange);
  std::vector<BranchEvent> folds;
  std::copy_if(branch.events.begin(), branch.events.end(), std::back_inserter(folds),
               [](const BranchEvent& event) { return event.kind == BranchEventKind::kFold; });
  ASSERT_EQ(folds.size(), 2u);
  const HalfPeriod half(oscillator);
  for (std::size_t k = 0; k < 2; ++k) {
    const double phase = FindPhaseOfMaximum(&flow, folds[k].cycle);
    const Vector2d guess(folds[k].cycle.Amplitude(0), folds[k].lambda);
    const double sign = k == 0 ? 1 : -1;  // the first is the greatest frequency, the second the least
    const double exact = FindStationaryFrequency(half, phase - 0.05, phase + 0.05, half.Solve(phase, guess), sign);
    // Phases to 1e-6 leave some 1e-12 of the stationary frequency; the rule of order 4 with 2000 steps about 1e-11.
    EXPECT_NEAR(folds[k].lambda, exact, 2e-9);
    EXPECT_NEAR(folds[k].cycle.multipliers[0].real(), 1, 1e-3);
  }
  for (const Cycle& cycle : branch.points) {
    EXPECT_EQ(static_cast<int>(cycle.multipliers.size()) + cycle.multipliers_zero + cycle.multipliers_one, 3);
  }
}

}  // namespace
}  // namespace uiclink
