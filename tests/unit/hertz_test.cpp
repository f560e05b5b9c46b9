#include "vehicle/contact/hertz.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr ElasticMaterial kSteel{.young = 21e10, .poisson = 0.27};

// Relative rounding of a few dozen operations.
constexpr double kRounding = 1e-13;

void ExpectRelative(double value, double expected, double tolerance) {
  EXPECT_NEAR(value / expected, 1, tolerance) << "found " << value << ", expected " << expected;
}

// --- elliptic integrals ---

TEST(EllipticIntegrals, AgreeWithTheStandardLibrary) {
  for (const double g : {0.01, 0.1, 0.3, 0.5, 0.7, 0.9}) {
    const double k = std::sqrt(1 - g * g);
    const EllipticIntegrals f = CalcEllipticIntegrals(g);
    const double K = std::comp_ellint_1(k);
    const double E = std::comp_ellint_2(k);
    ExpectRelative(f.K, K, kRounding);
    ExpectRelative(f.D, (K - E) / (k * k), 1e-12);  // here the difference K - E loses up to a digit
    ExpectRelative(f.B, (E - g * g * K) / (k * k), 1e-12);
  }
}

TEST(EllipticIntegrals, KeepTheirDigitsTowardsTheCircle) {
  // Series for small m: K = pi/2 (1 + m/4), D = pi/4 (1 + 3 m/8), B = pi/4 (1 + m/8), next terms below m^2.
  for (const double m : {0.0, 1e-14, 1e-10, 1e-7}) {
    const EllipticIntegrals f = CalcEllipticIntegrals(std::sqrt(1 - m));
    ExpectRelative(f.K, kPi / 2 * (1 + m / 4), kRounding);
    ExpectRelative(f.D, kPi / 4 * (1 + 3 * m / 8), kRounding);
    ExpectRelative(f.B, kPi / 4 * (1 + m / 8), kRounding);
  }
}

TEST(EllipticIntegrals, GoToTheirLogarithmTowardsTheLine) {
  for (const double g : {1e-3, 1e-6, 1e-9}) {  // K = ln(4/g) + O(g^2 ln g), B = 1 + O(g^2 ln g)
    const EllipticIntegrals f = CalcEllipticIntegrals(g);
    EXPECT_NEAR(f.K, std::log(4 / g), 10 * g * g * f.K + 1e-12);
    EXPECT_NEAR(f.B, 1, 10 * g * g * f.K + 1e-12);
  }
}

// --- closed forms ---

TEST(HertzContact, SphereOnPlane) {
  const double R = 0.46;
  const double N = 5013.1;
  const HertzContact contact = CalcHertzContact(1 / R, 1 / R, N, kSteel);
  const double E = 21e10 / (2 * (1 - 0.27 * 0.27));
  const double a = std::cbrt(3 * N * R / (4 * E));
  ExpectRelative(contact.a, a, kRounding);
  ExpectRelative(contact.b, a, kRounding);
  ExpectRelative(contact.approach, a * a / R, kRounding);
  ExpectRelative(contact.pressure, std::cbrt(6 * N * E * E / (kPi * kPi * kPi * R * R)), kRounding);
}

TEST(HertzContact, CrossedEqualCylindersTouchInACircle) {
  // Each cylinder is curved in one direction: 1/R along x from the one, 1/R along y from the other.
  const HertzContact contact = CalcHertzContact(1 / 0.3, 1 / 0.3, 38e3, kSteel);
  EXPECT_EQ(contact.a, contact.b);
}

TEST(HertzContact, TakesTheEllipseThatItsCurvaturesWereMadeFor) {
  // Backwards from a known ellipse (Johnson, Contact Mechanics, 4.26, a > b), with the library's integrals:
  //   kappa_x/2 = p0/E* b/(e^2 a^2) (K - E),   kappa_y/2 = p0/E* b/(a^2 e^2) ((a/b)^2 E - K),   approach = p0/E* b K.
  const double N = 12e3;
  const double a = 6e-3;
  for (const double b : {0.05e-3, 0.6e-3, 2e-3, 5e-3, 5.9e-3}) {
    const double e2 = 1 - b * b / (a * a);
    const double K = std::comp_ellint_1(std::sqrt(e2));
    const double E = std::comp_ellint_2(std::sqrt(e2));
    const double p0 = 3 * N / (2 * kPi * a * b);
    const double scale = p0 / kSteel.contact_modulus() * b;
    const double along = 2 * scale / (e2 * a * a) * (K - E);
    const double across = 2 * scale / (e2 * a * a) * (a * a / (b * b) * E - K);
    const HertzContact contact = CalcHertzContact(along, across, N, kSteel);
    ExpectRelative(contact.a, a, 1e-11);  // the differences above cancel a digit or two at b = 0.98 a
    ExpectRelative(contact.b, b, 1e-11);
    ExpectRelative(contact.approach, scale * K, 1e-11);
    ExpectRelative(contact.pressure, p0, 1e-11);

    const HertzContact turned = CalcHertzContact(across, along, N, kSteel);
    ExpectRelative(turned.a, contact.b, kRounding);
    ExpectRelative(turned.b, contact.a, kRounding);
    ExpectRelative(turned.approach, contact.approach, kRounding);
  }
}

