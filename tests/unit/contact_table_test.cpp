#include "vehicle/contact/contact_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"
#include "vehicle/contact/calc_contact_table.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

TrackGeometry Geometry(const std::string& name) {
  return ReadTrackGeometry(std::filesystem::path(UICLINK_SOURCE_DIR) / "data/geometry" / (name + ".toml"));
}

std::string MessageOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// A table of 4 rows with values that need all their digits.
ContactTable SmallTable() {
  ContactTable table{.name = "small", .r0 = 0.46, .shear_modulus = 82.68e9, .rows = {}};
  for (const double y : {-2e-3, 0.1e-3, 0.1e-3, 2e-3}) {
    const double t = y / 3;
    table.rows.push_back({.y = y,
                          .a_wheel = 0.75 + t,
                          .a_rail = 0.75 - t,
                          .r = 0.46 + t,
                          .z_rail = -1e-4 / 3 + t,
                          .delta = 0.025 + t,
                          .c11 = 4.2 + t,
                          .c22 = 3.7 - t,
                          .c23 = 1.5 + t,
                          .a_e = 2e-3 + 0.1 * t,
                          .b_e = 1e-3 + 0.1 * t,
                          .q0 = 1e-5 / 7,
                          .n0 = 5013.1 + t,
                          .z_lift = -t * t,
                          .phi_roll = t});
  }
  return table;
}

bool SameBits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

void ExpectSameBits(const ContactTable& a, const ContactTable& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_TRUE(SameBits(a.r0, b.r0) && SameBits(a.shear_modulus, b.shear_modulus));
  ASSERT_EQ(a.rows.size(), b.rows.size());
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    for (const ContactColumn& column : kContactColumns)
      ASSERT_TRUE(SameBits(a.rows[i].*column.value, b.rows[i].*column.value)) << column.name << " of row " << i;
  }
}

// --- text ---

TEST(ContactTableText, ReadsBackBitByBit) {
  const ContactTable table = CalcContactTable(Geometry("nominal-1435"));
  ExpectSameBits(ParseContactTable(FormatContactTable(table), "table"), table);
}

TEST(ContactTableText, ReadsBackFromAFile) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("contact_table_test." + std::to_string(::getpid()));
  WriteFileWhole(folder / "table.txt", FormatContactTable(SmallTable()));
  const ContactTable table = ReadContactTable(folder / "table.txt");
  std::filesystem::remove_all(folder);
  ExpectSameBits(table, SmallTable());
}

constexpr const char* kHead = "# name: t\n# r0: 0.46\n# shear_modulus: 8e10\n";
constexpr const char* kColumns = "y a_wheel a_rail r z_rail delta c11 c22 c23 a_e b_e q0 n0 z_lift phi_roll\n";
constexpr const char* kRowLeft = "-1e-3 0.75 0.751 0.459 0 0.02 4 3.6 1.4 2e-3 2e-3 1e-5 5e3 0 0\n";
constexpr const char* kRowRight = "1e-3 0.74 0.741 0.461 0 0.03 4 3.6 1.4 2e-3 2e-3 1e-5 5e3 0 0\n";

std::string Text(const std::string& rows) { return std::string(kHead) + kColumns + rows; }

TEST(ContactTableText, TakesColumnsInAnyOrderCommentsAndForeignLineEnds) {
  const std::string text =
      "\xef\xbb\xbf# made by hand\r\n# shear_modulus: 8e10\r\n#r0:0.46\r\n# name: of two words \r\n\r\n"
      "phi_roll\tz_lift n0 q0 b_e a_e c23 c22 c11 delta z_rail r a_rail a_wheel y\r\n"
      "0 1e-4 5e3 1e-5 2e-3 3e-3 1.4 3.6 4 0.02 -1e-4 0.459 0.751 0.75 -1e-3\r\n# between\r\n"
      "0 1e-4 5e3 1e-5 2e-3 3e-3 1.4 3.6 4 0.02 -1e-4 0.461 0.751 0.75 1e-3";
  const ContactTable table = ParseContactTable(text, "t.txt");
  EXPECT_EQ(table.name, "of two words");
  EXPECT_EQ(table.r0, 0.46);
  ASSERT_EQ(table.rows.size(), 2);
  EXPECT_EQ(table.rows[1].y, 1e-3);
  EXPECT_EQ(table.rows[1].r, 0.461);
  EXPECT_EQ(table.rows[0].a_e, 3e-3);
}

