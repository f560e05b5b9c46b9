#include "vehicle/contact/contact_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "vehicle/contact/calc_contact_table.h"

namespace uiclink {
namespace {

constexpr double kKink = 1e-3;     // [m] where the made-up wheel jumps
constexpr double kShorter = 1e-3;  // [m] by which its contact point then is nearer to the centre

/// A made-up wheel whose quantities are smooth but for one jump, so that every value is known. Height and roll have the
/// symmetry of a wagon: even and odd, with kinks at the jump and at its mirror image.
ContactRow RowAt(double y, bool after_jump) {
  const double r = 0.46 + 0.05 * y + 4 * y * y;
  return {.y = y,
          .a_wheel = 0.75 - 0.5 * y - (after_jump ? kShorter : 0),
          .a_rail = 0.75 + 0.5 * y,
          .r = r + (after_jump ? 1e-4 : 0),
          .z_rail = -1e-4,
          .delta = 0.03 + 2 * y,
          .c11 = 4,
          .c22 = 3.6,
          .c23 = 1.4,
          .a_e = 3e-3,
          .b_e = 2e-3,
          .q0 = 4e-5,
          .n0 = 2e4,
          .z_lift = 0.2 * y * y + 1e-2 * std::max(0.0, std::abs(y) - kKink),
          .phi_roll = 0.03 * y};
}

ContactTable TableAt(const std::vector<double>& places, bool jumps) {
  ContactTable table{.name = "made up", .r0 = 0.46, .shear_modulus = 8e10, .rows = {}};
  bool after = false;
  for (const double y : places) {
    if (jumps && !after && y > kKink) {
      table.rows.push_back(RowAt(kKink, false));
      table.rows.push_back(RowAt(kKink, true));
      after = true;
    }
    table.rows.push_back(RowAt(y, after));
  }
  return table;
}

std::vector<double> Equal(double low, double high, int intervals) {
  std::vector<double> places;
  for (int i = 0; i <= intervals; ++i) places.push_back(low + (high - low) * i / intervals);
  return places;
}

WheelContact<double> At(const ContactCurve& curve, double y) {
  const ContactCurve::Place place = curve.Find(y);
  return ContactCurve::Evaluate(curve.cubic(place.cell), place.t);
}

KinematicPose<double> PoseAt(const ContactCurve& curve, double y) {
  const ContactCurve::Place place = curve.Find(y);
  return ContactCurve::Evaluate(curve.pose_cubic(place.cell), place.t);
}

/// The cells in which the contact jumps.
std::vector<std::size_t> JumpCells(const ContactCurve& curve) {
  std::vector<std::size_t> cells;
  for (std::size_t i = 0; i < curve.cells(); ++i)
    if (curve.after_jump(i) != nullptr) cells.push_back(i);
  return cells;
}

/// The rows themselves to rounding: a cubic of values near 1 is worth 1e-15.
constexpr double kRounding = 1e-14;

void ExpectThroughRows(const ContactCurve& curve, const ContactTable& table, double tolerance) {
  for (const ContactRow& row : table.rows) {
    const WheelContact<double> at = At(curve, row.y);
    EXPECT_NEAR(at.a, row.a_wheel, tolerance) << row.y;
    EXPECT_NEAR(at.r, row.r, tolerance) << row.y;
    EXPECT_NEAR(at.sin_delta, std::sin(row.delta), tolerance) << row.y;
    EXPECT_NEAR(PoseAt(curve, row.y).z, row.z_lift, tolerance) << row.y;
    EXPECT_NEAR(PoseAt(curve, row.y).phi, row.phi_roll, tolerance) << row.y;
  }
}

TEST(ContactCurve, GoesThroughEqualRows) {
  const ContactTable table = TableAt(Equal(-9e-3, 9e-3, 180), false);
  const ContactCurve curve(table);
  EXPECT_EQ(curve.cells(), 180);
  EXPECT_TRUE(JumpCells(curve).empty());
  ExpectThroughRows(curve, table, kRounding);
  // n = n0/q0^1.5, f11 = G c11 a b/q0, f23 = G c23 (a b/q0)^1.5; rows are equal in them.
  const WheelContact<double> at = At(curve, 0.123e-3);
  const double area = 3e-3 * 2e-3 / 4e-5;
  EXPECT_NEAR(at.n, 2e4 / std::pow(4e-5, 1.5), 1e-12 * at.n);  // rounding of the powers
  EXPECT_NEAR(at.f11, 8e10 * 4 * area, 1e-12 * at.f11);
  EXPECT_NEAR(at.f23, 8e10 * 1.4 * std::pow(area, 1.5), 1e-12 * at.f23);
}

TEST(ContactCurve, ACellWithAJumpHasBothContacts) {
  // The jump within a cell, and at a row of the regular ones (which the two rows of the jump replace).
  for (const int intervals : {181, 180}) {
    std::vector<double> places = Equal(-9e-3, 9e-3, intervals);
    std::erase_if(places, [](double y) { return std::abs(y - kKink) < 1e-9; });
    const ContactCurve curve(TableAt(places, true));
    EXPECT_EQ(curve.cells(), static_cast<std::size_t>(intervals));
    const std::vector<std::size_t> cells = JumpCells(curve);
    ASSERT_EQ(cells.size(), 1);
    const double left = curve.y_min() + static_cast<double>(cells[0]) * curve.width();
    EXPECT_LT(left, kKink);
    EXPECT_GE(left + curve.width(), kKink - kRounding);
    for (const double t : {0.0, 0.4, 1.0}) {
      const double y = left + t * curve.width();
      const WheelContact<double> before = ContactCurve::Evaluate(curve.cubic(cells[0]), t);
      const WheelContact<double> after = ContactCurve::Evaluate(*curve.after_jump(cells[0]), t);
      // a is linear in y, so that its continuation beyond the jump is known: no point between both is made.
      EXPECT_NEAR(before.a, RowAt(y, false).a_wheel, kRounding);
      EXPECT_NEAR(after.a, RowAt(y, true).a_wheel, kRounding);
    }
    // Beyond the cell there is the one after the jump alone.
    EXPECT_NEAR(At(curve, left + 1.5 * curve.width()).a, RowAt(left + 1.5 * curve.width(), true).a_wheel, kRounding);
  }
}

TEST(ContactCurve, PoseHasItsKinksWhereEitherWheelJumps) {
  std::vector<double> places = Equal(-9e-3, 9e-3, 180);
  std::erase_if(places, [](double y) { return std::abs(y - kKink) < 1e-9; });
  const ContactCurve curve(TableAt(places, true));
  // Slopes of z beside the kinks, at the ends of cells: a smoothed kink would miss them by 5e-3, half of the step.
  const auto slope = [&](double y, double side) {
    const double h = 1e-9;
    return (PoseAt(curve, y + side * h).z - PoseAt(curve, y).z) / (side * h);
  };
  for (const double e : {-1.0, 1.0}) {
    // 1e-4: 1e-9 m of the parabola, end slopes of second order and 1e-18/1e-9 of rounding are less.
    EXPECT_NEAR(e * slope(e * kKink, e), 0.4 * kKink + 1e-2, 1e-4);
    EXPECT_NEAR(e * slope(e * kKink, -e), 0.4 * kKink, 1e-4);
  }
}

TEST(ContactCurve, PoseIsSymmetric) {
  const ContactCurve curve(TableAt(Equal(-9e-3, 9e-3, 181), true));
  for (double y = 0; y < 9e-3; y += 0.37e-4) {
    const KinematicPose<double> left = PoseAt(curve, y), right = PoseAt(curve, -y);
    EXPECT_NEAR(left.z, right.z, 1e-16) << y;  // heights of 1e-4 m
    EXPECT_NEAR(left.phi, -right.phi, 1e-16) << y;
  }
}

TEST(ContactCurve, UnevenRowsKeepTheirDetail) {
  std::vector<double> places = Equal(-9e-3, 4e-3, 13);  // 1 mm apart, then 0.05 mm
  for (double y = 4.05e-3; y < 9.02e-3; y += 0.05e-3) places.push_back(y);
  const ContactTable table = TableAt(places, false);
  const ContactCurve curve(table);
  EXPECT_NEAR(curve.width(), 0.05e-3, 1e-6);
  ExpectThroughRows(curve, table, 1e-9);  // a row may stand within a cell: a cubic over 0.05 mm
}

TEST(ContactCurve, NearlyEqualRowsDoNotMakeMillionsOfCells) {
  std::vector<double> places = Equal(-9e-3, 9e-3, 18);
  places.insert(places.begin() + 5, places[5] - 1e-12);
  EXPECT_LE(ContactCurve(TableAt(places, false)).cells(), 20 * places.size());
}

TEST(ContactCurve, ATableMayReachFurtherToOneSide) {
  const ContactTable table = TableAt(Equal(-3e-3, 9e-3, 120), false);
  const ContactCurve curve(table);
  EXPECT_EQ(curve.y_min(), -3e-3);
  EXPECT_NEAR(curve.y_max(), 9e-3, 1e-17);
  ExpectThroughRows(curve, table, kRounding);
}

TEST(ContactCurve, BeyondTheTableItsEndCounts) {
  const ContactCurve curve(TableAt(Equal(-9e-3, 9e-3, 180), false));
  EXPECT_EQ(curve.Find(-1).cell, 0);
  EXPECT_EQ(curve.Find(-1).t, 0);
  EXPECT_EQ(curve.Find(1).cell, 179);
  EXPECT_NEAR(curve.Find(1).t, 1, 1e-12);
  EXPECT_EQ(curve.Find(std::numeric_limits<double>::quiet_NaN()).cell, 0);
}

TEST(ContactCurve, TakesTheSmallestTable) {
  ContactTable table = TableAt({-9e-3, 9e-3}, false);
  EXPECT_EQ(ContactCurve(table).cells(), 1);
  ExpectThroughRows(ContactCurve(table), table, kRounding);
  EXPECT_EQ(ContactCurve(TableAt({-9e-3, 9e-3}, true)).cells(), 2);  // a jump between: cells of 8 mm would be 2.25
  table.rows.pop_back();
  EXPECT_THROW(ContactCurve{table}, std::invalid_argument);
  EXPECT_THROW(ContactCurve{ContactTable{}}, std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
