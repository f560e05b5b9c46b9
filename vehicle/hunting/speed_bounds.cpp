#include "vehicle/hunting/speed_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <stdexcept>

#include "model/parallel.h"

namespace uiclink {
namespace {

using Complex = std::complex<double>;

struct Followed {
  Complex lambda;
  bool others_are_stable = true;
};

/// The eigenvalue nearest to `near`.
Followed Follow(const Wagon& wagon, double V, const Complex& near) {
  const std::vector<Complex> eigenvalues = CalcEigenvalues(Linearize(wagon, V));
  const auto distance = [&](const Complex& e) { return std::abs(e - near); };
  Followed followed{.lambda = *std::ranges::min_element(eigenvalues, {}, distance)};
  for (const Complex& e : eigenvalues) {
    const bool itself = e == followed.lambda || e == std::conj(followed.lambda);
    followed.others_are_stable &= itself || !(e.real() > 0);
  }
  return followed;
}

bool IsStable(const Wagon& wagon, double V) { return !(CalcEigenvalues(Linearize(wagon, V)).front().real() > 0); }

bool IsStableBelow(const Wagon& wagon, double V, const CriticalSpeedOptions& options) {
  for (int i = 0; i < options.checked_below; ++i)
    if (!IsStable(wagon, std::lerp(options.from, V, static_cast<double>(i) / options.checked_below))) return false;
  return true;
}

/// By secants; none if they lead nowhere.
std::optional<double> FindBySecants(const Wagon& wagon, const KnownCrossing& known,
                                    const CriticalSpeedOptions& options) {
  constexpr int kMost = 12;
  constexpr double kFirstStep = 1e-3, kLongest = 0.2;  // of the speed
  double V0 = known.V, V1 = known.V * (1 + kFirstStep);
  Followed at0 = Follow(wagon, V0, known.lambda), at1 = Follow(wagon, V1, at0.lambda);
  for (int i = 0; i < kMost; ++i) {
    const double slope = (at1.lambda.real() - at0.lambda.real()) / (V1 - V0);
    if (!(slope > 0)) return std::nullopt;  // grows with speed where it becomes unstable
    const double step = -at1.lambda.real() / slope;
    const double V = V1 + std::clamp(step, -kLongest * V1, kLongest * V1);
    if (std::abs(step) < options.tolerance) return at1.others_are_stable ? std::optional(V) : std::nullopt;
    if (!(V > options.from && V < options.to)) return std::nullopt;
    V0 = V1;
    at0 = at1;
    V1 = V;
    at1 = Follow(wagon, V1, at0.lambda);
  }
  return std::nullopt;
}

/// The first crossing of the whole range.
KnownCrossing FindFirst(const Wagon& wagon, const CriticalSpeedOptions& range) {
  StabilityOptions options;
  options.from = range.from;
  options.to = range.to;
  options.tolerance = range.tolerance;
  options.first_only = true;
  const StabilityResult result = FindCrossings(wagon, options);
  if (result.unstable_at_start > 0) throw std::runtime_error(fmt::format("unstable already at {:g} m/s", range.from));
  if (!result.linear_critical_speed) throw std::runtime_error(fmt::format("stable up to {:g} m/s", range.to));
  return {*result.linear_critical_speed, result.crossings.front().mode.lambda};
}

/// A direction's k + sum k_i as a combination of the parameters of its set.
Eigen::VectorXd StiffnessOf(const SetScatter& scatter, Direction direction) {
  Eigen::VectorXd a = Eigen::VectorXd::Zero(scatter.centre().size());
  for (std::size_t i = 0; i < scatter.parameters().size(); ++i) {
    const UncertainParameter& p = scatter.parameters()[i];
    const bool stiffness = p.symbol.starts_with('k') && p.symbol.find('.') == std::string::npos;
    if (p.direction == direction && !p.is_factor && stiffness) a[static_cast<Eigen::Index>(i)] = 1;
  }
  return a;
}

}  // namespace

double FindCriticalSpeedNear(const Wagon& wagon, const KnownCrossing& known, const CriticalSpeedOptions& options) {
  const std::optional<double> V = FindBySecants(wagon, known, options);
  if (V && IsStableBelow(wagon, *V, options)) return *V;
  return FindFirst(wagon, options).V;
}

Eigen::VectorXd CalcSpeedGradient(const SetScatter& scatter, const Wagon& wagon, const KnownCrossing& known) {
  const double dV = 1e-3 * known.V;  // truncation 1e-6 of the derivative
  const double by_speed = (Follow(wagon, known.V + dV, known.lambda).lambda.real() -
                           Follow(wagon, known.V - dV, known.lambda).lambda.real()) /
                          (2 * dV);
  const Eigen::VectorXd growth = DifferentiateByParameters(scatter, [&](const Eigen::VectorXd& values) {
    return Follow(WithLinks(wagon, scatter.LinksAt(values)), known.V, known.lambda).lambda.real();
  });
  return -growth / by_speed;
}

SpeedBounds CalcSpeedBounds(const SetScatter& scatter, const Wagon& wagon, const CriticalSpeedOptions& range,
                            const PropagateOptions& options) {
  try {
    return CalcSpeedBounds(scatter, wagon, FindFirst(wagon, range), range, options);
  } catch (const std::runtime_error& error) {
    SpeedBounds bounds;
    bounds.speed.name = "linear critical speed";
    bounds.speed.unit = "m/s";
    bounds.speed.nominal_reason = error.what();
    return bounds;
  }
}

SpeedBounds CalcSpeedBounds(const SetScatter& scatter, const Wagon& wagon, const KnownCrossing& known,
                            const CriticalSpeedOptions& range, const PropagateOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  SpeedBounds bounds;
  ScalarBounds& speed = bounds.speed;
  speed.name = "linear critical speed";
  speed.unit = "m/s";
  speed.nominal = known.V;
  if (scatter.empty()) return bounds;
  bounds.gradient = CalcSpeedGradient(scatter, wagon, known);
  speed.values.resize(scatter.size());
  speed.reasons.resize(scatter.size());
  ParallelFor(
      scatter.size(), options.threads,
      [&](std::size_t i) {
        try {
          speed.values[i] = FindCriticalSpeedNear(WithLinks(wagon, scatter.Draw(i)), known, range);
        } catch (const std::exception& error) {
          speed.values[i] = std::numeric_limits<double>::quiet_NaN();
          speed.reasons[i] = error.what();
        }
      },
      [&](std::size_t done) {
        if (options.on_done) options.on_done(done, scatter.size());
      });
  Summarise(&speed);
  AddShares(scatter, bounds.gradient, &speed);
  bounds.by_lateral_stiffness =
      CalcExplainedBy(scatter.covariance(), bounds.gradient, StiffnessOf(scatter, Direction::kLateral));
  bounds.by_longitudinal_stiffness =
      CalcExplainedBy(scatter.covariance(), bounds.gradient, StiffnessOf(scatter, Direction::kLongitudinal));
  bounds.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return bounds;
}

}  // namespace uiclink