struct Fault {
  std::string text;
  std::string message;
};

TEST(ContactTableText, FaultsNameFileAndLine) {
  const std::string row = kRowLeft;
  const std::vector<Fault> faults{
      {"", "t.txt: expected a line \"# name: ...\", found none"},
      {std::string(kHead) + kRowLeft, "t.txt:4: expected the name of a column, found \"-1e-3\""},
      {"# r0: 0.5\n" + Text(row + kRowRight), "t.txt:3: expected \"# r0:\" once, found it again"},
      {"# name: t\n# shear_modulus: 8e10\n# r0: -1\n" + std::string(kColumns) + row + kRowRight,
       "t.txt:3: expected r0 > 0, found \"-1\""},
      {std::string(kHead) + "y " + kColumns + row, "t.txt:4: expected every column once, found \"y\" again"},
      {Text("1 2 3\n"), "t.txt:5: expected 15 numbers, found 3"},
      {Text(row + "1e-3 nan 0.741 0.461 0 0.03 4 3.6 1.4 2e-3 2e-3 1e-5 5e3 0 0\n"),
       "t.txt:6: expected a number > 0 as a_wheel, found \"nan\""},
      {Text(row + "1e-3 0.75 0.741 0.461 inf 0.03 4 3.6 1.4 2e-3 2e-3 1e-5 5e3 0 0\n"),
       "t.txt:6: expected a finite number as z_rail, found \"inf\""},
      {Text(row + "1e-3 0.75 0.741 0.461 0 0.03 4 3.6 1.4 2e-3 2e-3 0 5e3 0 0\n"),
       "t.txt:6: expected a number > 0 as q0, found \"0\""},
      {Text(row + "1e-3 0.75 0.741 0.461 0 2 4 3.6 1.4 2e-3 2e-3 1e-5 5e3 0 0\n"),
       "t.txt:6: expected an angle between -pi/2 and pi/2 [rad] as delta, found \"2\""},
      {Text(std::string(kRowRight) + row), "t.txt:6: expected rows by increasing y, found -0.001 after 0.001"},
      {Text(row + row + row + kRowRight), "t.txt:7: expected at most two rows at one y, found a third at -0.001"},
      {Text(row), "t.txt: expected two rows or more, found 1"},
      {Text(row + row), "t.txt: expected y on both sides of zero"},
  };
  for (const Fault& fault : faults)
    EXPECT_THAT(MessageOf([&] { ParseContactTable(fault.text, "t.txt"); }), StartsWith(fault.message));
  EXPECT_THAT(MessageOf([&] { ParseContactTable(std::string(kHead) + "y r\n", "t.txt"); }),
              HasSubstr("t.txt:4: expected a column \"phi_roll\", found none"));
}

TEST(ContactTableText, TellsAllFaultsAtOnceButNotThousands) {
  std::string rows;
  for (int i = 0; i < 1000; ++i) rows += "1 2 3\n";
  const std::string message = MessageOf([&] { ParseContactTable(Text(rows), "t.txt"); });
  EXPECT_THAT(message, HasSubstr("t.txt:6: expected 15 numbers, found 3"));
  EXPECT_THAT(message, HasSubstr("t.txt: and 980 more"));
}

TEST(ContactTableText, AMissingFileIsAnInputError) {
  EXPECT_THAT(MessageOf([] { ReadContactTable("/nowhere/table.txt"); }), HasSubstr("/nowhere/table.txt: expected"));
}

