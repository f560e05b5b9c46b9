#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "vehicle/moving_wagon.h"
#include "vehicle/wagon.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {

struct IntegratorOptions {
  /// Error of a step, relative to the scales of the motions (CalcErrorScales), root mean square over the state vector
  /// [-]. 1e-6 keeps hunting with impacts right to some 1e-6 of its amplitude over ten seconds.
  double tolerance = 1e-6;
  /// An explicit Runge-Kutta pair: a name of ARKODE ("ARKODE_ZONNEVELD_5_3_4") or of ours (runge_kutta.h); empty:
  /// kDefaultMethod.
  std::string method;
  double max_step = 5e-3;  ///< [s]; steps are never longer than the method is stable either
};

/// What a run has cost.
struct IntegratorCounts {
  long steps = 0;
  long rhs_calls = 0;
  long failed_steps = 0;  ///< repeated because of their error
  long events = 0;        ///< joints that changed over, guidance, spring stages
};
inline IntegratorCounts operator-(const IntegratorCounts& a, const IntegratorCounts& b) {
  return {.steps = a.steps - b.steps,
          .rhs_calls = a.rhs_calls - b.rhs_calls,
          .failed_steps = a.failed_steps - b.failed_steps,
          .events = a.events - b.events};
}

/// Why Advance returned.
enum class Advance : std::uint8_t {
  kStep,      ///< a step
  kEvent,     ///< a step up to an event, which has been passed
  kStopTime,  ///< the stop time
  kDerailed,  ///< a wheelset has left its track: IsDerailed; the state is the last one on it
};

/// Largest lateral displacement at which both wheels are on their rails [m]: the end of the contact table, or where the
/// contact angle of a flange has passed its maximum, so that nothing holds the wheel back any more.
double FindTrackLimit(const ContactCurve& contact);

/// Moves a wagon: SUNDIALS (ARKODE, explicit Runge-Kutta with root finding) between events.
///
/// Method, by measurement (4 s of hunting with impacts, set 1 empty at 20 m/s on smooth profiles, right-hand sides and
/// largest error of the lateral motions, of the amplitude):
///   ours, 7 stages, order 4, stable to -8.0 and 3.6 i    18 200 at 3e-6, 30 100 at 2e-7
///   ours, 8 stages, order 4, stable to -12.8 and 2.6 i   23 400 at 7e-7
///   classical order 4, first same as last                25 400 at 1e-6
///   Bogacki-Shampine 3(2)    15 900 at 1.3e-6, 24 000 at 3e-7        Zonneveld 4(3)   22 800 at 1e-6
///   Dormand-Prince 5(4)      26 400 at 2e-6, 35 500 at 4e-7
/// without flange contact, where stability alone limits the step: 2 700 a second against 3 700 (Bogacki-Shampine) and
/// 4 500 (classical). On S1002 and UIC60, 3 s from three moments of the hunting, right-hand sides a second:
///   rigid contact, which jumps   ours 26 400 at 7e-7, Zonneveld 26 000 at 5e-7, Bogacki-Shampine 34 000 at 8e-7
///   elastic contact              ours 9 400 at 4e-6 (12 600 at 2e-7), Zonneveld 7 700 at 4e-7
/// so that Zonneveld's pair is the faster choice there (tests/bench), and taken; ours is by 1.7 to 2.3 times where no
/// flange is touched.
///
/// Events: a joint starts to slide or sticks (link.h), an axle box meets or leaves its guidance, a parabolic spring
/// changes its stage, a leaf spring reverses, a wheelset leaves the track. At an event the state is set to it exactly
/// and goes on; the right-hand side is continuous there, so that the step size is kept. Forces of joints follow from
/// the mode (Link), so that a joint that slides is exactly on its bound.
/// Events of leaf springs change little: 4 s of hunting take 65 100 right-hand sides with them and 64 800 without on
/// smooth profiles, 83 900 and 83 950 on S1002 and UIC60, at the same errors (1e-8 and 3e-9 m).
///
/// Memory is taken by the constructor; nothing is allocated after it. One object serves one thread.
class Integrator final : public MovingWagon {
 public:
  /// @param wagon  must outlive the integrator.
  /// @throws std::invalid_argument for a tolerance that is not positive or an unknown method.
  explicit Integrator(const Wagon& wagon, const IntegratorOptions& options = {});
  ~Integrator() override;
  Integrator(Integrator&&) noexcept;
  Integrator& operator=(Integrator&&) noexcept;

  /// Starts, or starts again: what follows depends on V and the state alone, bit by bit.  Counters go on.
  /// @param V  [m/s], > 0.
  void Start(double V, const WagonState& state);

  /// One step, at most to t_stop [s].
  /// @throws std::runtime_error if the solver gives up, with its reason and the time.
  Advance Step(double t_stop);

  const Wagon& wagon() const override;
  double speed() const override;
  const WagonState& state() const override;
  double step_begin() const override;
  const LinkStates& step_links() const override;
  void Interpolate(double t, StateVector<double>* x) const override;
  WheelLoads loads() const override;
  void Restart(const WagonState& state) override;

  /// The rate of the state at the end of the last step, and the forces behind it.
  const StateVector<double>& rate() const;
  const WagonForces& forces() const;

  const IntegratorCounts& counts() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// What an error of a step is measured by, component by component: 1 mm or 1 mrad for displacements, as much as that
/// moves per relaxation time of creep or Hertz contact for rates, and as much as a corner's spring feels of it for leaf
/// forces.
StateVector<double> CalcErrorScales(const Wagon& wagon);

/// The step [s] at which an explicit method stops being stable, for a wagon at rest on straight track: beyond it the
/// control of the step size would have to find out by failing. With
///   creep between rolling and rotation  f11 q (1/m + r^2/I_y) 2/V,
///   Hertz contact  w^2 = 3 n sqrt(q) max(1/m, a^2/I_x).
/// @param real_extent, imaginary_extent  how far a step times an eigenvalue may go along the negative real and the
/// imaginary axis; 0: not known, and infinity is returned.
double CalcStableStep(const Wagon& wagon, double V, double real_extent, double imaginary_extent);

}  // namespace uiclink
