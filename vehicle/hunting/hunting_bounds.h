#pragma once

#include <optional>
#include <vector>

#include "vehicle/hunting/propagation.h"
#include "vehicle/simulation.h"

namespace uiclink {

/// The same motion on a wagon with other links: places and speeds stay; every joint keeps its force relative to its
/// limit, so that one that slides goes on sliding.
WagonState CarryOver(const Wagon& from, const WagonState& state, const Wagon& to);

/// What is asked of a run, in this order: amplitudes of front and rear wheelset and body, lateral [mm]; frequency of
/// the front wheelset [Hz]; used lateral clearance of front and rear [mm]; lateral impacts of both wheelsets and their
/// peak [kN]; longitudinal impacts; least wheel load [kN]. All of the last SimulationOptions::window seconds but the
/// last one.
const std::vector<Asked>& HuntingScalars();
std::vector<double> HuntingScalarsOf(const SimulationResult& result);

/// Smaller amplitudes of a wheelset are no hunting, and have no frequency [m].
inline constexpr double kHuntingLeast = 5e-5;

/// Runs each draw from the state `start` of the nominal wagon, carried over: a settled hunting state asks for less time
/// than a push. A run that ends before its time (wheel lift, derailment) is a draw without values, with that reason.
/// @param V  [m/s]
std::vector<ScalarBounds> CalcHuntingBounds(const SetScatter& scatter, const Wagon& wagon, double V,
                                            const WagonState& start, const SimulationOptions& simulation,
                                            const PropagateOptions& options = {});

}  // namespace uiclink
