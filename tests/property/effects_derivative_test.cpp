// Derivatives of the extended solver, for every mechanical effect of the catalogue.
// Figures in the comments on tolerances are the largest that the links below give.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "model/extended_solver.h"
#include "tests/property/effects_fixture.h"

namespace uiclink {
namespace {

class EffectDerivatives : public EveryEffect {};

/// Everything that a run depends on: k, k1, T01, y0, then the parameters of the effects, one after the other.
struct Quantities {
  std::vector<const Effect*> effects;
  std::vector<double> values;

  static Quantities Make(const Link& link, double y0) {
    return {{}, {link.k, link.joints[0].k, link.joints[0].T0, y0}};
  }
  Quantities With(const Effect& effect, const std::vector<double>& of_effect) const {
    Quantities more = *this;
    more.effects.push_back(&effect);
    more.values.insert(more.values.end(), of_effect.begin(), of_effect.end());
    return more;
  }

  template <typename T>
  SolveStatus Run(ExtendedTrajectory<T>* run, const ExtendedSolveOptions& options = {}) const {
    const std::vector<T> q = Lift<T>();
    Oscillator<T> plain;
    plain.k = q[0];
    plain.Add({q[1], q[2]});
    ExtendedOscillator<T> extended = Extend(plain);
    std::span<const T> rest = std::span(q).subspan(4);
    for (const Effect* effect : effects) {
      effect->Extend<T>(rest.first(effect->parameters.size()), &extended);
      rest = rest.subspan(effect->parameters.size());
    }
    return Solve(extended, q[3], kClock, kRecord, run, options);
  }

  /// All dy/dq by the dual solver, column after column.
  std::vector<double> Differentiate(const SampleTimes& times) const {
    ExtendedTrajectory<Dual<8>> run;
    EXPECT_EQ(Run(&run), SolveStatus::kOk);
    std::vector<double> y(times.size), v(times.size), dy(times.size * values.size());
    CalcDisplacements<8>(run, times, static_cast<int>(values.size()), y, v, dy);
    return dy;
  }

