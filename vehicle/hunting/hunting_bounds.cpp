#include "vehicle/hunting/hunting_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr std::size_t IndexOf(TrackedMotion motion) { return static_cast<std::size_t>(motion); }

/// One link: |T_i| / limit stays.
LinkState CarryOver(const Link& from, const LinkState& state, const Link& to, double d, double v) {
  if (from.sliders().size() != to.sliders().size())
    throw std::invalid_argument("CarryOver: expected links with the same joints");
  std::vector<double> forces;
  for (std::size_t i = 0; i < to.sliders().size(); ++i) {
    const double T = state.CalcJointForce(from, i, d, v), side = T < 0 ? 1 : -1;
    const double limit = from.CalcBreakoutForce(i, side, v) * from.load();
    const double share = limit > 0 ? std::min(1.0, std::abs(T) / limit) : 0;
    forces.push_back(-side * share * to.CalcBreakoutForce(i, side, v) * to.load());
  }
  return LinkState::WithForces(to, d, v, forces);
}

}  // namespace

WagonState CarryOver(const Wagon& from, const WagonState& state, const Wagon& to) {
  WagonState carried = state;
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const CornerDeflection<double> at = CalcDeflection(from, state.x, corner);
    carried.links.longitudinal[corner] =
        CarryOver(from.longitudinal[corner], state.links.longitudinal[corner], to.longitudinal[corner], at.dx, at.vx);
    carried.links.lateral[corner] =
        CarryOver(from.lateral[corner], state.links.lateral[corner], to.lateral[corner], at.dy, at.vy);
  }
  return carried;
}

const std::vector<Asked>& HuntingScalars() {
  static const std::vector<Asked> asked{
      {"front lateral amplitude", "mm"}, {"rear lateral amplitude", "mm"},       {"body lateral amplitude", "mm"},
      {"front lateral frequency", "Hz"}, {"front lateral clearance used", "mm"}, {"rear lateral clearance used", "mm"},
      {"lateral impacts", "-"},          {"lateral impact, peak", "kN"},         {"longitudinal impacts", "-"},
      {"least wheel load", "kN"}};
  return asked;
}

std::vector<double> HuntingScalarsOf(const SimulationResult& result) {
  const auto amplitude = [&](TrackedMotion motion) { return result.motions[IndexOf(motion)].amplitude; };
  const std::vector<double>& frequencies = result.motions[IndexOf(TrackedMotion::kFrontLateral)].frequencies;
  const double front = amplitude(TrackedMotion::kFrontLateral), rear = amplitude(TrackedMotion::kRearLateral);
  const bool hunts = std::max(front, rear) >= kHuntingLeast && !frequencies.empty();
  int lateral = 0, longitudinal = 0;
  double peak = 0;
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    lateral += result.lateral[axle].impacts_in_window.count;
    longitudinal += result.longitudinal[axle].impacts_in_window.count;
    peak = std::max(peak, result.lateral[axle].impacts_in_window.peak_N);
  }
  return {1e3 * front,
          1e3 * rear,
          1e3 * amplitude(TrackedMotion::kBodyLateral),
          hunts ? frequencies.front() : std::numeric_limits<double>::quiet_NaN(),
          1e3 * result.lateral[0].clearance_used_in_window,
          1e3 * result.lateral[1].clearance_used_in_window,
          static_cast<double>(lateral),
          1e-3 * peak,
          static_cast<double>(longitudinal),
          1e-3 * result.minimum_wheel_load};
}

std::vector<ScalarBounds> CalcHuntingBounds(const SetScatter& scatter, const Wagon& wagon, double V,
                                            const WagonState& start, const SimulationOptions& simulation,
                                            const PropagateOptions& options) {
  SimulationOptions quiet = simulation;
  quiet.output_hz = 0;
  quiet.output_forces = false;
  quiet.on_checkpoint = nullptr;
  quiet.on_progress = nullptr;
  const auto run = [&](const Wagon& at) {
    const SimulationResult result = Simulate(at, V, CarryOver(wagon, start, at), quiet);
    if (result.end != SimulationEnd::kDuration) throw std::runtime_error(result.end_reason);
    return HuntingScalarsOf(result);
  };
  return PropagateScalars(scatter, wagon, HuntingScalars(), run, options);
}

}  // namespace uiclink
