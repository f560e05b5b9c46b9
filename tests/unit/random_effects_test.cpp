#include "identify/random_effects.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd Normal(const MatrixXd& covariance, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  VectorXd z(covariance.rows());
  for (Eigen::Index i = 0; i < z.size(); ++i) z(i) = normal(*random);
  return covariance.llt().matrixL() * z;
}

TEST(RandomEffects, WithoutErrorsIsTheSample) {
  const std::vector<double> x = {1, 2, 3, 4, 5};
  std::vector<VectorXd> values;
  for (const double v : x) values.push_back(VectorXd::Constant(1, v));
  const std::vector<MatrixXd> errors(5, MatrixXd::Constant(1, 1, 1e-12));
  const VectorPopulation p = EstimateVectorPopulation(values, errors, {MatrixXd::Identity(1, 1)});
  EXPECT_NEAR(p.mean(0), 3, 1e-9);
  EXPECT_NEAR(p.spread(0), std::sqrt(2.5), 1e-3 * std::sqrt(2.5));  // the iteration stops at a thousandth
  EXPECT_NEAR(p.covariance(0, 0), 0.5, 2e-3 * 0.5);
  EXPECT_NEAR(p.error_covariance(0, 0), 1e-12 / 5, 1e-20);
}

TEST(RandomEffects, WithoutScatterIsTheWeightedMean) {
  MatrixXd first(2, 2), second(2, 2);
  first << 4, 1.5, 1.5, 1;
  second << 1, -0.5, -0.5, 2;
  const VectorXd a = VectorXd::Constant(2, 0.1), b = VectorXd::Zero(2);  // much closer than their errors
  const VectorPopulation p = EstimateVectorPopulation({a, b}, {first, second}, {MatrixXd::Identity(2, 2)});
  const MatrixXd weights = first.inverse() + second.inverse();
  const VectorXd mean = weights.inverse() * (first.inverse() * a + second.inverse() * b);
  EXPECT_TRUE(p.error_covariance.isApprox(weights.inverse(), 1e-12));
  // The iteration creeps towards zero, so some of the spread is left.
  EXPECT_LT(p.spread(0), 0.2);
  EXPECT_NEAR((p.mean - mean).norm(), 0, 0.02);
}

/// A population like that of shapes: two blocks, each with scatter s^2 (1 + delta_ij), errors that differ from member
/// to member, are correlated and, in one direction, far larger than the scatter.
struct Simulation {
  VectorXd truth = VectorXd::Zero(4);
  MatrixXd stiffness = MatrixXd::Zero(4, 4), friction = MatrixXd::Zero(4, 4);
  std::vector<VectorXd> values;
  std::vector<MatrixXd> errors;

  Simulation(int members, double s, double t, std::mt19937_64* random) {
    truth << -0.2, -0.5, 0.1, 0.2;
    stiffness.topLeftCorner(2, 2) << 2, 1, 1, 2;
    friction.bottomRightCorner(2, 2) << 2, 1, 1, 2;
    std::normal_distribution<double> normal;
    for (int r = 0; r < members; ++r) {
      MatrixXd error = 0.02 * 0.02 * MatrixXd::Identity(4, 4);
      VectorXd poor(4);
      for (Eigen::Index i = 0; i < 4; ++i) poor(i) = normal(*random);
      error += 0.3 * 0.3 * poor * poor.transpose();
      errors.push_back(error);
      values.push_back(truth + Normal(s * s * stiffness + t * t * friction, random) + Normal(error, random));
    }
  }
};

TEST(RandomEffects, FindsMeanAndSpreadOfAPopulation) {
  std::mt19937_64 random(6);
  constexpr int kTrials = 200, kMembers = 10;
  constexpr double kS = 0.05, kT = 0.08;
  double s2 = 0, t2 = 0;
  int inside = 0, better = 0;
  for (int i = 0; i < kTrials; ++i) {
    const Simulation data(kMembers, kS, kT, &random);
    const VectorPopulation p = EstimateVectorPopulation(data.values, data.errors, {data.stiffness, data.friction});
    s2 += p.spread(0) * p.spread(0) / kTrials;
    t2 += p.spread(1) * p.spread(1) / kTrials;
    VectorXd plain = VectorXd::Zero(4);
    for (const VectorXd& value : data.values) plain += value / kMembers;
    const VectorXd off = p.mean - data.truth;
    better += off.norm() < (plain - data.truth).norm() ? 1 : 0;
    inside += off.dot(p.covariance.ldlt().solve(off)) < 9.488 ? 1 : 0;  // chi-square, 95 %, 4 degrees of freedom
    EXPECT_GE((p.covariance - p.error_covariance).diagonal().minCoeff(), 0);
  }
  // A variance from some 16 values has a relative deviation of a third, the mean of 200 trials 2.5 %; three of these.
  EXPECT_NEAR(s2, kS * kS, 0.08 * kS * kS);
  EXPECT_NEAR(t2, kT * kT, 0.08 * kT * kT);
  // 190 with a deviation of 3, less what the uncertain spreads cost (the bounds allow for it by Student's
  // distribution).
  EXPECT_GE(inside, 175);
  EXPECT_GE(better, 180);  // the plain mean does not know which direction a member measured poorly
}

}  // namespace
}  // namespace uiclink
