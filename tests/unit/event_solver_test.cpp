#include "model/event_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "model/closed_form.h"

namespace uiclink {
namespace {

Oscillator<double> OneSlider(double k, double k1, double T0) {
  Oscillator<double> o;
  o.k = k;
  o.Add({k1, T0});
  return o;
}

Oscillator<double> Set1Lateral() { return OneSlider(4.2010, 1.4222, 0.014); }
Oscillator<double> Set2Lateral() { return OneSlider(3.413, 10.503, 0.018); }

std::vector<double> Extrema(const Oscillator<double>& o, double y0, double duration) {
  Trajectory<double> run;
  EXPECT_EQ(Solve(o, AtExtremum(o, y0), duration, &run), SolveStatus::kOk);
  std::vector<double> extrema;
  for (const Arc<double>& arc : run.arcs())
    if (arc.end == EventKind::kTurning) extrema.push_back(run.y(arc.t_end));
  return extrema;
}

// The published figures have three decimals in mm, so half a micrometre is their rounding.
constexpr double kHalfDigit = 0.5e-6;

TEST(EventSolver, ReproducesTheExtremaOfSet1) {
  const double expected_mm[] = {39.881, 34.969, 30.314, 25.980, 22.047, 18.609, 15.762, 13.571};
  const std::vector<double> extrema = Extrema(Set1Lateral(), 0.045, 15);
  double side = -1;
  for (std::size_t i = 0; i < std::size(expected_mm); ++i, side = -side)
    EXPECT_NEAR(extrema[i], side * expected_mm[i] * 1e-3, kHalfDigit) << i;
}

TEST(EventSolver, ApproachesTheSlipLimitOfSet1FromAboveForEver) {
  const Oscillator<double> o = Set1Lateral();
  Trajectory<double> run;
  ASSERT_EQ(Solve(o, AtExtremum(o, 0.045), 200, &run), SolveStatus::kOk);
  const Arc<double>& last = run.arcs().back();
  // After 200 s the excess has shrunk by 0.4942^(400), so only rounding is left: 1e-13 of T0 (kLocked), plus
  // some hundred roundings of 1e-17 m.
  EXPECT_NEAR(std::hypot(last.a, last.b), 0.014 / 1.4222, 1e-14);
  EXPECT_NEAR(last.c, 0, 1e-14);
}

TEST(EventSolver, LocksSet2OffCentre) {
  const Oscillator<double> o = Set2Lateral();
  const double expected_mm[] = {34.905, 24.961, 15.310, 6.426, 0.848};
  const std::vector<double> extrema = Extrema(o, 0.045, 15);
  ASSERT_EQ(extrema.size(), std::size(expected_mm));
  double side = -1;
  for (std::size_t i = 0; i < std::size(expected_mm); ++i, side = -side)
    EXPECT_NEAR(extrema[i], side * expected_mm[i] * 1e-3, kHalfDigit) << i;
  Trajectory<double> run;
  ASSERT_EQ(Solve(o, AtExtremum(o, 0.045), 15, &run), SolveStatus::kOk);
  const Arc<double>& rest = run.arcs().back();
  const double amplitude = std::hypot(rest.a, rest.b);
  EXPECT_NEAR(std::abs(rest.c), 0.653e-3, kHalfDigit);
  EXPECT_NEAR(amplitude, 1.501e-3, 2 * kHalfDigit);  // published as 0.848 + 0.653, the sum of two rounded figures
  EXPECT_NEAR(10.503 * amplitude + 3.413 * std::abs(rest.c), 0.018, 1e-15);  // rounding of 0.018
}

TEST(EventSolver, HasTheFrequenciesOfTheHybridLink) {
  const Oscillator<double> o = OneSlider(3.413, 2.210, 0.018);
  const double expected_mm[] = {36.6, 28.6, 21.5, 15.6, 11.4, 9.2, 8.4};
  const std::vector<double> extrema = Extrema(o, 0.045, 15);
  for (std::size_t i = 0; i < std::size(expected_mm); ++i)
    EXPECT_NEAR(std::abs(extrema[i]), expected_mm[i] * 1e-3, 0.05e-3) << i;  // one decimal is published
  EXPECT_NEAR(CalcSlidingFrequency(o) / (2 * std::numbers::pi), 0.921, 0.5e-3);
  EXPECT_NEAR(CalcRollingFrequency(o) / (2 * std::numbers::pi), 1.183, 0.5e-3);
}

TEST(EventSolver, TurnsGeometricallyNearTheLimit) {
  // Near A* = T0/k1 one half swing maps A - A* to (k - k1)/(k + k1) times itself: 0.4942 for set 1.
  const Oscillator<double> o = Set1Lateral();
  const double limit = 0.014 / 1.4222;
  const std::vector<double> extrema = Extrema(o, limit + 1e-7, 3);
  const double ratio = (std::abs(extrema[1]) - limit) / (std::abs(extrema[0]) - limit);
  EXPECT_NEAR(ratio, (4.2010 - 1.4222) / (4.2010 + 1.4222), 1e-4);  // curvature of the map: 1e-7 m / 1e-2 m, times 10
}

TEST(EventSolver, AgreesWithTheEnergyMapForManySliders) {
  std::mt19937_64 random(20260101);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    Oscillator<double> o;
    o.k = 2 + 6 * uniform(random);
    const int n = 1 + trial % 4;
    for (int i = 0; i < n; ++i) o.Add({0.2 + 4 * uniform(random), 0.001 + 0.01 * uniform(random)});
    const double A = 0.02 + 0.03 * uniform(random);
    Trajectory<double> run;
    const HalfCycle half = CalcHalfCycle(o, A);
    State<double> start{.y = A};
    for (std::size_t i = 0; i < o.sliders().size(); ++i)
      start.T[i] = -std::min(o.sliders()[i].T0, o.sliders()[i].k * A);
    ASSERT_EQ(Solve(o, start, 2, &run), SolveStatus::kOk);
    std::size_t j = 0;
    while (run.arcs()[j].end == EventKind::kBreakout) ++j;
    if (run.arcs()[j].end != EventKind::kTurning) continue;  // rolls for ever: one arc
    // 1e-14 m: some ten roundings of 0.05 m. Time: the same, divided by the frequency times the amplitude.
    EXPECT_NEAR(run.y(run.arcs()[j].t_end), -half.next_amplitude, 1e-14);
    EXPECT_NEAR(run.arcs()[j].t_end, half.duration, 1e-12);
    EXPECT_NEAR(CalcDissipation(o, run, run.arcs()[j].t_end), half.loss, 1e-15);
  }
}

TEST(EventSolver, KeepsTheEnergyBalance) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    Oscillator<double> o;
    o.k = 2 + 6 * uniform(random);
    for (int i = 0; i <= trial % 4; ++i) o.Add({0.2 + 6 * uniform(random), 0.001 + 0.02 * uniform(random)});
    State<double> start{.y = 0.1 * (uniform(random) - 0.5), .v = uniform(random) - 0.5};
    for (std::size_t i = 0; i < o.sliders().size(); ++i) start.T[i] = o.sliders()[i].T0 * (2 * uniform(random) - 1);
    Trajectory<double> run;
    ASSERT_EQ(Solve(o, start, 15, &run), SolveStatus::kOk);
    const double total = CalcEnergy(o, start);
    for (double t = 0; t < 15; t += 0.1) {
      State<double> now{.y = run.y(t), .v = run.v(t)};
      for (std::size_t i = 0; i < o.sliders().size(); ++i) now.T[i] = run.T(i, t);
      // 1e-12 of the energy: about 200 arcs of a few roundings each.
      ASSERT_NEAR(CalcEnergy(o, now) + CalcDissipation(o, run, t), total, 1e-12 * total) << trial << " t = " << t;
    }
  }
}