TEST(ContactTableText, WritesNothingThatItCannotRead) {
  ContactTable table = SmallTable();
  table.rows[1].q0 = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(FormatContactTable(table), std::invalid_argument);
  table = SmallTable();
  table.name = "two\nlines";
  EXPECT_THROW(FormatContactTable(table), std::invalid_argument);
  table = SmallTable();
  std::swap(table.rows[0], table.rows[3]);
  EXPECT_THROW(FormatContactTable(table), std::invalid_argument);
}

/// Damaged files: either a table that obeys the rules, or an InputError; nothing else, and no crash.
TEST(ContactTableText, SurvivesDamage) {
  const std::string whole = FormatContactTable(SmallTable());
  std::mt19937 random(20031);
  const auto below = [&](std::size_t n) { return random() % n; };
  int read = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string text = whole;
    for (std::size_t edits = 1 + below(4); edits > 0 && !text.empty(); --edits) {
      const std::size_t at = below(text.size());
      switch (below(4)) {
        case 0:
          text[at] = static_cast<char>(below(256));
          break;
        case 1:
          text.erase(at, 1 + below(30));
          break;
        case 2:
          text.insert(at, text.substr(below(text.size()), below(40)));
          break;
        default:
          text.resize(std::max<std::size_t>(at, 1));
      }
    }
    try {
      const ContactTable table = ParseContactTable(text, "damaged");
      ASSERT_GE(table.rows.size(), 2);
      ASSERT_TRUE(std::ranges::is_sorted(table.rows, {}, &ContactRow::y));
      for (const ContactRow& row : table.rows) ASSERT_TRUE(row.r > 0 && row.q0 > 0 && std::isfinite(row.z_lift));
      ++read;
    } catch (const InputError& error) {
      ASSERT_THAT(error.what(), StartsWith("damaged:"));
    }
  }
  EXPECT_GT(read, 200);  // damage inside a comment or a digit leaves a table
}

// --- geometry files ---

TEST(GeometryFile, HasMetresAndNewtons) {
  const TrackGeometry geometry = Geometry("nominal-1435");
  EXPECT_EQ(geometry.name, "nominal-1435");
  EXPECT_EQ(geometry.gauge, 1.435);
  EXPECT_EQ(geometry.gauge_depth, 0.014);
  EXPECT_EQ(geometry.r0, 0.46);
  EXPECT_EQ(geometry.contact, ContactModel::kElastic);
  EXPECT_NEAR(geometry.wheel_load, (13563.0 / 4 + 1022.0 / 2) * 9.82, 0.05);  // six digits in the file
  const TrackGeometry rigid = Geometry("nominal-1435-rigid");
  EXPECT_EQ(rigid.contact, ContactModel::kRigid);
  EXPECT_NEAR(rigid.wheel_load, 1022 * 9.82 / 2, 1e-9);
  EXPECT_NEAR(geometry.shear_modulus(), 8.27e10, 0.005e10);  // the thesis, 3.2, to its digits
}

TEST(GeometryFile, ThesisEquivalentDiffersByOneNumberAndTheRadius) {
  for (const std::string contact : {"", "-rigid"}) {
    const TrackGeometry thesis = Geometry("thesis-equivalent" + contact);
    const TrackGeometry nominal = Geometry("nominal-1435" + contact);
    EXPECT_GT(thesis.rail_offset, 0);
    EXPECT_EQ(thesis.r0, 0.425);
    EXPECT_EQ(thesis.gauge, nominal.gauge);
    EXPECT_EQ(thesis.back_to_back, nominal.back_to_back);
    EXPECT_EQ(thesis.cant, nominal.cant);
    EXPECT_EQ(thesis.wheel, nominal.wheel);
    EXPECT_EQ(thesis.rail, nominal.rail);
    EXPECT_EQ(thesis.contact, nominal.contact);
    EXPECT_EQ(thesis.wheel_load, nominal.wheel_load);
  }
}