 private:
  template <typename T>
  std::vector<T> Lift() const {
    std::vector<T> q;
    for (std::size_t p = 0; p < values.size(); ++p) {
      if constexpr (std::is_same_v<T, double>)
        q.push_back(values[p]);
      else
        q.push_back(T(values[p], static_cast<int>(p)));
    }
    return q;
  }
};

/// dy/dq of one quantity by extrapolated central differences (Ridders), and by how much it differs from its neighbour.
struct Difference {
  std::vector<double> dy;
  double uncertainty = std::numeric_limits<double>::infinity();
};

std::vector<double> CalcQuotient(const Quantities& quantities, std::size_t p, double h) {
  // The steps of the integrator are not the same on both sides: its error, divided by 2 h, must stay below the bound.
  const ExtendedSolveOptions options{.tolerance = 1e-13};
  std::vector<double> y[2];
  double at[2];
  for (int side = 0; side < 2; ++side) {
    Quantities moved = quantities;
    moved.values[p] += side == 0 ? h : -h;
    at[side] = moved.values[p];
    ExtendedTrajectory<double> run;
    EXPECT_EQ(moved.Run(&run, options), SolveStatus::kOk);
    y[side].resize(kSamples.size);
    CalcDisplacements(run, kSamples, y[side]);
  }
  for (std::size_t i = 0; i < kSamples.size; ++i) y[0][i] = (y[0][i] - y[1][i]) / (at[0] - at[1]);
  return y[0];
}

Difference CalcDifference(const Quantities& quantities, std::size_t p) {
  const double size = std::abs(quantities.values[p]);
  // The first step moves the run by 1e-4 of the start: smaller ones go up to the next kink, or to rounding.
  const double slope = MaxAbs(CalcQuotient(quantities, p, 1e-6 * size));
  double h = std::min(0.01 * size, 1e-4 * kStart / slope);
  Difference best;
  std::vector<double> coarse = CalcQuotient(quantities, p, h), previous;
  for (int level = 0; level < 14; ++level) {
    h /= 2;
    std::vector<double> fine = CalcQuotient(quantities, p, h), extrapolated(kSamples.size);
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

/// Largest error of the given columns, as a share of the largest value of the column.
struct DerivativeError {
  double error = 0, uncertainty = 0;  // uncertainty: that of the quotients
};

DerivativeError CompareWithQuotients(const Quantities& quantities, const std::vector<std::size_t>& columns) {
  const std::vector<double> dy = quantities.Differentiate(kSamples);
  DerivativeError worst;
  for (const std::size_t p : columns) {
    const Difference difference = CalcDifference(quantities, p);
    const double error = MaxDifference(std::span(dy).subspan(p * kSamples.size, kSamples.size), difference.dy);
    const double scale = MaxAbs(difference.dy);
    // The bound for the plain model; what the quotients themselves are known to is told with it.
    EXPECT_LT(error, 1e-6 * scale) << "quantity " << p << ", quotients known to " << difference.uncertainty / scale;
    worst.error = std::max(worst.error, error / scale);
    worst.uncertainty = std::max(worst.uncertainty, difference.uncertainty / scale);
  }
  return worst;
}

TEST_P(EffectDerivatives, AreDifferenceQuotients) {
  DerivativeError worst;
  for (const Link& link : {kLinks[0], kLinks[1]}) {
    for (const double share : {0.2, 1.0}) {
      SCOPED_TRACE(testing::Message() << link.name << ", size " << share);
      const Quantities quantities =
          Quantities::Make(link, kStart).With(effect(), MakeEffectValues(effect(), share, ScalesOf(link)));
      std::vector<std::size_t> all(quantities.values.size());
      std::iota(all.begin(), all.end(), 0u);
      const DerivativeError error = CompareWithQuotients(quantities, all);
      worst = {std::max(worst.error, error.error), std::max(worst.uncertainty, error.uncertainty)};
    }
  }
  Measured() << effect().id << " derivatives: error <= " << worst.error << ", quotients known to " << worst.uncertainty
             << "\n";
}

TEST_P(EffectDerivatives, AreDifferenceQuotientsBesideStribeckAndClearance) {
  // These two make the most events: a force that jumps at breakouts, and three states of each joint.
  DerivativeError worst;
  for (const char* id : {"stribeck_friction", "clearance"}) {
    const Effect& other = *FindEffect(id);
    if (&other == &effect()) continue;
    SCOPED_TRACE(id);
    const Scales scales = ScalesOf(kLinks[0]);
    const Quantities quantities = Quantities::Make(kLinks[0], kStart)
                                      .With(effect(), MakeEffectValues(effect(), 0.7, scales))
                                      .With(other, MakeEffectValues(other, 0.5, scales));
    const DerivativeError error = CompareWithQuotients(quantities, {4, 4 + effect().parameters.size()});
    worst = {std::max(worst.error, error.error), std::max(worst.uncertainty, error.uncertainty)};
  }
  Measured() << effect().id << " derivatives in pairs: error <= " << worst.error << ", quotients known to "
             << worst.uncertainty << "\n";
}

TEST_P(EffectDerivatives, AreDifferenceQuotientsAtSizeZero) {
  // What a score test stands on: dy/dsize at zero size, against one-sided differences (a loss cannot be negative).
  // Over the first 4 s: with k1 < k slips shrink for ever at zero size, but end at any size that loses energy, so later
  // the slope at zero holds for ever smaller sizes only.
  const SampleTimes early{.first = 0, .step = 0.01, .size = 401};
  double worst = 0;
  for (const Link& link : {kLinks[0], kLinks[1]}) {
    const double full = MakeEffectValues(effect(), 1, ScalesOf(link))[0];
    const Quantities quantities =
        Quantities::Make(link, kStart).With(effect(), MakeEffectValues(effect(), 0, ScalesOf(link)));
    const std::vector<double> dy = quantities.Differentiate(early);
    const auto moved = [&](double share) {
      Quantities at = quantities;
      at.values[4] += share * full;
      ExtendedTrajectory<double> run_at;
      EXPECT_EQ(at.Run(&run_at, {.tolerance = 1e-13}), SolveStatus::kOk);
      std::vector<double> y_at(early.size);
      CalcDisplacements(run_at, early, y_at);
      return y_at;
    };
    constexpr double h = 1e-4;
    const std::vector<double> at_0 = moved(0), at_1 = moved(h), at_2 = moved(2 * h);
    double error = 0, scale = 0;
    for (std::size_t i = 0; i < early.size; ++i) {
      const double quotient = (4 * at_1[i] - at_2[i] - 3 * at_0[i]) / (2 * h * full);  // of order h^2
      error = std::max(error, std::abs(quotient - dy[4 * early.size + i]));
      scale = std::max(scale, std::abs(quotient));
    }
    // h^2 = 1e-8 times how much the sensitivity bends over the whole size, which is of order 1 to 10.
    EXPECT_LT(error, 1e-6 * scale) << link.name;
    worst = std::max(worst, error / scale);
  }
  Measured() << effect().id << " derivative at zero size: error <= " << worst << "\n";
}

INSTANTIATE_TEST_SUITE_P(Catalogue, EffectDerivatives, testing::ValuesIn(Select(IsMechanical)), IdOf);

}  // namespace
}  // namespace uiclink
