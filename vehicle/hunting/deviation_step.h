#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "vehicle/rate_slopes.h"

namespace uiclink {

/// Moves deviations from a run, a column each, over one of its steps:
///   X' = J X + sum over the links of g_link forcing_link,   in one column also + d rate / d parameter.
/// Rows lie one after the other; their length is a whole number of vectors of four.
class DeviationStep {
 public:
  /// The derivatives of the rate where the step begins, in its middle and where it ends.
  struct Slopes {
    const RateSlopes& begin;
    const RateSlopes& middle;
    const RateSlopes& end;
  };
  struct Columns {
    std::size_t stride;            ///< doubles from row to row, a multiple of 4
    std::size_t parameter_column;  ///< which column feels the parameter; stride or more: none
  };
  /// d rate / d parameter by motion, at begin, middle and end of a step; null: the parameter is the speed, and
  /// RateSlopes has it.
  using ParameterRates = std::array<const double*, 3>;

  /// Takes memory for rows of up to so many columns.
  void Reserve(std::size_t stride);

  /// Runge-Kutta of order 4.
  /// @param motions  30, or 34 with leaf springs (Wagon::size).
  /// @param forcing  by link, longitudinal ones by corner, then lateral ones [N].
  /// @param X        rows by motion; moved.
  void Make(const Slopes& slopes, double h, std::size_t motions, const Columns& columns, const double* forcing,
            double* X, const ParameterRates& by_parameter = {});

 private:
  std::vector<double> rate_, stage_, sum_;
};

}  // namespace uiclink
