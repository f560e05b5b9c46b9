#include "identify/link_coordinates.h"

#include <algorithm>
#include <cmath>

namespace uiclink {
namespace {

constexpr int kLevels = 3;

std::vector<double> Shares(const double* logs, int n) {
  std::vector<double> shares(static_cast<std::size_t>(n));
  double largest = 0, sum = 0;
  for (int i = 1; i < n; ++i) largest = std::max(largest, logs[i - 1]);
  for (int i = 0; i < n; ++i) {
    shares[static_cast<std::size_t>(i)] = std::exp((i == 0 ? 0.0 : logs[i - 1]) - largest);
    sum += shares[static_cast<std::size_t>(i)];
  }
  for (double& share : shares) share /= sum;
  return shares;
}

struct Sums {
  double stiffness = 0;
  double friction = 0;
};

Sums SumSliders(const Oscillator<double>& link) {
  Sums sums;
  for (const Slider<double>& s : link.sliders()) {
    sums.stiffness += s.k;
    sums.friction += s.T0;
  }
  return sums;
}

}  // namespace

int CountSliders(const Shape& shape) { return static_cast<int>(shape.size() / 2) + 1; }

Oscillator<double> ToOscillator(const Levels& levels, const Shape& shape, double g) {
  return ToOscillator(levels.data(), shape.data(), CountSliders(shape), g);
}

Oscillator<double> ToOscillator(const double* levels, const double* shape, int n, double g) {
  const std::vector<double> stiffness = Shares(shape, n);
  const std::vector<double> friction = Shares(shape + (n - 1), n);
  Oscillator<double> link;
  link.g = g;
  link.k = std::exp(levels[0]);
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
    link.Add({.k = std::exp(levels[1]) * stiffness[i], .T0 = std::exp(levels[2]) * friction[i]});
  return link;
}

void FromOscillator(const Oscillator<double>& oscillator, Levels* levels, Shape* shape) {
  const std::size_t n = oscillator.sliders().size();
  const Sums sums = SumSliders(oscillator);
  *levels = {std::log(oscillator.k), std::log(sums.stiffness), std::log(sums.friction)};
  shape->assign(2 * (n - 1), 0.0);
  for (std::size_t i = 1; i < n; ++i) {
    (*shape)[i - 1] = std::log(oscillator.sliders()[i].k / oscillator.sliders()[0].k);
    (*shape)[n - 1 + i - 1] = std::log(oscillator.sliders()[i].T0 / oscillator.sliders()[0].T0);
  }
}

Eigen::MatrixXd CalcNaturalDerivatives(const Oscillator<double>& link) {
  const int n = link.size();
  const Sums sums = SumSliders(link);
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(1 + 2 * n, kLevels + 2 * (n - 1));
  d(0, 0) = link.k;
  for (int i = 0; i < n; ++i) {
    const Slider<double>& s = link.sliders()[static_cast<std::size_t>(i)];
    d(1 + i, 1) = s.k;
    d(1 + n + i, 2) = s.T0;
    for (int j = 1; j < n; ++j) {
      const Slider<double>& other = link.sliders()[static_cast<std::size_t>(j)];
      d(1 + i, kLevels + j - 1) = s.k * ((i == j ? 1.0 : 0.0) - other.k / sums.stiffness);
      d(1 + n + i, kLevels + n - 1 + j - 1) = s.T0 * ((i == j ? 1.0 : 0.0) - other.T0 / sums.friction);
    }
  }
  return d;
}

int CountQuantities(int sliders) { return 2 * sliders + 3; }

double CalcQuantity(const Oscillator<double>& link, int quantity) {
  const int n = link.size();
  const Sums sums = SumSliders(link);
  if (quantity == SumOfStiffness(n)) return sums.stiffness;
  if (quantity == SumOfFriction(n)) return sums.friction;
  const int of_share = quantity - CountQuantities(n) + 1;
  if (of_share > 0) return CalcQuantity(link, of_share) / (of_share <= n ? sums.stiffness : sums.friction);
  if (quantity == 0) return link.k;
  return quantity <= n ? link.sliders()[static_cast<std::size_t>(quantity - 1)].k
                       : link.sliders()[static_cast<std::size_t>(quantity - 1 - n)].T0;
}

Eigen::RowVectorXd CalcLogGradient(const Oscillator<double>& link, int quantity) {
  const int n = link.size();
  const int of_share = quantity - CountQuantities(n) + 1;
  if (of_share > 0)
    return CalcLogGradient(link, of_share) -
           CalcLogGradient(link, of_share <= n ? SumOfStiffness(n) : SumOfFriction(n));
  Eigen::RowVectorXd gradient = Eigen::RowVectorXd::Zero(kLevels + 2 * (n - 1));
  if (quantity == SumOfStiffness(n)) {
    gradient(1) = 1;
  } else if (quantity == SumOfFriction(n)) {
    gradient(2) = 1;
  } else {
    gradient = CalcNaturalDerivatives(link).row(quantity) / CalcQuantity(link, quantity);
  }
  return gradient;
}

std::string QuantityName(int sliders, int quantity) {
  if (quantity == SumOfStiffness(sliders)) return "sum_ki";
  if (quantity == SumOfFriction(sliders)) return "sum_T0i";
  return ParameterSymbols(sliders)[static_cast<std::size_t>(quantity)];
}

}  // namespace uiclink
