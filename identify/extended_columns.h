#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "identify/extension.h"
#include "model/extended_solver.h"

namespace uiclink {

/// Error of an integrator step in a fit: adds up to nanometres, a thousandth of what sensors resolve.
inline constexpr double kFitTolerance = 1e-9;

/// The residuals model - reading of one record under an extended model [m] and their derivatives, column after column:
///   levels 3, shape 2(n-1), y0, t0, offset, shared effect parameters, the record's own ones; last the residuals.
/// Keeps its memory from call to call.
class ExtendedColumns {
 public:
  ExtendedColumns(const Extension& extension, int sliders);

  int CountUnknowns() const { return unknowns_; }
  int evaluations() const { return evaluations_; }

  /// Evaluates every stride-th of the first `size` samples. @returns false where the model has no solution.
  bool Evaluate(const FitData& data, std::size_t size, std::size_t stride, const double* levels, const double* shape,
                const double* start, const double* shared, const double* own, bool derivatives);

  /// Accuracy of motions without closed form, see ExtendedSolveOptions::tolerance.
  void SetTolerance(double tolerance) { tolerance_ = tolerance; }

  /// Derivatives and residuals of the last call; without derivatives only the last column means something.
  Eigen::Map<const Eigen::MatrixXd> Map() const {
    return {columns_.data(), static_cast<Eigen::Index>(size_), unknowns_ + 1};
  }
  std::span<const double> residuals() const {
    return {columns_.data() + static_cast<std::size_t>(unknowns_) * size_, size_};
  }

 private:
  bool EvaluatePlain(const FitData& data, const SampleTimes& times, const double* levels, const double* shape,
                     const double* start, const double* shared);
  template <int N>
  bool EvaluateDual(const FitData& data, const SampleTimes& times, const double* levels, const double* shape,
                    const double* start, const double* shared);
  void Read(const FitData& data, std::size_t stride, const double* start, std::span<const double> shared,
            std::span<const double> own, bool derivatives);
  void ReadThrough(const Effect* effect, std::span<const double> law_values, bool derivatives);
  double* Column(int i) { return columns_.data() + static_cast<std::size_t>(i) * size_; }

  const Extension& extension_;
  int sliders_;
  int link_;      // coordinates of the link
  int unknowns_;  // all of them
  std::size_t size_ = 0;
  int evaluations_ = 0;
  double fit_start_ = 0;
  double tolerance_ = kFitTolerance;
  std::vector<double> columns_, clock_, times_, scratch_, slope_;
  ExtendedTrajectory<double> plain_;
  std::tuple<ExtendedTrajectory<Dual<6>>, ExtendedTrajectory<Dual<8>>, ExtendedTrajectory<Dual<12>>,
             ExtendedTrajectory<Dual<16>>>
      duals_;
};

}  // namespace uiclink
