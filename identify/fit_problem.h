#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/link_coordinates.h"
#include "identify/record.h"

namespace uiclink {

/// Start of the free decay of one record: y0 [m] from the true origin, t0 [s] of the extremum, offset [m] of the
/// sensor's zero, so that reading(t) = offset + y(t - t0).
using Start = std::array<double, 3>;

/// The samples of one record that a fit uses.  A view: the record must outlive it.
struct FitData {
  const Record* record = nullptr;
  std::size_t first = 0;  ///< first sample at or after the first free extremum
  std::size_t size = 0;   ///< samples from there
  double sigma = 0;       ///< noise of a reading [m], > 0
  double g = kThesisGravity;
  double centre = 0;    ///< centre of the late motion in readings [m]: the sensor's zero is not far from it
  double swing = 0;     ///< amplitude of the first extremum about it [m]; 0: unknown, no limits from it
  double smallest = 0;  ///< smallest amplitude that the record resolves [m]; 0: unknown, no limit
};

/// Number of samples within some time [s] of the first one.
std::size_t SamplesWithin(const FitData& data, double seconds);

/// Where a fit does not go, because the model means nothing there. They only matter where the data say too little or
/// the model lacks something; a bound that ends at one of them is called open.
///   zero of the sensor within a quarter of the first amplitude from the centre of the late motion
///     (a locked slider holds it at most T0/(k + k1) away, an eighth of that in the thesis's stiffest set);
///   critical displacements T0i/k_i not below the smallest amplitude that the record resolves: such a slider never
///     rolls in this record, it is a friction force and no joint;
///   nor above the first amplitude: such a slider never slides in this record, it is a spring, and its force at the
///     first extremum is not known (as a fit has it, a shift of the zero).
inline constexpr double kZeroReach = 0.25;
inline constexpr double kZeroReachOfWindows = 0.06;  ///< while the window of a fit grows

/// What the records of a joint fit have in common.
enum class Sharing {
  kLink,   ///< one link for all: levels and shape
  kShape,  ///< own levels for each record, one shape
};

/// All unknowns of a fit.
struct FitState {
  std::vector<Levels> levels;  ///< one (Sharing::kLink) or one per record (Sharing::kShape)
  Shape shape;
  std::vector<Start> starts;  ///< one per record
  /// Shapes of their own, one per record (extended fits of several sliders only); `shape` is not used then, but says
  /// how many sliders there are. Empty: all have `shape`.
  std::vector<Shape> shapes = {};

  const Levels& LevelsOf(std::size_t record) const { return levels[levels.size() == 1 ? 0 : record]; }
  const Shape& ShapeOf(std::size_t record) const { return shapes.empty() ? shape : shapes[record]; }
};

struct FitControl {
  std::vector<double> window_s = {};  ///< growing windows from the first extremum [s]; the whole record comes last
  /// A quantity (see CountQuantities) that is held near this logarithm while everything else is free: the outcome is a
  /// point on the profile of that quantity, at the value that the quantity has there.
  std::optional<std::pair<int, double>> held = {};
  /// Weight of its distance [1/unit of the logarithm]. Some thirty times the inverse of its standard deviation holds it
  /// well enough; more makes a narrow bent valley of the problem, along which a fit creeps.
  double held_weight = 1e6;
  bool fix_link = false;   ///< only the starts are free; levels and shape stay as they are
  bool fix_shape = false;  ///< the shape is held, levels and starts are free
  int max_iterations = 200;
  double function_tolerance = 1e-9;  ///< relative fall of the sum of squares at which the last window stops [-]
  int threads = 1;                   ///< records evaluated side by side; 0: as many as the machine can
};

struct FitOutcome {
  FitState state = {};
  double chi2 = 0;  ///< sum of ((model - reading)/sigma)^2
  std::vector<double> chi2_of_record = {};
  std::vector<Levels> window_levels = {};  ///< levels (of record 0) that each window ended with; the last: all samples
  int evaluations = 0;                     ///< of a record, with or without derivatives
  bool converged = false;
  std::string message = {};  ///< why it stopped, when it did not converge
};

/// Least squares on the differential-succession model with exact derivatives (Ceres, Levenberg-Marquardt), through
/// growing windows.  Never throws for what is in the data; a fit that fails says why.
FitOutcome Fit(std::span<const FitData> data, Sharing sharing, const FitState& initial, const FitControl& control = {});

/// Model minus reading of one record [m].
std::vector<double> CalcResiduals(const FitData& data, const Levels& levels, const Shape& shape, const Start& start);

/// Derivatives of the residuals (in units of sigma) of one record by (levels, shape, start), row by row, and the
/// residuals.
struct Linearisation {
  Eigen::MatrixXd jacobian;   ///< samples x (3 + 2(n-1) + 3)
  Eigen::VectorXd residuals;  ///< samples
};
Linearisation Linearise(const FitData& data, const Levels& levels, const Shape& shape, const Start& start);

}  // namespace uiclink
