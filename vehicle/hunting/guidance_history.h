#pragma once

#include <array>
#include <span>
#include <vector>

#include "reports/csv.h"
#include "vehicle/simulation.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// Axle boxes against their guides over a run (chapter 6, figures 10.6 ff.), from its samples.
struct GuidanceHistory {
  struct Box {
    std::vector<double> displacement;  ///< of the axle box relative to the body [m]
    std::vector<double> force;         ///< of the guide on the wheelset [N]
  };
  std::vector<double> t;                   ///< [s]
  std::array<Box, kAxles> lateral;         ///< by axle; the force of both boxes together
  std::array<Box, kCorners> longitudinal;  ///< by corner
  double lateral_clearance = 0;            ///< [m]
  double longitudinal_clearance = 0;       ///< [m]
};
GuidanceHistory CalcGuidanceHistory(const Wagon& wagon, std::span<const SimulationSample> samples);

/// Contacts that began, largest force and clearance used, as far as samples show them; both figures of GuidanceUse,
/// whole and in the window, are of all samples.
struct GuidanceUses {
  std::array<GuidanceUse, kAxles> lateral, longitudinal;
};
GuidanceUses CountGuidanceUse(const GuidanceHistory& history);

/// Time; of every guide displacement, force and what is left of the clearance (< 0 while it is pressed). SI units.
std::vector<DataColumn> GuidanceColumns(const GuidanceHistory& history);

}  // namespace uiclink
