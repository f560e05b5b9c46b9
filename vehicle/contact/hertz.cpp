#include "vehicle/contact/hertz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGreatestCurvatureRatio = 1e10;

void Require(bool good, const char* symbol, double value, const char* rule) {
  if (!good) throw std::invalid_argument(fmt::format("CalcHertzContact: {} = {}, must be {}", symbol, value, rule));
}

/// d ln(g^2 D/B) / d ln g:  from dB/dm = (D - B)/(2 m), dD/dm = (B - g^2 D)/(2 g^2 m), dm = -2 g^2 d ln g.
double CalcLogSlope(double g, const EllipticIntegrals& f) {
  const double m = (1 - g) * (1 + g);
  if (m < 1e-7) return 1.5;  // the limit, where the differences above are rounding
  return 2 - ((f.B - g * g * f.D) / f.D - g * g * (f.D - f.B) / f.B) / m;
}

/// The axis ratio g <= 1 for the ratio of the lesser to the greater curvature, 0 < ratio <= 1. ln(ratio) is nearly a
/// straight line over ln g (slope 1.5 at g = 1, towards 2 at g = 0), so Newton's method needs three or four steps.
double FindAxisRatio(double ratio) {
  constexpr int kMostSteps = 20;
  const double target = std::log(ratio);
  double u = 0.636 * target;
  for (int i = 0; i < kMostSteps; ++i) {
    const double g = std::exp(u);
    const EllipticIntegrals f = CalcEllipticIntegrals(g);
    const double step = (2 * u + std::log(f.D / f.B) - target) / CalcLogSlope(g, f);
    u = std::min(u - step, 0.0);
    if (std::abs(step) < 4e-16 * (1 + std::abs(u))) break;
  }
  return std::exp(u);
}

}  // namespace

EllipticIntegrals CalcEllipticIntegrals(double g) {
  // c_n^2 of the mean's sequence, divided by m: m itself drops out, so that nothing cancels as m -> 0.
  double mean = 1;
  double geometric = g;
  double sum = 1;  // sum of 2^n c_n^2 / m
  double power = 1;
  double c2 = 0;
  for (int n = 1; n < 40; ++n) {
    const double half = 0.5 * (mean - geometric);
    c2 = n == 1 ? 0.25 * (1 - g) / (1 + g) : half * half / ((1 - g) * (1 + g));
    power *= 2;
    const double next = 0.5 * (mean + geometric);
    geometric = std::sqrt(mean * geometric);
    mean = next;
    if (half <= 1e-17 * mean) break;
    sum += power * c2;
    if (half <= 1e-9 * mean) break;  // the next half is the square of this one
  }
  const double K = kPi / (2 * mean);
  const double D = 0.5 * K * sum;
  return {.K = K, .B = K - D, .D = D};
}

double CalcHertzAxisRatio(double curvature_ratio) {
  Require(curvature_ratio >= 1 / kGreatestCurvatureRatio && curvature_ratio <= kGreatestCurvatureRatio,
          "kappa_x/kappa_y", curvature_ratio, "within 1e-10 ... 1e10");
  // The longer axis lies along the lesser curvature.
  if (curvature_ratio <= 1) return 1 / FindAxisRatio(curvature_ratio);
  return FindAxisRatio(1 / curvature_ratio);
}

HertzContact CalcHertzContact(double kappa_x, double kappa_y, double normal_force, const ElasticMaterial& material) {
  Require(kappa_x > 0 && std::isfinite(kappa_x), "kappa_x", kappa_x, "> 0");
  Require(kappa_y > 0 && std::isfinite(kappa_y), "kappa_y", kappa_y, "> 0");
  Require(normal_force >= 0 && std::isfinite(normal_force), "N", normal_force, ">= 0");
  Require(material.young > 0 && std::isfinite(material.young), "E", material.young, "> 0");
  Require(material.poisson >= 0 && material.poisson <= 0.5, "nu", material.poisson, "within 0 ... 0.5");
  const double ratio = CalcHertzAxisRatio(kappa_x / kappa_y);
  if (normal_force == 0) return {};
  const double g = std::min(ratio, 1 / ratio);
  const EllipticIntegrals f = CalcEllipticIntegrals(g);
  const double modulus = material.contact_modulus();
  const double p = std::cbrt(3 * normal_force * f.B / (kPi * modulus * std::max(kappa_x, kappa_y) * g * g));
  const double q = g * p;
  return {.a = ratio >= 1 ? p : q,
          .b = ratio >= 1 ? q : p,
          .approach = 3 * normal_force * f.K / (2 * kPi * modulus * p),
          .pressure = 3 * normal_force / (2 * kPi * p * q)};
}

}  // namespace uiclink
