#include "vehicle/hunting/propagation.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <unsupported/Eigen/SpecialFunctions>

#include "model/parallel.h"

namespace uiclink {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLow = 0.025, kHigh = 0.975;

std::vector<double> FiniteValues(const ScalarBounds& bounds) {
  std::vector<double> values;
  for (const double value : bounds.values)
    if (std::isfinite(value)) values.push_back(value);
  return values;
}

double Quantile(const std::vector<double>& sorted, double p) {
  const double place = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], place - static_cast<double>(below));
}

/// Maritz and Jarrett 1978: the standard deviation of the order statistic under resampling, with its beta weights.
double QuantileError(const std::vector<double>& sorted, double p) {
  const auto n = static_cast<double>(sorted.size());
  const double a = p * (n + 1), b = (1 - p) * (n + 1);
  double mean = 0, square = 0, before = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double upto = i + 1 < sorted.size() ? Eigen::numext::betainc(a, b, static_cast<double>(i + 1) / n) : 1.0;
    const double deviation = sorted[i] - sorted.front();
    mean += (upto - before) * deviation;
    square += (upto - before) * deviation * deviation;
    before = upto;
  }
  return std::sqrt(std::max(square - mean * mean, 0.0));
}

Sampled QuantileWithError(const std::vector<double>& sorted, double p) {
  return {Quantile(sorted, p), QuantileError(sorted, p)};
}

/// Draws with a value: deviations of the parameters in standard deviations, and of the scalar.
struct Regression {
  Eigen::MatrixXd x;
  Eigen::VectorXd y;
  Eigen::VectorXd scale;  ///< standard deviation of each parameter; 1 where it does not vary
};

Regression Collect(const SetScatter& scatter, const ScalarBounds& bounds) {
  const Eigen::Index n = scatter.centre().size();
  Regression r{Eigen::MatrixXd(static_cast<Eigen::Index>(bounds.values.size() - bounds.failed), n), {}, {}};
  r.y.resize(r.x.rows());
  r.scale = scatter.covariance().diagonal().cwiseSqrt().unaryExpr([](double s) { return s > 0 ? s : 1.0; });
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < bounds.values.size(); ++i) {
    if (!std::isfinite(bounds.values[i])) continue;
    r.x.row(row) = (scatter.values().row(static_cast<Eigen::Index>(i)).transpose() - scatter.centre())
                       .cwiseQuotient(r.scale)
                       .transpose();
    r.y[row++] = bounds.values[i];
  }
  r.x.rowwise() -= r.x.colwise().mean().eval();
  r.y.array() -= r.y.mean();
  return r;
}

/// Runs one wagon; what goes wrong is told in `reason`, the values are then none.
std::vector<double> Run(const Wagon& wagon, std::size_t size, const WagonScalars& function, std::string* reason) {
  try {
    std::vector<double> values = function(wagon);
    values.resize(size, kNone);
    return values;
  } catch (const std::exception& error) {
    *reason = error.what();
    return std::vector<double>(size, kNone);
  }
}

/// The wagon of a draw may be none either (an effect's own rules).
std::vector<double> RunDraw(const SetScatter& scatter, const Wagon& wagon, std::size_t i, std::size_t size,
                            const WagonScalars& function, std::string* reason) {
  try {
    return Run(WithLinks(wagon, scatter.Draw(i)), size, function, reason);
  } catch (const std::exception& error) {
    *reason = error.what();
    return std::vector<double>(size, kNone);
  }
}

std::string ReasonOf(double value, const std::string& reason) {
  if (std::isfinite(value)) return {};
  return reason.empty() ? "there is none" : reason;
}

}  // namespace

Eigen::VectorXd DifferentiateByParameters(const SetScatter& scatter,
                                          const std::function<double(const Eigen::VectorXd& values)>& function) {
  constexpr double kRelativeStep = 1e-3;  // truncation 1e-6 of the derivative
  const Eigen::VectorXd& centre = scatter.centre();
  std::optional<double> here;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(centre.size());
  for (Eigen::Index i = 0; i < gradient.size(); ++i) {
    const UncertainParameter& parameter = scatter.parameters()[static_cast<std::size_t>(i)];
    const double step = kRelativeStep * (centre[i] != 0 ? std::abs(centre[i]) : std::sqrt(scatter.covariance()(i, i)));
    if (!(step > 0)) continue;  // neither a value nor an uncertainty
    const auto at = [&](double value) {
      Eigen::VectorXd values = centre;
      values[i] = value;
      return function(values);
    };
    const bool up = centre[i] + step <= parameter.high, down = centre[i] - step >= parameter.low;
    if (!up && !down)
      throw std::runtime_error(fmt::format("{} cannot be changed without leaving its bounds", parameter.name));
    if (!(up && down) && !here) here = function(centre);
    const double above = up ? at(centre[i] + step) : *here, below = down ? at(centre[i] - step) : *here;
    gradient[i] = (above - below) / (up && down ? 2 * step : step);
  }
  return gradient;
}

