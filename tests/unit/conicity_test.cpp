#include "vehicle/contact/conicity.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr double kPi = std::numbers::pi;

RollingRadiusDifference Sample(const std::function<double(double)>& delta_r, double y_min, double y_max,
                               int intervals) {
  RollingRadiusDifference d;
  for (int i = 0; i <= intervals; ++i) {
    d.y.push_back(y_min + (y_max - y_min) * i / intervals);
    d.delta_r.push_back(delta_r(d.y.back()));
  }
  return d;
}

TEST(Conicity, OfACone) {
  // delta_r = 2 gamma (y - y0): harmonic motion about y0, both methods give gamma for any amplitude.
  for (const double y0 : {0.0, 0.0012}) {
    const RollingRadiusDifference d = Sample([&](double y) { return 2 * 0.05 * (y - y0); }, -0.01, 0.01, 77);
    for (const double amplitude : {0.0003, 0.003, 0.0071}) {
      EXPECT_NEAR(CalcEquivalentConicity(d, amplitude), 0.05, 1e-13);
      EXPECT_NEAR(CalcHarmonicConicity(d, amplitude), 0.05, 1e-13);
    }
  }
}

TEST(Conicity, OfAStep) {
  // delta_r = rho sign(y), as a jump at y = 0: parabolas, quarter wavelength 2 sqrt(e r0 A / (2 rho)).
  const double rho = 0.001;
  const RollingRadiusDifference d{{-0.01, 0, 0, 0.01}, {-rho, -rho, rho, rho}};
  for (const double amplitude : {0.001, 0.004}) {
    EXPECT_NEAR(CalcEquivalentConicity(d, amplitude), kPi * kPi * rho / (16 * amplitude), 1e-13);
    EXPECT_NEAR(CalcHarmonicConicity(d, amplitude), 2 * rho / (kPi * amplitude), 1e-13);
  }
}

TEST(Conicity, OfACubicConvergesWithTheSquareOfTheStep) {
  // delta_r = k y^3: quarter wave (2/(A sqrt(k))) K, K = integral_0^1 du / sqrt(1 - u^4) = 1.3110287771461.
  const double k = 4000;
  const double amplitude = 0.004;
  const double exact = k * std::pow(kPi * amplitude / (4 * 1.3110287771460599), 2);
  const auto error = [&](int intervals) {
    const RollingRadiusDifference d = Sample([&](double y) { return k * y * y * y; }, -0.01, 0.01, intervals);
    return std::abs(CalcEquivalentConicity(d, amplitude) - exact) / exact;
  };
  const double coarse = error(200);
  const double fine = error(400);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_GT(std::log2(coarse / fine), 1.5);  // order 2, minus 0.5
  const RollingRadiusDifference d = Sample([&](double y) { return k * y * y * y; }, -0.01, 0.01, 2000);
  EXPECT_NEAR(CalcHarmonicConicity(d, amplitude), 3.0 / 8 * k * amplitude * amplitude, 1e-4 * 3.0 / 8 * k * 1.6e-5);
}

TEST(Conicity, OfAnAsymmetricPair) {
  // Slope 2 g1 to the right of the equilibrium, 2 g2 to the left: half a wave of each cone's wavelength; the sides
  // share the stretch 2A so that g1 a1^2 = g2 a2^2. Hence 1/sqrt(g) = (1/sqrt(g1) + 1/sqrt(g2)) / 2.
  const double g1 = 0.2;
  const double g2 = 0.05;
  const RollingRadiusDifference d{{-0.01, 0, 0.01}, {-2 * g2 * 0.01, 0, 2 * g1 * 0.01}};
  const double root = 2 / (1 / std::sqrt(g1) + 1 / std::sqrt(g2));
  EXPECT_NEAR(CalcEquivalentConicity(d, 0.003), root * root, 1e-13);
  // Seen in a mirror it is the same; shifted sideways too.
  const RollingRadiusDifference mirrored{{-0.01, 0, 0.01}, {-2 * g1 * 0.01, 0, 2 * g2 * 0.01}};
  EXPECT_NEAR(CalcEquivalentConicity(mirrored, 0.003), root * root, 1e-13);
  EXPECT_NEAR(CalcHarmonicConicity(mirrored, 0.003), CalcHarmonicConicity(d, 0.003), 1e-13);
  const RollingRadiusDifference shifted{{-0.012, -0.002, 0.008}, d.delta_r};
  EXPECT_NEAR(CalcEquivalentConicity(shifted, 0.003), root * root, 1e-13);
}

TEST(Conicity, OfACylinderWithFlanges) {
  // Free play +-c, stiff beyond: 0 inside the play. With amplitude A > c, slope 2 g outside:
  // quarter wave sqrt(e r0/(2 g)) (pi/2 + c/(A - c)).
  const double c = 0.002;
  const double g = 0.5;
  const RollingRadiusDifference d{{-0.01, -c, c, 0.01}, {-2 * g * (0.01 - c), 0, 0, 2 * g * (0.01 - c)}};
  EXPECT_EQ(CalcEquivalentConicity(d, 0.5 * c), 0);
  EXPECT_EQ(CalcEquivalentConicity(d, c), 0);
  const double amplitude = 0.003;
  const double quarter = kPi / 2 + c / (amplitude - c);
  EXPECT_NEAR(CalcEquivalentConicity(d, amplitude), g * std::pow(kPi / 2 / quarter, 2), 1e-13);
}

TEST(Conicity, IsNotANumberWhereTheWheelsetDoesNotSwing) {
  const RollingRadiusDifference inverted{{-0.01, 0.01}, {0.001, -0.001}};
  EXPECT_TRUE(std::isnan(CalcEquivalentConicity(inverted, 0.003)));
  EXPECT_TRUE(std::isnan(CalcHarmonicConicity(inverted, 0.003)));
  const RollingRadiusDifference short_one{{-0.002, 0.002}, {-0.001, 0.001}};
  EXPECT_TRUE(std::isnan(CalcEquivalentConicity(short_one, 0.003)));
  EXPECT_TRUE(std::isnan(CalcHarmonicConicity(short_one, 0.003)));
  EXPECT_TRUE(std::isnan(CalcEquivalentConicity(short_one, 0)));
  EXPECT_THROW(CalcEquivalentConicity({{0, 0.01}, {0}}, 0.001), std::invalid_argument);
}

TEST(Conicity, OfConesOnRoundRailsIsTheirSlope) {
  // Without roll a cone touches a round rail always at the same point of the rail: delta_r = 2 lambda y exactly.
  const double lambda = 0.05;
  const Profile cone("cone", {ProfilePiece::Polynomial(-0.05, 0.05, 0, std::array{0.0, lambda})});
  const Profile rail("round", {ProfilePiece::UpperArc(0.72, 0.78, 0.75, -0.3, 0.3)});
  const WheelOnRail side{cone, rail, 0.75, 0.46};
  const WheelsetOnRails wheelset(side, side, 0.46);
  const RollingRadiusDifference d = CalcRollingRadiusDifference(wheelset, 0.008, 1e-4, {.roll = false});
  ASSERT_EQ(d.y.size(), 161u);  // no jumps
  for (std::size_t i = 0; i < d.y.size(); ++i) EXPECT_NEAR(d.delta_r[i], 2 * lambda * d.y[i], 1e-14);
  EXPECT_NEAR(CalcEquivalentConicity(d, 0.003), lambda, 1e-11);
  EXPECT_THROW(CalcRollingRadiusDifference(wheelset, 0, 1e-4, {}), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
