#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "vehicle/wagon.h"

namespace uiclink {

/// A step: the cubic through states and rates at both ends.
struct HermiteStep {
  StateVector<double> x0, f0, x1, f1;
  double h = 0;  ///< [s]
  /// @param share  0 at the begin, 1 at the end.
  void At(double share, StateVector<double>* x) const;
};

/// The events of one wagon (integrator.h), and how to look for them in a step. Each guard is a number that
/// passes zero where something changes, and is held with the side on which it is.
class WagonGuards {
 public:
  enum class Kind : std::uint8_t { kLinks, kTrack, kLongitudinalStop, kLateralStop, kStage, kLeafReversal };
  struct Guard {
    Kind kind;
    std::size_t corner;
    std::int8_t side;  ///< +1, -1
  };
  static constexpr std::size_t kMost = 1 + 1 + 4 + 2 + 4;
  static constexpr double kFar = 1;             ///< of a guard that cannot pass zero now
  static constexpr double kLeafAtRest = 1e-10;  ///< [m/s]; rounding of a wagon at rest makes no events

  /// Values of the guards, in their order.
  using Values = std::array<double, kMost>;

  WagonGuards() = default;
  /// @param wagon  must outlive this.
  explicit WagonGuards(const Wagon& wagon);
  /// Lets the joints of `state` change over where they have to, and takes the sides from it.
  void Start(double V, WagonState* state);

  /// Looks for the first event within a step that was made in the mode of state->links. If there is one, the state is
  /// set to it (its time by share), and goes on behind it.
  /// @return the share of the step at the event, or a negative number.
  double Pass(const HermiteStep& step, WagonState* state);

  // The parts of it, for a solver that finds the zeros itself.
  void Calc(const LinkStates& links, const StateVector<double>& x, double* values) const;
  /// Lets the joints change over; with limits that depend on speed until the acceleration after it agrees (link.h).
  void Settle(WagonState* state) const;
  /// Brings the directions in which leaf springs move up to date.
  void FollowLeaves(const StateVector<double>& x);
  /// Only the fall of such a guard below zero is an event.
  static bool IsFalling(Kind kind) {
    return kind == Kind::kLinks || kind == Kind::kTrack || kind == Kind::kLeafReversal;
  }

  std::size_t size() const { return count_; }
  const Guard& operator[](std::size_t i) const { return guards_[i]; }
  std::int8_t leaf_travel(std::size_t corner) const { return leaf_travel_[corner]; }
  double track_limit() const { return track_limit_; }
  /// Limits of a joint depend on speed: a coarse look that knows no accelerations does not do.
  bool needs_acceleration() const { return needs_acceleration_; }
  bool derailed() const { return derailed_; }

 private:
  using Deflections = std::array<CornerDeflection<double>, kCorners>;

  double CalcLinkMargin(const LinkStates& links, const StateVector<double>& x, const Deflections& at) const;
  void SetSides(const LinkStates& links, const StateVector<double>& x);
  bool HasCrossed(std::size_t i, double value) const;
  bool HasAnyCrossed(const Values& values) const;
  double Find(const HermiteStep& step, const LinkStates& links, const Values& at_end) const;
  double CalcSecant(const Values& low, const Values& high, double weight) const;
  void Cross(const Values& values, WagonState* state);

  const Wagon* wagon_ = nullptr;
  double V_ = 0;
  double track_limit_ = 0;
  bool needs_acceleration_ = false;
  bool derailed_ = false;
  std::array<Guard, kMost> guards_{};
  std::size_t count_ = 0;
  std::array<std::int8_t, kCorners> leaf_travel_{};  ///< +1, -1: a leaf spring is being loaded, unloaded; 0 at rest
};

}  // namespace uiclink
