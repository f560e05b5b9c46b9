// The parts that symptoms are made of, each against a closed form.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "identify/half_swings.h"
#include "identify/harmonic_content.h"
#include "identify/noise_draws.h"
#include "identify/residual_spectrum.h"
#include "identify/rolling_decay.h"
#include "identify/significance.h"
#include "model/closed_form.h"
#include "model/event_solver.h"

namespace uiclink {
namespace {

constexpr Noise kFine{.sigma = 1e-6, .quantum = 0};

Oscillator<double> Link(double k, double k1, double T0) {
  Oscillator<double> link;
  link.k = k;
  link.Add({.k = k1, .T0 = T0});
  return link;
}

/// Samples of a free decay from an extremum, no noise.
Record Decay(const Oscillator<double>& link, double y0, double offset) {
  Record record;
  record.sampling_hz = 200;
  for (int i = 0; i < 2400; ++i) record.t.push_back(0.005 * i);
  record.y.resize(record.t.size());
  Trajectory<double> trajectory;
  EXPECT_EQ(Solve(link, AtExtremum(link, y0), 12.1, &trajectory), SolveStatus::kOk);
  for (std::size_t i = 0; i < record.t.size(); ++i) record.y[i] = offset + trajectory.y(record.t[i]);
  return record;
}

TEST(Significance, AgreesWithTables) {
  EXPECT_NEAR(CalcNormalEquivalent(std::log(0.05)), 1.959964, 1e-6);
  EXPECT_NEAR(CalcNormalEquivalent(std::log(0.002699796)), 3, 1e-6);
  EXPECT_EQ(CalcNormalEquivalent(0), 0);
  // One degree of freedom: the square of a normal variable, also far beyond the smallest number.
  for (const double z : {1.0, 5.0, 20.0, 60.0, 500.0})
    EXPECT_NEAR(CalcNormalEquivalent(CalcLogChiSquareTail(z * z, 1)), z, 1e-3 * z) << z;
  EXPECT_NEAR(CalcLogChiSquareTail(3000, 2), -1500, 1e-6);  // exact: exp(-x/2)
}

TEST(HalfSwings, AreThoseOfTheClosedForm) {
  const Oscillator<double> link = Link(3.41, 2.21, 0.018);
  for (const double y0 : {0.025, -0.025}) {
    const Swings swings = ReadSwings(Decay(link, y0, 0.0007), kFine);
    ASSERT_GT(swings.turns.size(), 15u);
    EXPECT_NEAR(swings.turns[0].y, 0.0007 + y0,
                6e-6);  // what another frequency behind the turn makes of it (half_swings.cpp)
    EXPECT_NEAR(swings.turns[0].t, 0, 1e-3);
    double A = 0.025;
    for (std::size_t i = 1; i < 6; ++i) {
      const HalfCycle half = CalcHalfCycle(link, A);
      const double side = (i % 2 == 0) == (y0 > 0) ? 1 : -1;
      // Where the joint stops sliding the fourth derivative jumps: up to 0.5 ms, hence 2e-6 m (identify/local_fit.h).
      EXPECT_NEAR(swings.turns[i].y, 0.0007 + side * half.next_amplitude, 5e-6) << i;
      EXPECT_NEAR(swings.turns[i].t - swings.turns[i - 1].t, half.duration, 1.5e-3) << i;
      A = half.next_amplitude;
    }
  }
}

TEST(HalfSwings, ThreeReadingsOfFrictionAgreeInThePlainModel) {
  for (const auto& [k, k1, T0] : {std::array{3.41, 2.21, 0.018}, std::array{3.413, 10.5, 0.018}}) {
    const Oscillator<double> link = Link(k, k1, T0);
    const Record decay = Decay(link, 0.04, 0);
    const Swings swings = ReadSwings(decay, kFine);
    const std::size_t sliding = CountSlidingTurns(swings.turns, link), n = swings.turns.size();
    ASSERT_GE(sliding, 3u);
    EXPECT_NEAR(ReadFrictionFromDecrement(swings.turns, sliding, link), T0, 0.002 * T0);
    EXPECT_NEAR(ReadFrictionFromCentre(decay, swings.turns, sliding, link), T0, 0.002 * T0);
    // k1 a + k |o| = T0 holds exactly once locked; without locking (k1 < k) the amplitude comes close to T0/k1.
    EXPECT_NEAR(ReadFrictionFromLock(swings.turns, n - 8, n, 0, link), T0, 0.002 * T0);
  }
}

TEST(HalfSwings, SeveralSlidersHaveNoLock) {
  Oscillator<double> link = Link(3.4, 2, 0.01);
  link.Add({.k = 1, .T0 = 0.002});
  const Swings swings = ReadSwings(Decay(link, 0.03, 0), kFine);
  EXPECT_TRUE(std::isnan(ReadFrictionFromLock(swings.turns, 0, swings.turns.size(), 0, link)));
}

TEST(AmplitudeCurve, IsLinearAndEndsAsItSays) {
  const HalfSwing swings[] = {{.amplitude = 3, .loss = 30}, {.amplitude = 2, .loss = 10}, {.amplitude = 1, .loss = 4}};
  const AmplitudeCurve curve(swings, &HalfSwing::loss);
  EXPECT_DOUBLE_EQ(curve(2.5), 20);
  EXPECT_DOUBLE_EQ(curve(1.5), 7);
  EXPECT_DOUBLE_EQ(curve(0.2), 4);
  EXPECT_DOUBLE_EQ(curve(4), 50);
}

TEST(RollingDecay, FindsTheExponentOfAKnownLoss) {
  for (const double p : {1.0, 1.5, 2.0, 3.0}) {
    std::vector<RollingTail> tails(2);
    for (std::size_t r = 0; r < 2; ++r) {
      const double c = r == 0 ? 0.03 : 0.04;  // in units of the first amplitude, 8 mm
      for (int n = 0; n < 24; ++n) {
        const double q = 2 - p;
        const double a = std::abs(q) < 1e-9 ? std::exp(-c * n) : std::pow(1 - q * c * n, 1 / q);
        const double side = (n % 2 == 0) == (r == 0) ? 1 : -1;
        tails[r].turns.push_back({{.t = 0.42 * n, .y = 1e-4 * n + 0.008 * side * a, .index = 0}, 1e-6, 1});
      }
    }
    const DecayExponent e = FitDecayExponent(tails);
    ASSERT_TRUE(e.known) << p;
    EXPECT_NEAR(e.p, p, 0.002);  // resolution of the search, 0.001
    EXPECT_LT(e.low, p + 0.001);
    EXPECT_GT(e.high, p - 0.001);
  }
}

TEST(RollingDecay, ALosslessTailHasNone) {
  RollingTail tail;
  for (int n = 0; n < 20; ++n)  // errors of one deviation, in a fixed irregular order
    tail.turns.push_back(
        {{.t = 0.42 * n, .y = (n % 2 == 0 ? 0.008 : -0.008) + 1e-6 * std::sin(7.3 * n * n), .index = 0}, 1e-6, 1});
  EXPECT_FALSE(FitDecayExponent({&tail, 1}).known);
  EXPECT_FALSE(FitDecayExponent({}).known);
}

TEST(HarmonicContent, ReadsWhatIsThere) {
  std::vector<double> t, y;
  std::vector<Turn> turns;
  for (int i = 0; i <= 20; ++i)
    turns.push_back({{.t = 0.5 * i, .y = 0.001 + (i % 2 == 0 ? -0.01 : 0.01), .index = 0}, 1e-6, 1});
  for (int i = 0; i < 2000; ++i) {
    t.push_back(0.005 * i);
    const double phase = 2 * std::numbers::pi * t.back();
    y.push_back(0.001 - 0.01 * std::cos(phase) + 0.01 * 0.02 * std::cos(2 * phase) + 0.01 * 0.03 * std::sin(3 * phase));
  }
  const std::array<double, 4> content = CalcHarmonicContent(t, y, turns);
  EXPECT_NEAR(content[0], 0.02, 1e-9);
  EXPECT_NEAR(content[1], 0, 1e-9);
  EXPECT_NEAR(content[2], 0, 1e-9);
  EXPECT_NEAR(content[3], -0.03, 1e-9);  // signs of a motion that starts at a maximum
}

TEST(ResidualSpectrum, NamesLines) {
  const MotionBand motion{.sliding = 0.92, .rolling = 1.18};
  const auto name = [&](double f, double rate) { return NameLine(f, 0.07, motion, rate); };
  EXPECT_EQ(name(0.1, 200).origin, LineOrigin::kDrift);
  EXPECT_EQ(name(1.1, 200).origin, LineOrigin::kMotion);
  EXPECT_EQ(name(2.36, 200).harmonic, 2);
  EXPECT_EQ(name(3.54, 200).harmonic, 3);
  EXPECT_EQ(name(1.3, 200).origin, LineOrigin::kCrossAxis);
  EXPECT_EQ(name(1.65, 200).origin, LineOrigin::kCrossAxis);
  EXPECT_EQ(name(23, 200).origin, LineOrigin::kUnknown);
  EXPECT_EQ(name(50, 200).base, 50);
  EXPECT_EQ(name(50, 200).harmonic, 1);
  EXPECT_EQ(name(20, 200).base, 60);  // 180 Hz folded at 200
  EXPECT_EQ(name(20, 200).harmonic, 3);
  EXPECT_EQ(name(28, 128).harmonic, 2);  // 100 Hz folded at 128
  EXPECT_EQ(name(28, 128).base, 50);
  EXPECT_EQ(name(28, 200).origin, LineOrigin::kUnknown);
}

TEST(NoiseDraws, HoldNothingThatTheFitFollows) {
  Record record;
  record.t.resize(300), record.y.resize(300);
  Eigen::MatrixXd own(300, 2), common(300, 1);
  for (Eigen::Index i = 0; i < 300; ++i)
    own.row(i) << 1, static_cast<double>(i), common(i, 0) = std::sin(0.1 * static_cast<double>(i));
  Eigen::MatrixXd second = 2 * common;
  SymptomInput inputs[2];
  for (SymptomInput& input : inputs) input.record = &record, input.size = 300, input.own = &own;
  inputs[0].sigma = 1e-5, inputs[1].sigma = 3e-5;
  inputs[0].common = &common, inputs[1].common = &second;
  NoiseDraws draws(inputs, 1);
  double squares = 0;
  for (int b = 0; b < 200; ++b) {
    const std::vector<Eigen::VectorXd>& noise = draws.Next();
    for (const Eigen::VectorXd& e : noise) EXPECT_LT((own.transpose() * e).norm(), 1e-8 * own.norm() * e.norm());
    // Common directions are only orthogonal to all records together, each in units of its noise.
    const double first = common.col(0).dot(noise[0]) / 1e-5, other = second.col(0).dot(noise[1]) / 3e-5;
    EXPECT_NEAR(first + other, 0, 1e-8 * std::abs(first) + 1e-9);
    squares += noise[1].squaredNorm() / (9e-10);
  }
  // 300 samples less two of its own and 4/5 of the common one; 200 draws know it to sqrt(2/(200 297)) = 0.6 %.
  EXPECT_NEAR(squares / 200, 297.2, 5);
}

}  // namespace
}  // namespace uiclink