TEST(EventSolver, MirroredStartMirrorsTheRun) {
  const Oscillator<double> o = Set2Lateral();
  Trajectory<double> run, mirrored;
  Solve(o, {.y = 0.03, .v = 0.1, .T = {0.004}}, 15, &run);
  Solve(o, {.y = -0.03, .v = -0.1, .T = {-0.004}}, 15, &mirrored);
  for (double t = 0; t < 15; t += 0.05) ASSERT_EQ(run.y(t), -mirrored.y(t));
}

TEST(EventSolver, EqualSlidersBreakOutTogether) {
  const Oscillator<double> one = OneSlider(3.4, 2.4, 0.018);
  Oscillator<double> three;
  three.k = 3.4;
  for (int i = 0; i < 3; ++i) three.Add({0.8, 0.006});
  Trajectory<double> a, b;
  Solve(one, AtExtremum(one, 0.04), 15, &a);
  Solve(three, AtExtremum(three, 0.04), 15, &b);
  EXPECT_EQ(a.CountEvents(), b.CountEvents());
  for (double t = 0; t < 15; t += 0.05) ASSERT_NEAR(a.y(t), b.y(t), 1e-13);  // rounding of about 100 arcs
}

TEST(EventSolver, GoesOnFromAnyStateOfARun) {
  const Oscillator<double> o = Set1Lateral();
  Trajectory<double> whole, rest;
  Solve(o, AtExtremum(o, 0.03), 15, &whole);
  for (const double cut : {0.1, 0.5, 1.234, 3.3, 9.0}) {
    State<double> state{.y = whole.y(cut), .v = whole.v(cut), .T = {whole.T(0, cut)}};
    ASSERT_EQ(Solve(o, state, 15 - cut, &rest), SolveStatus::kOk);
    for (double t = 0; t < 15 - cut; t += 0.05) ASSERT_NEAR(rest.y(t), whole.y(cut + t), 1e-13) << cut;
  }
}

