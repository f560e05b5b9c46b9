#include "identify/noise_draws.h"

#include <Eigen/Dense>

namespace uiclink {
namespace {

/// Directions whose share in their column is below this are a combination of the others.
constexpr double kRankThreshold = 1e-9;

/// Orthonormal basis of the columns, whatever their scales.
Eigen::MatrixXd FindBasis(const Eigen::MatrixXd& columns) {
  Eigen::MatrixXd scaled = columns;
  for (Eigen::Index j = 0; j < scaled.cols(); ++j)
    if (const double norm = scaled.col(j).norm(); norm > 0) scaled.col(j) /= norm;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled.rows(), scaled.cols());
  qr.setThreshold(kRankThreshold);
  qr.compute(scaled);
  return qr.householderQ() * Eigen::MatrixXd::Identity(scaled.rows(), qr.rank());
}

}  // namespace

NoiseDraws::NoiseDraws(std::span<const SymptomInput> records, unsigned seed) : random_(seed) {
  Eigen::MatrixXd normal;
  for (const SymptomInput& input : records) {
    Projection projection;
    projection.sigma = input.sigma;
    if (input.own != nullptr) projection.own = FindBasis(*input.own);
    if (input.common != nullptr) {
      projection.common = *input.common;
      if (projection.own.size() > 0)
        projection.common -= projection.own * (projection.own.transpose() * projection.common);
      if (normal.size() == 0) normal.setZero(projection.common.cols(), projection.common.cols());
      normal += projection.common.transpose() * projection.common;
    }
    projections_.push_back(std::move(projection));
    draw_.emplace_back(static_cast<Eigen::Index>(input.size));
  }
  if (normal.size() > 0) common_inverse_ = normal.completeOrthogonalDecomposition().pseudoInverse();
}

const std::vector<Eigen::VectorXd>& NoiseDraws::Next() {
  for (std::size_t i = 0; i < draw_.size(); ++i) {
    for (double& value : draw_[i]) value = normal_(random_);
    const Eigen::MatrixXd& own = projections_[i].own;
    if (own.size() > 0) draw_[i] -= own * (own.transpose() * draw_[i]);
  }
  if (common_inverse_.size() > 0) RemoveCommon();
  for (std::size_t i = 0; i < draw_.size(); ++i) draw_[i] *= projections_[i].sigma;
  return draw_;
}

void NoiseDraws::RemoveCommon() {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(common_inverse_.cols());
  for (std::size_t i = 0; i < draw_.size(); ++i)
    if (projections_[i].common.size() > 0) gradient += projections_[i].common.transpose() * draw_[i];
  const Eigen::VectorXd step = common_inverse_ * gradient;
  for (std::size_t i = 0; i < draw_.size(); ++i)
    if (projections_[i].common.size() > 0) draw_[i] -= projections_[i].common * step;
}

}  // namespace uiclink
