#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "model/extended_oscillator.h"
#include "model/parameter_set.h"
#include "model/scalar.h"

namespace uiclink {

/// Effects of an extended set that have no place on a wagon, by identifier: those on the reading of a sensor or by the
/// rig, and friction_drift, which counts from the start of a record. Identifiers that the catalogue does not know are
/// not among them; the constructor of Link throws for these.
std::vector<std::string> EffectsLeftOut(const DirectionParameters& parameters);

/// The double link of one corner in one horizontal direction, under its load.  Constant during a run.
///
/// d [m], v [m/s]: displacement and velocity of the axle box relative to the body. Force on the wheelset [N]:
///   F = Q (-k d - c v - sum_i k_i S(d - p_i) + stops + forces of the effects),   Q = load of the corner,
/// with the law and the effects of model/extended_oscillator.h. Joint i sticks (p_i at rest) or slides (p_i follows at
/// the distance y_c,i L).
///
/// Rolling friction T_r sign(v) is a slider that slips at kRollingSlip: a body with many degrees of freedom has no
/// "held at rest" to switch to.  After a reversal it comes round over the way of 2 kRollingSlip, instead of at once,
/// and the excess makes a mass faster by  dv = (8/3) g T_r sqrt(kRollingSlip/a),  a the acceleration there: with T_r =
/// 3e-4 it is ahead by 1 um at 25 mm of amplitude, by 4 um at 1 mm, each time. A free decay on the bench is off by 0.03
/// mm in the end.
class Link {
 public:
  /// Displacement at which the friction of rolling slips [m]: far below every swing, and soft enough not to be stiff.
  static constexpr double kRollingSlip = 1e-6;

  Link() = default;
  /// @param load  weight on the corner [N], what M g was on the bench.
  /// @throws std::invalid_argument unless load > 0, for effects that are not in the catalogue, values outside their
  ///         bounds or too many sliders (MakeExtendedOscillator() of model/extended_link.h).
  Link(const DirectionParameters& parameters, double g, double load);

  double load() const { return load_; }
  /// The law per unit load, without drift; rolling friction is the slider rolling_slider().
  const ExtendedOscillator<double>& law() const { return law_; }
  /// First those of the parameter set in its order, then those of its effects, the friction of rolling last.
  std::span<const ExtendedSlider<double>> sliders() const { return law_.sliders.items(); }
  /// Between events the force is F = C - K d - c v: nothing but springs, sliders, clearances, stops, viscous damping
  /// and friction that grows linearly with speed.
  bool is_affine() const { return is_affine_; }
  /// Half the clearance of a joint [m]; 0 without one.
  double gap(std::size_t joint) const { return HasGap(joint) ? law_.gap : 0; }
  /// Friction limits depend on speed.  Then CalcMargin() and Switch() need the acceleration, and Switch() is to be
  /// called again, with the acceleration after the change, until it returns false: where a joint breaks out from a
  /// static peak the force falls at once, and with it the acceleration that says whether the joint slides on.
  bool needs_acceleration() const { return needs_acceleration_; }
  /// Number of the slider that is the friction of rolling; sliders().size() if there is none.
  std::size_t rolling_slider() const { return rolling_slider_; }

  /// Force at which a joint slides, per unit load [-]: moving at v [m/s] towards `side` (+1 or -1), v side >= 0.
  double CalcSlidingForce(std::size_t joint, double side, double v) const;
  /// The same at which it breaks out.
  double CalcBreakoutForce(std::size_t joint, double side, double v) const;
  /// d (deflection at which the joint slides) / d |v| [s].
  double CalcLimitSlope(std::size_t joint, double side, double v) const;

 private:
  bool HasGap(std::size_t joint) const { return law_.has_gap && law_.sliders.items()[joint].joint; }
  bool LimitMoves(std::size_t joint) const { return law_.has_strengthening && law_.sliders.items()[joint].joint; }
  double CalcSlidingLimit(std::size_t joint, double side, double v) const;
  double CalcBreakoutLimit(std::size_t joint, double side, double v) const;

