#include "identify/link_coordinates.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uiclink {
namespace {

constexpr int kLevels = 3;

/// A coordinate, the number-th of (levels, shape).
double SeedCoordinate(double value, int /*number*/, double /*type*/) { return value; }
template <int N>
Dual<N> SeedCoordinate(double value, int number, const Dual<N>& /*type*/) {
  return Dual<N>(value, number);
}

/// Shares exp(u_i) / sum exp(u_j) of n sliders, u_1 = 0; u_2 is coordinate `first`.
template <typename T>
std::array<T, kMaxFittedSliders> CalcShares(const double* logs, int n, int first) {
  using std::exp;
  std::array<T, kMaxFittedSliders> shares;
  double largest = 0;
  for (int i = 1; i < n; ++i) largest = std::max(largest, logs[i - 1]);
  T sum(0);
  for (int i = 0; i < n; ++i) {
    const T log = i == 0 ? T(0) : SeedCoordinate(logs[i - 1], first + i - 1, T());
    sum += shares[static_cast<std::size_t>(i)] = exp(T(log - largest));
  }
  for (int i = 0; i < n; ++i) shares[static_cast<std::size_t>(i)] /= sum;
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

template <typename T>
Oscillator<T> ToOscillator(const double* levels, const double* shape, int n, double g) {
  using std::exp;
  Oscillator<T> link;
  link.g = g;
  link.k = exp(SeedCoordinate(levels[0], 0, T()));
  const T stiffness = exp(SeedCoordinate(levels[1], 1, T())), friction = exp(SeedCoordinate(levels[2], 2, T()));
  if (n == 1) {
    link.Add({.k = stiffness, .T0 = friction});
    return link;
  }
  const auto k = CalcShares<T>(shape, n, kLevels), T0 = CalcShares<T>(shape + (n - 1), n, kLevels + n - 1);
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i)
    link.Add({.k = stiffness * k[i], .T0 = friction * T0[i]});
  return link;
}
template Oscillator<double> ToOscillator(const double*, const double*, int, double);
template Oscillator<Dual<6>> ToOscillator(const double*, const double*, int, double);
template Oscillator<Dual<8>> ToOscillator(const double*, const double*, int, double);
template Oscillator<Dual<12>> ToOscillator(const double*, const double*, int, double);
template Oscillator<Dual<16>> ToOscillator(const double*, const double*, int, double);

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
