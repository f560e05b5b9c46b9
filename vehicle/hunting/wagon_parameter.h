#pragma once

#include <functional>
#include <string>
#include <vector>

#include "vehicle/hunting/wagon_flow.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {

/// A number of the wagon that hunting can be followed in, at a fixed speed.
///
/// Names are those of the other commands: of a set's numbers as in its covariance, with the direction before them
/// ("lateral.k", "longitudinal.T01", "lateral.rolling_friction.T_r"), before that the corners if not all
/// ("front-left.lateral.k", as --set has them); the others as in a campaign of `wagon sweep` ("friction",
/// "lateral_clearance_mm"). A set's numbers are per weight on the corner.
struct WagonParameter {
  std::string name;
  std::string unit;  ///< of its values everywhere: 1/m, -, mm, N/m, kg, ...
  double value = 0;  ///< as the inputs have it
  double low = 0;    ///< values lie strictly between these, where the wagon is one of the same kind
  double high = 0;
  std::function<void(double value, WagonInputs* inputs)> set;  ///< of data, body, links and options, nothing else
};

/// All of a wagon, those of single corners apart.
std::vector<WagonParameter> ListWagonParameters(const WagonInputs& inputs);

/// @throws UsageError for a name that is none, with those that there are; for one that is of the contact's geometry:
/// the way from a gauge to the motion goes through the contact table, which is computed anew for each, and has no
/// derivative by it; for corners whose links differ in it.
WagonParameter FindWagonParameter(const WagonInputs& inputs, const std::string& name);

/// Wagons by a parameter, at a speed. The contact is made once.
/// @param low, high  values that will be asked for: what steps of differences follow from.
/// @throws UsageError unless parameter.low < low < high < parameter.high.
WagonFamily FamilyByParameter(const WagonInputs& inputs, const WagonParameter& parameter, double speed, double low,
                              double high);

}  // namespace uiclink
