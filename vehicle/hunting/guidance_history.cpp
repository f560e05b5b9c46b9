#include "vehicle/hunting/guidance_history.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "vehicle/guidance.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

constexpr std::array<const char*, kAxles> kAxleNames{"front", "rear"};

void AddUse(const GuidanceHistory::Box& box, double clearance, GuidanceUse* use) {
  bool touched = false;
  for (std::size_t i = 0; i < box.force.size(); ++i) {
    use->clearance_used = std::max(use->clearance_used, std::abs(box.displacement[i]));
    const bool touches = box.force[i] != 0 && std::abs(box.displacement[i]) > clearance;
    if (touches && !touched) ++use->impacts.count;
    touched = touches;
    use->impacts.peak_N = std::max(use->impacts.peak_N, std::abs(box.force[i]));
  }
  use->clearance_used_in_window = use->clearance_used;
  use->impacts_in_window = use->impacts;
}

void AddColumns(const std::string& name, const GuidanceHistory::Box& box, double clearance,
                std::vector<DataColumn>* columns) {
  std::vector<double> left;
  left.reserve(box.displacement.size());
  for (const double d : box.displacement) left.push_back(clearance - std::abs(d));
  columns->push_back({name + "_displacement", "m", box.displacement});
  columns->push_back({name + "_clearance_left", "m", std::move(left)});
  columns->push_back({name + "_force", "N", box.force});
}

}  // namespace

GuidanceHistory CalcGuidanceHistory(const Wagon& wagon, std::span<const SimulationSample> samples) {
  GuidanceHistory history;
  history.lateral_clearance = wagon.guidance.lateral.clearance;
  history.longitudinal_clearance = wagon.guidance.longitudinal.clearance;
  // Never -0.
  const auto force = [&](double boxes, double stop) { return wagon.options.guidance ? boxes * stop + 0.0 : 0.0; };
  for (const SimulationSample& sample : samples) {
    history.t.push_back(sample.t);
    for (std::size_t i = 0; i < kCorners; ++i) {
      const CornerDeflection<double> d = CalcDeflection(wagon, sample.x, i);
      history.longitudinal[i].displacement.push_back(d.dx);
      history.longitudinal[i].force.push_back(force(1, CalcStopForce(wagon.guidance.longitudinal, d.dx)));
      if (SideOf(i) < 0) continue;  // both boxes of a wheelset are displaced alike
      history.lateral[AxleOf(i)].displacement.push_back(d.dy);
      history.lateral[AxleOf(i)].force.push_back(force(2, CalcStopForce(wagon.guidance.lateral, d.dy)));
    }
  }
  return history;
}

GuidanceUses CountGuidanceUse(const GuidanceHistory& history) {
  GuidanceUses uses;
  for (std::size_t i = 0; i < kAxles; ++i) AddUse(history.lateral[i], history.lateral_clearance, &uses.lateral[i]);
  for (std::size_t i = 0; i < kCorners; ++i)
    AddUse(history.longitudinal[i], history.longitudinal_clearance, &uses.longitudinal[AxleOf(i)]);
  return uses;
}

std::vector<DataColumn> GuidanceColumns(const GuidanceHistory& history) {
  std::vector<DataColumn> columns{{"time", "s", history.t}};
  for (std::size_t i = 0; i < kAxles; ++i)
    AddColumns(std::string(kAxleNames[i]) + "_lateral", history.lateral[i], history.lateral_clearance, &columns);
  for (std::size_t i = 0; i < kCorners; ++i) {
    AddColumns(std::string(kCornerNames[i]) + "_longitudinal", history.longitudinal[i], history.longitudinal_clearance,
               &columns);
  }
  return columns;
}

}  // namespace uiclink
