#include "vehicle/contact/kalker_coefficients.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;

/// Columns nu = 0, 1/4, 1/2.
using Columns = std::array<double, 3>;
struct Row {
  Columns c11, c22, c23;
};

/// Rows g = 0.1, 0.2, ..., 1 with g = a/b: the ellipse is longer across rolling. Two misprints of other listings: c23
/// is 1.25 at (0.8, 1/4) here, and c11 is 6.57 at (1/0.4, 1/2) below.
constexpr std::array<Row, 10> kLongAcross{{
    {{2.51, 3.31, 4.85}, {2.51, 2.52, 2.53}, {0.334, 0.473, 0.731}},
    {{2.59, 3.37, 4.81}, {2.59, 2.63, 2.66}, {0.483, 0.603, 0.809}},
    {{2.68, 3.44, 4.80}, {2.68, 2.75, 2.81}, {0.607, 0.715, 0.889}},
    {{2.78, 3.53, 4.82}, {2.78, 2.88, 2.98}, {0.720, 0.823, 0.977}},
    {{2.88, 3.62, 4.83}, {2.88, 3.01, 3.14}, {0.827, 0.929, 1.07}},
    {{2.98, 3.72, 4.91}, {2.98, 3.14, 3.31}, {0.930, 1.03, 1.18}},
    {{3.09, 3.81, 4.97}, {3.09, 3.28, 3.48}, {1.03, 1.14, 1.29}},
    {{3.19, 3.91, 5.05}, {3.19, 3.41, 3.65}, {1.13, 1.25, 1.40}},
    {{3.29, 4.01, 5.12}, {3.29, 3.54, 3.82}, {1.23, 1.36, 1.51}},
    {{3.40, 4.12, 5.20}, {3.40, 3.67, 3.98}, {1.33, 1.47, 1.63}},
}};

/// Rows g = 0.1, 0.2, ..., 1 with g = b/a: longer along rolling.
constexpr std::array<Row, 10> kLongAlong{{
    {{10.7, 11.7, 12.9}, {10.7, 12.8, 16.0}, {12.2, 14.6, 18.0}},
    {{6.96, 7.78, 8.82}, {6.96, 8.14, 9.79}, {5.72, 6.63, 7.89}},
    {{5.57, 6.34, 7.34}, {5.57, 6.40, 7.51}, {3.79, 4.32, 5.01}},
    {{4.84, 5.57, 6.57}, {4.84, 5.48, 6.31}, {2.88, 3.24, 3.70}},
    {{4.37, 5.10, 6.11}, {4.37, 4.90, 5.56}, {2.35, 2.62, 2.96}},
    {{4.06, 4.78, 5.80}, {4.06, 4.50, 5.04}, {2.01, 2.23, 2.50}},
    {{3.82, 4.54, 5.58}, {3.82, 4.21, 4.67}, {1.76, 1.95, 2.18}},
    {{3.65, 4.36, 5.42}, {3.65, 3.99, 4.39}, {1.58, 1.75, 1.94}},
    {{3.51, 4.22, 5.30}, {3.51, 3.81, 4.16}, {1.44, 1.59, 1.77}},
    {{3.40, 4.12, 5.20}, {3.40, 3.67, 3.98}, {1.33, 1.47, 1.63}},
}};

/// Parabola in nu through the reciprocals.
double AtPoisson(const Columns& c, double nu) {
  const double reciprocal =
      8 * (nu - 0.25) * (nu - 0.5) / c[0] - 16 * nu * (nu - 0.5) / c[1] + 8 * nu * (nu - 0.25) / c[2];
  return 1 / reciprocal;
}

/// g within 0.1 ... 1.
KalkerCoefficients InTable(const std::array<Row, 10>& table, double g, double nu) {
  const double place = std::clamp(10 * g - 1, 0.0, 9.0);
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(place), 8);
  const double t = place - static_cast<double>(i);
  const auto at = [&](Columns Row::*coefficient) {
    Columns c{};
    for (std::size_t k = 0; k < c.size(); ++k)
      c[k] = (1 - t) * (table[i].*coefficient)[k] + t * (table[i + 1].*coefficient)[k];
    return AtPoisson(c, nu);
  };
  return {.c11 = at(&Row::c11), .c22 = at(&Row::c22), .c23 = at(&Row::c23)};
}

/// g = a/b -> 0.
KalkerCoefficients AcrossAsymptote(double g, double nu) {
  return {.c11 = kPi * kPi / 4 / (1 - nu),
          .c22 = kPi * kPi / 4,
          .c23 = kPi * std::sqrt(g) / (3 * (1 - nu)) * (1 + nu * (std::log(16 / g) - 5))};
}

/// g = b/a -> 0.
KalkerCoefficients AlongAsymptote(double g, double nu) {
  const double L = std::log(16 / (g * g));
  const double s = 3 - std::log(4.0);
  const double x = L - 2 * nu;
  const double y = (1 - nu) * L + 2 * nu;
  return {.c11 = 2 * kPi / (x * g) * (1 + s / x),
          .c22 = 2 * kPi / (y * g) * (1 + (1 - nu) * s / y),
          .c23 = 2 * kPi / (3 * g * std::sqrt(g)) / ((1 - nu) * L - 2 + 4 * nu)};
}

}  // namespace

KalkerCoefficients CalcKalkerCoefficients(double axis_ratio, double poisson) {
  constexpr double kEdge = 0.1;
  if (!(axis_ratio > 0) || !std::isfinite(axis_ratio))
    throw std::invalid_argument(fmt::format("CalcKalkerCoefficients: a/b = {}, must be > 0 and finite", axis_ratio));
  if (!(poisson >= 0 && poisson <= 0.5))
    throw std::invalid_argument(fmt::format("CalcKalkerCoefficients: nu = {}, must be within 0 ... 0.5", poisson));
  const bool across = axis_ratio <= 1;
  const double g = across ? axis_ratio : 1 / axis_ratio;
  const KalkerCoefficients inside = InTable(across ? kLongAcross : kLongAlong, std::max(g, kEdge), poisson);
  if (g >= kEdge) return inside;
  const auto asymptote = across ? &AcrossAsymptote : &AlongAsymptote;
  const KalkerCoefficients limit = asymptote(g, poisson);
  const KalkerCoefficients edge = asymptote(kEdge, poisson);
  const auto blend = [&](double in_table, double at_edge, double here) {
    return here * (1 + (in_table / at_edge - 1) * g / kEdge);
  };
  return {.c11 = blend(inside.c11, edge.c11, limit.c11),
          .c22 = blend(inside.c22, edge.c22, limit.c22),
          .c23 = blend(inside.c23, edge.c23, limit.c23)};
}

}  // namespace uiclink
