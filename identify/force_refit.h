#pragma once

#include <span>
#include <vector>

#include "identify/force_dependence.h"
#include "identify/force_series.h"

namespace uiclink {

/// Records, what they lack, and what that depends on.
struct ForceAnalysis {
  std::vector<MissingForceInput> inputs;  ///< usable ones, with the links along which the force is seen
  std::vector<std::size_t> usable;        ///< their indices among all
  std::vector<ForceSeries> series;
  DependenceSearch search;
  int dof = 0;
};

/// Sees the missing force along links that are right beside it.
///
/// A link that was fitted without the missing force can be wrong by a third, and then its sliders break out at the
/// wrong places: first-order projection no longer takes that away, and the error would pass for a force of velocity. So
/// where something is missing at all, k, k_i, T0i and offset of each record are refitted to the windows (Gauss-Newton,
/// least squares on forces, which accumulate no phase), at first alone, then beside whatever the search has named,
/// until the links settle. Weak normal priors (kLinkPrior of each parameter about its value) hold what the force makes
/// unobservable. Where nothing is missing the links stay as given.
ForceAnalysis AnalyseForce(std::span<const MissingForceInput> records);

/// Orthonormal columns of all named dependences for which `use` holds.
template <typename Use>
Eigen::MatrixXd NamedBasis(const ForceRegression& regression, const DependenceSearch& search, const Use& use) {
  Eigen::MatrixXd basis(regression.force().size(), 0);
  for (const std::size_t i : search.named) {
    if (!use(search.all[i])) continue;
    const Eigen::MatrixXd more = Independent(ColumnsOf(regression, search.all[i]), basis);
    basis.conservativeResize(Eigen::NoChange, basis.cols() + more.cols());
    basis.rightCols(more.cols()) = more;
  }
  return basis;
}

/// Probability of the missing force's size by noise alone.
double CalcNoiseProbability(const DependenceSearch& search, int dof);

}  // namespace uiclink
