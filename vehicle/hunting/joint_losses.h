#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "vehicle/integrator.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// What one link has taken from the motion [J].
struct LinkLosses {
  std::vector<double> sliders;  ///< by slider of the link (Link::sliders): |T| x way of slip
  double viscous = 0;           ///< damping of an extended set: Q c v^2
  /// Further forces of an extended set: the part that changes sign with v (drag). What does not (cubic stiffness) gives
  /// back what it takes and is in EnergyLosses::reversible.
  double drag = 0;

  double Sum() const;
};

/// Where the energy of a run goes between two moments [J]; losses > 0.
///
///   drive + contact + rotations + reversible = Lost() + stored_change + Residual()
struct EnergyLosses {
  double t0 = 0, t1 = 0;  ///< [s]
  std::array<LinkLosses, kCorners> longitudinal, lateral;
  /// Vertical springs: parabolic or linear damping, friction of a leaf spring (its work beside the mean line c s, so
  /// that over less than a cycle it may be negative).
  std::array<double, kCorners> springs{};
  /// Creep -V (F_x xi_x + F_y xi_y) by wheel. F_y has a part that the lateral creepage makes and one that spin makes:
  /// creep_spin is the work of the latter along xi_y, of either sign. The law has no spin moment, so that spin takes
  /// nothing by itself (contact/contact_curve.h).
  std::array<double, kCorners> creep_longitudinal{}, creep_lateral{}, creep_spin{};
  double drive = 0;          ///< what keeps V constant: -V times the sum of the longitudinal wheel forces
  double stored_change = 0;  ///< of kinetic energy, height, springs, joints, stops
  /// Wheels pressed into rails, and contact frames turned against the track. Over a cycle it is N V psi sin(delta): the
  /// equations turn the normal force with the yaw psi, and the drive works against the part lengthwise.
  double contact = 0;
  double rotations = 0;   ///< work of the rotations of first order (wagon_energy.h)
  double reversible = 0;  ///< see LinkLosses::drag

  double LostInLinks() const;
  double LostInSprings() const;
  double LostInCreep() const;
  double Lost() const { return LostInLinks() + LostInSprings() + LostInCreep(); }
  /// Of the balance above: the error of the run and of its quadrature.
  double Residual() const { return drive + contact + rotations + reversible - Lost() - stored_change; }
};

/// One place where energy goes.
struct LossPart {
  std::string where;       ///< "lateral", "longitudinal" (links), "vertical" (springs), "wheel"
  std::string what;        ///< "slider_1", "rolling_friction", "micro_slip", "viscous", "drag"; "damping" or
                           ///< "leaf_friction"; "creep_longitudinal", "creep_lateral", "creep_spin"
  std::size_t corner = 0;  ///< or wheel
  double lost = 0;         ///< [J]
};
/// All parts, the corners of one kind after each other: lateral links first. Sliders of micro-slip are one part.
/// "viscous", "drag", "rolling_friction" and "micro_slip" are there where a link has them.
std::vector<LossPart> ListLosses(const Wagon& wagon, const EnergyLosses& losses);

/// Measures the losses of a run on the integrator's own steps.
///
/// A joint that slides with a constant force loses |T| times the way of its slip, exactly; where a limit depends on
/// speed the loss is the joint's work less what its spring stores; where a joint breaks out from a static peak its
/// spring loses what the force falls by. Powers are integrated by Simpson's rule, the middle from the interpolant, as
/// good as a step of order 4.
///
///   LossMeter meter(wagon, V);
///   meter.Begin(integrator.state());              // after Integrator::Start
///   while (...) { integrator.Step(end); meter.Add(integrator); }
///   meter.Result()
class LossMeter {
 public:
  /// @param wagon  must outlive the meter.
  LossMeter(const Wagon& wagon, double V);

  /// @param state  where the run starts, in the mode that it starts in.
  void Begin(const WagonState& state);
  void Add(const Integrator& integrator);
  /// From Begin() to the last Add().
  EnergyLosses Result() const;

 private:
  /// A place within a step: its start, its middle or its end.
  struct Moment;
  Moment Look(const LinkStates& mode, const StateVector<double>& x) const;
  void AddPowers(const Moment& moment, double weight);
  void AddLink(const Link& link, const LinkState& mode, const LinkState& after, const std::array<double, 3>& d,
               const std::array<double, 3>& v, double h, LinkLosses* losses);

  const Wagon& wagon_;
  double V_;
  WagonState last_;
  double energy_begin_ = 0;
  EnergyLosses sum_;
};

/// The losses of a run from `start` on, until its duration [s] is over or a wheelset leaves the track.
/// The energy that a run makes or loses by its own errors grows with its tolerance, and looks like a loss: set 1 empty
/// at 24 m/s has 0.9 % of the losses at 1e-6 and 0.006 % at 1e-8 (IntegratorOptions::tolerance).
/// @throws what Integrator throws.
EnergyLosses MeasureLosses(const Wagon& wagon, double V, const WagonState& start, double duration,
                           const IntegratorOptions& options);

}  // namespace uiclink
