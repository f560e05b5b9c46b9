#pragma once

#include <array>
#include <cstddef>

#include "vehicle/simulation.h"

namespace uiclink {

/// What a stretch of a run does: extremes of the motions, guidance, wheel loads. Takes no memory, so that thousands of
/// short stretches can be watched on one integrator; MotionRecord, with its spectra, is for single runs.
///
/// Extremes are found within steps, by the cubic through values and rates at both ends (vehicle/turn.h).
class WindowWatch {
 public:
  explicit WindowWatch(const Wagon& wagon) : wagon_(&wagon) {}

  /// A stretch begins where the integrator is.
  void Begin(const Integrator& integrator);
  /// After every step.
  void Add(const Integrator& integrator);

  double least(TrackedMotion motion) const { return least_[static_cast<std::size_t>(motion)]; }
  double greatest(TrackedMotion motion) const { return greatest_[static_cast<std::size_t>(motion)]; }
  /// max |y| [m] or [rad], half of peak to peak, and the middle between the peaks, by TrackedMotion.
  std::array<double, kMotionCount> CalcLargest() const;
  std::array<double, kMotionCount> CalcHalfWidths() const;
  std::array<double, kMotionCount> CalcMiddles() const;
  /// Only what belongs to a whole run is set: clearance_used and impacts. A contact that lasts from before the stretch
  /// counts as one that began.
  GuidanceUse Lateral(Axle axle) const;
  GuidanceUse Longitudinal(Axle axle) const;
  double minimum_wheel_load() const { return minimum_wheel_load_; }  ///< smallest Q at the ends of steps [N]
  bool wheel_lift() const { return wheel_lift_; }                    ///< a wheel was in the air at the end of a step

 private:
  static constexpr std::size_t kStops = kAxles + kCorners;  ///< lateral by axle, longitudinal by corner
  struct Stop {
    double value = 0, rate = 0;
    double used = 0;  ///< largest |value| [m]
    bool touches = false;
    int contacts = 0;
  };

  void WatchMotions(double h, const StateVector<double>& x);
  void WatchStops(double h, const StateVector<double>& x);
  void SeeStop(std::size_t stop, double value);
  double ClearanceOf(std::size_t stop) const;
  double StiffnessOf(std::size_t stop) const;
  GuidanceUse CalcUse(std::size_t stop) const;

  const Wagon* wagon_;
  double t_ = 0;
  StateVector<double> x_{};
  std::array<double, kMotionCount> least_{}, greatest_{};
  std::array<Stop, kStops> stops_{};
  double minimum_wheel_load_ = 0;
  bool wheel_lift_ = false;
};

}  // namespace uiclink