TEST(GeometryFile, TellsAllFaults) {
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("geometry_test." + std::to_string(::getpid()) + ".toml");
  WriteFileWhole(file,
                 "name = \"x\"\nsource = \"y\"\ngauge_mm = -1\ngauge_depth_mm = 14\ncant = 0.025\nrail_offset_mm = 0\n"
                 "back_to_back_mm = 1360\ntape_circle_mm = 70\nr0_mm = 460\nwheel = \"S1003\"\nrail = \"UIC60\"\n"
                 "contact = \"soft\"\nwheel_load_N = 5000\nyoung = 21e10\npoisson = 0.27\ny_max_mm = 9\nrows = 7.5\n"
                 "colour = 3\n");
  const std::string message = MessageOf([&] { ReadTrackGeometry(file); });
  std::filesystem::remove(file);
  EXPECT_THAT(message, HasSubstr(":3: expected 300 <= gauge_mm <= 3000 [mm], found -1"));
  EXPECT_THAT(message, HasSubstr(":10: expected \"S1002\", \"UIC60\", \"60E1\" or a file of points beside this file"));
  EXPECT_THAT(message, HasSubstr(":12: expected one of \"rigid\", \"elastic\", found \"soft\""));
  EXPECT_THAT(message, HasSubstr(":17: expected a whole number"));
  EXPECT_THAT(message, HasSubstr(":18: expected a known key"));
}

// --- the computed table ---

class ComputedTable : public testing::TestWithParam<std::pair<const char*, ContactModel>> {
 protected:
  ComputedTable() : geometry_(Geometry(GetParam().first)) {
    geometry_.contact = GetParam().second;
    table_ = CalcContactTable(geometry_, notes_);
  }
  /// Rows but those at and beside jumps.
  std::vector<std::size_t> SmoothRows() const {
    std::vector<std::size_t> smooth;
    const auto& rows = table_.rows;
    for (std::size_t i = 1; i + 1 < rows.size(); ++i) {
      if (rows[i - 1].y < rows[i].y && rows[i].y < rows[i + 1].y) smooth.push_back(i);
    }
    return smooth;
  }

  TrackGeometry geometry_;
  ContactNotes notes_;
  ContactTable table_;
};

class RigidTable : public ComputedTable {};  ///< elastic contact has the same poses

TEST_P(ComputedTable, HasTheRowsAskedFor) {
  const std::size_t jumps = notes_.jumps.size();
  EXPECT_EQ(table_.rows.size(), static_cast<std::size_t>(geometry_.rows) + 2 * jumps);
  EXPECT_EQ(jumps > 0, geometry_.contact == ContactModel::kRigid);
  EXPECT_EQ(table_.rows.front().y, -geometry_.y_max);
  EXPECT_EQ(table_.rows.back().y, geometry_.y_max);
  EXPECT_TRUE(std::ranges::is_sorted(table_.rows, {}, &ContactRow::y));
}

TEST_P(ComputedTable, CarriesTheWheelLoadVertically) {
  for (const ContactRow& row : table_.rows)
    ASSERT_NEAR(row.n0 * std::cos(row.delta + row.phi_roll), geometry_.wheel_load, 1e-6) << row.y;  // [N], rounding
}

TEST_P(ComputedTable, PosesAreMirrored) {
  // Rows of the regular grid at y and -y are made from one pose.
  for (const ContactRow& row : table_.rows) {
    const auto [low, high] = std::ranges::equal_range(table_.rows, -row.y, {}, &ContactRow::y);
    if (low == high) continue;  // a jump of one wheel
    ASSERT_EQ(low->z_lift, row.z_lift);
    ASSERT_EQ(low->phi_roll, -row.phi_roll);
  }
}

