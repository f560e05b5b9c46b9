#include "identify/significance.h"

#include <cmath>
#include <numbers>

#include "identify/statistics.h"

namespace uiclink {
namespace {

constexpr double kSmallestTail = 1e-280;  // above the denormal numbers

/// log P(|z| > x), x >= 0.
double CalcLogNormalTails(double x) {
  if (x < 30) return std::log(std::erfc(x / std::numbers::sqrt2));
  return -0.5 * x * x - std::log(x * std::sqrt(std::numbers::pi / 2)) + std::log1p(-1 / (x * x));
}

}  // namespace

double CalcLogChiSquareTail(double x, double dof) {
  if (!(x > 0)) return 0;
  const double tail = CalcChiSquareTail(x, dof);
  if (tail > kSmallestTail) return std::log(tail);
  const double a = 0.5 * dof, h = 0.5 * x;
  // Gamma(a, h) ~ h^(a-1) e^-h / (1 - (a-1)/h), h >> a.
  return -h + (a - 1) * std::log(h) - std::lgamma(a) - std::log1p(-(a - 1) / h);
}

double CalcNormalEquivalent(double log_p) {
  if (!(log_p < 0)) return 0;
  double low = 0, high = 1;
  while (CalcLogNormalTails(high) > log_p) high *= 2;
  for (int i = 0; i < 60; ++i) {  // halving to the last bit
    const double middle = 0.5 * (low + high);
    (CalcLogNormalTails(middle) > log_p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace uiclink
