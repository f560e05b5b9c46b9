#pragma once

#include <string>

#include "vehicle/simulation.h"

namespace uiclink {

/// "front_lateral=5mm, rear_lateral=-0.002m, body_roll=1mrad": displacements from the running equilibrium.
/// Places: front_lateral, rear_lateral, body_lateral [mm, cm, m]; front_yaw, rear_yaw, body_yaw, body_roll
/// [mrad, rad, deg]. A unit is required.
/// @throws UsageError (vehicle/wagon_inputs.h) that names the part and what was expected.
Perturbation ParsePerturbation(const std::string& text);

}  // namespace uiclink
