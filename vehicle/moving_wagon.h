#pragma once

#include "vehicle/wagon.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {

/// A wagon that something moves step by step (Integrator, a lane of FourIntegrators), as its record sees it between two
/// steps.
class MovingWagon {
 public:
  virtual ~MovingWagon() = default;

  virtual const Wagon& wagon() const = 0;
  virtual double speed() const = 0;  ///< [m/s]

  /// Where the wagon is, after an event in the new mode.
  virtual const WagonState& state() const = 0;
  /// Where the last step began, and in which mode it was made.
  virtual double step_begin() const = 0;
  virtual const LinkStates& step_links() const = 0;
  /// State at t [s] within the last step.  Does not change the run.
  virtual void Interpolate(double t, StateVector<double>* x) const = 0;
  /// At the end of the last step.
  virtual WheelLoads loads() const = 0;

  /// From here on nothing but the state counts, as after a start.
  virtual void Restart(const WagonState& state) = 0;

 protected:
  MovingWagon() = default;
  MovingWagon(const MovingWagon&) = default;
  MovingWagon(MovingWagon&&) = default;
  MovingWagon& operator=(const MovingWagon&) = default;
  MovingWagon& operator=(MovingWagon&&) = default;
};

}  // namespace uiclink
