#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace uiclink::digitise {

/// Cubic B-spline on equally spaced knots.
class UniformSpline {
 public:
  struct Basis {
    std::size_t first = 0;          ///< index of the first of four coefficients
    std::array<double, 4> value{};  ///< of the four basis functions
    std::array<double, 4> slope{};  ///< their derivatives by x
  };

  UniformSpline() = default;
  /// Over [first, last] with knots about `spacing` apart; all coefficients 0.
  UniformSpline(double first, double last, double spacing)
      : first_(first), pieces_(std::max(4.0, std::ceil((last - first) / spacing))) {
    spacing_ = (last - first) / pieces_;
    coefficients.resize(static_cast<std::size_t>(pieces_) + 3);
  }

  Basis At(double x) const {
    const double place = std::clamp((x - first_) / spacing_, 0.0, pieces_);
    const double piece = std::min(std::floor(place), pieces_ - 1);
    const double u = place - piece, v = 1 - u;
    Basis basis{.first = static_cast<std::size_t>(piece)};
    basis.value = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6,
                   u * u * u / 6};
    basis.slope = {-v * v / (2 * spacing_), (3 * u * u - 4 * u) / (2 * spacing_), (4 * v - 3 * v * v) / (2 * spacing_),
                   u * u / (2 * spacing_)};
    return basis;
  }
  double Value(const Basis& basis) const { return Sum(basis.first, basis.value); }
  double Slope(const Basis& basis) const { return Sum(basis.first, basis.slope); }
  double operator()(double x) const { return Value(At(x)); }

  double first() const { return first_; }
  double last() const { return first_ + spacing_ * pieces_; }
  double spacing() const { return spacing_; }

  std::vector<double> coefficients;

 private:
  double Sum(std::size_t at, const std::array<double, 4>& factors) const {
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i) sum += factors[i] * coefficients[at + i];
    return sum;
  }

  double first_ = 0;
  double pieces_ = 1;
  double spacing_ = 1;
};

}  // namespace uiclink::digitise
