#include "identify/random_effects.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

namespace uiclink {
namespace {

constexpr int kMaxIterations = 300;
constexpr double kTolerance = 1e-3;  // relative change of a spread at which it is settled: far below its own error

Eigen::MatrixXd Invert(const Eigen::MatrixXd& matrix) {
  return matrix.ldlt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

/// A structure as the expectation step needs it.
struct Structure {
  Eigen::MatrixXd matrix, inverse;  // the inverse on its own subspace
  int rank = 0;
};

Structure MakeStructure(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(matrix);
  Eigen::VectorXd inverse = Eigen::VectorXd::Zero(matrix.rows());
  Structure structure{.matrix = matrix, .inverse = {}, .rank = 0};
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    if (eigen.eigenvalues()(i) < 1e-9 * eigen.eigenvalues().maxCoeff()) continue;
    inverse(i) = 1 / eigen.eigenvalues()(i);
    ++structure.rank;
  }
  structure.inverse = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  return structure;
}

/// Weighted mean for given variances of the scatter.
class WeightedMean {
 public:
  WeightedMean(const std::vector<Eigen::VectorXd>& values, const std::vector<Eigen::MatrixXd>& errors,
               const Eigen::MatrixXd& scatter) {
    const Eigen::Index size = values[0].size();
    Eigen::MatrixXd total = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(size);
    for (std::size_t r = 0; r < values.size(); ++r) {
      weights_.push_back(Invert(errors[r] + scatter));
      total += weights_.back();
      sum += weights_.back() * values[r];
    }
    covariance_ = Invert(total);
    mean_ = covariance_ * sum;
  }

  const Eigen::MatrixXd& weight(std::size_t r) const { return weights_[r]; }
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  const Eigen::VectorXd& mean() const { return mean_; }

 private:
  std::vector<Eigen::MatrixXd> weights_;
  Eigen::MatrixXd covariance_;
  Eigen::VectorXd mean_;
};

}  // namespace

VectorPopulation EstimateVectorPopulation(const std::vector<Eigen::VectorXd>& values,
                                          const std::vector<Eigen::MatrixXd>& errors,
                                          const std::vector<Eigen::MatrixXd>& structures) {
  const Eigen::Index size = values[0].size();
  const auto members = static_cast<double>(values.size());
  std::vector<Structure> groups;
  for (const Eigen::MatrixXd& matrix : structures) groups.push_back(MakeStructure(matrix));
  const auto sum_up = [&](const Eigen::VectorXd& variances) {
    Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t g = 0; g < groups.size(); ++g)
      scatter += variances(static_cast<Eigen::Index>(g)) * groups[g].matrix;
    return scatter;
  };
  // From the variance of the values themselves, which is never too small.
  const WeightedMean plain(values, std::vector<Eigen::MatrixXd>(values.size(), Eigen::MatrixXd::Identity(size, size)),
                           Eigen::MatrixXd::Zero(size, size));
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const Eigen::VectorXd& value : values)
      variances(static_cast<Eigen::Index>(g)) +=
          (value - plain.mean()).dot(groups[g].inverse * (value - plain.mean())) / (groups[g].rank * (members - 1));
  for (int i = 0; i < kMaxIterations; ++i) {
    const Eigen::MatrixXd scatter = sum_up(variances);
    const WeightedMean weighted(values, errors, scatter);
    Eigen::VectorXd next = Eigen::VectorXd::Zero(variances.size());
    for (std::size_t r = 0; r < values.size(); ++r) {
      const Eigen::MatrixXd& weight = weighted.weight(r);
      const Eigen::VectorXd expected = scatter * weight * (values[r] - weighted.mean());
      const Eigen::MatrixXd uncertain =
          scatter - scatter * (weight - weight * weighted.covariance() * weight) * scatter;
      const Eigen::MatrixXd second_moment = expected * expected.transpose() + uncertain;
      for (std::size_t g = 0; g < groups.size(); ++g)
        next(static_cast<Eigen::Index>(g)) += (groups[g].inverse * second_moment).trace() / (groups[g].rank * members);
    }
    const bool settled = ((next - variances).array().abs() <= 2 * kTolerance * variances.array()).all();
    variances = next.cwiseMax(0.0);
    if (settled) break;
  }
  const WeightedMean result(values, errors, sum_up(variances));
  const WeightedMean alone(values, errors, Eigen::MatrixXd::Zero(size, size));
  return {.mean = result.mean(),
          .covariance = result.covariance(),
          .error_covariance = alone.covariance(),
          .spread = variances.cwiseSqrt()};
}

}  // namespace uiclink
