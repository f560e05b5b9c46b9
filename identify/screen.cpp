#include "identify/screen.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace uiclink {

UnknownMap::UnknownMap(const Extension& extension, Sharing sharing, int sliders, std::size_t records, bool own_shapes)
    : levels_(sharing == Sharing::kLink ? 1 : static_cast<Eigen::Index>(records)),
      shape_(2 * (sliders - 1)),
      shapes_(own_shapes ? static_cast<Eigen::Index>(records) : 1),
      shared_(static_cast<Eigen::Index>(extension.shared().size())),
      own_(static_cast<Eigen::Index>(extension.own().size())),
      records_(static_cast<Eigen::Index>(records)),
      size_(3 * levels_ + shape_ * shapes_ + shared_ + (3 + own_) * records_) {}

std::vector<Eigen::Index> UnknownMap::Columns(std::size_t record) const {
  const auto r = static_cast<Eigen::Index>(record);
  std::vector<Eigen::Index> columns;
  const auto add = [&](Eigen::Index first, Eigen::Index size) {
    for (Eigen::Index i = 0; i < size; ++i) columns.push_back(first + i);
  };
  const Eigen::Index common = first_shared() + shared_;
  add(levels_ == 1 ? 0 : 3 * r, 3);
  add(3 * levels_ + (shapes_ == 1 ? 0 : shape_ * r), shape_);
  add(common + (3 + own_) * r, 3);
  add(first_shared(), shared_);
  add(common + (3 + own_) * r + 3, own_);
  return columns;
}

Normal CalcNormal(std::span<const FitData> data, Sharing sharing, const Extension& extension,
                  const ExtendedState& state, std::size_t stride) {
  const UnknownMap map(extension, sharing, CountSliders(state.link.shape), data.size(), !state.link.shapes.empty());
  Normal normal{.gram = Eigen::MatrixXd::Zero(map.size(), map.size()), .gradient = Eigen::VectorXd::Zero(map.size())};
  for (std::size_t r = 0; r < data.size(); ++r) {
    const Linearisation at = LineariseExtended(data[r], extension, state, r, stride);
    const Eigen::MatrixXd gram = at.jacobian.transpose() * at.jacobian;
    const Eigen::VectorXd gradient = at.jacobian.transpose() * at.residuals;
    const std::vector<Eigen::Index> columns = map.Columns(r);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      normal.gradient(columns[i]) += gradient(row);
      for (std::size_t j = 0; j < columns.size(); ++j)
        normal.gram(columns[i], columns[j]) += gram(row, static_cast<Eigen::Index>(j));
    }
    normal.chi2 += at.residuals.squaredNorm();
  }
  return normal;
}

Eigen::MatrixXd InvertDetermined(const Eigen::MatrixXd& matrix, double rounding) {
  Eigen::VectorXd scale = matrix.diagonal().cwiseMax(0).cwiseSqrt();
  for (double& s : scale) s = s > 0 ? 1 / s : 0;
  const Eigen::MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  Eigen::VectorXd inverse = eigen.eigenvalues();
  for (double& value : inverse) value = value > rounding ? 1 / value : 0;
  const Eigen::MatrixXd vectors = scale.asDiagonal() * eigen.eigenvectors();
  return vectors * inverse.asDiagonal() * vectors.transpose();
}

Score TestScore(const Normal& normal, std::span<const Eigen::Index> tested) {
  std::vector<Eigen::Index> visible, others;
  for (Eigen::Index i = 0; i < normal.gram.rows(); ++i) {
    const bool is_tested = std::find(tested.begin(), tested.end(), i) != tested.end();
    if (!is_tested) others.push_back(i);
    if (is_tested && normal.gram(i, i) > 0) visible.push_back(i);
  }
  Score score{.step = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(tested.size()))};
  if (visible.empty()) return score;
  const Eigen::MatrixXd base = normal.gram(others, others);
  const Eigen::MatrixXd cross = normal.gram(others, visible);
  const Eigen::VectorXd base_gradient = normal.gradient(others);
  constexpr double kRounding = 1e-11;
  const Eigen::MatrixXd absorbed = InvertDetermined(base, kRounding) * cross;
  const Eigen::MatrixXd own = normal.gram(visible, visible);
  const Eigen::MatrixXd projected = own - cross.transpose() * absorbed;
  const Eigen::VectorXd gradient = Eigen::VectorXd(normal.gradient(visible)) - absorbed.transpose() * base_gradient;
  const Eigen::VectorXd step = -InvertDetermined(projected, kRounding) * gradient;
  score.statistic = -gradient.dot(step);
  score.visibility = std::sqrt(std::max(0.0, projected.trace() / own.trace()));
  for (std::size_t i = 0; i < visible.size(); ++i) {
    const auto at = std::find(tested.begin(), tested.end(), visible[i]) - tested.begin();
    score.step(at) = step(static_cast<Eigen::Index>(i));
  }
  return score;
}

}  // namespace uiclink
