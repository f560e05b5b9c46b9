// One record of 15 s at 200 Hz with one effect of each kind: the extended solver at the tolerance of a fit against
// CVODES on the same equation.

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "identify/extended_columns.h"
#include "model/effect.h"
#include "model/extended_solver.h"
#include "model/extremum_deflection.h"
#include "tests/bench/ratio.h"
#include "tests/support/effect_values.h"
#include "tests/support/extended_cvode_reference.h"

namespace uiclink {
namespace {

constexpr double kRelease = 0.025, kClock = 2.5;  // [m], [s]
const SampleTimes kSamples{.first = 0, .step = 0.005, .size = 3001};

/// 15 s of set 2 lateral with one effect: ours at the tolerance of fits against the reference integration.
Comparison AgainstCvode(const char* id, double least_ratio, double largest_difference) {
  struct Case {
    ExtendedOscillator<double> oscillator;
    std::vector<double> deflection;
    ExtendedTrajectory<double> run;
    std::vector<double> y = std::vector<double>(kSamples.size), cvode_y = y;
  };
  auto made = std::make_shared<Case>();
  Oscillator<double> link;  // table 4.1 of the thesis
  link.k = 3.413;
  link.Add({.k = 10.503, .T0 = 0.018});
  const Effect& effect = *FindEffect(id);
  made->oscillator = With<double>(Extend(link), effect, MakeEffectValues(effect, 1));
  for (std::size_t i = 0; i < made->oscillator.sliders.size(); ++i)
    made->deflection.push_back(CalcDeflectionAtExtremum(made->oscillator, i, kRelease, kClock));
  return {
      .name = std::string(id) + ": record",
      .ours = Timed("event by event, tolerance of fits", 20,
                    [made] {
                      Solve(made->oscillator, kRelease, kClock, 15, &made->run, {.tolerance = kFitTolerance});
                      CalcDisplacements(made->run, kSamples, made->y);
                    }),
      .theirs = Timed(
          "CVODES (Adams, fixed point) with roots, rtol 1e-12, steps up to 10 ms", 1,
          [made] { RunExtendedCvode(made->oscillator, kRelease, made->deflection, kClock, kSamples, made->cvode_y); }),
      .least_ratio = least_ratio,
      .difference =
          [made] {
            double worst = 0;
            for (std::size_t i = 0; i < made->y.size(); ++i)
              worst = std::max(worst, std::abs(made->y[i] - made->cvode_y[i]));
            return worst;
          },
      .largest_difference = largest_difference,
      .unit = "m"};
}

std::vector<Comparison> CompareWithCvode() {
  // Closed forms were 7e-12 m off, which is what the reference's tolerance adds up to in 15 s; integrated motions 9e-10
  // m at a fit's tolerance of 1e-9 a step. Ten times that, for other machines.
  constexpr double kClosed = 1e-10, kIntegrated = 1e-8;
  return {AgainstCvode("viscous_damping", 100, kClosed), AgainstCvode("micro_slip", 50, kClosed),
          AgainstCvode("friction_drift", 100, kClosed), AgainstCvode("cubic_stiffness", 10, kIntegrated),
          AgainstCvode("stribeck_friction", 50, kIntegrated)};
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) { return uiclink::RunComparisons(argc, argv, uiclink::CompareWithCvode()); }