TEST(EventSolver, StaysAtRestWhereItIsInBalance) {
  const Oscillator<double> o = OneSlider(4, 2, 0.01);
  Trajectory<double> run;
  ASSERT_EQ(Solve(o, {.y = 0.001, .v = 0, .T = {0.004}}, 10, &run), SolveStatus::kOk);
  EXPECT_NEAR(run.y(7.3), 0.001, 1e-17);
  ASSERT_EQ(Solve(o, {.y = 0.0025, .v = 0, .T = {0.01}}, 10, &run), SolveStatus::kOk);  // at its limit, in balance
  EXPECT_NEAR(run.y(7.3), 0.0025, 1e-17);
}

TEST(EventSolver, PowerlessSlidersAreNotThere) {
  const Oscillator<double> without = OneSlider(4, 2, 0.01);
  Oscillator<double> with = without;
  with.Add({1.5, 0.0});
  Trajectory<double> a, b;
  ASSERT_EQ(Solve(without, AtExtremum(without, 0.03), 15, &a), SolveStatus::kOk);
  ASSERT_EQ(Solve(with, AtExtremum(with, 0.03), 15, &b), SolveStatus::kOk);
  for (double t = 0; t < 15; t += 0.05) ASSERT_NEAR(a.y(t), b.y(t), 1e-13);
}

TEST(EventSolver, RefusesWhatIsNoLink) {
  Trajectory<double> run;
  const Oscillator<double> o = OneSlider(4, 2, 0.01);
  EXPECT_EQ(Solve(OneSlider(-1, 2, 0.01), {.y = 0.01}, 1, &run), SolveStatus::kNotFinite);
  EXPECT_EQ(Solve(OneSlider(4, NAN, 0.01), {.y = 0.01}, 1, &run), SolveStatus::kNotFinite);
  EXPECT_EQ(Solve(o, {.y = NAN}, 1, &run), SolveStatus::kNotFinite);
  EXPECT_EQ(Solve(o, {.y = 0.01, .v = 0, .T = {0.02}}, 1, &run), SolveStatus::kNotFinite);
  EXPECT_EQ(Solve(o, AtExtremum(o, 0.03), 15, &run, {.max_events = 3}), SolveStatus::kTooManyEvents);
}

