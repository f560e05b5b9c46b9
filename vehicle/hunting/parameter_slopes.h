#pragma once

#include <cstddef>
#include <memory>

#include "vehicle/hunting/recorded_run.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// How the laws of a wagon change with one of its numbers while its state and the mode of its joints stay: central
/// differences between two wagons a little below and above. Within a mode the laws are smooth, so that a step h
/// relative to the number leaves errors of h^2 and of rounding/h: 1e-10 for h = 1e-5. Events are none of them;
/// Variation passes those exactly.
class ParameterSlopes {
 public:
  /// @param width  how much the parameter differs between the two [its unit], > 0.
  ParameterSlopes(std::shared_ptr<const Wagon> below, std::shared_ptr<const Wagon> above, double width);

  /// The mode that counts from now on.
  void SetMode(const LinkStates& links);
  /// d rate / d parameter. @param V  speed [m/s].
  void CalcRate(double V, const StateVector<double>& x, StateVector<double>* slope) const;

  /// Of the deflection of a link [m per unit] and of its rate, where the motions stay: the body's height moves them.
  struct Deflection {
    double d = 0, v = 0;
  };
  Deflection CalcDeflection(std::size_t link, const StateVector<double>& x) const;

  /// Of the distance from the place where a joint's spring is relaxed at which it slides towards `side` at v [m/s],
  /// clearance included [m per unit].
  double CalcSlidingReach(const SliderPlace& place, double side, double v) const {
    return CalcReach(&Link::CalcSlidingForce, place, side, v);
  }
  /// The same for its breaking out.
  double CalcBreakoutReach(const SliderPlace& place, double side, double v) const {
    return CalcReach(&Link::CalcBreakoutForce, place, side, v);
  }

 private:
  using ForceLaw = double (Link::*)(std::size_t joint, double side, double v) const;
  double CalcReach(ForceLaw law, const SliderPlace& place, double side, double v) const;

  std::shared_ptr<const Wagon> below_, above_;
  double width_;
  LinkStates links_below_, links_above_;
};

}  // namespace uiclink
