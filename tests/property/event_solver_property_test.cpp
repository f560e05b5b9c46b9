// What holds for every link: agreement with CVODE, derivatives, and the laws of spring-slider systems.
// Figures in the comments on tolerances are the largest that the written seeds give.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <random>
#include <vector>

#include "model/closed_form.h"
#include "model/event_solver.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/cvode_reference.h"

namespace uiclink {
namespace {

constexpr double kRecord = 15;  // length of a record [s]
const SampleTimes kEvery5ms{.first = 0, .step = 0.005, .size = 3001};
const SampleTimes kEvery50ms{.first = 0, .step = 0.05, .size = 301};

template <typename Scalar>
struct Link {
  Oscillator<Scalar> oscillator;
  State<Scalar> start;
};

/// All that a run depends on as one list of numbers, so that differences can be taken in each of them:
/// k, k_i, T0i, y0, v0, T_i(0) / T0i.
struct Quantities {
  int n = 0;
  std::vector<double> values;
  std::vector<double> sizes;  // what a change is to be compared with

  /// The first N quantities carry their derivatives, or none when Scalar is double.
  template <typename Scalar>
  Link<Scalar> MakeLink() const {
    std::vector<Scalar> q;
    for (std::size_t p = 0; p < values.size(); ++p) q.push_back(MakeScalar<Scalar>(p));
    Link<Scalar> link;
    link.oscillator.k = q[0];
    const auto sliders = static_cast<std::size_t>(n);
    link.start.y = q[1 + 2 * sliders];
    link.start.v = q[2 + 2 * sliders];
    for (std::size_t i = 0; i < sliders; ++i) {
      link.oscillator.Add({q[1 + i], q[1 + sliders + i]});
      link.start.T[i] = q[1 + sliders + i] * q[3 + 2 * sliders + i];
    }
    return link;
  }

 private:
  template <typename Scalar>
  Scalar MakeScalar(std::size_t p) const {
    if constexpr (!std::is_same_v<Scalar, double>)
      if (p < static_cast<std::size_t>(Scalar::DIMENSION)) return Scalar(values[p], static_cast<int>(p));
    return Scalar(values[p]);
  }
};

/// Links far beyond what is built: k1/k from 0.005 to 30, slip limits from 17 um to 0.4 m, any slider state and
/// velocity.
class RandomLinks {
 public:
  explicit RandomLinks(std::uint64_t seed) : random_(seed) {}

  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double LogUniform(double low, double high) { return low * std::pow(high / low, Uniform(0, 1)); }

  Quantities Next(int n) {
    Quantities q{.n = n, .values = {LogUniform(1, 20)}, .sizes = {}};
    for (int i = 0; i < n; ++i) q.values.push_back(LogUniform(0.1, 30) / n);
    for (int i = 0; i < n; ++i) q.values.push_back(LogUniform(5e-4, 0.04) / n);
    q.sizes = q.values;
    q.values.push_back(Uniform(-0.05, 0.05));
    q.sizes.push_back(0.05);
    q.values.push_back(Uniform(-0.4, 0.4));
    q.sizes.push_back(0.4);
    for (int i = 0; i < n; ++i) {
      q.values.push_back(Uniform(-0.98, 0.98));
      q.sizes.push_back(1);
    }
    return q;
  }

