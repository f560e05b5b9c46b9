#include "vehicle/hunting/hopf.h"

#include <algorithm>
#include <cmath>
#include <exception>

#include "dynamics/continuation.h"
#include "vehicle/equilibrium.h"

namespace uiclink {
namespace {

/// A cycle of size s is closed to this share of it [-]: far below the share by which a cycle of size s grows or decays
/// in a period one s^2 away from its place.
constexpr double kClosure = 1e-4;

HopfType TypeOf(const Crossing& crossing, double speed) {
  return (speed > crossing.V) == crossing.to_unstable ? HopfType::kSupercritical : HopfType::kSubcritical;
}

bool HasRollingFriction(const Wagon& wagon) {
  const auto has = [](const Link& link) { return link.rolling_slider() < link.sliders().size(); };
  return std::ranges::any_of(wagon.longitudinal, has) || std::ranges::any_of(wagon.lateral, has);
}

}  // namespace

const char* HopfTypeName(HopfType type) { return type == HopfType::kSupercritical ? "supercritical" : "subcritical"; }

HopfPoint ExamineHopf(const Wagon& wagon, const Crossing& crossing, const HopfOptions& options) {
  return ExamineHopf(FamilyBySpeed(wagon), crossing, options);
}

HopfPoint ExamineHopf(const WagonFamily& family, const Crossing& crossing, const HopfOptions& options) {
  HopfPoint hopf;
  hopf.crossing = crossing;
  if (crossing.frequency_hz == 0) {
    hopf.reason = "a real eigenvalue: the wagon diverges, no cycle is born";
    return hopf;
  }
  WagonFlow flow(family, crossing.V, options.flow);
  const Wagon& wagon = flow.WagonAt(crossing.V);
  if (HasRollingFriction(wagon)) {
    hopf.reason = "rolling friction holds the links at vanishing amplitude: no cycle is born, hunting has to be pushed";
    return hopf;
  }
  const Eigen::VectorXd equilibrium = flow.FromWagonState(FindEquilibrium(wagon, flow.SpeedAt(crossing.V)));
  Eigen::VectorXcd shape = flow.FromMode(crossing.mode);
  if (crossing.mode.lambda.imag() < 0) shape = shape.conjugate().eval();
  const double omega = std::abs(crossing.mode.lambda.imag());
  std::vector<double> sizes = options.sizes;
  sizes.push_back(options.type_size);
  std::ranges::sort(sizes);
  sizes.erase(std::ranges::unique(sizes).begin(), sizes.end());
  for (const double size : sizes) {
    CycleOptions cycle;
    cycle.tolerance = kClosure * size / options.flow.unit;
    try {
      BornCycle born{
          .size = size, .speed = 0, .cycle = FindBornCycle(flow, crossing.V, omega, equilibrium, shape, size, cycle)};
      born.speed = born.cycle.lambda;
      hopf.born.push_back(std::move(born));
    } catch (const std::exception& error) {
      if (size == options.type_size) hopf.reason = error.what();
    }
  }
  for (const BornCycle& born : hopf.born)
    if (born.size == options.type_size) hopf.type = TypeOf(crossing, born.speed);
  if (!hopf.type) return hopf;
  for (const BornCycle& born : hopf.born)
    if (born.size < options.type_size && TypeOf(crossing, born.speed) != *hopf.type) hopf.other_below = born.size;
  return hopf;
}

}  // namespace uiclink
