#pragma once

#include "vehicle/wagon.h"

namespace uiclink {

/// How well an equilibrium was found.
struct EquilibriumStats {
  int iterations = 0;   ///< of Newton's method
  double residual = 0;  ///< largest acceleration that is left, of a wheelset or the body [m/s^2, rad/s^2]
};

/// The running equilibrium at speed V: every rate zero, all joints relaxed where the links stand.
///
/// Unknown are x, y, z, phi, psi, beta of both wheelsets and y, z, phi, psi of the body; beta is not zero, because the
/// rolling radius at rest is not r0, and an uneven freight shifts, rolls and yaws.  Newton's method with the exact
/// Jacobian (CalcRate with dual numbers), from the contact at the height of the static load.
/// Leaf springs carry what the balance asks for at the compression Wagon::Corner::s_eq, on average over the corners:
/// the force is a state of its own, and every force between the envelopes would be an equilibrium.
///
/// @param V  [m/s], > 0.
/// @throws std::invalid_argument unless V > 0 and finite; std::runtime_error with the residual if Newton's method does
/// not converge, a wheel carries nothing or a wheelset leaves its contact table.
WagonState FindEquilibrium(const Wagon& wagon, double V, EquilibriumStats* stats = nullptr);

}  // namespace uiclink
