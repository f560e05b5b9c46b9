#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "model/slider.h"

namespace uiclink {

/// Acceleration of gravity that the thesis normalises with (table 2.1) [m/s^2].
inline constexpr double kThesisGravity = 9.82;

enum class Direction { kLateral, kLongitudinal };

/// "lateral" or "longitudinal": the word used in files, messages and JSON.
const char* Name(Direction direction);

/// Covariance of some parameters of one direction; row and column i belong to order[i] ("k", "k1", "T01", ...).
struct Covariance {
  std::vector<std::string> order;
  std::vector<std::vector<double>> matrix;
  /// Half of a 95 % interval in standard deviations: 1.96 where the errors are known, more where they come from few
  /// records (Student: 2.26 for ten, 4.30 for three). None: 1.96.
  std::optional<double> coverage = {};
  /// Standard deviation between links by symbol, in the unit of the parameter, where records do not share their link:
  /// how far one link is from another, which more records do not make smaller. Empty where nothing is known of it.
  std::map<std::string, double> spread = {};
};
inline constexpr double kNormalCoverage = 1.96;  ///< where a covariance has none

/// An effect beside the plain model: identifier of the catalogue and its parameters by symbol.
struct EffectValues {
  std::string id;
  std::vector<std::pair<std::string, double>> parameters;
};

/// The link in one direction, everything divided by the load M g.
struct DirectionParameters {
  double k = 0;                         ///< main (pendulum) stiffness [1/m]
  std::vector<Slider<double>> sliders;  ///< in the order of the file
  std::vector<EffectValues> effects;    ///< only in extended sets
  std::map<std::string, double> std;    ///< standard deviation by symbol ("k", "k1", "T01"), where known
  std::optional<Covariance> covariance;

  double SumOfSliderStiffness() const;  ///< sum k_i [1/m]
  double SumOfSliderForce() const;      ///< sum T0i [-]
};

/// Parameters of a link suspension, as read from and written to `data/parameter_sets/*.toml`.
struct ParameterSet {
  std::string name;
  std::string source;
  double load_N = 0;          ///< M g during the measurement [N]
  double g = kThesisGravity;  ///< the acceleration of gravity that the set was normalised with [m/s^2]
  std::optional<DirectionParameters> lateral;
  std::optional<DirectionParameters> longitudinal;

  const std::optional<DirectionParameters>& operator[](Direction direction) const;
};

/// Symbols of the parameters of `n` sliders in the order used everywhere: k, k1..kn, T01..T0n.
std::vector<std::string> ParameterSymbols(int n);

}  // namespace uiclink
