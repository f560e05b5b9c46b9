// Deviations from a run: one step against dense matrices, and runs put end to end.

#include "vehicle/hunting/variation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "tests/support/wagon_samples.h"
#include "tests/unit/hunting_samples.h"
#include "vehicle/hunting/deviation_step.h"
#include "vehicle/rate_slopes.h"
#include "vehicle/wagon_rate.h"

namespace uiclink {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct EverySample : testing::TestWithParam<WagonSample> {};

/// J by the dual scalar, and d rate by the force of every link and by the speed, by differences.
struct DenseSlopes {
  MatrixXd J, g;
  Eigen::VectorXd by_speed;
};

Eigen::VectorXd Rate(const Wagon& wagon, double V, const LinkStates& links, const StateVector<double>& x) {
  StateVector<double> rate;
  CalcRate(wagon, V, links, x, &rate);
  return Eigen::Map<const Eigen::VectorXd>(rate.data(), static_cast<Index>(wagon.size()));
}

DenseSlopes CalcDense(const Wagon& wagon, double V, const WagonState& state) {
  const auto n = static_cast<Index>(wagon.size());
  StateVector<Dual<kMaxState>> x, rate;
  for (std::size_t i = 0; i < kMaxState; ++i) x[i] = Dual<kMaxState>(state.x[i], static_cast<int>(i));
  CalcRate(wagon, V, state.links, x, &rate);
  DenseSlopes dense{MatrixXd(n, n), MatrixXd(n, static_cast<Index>(kLinks)), {}};
  for (Index i = 0; i < n; ++i) dense.J.row(i) = rate[static_cast<std::size_t>(i)].v.head(n).transpose();
  for (std::size_t link = 0; link < kLinks; ++link) {
    LinkStates more = state.links, less = state.links;  // linear: any force will do
    LinkAt(more, link).C += 1e4;
    LinkAt(less, link).C -= 1e4;
    dense.g.col(static_cast<Index>(link)) = (Rate(wagon, V, more, state.x) - Rate(wagon, V, less, state.x)) / 2e4;
  }
  const auto slope = [&](double h) -> Eigen::VectorXd {
    return (Rate(wagon, V + h, state.links, state.x) - Rate(wagon, V - h, state.links, state.x)) / (2 * h);
  };
  dense.by_speed = (4 * slope(1e-4 * V) - slope(2e-4 * V)) / 3;
  return dense;
}

// Both are sums of a few products; 1e-14 of the largest entry of a row is some fifty roundings.
TEST_P(EverySample, SlopesAreThoseOfTheDualScalar) {
  const Wagon wagon = MakeWagon(GetParam());
  RandomStates random(11);
  const double V = 22;
  for (const Region region : kRegions) {
    for (int draw = 0; draw < 20; ++draw) {
      const WagonState state = random.Draw(wagon, V, region);
      RateSlopes slopes;
      CalcRateSlopes(wagon, V, state.links, state.x, &slopes);
      const StateMatrix found = SpreadOut(slopes);
      const DenseSlopes dense = CalcDense(wagon, V, state);
      for (Index i = 0; i < dense.J.rows(); ++i)
        for (Index j = 0; j < dense.J.cols(); ++j)
          ASSERT_NEAR(found[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)], dense.J(i, j),
                      1e-14 * dense.J.row(i).cwiseAbs().maxCoeff())
              << kStateNames[static_cast<std::size_t>(i)] << " by " << kStateNames[static_cast<std::size_t>(j)];
    }
  }
}

TEST_P(EverySample, MakesAStepAsDenseMatricesDo) {
  const Wagon wagon = MakeWagon(GetParam());
  RandomStates random(12);
  const double V = 22, h = 2e-4;
  const auto n = static_cast<Index>(wagon.size());
  const Index columns = 12, speed = 9;  // one block of eight and one of four
  std::array<RateSlopes, 3> slopes;
  std::array<DenseSlopes, 3> dense;
  for (std::size_t i = 0; i < 3; ++i) {
    const WagonState state = random.Draw(wagon, V, Region::kTread);
    CalcRateSlopes(wagon, V, state.links, state.x, &slopes[i]);
    dense[i] = CalcDense(wagon, V, state);
  }
  const Rows from = 1e-3 * Rows::Random(n, columns), forcing = 100 * Rows::Random(static_cast<Index>(kLinks), columns);

  Rows found = from;
  DeviationStep step;
  step.Reserve(columns);
  step.Make({slopes[0], slopes[1], slopes[2]}, h, wagon.size(), {.stride = columns, .parameter_column = speed},
            forcing.data(), found.data());

  const auto rate = [&](const DenseSlopes& at, const MatrixXd& X) -> MatrixXd {
    MatrixXd all = at.J * X + at.g * forcing;
    all.col(speed) += at.by_speed;
    return all;
  };
  const MatrixXd k1 = rate(dense[0], from), k2 = rate(dense[1], from + h / 2 * k1),
                 k3 = rate(dense[1], from + h / 2 * k2), k4 = rate(dense[2], from + h * k3);
  const MatrixXd expected = from + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < columns; ++j)  // the forces of links and the speed come from differences, some 1e-10 of them
      EXPECT_NEAR(found(i, j), expected(i, j), (j == speed ? 1e-9 : 1e-12) * expected.row(i).cwiseAbs().maxCoeff())
          << kStateNames[static_cast<std::size_t>(i)] << " column " << j;
}

INSTANTIATE_TEST_SUITE_P(All, EverySample, testing::ValuesIn(WagonSamples()),
                         [](const auto& sample) { return sample.param.name; });

// One run in two parts: what the second makes of the first's deviations is what the whole does, speed included. Parts
// take other steps than the whole: measured 6e-8 of it at the tolerance 1e-10.
TEST(Variation, RunsPutEndToEndMultiply) {
  HuntingWagon hunting(HuntingSample{});
  WagonFlow& flow = hunting.flow;
  const double V = hunting.sample.V, T = hunting.period;
  const Passage first = flow.Pass(hunting.start, 0.4 * T, V, Flow::Derivatives::kAll);
  const Passage second = flow.Pass(first.end, 0.6 * T, V, Flow::Derivatives::kAll);
  const Passage whole = flow.Pass(hunting.start, T, V, Flow::Derivatives::kAll);
  const auto scaled = [&](const MatrixXd& M) -> MatrixXd {
    return flow.scales().cwiseInverse().asDiagonal() * M * flow.scales().asDiagonal();
  };
  const MatrixXd product = scaled(second.by_start * first.by_start), expected = scaled(whole.by_start);
  EXPECT_LT((product - expected).norm(), 1e-6 * expected.norm());
  const Eigen::VectorXd by_speed = second.by_start * first.by_parameter + second.by_parameter;
  EXPECT_LT((by_speed - whole.by_parameter).cwiseQuotient(flow.scales()).norm(),
            1e-5 * whole.by_parameter.cwiseQuotient(flow.scales()).norm());
}

}  // namespace
}  // namespace uiclink