  ExtendedOscillator<double> law_;                ///< per unit load
  FixedList<ForceTerm<Dual<6>>, 4> forces_dual_;  ///< its forces, for slopes by d (0) and v (1)
  double load_ = 0;
  double sticking_share_ = 0;  ///< of T0 by all speed terms, for a joint that sticks
  std::size_t rolling_slider_ = 0;
  bool is_affine_ = true;
  bool needs_acceleration_ = false;
  friend struct LinkState;
};

/// Which joints of a link stick and which slide, where they stick, and what follows from it for the force.
///
/// A mode lasts while CalcMargin() > 0. It ends where a joint that sticks reaches its limit, passes an end of its
/// clearance, a stop is touched or left, a joint whose limit grows faster than it is deflected stops sliding, or the
/// motion reverses: all joints that slide stick.
///
/// The reversal ends a mode even where nothing slides and no force changes (Switch() returns false, nothing is to be
/// started anew). Without it a slip that is shorter than a step of the integrator, which is what all slips near a
/// turning point are, would show in no sign at the step's ends. With it the margin that has once fallen through zero
/// stays negative, so that the ends of a step are enough, however long it is, unless the motion reverses twice within
/// it. (Where limits depend on speed it may dip below zero and come back: keep steps short against v_s/a there.)
/// No function but WithForces() may throw, none takes memory.
struct LinkState {
  /// Every threshold is taken this much too far [m], so that a joint that has just stuck at its limit, or has just
  /// passed an end of its clearance, has a margin that rounding does not use up. Events count from half of it on: an
  /// integrator that finds them within 1e-12 s has d within 2e-12 m up to 2 m/s. A force is off by k_i Q times that
  /// where the joint changes over, some 1e-6 N.
  static constexpr double kSlack = 4e-12;
  /// A motion has reversed when it goes back at this speed [m/s], what 100 m/s^2 make in 1e-12 s: rounding of a mass at
  /// rest makes no events. The displacement has changed by less than its own rounding since v = 0.
  static constexpr double kAtRest = 1e-10;
  /// Makes a distance [m] of a speed in the margin [s]: about the time in which a link turns round.
  static constexpr double kMarginTime = 0.1;

  struct Joint {
    double p = 0;             ///< deflection of the link at which the joint's spring is relaxed [m], while it sticks
    std::int8_t slides = 0;   ///< 0 sticks; +1, -1 slides towards +d, -d
    std::int8_t engaged = 0;  ///< joints with clearance: 0 in the gap, +1, -1 on that side of it
  };
  std::array<Joint, kMaxExtendedSliders> joints{};

  // F = C - K d - c v [N], the affine part (all of it for an affine link).
  double K = 0;  ///< [N/m]
  double C = 0;  ///< [N]
  double c = 0;  ///< [N s/m]

  double upper = 0;        ///< the next event of joints that stick is at d = upper ...
  double lower = 0;        ///< ... or d = lower [m]; infinite where there is none, or none before the motion reverses
  std::int8_t slides = 0;  ///< direction in which joints slide; 0 if none does
  std::int8_t travel = 0;  ///< direction in which the link moves, +1, -1; 0 before the first Switch()

  double slip = 0;                ///< share of sliding joints whose limit has speed terms: slides Q sum k_i y_c,i [N]
  std::array<bool, 2> touches{};  ///< stops in contact
  bool without_rolling_friction = false;  ///< of Rolling()

  /// All joints stick, relaxed at deflection d.
  static LinkState AtRest(const Link& link, double d);
  /// The joints' forces are given: T_i [N], |T_i| <= T0i; joints at their bounds slide if v says so.
  /// @param T  one per slider of the link. A joint with clearance and T_i = 0 is in the middle of it.
  /// @throws std::invalid_argument when there are not as many forces as sliders, or one exceeds its bound by more than
  ///         1e-9 of it.
  static LinkState WithForces(const Link& link, double d, double v, std::span<const double> T);
  /// All joints are given as they stand: p, direction of sliding, side of the clearance. For who knows the limits.
  /// @param joints  one per slider of the link.
  static LinkState WithJoints(const Link& link, double d, double v, std::span<const Joint> joints);
  /// The same joints and stops, as they are, in a link with other numbers (and as many sliders).
  LinkState In(const Link& link) const;
  /// What rolls on for ever at a vanishing amplitude about d = 0, for linear stability: every joint sticks, relaxed at
  /// d = 0; joints with clearance are within it.
  ///
  /// Rolling friction is taken as sliding, with zero mean force and slope zero. As the slider that it is in a run it
  /// would lock the link at infinitesimal amplitude, with the stiffness T_r/kRollingSlip that no link has; but what is
  /// asked of linear stability is the motion that has got going, and on a cycle of amplitude A >> kRollingSlip its
  /// force is +-T_r, whose stiffness is zero. (Its damping, 4 T_r/(pi A w), is not in the linear answer.) Micro-slip
  /// is not like that: its sliders stick at zero amplitude, and together they are the stiffness seen there.
  static LinkState Rolling(const Link& link);

