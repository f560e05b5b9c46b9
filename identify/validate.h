#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "model/parameter_set.h"

namespace uiclink {

/// A parameter set that is to prove itself on the wagon.
struct ValidationSet {
  std::string role;  ///< "identified", "identified_plain", "set1", ...: for programs
  std::string file;  ///< where it was written, or read from
  std::string sha256;
  ParameterSet set;
  /// Half of the 95 % interval in standard deviations, by Direction: 1.96 where a fit knows its errors, more where they
  /// are means over few records (Student).
  std::array<double, 2> coverage{1.96, 1.96};
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

/// The speed at which straight running becomes unstable (vehicle/stability.h).
struct CriticalSpeed {
  std::optional<double> value;  ///< [m/s]; none: stable up to searched_to, or not stable at the lowest speed
  double frequency_hz = 0;
  double searched_to = 0;  ///< [m/s]
  bool unstable_from_start = false;
  /// 95 % bounds [m/s]: the covariance of the measured directions carried over to first order,
  ///   half = sqrt(sum over directions of (c s)^2),  s^2 = g' C g,  g = dV/dp,  c = ValidationSet::coverage.
  /// They hold the uncertainty of the link's parameters alone, not that of wagon, wheels or rails. None without a
  /// covariance, or where the speed cannot be followed through the change of a parameter (a failure of the row).
  std::optional<double> low, high;
  std::vector<SpeedSensitivity> sensitivities;  ///< empty without a covariance
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
inline constexpr double kHuntingLeast = 5e-5;   ///< smaller amplitudes of a wheelset are no hunting [m]

/// What a set does on the wagon.
struct ValidationRow {
  ValidationSet set;
  std::optional<CriticalSpeed> critical_speed;
  std::optional<HuntingRun> hunting;
  std::vector<std::string> notices;   ///< directions from set 1, effects that a wagon has no place for
  std::vector<std::string> failures;  ///< why one of the two is missing
};

/// Sets side by side on the wagon.
struct Validation {
  ValidateOptions options;
  std::string wagon;  ///< its name
  std::string cargo;  ///< the same; what was asked for is in options
  std::string geometry;
  std::vector<ValidationFile> files;
  std::vector<ValidationRow> rows;   ///< the sets given, then set 1 and set 2
  std::vector<std::string> notices;  ///< about the freight
  std::string failure;               ///< why nothing could be done at all; rows are empty then
  double wall_s = 0;

  bool Complete() const;  ///< nothing failed
};

/// Runs identified sets on the wagon beside sets 1 and 2: linear critical speed with bounds, and one hunting run.
///
/// A direction that a set lacks comes from set 1, as it stands there, with a notice. Effects without a place on a wagon
/// are left out, with a notice. Derivatives of the critical speed are central differences with steps of a thousandth of
/// the parameter.
/// Never throws: missing data files, sets that the wagon cannot run and solvers that give up are failures in the
/// result. The result does not depend on the number of threads.
Validation ValidateOnWagon(const std::vector<ValidationSet>& sets, const ValidateOptions& options = {});

}  // namespace uiclink
