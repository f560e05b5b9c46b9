#pragma once

#include <cstddef>

namespace uiclink {

/// Probability that any effect of the catalogue reaches a statistic by chance when the plain model is right.
///
/// With q the tail of the statistic beyond its value and a the alternatives,
///   p = 1 - exp(-F a q),    q = P(chi-square of `unknowns` > statistic),    F = 7 + 3 log10(records).
/// The statistic n log(sum of squares without / with) of one effect with one place to act in is chi-square; places
/// (frequencies, positions) multiply its tail, and the catalogue multiplies it once more by F, the number of
/// independent families among its effects. F is calibrated on the pipeline itself, on records in which nothing is
/// hidden: tests/hidden_effects/README.md.
/// @param statistic     [-]; not positive, NaN: p is 1
/// @param unknowns      by how many the model has grown; >= 1
/// @param alternatives  >= 1
/// @param records       number of records, >= 1
double CalcFamilyWiseP(double statistic, int unknowns, double alternatives, std::size_t records);

}  // namespace uiclink
