#pragma once

#include <memory>
#include <span>
#include <vector>

#include "model/oscillator.h"
#include "model/trajectory.h"

namespace uiclink {

struct CvodeOptions {
  double rtol = 1e-12;
  double atol = 1e-14;  ///< of every component: y [m], v [m/s], T_i [-]; and of their derivatives, see derivative_scale
  enum class Method { kAdams, kBdf } method = Method::kAdams;
  enum class Corrector { kFixedPoint, kNewton } corrector = Corrector::kFixedPoint;
  enum class Sensitivities { kSimultaneous, kStaggered } sensitivities = Sensitivities::kSimultaneous;
  /// Whether the derivatives take part in the choice of the step.  CVODES's own default is false.
  bool control_derivatives = true;
  /// Size of each derivative, in the order of the dual quantities: its absolute tolerance is atol / p.  One where
  /// missing.
  std::vector<double> parameter_scale;
};

struct CvodeCounts {
  long steps = 0;
  long rhs_calls = 0;
  long breakouts = 0;
  long turnings = 0;
};

/// The bench model by general-purpose means, to check and to time the event solver against; it shares data types with
/// it and nothing else.
///
///   y' = v,  v' = g (-k y + sum T_i),  T_i' = -k_i v (stick) or 0 (slide)
///
/// integrated by CVODES (SUNDIALS) with root-finding.  Within a half swing the velocity keeps its sign d, so a sticking
/// slider can only reach the limit -d T0i.  Guards:  T0i + d T_i  for each slider that sticks, v  for the half swing.
/// The limit that a slider starts from at a turning point is not asked for: the half swing can return to it only at
/// rest.  A slip that begins and ends inside one step is not stepped over either, because the root of v lies in it.
///
/// Derivatives: CVODES's forward sensitivities.  At every event x+ = x-, but the field changes from f- to f+, so
///   s+ = s- + (f- - f+) dt*/dp,   dt*/dp = -(g_p + g_x s-) / (g_x f-)     for the guard g(x, p).
class CvodeReference {
 public:
  /// @param sliders      number of sliders of the oscillators to run.
  /// @param derivatives  number of dual quantities, 0 for none.
  CvodeReference(int sliders, int derivatives, const CvodeOptions& options = {});
  ~CvodeReference();
  CvodeReference(const CvodeReference&) = delete;
  CvodeReference& operator=(const CvodeReference&) = delete;

  /// Displacements [m] at the sample times, which start at or after 0, the time of the start state.
  /// @throws std::runtime_error when CVODES fails.
  CvodeCounts Run(const Oscillator<double>& oscillator, const State<double>& start, const SampleTimes& times,
                  std::span<double> y) {
    return RunSeeded(oscillator, start, {}, times, y, {});
  }

  /// The same with derivatives.  @param dy  column after column: dy[p * times.size + i].
  template <int N>
  CvodeCounts Run(const Oscillator<Dual<N>>& oscillator, const State<Dual<N>>& start, const SampleTimes& times,
                  std::span<double> y, std::span<double> dy) {
    std::vector<Seed> seeds;
    for (int p = 0; p < N; ++p) seeds.push_back(Split(oscillator, start, [p](const Dual<N>& x) { return x.v[p]; }));
    const Seed value = Split(oscillator, start, [](const Dual<N>& x) { return x.a; });
    return RunSeeded(value.oscillator, value.start, seeds, times, y, dy);
  }

 private:
  /// Parameters and start state, or their derivatives with respect to one quantity.
  struct Seed {
    Oscillator<double> oscillator;
    State<double> start;
  };
  class Integrator;

  template <int N, typename Part>
  static Seed Split(const Oscillator<Dual<N>>& oscillator, const State<Dual<N>>& start, Part part) {
    Seed seed;
    seed.oscillator.g = oscillator.g;
    seed.oscillator.k = part(oscillator.k);
    seed.start.y = part(start.y);
    seed.start.v = part(start.v);
    for (std::size_t i = 0; i < oscillator.sliders().size(); ++i) {
      seed.oscillator.Add({part(oscillator.sliders()[i].k), part(oscillator.sliders()[i].T0)});
      seed.start.T[i] = part(start.T[i]);
    }
    return seed;
  }

  CvodeCounts RunSeeded(const Oscillator<double>& oscillator, const State<double>& start, std::span<const Seed> seeds,
                        const SampleTimes& times, std::span<double> y, std::span<double> dy);

  std::unique_ptr<Integrator> integrator_;
};

}  // namespace uiclink
