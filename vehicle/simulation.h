#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "vehicle/integrator.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {

struct SimulationOptions {
  double duration = 60;        ///< [s] from the start state's time
  double output_hz = 0;        ///< samples per second in the result, at start.t + i / output_hz; 0: none
  bool output_forces = false;  ///< forces beside every sample
  double window =
      10;  ///< amplitudes, frequencies and figures "in the window" are of the last so many seconds that were run
  bool end_at_wheel_lift = true;  ///< or go on with a wheel in the air (N = 0)
  IntegratorOptions integrator;

  /// At multiples of this time [s] a run is started anew from its state alone, so that a run that is resumed there goes
  /// on bit by bit as the one that was not interrupted.  Absolute times; > 0.
  double checkpoint_interval = 1;
  /// Called at these times and at the end (or null).
  std::function<void(const WagonState&)> on_checkpoint;
  /// Called about ten times per second of wall time with the time that has been simulated, from start to end, or null.
  /// Returns false to stop the run.
  std::function<bool(double t)> on_progress;
};

/// Guidance impacts of one wheelset in one direction.
struct Impacts {
  int count = 0;      ///< contacts that began
  double peak_N = 0;  ///< largest force: lateral of both boxes of the wheelset together, longitudinal of one box
};

/// One wheelset in one direction against its guidance.
struct GuidanceUse {
  double clearance_used = 0;  ///< largest |displacement| of an axle box relative to the body [m]
  Impacts impacts;
  double clearance_used_in_window = 0;  ///< [m]
  Impacts impacts_in_window;
};

enum class SimulationEnd {
  kDuration,   ///< ran to the end
  kWheelLift,  ///< a wheel left its rail
  kDerailed,   ///< a wheelset left the track
  kStopped,    ///< on_progress said so
  kFailed,     ///< could not begin, or the solver gave up: of SimulateSideBySide alone, Simulate() throws
};

/// What moves, for amplitudes and frequencies.
enum class TrackedMotion {
  kFrontLateral,
  kRearLateral,
  kBodyLateral,
  kFrontLongitudinal,
  kRearLongitudinal,
  kBodyYaw,
  kBodyRoll
};
inline constexpr std::size_t kMotionCount = 7;
/// "front_lateral", ..., "body_roll": the keys of "wagon-simulate/1".
extern const std::array<const char*, kMotionCount> kMotionNames;
/// Place of a motion in the state vector.
extern const std::array<std::size_t, kMotionCount> kMotionIndex;

struct MotionFigures {
  double amplitude = 0;  ///< half of peak to peak in the window [m] or [rad]
  double mean = 0;       ///< middle between the peaks [m] or [rad]
  /// Peaks of the amplitude spectrum in the window (Hann window, refined between the lines of the transform) [Hz], by
  /// falling height, those above 2 % of the highest; at most four. Empty where nothing moves.
  std::vector<double> frequencies;
  std::vector<double> frequency_amplitudes;  ///< of these peaks [m] or [rad]
};

struct SimulationSample {
  double t = 0;
  StateVector<double> x{};
};

struct SimulationResult {
  SimulationEnd end = SimulationEnd::kDuration;
  std::string end_reason;  ///< "the front left wheel lifted at 3.21 s", empty for kDuration
  WagonState state;        ///< where the run ended, to go on from
  double V = 0;            ///< [m/s]
  double simulated = 0;    ///< [s]

  std::array<MotionFigures, kMotionCount> motions;  ///< by TrackedMotion
  std::array<GuidanceUse, kAxles> lateral;          ///< by Axle
  std::array<GuidanceUse, kAxles> longitudinal;
  double minimum_wheel_load = 0;  ///< smallest Q at the ends of all steps [N]
  std::size_t minimum_wheel_corner = 0;
  bool wheel_lift = false;  ///< a wheel was in the air at some time
  bool derailed = false;

  std::vector<SimulationSample> samples;
  std::vector<WagonForces> forces;  ///< beside the samples, if wanted

  double wall_s = 0;
  IntegratorCounts counts;
};

/// Runs a wagon at speed V from a start state (FindEquilibrium, Perturb, ReadStateFile).
/// The run does not depend on the output rate.
/// @throws std::invalid_argument for options out of range; std::runtime_error if the solver gives up.
SimulationResult Simulate(const Wagon& wagon, double V, const WagonState& start, const SimulationOptions& options = {});

/// The same on an integrator that exists already (sweeps: its memory is used again); options.integrator is not looked
/// at.
SimulationResult Simulate(Integrator& integrator, double V, const WagonState& start, const SimulationOptions& options);

/// A start state beside another one: both wheelsets (front by y, rear by y_rear) and body displaced laterally; the
/// vertical position and roll of the wheelsets follow their contact, joints stay relaxed where they were, so that the
/// links pull back with all their springs, and slide where that is beyond their bounds.
struct Perturbation {
  double front_y = 0;    ///< [m]
  double rear_y = 0;     ///< [m]
  double body_y = 0;     ///< [m]
  double body_phi = 0;   ///< [rad]
  double body_psi = 0;   ///< [rad]
  double front_psi = 0;  ///< [rad]
  double rear_psi = 0;   ///< [rad]
};
WagonState Perturb(const Wagon& wagon, const WagonState& state, const Perturbation& by);

}  // namespace uiclink
