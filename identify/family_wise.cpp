#include "identify/family_wise.h"

#include <algorithm>
#include <cmath>

#include "identify/statistics.h"

namespace uiclink {
namespace {

/// Effects that linear screens can tell apart act like so many independent ones (literature.md 5.3: 3 in one record, 4
/// to 5 in five).
constexpr double kFamilies = 10;

}  // namespace

double CalcFamilyWiseP(double statistic, int unknowns, double alternatives, std::size_t /*records*/) {
  if (!(statistic > 0)) return 1;
  const double one = CalcChiSquareTail(statistic, std::max(1, unknowns));
  const double expected = one * std::max(1.0, alternatives) * kFamilies;
  return -std::expm1(-expected);
}

}  // namespace uiclink