  /// Force on the wheelset [N]; what is not affine is added.
  double CalcForce(const Link& link, double d, double v) const {
    const double affine = C - K * d - c * v;
    return link.is_affine() ? affine : affine + CalcOther(link, d, v);
  }
  /// The same with derivatives: F_d = dF/dd [N/m], F_v = dF/dv [N s/m], within the mode.
  struct Slopes {
    double F = 0, F_d = 0, F_v = 0;
  };
  Slopes CalcSlopes(const Link& link, double d, double v) const {
    const Slopes affine{.F = C - K * d - c * v, .F_d = -K, .F_v = -c};
    return link.is_affine() ? affine : AddOther(link, d, v, affine);
  }
  double CalcOther(const Link& link, double d, double v) const;  ///< what is not in C - K d - c v [N]

  /// Positive while the mode holds, negative beyond its end; continuous. a: d'' [m/s^2], used only where the limit of a
  /// joint depends on speed.  [m]; a falling zero is an event, a rising one is none.
  double CalcMargin(const Link& link, double d, double v, double a) const {
    double margin = std::min(upper - d, d - lower);
    if (travel != 0) margin = std::min(margin, kMarginTime * (travel * v + kAtRest));
    return link.needs_acceleration() ? std::min(margin, CalcMovingMargin(link, d, v, a)) : margin;
  }
  /// To be called where CalcMargin has fallen to zero: the joints change over.  False if nothing changed in the force.
  /// Call it once before the start, too: it then takes the direction of travel from v, or from a where v = 0.
  ///
  /// Everything within kSlack/2 of its threshold changes over together. A joint that reaches its limit at rest sticks
  /// with its force on the limit. At any other place nothing happens. See Link::needs_acceleration().
  bool Switch(const Link& link, double d, double v, double a);

  double CalcJointForce(const Link& link, std::size_t joint, double d, double v) const;  ///< T_i on the wheelset [N]
  /// Where the spring of a joint has no force [m]: p, or what follows d while it slides (without its clearance).
  double CalcPosition(const Link& link, std::size_t joint, double d, double v) const;
  bool AllStick() const { return slides == 0; }

 private:
  struct Range {
    double lower = 0, upper = 0;
  };
  bool IsAbsent(const Link& link, std::size_t joint) const {
    return link.law_.sliders.items()[joint].k == 0 || (without_rolling_friction && joint == link.rolling_slider_);
  }
  bool IsLoose(const Link& link, std::size_t joint) const { return joints[joint].engaged == 0 && link.HasGap(joint); }
  double CalcNeutral(const Link& link, std::size_t joint) const;
  double CalcSlidingRate(const Link& link, std::size_t joint, double v, double a) const;
  double CalcMovingMargin(const Link& link, double d, double v, double a) const;
  Slopes AddOther(const Link& link, double d, double v, Slopes sum) const;
  Range FindThresholds(const Link& link, std::size_t joint, double v) const;

  void Stick(const Link& link, std::size_t joint, double d, double v);
  void PassThreshold(const Link& link, std::size_t joint, double side, double d, double v);
  void Follow(double v, double a);
  bool StopSliding(const Link& link, double d, double v, double a);
  bool PassThresholds(const Link& link, double d, double v);
  bool PassStops(const Link& link, double d);
  void Load(const Link& link);
  void LoadStops(const Link& link);
};

}  // namespace uiclink
