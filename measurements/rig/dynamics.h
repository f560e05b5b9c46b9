#pragma once

#include <vector>

#include "measurements/rig/rig.h"

namespace uiclink::rig {

/// The mass on its link, moved in fixed small steps (velocity Verlet, second order, with a return map for the joints).
///
/// A joint is kept by the position p of its slider, not by its force: T = -k (y - p) exactly as long as it sticks, and
/// the return map moves p when the force would exceed what friction holds. Dry friction on the mass itself
/// (rolling_friction) changes the velocity piecewise exactly within each half step, so reversals cost no accuracy.
class Oscillator {
 public:
  /// Everything that moves, so that a step can be taken back.
  struct State {
    struct Slider {
      double p = 0;  ///< position [m]
      bool sliding = false;
    };
    double t = 0, y = 0, v = 0;
    double friction = 0;  ///< dry friction on the mass that holds now, per unit load
    double T_sum =
        0;  ///< force of all that has a memory (joints, micro-slip, Maxwell branch) on the mass, per unit load
    double maxwell_T = 0;  ///< force of the Maxwell branch on the mass, per unit load
    double loss = 0;       ///< energy lost so far, per unit load [m]
    std::vector<Slider> joints;
    std::vector<double> micro;  ///< positions of the micro-slip sliders [m]
  };

  explicit Oscillator(const Link& link);

  /// Puts the mass at rest where the joints' start forces hold it.
  void StartAtRest();
  /// Puts the mass at rest at y [m], every joint at the end of sliding outward: -sign(y) T0i, as the effects have it.
  void StartAtExtremum(double y);
  void SetTime(double t) { state_.t = t; }
  /// A push of strength P (0: none) that follows the velocity; `sign` is its direction while the mass stands still.
  void SetPush(double P, double sign);

  void Step(double h);  ///< moves on by h [s]

  const State& state() const { return state_; }
  void Restore(const State& state) { state_ = state; }
  double t() const { return state_.t; }
  double y() const { return state_.y; }
  double v() const { return state_.v; }
  double Loss() const { return state_.loss; }
  double Energy() const;  ///< kinetic + potential energy per unit load [m]
  /// w of the push [rad/s]: all joints stuck.
  double ResonanceFrequency() const { return w_push_; }

 private:
  double Stiffness(double t) const;
  double PositionForce(double y) const;
  double VelocityForce(double v) const;
  double PushForce(double v) const;
  double PotentialEnergy(double y) const;
  double PendulumEnergy(double y, double k) const;
  double SlackFree(double z) const;
  double FrictionLimit(const Joint& joint, double side) const;
  void FollowJoints(double v_half, double speed);
  void FollowMicroSlip();
  void FollowMaxwell(double dy, double h);

  Link link_;  ///< the extra slider is one of its joints
  double w_push_ = 0;
  double push_ = 0, push_sign_ = 1;
  double rest_y_ = 0;
  State state_;
};

/// How one record is pushed.
struct PushPlan {
  double start_s = 0;
  double strength = 0;  ///< P
  int half_swings = 0;
  double release_before_extremum = 0;
  double side = 1;  ///< sign of the first free extremum
};

/// What the mass did in one record.
struct Motion {
  std::vector<double> y;  ///< true displacement at the converter's samples [m]
  double rest_y = 0;
  double push_amplitude = 0;
  double push_start_s = 0;
  double release_s = 0;
  double first_extremum_s = 0;
  double first_extremum = 0;
};

/// Tunes the push and runs one record: rest, push, release, free decay.
/// @param side    sign of the first free extremum
/// @param target  its size [m]
/// @throws std::invalid_argument when no push reaches the target.
Motion RunRecord(const Settings& settings, const Link& link, double side, double target);

}  // namespace uiclink::rig
