#include "vehicle/wagon_state.h"

namespace uiclink {

const std::array<const char*, kMaxState> kStateNames{
    "front_x",         "front_x_rate",     "front_y",        "front_y_rate",   "front_z",        "front_z_rate",
    "front_phi",       "front_phi_rate",   "front_beta",     "front_psi",      "front_psi_rate", "rear_x",
    "rear_x_rate",     "rear_y",           "rear_y_rate",    "rear_z",         "rear_z_rate",    "rear_phi",
    "rear_phi_rate",   "rear_beta",        "rear_psi",       "rear_psi_rate",  "body_y",         "body_y_rate",
    "body_z",          "body_z_rate",      "body_phi",       "body_phi_rate",  "body_psi",       "body_psi_rate",
    "front_left_leaf", "front_right_leaf", "rear_left_leaf", "rear_right_leaf"};

const std::array<const char*, kMaxState> kStateUnits{
    "m",   "m/s", "m",   "m/s",   "m",   "m/s",   "rad",   "rad/s", "rad/s", "rad",   "rad/s", "m",
    "m/s", "m",   "m/s", "m",     "m/s", "rad",   "rad/s", "rad/s", "rad",   "rad/s", "m",     "m/s",
    "m",   "m/s", "rad", "rad/s", "rad", "rad/s", "N",     "N",     "N",     "N"};

}  // namespace uiclink
