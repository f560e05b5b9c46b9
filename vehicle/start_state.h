#pragma once

#include <string>

#include "vehicle/simulation.h"

namespace uiclink {

/// "front_lateral=5mm, rear_lateral=-0.002m, body_roll=1mrad": displacements from the running equilibrium.
/// Places: front_lateral, rear_lateral, body_lateral [mm, cm, m]; front_yaw, rear_yaw, body_yaw, body_roll
/// [mrad, rad, deg]. A unit is required.
/// @throws UsageError (vehicle/wagon_inputs.h) that names the part and what was expected.
Perturbation ParsePerturbation(const std::string& text);

/// Where a run starts, and what to call it.
struct RunStart {
  WagonState state;
  std::string words;
};

/// What --start says: "equilibrium", a state file (its time counts from 0), or displacements from the equilibrium.
/// @param V  speed [m/s].
/// @throws UsageError, InputError for what cannot be read, a state of another wagon, wheelsets beyond the contact
/// table;
///         what FindEquilibrium throws.
RunStart MakeRunStart(const std::string& text, const Wagon& wagon, double V);

/// The same errors for displacements that cannot be read, before anything is computed.
void CheckRunStart(const std::string& text);

}  // namespace uiclink
