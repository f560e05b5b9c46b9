#include "tests/support/chaotic_flows.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace uiclink {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class SmoothFlow : public Flow {
 public:
  using Rate = std::function<VectorXd(const VectorXd& z, double lambda)>;
  using Jacobian = std::function<MatrixXd(const VectorXd& z, double lambda)>;

  SmoothFlow(int size, double step, Rate rate, Jacobian jacobian)
      : step_(step), scales_(VectorXd::Ones(size)), rate_(std::move(rate)), jacobian_(std::move(jacobian)) {}

  int size() const override { return static_cast<int>(scales_.size()); }
  const VectorXd& scales() const override { return scales_; }
  const std::vector<std::string>& watched() const override {
    static const std::vector<std::string> names{"x"};
    return names;
  }

  Passage Pass(const VectorXd& start, double T, double lambda, Derivatives wanted) override {
    const auto steps = static_cast<int>(std::ceil(T / step_ - 1e-9));
    const double h = T / steps;
    // The state, and beside it, if wanted, its derivative by the start.
    MatrixXd z = start;
    if (wanted == Derivatives::kAll) {
      z.resize(size(), 1 + size());
      z << start, MatrixXd::Identity(size(), size());
    }
    Passage passage;
    passage.least = passage.greatest = z.topLeftCorner(1, 1);
    for (int i = 0; i < steps; ++i) {
      const MatrixXd k1 = RateOfAll(z, lambda), k2 = RateOfAll(z + 0.5 * h * k1, lambda);
      const MatrixXd k3 = RateOfAll(z + 0.5 * h * k2, lambda), k4 = RateOfAll(z + h * k3, lambda);
      z += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      passage.least[0] = std::min(passage.least[0], z(0, 0));
      passage.greatest[0] = std::max(passage.greatest[0], z(0, 0));
    }
    passage.end = z.col(0);
    passage.rate = rate_(passage.end, lambda);
    passage.by_start = z.rightCols(z.cols() - 1);
    return passage;
  }

 private:
  MatrixXd RateOfAll(const MatrixXd& z, double lambda) const {
    MatrixXd rate(z.rows(), z.cols());
    rate.col(0) = rate_(z.col(0), lambda);
    if (z.cols() > 1) rate.rightCols(z.cols() - 1) = jacobian_(z.col(0), lambda) * z.rightCols(z.cols() - 1);
    return rate;
  }

  double step_;
  VectorXd scales_;
  Rate rate_;
  Jacobian jacobian_;
};

}  // namespace

std::unique_ptr<Flow> MakeLorenz() {
  constexpr double sigma = 10, beta = 8.0 / 3;
  return std::make_unique<SmoothFlow>(
      3, 0.01,
      [](const VectorXd& z, double rho) {
        return VectorXd{{sigma * (z[1] - z[0]), z[0] * (rho - z[2]) - z[1], z[0] * z[1] - beta * z[2]}};
      },
      [](const VectorXd& z, double rho) {
        return MatrixXd{{-sigma, sigma, 0}, {rho - z[2], -1, -z[0]}, {z[1], z[0], -beta}};
      });
}

std::unique_ptr<Flow> MakeRoessler() {
  constexpr double a = 0.2, b = 0.2;
  return std::make_unique<SmoothFlow>(
      3, 0.05,
      [](const VectorXd& z, double c) {
        return VectorXd{{-z[1] - z[2], z[0] + a * z[1], b + z[2] * (z[0] - c)}};
      },
      [](const VectorXd& z, double c) {
        return MatrixXd{{0, -1, -1}, {1, a, 0}, {z[2], 0, z[0] - c}};
      });
}

std::unique_ptr<Flow> MakeSmoothVanDerPol() {
  return std::make_unique<SmoothFlow>(
      2, 0.02,
      [](const VectorXd& z, double mu) {
        return VectorXd{{z[1], mu * (1 - z[0] * z[0]) * z[1] - z[0]}};
      },
      [](const VectorXd& z, double mu) {
        return MatrixXd{{0, 1}, {-2 * mu * z[0] * z[1] - 1, mu * (1 - z[0] * z[0])}};
      });
}

std::unique_ptr<Flow> MakeDampedOscillator() {
  return std::make_unique<SmoothFlow>(
      2, 0.01,
      [](const VectorXd& z, double zeta) {
        return VectorXd{{z[1], -z[0] - 2 * zeta * z[1]}};
      },
      [](const VectorXd&, double zeta) {
        return MatrixXd{{0, 1}, {-1, -2 * zeta}};
      });
}

}  // namespace uiclink
