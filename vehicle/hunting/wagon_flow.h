#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/flow.h"
#include "vehicle/integrator.h"
#include "vehicle/stability.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// What is varied: the speed, or anything that a wagon is made of.
struct WagonFamily {
  std::string name = "speed";  ///< for messages and files
  std::string unit = "m/s";
  /// The wagon at a value of the parameter; called with the values that a continuation meets and close ones.
  std::function<std::shared_ptr<const Wagon>(double value)> make;
  bool varies_speed = true;  ///< the value is the speed, and `make` gives the same wagon for all of them
  double speed = 0;          ///< [m/s], where something else is varied
  double step = 1e-4;        ///< of ParameterSlopes [its unit]; not used for the speed
};

struct WagonFlowOptions {
  double tolerance = 1e-8;  ///< of the integrator (IntegratorOptions)
  double unit = 1e-3;       ///< scales: a deviation of 1 mm or 1 mrad counts as one, rates accordingly
};

/// The wagon as a flow whose cycles are hunting (dynamics/flow.h).
///
/// State: the motions of wagon_state.h (30, or 34 with leaf springs), then for every slider of every link the place p
/// [m] where its spring is relaxed (LinkState::Joint::p; while the joint slides, p follows the link: slaved). Sliders
/// in the order longitudinal links by corner, lateral links by corner.
///
/// Derivatives, by whatever is varied too, are exact through stick and slip, static friction, guidance and spring
/// stages (variation.h); a jump of rigid contact is blended over a fraction of a micrometre (ContactCurve), and what a
/// deviation gains or loses there is not in them.
class WagonFlow : public Flow {
 public:
  /// @param lambda  a value of the parameter: what sizes and names follow from.
  WagonFlow(WagonFamily family, double lambda, const WagonFlowOptions& options = {});
  ~WagonFlow() override;

  int size() const override;
  const Eigen::VectorXd& scales() const override;
  /// kMotionNames (simulation.h), then the displacements of axle boxes relative to the body: lateral at front and rear,
  /// longitudinal by corner.
  const std::vector<std::string>& watched() const override;
  Passage Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) override;
  void Follow(const Eigen::VectorXd& from, const std::vector<int>& slaved, Eigen::VectorXd* state) const override;

  const WagonFamily& family() const;
  double SpeedAt(double lambda) const;
  const Wagon& WagonAt(double lambda);  ///< lives until the next call with another value

  /// Between the two ways of writing down where a wagon is.
  Eigen::VectorXd FromWagonState(const WagonState& state) const;
  WagonState ToWagonState(const Eigen::VectorXd& state, double lambda);
  /// A mode of the linear wagon as a direction of the state.
  Eigen::VectorXcd FromMode(const LinearMode& mode) const;

  /// A moment of a run at which the body passes the middle of its lateral motion to the left, and the time to the next
  /// such moment: a guess for FindCycle. Runs on for `duration` [s]. None where the wagon does not hunt.
  struct Guess {
    Eigen::VectorXd state;
    double period = 0;
  };
  std::optional<Guess> GuessCycle(const WagonState& from, double lambda, double duration);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// The family of a wagon by speed; the wagon is copied.
WagonFamily FamilyBySpeed(const Wagon& wagon);

}  // namespace uiclink
