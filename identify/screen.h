#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "identify/extended_fit.h"

namespace uiclink {

/// The unknowns of a fit of several records in one row, and where those of one record are in it.
class UnknownMap {
 public:
  /// @param own_shapes  each record has a shape of its own (FitState::shapes).
  UnknownMap(const Extension& extension, Sharing sharing, int sliders, std::size_t records, bool own_shapes = false);

  Eigen::Index size() const { return size_; }
  /// Place in the whole of each column of LineariseExtended() for one record.
  std::vector<Eigen::Index> Columns(std::size_t record) const;
  /// Place of the first shared parameter of the effects.
  Eigen::Index first_shared() const { return 3 * levels_ + shape_ * shapes_; }

 private:
  Eigen::Index levels_, shape_, shapes_, shared_, own_, records_, size_;
};

/// [J r]'[J r] of all records at a state, in units of the noise: everything that linear statistics need.
struct Normal {
  Eigen::MatrixXd gram;      ///< J'J, unknowns in the order of UnknownMap
  Eigen::VectorXd gradient;  ///< J'r
  double chi2 = 0;           ///< r'r
};
Normal CalcNormal(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                  const ExtendedState& state, std::size_t stride);

/// Inverse of a symmetric positive semidefinite matrix, unknowns scaled to a like size first; directions whose scaled
/// eigenvalue is below `rounding` are not determined and get nothing.
Eigen::MatrixXd InvertDetermined(const Eigen::MatrixXd& matrix, double rounding);

/// What a score (Lagrange-multiplier) test says about some of the unknowns, the others being fitted.
struct Score {
  double statistic = 0;   ///< fall of the sum of squares that a linear step by these unknowns promises
  double visibility = 0;  ///< u: share of their sensitivity that the other unknowns cannot absorb, 0..1
  Eigen::VectorXd step;   ///< of these unknowns, to the minimum of the linear problem
};

/// @param tested  numbers of the unknowns that are at their neutral value. Unknowns without any sensitivity (the
///                frequency of a tone of no amplitude) are left out by themselves.
Score TestScore(const Normal& normal, std::span<const Eigen::Index> tested);

}  // namespace uiclink