/// Deflection of both bodies at (x, y) under the semi-ellipsoid of pressure: 1/(pi E*) int p/rho dA, in polar
/// coordinates about the point. Along a chord the pressure is a half ellipse over t, so that the integral over t is
/// pi/2 times its height times half its length; over the direction the trapezoidal rule converges geometrically.
double CalcDeflection(const HertzContact& c, double x, double y) {
  constexpr int n = 400;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double angle = kPi * i / n;
    const double u = std::cos(angle) / c.a;
    const double v = std::sin(angle) / c.b;
    // 1 - ((x/a + u t)^2 + (y/b + v t)^2) = height - A (t - t0)^2
    const double A = u * u + v * v;
    const double t0 = -(x / c.a * u + y / c.b * v) / A;
    const double height = 1 - x * x / (c.a * c.a) - y * y / (c.b * c.b) + A * t0 * t0;
    sum += kPi / 2 * height / std::sqrt(A);
  }
  return c.pressure * sum * kPi / n / (kPi * kSteel.contact_modulus());
}

TEST(HertzContact, PressureDeflectsTheBodiesIntoEachOther) {
  const double kappa_x = 2.1;
  const double kappa_y = 9.7;
  const HertzContact c = CalcHertzContact(kappa_x, kappa_y, 20e3, kSteel);
  for (const auto& [x, y] : {std::pair{0.0, 0.0}, {0.5, 0.0}, {0.0, 0.7}, {-0.4, 0.6}, {0.9, 0.1}}) {
    const double gap = 0.5 * (kappa_x * x * x * c.a * c.a + kappa_y * y * y * c.b * c.b);
    ExpectRelative(CalcDeflection(c, x * c.a, y * c.b), c.approach - gap, 1e-11);
  }
}

TEST(HertzContact, ScalesWithTheForce) {
  const HertzContact one = CalcHertzContact(2.17, 6.2, 1e3, kSteel);
  const HertzContact eight = CalcHertzContact(2.17, 6.2, 8e3, kSteel);
  ExpectRelative(eight.a, 2 * one.a, kRounding);  // a ~ N^(1/3)
  ExpectRelative(eight.b, 2 * one.b, kRounding);
  ExpectRelative(eight.approach, 4 * one.approach, kRounding);  // N ~ approach^1.5
  ExpectRelative(eight.pressure, 2 * one.pressure, kRounding);
}

TEST(HertzContact, PassesContinuouslyThroughTheCircle) {
  // Slope of ln(a/b) over ln(kappa_y/kappa_x) is 2/3 there; the second derivative is below 0.1.
  for (const double step : {1e-12, 1e-9, 1e-6, 1e-4}) {
    for (const double sign : {-1.0, 1.0}) {
      const double ratio = CalcHertzAxisRatio(std::exp(sign * step));
      EXPECT_NEAR(std::log(ratio), -sign * step * 2 / 3, 0.1 * step * step + 1e-15) << "step " << sign * step;
    }
  }
}

TEST(HertzContact, AxisRatioIsMonotoneOverTwentyDecades) {
  double before = std::numeric_limits<double>::infinity();
  for (double decade = -10; decade <= 10; decade += 0.05) {
    const double ratio = CalcHertzAxisRatio(std::min(std::pow(10, decade), 1e10));
    EXPECT_LT(ratio, before) << "curvature ratio 1e" << decade;
    ExpectRelative(ratio * CalcHertzAxisRatio(1 / std::min(std::pow(10, decade), 1e10)), 1, 1e-12);
    before = ratio;
  }
}

TEST(HertzContact, NoForceNoEllipse) {
  const HertzContact contact = CalcHertzContact(2, 3, 0, kSteel);
  EXPECT_EQ(contact.a, 0);
  EXPECT_EQ(contact.approach, 0);
}

TEST(HertzContact, RejectsWhatHasNoEllipse) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(CalcHertzContact(0, 1, 1, kSteel), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1, -1, 1, kSteel), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1, nan, 1, kSteel), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1e-6, 1e6, 1, kSteel), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1, 1, -1, kSteel), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1, 1, 1, {.young = 0, .poisson = 0.3}), std::invalid_argument);
  EXPECT_THROW(CalcHertzContact(1, 1, 1, {.young = 1, .poisson = 0.6}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
