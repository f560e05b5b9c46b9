#pragma once

#include <cstddef>

namespace uiclink {

/// Probability that any effect of the catalogue reaches a statistic by chance when the plain model is right.
///
/// The statistic n_eff log(mean square without / with) of one effect with one place to act in is chi-square of its
/// `unknowns`; `alternatives` places (frequencies, positions) multiply its tail, and the whole catalogue multiplies it
/// once more by kFamilies, the number of independent families among its effects. Calibrated on the pipeline itself:
/// tests/hidden_effects/README.md.
/// @param statistic     [-]
/// @param unknowns      by how many the model has grown
/// @param alternatives  >= 1
/// @param records       number of records
double CalcFamilyWiseP(double statistic, int unknowns, double alternatives, std::size_t records);

}  // namespace uiclink
