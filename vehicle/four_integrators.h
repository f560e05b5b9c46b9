#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "vehicle/four_steps.h"
#include "vehicle/four_wagons.h"
#include "vehicle/integrator.h"
#include "vehicle/wagon_guards.h"

namespace uiclink {

/// Moves up to four wagons side by side in the lanes of the processor, each at its own time, with its own step size and
/// its own events: none waits for another.  For sweeps, where it makes more than twice as many wagons a second and
/// core as Integrator one after the other (tests/bench).
///
/// The pair (Zonneveld), the control of the step size and the events are those of Integrator, so that both make the
/// same errors, but not the same last digits.  What happens in a lane depends on its wagon alone, bit by bit, whatever
/// runs beside it. Nothing is allocated. One object serves one thread.
class FourIntegrators {
 public:
  static constexpr std::size_t kWagons = FourWagons::kWagons;

  /// Puts a wagon into a lane, or starts it again there. What follows depends on wagon, V, state and options alone.
  /// @param wagon  must outlive its run: until Stop() or another Start(). CanShareLanes() must hold for all wagons.
  /// @throws std::invalid_argument where it does not, V or the tolerance is not positive, or another method is asked
  /// for.
  void Start(std::size_t lane, const Wagon& wagon, double V, const WagonState& state,
             const IntegratorOptions& options = {});
  /// Goes on from a state as after a start with the same wagon, speed and options.
  void Restart(std::size_t lane, const WagonState& state);
  /// Ends the run of a lane. Its wagon is not looked at any more.
  void Stop(std::size_t lane);
  bool runs(std::size_t lane) const { return lanes_[lane].runs; }
  /// The integration has given up at state().t.
  bool failed(std::size_t lane) const { return lanes_[lane].failures == kMostFailures; }

  /// Tries one step in every lane that runs, at most to t_stop [s]. Empty for a lane whose step was too large, or that
  /// does not run.  A wagon that derails stops, and so does one the error of whose step stays too large (failed()).
  using Advances = std::array<std::optional<Advance>, kWagons>;
  Advances Step(const std::array<double, kWagons>& t_stop);

  // As those of MovingWagon, by lane; between a step that was taken there and the next call.
  const Wagon& wagon(std::size_t lane) const { return *lanes_[lane].wagon; }
  double speed(std::size_t lane) const { return lanes_[lane].V; }
  const WagonState& state(std::size_t lane) const { return lanes_[lane].state; }
  double step_begin(std::size_t lane) const { return lanes_[lane].begin; }
  const LinkStates& step_links(std::size_t lane) const;
  void Interpolate(std::size_t lane, double t, StateVector<double>* x) const;
  WheelLoads loads(std::size_t lane) const;
  const IntegratorCounts& counts(std::size_t lane) const { return lanes_[lane].counts; }

 private:
  static constexpr int kMostFailures = 7;  ///< of one step

  struct Lane {
    enum class After : std::uint8_t { kNothing, kStep, kEvent };
    bool runs = false;
    const Wagon* wagon = nullptr;
    double V = 0;
    WagonState state;          ///< where the last step ended
    LinkStates step_links;     ///< before the event
    StateVector<double> rate;  ///< after a start or an event
    WheelLoads loads;          ///< likewise
    WagonGuards guards;
    double begin = 0, h = 0;  ///< of the last step [s]
    double next = 0;          ///< size of the next step [s]
    double largest_step = 0;  ///< [s]
    double log_error = 0;     ///< of the last step that was taken
    double most_growth = 0;
    int failures = 0;               ///< of this step
    After after = After::kNothing;  ///< what the next call has to do first
    IntegratorCounts counts;
  };

  void FillEmptyLanes();
  void Begin(std::size_t lane, const WagonState& state);
  void CalcBegin(Lane* lane);
  void PutState(std::size_t lane);
  void SetGuards(std::size_t lane);
  void Commit();
  void MakeSteps();
  static bool ControlStep(Lane* lane, double error);
  Advance EndStep(std::size_t lane, double least_guard, double t_stop);
  HermiteStep LastStep(std::size_t lane) const;

  FourWagons four_;
  std::array<Lane, kWagons> lanes_;
  bool lanes_change_ = false;  ///< which run and which do not
  FourStates x_, x_end_;       ///< begin and end of the steps
  FourStages k_;               ///< rates of the stages: the first at the begin, the last at the end
  FourStates weights_;         ///< of errors: 1 / tolerance
  FourWheelLoads loads_;
  FourGuards guards_;
  Lanes h_, errors_, least_guards_;
};

/// A lane of them.
class MovingLane final : public MovingWagon {
 public:
  MovingLane(FourIntegrators& four, std::size_t lane) : four_(four), lane_(lane) {}
  const Wagon& wagon() const override { return four_.wagon(lane_); }
  double speed() const override { return four_.speed(lane_); }
  const WagonState& state() const override { return four_.state(lane_); }
  double step_begin() const override { return four_.step_begin(lane_); }
  const LinkStates& step_links() const override { return four_.step_links(lane_); }
  void Interpolate(double t, StateVector<double>* x) const override { four_.Interpolate(lane_, t, x); }
  WheelLoads loads() const override { return four_.loads(lane_); }
  void Restart(const WagonState& state) override { four_.Restart(lane_, state); }

 private:
  FourIntegrators& four_;
  std::size_t lane_;
};

}  // namespace uiclink