TEST(Trajectory, SamplesAsItEvaluates) {
  const Oscillator<double> o = Set1Lateral();
  Trajectory<double> run;
  Solve(o, AtExtremum(o, 0.03), 15, &run);
  const SampleTimes grid{.first = -0.003, .step = 0.005, .size = 3000};
  std::vector<double> y(grid.size), listed(grid.size), times(grid.size);
  for (std::size_t i = 0; i < grid.size; ++i) times[i] = grid[i];
  CalcDisplacements(run, grid, y);
  CalcDisplacements(run, {.size = times.size(), .times = times}, listed);
  for (std::size_t i = 0; i < grid.size; ++i) {
    ASSERT_NEAR(y[i], run.y(grid[i]), 1e-14);  // a thousand turns of a few roundings of 0.03 m
    ASSERT_NEAR(listed[i], run.y(grid[i]), 1e-16);
  }
}

// Derivatives by extrapolated central differences: D(h) and D(h/2) are combined so that the error of order h^2 goes.
TEST(EventSolver, DerivativesPassEvents) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst = 0;
  for (int trial = 0; trial < 60; ++trial) {
    constexpr int n = 4, N = 2 * n + 2;
    Oscillator<double> o;
    o.k = 3 + 3 * uniform(random);
    for (int i = 0; i < n; ++i) o.Add({0.3 + 1.5 * uniform(random), 0.001 + 0.004 * uniform(random)});
    const double y0 = 0.02 + 0.02 * uniform(random);
    Oscillator<Dual<N>> dual = WithDerivatives<N>(o);
    Trajectory<Dual<N>> run;
    ASSERT_EQ(Solve(dual, AtExtremum(dual, Dual<N>(y0, N - 1)), 15, &run), SolveStatus::kOk);
    const SampleTimes grid{.first = 0.5, .step = 0.5, .size = 25};
    std::vector<double> y(grid.size), v(grid.size), dy(grid.size * N);
    CalcDisplacements(run, grid, y, v, dy);
    for (int p = 0; p < N; ++p) {
      auto at = [&](double relative) {
        Oscillator<double> moved = o;
        double start = y0;
        if (p == 0)
          moved.k *= 1 + relative;
        else if (p <= n)
          moved.sliders()[static_cast<std::size_t>(p - 1)].k *= 1 + relative;
        else if (p <= 2 * n)
          moved.sliders()[static_cast<std::size_t>(p - 1 - n)].T0 *= 1 + relative;
        else
          start *= 1 + relative;
        Trajectory<double> trajectory;
        Solve(moved, AtExtremum(moved, start), 15, &trajectory);
        std::vector<double> values(grid.size);
        CalcDisplacements(trajectory, grid, values);
        return values;
      };
      const double value = p == 0       ? o.k
                           : p <= n     ? o.sliders()[static_cast<std::size_t>(p - 1)].k
                           : p <= 2 * n ? o.sliders()[static_cast<std::size_t>(p - 1 - n)].T0
                                        : y0;
      const double h = 1e-5;
      const auto p1 = at(h), m1 = at(-h), p2 = at(h / 2), m2 = at(-h / 2);
      double scale = 0, error = 0;
      for (std::size_t i = 0; i < grid.size; ++i) {
        const double d1 = (p1[i] - m1[i]) / (2 * h), d2 = (p2[i] - m2[i]) / h;
        const double extrapolated = (4 * d2 - d1) / 3;
        scale = std::max(scale, std::abs(extrapolated));
        error = std::max(error, std::abs(dy[static_cast<std::size_t>(p) * grid.size + i] * value - extrapolated));
      }
      worst = std::max(worst, error / scale);
    }
  }
  // Extrapolated differences at h = 1e-5: rounding 1e-16 / 1e-5 of a motion that depends on a parameter 10 to 100 times
  // more than on its start, 1e-9; kinks of the derivative inside the step add about as much.
  EXPECT_LT(worst, 1e-7);
}

}  // namespace
}  // namespace uiclink
