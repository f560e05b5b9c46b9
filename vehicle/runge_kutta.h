#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

namespace uiclink {

/// An explicit Runge-Kutta pair whose last stage is the first one of the next step ("first same as last"), so that s
/// stages cost s - 1 right-hand sides.
struct RungeKuttaPair {
  std::string_view name;
  int order = 0;
  int embedded_order = 0;
  /// Row i: what stage i + 1 takes of the stages before it; the last row is the step itself.
  std::vector<std::vector<double>> rows;
  std::vector<double> embedded;  ///< weights of the embedded solution, one per stage
  /// How far a step times an eigenvalue may go along the negative real and the imaginary axis.
  double real_extent = 0, imaginary_extent = 0;

  std::size_t stages() const { return embedded.size(); }
};

/// Our pairs by name; null for an unknown one.
const RungeKuttaPair* FindRungeKuttaPair(std::string_view name);

/// The extents of four stages of order 4, 1 + z + z^2/2 + z^3/6 + z^4/24: of the classical method and of Zonneveld's.
inline constexpr double kClassicalRealExtent = 2.785, kClassicalImaginaryExtent = 2.828;

/// The method that Integrator takes unless told otherwise: the fastest at 1e-6 of the amplitude where wheels touch with
/// their flanges and axle boxes hit their guides (integrator.h has the measurement).
inline constexpr std::string_view kDefaultMethod = "ARKODE_ZONNEVELD_5_3_4";

}  // namespace uiclink
