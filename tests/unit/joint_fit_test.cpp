#include "identify/joint_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "identify/identification.h"
#include "model/event_solver.h"

namespace uiclink {
namespace {

Oscillator<double> Lateral() {
  Oscillator<double> link;
  link.k = 3.41;
  link.Add({2.21, 0.018});
  return link;
}

Oscillator<double> Longitudinal() {
  Oscillator<double> link;
  link.k = 5.5;
  link.Add({2.0, 2.0 * 0.003});
  link.Add({1.5, 1.5 * 0.006});
  return link;
}

/// Every parameter times 1 + a normal deviate of its own.
Oscillator<double> Scatter(Oscillator<double> link, double relative, std::mt19937_64* random) {
  std::normal_distribution<double> normal(1, relative);
  link.k *= normal(*random);
  for (Slider<double>& slider : link.sliders()) {
    slider.k *= normal(*random);
    slider.T0 *= normal(*random);
  }
  return link;
}

/// A decay from some 27 mm that starts at rest there, read with a noise of 0.013 mm and a zero that is off by 0.2 mm.
Record MakeRecord(const Oscillator<double>& link, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  const double y0 = 0.027 + 0.0005 * normal(*random), zero = 0.0002 * normal(*random);
  Trajectory<double> run;
  Solve(link, AtExtremum(link, y0), 9, &run);
  Record record;
  record.file = "decay.txt";
  record.direction = Direction::kLateral;
  record.sampling_hz = 200;
  for (int i = 0; i < 1800; ++i) {
    record.t.push_back(i / 200.0);
    record.y.push_back(zero + run.y(i / 200.0) + 1.3e-5 * normal(*random));
  }
  return record;
}

std::vector<Record> MakeRecords(const Oscillator<double>& link, double scatter, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Record> records;
  for (int i = 0; i < count; ++i) records.push_back(MakeRecord(Scatter(link, scatter, &random), &random));
  return records;
}

Identification IdentifyPlainly(std::vector<Record> records, int sliders, int threads = 1) {
  IdentifyOptions options;
  options.sliders = sliders;
  options.starts.count = 0;
  options.threads = threads;
  return Identify(Direction::kLateral, std::move(records), options);
}

TEST(Sharing, ErrsAsOftenAsItSays) {
  // p-values of records that do share a link are uniform: Kolmogorov's distance of n of them from the straight line is
  // below 1.63/sqrt(n) in 99 of 100 cases.
  constexpr int kCases = 120;
  std::vector<double> p;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const Identification id = IdentifyPlainly(MakeRecords(Lateral(), 0, 3, 1000 + seed), 1);
    ASSERT_EQ(id.CountUsed(), 3) << id.records[0].reason;
    EXPECT_EQ(id.sharing.dof, 6);
    p.push_back(id.sharing.p_value);
  }
  std::sort(p.begin(), p.end());
  double distance = 0;
  for (std::size_t i = 0; i < p.size(); ++i)
    distance = std::max({distance, std::abs(p[i] - static_cast<double>(i) / kCases),
                         std::abs(p[i] - static_cast<double>(i + 1) / kCases)});
  EXPECT_LT(distance, 1.63 / std::sqrt(static_cast<double>(kCases)));
}

TEST(Sharing, SeesAScatterOfOneTenthOfAPerCent) {
  // A record knows k to 1e-4 and better, so a thousandth is ten deviations.
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Identification id = IdentifyPlainly(MakeRecords(Lateral(), 0.001, 3, 2000 + seed), 1);
    EXPECT_FALSE(id.shared) << seed;
    EXPECT_LT(id.sharing.p_value, 1e-6) << seed;
  }
}

void ExpectSame(const Identification& a, const Identification& b, double relative) {
  ASSERT_EQ(a.quantities.size(), b.quantities.size());
  for (std::size_t q = 0; q < a.quantities.size(); ++q) {
    const Estimate &x = a.quantities[q], &y = b.quantities[q];
    EXPECT_NEAR(x.value, y.value, relative * x.value) << q;
    // Bounds are walked to within a hundredth of their distance.
    EXPECT_NEAR(x.low, y.low, relative * x.value + 0.02 * (x.value - x.low)) << q;
    EXPECT_NEAR(x.high, y.high, relative * x.value + 0.02 * (x.high - x.value)) << q;
    EXPECT_NEAR(x.std, y.std, 1e-3 * x.std) << q;
    EXPECT_NEAR(x.spread, y.spread, 1e-3 * x.value * relative + 1e-3 * x.spread) << q;
  }
  EXPECT_NEAR(a.rms, b.rms, 1e-6 * a.rms);
}

struct Kind {
  const char* name;
  Oscillator<double> link;
  double scatter;
};
class EveryKind : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(OneOrTwoSliders, EveryKind,
                         testing::Values(Kind{"one_shared", Lateral(), 0}, Kind{"one_scattered", Lateral(), 0.02},
                                         Kind{"two_shared", Longitudinal(), 0},
                                         Kind{"two_scattered", Longitudinal(), 0.02}),
                         [](const auto& kind) { return std::string(kind.param.name); });

TEST_P(EveryKind, DoesNotDependOnTheOrderOfTheRecords) {
  const int sliders = GetParam().link.size();
  std::vector<Record> records = MakeRecords(GetParam().link, GetParam().scatter, 5, 3);
  const Identification forth = IdentifyPlainly(records, sliders);
  std::reverse(records.begin(), records.end());
  const Identification back = IdentifyPlainly(records, sliders);
  EXPECT_EQ(forth.shared, GetParam().scatter == 0);
  // Several sliders are fitted to a millionth of the sum of squares, some hundredths of a standard deviation.
  ExpectSame(forth, back, sliders == 1 ? 1e-7 : 2e-4);
}