/// The point on the wheel is the point on the rail: y + a cos(phi) + r sin(phi) = a_rail, and in height
/// r0 + z_lift + a sin(phi) - r cos(phi) = z_rail. For means over an elastic contact the first holds as it is, and the
/// second to the mean gap, below the approach.
TEST_P(ComputedTable, WheelAndRailPointCoincide) {
  const bool rigid = geometry_.contact == ContactModel::kRigid;
  for (const ContactRow& row : table_.rows) {
    const double c = std::cos(row.phi_roll);
    const double s = std::sin(row.phi_roll);
    ASSERT_NEAR(row.y + row.a_wheel * c + row.r * s, row.a_rail, 1e-12) << row.y;
    const double gap = geometry_.r0 + row.z_lift + row.a_wheel * s - row.r * c - row.z_rail;
    // Rigid: the search stops at a few 1e-12 m. S1002's step of 0.1 um is between two limits of one point.
    ASSERT_GE(gap, -1e-10) << row.y;
    ASSERT_LE(gap, rigid ? 2e-7 : row.q0 / std::cos(row.delta + row.phi_roll)) << row.y;
  }
}

/// Virtual work of the rigid constraint: both contact points slide along the rails, so that
///   dz + a dphi = (dy - r' dphi) tan(delta_left + phi)   on the left and its mirror image on the right,
/// with a, r' the horizontal and vertical distance of the contact point in the track frame.
TEST_P(RigidTable, LiftAndRollFollowTheContactAngles) {
  const auto& rows = table_.rows;
  int compared = 0;
  for (const std::size_t i : SmoothRows()) {
    if (std::abs(rows[i].y) > 4.5e-3) continue;  // the tread; beyond, y moves through the root within a row or two
    const auto right = std::ranges::lower_bound(rows, -rows[i].y, {}, &ContactRow::y);
    if (std::abs(right->y + rows[i].y) > 1e-12) continue;
    const ContactRow& l = rows[i];
    const ContactRow& r = *right;
    const double span = rows[i + 1].y - rows[i - 1].y;
    const double dz = (rows[i + 1].z_lift - rows[i - 1].z_lift) / span;
    const double dphi = (rows[i + 1].phi_roll - rows[i - 1].phi_roll) / span;
    const double tan_l = std::tan(l.delta + l.phi_roll);
    const double tan_r = std::tan(r.delta + r.phi_roll);
    const double arm_l = l.a_rail - l.y, arm_r = r.a_rail + l.y;
    const double down_l = geometry_.r0 + l.z_lift - l.z_rail, down_r = geometry_.r0 + l.z_lift - r.z_rail;
    // A jump of the right wheel within the span bends z and phi.
    const bool kink = std::ranges::any_of(
        notes_.jumps, [&](const Jump& j) { return std::abs(std::abs(j.y) - std::abs(l.y)) < 1.5 * span; });
    if (kink) continue;
    // Central differences over 10 um: error (10 um)^2/6 times the third derivative, 1/m^2 ... 3e4/m^2 on the tread.
    EXPECT_NEAR(dz + arm_l * dphi, (1 + down_l * dphi) * tan_l, 2e-6) << l.y;
    EXPECT_NEAR(dz - arm_r * dphi, -(1 + down_r * dphi) * tan_r, 2e-6) << l.y;
    ++compared;
  }
  EXPECT_GT(compared, 700);
}

TEST_P(ComputedTable, IsContinuousOnTheTread) {
  const auto& rows = table_.rows;
  const double first_flange_jump = geometry_.rail_offset + 4.5e-3;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].y == rows[i - 1].y || rows[i].y > first_flange_jump) continue;
    // Per row of 10 um. Rigid: dr/dy = tan(delta) da/dy, at most 0.35 on the tread. Elastic contact passes the crown's
    // jump of 10 mm on the wheel (0.45 mm of r) within 0.2 mm of y: twenty rows of 0.02 mm.
    ASSERT_LT(std::abs(rows[i].r - rows[i - 1].r), geometry_.contact == ContactModel::kRigid ? 4e-6 : 40e-6)
        << rows[i].y;
    ASSERT_LT(std::abs(rows[i].q0 / rows[i - 1].q0 - 1), 0.05) << rows[i].y;
  }
}

TEST_P(ComputedTable, IsDeterministic) {
  EXPECT_EQ(FormatContactTable(CalcContactTable(geometry_)), FormatContactTable(table_));
}

