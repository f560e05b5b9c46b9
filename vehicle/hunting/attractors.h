#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/lyapunov.h"
#include "dynamics/poincare.h"
#include "vehicle/simulation.h"

namespace uiclink {

/// Where start states are drawn from: displacements from the running equilibrium (Perturb), each uniform between minus
/// and plus its limit, independent of the others, then all of them times one factor, whose logarithm is uniform between
/// that of least_factor and 0: small starts and large ones lead to different motions. Shares of basins are shares of
/// this distribution and of nothing else.
struct StartBox {
  double wheelset_y = 5e-3;    ///< each wheelset by itself [m]; flanges are met at some 6 mm
  double wheelset_psi = 2e-3;  ///< each by itself [rad]
  double body_y = 15e-3;       ///< [m]; the lateral guidance leaves 20 mm
  double body_psi = 3e-3;      ///< [rad]
  double body_phi = 5e-3;      ///< [rad]
  double least_factor = 0.02;  ///< 1: uniform in the box
};

/// Start state number `index` of the box: depends on seed and index alone.
Perturbation DrawStart(const StartBox& box, std::uint64_t seed, std::size_t index);

/// The moment at which a motion passes its middle upwards is a point of its section.
enum class SectionOf { kBodyLateral, kFrontLateral };

/// How a run ended.
enum class RunEnd {
  kSettled,    ///< on what `motion` says
  kUnsettled,  ///< the longest time was over first: settling or too short
  kDerailed,
  kFailed,  ///< the solver gave up
};

/// Where one start state led.
struct RunOutcome {
  Perturbation start;
  RunEnd end = RunEnd::kSettled;
  std::string reason;    ///< kDerailed, kFailed
  double simulated = 0;  ///< [s]
  WagonState state;      ///< at the end
  SectionMotion motion;
  double observed = 0;                            ///< what follows is of the last so many seconds [s]
  std::array<double, kMotionCount> half_width{};  ///< half of peak to peak, by TrackedMotion [m] or [rad]
  std::array<double, kMotionCount> middle{};
  double frequency = 0;                       ///< of returns to the section [Hz]; 0: none
  std::array<GuidanceUse, kAxles> lateral{};  ///< clearance_used and impacts
  std::array<GuidanceUse, kAxles> longitudinal{};
  double minimum_wheel_load = 0;  ///< [N]
  bool wheel_lift = false;
};

struct AttractorOptions {
  std::size_t starts = 32;
  std::uint64_t seed = 1;
  StartBox box = {};
  int threads = 0;  ///< 0: as many as the machine has; results do not depend on it

  double settle = 40;    ///< first so many seconds, not looked at [s]
  double observe = 40;   ///< then looked at [s]; twice as long again, until the section is clear about the motion
  double longest = 600;  ///< end of a run whose motion stays unclear [s]
  /// Half widths below this count as no motion [m]. Friction leaves nothing else to hunt about: the links stick.
  double least_motion = 1e-5;
  SectionOf section_of = SectionOf::kBodyLateral;
  SectionOptions section = {};

  /// Two motions are the same when each half width agrees within this share of the larger one and
  /// `same_motion`; for modulated and irregular motions, whose extremes depend on when one looks, three times that.
  double same_share = 0.05;
  double same_motion = 5e-5;     ///< [m] or [rad]
  double same_frequency = 0.01;  ///< share of the frequency of returns

  /// Largest Lyapunov exponent of modulated and irregular attractors, over so many intervals; 0 intervals: none.
  LyapunovOptions lyapunov{.interval = 1, .intervals = 400, .discarded = 50};
  IntegratorOptions integrator = {};
  /// Told about every run that ends; called on one thread, in no order.
  std::function<void(std::size_t done, std::size_t in_all)> on_progress = {};
  /// Runs of an earlier survey with the same options, by number: they are not made again.
  std::map<std::size_t, RunOutcome> known = {};
  /// Told about every run that was made, with its number, to be kept; one call at a time, on any thread. False ends the
  /// survey (AttractorSurvey::stopped); runs under way are finished. May be null.
  std::function<bool(std::size_t number, const RunOutcome& run)> on_run = {};
};

/// Runs from a start state until the section says what kind of motion it is.
RunOutcome RunToAttractor(Integrator& integrator, double V, const WagonState& start, const AttractorOptions& options);

/// A motion that start states led to.
struct Attractor {
  std::vector<std::size_t> runs;           ///< numbers of the start states, rising
  double share = 0;                        ///< of all start states
  double low = 0, high = 0;                ///< 95 % bounds of the share (Wilson)
  std::size_t representative = 0;          ///< number of the run nearest to the median half widths
  RunOutcome typical;                      ///< that run: kind, periods, amplitudes, impacts, a state to go on from
  bool mirrored = false;                   ///< met in both mirror images (middles of opposite sign)
  std::optional<LyapunovResult> lyapunov;  ///< of modulated and irregular ones
  std::string lyapunov_failure;            ///< why there is none although it was wanted
};

struct AttractorSurvey {
  double V = 0;
  std::vector<Attractor> attractors;  ///< by falling share; runs that have not settled are attractors with that mark
  std::vector<RunOutcome> runs;       ///< by number of the start state
  std::size_t derailed = 0, failed = 0, unsettled = 0;
  bool stopped = false;  ///< on_run said so: nothing else is set
  double wall_s = 0;
};

/// Motions along the track: not asked whether two motions are the same, nor whether one has settled. Beside what
/// hunting makes there is the free vibration of the wagon on its links, which a start leaves behind and nothing but
/// creep damps (0.05 to 0.14/s), for minutes.
constexpr bool IsLongitudinal(std::size_t motion) {
  return motion == static_cast<std::size_t>(TrackedMotion::kFrontLongitudinal) ||
         motion == static_cast<std::size_t>(TrackedMotion::kRearLongitudinal);
}

/// The attractors of a wagon at one speed that start states of the box lead to.
///
/// Motions are told apart by kind and returns, half widths (not IsLongitudinal) and frequency of returns; mirror images
/// (left for right) are one attractor, and so are equilibria and cycles that differ only in where friction has left
/// their middle.
/// @throws what FindEquilibrium throws; std::invalid_argument for options out of range.
AttractorSurvey FindAttractors(const Wagon& wagon, double V, const AttractorOptions& options = {});

/// The same from given start states (traced hunting, shipped states); options.starts and the box are not looked at.
AttractorSurvey FindAttractors(const Wagon& wagon, double V, const std::vector<WagonState>& starts,
                               const AttractorOptions& options);

/// 95 % bounds of a share by Wilson's score interval.
struct ShareBounds {
  double low = 0, high = 1;
};
ShareBounds CalcShareBounds(std::size_t count, std::size_t of);

}  // namespace uiclink
