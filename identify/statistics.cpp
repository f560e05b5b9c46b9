#include "identify/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <unsupported/Eigen/SpecialFunctions>

namespace uiclink {
namespace {

constexpr int kWhitenessLags =
    20;  // a tenth of a second at 200 Hz: far below a period, where missing physics shows first
constexpr double kConfidence = 0.95;

/// P(|t| > x) for a Student variable.
double StudentTails(double x, double dof) {
  if (std::isinf(dof)) return std::erfc(x / std::sqrt(2.0));
  return Eigen::numext::betainc(0.5 * dof, 0.5, dof / (dof + x * x));
}

double Mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// sum (x_i - mean)(x_{i+lag} - mean)
double LaggedSum(std::span<const double> x, double mean, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = 0; i + lag < x.size(); ++i) sum += (x[i] - mean) * (x[i + lag] - mean);
  return sum;
}

struct Weighted {
  double mean = 0, weights = 0, squares = 0;
};

Weighted CalcWeighted(std::span<const double> values, std::span<const double> errors, double variance) {
  Weighted result;
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double weight = 1 / (errors[i] * errors[i] + variance);
    result.weights += weight;
    sum += weight * values[i];
  }
  result.mean = sum / result.weights;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double d = values[i] - result.mean;
    result.squares += d * d / (errors[i] * errors[i] + variance);
  }
  return result;
}

}  // namespace

double CalcChiSquareTail(double x, double dof) {
  if (!(x > 0)) return 1;
  return Eigen::numext::igammac(0.5 * dof, 0.5 * x);
}

double CalcStudentBound(double confidence, double dof) {
  double low = 0, high = 1;
  while (StudentTails(high, dof) > 1 - confidence) high *= 2;
  for (int i = 0; i < 60; ++i) {  // halving to the last bit
    const double middle = 0.5 * (low + high);
    (StudentTails(middle, dof) > 1 - confidence ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Whiteness TestWhiteness(std::span<const double> residuals) {
  Whiteness result;
  const std::size_t n = residuals.size();
  result.lags = static_cast<int>(std::min<std::size_t>(kWhitenessLags, n / 4));
  const double mean = Mean(residuals);
  const double variance = LaggedSum(residuals, mean, 0);
  if (!(variance > 0) || result.lags == 0) return result;
  for (std::size_t lag = 1; lag <= static_cast<std::size_t>(result.lags); ++lag) {
    const double rho = LaggedSum(residuals, mean, lag) / variance;
    result.statistic += rho * rho / static_cast<double>(n - lag);
  }
  result.statistic *= static_cast<double>(n) * static_cast<double>(n + 2);
  result.p_value = CalcChiSquareTail(result.statistic, result.lags);
  return result;
}

double CalcEffectiveSize(std::span<const double> residuals) {
  const auto n = static_cast<double>(residuals.size());
  const double mean = Mean(residuals);
  const double variance = LaggedSum(residuals, mean, 0);
  if (!(variance > 0)) return n;
  double sum = 1;
  for (std::size_t lag = 1; lag < residuals.size() / 2; ++lag) {
    const double rho = LaggedSum(residuals, mean, lag) / variance;
    if (rho <= 0) break;
    sum += 2 * rho;
  }
  return std::clamp(n / sum, 1.0, n);
}

Population EstimatePopulation(std::span<const double> values, std::span<const double> errors) {
  const auto n = static_cast<double>(values.size());
  if (values.size() == 1) {
    const double bound = CalcStudentBound(kConfidence, std::numeric_limits<double>::infinity());
    return {.mean = values[0], .std = errors[0], .spread = 0, .half_width = bound * errors[0]};
  }
  double variance = 0;
  if (CalcWeighted(values, errors, 0).squares > n - 1) {
    const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
    double low = 0, high = (*largest - *smallest) * (*largest - *smallest);  // above any between-member variance
    for (int i = 0; i < 100; ++i) {
      variance = 0.5 * (low + high);
      (CalcWeighted(values, errors, variance).squares > n - 1 ? low : high) = variance;
    }
  }
  const Weighted fit = CalcWeighted(values, errors, variance);
  Population result;
  result.mean = fit.mean;
  result.spread = std::sqrt(variance);
  // Hartung and Knapp's variance, never below the one that the errors alone give.
  result.std = std::sqrt(std::max(1.0, fit.squares / (n - 1)) / fit.weights);
  result.half_width = CalcStudentBound(kConfidence, n - 1) * result.std;
  return result;
}

}  // namespace uiclink