TEST_P(ComputedTable, StatesTheSecondContactInTheFlangeRoot) {
  // Between the last tread contact and the first one in the root both carry load.
  const bool found = std::ranges::any_of(notes_.two_point, [](const TwoPointContact& two) {
    return std::min(two.touching.delta, two.second.delta) < 0.15 &&
           std::max(two.touching.delta, two.second.delta) > 0.25;
  });
  EXPECT_TRUE(found);
  for (const TwoPointContact& two : notes_.two_point) EXPECT_LT(two.gap, two.approach);
}

std::string NameOf(const testing::TestParamInfo<std::pair<const char*, ContactModel>>& instance) {
  std::string name = instance.param.first;
  std::erase(name, '-');
  return name + (instance.param.second == ContactModel::kRigid ? "Rigid" : "Elastic");
}
INSTANTIATE_TEST_SUITE_P(Geometries, ComputedTable,
                         testing::Values(std::pair{"nominal-1435-rigid", ContactModel::kRigid},
                                         std::pair{"nominal-1435-rigid", ContactModel::kElastic},  // 5 kN
                                         std::pair{"nominal-1435", ContactModel::kElastic},        // 38 kN
                                         std::pair{"thesis-equivalent-rigid", ContactModel::kRigid},
                                         std::pair{"thesis-equivalent", ContactModel::kElastic}),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Geometries, RigidTable,
                         testing::Values(std::pair{"nominal-1435-rigid", ContactModel::kRigid},
                                         std::pair{"thesis-equivalent-rigid", ContactModel::kRigid}),
                         NameOf);

TEST(CalcContactTable, FollowsTheHertzianScalesOfItsLoad) {
  TrackGeometry geometry = Geometry("nominal-1435-rigid");
  geometry.rows = 181;
  const ContactTable light = CalcContactTable(geometry);
  geometry.wheel_load *= 8;
  const ContactTable heavy = CalcContactTable(geometry);
  ASSERT_EQ(light.rows.size(), heavy.rows.size());
  for (std::size_t i = 0; i < light.rows.size(); ++i) {
    const ContactRow& l = light.rows[i];
    if (l.y > -2e-3 && l.y < 2e-3) continue;  // the crown's curvature is that of the whole ellipse
    if (l.y > 4.5e-3) continue;
    EXPECT_EQ(heavy.rows[i].r, l.r);
    EXPECT_NEAR(heavy.rows[i].q0 / l.q0, 4, 4 * 0.02) << l.y;  // the tread's curvature changes by 5 % over the ellipse
  }
}

TEST(CalcContactTable, SaysThatTheWheelsetDoesNotFit) {
  TrackGeometry geometry = Geometry("nominal-1435");
  geometry.gauge = 1.2;
  EXPECT_THROW(CalcContactTable(geometry), std::invalid_argument);
  geometry = Geometry("nominal-1435");
  geometry.rows = 2;
  EXPECT_THROW(CalcContactTable(geometry), std::invalid_argument);
}

TEST(RollingRadiusDifferenceOfATable, IsOddAndHasBothWheelsJumps) {
  const TrackGeometry geometry = Geometry("nominal-1435-rigid");
  ContactNotes notes;
  const RollingRadiusDifference d = CalcRollingRadiusDifference(CalcContactTable(geometry, notes));
  ASSERT_EQ(d.y.size(), d.delta_r.size());
  std::size_t doubled = 0;
  for (std::size_t i = 0; i < d.y.size(); ++i) {
    const std::size_t mirror = d.y.size() - 1 - i;
    ASSERT_EQ(d.y[i], -d.y[mirror]);
    ASSERT_NEAR(d.delta_r[i], -d.delta_r[mirror], 1e-15);
    doubled += i > 0 && d.y[i] == d.y[i - 1];
  }
  EXPECT_EQ(doubled, 2 * notes.jumps.size());
}

}  // namespace
}  // namespace uiclink
