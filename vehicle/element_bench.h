#pragma once

#include <array>
#include <string>
#include <vector>

#include "model/parameter_set.h"
#include "vehicle/guidance.h"
#include "vehicle/vertical_spring.h"
#include "vehicle/wagon_data.h"

namespace uiclink {

// The test benches of chapters 5, 6 and 8: each element alone, before it goes into the wagon. Every function is
// deterministic and throws std::invalid_argument, with name, value and rule, for options that make no sense.

// --- leaf spring moved harmonically (figure 5.8) ---

struct LeafHarmonicOptions {
  LeafSpring spring;
  double mean = 0;       ///< middle of the movement [m]; the thesis moves it about the unloaded length
  double amplitude = 0;  ///< [m], > 0
  int cycles = 3;        ///< >= 1
  int samples = 400;     ///< for each cycle, >= 4
};

/// s = mean + a sin(phase) from phase 0, F = 0. The force depends on the path alone, not on time, and is the closed
/// form of CalcLeafForce from reversal to reversal.
struct LeafHarmonicRun {
  LeafHarmonicOptions options;
  std::vector<double> phase;  ///< [rad]
  std::vector<double> s;      ///< [m]
  std::vector<double> F;      ///< [N], > 0 in compression
  double loss = 0;            ///< energy lost in the last cycle [J]
  double steady_loss = 0;     ///< in the cycle that repeats itself [J]
  double envelope_loss = 0;   ///< between the envelopes, the limit for beta -> 0:  4 a (F_r + mu0 c mean) [J]
};
LeafHarmonicRun RunLeafHarmonic(const LeafHarmonicOptions& options);

/// Energy that a steady cycle of amplitude a [m] about `mean` [m] loses [J], in closed form.
double CalcLeafLoopLoss(const LeafSpring& spring, double mean, double a);

// --- leaf spring under a falling load (figure 5.9) ---

struct LeafDropOptions {
  LeafSpring spring;
  LinearSpring linear = {};  ///< to compare with
  double m = 0;              ///< load [kg], > 0
  double g = 9.82;           ///< [m/s^2]
  double duration = 2;       ///< [s], > 0
  double step = 1e-3;        ///< between samples [s], > 0
  double rtol = 1e-10;       ///< of the integrator
};

/// m s'' = m g - F from s = 0, s' = 0, F = 0; the linear spring likewise.
struct LeafDropRun {
  LeafDropOptions options;
  std::vector<double> t;         ///< [s]
  std::vector<double> s;         ///< [m]
  std::vector<double> v;         ///< [m/s]
  std::vector<double> F;         ///< [N]
  std::vector<double> s_linear;  ///< [m]
  double rest = 0;               ///< m g / c, the middle of the envelopes under the load [m]
  double largest = 0;            ///< greatest compression among samples and reversals [m]
  double settled_within = 0;     ///< greatest |s - rest| in the last tenth of the run [m]
  double swing = 0;              ///< greatest less least s in the last tenth [m]
  int rest_crossings = 0;        ///< times that s passes `rest`, sample by sample
  int rest_crossings_linear = 0;
  double energy_error = 0;  ///< greatest |m v^2/2 - m g s + W| at a reversal, W the work on the spring, over m g rest
  long reversals = 0;
  long steps = 0;
};
LeafDropRun RunLeafDrop(const LeafDropOptions& options);

// --- parabolic spring moved harmonically (figures 5.10, 5.11) ---

struct ParabolicLoopOptions {
  ParabolicSpring spring;
  double m = 0;          ///< load [kg], > 0
  double g = 9.82;       ///< [m/s^2]
  double mu = 0.13;      ///< friction of the leaves that the damper stands for [-] (section 5.3)
  double frequency = 1;  ///< [Hz], > 0; never stated, table 5.1 gives it away
  int samples = 720;     ///< of the cycle, >= 4
};

/// s = s_static + a sin wt with a half of the static compression; the damper loses what dry friction would.
struct ParabolicLoopRun {
  ParabolicLoopOptions options;
  double static_compression = 0;  ///< [m]
  double amplitude = 0;           ///< [m]
  double friction_work = 0;       ///< 4 a mu m g [J]
  double damping = 0;             ///< 4 mu m g / (pi w a) [N s/m]
  double damping_of_file = 0;     ///< of the spring for this load [N s/m]
  double loop_loss = 0;           ///< area of the loop with `damping`, by quadrature [J]
  double loop_loss_of_file = 0;   ///< pi d w a^2 with the file's damping [J]
  std::vector<double> s;          ///< [m]
  std::vector<double> F;          ///< with `damping` [N]
  std::vector<double> F_static;   ///< [N]
};
ParabolicLoopRun RunParabolicLoop(const ParabolicLoopOptions& options);

// --- wheelset between its guides (figures 6.4, 6.5) ---

/// x, x', y, y', psi, psi' [m, m/s, rad, rad/s].
using GuidanceState = std::array<double, 6>;

struct GuidanceBenchOptions {
  WheelsetBetweenGuides wheelset;
  GuidanceState start = {0, 0.6, 0, 0.3, 0, 0};        ///< section 6.3
  GuidanceState perturbation = {0, 0, 1e-6, 0, 0, 0};  ///< added for the second run
  double duration = 20;                                ///< [s], > 0
  double step = 5e-3;                                  ///< between samples [s], > 0
  double rtol = 1e-12;
};

/// Table 6.1: exaggerated clearances of 0.5 and 0.2 m, the longitudinal stiffness as printed.
WheelsetBetweenGuides Table61();
/// The same with true clearances, 22.5 and 20 mm (figure 6.5).
WheelsetBetweenGuides TrueClearances();

/// One run. Free flight is uniform motion, contacts are springs; both by the integrator with its root finder.
struct GuidanceRun {
  std::vector<GuidanceState> states;  ///< sample by sample
  long impacts_longitudinal = 0;      ///< contacts made
  long impacts_lateral = 0;
  double energy_start = 0;  ///< [J]
  double energy_error = 0;  ///< greatest |E - E_start| / E_start among samples
  long steps = 0;
};
GuidanceRun RunGuidance(const WheelsetBetweenGuides& wheelset, const GuidanceState& start, double duration, double step,
                        double rtol);

struct GuidanceBenchRun {
  GuidanceBenchOptions options;
  std::vector<double> t;  ///< [s]
  GuidanceRun plain;
  GuidanceRun perturbed;
  /// Greatest difference of the two runs up to t, for x [m], y [m], psi [rad].
  std::array<std::vector<double>, 3> largest_difference;
  /// Root mean square of the difference over the last fifth of the run, over that of the plain run's own motion there:
  /// 1.4 for two runs that have nothing to do with each other, 0 for the same.
  std::array<double, 3> relative_difference{};
  /// Rate of growth [1/s] of the difference: slope of log |d| by least squares, |d| scaled by the clearances, from the
  /// start until it passes a tenth of them or the run ends.
  double growth_rate = 0;
  double growth_until = 0;  ///< that time [s]
};
GuidanceBenchRun RunGuidanceBench(const GuidanceBenchOptions& options);

// --- dry-friction element (figures 8.2 to 8.5) ---

struct DryFrictionOptions {
  DirectionParameters element;  ///< per unit load; effects are not allowed
  double g = 9.82;              ///< [m/s^2]
  double pull = 0.045;          ///< pulled out slowly from the true origin to here, then released [m]
  double duration = 15;         ///< [s], > 0
  double step = 2e-3;           ///< between samples [s], > 0
};

struct DryFrictionRun {
  DryFrictionOptions options;
  std::vector<double> t;               ///< [s]
  std::vector<double> y;               ///< [m]
  std::vector<double> v;               ///< [m/s]
  std::vector<std::vector<double>> T;  ///< of each slider, per unit load [-]
  std::vector<double> extremum_t;      ///< turning points [s]
  std::vector<double> extremum_y;      ///< [m]
  double energy_error = 0;             ///< greatest |E + dissipated - E_start| / E_start at the turning points
  bool locked = false;                 ///< no slider slides any more when the run ends
  double amplitude = 0;                ///< of the last swing [m]
  double offset = 0;                   ///< its centre [m]
  double frequency = 0;                ///< of the last arc [Hz]
};

/// Exact, by the event solver of model/.
/// @throws std::invalid_argument, too, where the element has effects or the solver gives up.
DryFrictionRun RunDryFriction(const DryFrictionOptions& options);

}  // namespace uiclink
