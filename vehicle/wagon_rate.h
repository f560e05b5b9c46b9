#pragma once

#include <array>
#include <cstddef>

#include "model/scalar.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// What acts at the wheels and corners, for output and tests. Forces on the wheelset [N]; corner order.
struct WagonForces {
  struct Wheel {
    double q = 0;    ///< approach [m]; <= 0: the wheel has lifted
    double N = 0;    ///< normal force
    double F_x = 0;  ///< creep forces in the contact frame
    double F_y = 0;
    double xi_x = 0;  ///< creepages [-], [-], [1/m]
    double xi_y = 0;
    double xi_s = 0;
    double Q = 0;     ///< vertical force on the wheelset, track frame: the wheel load
    double Y = 0;     ///< lateral force on the wheelset, track frame
    double X = 0;     ///< longitudinal force on the wheelset, track frame
    double roll = 0;  ///< moments about the wheelset's centre, wheelset frame [N m]
    double pitch = 0;
    double yaw = 0;
  };
  std::array<Wheel, kCorners> wheels{};
  std::array<double, kCorners> link_x{}, link_y{};    ///< links
  std::array<double, kCorners> spring{};              ///< F > 0 in compression: on the body upwards
  std::array<double, kCorners> guide_x{}, guide_y{};  ///< guidance
};

/// Of each wheel what its run watches: WagonForces::Wheel::Q [N] and q [m].
struct WheelLoads {
  std::array<double, kCorners> Q{}, q{};
};
inline WheelLoads LoadsOf(const WagonForces& forces) {
  WheelLoads loads;
  for (std::size_t i = 0; i < kCorners; ++i) {
    loads.Q[i] = forces.wheels[i].Q;
    loads.q[i] = forces.wheels[i].q;
  }
  return loads;
}

/// The rate of the state at speed V: equations (2.1) to (2.12) as corrected (NOTATION.md), sum of
///   wheel-rail contact (contact/contact_curve.h; creep by Shen, Hedrick and Elkins, (3.1) to (3.3)), links, springs,
///   guidance and weight.  The joints of the links are in the mode that `links` says.
/// T is double or Dual<kMaxState>.
/// @param V  speed of the wagon [m/s], > 0.
template <typename T>
void CalcRate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<T>& x, StateVector<T>* rate);

/// The same, and the forces behind it.
void CalcForces(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x,
                StateVector<double>* rate, WagonForces* forces);

}  // namespace uiclink
