// Draws from the uncertainty of a set: moments, bounds, what is common and what is independent.

#include "vehicle/hunting/set_scatter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/wagon_fixture.h"
#include "vehicle/stability.h"

namespace uiclink {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::Pointwise;

/// Set 1 with the errors of k and k1 bound together, as a fit makes them.
std::array<CornerLinks, kCorners> Uncertain() {
  CornerLinks links = WagonFixture{}.ReadLinks();
  links.lateral.covariance = {.order = {"k", "k1", "T01"},
                              .matrix = {{9e-4, -5.4e-4, 0}, {-5.4e-4, 4e-4, 2e-7}, {0, 2e-7, 1e-8}}};
  return {links, links, links, links};
}

Eigen::MatrixXd SampleCovariance(const Eigen::MatrixXd& values) {
  const Eigen::MatrixXd centred = values.rowwise() - values.colwise().mean();
  return centred.transpose() * centred / static_cast<double>(values.rows() - 1);
}

TEST(SetScatter, DrawsHaveTheMeanAndTheCovarianceOfTheSet) {
  for (const Sampling sampling : {Sampling::kRandom, Sampling::kAntithetic, Sampling::kLatinHypercube}) {
    const SetScatter scatter(Uncertain(), {.draws = 20000, .seed = 3, .sampling = sampling});
    ASSERT_EQ(scatter.parameters().size(), 3u);
    EXPECT_EQ(scatter.redrawn(), 0u) << "the bounds are seventy standard deviations away";
    const Eigen::MatrixXd C = SampleCovariance(scatter.values()), expected = scatter.covariance();
    EXPECT_NEAR(expected(0, 1), -5.4e-4, 1e-16);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double std = std::sqrt(expected(i, i));
      // Five standard errors: of a mean 1/sqrt(n), of a covariance at most sqrt(2/n) of the standard deviations'
      // product.
      EXPECT_NEAR(scatter.values().col(i).mean(), scatter.centre()[i], 5 * std / std::sqrt(20000.0));
      for (Eigen::Index j = 0; j < 3; ++j)
        EXPECT_NEAR(C(i, j), expected(i, j), 5 * std * std::sqrt(expected(j, j) * 2 / 20000.0)) << i << ' ' << j;
    }
  }
}

TEST(SetScatter, AntitheticPairsHaveTheNominalValueInTheMiddle) {
  const SetScatter scatter(Uncertain(), {.draws = 20, .sampling = Sampling::kAntithetic});
  for (Eigen::Index i = 0; i < 20; i += 2)
    EXPECT_NEAR((0.5 * (scatter.values().row(i) + scatter.values().row(i + 1)).transpose() - scatter.centre()).norm(),
                0,
                1e-14);  // rounding of values near 4
}

TEST(SetScatter, LatinHypercubeHasOneDrawInEachInterval) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  for (CornerLinks& corner : links) corner.lateral.covariance = {.order = {"k"}, .matrix = {{1e-4}}};
  constexpr int kDraws = 50;
  const SetScatter scatter(links, {.draws = kDraws});
  std::array<int, kDraws> seen{};
  for (Eigen::Index i = 0; i < kDraws; ++i) {
    const double z = (scatter.values()(i, 0) - scatter.centre()[0]) / 1e-2;
    ++seen.at(static_cast<std::size_t>(kDraws * 0.5 * std::erfc(-z / std::numbers::sqrt2)));
  }
  EXPECT_THAT(seen, Each(1));
}

TEST(SetScatter, ValuesOutsideOfPhysicalBoundsAreDrawnAnew) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  const double T0 = links[0].lateral.sliders[0].T0, std = T0;  // the bound is one standard deviation away
  for (CornerLinks& corner : links) corner.lateral.covariance = {.order = {"T01"}, .matrix = {{std * std}}};
  constexpr int kDraws = 40000;
  const SetScatter scatter(links, {.draws = kDraws});
  EXPECT_GT(scatter.values().minCoeff(), 0);
  // Mean of a normal distribution cut off one standard deviation below: m + s phi(1)/Phi(1). Five standard errors.
  const double phi = std::exp(-0.5) / std::sqrt(2 * std::numbers::pi), Phi = 0.5 * std::erfc(-1 / std::numbers::sqrt2);
  EXPECT_NEAR(scatter.values().mean(), T0 + std * phi / Phi, 5 * std / std::sqrt(1.0 * kDraws));
  // Of n points n (1 - Phi)/Phi are drawn anew, over again where that fails.
  const double again = kDraws * (1 - Phi) / Phi;
  EXPECT_NEAR(static_cast<double>(scatter.redrawn()), again, 5 * std::sqrt(again));
}

