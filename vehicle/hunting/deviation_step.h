#pragma once

#include <cstddef>
#include <vector>

#include "vehicle/rate_slopes.h"

namespace uiclink {

/// Moves deviations from a run, a column each, over one of its steps:
///   X' = J X + sum over the links of g_link forcing_link,   in the last column also + d rate / dV.
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
    std::size_t stride;        ///< doubles from row to row, a multiple of 4
    std::size_t speed_column;  ///< which column feels the speed; stride or more: none
  };

  /// Takes memory for rows of up to so many columns.
  void Reserve(std::size_t stride);

  /// Runge-Kutta of order 4.
  /// @param motions  30, or 34 with leaf springs (Wagon::size).
  /// @param forcing  by link, longitudinal ones by corner, then lateral ones [N].
  /// @param X        rows by motion; moved.
  void Make(const Slopes& slopes, double h, std::size_t motions, const Columns& columns, const double* forcing,
            double* X);

 private:
  std::vector<double> rate_, stage_, sum_;
};

}  // namespace uiclink
