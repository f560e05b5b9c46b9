#pragma once

namespace uiclink {

/// Coefficients of Kalker's linear creep law [-], a, b the semi-axes along and across rolling, c = sqrt(a b):
///   F_x = -G c^2 c11 xi_x,   F_y = -G c^2 (c22 xi_y + c c23 xi_s).
struct KalkerCoefficients {
  double c11 = 0;
  double c22 = 0;
  double c23 = 0;
};

/// Kalker's coefficients by his table (Three-Dimensional Elastic Bodies in Rolling Contact, 1990, table E3), 19 ratios
/// 0.1 ... 10 by nu = 0, 1/4, 1/2, exactly its values at the nodes. Between them as CONTACT does (module m_hertz): each
/// column linear in g = min(a/b, b/a), then a parabola in nu through the reciprocals. Where a is the longer axis the
/// columns go like 1/g (c23: g^-1.5), so that between g = 0.1 and 0.2, which only a flange reaches, the straight line
/// is up to 9 % (c23: 18 %) above such a curve; from g = 0.3 on it is below 3 %.
///
/// Outside of the table, g < 0.1, Kalker's asymptotes for g -> 0, multiplied by 1 + (e - 1) g/0.1 with e the quotient
/// of table and asymptote at g = 0.1 (0.98 ... 1.07): continuous at the edge of the table, exact in the limit. (CONTACT
/// jumps there.)
/// @param axis_ratio  a/b, > 0, finite.
/// @param poisson     nu, 0 ... 0.5.
/// @throws std::invalid_argument otherwise (NaN included).
KalkerCoefficients CalcKalkerCoefficients(double axis_ratio, double poisson);

}  // namespace uiclink
