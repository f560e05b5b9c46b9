// What the plain model costs on the wagon, and its bounds from paired records, by hand.

#include "identify/cause_cost.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/validate.h"

namespace uiclink {
namespace {

constexpr double kStudentOfThree = 4.302653;  // two degrees of freedom, 97.5 %

/// A set whose critical speed is V = 10 + gradient (parameters), with the records that it stands on.
ValidationRow MakeRow(const char* role, const std::vector<std::string>& order, const Eigen::VectorXd& gradient,
                      double V, double half) {
  ValidationRow row{.set = {.role = role, .label = {}, .file = {}, .sha256 = {}, .set = {}},
                    .critical_speed = CriticalSpeed{},
                    .hunting = {},
                    .notices = {},
                    .failures = {}};
  row.critical_speed->value = V;
  row.critical_speed->low = V - half;
  row.critical_speed->high = V + half;
  for (std::size_t i = 0; i < order.size(); ++i)
    row.critical_speed->sensitivities.push_back(
        {Direction::kLateral, order[i], gradient[static_cast<Eigen::Index>(i)]});
  row.set.set.lateral = DirectionParameters{};
  row.set.set.lateral->covariance = Covariance{.order = order, .matrix = {}};
  return row;
}

class PairedCost : public testing::Test {
 protected:
  PairedCost() {
    plain_.set.by_record[0] = RecordValues{.order = {"k", "k1"}, .by_record = by_plain_, .common = {}};
    extended_.set.by_record[0] = RecordValues{
        .order = {"k", "k1", "rolling_friction.T_r"}, .by_record = by_extended_, .common = Eigen::Matrix3d::Zero()};
  }
  Eigen::MatrixXd by_plain_ = (Eigen::MatrixXd(3, 2) << 4.0, 1.4, 4.2, 1.5, 4.1, 1.3).finished();
  Eigen::MatrixXd by_extended_ =
      (Eigen::MatrixXd(3, 3) << 3.9, 1.3, 1e-3, 4.1, 1.4, 1e-3, 4.0, 1.2, 1e-3).finished();  // all 0.1 less
  ValidationRow plain_ = MakeRow("identified_plain", {"k", "k1"}, Eigen::Vector2d(1, 1), 6.2, 0.4);
  ValidationRow extended_ =
      MakeRow("identified", {"k", "k1", "rolling_friction.T_r"}, Eigen::Vector3d(1, 1, 20), 6.0, 0.3);
};

TEST_F(PairedCost, IsExactWhereEveryRecordSaysTheSame) {
  const CauseCost cost = CalcSpeedCost(plain_, extended_).value();
  EXPECT_NEAR(cost.difference(), 0.2, 1e-14);
  ASSERT_TRUE(cost.paired_half);
  EXPECT_NEAR(cost.half(), 0, 1e-12) << "each record's difference is 0.2, whatever the link";
  EXPECT_NEAR(cost.independent(), 0.5, 1e-14);
  EXPECT_NEAR(cost.narrowest_half(), 0.1, 1e-14);
}

TEST_F(PairedCost, IsTheStandardErrorOfTheRecordsDifferences) {
  extended_.set.by_record[0]->by_record(0, 0) += 0.03;  // differences -0.03, 0, 0 about their mean: variance 3e-4
  EXPECT_NEAR(CalcSpeedCost(plain_, extended_)->half(), kStudentOfThree * std::sqrt(3e-4 / 3), 1e-7);
}

TEST_F(PairedCost, HasTheErrorsThatRecordsHaveInCommon) {
  // T_r with an error of 1e-3 that takes k by -8 of it along: V moves by (20 - 8) 1e-3.
  const Eigen::Vector3d along(-8e-3, 0, 1e-3);
  extended_.set.by_record[0]->common = along * along.transpose();
  EXPECT_NEAR(CalcSpeedCost(plain_, extended_)->half(), 1.96 * 12e-3, 1e-12);
}

TEST_F(PairedCost, HasTheDifferenceOfTheGradientsByACommonDirection) {
  for (ValidationRow* row : {&plain_, &extended_}) {
    row->set.set.longitudinal = DirectionParameters{};
    row->set.set.longitudinal->covariance =
        Covariance{.order = {"k", "k1"}, .matrix = {{4e-4, 0}, {0, 9e-4}}, .coverage = 2.5};
    row->critical_speed->sensitivities.push_back({Direction::kLongitudinal, "k", 0.7});
  }
  EXPECT_NEAR(CalcSpeedCost(plain_, extended_)->half(), 0, 1e-12);
  extended_.critical_speed->sensitivities.back().derivative = 0.5;
  EXPECT_NEAR(CalcSpeedCost(plain_, extended_)->half(), 2.5 * 0.2 * 0.02, 1e-12);
}

TEST_F(PairedCost, IsAnUpperBoundWhereRecordsShareTheirLink) {
  extended_.set.by_record[0].reset();
  const CauseCost cost = CalcSpeedCost(plain_, extended_).value();
  EXPECT_FALSE(cost.paired_half);
  EXPECT_EQ(cost.half(), cost.independent());
}

TEST_F(PairedCost, NeedsBounds) {
  extended_.critical_speed->high.reset();
  EXPECT_FALSE(CalcSpeedCost(plain_, extended_));
}

TEST(SpeedDifferences, AreAgainstTheFirst) {
  std::vector<ValidationRow> rows;
  for (const auto& [V, half] : {std::pair{6.0, 0.3}, {6.5, 0.4}, {7.0, 0.0}}) {
    rows.push_back(MakeRow("given", {}, {}, V, half));
    if (half == 0) rows.back().critical_speed->low = rows.back().critical_speed->high = std::nullopt;
  }
  rows.insert(rows.begin() + 1, rows[0]);
  rows[1].critical_speed.reset();  // the wagon cannot run it
  const std::vector<SpeedDifference> differences = CalcSpeedDifferences(rows);
  ASSERT_EQ(differences.size(), 2u);
  EXPECT_EQ(differences[0].row, 2u);
  EXPECT_NEAR(differences[0].difference, 0.5, 1e-14);
  EXPECT_NEAR(differences[0].half.value(), 0.5, 1e-14);
  EXPECT_NEAR(differences[0].half_if_correlated.value(), 0.1, 1e-14);
  EXPECT_NEAR(differences[1].half.value(), 0.3, 1e-14) << "a set without covariance is exact";
  EXPECT_FALSE(differences[1].half_if_correlated);
  rows.erase(rows.begin());
  EXPECT_TRUE(CalcSpeedDifferences(rows).empty()) << "nothing to compare with";
}

}  // namespace
}  // namespace uiclink