void Summarise(ScalarBounds* bounds) {
  std::vector<double> values = FiniteValues(*bounds);
  bounds->failed = bounds->values.size() - values.size();
  if (values.empty()) return;
  std::ranges::sort(values);
  const auto n = static_cast<double>(values.size());
  double sum = 0, squares = 0, fourth = 0;
  for (const double value : values) sum += value;
  bounds->mean.value = sum / n;
  for (const double value : values) {
    const double square = (value - bounds->mean.value) * (value - bounds->mean.value);
    squares += square;
    fourth += square * square;
  }
  const double variance = n > 1 ? squares / (n - 1) : 0;
  bounds->std.value = std::sqrt(variance);
  bounds->mean.error = bounds->std.value / std::sqrt(n);
  // var(s^2) = (m4 - m2^2)/n, and half of it relative to s^2 for s.
  if (variance > 0)
    bounds->std.error = std::sqrt(std::max(fourth / n - variance * variance, 0.0) / n) / (2 * bounds->std.value);
  bounds->median = Quantile(values, 0.5);
  bounds->low = QuantileWithError(values, kLow);
  bounds->high = QuantileWithError(values, kHigh);
}

void AddShares(const SetScatter& scatter, ScalarBounds* bounds) {
  const std::size_t parameters = scatter.parameters().size(), kept = bounds->values.size() - bounds->failed;
  if (kept < 3 * parameters + 3) {
    bounds->shares_reason = fmt::format("{} draws with a value are too few for {} parameters", kept, parameters);
    return;
  }
  const Regression r = Collect(scatter, *bounds);
  const double total = r.y.squaredNorm();
  if (!(total > 0)) {
    bounds->shares_reason = "it does not vary";
    return;
  }
  const Eigen::VectorXd b = r.x.completeOrthogonalDecomposition().solve(r.y);
  // Chance alone explains one part in n for each parameter (adjusted R^2).
  const double rest = (r.y - r.x * b).squaredNorm() / total;
  const auto n = static_cast<double>(kept), p = static_cast<double>(parameters);
  const double adjusted = std::max(0.0, 1 - rest * (n - 1) / (n - 1 - p));
  bounds->shares =
      CalcVarianceShares(scatter, bounds->values, b.cwiseQuotient(r.scale), rest < 1 ? adjusted / (1 - rest) : 0);
}

void AddShares(const SetScatter& scatter, const Eigen::VectorXd& gradient, ScalarBounds* bounds) {
  if (bounds->nominal) {
    const double half = 1.96 * std::sqrt(std::max(0.0, gradient.dot(scatter.covariance() * gradient)));
    bounds->linear_low = *bounds->nominal - half;
    bounds->linear_high = *bounds->nominal + half;
  }
  if (!(gradient.dot(scatter.covariance() * gradient) > 0)) {
    bounds->shares_reason = "it does not vary";
    return;
  }
  const bool few = bounds->values.size() < bounds->failed + 2;
  bounds->shares = few ? CalcVarianceShares(scatter, gradient) : CalcVarianceShares(scatter, bounds->values, gradient);
}

std::vector<ScalarBounds> PropagateScalars(const SetScatter& scatter, const Wagon& wagon,
                                           const std::vector<Asked>& asked, const WagonScalars& function,
                                           const PropagateOptions& options) {
  const std::size_t draws = scatter.empty() ? 0 : scatter.size();
  std::vector<std::vector<double>> values(draws + 1);  // the nominal wagon first
  std::vector<std::string> reasons(draws + 1);
  ParallelFor(
      draws + 1, options.threads,
      [&](std::size_t i) {
        values[i] = i == 0 ? Run(wagon, asked.size(), function, &reasons[i])
                           : RunDraw(scatter, wagon, i - 1, asked.size(), function, &reasons[i]);
      },
      [&](std::size_t done) {
        if (options.on_done) options.on_done(done, draws + 1);
      });
  std::vector<ScalarBounds> all;
  for (std::size_t k = 0; k < asked.size(); ++k) {
    ScalarBounds bounds;
    bounds.name = asked[k].name;
    bounds.unit = asked[k].unit;
    if (std::isfinite(values[0][k])) bounds.nominal = values[0][k];
    bounds.nominal_reason = ReasonOf(values[0][k], reasons[0]);
    for (std::size_t i = 1; i <= draws; ++i) {
      bounds.values.push_back(values[i][k]);
      bounds.reasons.push_back(ReasonOf(values[i][k], reasons[i]));
    }
    Summarise(&bounds);
    if (bounds.exists()) AddShares(scatter, &bounds);
    all.push_back(std::move(bounds));
  }
  return all;
}

ScalarBounds PropagateScalar(const std::string& name, const std::string& unit,
                             const std::function<double(const Wagon&)>& function, const SetScatter& scatter,
                             const Wagon& wagon, const PropagateOptions& options) {
  const auto one = [&](const Wagon& at) { return std::vector{function(at)}; };
  return PropagateScalars(scatter, wagon, {{name, unit}}, one, options).front();
}

}  // namespace uiclink