 private:
  std::mt19937_64 random_;
};

std::vector<double> Displacements(const Link<double>& link, const SampleTimes& times) {
  Trajectory<double> run;
  EXPECT_EQ(Solve(link.oscillator, link.start, kRecord, &run), SolveStatus::kOk);
  std::vector<double> y(times.size);
  CalcDisplacements(run, times, y);
  return y;
}

double MaxDifference(std::span<const double> a, std::span<const double> b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

double MaxAbs(std::span<const double> a) {
  double worst = 0;
  for (const double x : a) worst = std::max(worst, std::abs(x));
  return worst;
}

long CountBreakouts(const Trajectory<double>& run) {
  return std::count_if(run.arcs().begin(), run.arcs().end(),
                       [](const Arc<double>& arc) { return arc.end == EventKind::kBreakout; });
}

std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

// ---------------------------------------------------------------------------------------------------------------------
// CVODE.  No case is left out as ambiguous: where rounding decides whether a slip at a turning point happens, the two
// solvers may count slips differently, but the slip that one of them leaves out is as small as what decided.

/// One link by both solvers.
struct Comparison {
  double difference = 0;  // largest |dy| over the record [m]
  bool same_slips = true;
};

Comparison CompareWithCvode(const Link<double>& link, CvodeReference* cvode) {
  Trajectory<double> run;
  EXPECT_EQ(Solve(link.oscillator, link.start, kRecord, &run), SolveStatus::kOk);
  std::vector<double> exact(kEvery5ms.size), stepped(kEvery5ms.size);
  CalcDisplacements(run, kEvery5ms, exact);
  const CvodeCounts counts = cvode->Run(link.oscillator, link.start, kEvery5ms, stepped);
  return {MaxDifference(exact, stepped), CountBreakouts(run) == counts.breakouts};
}

class EventSolverAndCvode : public testing::TestWithParam<int> {};

TEST_P(EventSolverAndCvode, AgreeForRandomLinks) {
  const int n = GetParam();
  RandomLinks random(20260301 + static_cast<std::uint64_t>(n));
  CvodeReference cvode(n, 0);
  double worst = 0, worst_other_slips = 0;
  int other_slips = 0;
  constexpr int kLinks = 120;
  for (int trial = 0; trial < kLinks; ++trial) {
    const Comparison comparison = CompareWithCvode(random.Next(n).MakeLink<double>(), &cvode);
    // The task's bound.  CVODE at rtol 1e-12 drifts by up to 2e-10 m, what its tolerance makes of up to 20000 steps.
    ASSERT_LT(comparison.difference, 1e-9) << "link " << trial;
    worst = std::max(worst, comparison.difference);
    if (comparison.same_slips) continue;
    ++other_slips;
    worst_other_slips = std::max(worst_other_slips, comparison.difference);
  }
  Measured() << kLinks << " links of " << n << " sliders: |dy| <= " << worst << " m; " << other_slips
             << " with another number of slips: |dy| <= " << worst_other_slips << " m\n";
}
INSTANTIATE_TEST_SUITE_P(Sliders, EventSolverAndCvode, testing::Values(1, 2, 4));

TEST(EventSolverAndCvode, AgreeWhereSlipsShrinkForEver) {
  // k1 <= k: after every half swing what exceeds T0/k1 is (k - k1)/(k + k1) of what it was, so every run ends in
  // slips that no solver can tell from none.  Starts from 1e-1 to 1e-12 above the limit, and on it.
  RandomLinks random(20260311);
  CvodeReference cvode(1, 0);
  double worst = 0;
  int links = 0, other_slips = 0;
  for (int power = 1; power <= 13; ++power) {
    for (int trial = 0; trial < 8; ++trial) {
      const double k = random.LogUniform(2, 10);
      const double k1 = trial == 0 ? k : k * random.LogUniform(0.05, 1);  // 0: the excess is squared, not multiplied
      Link<double> link;
      link.oscillator.k = k;
      link.oscillator.Add({k1, random.LogUniform(0.01, 0.05) * k1});
      const double excess = power == 13 ? 0 : std::pow(10, -power);
      link.start = AtExtremum(link.oscillator, link.oscillator.sliders()[0].T0 / k1 * (1 + excess));
      const Comparison comparison = CompareWithCvode(link, &cvode);
      ASSERT_LT(comparison.difference, 1e-9) << "k " << k << ", k1 " << k1 << ", excess " << excess;
      worst = std::max(worst, comparison.difference);
      ++links;
      other_slips += !comparison.same_slips;
    }
  }
  Measured() << links << " links with endless slips: |dy| <= " << worst << " m; " << other_slips
             << " with another number of slips\n";
  EXPECT_GT(other_slips, 0);  // else this test does not test what it is for
}

TEST(EventSolver, MotionIsContinuousWhereASlipVanishes) {
  // Why no case above is ambiguous: on both sides of a graze, amplitudes A = (T0/k1)(1 +- e) give runs that differ in
  // the number of slips, yet differ by no more than a fixed multiple of e.
  RandomLinks random(20260312);
  for (int trial = 0; trial < 40; ++trial) {
    Link<double> link;
    link.oscillator.k = random.LogUniform(1, 20);
    link.oscillator.Add({random.LogUniform(0.1, 30), random.LogUniform(5e-4, 0.04)});
    const double limit = link.oscillator.sliders()[0].T0 / link.oscillator.sliders()[0].k;
    for (double e = 1e-3; e > 1e-12; e /= 10) {
      Link<double> above = link, below = link;
      above.start = AtExtremum(link.oscillator, limit * (1 + e));
      below.start = AtExtremum(link.oscillator, limit * (1 - e));
      // |dy/dA| of a half swing is below 1 + 2 k1/(k + k1) < 3 on either side; the sum of the later ones is bounded.
      EXPECT_LT(MaxDifference(Displacements(above, kEvery50ms), Displacements(below, kEvery50ms)),
                6 * limit * e + 1e-14 * limit);
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------------
// Derivatives.  An error is relative to the largest value of its column over the record.

template <int N>
std::vector<double> Derivatives(const Link<Dual<N>>& link, const SampleTimes& times) {
  Trajectory<Dual<N>> run;
  EXPECT_EQ(Solve(link.oscillator, link.start, kRecord, &run), SolveStatus::kOk);
  std::vector<double> y(times.size), v(times.size), dy(times.size * N);
  CalcDisplacements(run, times, y, v, dy);
  return dy;
}

std::span<const double> Column(const std::vector<double>& dy, std::size_t p, const SampleTimes& times) {
  return std::span(dy).subspan(p * times.size, times.size);
}

/// dy/dq of one quantity by extrapolated central differences (Ridders): steps h, h/2, h/4 ..., from each pair the error
/// of order h^2 is taken out, and the one that differs least from its neighbour is taken.
struct Difference {
  std::vector<double> dy;
  double uncertainty = std::numeric_limits<double>::infinity();  // by which it differs
};

Difference CalcDifference(const Quantities& quantities, std::size_t p, const SampleTimes& times) {
  const auto central = [&](double h) {
    Quantities up = quantities, down = quantities;
    up.values[p] += h;
    down.values[p] -= h;
    const std::vector<double> plus = Displacements(up.MakeLink<double>(), times);
    const std::vector<double> minus = Displacements(down.MakeLink<double>(), times);
    std::vector<double> dy(times.size);
    for (std::size_t i = 0; i < dy.size(); ++i) dy[i] = (plus[i] - minus[i]) / (up.values[p] - down.values[p]);
    return dy;
  };
  // The first step moves the run by 1e-3 of its amplitude: smaller ones go up to the next kink, or to rounding.
  const double amplitude = MaxAbs(Displacements(quantities.MakeLink<double>(), times));
  const double slope = MaxAbs(central(1e-7 * quantities.sizes[p]));
  double h = std::min(0.01 * quantities.sizes[p], 1e-3 * amplitude / slope);
  Difference best;
  std::vector<double> coarse = central(h), previous;
  for (int level = 0; level < 14; ++level) {
    h /= 2;
    std::vector<double> fine = central(h), extrapolated(times.size);
    for (std::size_t i = 0; i < fine.size(); ++i) extrapolated[i] = (4 * fine[i] - coarse[i]) / 3;
    if (!previous.empty()) {
      const double change = MaxDifference(extrapolated, previous);
      if (change < best.uncertainty) best = {extrapolated, change};
    }
    previous = std::move(extrapolated);
    coarse = std::move(fine);
  }
  return best;
}

/// Columns of all quantities (n = 1, 2) or of the first N = 2n + 2 (n = 4: all parameters and y0).
template <int n, int N>
void CompareWithDifferences(int links) {
  // Runs round to about 1e-14 m and the second step is 0.005 of a quantity at most; the extrapolation makes that 1e-11
  // m in a quotient times the quantity, which is 1e-6 where the whole quantity moves the run by 10 um.  The quotients
  // of quantities that move it by less are known no better, and are held to 1e-11 m.
  constexpr double kLeastMotion = 1e-5;
  RandomLinks random(20260320 + static_cast<std::uint64_t>(n));
  double worst = 0, worst_uncertainty = 0;
  int columns = 0, small = 0;
  for (int trial = 0; trial < links; ++trial) {
    const Quantities quantities = random.Next(n);
    const std::vector<double> exact = Derivatives<N>(quantities.MakeLink<Dual<N>>(), kEvery50ms);
    for (std::size_t p = 0; p < std::min<std::size_t>(N, quantities.values.size()); ++p, ++columns) {
      const Difference difference = CalcDifference(quantities, p, kEvery50ms);
      const double error = MaxDifference(Column(exact, p, kEvery50ms), difference.dy);
      const double scale = MaxAbs(difference.dy), least = kLeastMotion / quantities.sizes[p];
      // The task's bound.
      ASSERT_LT(error, 1e-6 * std::max(scale, least)) << "link " << trial << ", quantity " << p << ", largest " << scale
                                                      << ", quotients known to " << difference.uncertainty;
      if (scale < least) {
        ++small;
        continue;
      }
      worst = std::max(worst, error / scale);
      worst_uncertainty = std::max(worst_uncertainty, difference.uncertainty / scale);
    }
  }
  Measured() << columns << " derivatives of " << links << " links of " << n << " sliders: error <= " << worst
             << ", quotients known to " << worst_uncertainty << "; " << small << " move the run by less than 10 um\n";
  EXPECT_LT(small, columns / 5);  // else the test says little
}

TEST(EventSolverDerivatives, AreDifferenceQuotientsForOneSlider) { CompareWithDifferences<1, 6>(120); }
TEST(EventSolverDerivatives, AreDifferenceQuotientsForTwoSliders) { CompareWithDifferences<2, 10>(60); }
TEST(EventSolverDerivatives, AreDifferenceQuotientsForFourSliders) { CompareWithDifferences<4, 10>(120); }

template <int n, int N>
void CompareWithCvodes(int links) {
  RandomLinks random(20260330 + static_cast<std::uint64_t>(n));
  double worst = 0;
  for (int trial = 0; trial < links; ++trial) {
    const Quantities quantities = random.Next(n);
    const Link<Dual<N>> link = quantities.MakeLink<Dual<N>>();
    CvodeOptions options;
    options.parameter_scale.assign(quantities.sizes.begin(), quantities.sizes.begin() + N);
    CvodeReference cvodes(n, N, options);
    std::vector<double> y(kEvery50ms.size), dy(kEvery50ms.size * N);
    cvodes.Run(link.oscillator, link.start, kEvery50ms, y, dy);
    const std::vector<double> exact = Derivatives<N>(link, kEvery50ms);
    for (std::size_t p = 0; p < static_cast<std::size_t>(N); ++p) {
      const double scale = MaxAbs(Column(exact, p, kEvery50ms));
      const double error = MaxDifference(Column(exact, p, kEvery50ms), Column(dy, p, kEvery50ms));
      ASSERT_LE(error, 1e-6 * scale) << "link " << trial << ", quantity " << p;
      if (scale > 0) worst = std::max(worst, error / scale);
    }
  }
  Measured() << links << " links of " << n << " sliders against CVODES: error <= " << worst << "\n";
}

TEST(EventSolverDerivatives, AreCvodesSensitivitiesForOneSlider) { CompareWithCvodes<1, 6>(60); }
TEST(EventSolverDerivatives, AreCvodesSensitivitiesForFourSliders) { CompareWithCvodes<4, 10>(20); }

TEST(EventSolverDerivatives, AreOneSidedWhereASlipVanishes) {
  // At A = T0/k1 the run grazes the limit.  Below, no joint slips, and the run is linear in A; above, one does. Between
  // them dy/dA jumps, and the solver, which does not slip at a graze, gives the derivative from below.
  Oscillator<double> o;
  o.k = 3.4;
  o.Add({5, 0.01});
  const double limit = 0.01 / 5;
  const auto exact = [&](double A) {
    Link<Dual<4>> link{.oscillator = WithDerivatives<4>(o), .start = {}};
    link.start = AtExtremum(link.oscillator, Dual<4>(A, 3));
    const std::vector<double> dy = Derivatives<4>(link, kEvery50ms);
    const std::span<const double> by_y0 = Column(dy, 3, kEvery50ms);
    return std::vector<double>(by_y0.begin(), by_y0.end());
  };
  const auto quotient = [&](double from, double to) {
    std::vector<double> dy = Displacements({.oscillator = o, .start = AtExtremum(o, to)}, kEvery50ms);
    const std::vector<double> y = Displacements({.oscillator = o, .start = AtExtremum(o, from)}, kEvery50ms);
    for (std::size_t i = 0; i < dy.size(); ++i) dy[i] = (dy[i] - y[i]) / (to - from);
    return dy;
  };
  EXPECT_LT(MaxDifference(exact(limit), quotient(limit * (1 - 1e-6), limit)), 1e-9);  // rounding 1e-18 m / 2e-9 m
  // Above, y has a term of (A - limit)^1.5: the slope changes with the root of the step, 1e-4 here, times a few.
  EXPECT_LT(MaxDifference(exact(limit * (1 + 1e-8)), quotient(limit, limit * (1 + 1e-8))), 1e-3);
  EXPECT_GT(MaxDifference(exact(limit * (1 + 1e-8)), exact(limit)), 0.5);
}

TEST(EventSolverDerivatives, GoOnFromAnyStateOfARun) {
  RandomLinks random(20260340);
  constexpr int N = 10;
  Trajectory<Dual<N>> whole, rest;
  double worst_y = 0, worst_dy = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Link<Dual<N>> link = random.Next(4).MakeLink<Dual<N>>();
    ASSERT_EQ(Solve(link.oscillator, link.start, kRecord, &whole), SolveStatus::kOk);
    const std::size_t event = whole.arcs().size() / 3;
    for (const double cut : {random.Uniform(0, 3), random.Uniform(3, 14), whole.arcs()[event].t_end}) {
      State<Dual<N>> state{.y = whole.y(cut), .v = whole.v(cut)};
      for (std::size_t i = 0; i < 4; ++i) state.T[i] = whole.T(i, cut);
      ASSERT_EQ(Solve(link.oscillator, state, kRecord - cut, &rest), SolveStatus::kOk);
      Eigen::Matrix<double, N, 1> scale = Eigen::Matrix<double, N, 1>::Constant(1e-300), error = 0 * scale;
      for (double t = 0; t < kRecord - cut; t += 0.05) {
        const Dual<N> a = whole.y(cut + t), b = rest.y(t);
        worst_y = std::max(worst_y, std::abs(a.a - b.a));
        scale = scale.cwiseMax(a.v.cwiseAbs());
        error = error.cwiseMax((a.v - b.v).cwiseAbs());
      }
      worst_dy = std::max(worst_dy, error.cwiseQuotient(scale).maxCoeff());
    }
  }
  Measured() << "restart: |dy| <= " << worst_y << " m, derivatives to " << worst_dy << "\n";
  EXPECT_LT(worst_y, 1e-13);  // rounding of 0.1 m through some 100 arcs
  EXPECT_LT(worst_dy, 1e-9);
}

// ---------------------------------------------------------------------------------------------------------------------
// Laws of spring-slider systems.

TEST(EventSolver, EqualSlidersAreOneSliderOfTheirSum) {
  RandomLinks random(20260350);
  for (int trial = 0; trial < 100; ++trial) {
    const Link<double> one = random.Next(1).MakeLink<double>();
    Link<double> many;
    many.oscillator.k = one.oscillator.k;
    many.start = one.start;
    const int n = 2 + trial % (kMaxSliders - 1);
    for (int i = 0; i < n; ++i) {
      many.oscillator.Add({one.oscillator.sliders()[0].k / n, one.oscillator.sliders()[0].T0 / n});
      many.start.T[static_cast<std::size_t>(i)] = one.start.T[0] / n;
    }
    // Rounding of 0.1 m through some 100 arcs.
    ASSERT_LT(MaxDifference(Displacements(one, kEvery50ms), Displacements(many, kEvery50ms)), 1e-13) << n;
  }
}

TEST(EventSolver, ForcesFollowMasingsRule) {
  // From a turning point the forces of all sliders follow the curve of first loading,  S(y) = sum min(k_i y, T0i),
  // turned round and doubled in both axes:  sum T = sum T(turning) +- 2 S(|y - y(turning)| / 2).
  RandomLinks random(20260360);
  for (int trial = 0; trial < 100; ++trial) {
    Link<double> link = random.Next(1 + trial % 4).MakeLink<double>();
    link.start = {.y = 0, .v = random.Uniform(0.1, 0.5)};
    const auto sliders = link.oscillator.sliders();
    Trajectory<double> run;
    ASSERT_EQ(Solve(link.oscillator, link.start, kRecord, &run), SolveStatus::kOk);
    const auto force = [&](double t) {
      double sum = 0;
      for (std::size_t i = 0; i < sliders.size(); ++i) sum += run.T(i, t);
      return sum;
    };
    const auto first_loading = [&](double y) {
      double sum = 0;
      for (const Slider<double>& slider : sliders) sum += std::min(slider.k * y, slider.T0);
      return sum;
    };
    double from_y = 0, from_force = 0, times = 1, direction = 1;
    for (const Arc<double>& arc : run.arcs()) {
      if (arc.end == EventKind::kEnd) break;  // rolls to and fro from here on
      for (const double part : {0.0, 0.1, 0.5, 0.9, 1.0}) {
        const double t = arc.t_start + part * (arc.t_end - arc.t_start);
        const double expected = from_force - direction * times * first_loading(std::abs(run.y(t) - from_y) / times);
        ASSERT_NEAR(force(t), expected, 1e-13) << trial << ", t = " << t;  // rounding of 0.1 through some 100 arcs
      }
      if (arc.end != EventKind::kTurning) continue;
      from_y = run.y(arc.t_end);
      from_force = force(arc.t_end);
      times = 2;
      direction = -direction;
    }
  }
}

TEST(EventSolver, TheRunDoesNotDependOnWhereItIsSampled) {
  RandomLinks random(20260370);
  for (int trial = 0; trial < 40; ++trial) {
    const Link<double> link = random.Next(4).MakeLink<double>();
    Trajectory<double> run, half;
    ASSERT_EQ(Solve(link.oscillator, link.start, kRecord, &run), SolveStatus::kOk);
    ASSERT_EQ(Solve(link.oscillator, link.start, kRecord / 2, &half), SolveStatus::kOk);
    std::vector<double> list(500);
    for (double& t : list) t = random.Uniform(-0.1, kRecord + 1);
    list[1] = list[0];  // one time twice
    std::sort(list.begin(), list.end());
    const SampleTimes grids[] = {kEvery5ms,
                                 {.first = 0.1234, .step = 0.37, .size = 40},
                                 {.first = 3.3, .step = 1e-4, .size = 5000},
                                 {.first = -1, .step = 6, .size = 4},
                                 {.first = 20, .step = 0.1, .size = 7},
                                 {.size = list.size(), .times = list}};
    for (const SampleTimes& grid : grids) {
      std::vector<double> y(grid.size);
      CalcDisplacements(run, grid, y);
      for (std::size_t i = 0; i < grid.size; ++i) {
        ASSERT_NEAR(y[i], run.y(grid[i]), 2e-14) << grid[i];  // 1e-14 of 0.1 m per thousand samples of an arc
        if (grid[i] < kRecord / 2) {
          ASSERT_EQ(run.y(grid[i]), half.y(grid[i]));
        }
      }
    }
  }
}

template <typename Scalar>
std::size_t CountAllocationsOfSecondRun(const Link<Scalar>& link, Trajectory<Scalar>* run) {
  EXPECT_EQ(Solve(link.oscillator, link.start, kRecord, run), SolveStatus::kOk);
  const std::size_t before = CountAllocations();
  EXPECT_EQ(Solve(link.oscillator, link.start, kRecord, run), SolveStatus::kOk);
  return CountAllocations() - before;
}

TEST(EventSolver, ASecondRunAllocatesNothing) {
  RandomLinks random(20260380);
  const Quantities quantities = random.Next(4);
  Trajectory<double> run;
  Trajectory<Dual<10>> dual;
  std::vector<double> y(kEvery5ms.size), v(kEvery5ms.size), dy(kEvery5ms.size * 10);
  const std::size_t at_first = CountAllocations();
  EXPECT_EQ(CountAllocationsOfSecondRun(quantities.MakeLink<double>(), &run), 0u);
  EXPECT_EQ(CountAllocationsOfSecondRun(quantities.MakeLink<Dual<10>>(), &dual), 0u);
  EXPECT_GT(CountAllocations(), at_first);  // the counter counts: the first runs did allocate
  const std::size_t before = CountAllocations();
  CalcDisplacements(run, kEvery5ms, y);
  CalcDisplacements(dual, kEvery5ms, y, v, dy);
  EXPECT_EQ(CountAllocations(), before);
}

}  // namespace
}  // namespace uiclink
