#pragma once

namespace uiclink {

/// Complete elliptic integrals of the parameter m = k^2, 0 <= m < 1, to rounding:
///   K(m) = int_0^{pi/2} dt / sqrt(1 - m sin^2 t),   D(m) = (K - E)/m,   B(m) = K - D = (E - (1 - m) K)/m.
/// B and D tend to pi/4 as m -> 0, where K - E would cancel.
struct EllipticIntegrals {
  double K = 0;
  double B = 0;
  double D = 0;
};

/// By the arithmetic-geometric mean.
/// @param g  sqrt(1 - m), 0 < g <= 1: the ratio of the axes of an ellipse with the eccentricity sqrt(m).
EllipticIntegrals CalcEllipticIntegrals(double g);

/// Two bodies of the same linear elastic material.
struct ElasticMaterial {
  double young = 0;    ///< E [N/m^2], > 0
  double poisson = 0;  ///< nu [-], 0 <= nu <= 0.5

  /// E* = E / (2 (1 - nu^2)) [N/m^2].
  double contact_modulus() const { return young / (2 * (1 - poisson * poisson)); }
};

/// A frictionless contact on an ellipse.
struct HertzContact {
  double a = 0;         ///< semi-axis along x, which is rolling [m]
  double b = 0;         ///< semi-axis along y, which is across [m]
  double approach = 0;  ///< of distant points of the two bodies along the normal [m]
  double pressure = 0;  ///< the greatest, 3 N / (2 pi a b) [N/m^2]
};

/// The contact of two bodies whose distance, as long as they just touch, is (kappa_x x^2 + kappa_y y^2)/2
/// (Hertz 1882; Johnson, Contact Mechanics, 4.2).  With the longer semi-axis p along the lesser curvature kappa_p, the
/// shorter one q = g p along kappa_q, and integrals of m = 1 - g^2:
///   kappa_p / kappa_q = g^2 D/B,    p^3 = 3 N B / (pi E* kappa_q g^2),    approach = 3 N K / (2 pi E* p).
/// Either axis may be the longer one; equal curvatures (crossed equal cylinders) give a circle. N = 0 gives zeros.
/// @param kappa_x, kappa_y  relative principal curvatures [1/m], > 0, their ratio within 1e-10 ... 1e10.
/// @param normal_force  N [N], >= 0.
/// @throws std::invalid_argument otherwise (NaN included).
HertzContact CalcHertzContact(double kappa_x, double kappa_y, double normal_force, const ElasticMaterial& material);

/// a/b of that contact for kappa_x/kappa_y within 1e-10 ... 1e10; neither force nor material matters.
/// @throws std::invalid_argument otherwise (NaN included).
double CalcHertzAxisRatio(double curvature_ratio);

}  // namespace uiclink
