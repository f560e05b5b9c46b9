#include "vehicle/hunting/variance_shares.h"

#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

void Add(const std::string& name, double share, std::vector<VarianceShare>* shares) {
  const auto place = std::ranges::find(*shares, name, &VarianceShare::name);
  if (place != shares->end()) {
    place->share += share;
  } else {
    shares->push_back({name, share});
  }
}

VarianceShares Collect(const SetScatter& scatter, const Eigen::VectorXd& parts) {
  VarianceShares shares{.parameters = {}, .groups = {}, .not_linear = 1 - parts.sum()};
  for (std::size_t i = 0; i < scatter.parameters().size(); ++i) {
    const UncertainParameter& parameter = scatter.parameters()[i];
    const double share = parts[static_cast<Eigen::Index>(i)];
    Add(parameter.is_factor ? parameter.group : parameter.name, share, &shares.parameters);
    Add(parameter.group, share, &shares.groups);
  }
  return shares;
}

}  // namespace

VarianceShares CalcVarianceShares(const SetScatter& scatter, std::span<const double> f, const Eigen::VectorXd& b,
                                  double keep) {
  double mean = 0, variance = 0;
  std::size_t count = 0;
  for (const double value : f) {
    if (!std::isfinite(value)) continue;
    mean += value;
    ++count;
  }
  mean /= static_cast<double>(std::max<std::size_t>(count, 1));
  Eigen::VectorXd covariances = Eigen::VectorXd::Zero(b.size());  // of f and the parameters, times count
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (!std::isfinite(f[i])) continue;
    const double deviation = f[i] - mean;
    variance += deviation * deviation;
    covariances += deviation * (scatter.values().row(static_cast<Eigen::Index>(i)).transpose() - scatter.centre());
  }
  if (!(variance > 0)) return {};
  return Collect(scatter, keep / variance * b.cwiseProduct(covariances));
}

VarianceShares CalcVarianceShares(const SetScatter& scatter, const Eigen::VectorXd& b) {
  const Eigen::VectorXd covariances = scatter.covariance() * b;
  const double variance = b.dot(covariances);
  if (!(variance > 0)) return {};
  return Collect(scatter, b.cwiseProduct(covariances) / variance);
}

double CalcExplainedBy(const Eigen::MatrixXd& C, const Eigen::VectorXd& b, const Eigen::VectorXd& a) {
  const double both = a.dot(C * b), f = b.dot(C * b), g = a.dot(C * a);
  return f > 0 && g > 0 ? both * both / (f * g) : 0;
}

}  // namespace uiclink
