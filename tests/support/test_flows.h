#pragma once

#include <ceres/jet.h>

#include <Eigen/Core>
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/flow.h"

namespace uiclink {

/// dz/dt = rate(t, z), a column of z for the state and one for each derivative that goes with it.
using MatrixRate = std::function<Eigen::MatrixXd(double t, const Eigen::MatrixXd& z)>;

/// One step of the modified midpoint rule, extrapolated to order 16 (Gragg, Bulirsch, Stoer).
/// @param error  null, or takes what the last extrapolation changed in the first column
Eigen::MatrixXd ExtrapolatedStep(const MatrixRate& rate, double t, const Eigen::MatrixXd& z, double h,
                                 Eigen::VectorXd* error = nullptr);

/// A smooth system as a flow; by_start and by_parameter by the variational equations on the same steps. The error of a
/// step is kept below `tolerance` in units of the scales.
class SmoothFlow : public Flow {
 public:
  struct Model {
    Eigen::VectorXd scales;
    std::vector<int> watched;  ///< components
    std::function<Eigen::VectorXd(double t, const Eigen::VectorXd& z, double lambda)> rate;
    /// By z and by lambda, n x (n + 1).
    std::function<Eigen::MatrixXd(double t, const Eigen::VectorXd& z, double lambda)> jacobian;
    /// Of the excitation and its derivative by lambda; null without.
    std::function<std::pair<double, double>(double lambda)> forced_period;
    /// Change their sign where the rate has a kink: steps end there. Null without.
    std::function<Eigen::VectorXd(const Eigen::VectorXd& z)> kinks;
    double tolerance = 1e-13;
  };

  explicit SmoothFlow(Model model);
  int size() const override { return static_cast<int>(model_.scales.size()); }
  const Eigen::VectorXd& scales() const override { return model_.scales; }
  const std::vector<std::string>& watched() const override { return names_; }
  std::optional<double> ForcedPeriod(double lambda) const override;
  Passage Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) override;

 private:
  void Watch(const MatrixRate& rate, double t, double h, const Eigen::MatrixXd& before, const Eigen::MatrixXd& after,
             Passage* passage) const;
  double FirstKink(const MatrixRate& rate, double t, double h, const Eigen::MatrixXd& before,
                   const Eigen::MatrixXd& after) const;

  Model model_;
  std::vector<std::string> names_;
};

/// The model of a right-hand side that is written once for all scalars:  f(t, z, lambda, rate).
template <int N, typename F>
SmoothFlow::Model MakeModel(F f) {
  SmoothFlow::Model model;
  model.scales = Eigen::VectorXd::Ones(N);
  model.watched = {0};
  model.rate = [f](double t, const Eigen::VectorXd& z, double lambda) {
    Eigen::VectorXd rate(N);
    f(t, z.data(), lambda, rate.data());
    return rate;
  };
  model.jacobian = [f](double t, const Eigen::VectorXd& z, double lambda) {
    using Dual = ceres::Jet<double, N + 1>;
    std::array<Dual, N> dual, rate;
    for (int i = 0; i < N; ++i) dual[static_cast<std::size_t>(i)] = Dual(z[i], i);
    f(t, dual.data(), Dual(lambda, N), rate.data());
    Eigen::MatrixXd jacobian(N, N + 1);
    for (int i = 0; i < N; ++i) jacobian.row(i) = rate[static_cast<std::size_t>(i)].v.transpose();
    return jacobian;
  };
  return model;
}

/// An oscillator with one dry-friction element (Jenkins) under a harmonic force; the parameter is its frequency w:
///   x'' + 2 zeta x' + k0 x + k3 x^3 + k1 (x - p) = force cos(w t),
/// p holds the place where the element is relaxed: constant while it sticks, p' = x' while it slides, which it does at
/// |k1 (x - p)| = T0. State (x, x', p); watched: x.
struct SliderOscillator {
  double zeta = 0.02, k0 = 1, k1 = 1, k3 = 0, T0 = 0.5, force = 0.3;
};

class SliderFlow : public Flow {
 public:
  explicit SliderFlow(const SliderOscillator& oscillator);
  int size() const override { return 3; }
  const Eigen::VectorXd& scales() const override { return scales_; }
  const std::vector<std::string>& watched() const override { return names_; }
  std::optional<double> ForcedPeriod(double lambda) const override;
  Passage Pass(const Eigen::VectorXd& start, double T, double lambda, Derivatives wanted) override;
  void Follow(const Eigen::VectorXd& from, const std::vector<int>& slaved, Eigen::VectorXd* state) const override;

 private:
  SliderOscillator oscillator_;
  Eigen::VectorXd scales_ = Eigen::VectorXd::Ones(3);
  std::vector<std::string> names_{"x"};
};

}  // namespace uiclink