TEST(SetScatter, EffectsKeepTheBoundsOfTheCatalogue) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  for (CornerLinks& corner : links) {
    corner.lateral.effects = {{.id = "viscous_damping", .parameters = {{"c", 0.001}}}};
    corner.lateral.covariance = {.order = {"viscous_damping.c"}, .matrix = {{1e-4}}};
  }
  const SetScatter scatter(links, {.draws = 1000});
  EXPECT_GE(scatter.values().minCoeff(), 0);
  EXPECT_GT(scatter.redrawn(), 500u);
  EXPECT_EQ(scatter.parameters()[0].group, "lateral viscous_damping");
  EXPECT_EQ(scatter.Draw(7)[2].lateral.effects[0].parameters[0].second, scatter.values()(7, 0));
}

TEST(SetScatter, CornersOnTheSameSetHaveItsErrorsInCommon) {
  const SetScatter scatter(Uncertain(), {.draws = 10});
  for (std::size_t i = 0; i < 10; ++i) {
    const std::array<CornerLinks, kCorners> links = scatter.Draw(i);
    for (const CornerLinks& corner : links) {
      EXPECT_EQ(corner.lateral.k, scatter.values()(static_cast<Eigen::Index>(i), 0));
      EXPECT_EQ(corner.lateral.sliders[0].T0, scatter.values()(static_cast<Eigen::Index>(i), 2));
      EXPECT_EQ(corner.longitudinal.k, scatter.nominal()[0].longitudinal.k) << "it has no covariance";
    }
  }
}

TEST(SetScatter, CornersOnDifferentSetsAreDrawnApart) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  for (const std::size_t rear : {2u, 3u}) links[rear].lateral.k += 0.1;
  const SetScatter scatter(links, {.draws = 4000});
  ASSERT_EQ(scatter.parameters().size(), 6u);
  const Eigen::MatrixXd C = SampleCovariance(scatter.values());
  EXPECT_EQ(scatter.covariance()(0, 3), 0);
  EXPECT_NEAR(C(0, 3), 0, 5 * C(0, 0) / std::sqrt(4000.0));
  const std::array<CornerLinks, kCorners> drawn = scatter.Draw(0);
  EXPECT_EQ(drawn[0].lateral.k, drawn[1].lateral.k);
  EXPECT_NE(drawn[0].lateral.k, drawn[2].lateral.k);
}

TEST(SetScatter, CornerScatterIsAFactorOnEachCornersOwnValue) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  const SetScatter scatter(links, {.draws = 8000, .corner = {.k = 0.02, .slider_k = 0.03, .slider_T0 = 0.04}});
  EXPECT_EQ(scatter.parameters().size(), 3u + 4u * (3u + 9u));
  double squares = 0;
  for (std::size_t i = 0; i < scatter.size(); ++i) {
    const std::array<CornerLinks, kCorners> drawn = scatter.Draw(i);
    const double common = scatter.values()(static_cast<Eigen::Index>(i), 0);
    const double factor = drawn[3].lateral.k / common;
    squares += (factor - 1) * (factor - 1);
    EXPECT_NE(drawn[0].lateral.k, drawn[1].lateral.k);
    EXPECT_NE(drawn[0].longitudinal.sliders[2].T0, links[0].longitudinal.sliders[2].T0);
  }
  EXPECT_NEAR(std::sqrt(squares / 8000), 0.02, 5 * 0.02 / std::sqrt(2 * 8000.0));
}

TEST(SetScatter, DrawsOfADirectionDependOnNothingElse) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  const SetScatter alone(links, {.draws = 30});
  for (CornerLinks& corner : links) corner.longitudinal.covariance = {.order = {"k"}, .matrix = {{1e-2}}};
  const SetScatter both(links, {.draws = 30, .corner = {.k = 0.01}});
  EXPECT_EQ(alone.values(), both.values().leftCols(3));
  EXPECT_NE(alone.values(), SetScatter(Uncertain(), {.draws = 30, .seed = 2}).values());
}

TEST(SetScatter, CoverageWidensTheDraws) {
  const SetScatter normal(Uncertain(), {.draws = 5}), wide(Uncertain(), {.draws = 5, .coverage = {3.92, 1.96}});
  for (Eigen::Index i = 0; i < 5; ++i)
    EXPECT_NEAR(wide.values()(i, 0) - wide.centre()[0], 2 * (normal.values()(i, 0) - normal.centre()[0]), 1e-14);
}

