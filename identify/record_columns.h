#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

#include "identify/fit_problem.h"
#include "model/event_solver.h"
#include "model/trajectory.h"

namespace uiclink {

/// Times of the first `size` samples of a fit since t0 [s]; irregular ones are kept in `scratch`.
inline SampleTimes TimesSince(const FitData& data, std::size_t size, double t0, std::vector<double>* scratch) {
  const std::vector<double>& t = data.record->t;
  if (data.record->uniform) return {.first = t[data.first] - t0, .step = 1.0 / data.record->sampling_hz, .size = size};
  scratch->resize(size);
  for (std::size_t i = 0; i < size; ++i) (*scratch)[i] = t[data.first + i] - t0;
  return {.size = size, .times = *scratch};
}

/// The link with its derivatives by the coordinates of the fit (levels, shape); the last dual is left to the start.
template <int n>
Oscillator<Dual<2 * n + 2>> SeedDerivatives(const Oscillator<double>& link) {
  using Scalar = Dual<2 * n + 2>;
  const Eigen::MatrixXd natural = CalcNaturalDerivatives(link);
  const auto seed = [&](double value, Eigen::Index row) {
    Scalar scalar(value);
    for (Eigen::Index c = 0; c < natural.cols(); ++c) scalar.v(c) = natural(row, c);
    return scalar;
  };
  Oscillator<Scalar> dual;
  dual.g = link.g;
  dual.k = seed(link.k, 0);
  for (int i = 0; i < n; ++i) {
    const Slider<double>& slider = link.sliders()[static_cast<std::size_t>(i)];
    dual.Add({.k = seed(slider.k, 1 + i), .T0 = seed(slider.T0, 1 + n + i)});
  }
  return dual;
}

/// The residuals of one record [m] and their derivatives, column after column; memory that is kept from call to call.
template <int n>
class RecordColumns {
 public:
  static constexpr int kDuals = 2 * n + 2;               // levels, shape, y0
  static constexpr int kUnknowns = 3 + 2 * (n - 1) + 3;  // and t0, offset

  int evaluations() const { return evaluations_; }

  /// Residuals model - reading of the first `size` samples. @returns false where the model has no solution.
  bool Evaluate(const FitData& data, std::size_t size, const Oscillator<double>& link, const double* start) {
    Resize(size);
    const SampleTimes times = TimesSince(data, size, start[1], &times_);
    if (Solve(link, AtExtremum(link, start[0]), Duration(times), &plain_) != SolveStatus::kOk) return false;
    CalcDisplacements(plain_, times, Residuals());
    Subtract(data, start[2]);
    return true;
  }

  /// Derivatives as well, by (levels, shape, start).
  bool EvaluateWithDerivatives(const FitData& data, std::size_t size, const Oscillator<double>& link,
                               const double* start) {
    Resize(size);
    const SampleTimes times = TimesSince(data, size, start[1], &times_);
    const Oscillator<Dual<kDuals>> dual = SeedDerivatives<n>(link);
    const State<Dual<kDuals>> state = AtExtremum(dual, Dual<kDuals>(start[0], kDuals - 1));
    if (Solve(dual, state, Duration(times), &dual_) != SolveStatus::kOk) return false;
    const std::span<double> by_t0 = Column(kDuals), by_offset = Column(kDuals + 1);
    CalcDisplacements(dual_, times, Residuals(), by_t0, {columns_.data(), size_ * kDuals});
    for (double& v : by_t0) v = -v;
    std::fill(by_offset.begin(), by_offset.end(), 1.0);
    Subtract(data, start[2]);
    return true;
  }

  /// Derivatives, kUnknowns columns, and beside them the residuals.
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kUnknowns + 1>> Map() {
    return {columns_.data(), static_cast<Eigen::Index>(size_), kUnknowns + 1};
  }

 private:
  static double Duration(const SampleTimes& times) { return std::max(0.0, times[times.size - 1]); }

  void Resize(std::size_t size) {
    ++evaluations_;
    size_ = size;
    columns_.resize(size * (kUnknowns + 1));
  }

  std::span<double> Column(int i) { return {columns_.data() + static_cast<std::size_t>(i) * size_, size_}; }
  std::span<double> Residuals() { return Column(kUnknowns); }

  /// From displacements to residuals.
  void Subtract(const FitData& data, double offset) {
    const double* reading = data.record->y.data() + data.first;
    const std::span<double> residuals = Residuals();
    for (std::size_t i = 0; i < size_; ++i) residuals[i] += offset - reading[i];
  }

  Trajectory<double> plain_;
  Trajectory<Dual<kDuals>> dual_;
  std::vector<double> columns_, times_;
  std::size_t size_ = 0;
  int evaluations_ = 0;
};

}  // namespace uiclink
