#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <random>
#include <string>
#include <vector>

#include "model/effect.h"
#include "model/extended_solver.h"
#include "tests/support/effect_values.h"

/// What the tests of the catalogue share: links, starts, sizes of effects, one run.
namespace uiclink {

inline void PrintTo(const Effect* effect, std::ostream* stream) { *stream << effect->id; }

inline constexpr double kRecord = 15;  // length of a record [s]
inline const SampleTimes kSamples{.first = 0, .step = 0.01, .size = 1501};

struct Link {
  const char* name;
  double k;
  std::vector<Slider<double>> joints;
};

/// Slips that shrink for ever (k1 < k), a link that locks (k1 > k), and four joints.
inline const std::array kLinks = {
    Link{"set 1", 4.2010, {{1.4222, 0.014}}}, Link{"set 2", 3.413, {{10.503, 0.018}}},
    Link{"longitudinal set 2", 5.50, {{3.44, 6.98e-3}, {2.00, 5.11e-3}, {0.33, 0.91e-3}, {1.90, 7.16e-3}}}};

inline Oscillator<double> MakePlain(const Link& link) {
  Oscillator<double> plain;
  plain.k = link.k;
  for (const Slider<double>& joint : link.joints) plain.Add(joint);
  return plain;
}

inline constexpr double kStart = 0.0253;  // [m]; a round number would put the starts of positions on the start itself
inline constexpr double kClock = 2.5;     // the record's clock there [s]

/// Largest displacement and largest speed of the free decay of a link.
inline Scales ScalesOf(const Link& link, double start = kStart) {
  double K = link.k;
  for (const Slider<double>& joint : link.joints) K += joint.k;
  return {.swing = start, .speed = start * std::sqrt(kThesisGravity * K)};
}

inline std::ostream& Measured() { return std::cout << "[ MEASURED ] "; }

inline double MaxDifference(std::span<const double> a, std::span<const double> b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

inline double MaxAbs(std::span<const double> a) {
  double worst = 0;
  for (const double x : a) worst = std::max(worst, std::abs(x));
  return worst;
}

inline std::vector<double> Displacements(const ExtendedOscillator<double>& oscillator, double y0,
                                         const ExtendedSolveOptions& options = {}) {
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(oscillator, y0, kClock, kRecord, &run, options), SolveStatus::kOk);
  std::vector<double> y(kSamples.size);
  CalcDisplacements(run, kSamples, y);
  return y;
}

inline ExtendedOscillator<double> Extended(const Link& link, const Effect& effect, double share) {
  return With<double>(Extend(MakePlain(link)), effect, MakeEffectValues(effect, share, ScalesOf(link)));
}

/// Extrema of a run after its start: where the arcs change direction.
inline std::vector<double> FindExtrema(const ExtendedOscillator<double>& oscillator, double y0, double duration) {
  ExtendedTrajectory<double> run;
  EXPECT_EQ(Solve(oscillator, y0, kClock, duration, &run), SolveStatus::kOk);
  std::vector<double> extrema;
  double d = y0 > 0 ? -1 : 1;
  for (const ExtendedArc<double>& arc : run.arcs()) {
    // An arc ends where the mass turns round, so its direction is that of its middle.
    const double v = CalcVelocity(arc, 0.5 * (arc.t_end - arc.t_start));
    if (v * d < 0) {
      extrema.push_back(CalcDisplacement(arc, 0.0));
      d = -d;
    }
  }
  return extrema;
}

/// Motion is integrated rather than known in closed form.
inline bool IsIntegrated(const ExtendedOscillator<double>& oscillator) {
  return !oscillator.forces.empty() || !oscillator.speed_terms.empty();
}

/// Links and sizes far from the published sets: k1/k from 0.1 to 4, slips from 1 to 12 mm, sizes over a decade.
struct RandomCases {
  std::mt19937_64 random;

  double LogUniform(double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0, 1)(random));
  }
  /// A value between the bounds of a parameter, as laws are given it.
  double Inside(const EffectParameter& p) {
    if (p.coordinate == Coordinate::kInverseSquare)
      return std::uniform_real_distribution<double>(0, 1 / (p.low * p.low))(random);
    if (p.coordinate == Coordinate::kLog) return LogUniform(p.low, p.high);
    return std::uniform_real_distribution<double>(p.low, p.high)(random);
  }
  Link NextLink() {
    const double k = LogUniform(2, 10), k1 = k * LogUniform(0.1, 4);
    return {"random", k, {{k1, k1 * LogUniform(1e-3, 12e-3)}}};
  }
};

class EveryEffect : public testing::TestWithParam<const Effect*> {
 protected:
  const Effect& effect() const { return *GetParam(); }
};

template <typename Condition>
std::vector<const Effect*> Select(Condition condition) {
  std::vector<const Effect*> selected;
  for (const Effect* effect : Effects())
    if (condition(*effect)) selected.push_back(effect);
  return selected;
}
inline std::string IdOf(const testing::TestParamInfo<const Effect*>& test) { return std::string(test.param->id); }

inline bool IsMechanical(const Effect& effect) { return effect.IsMechanical(); }

}  // namespace uiclink
