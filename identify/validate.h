#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "identify/cause_cost.h"
#include "model/parameter_set.h"

namespace uiclink {

/// A parameter set that is to prove itself on the wagon.
struct ValidationSet {
  std::string role;   ///< "identified", "identified_plain", "set1", "given", ...: for programs
  std::string label;  ///< in tables; empty: the name of the set
  std::string file;   ///< where it was written, or read from
  std::string sha256;
  ParameterSet set;
  std::array<std::optional<RecordValues>, 2> by_record = {};  ///< by Direction, where its records are at hand
  std::string doubt = {};  ///< why its values are not to be trusted as they stand; empty when they are
};

struct ValidateOptions {
  std::string cargo = "empty";            ///< a name or a file (data/data_path.h)
  std::string geometry = "nominal-1435";  ///< the same
  /// Of the hunting run [m/s], > 0. At 12 m/s the empty wagon on nominal-1435 hunts on sets 1 and 2 and on either's
  /// lateral with the other's longitudinal direction, by 0.5 to 0.7 mm and in the same way from every start that was
  /// tried and lifts no wheel at once. At 10 m/s that depends on the start, from 20 m/s on 0.1 mm and less is left. On
  /// thesis-equivalent 30 m/s does the same: set 2 is stable below 28 m/s there.
  double speed = 12;
  /// From each set with a covariance, for the uncertainty of its hunting; 0: none. Of sets of one run only where there
  /// is a plain one to tell from the extended one.
  int hunting_draws = 16;
  /// The sets stand for themselves: sets 1 and 2 are no rows unless given, the types of the critical speeds are found,
  /// and each set is told against the first.
  bool side_by_side = false;
  int threads = 0;                                                               ///< 0: as many as the machine has
  std::function<void(const std::string& what, int done, int of)> progress = {};  ///< on the calling thread only
};

/// A file that the result stands on.
struct ValidationFile {
  std::string role;  ///< "wagon", "cargo", "geometry", "wheel_profile", "rail_profile", "set"
  std::string name;  ///< what the file calls itself
  std::string file;
  std::string sha256;
};

/// dV/dp of the linear critical speed by one parameter.
struct SpeedSensitivity {
  Direction direction = Direction::kLateral;
  std::string symbol;     ///< as in the covariance: "k", "T01", "rolling_friction.T_r"
  double derivative = 0;  ///< [m/s per unit of the parameter]
};

/// Share of the variance of the linear critical speed that a group of parameters makes (hunting/variance_shares.h).
struct SpeedShare {
  std::string group;  ///< "lateral k + sum k_i", "lateral T0", "lateral rolling_friction"
  double share = 0;   ///< [-]; all add up to 1
};

/// The speed at which straight running becomes unstable (vehicle/stability.h).
struct CriticalSpeed {
  std::optional<double> value;  ///< [m/s]; none: stable up to searched_to, or not stable at the lowest speed
  double frequency_hz = 0;
  std::string type = {};  ///< "supercritical", "subcritical" (hunting/hopf.h); empty: not asked for, or not found
  std::string type_reason = {};  ///< why it was not found
  double searched_to = 0;        ///< [m/s]
  bool unstable_from_start = false;
  /// 95 % bounds [m/s]: the covariance of the measured directions carried over to first order,
  ///   half = sqrt(sum over directions of (c s)^2),  s^2 = g' C g,  g = dV/dp,  c = Covariance::coverage.
  /// They hold the uncertainty of the link's parameters alone, not that of wagon, wheels or rails. None without a
  /// covariance, or where the speed cannot be followed through the change of a parameter (a failure of the row).
  std::optional<double> low, high;
  std::vector<SpeedSensitivity> sensitivities;  ///< empty without a covariance
  std::vector<SpeedShare> shares;               ///< the same; empty where nothing varies
};

/// One run at ValidateOptions::speed from kHuntingStart; everything is of its last kHuntingWindow seconds, what the
/// start stirs up apart from that. A run that ends before (wheel lift, derailment) is told as a whole.
struct HuntingRun {
  std::array<double, 2> wheelset_amplitude{};  ///< lateral, front and rear: half of peak to peak [m]
  double body_amplitude = 0;                   ///< lateral [m]
  std::optional<double> frequency_hz;          ///< of the front wheelset; none where it does not hunt
  std::array<int, 2> impacts{};                ///< lateral, on the guidance of front and rear wheelset
  int longitudinal_impacts = 0;                ///< of both wheelsets
  double peak_impact = 0;                      ///< largest lateral force of the guidance of a wheelset [N]
  double minimum_wheel_load = 0;               ///< [N]
  bool wheel_lift = false;
  bool derailed = false;
  double simulated = 0;    ///< [s]
  std::string end_reason;  ///< why the run ended before its time; empty if it did not
};
inline constexpr double kHuntingStart = 5e-3;   ///< both wheelsets beside the running equilibrium, to the left [m]
inline constexpr double kHuntingDuration = 30;  ///< [s]
inline constexpr double kHuntingWindow = 10;    ///< [s]

/// Uncertainty of a scalar of the hunting run, from draws.
struct HuntingBound {
  std::string name;  ///< HuntingScalars(): "front lateral amplitude", ...
  std::string unit;
  double value = 0;  ///< of the set itself, run on as the draws are
  double half = 0;   ///< of the 95 % interval: 1.96 standard deviations of the draws
};

/// What a set does on the wagon.
struct ValidationRow {
  ValidationSet set;
  std::optional<CriticalSpeed> critical_speed;
  std::optional<HuntingRun> hunting;
  std::vector<HuntingBound> hunting_bounds = {};  ///< empty where nothing is uncertain, or was asked for
  std::vector<std::string> notices;               ///< directions from set 1, effects that a wagon has no place for
  std::vector<std::string> failures;              ///< why one of the two is missing
};

/// Sets side by side on the wagon.
struct Validation {
  ValidateOptions options;
  std::string wagon;  ///< its name
  std::string cargo;  ///< the same; what was asked for is in options
  std::string geometry;
  std::vector<ValidationFile> files;
  std::vector<ValidationRow> rows;  ///< the sets given, then set 1 and set 2 (ValidateOptions::side_by_side)
  /// Where the sets of the extended ("identified") and the plain model ("identified_plain") are both given.
  std::vector<CauseCost> cause_cost;
  std::vector<std::string> notices;  ///< about the freight
  std::string failure;               ///< why nothing could be done at all; rows are empty then
  double wall_s = 0;

  bool Complete() const;  ///< nothing failed
};

/// Runs sets on the wagon, identified ones beside sets 1 and 2: linear critical speed with bounds, and one hunting run.
///
/// A direction that a set lacks comes from set 1, as it stands there, with a notice. Effects without a place on a wagon
/// are left out, with a notice. Derivatives of the critical speed are those of hunting/speed_bounds.h.
/// Never throws: missing data files, sets that the wagon cannot run and solvers that give up are failures in the
/// result. The result does not depend on the number of threads.
Validation ValidateOnWagon(const std::vector<ValidationSet>& sets, const ValidateOptions& options = {});

}  // namespace uiclink