TEST_P(EveryKind, DoesNotDependOnTheNumberOfThreads) {
  const std::vector<Record> records = MakeRecords(GetParam().link, GetParam().scatter, 4, 4);
  const int sliders = GetParam().link.size();
  // Only the order of sums over records may differ.
  ExpectSame(IdentifyPlainly(records, sliders, 1), IdentifyPlainly(records, sliders, 3), 1e-9);
}

TEST_P(EveryKind, HasACovarianceThatIsOne) {
  const Identification id =
      IdentifyPlainly(MakeRecords(GetParam().link, GetParam().scatter, 4, 5), GetParam().link.size());
  const Eigen::Index size = 1 + 2 * GetParam().link.size();
  ASSERT_EQ(id.covariance.rows(), size);
  ASSERT_EQ(id.covariance.cols(), size);
  EXPECT_TRUE(id.covariance.isApprox(id.covariance.transpose(), 1e-12));
  const Eigen::VectorXd deviations = id.covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      deviations.cwiseInverse().asDiagonal() * id.covariance * deviations.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  EXPECT_GT(eigen.eigenvalues().minCoeff(), -1e-9);  // rounding of correlations near one
  // The same deviations as in the table of quantities: k, k_i, T0i come first in both.
  for (Eigen::Index q = 0; q < size; ++q) {
    const Estimate& e = id.quantities[static_cast<std::size_t>(q)];
    EXPECT_NEAR(deviations(q), e.std, 0.02 * e.std) << q;
  }
}

TEST(JointFit, OfOneRecordIsItsOwn) {
  const Identification id = IdentifyPlainly(MakeRecords(Lateral(), 0, 1, 6), 1);
  ASSERT_EQ(id.CountUsed(), 1);
  const RecordResult& record = id.records[0];
  EXPECT_EQ(id.rms, record.rms);
  for (std::size_t q = 0; q < id.quantities.size(); ++q) {
    EXPECT_EQ(id.quantities[q].value, record.own_quantities[q].value) << q;
    EXPECT_NEAR(id.quantities[q].low, record.own_quantities[q].low, 1e-12) << q;
    EXPECT_NEAR(id.quantities[q].high, record.own_quantities[q].high, 1e-12) << q;
    EXPECT_EQ(id.quantities[q].spread, 0) << q;
  }
}

TEST(JointFit, KnowsASharedLinkBetterThanItsRecords) {
  const Identification id = IdentifyPlainly(MakeRecords(Lateral(), 0, 9, 7), 1);
  ASSERT_TRUE(id.shared);
  double own = 0;
  for (const RecordResult& record : id.records) own += record.own_quantities[0].std / 9;
  EXPECT_NEAR(id.quantities[0].std, own / 3,
              0.1 * own / 3);  // nine equally good records: a third; they differ by some %
}

TEST(JointFit, DescribesScatterByMeanAndSpread) {
  constexpr int kRecords = 12;
  constexpr double kScatter = 0.02;
  const Identification id = IdentifyPlainly(MakeRecords(Longitudinal(), kScatter, kRecords, 8), 2);
  ASSERT_FALSE(id.shared);
  // The spread of k from twelve records: a deviation of 1/sqrt(2 * 11) = 21 %, three of these.
  EXPECT_NEAR(id.quantities[0].spread / id.quantities[0].value, kScatter, 0.65 * kScatter);
  double sum = 0;
  for (const RecordResult& record : id.records) sum += std::log(record.link.k) / kRecords;
  EXPECT_NEAR(std::log(id.quantities[0].value), sum, 1e-4);  // records of equal weight: the mean logarithm
  EXPECT_NEAR(id.quantities[0].std, id.quantities[0].spread / std::sqrt(kRecords), 0.01 * id.quantities[0].std);
  // Single sliders scatter by as much, and the records of this noise know them.
  for (const std::size_t q : {1, 2, 3, 4}) {
    EXPECT_NEAR(id.quantities[q].spread / id.quantities[q].value, kScatter, 0.65 * kScatter) << q;
    EXPECT_NEAR(id.quantities[q].value, CalcQuantity(Longitudinal(), static_cast<int>(q)),
                4 * kScatter / std::sqrt(kRecords) * id.quantities[q].value)
        << q;
  }
  // Each record keeps the link that describes it down to its noise.
  for (const RecordResult& record : id.records) EXPECT_NEAR(record.rms / record.noise.sigma, 1, 0.06);
}

TEST(SliderChoice, TakesOneWhereThereIsOne) {
  int right = 0;
  constexpr unsigned kCases = 20;
  for (unsigned seed = 0; seed < kCases; ++seed) {
    const Identification id =
        IdentifyPlainly(MakeRecords(Lateral(), seed % 2 == 0 ? 0 : 0.02, 2, 9000 + seed), kAutoSliders);
    right += id.sliders == 1 ? 1 : 0;
    EXPECT_EQ(id.choices.size(), 4u);
  }
  EXPECT_GE(right, 19);
}

TEST(SliderChoice, TakesTwoWhereThereAreTwo) {
  int right = 0;
  for (unsigned seed = 0; seed < 5; ++seed)
    right += IdentifyPlainly(MakeRecords(Longitudinal(), 0.02, 2, 9500 + seed), kAutoSliders).sliders == 2 ? 1 : 0;
  EXPECT_GE(right, 4);
}

}  // namespace
}  // namespace uiclink