TEST(SetScatter, CoverageIsTheSetsUnlessSaidOtherwise) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  for (CornerLinks& corner : links) corner.lateral.covariance->coverage = 3.92;
  const SetScatter of_set(links, {.draws = 5}), wide(Uncertain(), {.draws = 5, .coverage = {3.92}});
  EXPECT_EQ(of_set.values(), wide.values());
  EXPECT_EQ(of_set.coverage(), (std::array{3.92, 1.96}));
  const SetScatter narrow(links, {.draws = 5, .coverage = {1.96}}), normal(Uncertain(), {.draws = 5});
  EXPECT_EQ(narrow.values(), normal.values());
  EXPECT_EQ(narrow.coverage(), normal.coverage());
}

TEST(SetScatter, CornersScatterAsTheirSetSays) {
  std::array<CornerLinks, kCorners> links = Uncertain();
  const double k = links[0].lateral.k, T0 = links[0].lateral.sliders[0].T0;
  // Other numbers for the rear: corners take what is said of their own set.
  for (std::size_t corner = 0; corner < kCorners; ++corner)
    links[corner].lateral.covariance->spread = {{"k", (corner < 2 ? 0.01 : 0.02) * k}, {"T01", 0.03 * T0}};
  const SetScatter scatter(links, {.draws = 8000, .corner = {.from_set = true}});
  std::array<double, kCorners> squares{};
  for (std::size_t i = 0; i < scatter.size(); ++i) {
    const std::array<CornerLinks, kCorners> drawn = scatter.Draw(i);
    const auto row = scatter.values().row(static_cast<Eigen::Index>(i));
    for (std::size_t corner = 0; corner < kCorners; ++corner) {
      squares[corner] += std::pow(drawn[corner].lateral.k / row[0] - 1, 2);
      // No spread is known of k1 and of the other direction.
      EXPECT_EQ(drawn[corner].lateral.sliders[0].k, row[1]);
      EXPECT_EQ(drawn[corner].longitudinal.k, links[corner].longitudinal.k);
    }
    EXPECT_NE(drawn[0].lateral.sliders[0].T0, drawn[1].lateral.sliders[0].T0);
  }
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    const double std = corner < 2 ? 0.01 : 0.02;
    EXPECT_NEAR(std::sqrt(squares[corner] / 8000), std, 5 * std / std::sqrt(2 * 8000.0)) << corner;
  }
}

TEST(SetScatter, WithoutCovarianceNothingIsUncertain) {
  const CornerLinks set1 = WagonFixture{}.ReadLinks();
  EXPECT_TRUE(SetScatter({set1, set1, set1, set1}, {}).empty());
}

TEST(SetScatter, ACovarianceThatIsNoneIsRefused) {
  const auto message = [](const Covariance& covariance) -> std::string {
    std::array<CornerLinks, kCorners> links = Uncertain();
    for (CornerLinks& corner : links) corner.lateral.covariance = covariance;
    try {
      SetScatter(links, {});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_EQ(message({.order = {"k", "k7"}, .matrix = {{1, 0}, {0, 1}}}),
            "lateral k7 is in the covariance, but not in the set");
  // Each pair may be so, all three may not: smallest eigenvalue 1 - 2 * 0.9.
  EXPECT_THAT(message({.order = {"k", "k1", "T01"}, .matrix = {{1, -.9, -.9}, {-.9, 1, -.9}, {-.9, -.9, 1}}}),
              HasSubstr("has a variance of -0.8 relative"));
}

TEST(SetScatter, AWagonOnOtherLinksIsTheOneMadeOfThem) {
  for (const Suspension suspension : {Suspension::kLinear, Suspension::kParabolic}) {
    const WagonFixture fixture{.options = {.suspension = suspension}};
    const ContactTable table = MakeHandMadeTable();
    const Wagon wagon = fixture.Make(table);
    const std::array<CornerLinks, kCorners> links =
        SetScatter(Uncertain(), {.draws = 1, .corner = {.k = 0.1, .slider_k = 0.1, .slider_T0 = 0.1}}).Draw(0);
    const Wagon made(fixture.ReadData(), fixture.ReadBody(), false, links, table, fixture.options);
    EXPECT_EQ(Linearize(WithLinks(wagon, links), 10).jacobian, Linearize(made, 10).jacobian);
  }
}

}  // namespace
}  // namespace uiclink
