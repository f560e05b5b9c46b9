#pragma once

#include <array>
#include <string>
#include <vector>

#include "vehicle/sweep/sweep_axis.h"
#include "vehicle/wagon.h"

namespace uiclink {

/// The links of a run: those of its sets with what is drawn for its sample, and for nothing else, so that it is the
/// same whatever other samples there are, in whatever order and on whatever computer.
///
///   draw_sets     the values of each set from its covariance (vehicle/hunting/set_scatter.h, independent draws: more
///                 samples may come later, which a Latin hypercube cannot have)
///   draw_corners  times a factor for each corner's parameter, by the spread between links that its set has
///   scatter       times a factor, log-normal with mean 1, for every parameter of every corner (ScatterLinks)
/// @throws InputError where there is nothing to draw from, or a covariance is none.
std::array<CornerLinks, kCorners> DrawLinks(const RunSetup& setup, const std::array<CornerLinks, kCorners>& links);

/// A number that was drawn from a set.
struct DrawnValue {
  std::string column;  ///< "drawn_lateral_T01" [of the set], "factor_lateral_k_front_left" [-]
  double value;
};
/// Those of draw_sets and draw_corners; empty without. @throws InputError as DrawLinks().
std::vector<DrawnValue> ListDraws(const RunSetup& setup, const std::array<CornerLinks, kCorners>& links);

/// The factors of a corner's parameters in a run with scatter: log-normal with mean 1, independent, from the run's own
/// seed. Corner by corner: longitudinal k, k1, T01, k2, T02, ..., lateral k, k1, T01, ...
void ScatterLinks(const RunSetup& setup, std::array<CornerLinks, kCorners>* links);

}  // namespace uiclink
