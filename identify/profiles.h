#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/extended_result.h"
#include "identify/identification.h"

namespace uiclink {

/// Rise of the sum of squares at the ends of a 95 % interval, in variance factors: chi-square of one degree of freedom.
inline constexpr double kProfileRise = 3.84;

/// Profile likelihood of one unknown: the least sum of squares with the unknown held and everything else fitted again.
struct LikelihoodProfile {
  std::string symbol;  ///< "k", "sum_ki" (one slider: "k1"), "sum_T0i" ("T01"), "viscous_damping.c"
  std::string unit;
  int record = -1;            ///< number among the used ones, by itself; -1: all together
  std::vector<double> value;  ///< increasing, in the unit; the fitted one is among them
  /// Signed root of the rise of the sum of squares over the variance factor, below 0 left of the fitted value: a
  /// straight line where the likelihood is normal, -1.96 and 1.96 at the ends of a 95 % interval.
  std::vector<double> root;

  /// It has points on both sides and rises all the way. Otherwise refits have ended in different minima, as those of
  /// several sliders may, and nothing can be read from it.
  bool IsSound() const;
  /// The root between and beyond the points, by the polynomial through them.
  double Root(double at) const;
  /// Where the root reaches `goal`, within the points and as far again beyond them; none where it does not,
  /// or is not sound.
  std::optional<double> Find(double goal) const;
};

/// Profiles of the final model: k, the sums of stiffness and friction, and the shared parameters of the effects.
///
/// Records that share one link have one profile of each level. Where each has its own, a record has its profiles by
/// itself, with the shared parameters of the effects held at their common values: one record of several moves those by
/// a small part of their error. Two refits on either side, one and two standard deviations away, each from the fitted
/// state moved as the covariance says; the root is so nearly straight that a curve through them is exact to some per
/// cent of the width.
/// @param fit      of the used records of `id`, with its effects or without any.
/// @param records  numbers among the used ones that get profiles by themselves where links differ.
std::vector<LikelihoodProfile> CalcProfiles(const Identification& id, const ExtendedResult& fit,
                                            std::span<const std::size_t> records, int threads = 0);

/// The plain model of an identification as an extended result without effects, where there is no diagnosis to have one.
ExtendedResult DescribePlain(const Identification& id);

}  // namespace uiclink
