// Contact mechanics against published figures: Kalker's table, and the program CONTACT on the Manchester benchmark case
// A-2.2 (S1002 on UIC60, 1:40, 10 kN on each wheel, nu = 0.28, G = 82 GPa, displacement 0 ... 10 mm, yaw 0 ... 24
// mrad).

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "vehicle/contact/calc_contact_table.h"
#include "vehicle/contact/elastic_contact.h"
#include "vehicle/contact/kalker_coefficients.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

const fs::path kReference = fs::path(UICLINK_SOURCE_DIR) / "../shared/reference";

std::vector<std::string> Split(std::string line, char separator) {
  std::vector<std::string> cells;
  if (line.ends_with('\r')) line.pop_back();
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, separator);) cells.push_back(cell);
  return cells;
}

// --- Kalker's table ---

TEST(KalkerTable, AllItsValuesComeBack) {
  std::ifstream file(kReference / "contact.md");
  if (!file) GTEST_SKIP() << "no " << kReference / "contact.md";
  int compared = 0;
  for (std::string line; std::getline(file, line);) {
    // | a/b | C11 at nu = 0, 1/4, 1/2 | C22 | C23 | C33 |
    const std::vector<std::string> cells = Split(line, '|');
    if (cells.size() != 14 || cells[1].find_first_of("0123456789") == std::string::npos) continue;
    const std::vector<std::string> quotient = Split(cells[1], '/');
    const double ratio = quotient.size() == 2 ? 1 / std::stod(quotient[1]) : std::stod(cells[1]);
    for (int k = 0; k < 3; ++k) {
      const KalkerCoefficients c = CalcKalkerCoefficients(ratio, 0.25 * k);
      const double expected[] = {std::stod(cells[2 + k]), std::stod(cells[5 + k]), std::stod(cells[8 + k])};
      const double found[] = {c.c11, c.c22, c.c23};
      for (int i = 0; i < 3; ++i, ++compared)
        EXPECT_NEAR(found[i], expected[i], 1e-13 * expected[i]) << "a/b = " << ratio << ", column " << k;  // rounding
    }
  }
  EXPECT_EQ(compared, 19 * 9);
}

// --- CONTACT ---

/// One wheel of one case, told as the left wheel: y > 0 moves its flange to the rail.
struct BenchmarkCase {
  double y = 0;         ///< [m]
  double yaw = 0;       ///< [rad]
  double a_rail = 0;    ///< from the track centre [m]
  double y_wheel = 0;   ///< from the tape circle [m]
  double force = 0;     ///< normal [N]
  double approach = 0;  ///< [m]
  double pressure = 0;  ///< greatest [N/m^2]
  double area = 0;      ///< [m^2]
};

std::vector<BenchmarkCase> ReadBenchmark() {
  std::ifstream file(kReference / "profiles/mbench_a22_contact_results.csv");
  std::string line;
  if (!std::getline(file, line)) return {};
  std::map<std::string, std::size_t> column;
  for (const std::string& name : Split(line, ',')) column.emplace(name, column.size());
  std::vector<BenchmarkCase> cases;
  while (std::getline(file, line)) {
    const std::vector<std::string> cells = Split(line, ',');
    const auto number = [&](const std::string& name) { return std::stod(cells[column.at(name)]); };
    const double side = cells[column.at("side")] == "right" ? 1 : -1;  // of CONTACT, whose y is positive to the right
    cases.push_back({.y = side * number("y_ws_mm") / 1e3,
                     .yaw = number("yaw_rad"),
                     .a_rail = side * number("ycp_tr_mm") / 1e3,
                     .y_wheel = side * number("ycp_w_mm") / 1e3,
                     .force = number("fn_N"),
                     .approach = number("approach_mm") / 1e3,
                     .pressure = number("pmax_Npmm2") * 1e6,
                     .area = number("contact_area_mm2") / 1e6});
  }
  return cases;
}

class ManchesterBenchmark : public testing::Test {
 protected:
  void SetUp() override {
    if (cases_.empty()) GTEST_SKIP() << "no reference in " << kReference;
  }
  static TrackGeometry Geometry() {
    return ReadTrackGeometry(fs::path(UICLINK_SOURCE_DIR) / "data/geometry/nominal-1435-rigid.toml");
  }

  std::vector<BenchmarkCase> cases_ = ReadBenchmark();
  WheelsetOnRails wheelset_{Geometry()};
  ElasticMaterial material_{.young = 2 * 82e9 * 1.28, .poisson = 0.28};
};

/// A wheel of the benchmark with our contact, under CONTACT's normal force (friction takes part in carrying its load).
struct Comparison {
  BenchmarkCase contact;
  HertzContact hertz;
  ElasticContact elastic;
  double track_angle = 0;  ///< [rad]
  double spread = 0;  ///< change of the relative curvature from one end of the ellipse to the other, over its value

  /// Hertz's assumption is that the spread is zero.
  bool OnTread() const { return std::abs(track_angle) < 0.15; }
};

class Compared : public ManchesterBenchmark {
 protected:
  std::vector<Comparison> Compare() const {
    std::vector<Comparison> comparisons;
    for (const BenchmarkCase& c : cases_) {
      const KinematicContact k = FindKinematicContact(wheelset_, c.y);
      const ContactCandidate& point = k.left[0];
      Comparison result;
      result.contact = c;
      result.hertz = CalcRigidEllipse(wheelset_, point, c.y, k.phi_roll, k.z_lift, c.force, material_);
      result.track_angle = point.delta + k.phi_roll;
      result.elastic = CalcElasticContact(wheelset_, {.y = c.y, .phi = k.phi_roll, .z_lift = k.z_lift}, k.left,
                                          c.force * std::cos(result.track_angle), material_);
      const double across = result.hertz.b * std::cos(point.delta);
      const auto second = [&](double shift) {
        return wheelset_.EvalGap(WheelSide::kLeft, point.y_wheel + shift, c.y, k.phi_roll).gap_second;
      };
      result.spread = std::abs(second(across) - second(-across)) * std::pow(std::cos(point.delta), 3) /
                      (point.curvature_wheel + point.curvature_rail);
      comparisons.push_back(result);
    }
    return comparisons;
  }
};

/// Where the relative curvature across rolling changes by less than half of itself over the ellipse: y = -10 ... -6 mm
/// and 2.5 ... 4 mm. CONTACT solves the elastic half-space on the true gap with elements of 0.2 mm, and prints four
/// digits; approach differs by 0.1 %, pressure by 0.5 % (greatest pressure of an element, not of a point).
TEST_F(Compared, ApproachAndPressureAreHertzWhereTheCurvatureIsNearlyConstant) {
  int compared = 0;
  for (const Comparison& c : Compare()) {
    if (!c.OnTread() || c.spread > 0.5) continue;
    EXPECT_NEAR(c.hertz.approach / c.contact.approach, 1, 0.002) << "y = " << c.contact.y;
    EXPECT_NEAR(c.hertz.pressure / c.contact.pressure, 1, 0.005) << "y = " << c.contact.y;
    ++compared;
  }
  EXPECT_EQ(compared, 13);
}

/// Where it changes by up to its own value: y = -10 ... -1.5 mm and 2.5 ... 4.5 mm, all of the tread but the crown and
/// the step of the rail's curvature next to it.
TEST_F(Compared, ApproachIsStillHertzWhereTheCurvatureChangesByItsOwnValue) {
  int compared = 0;
  for (const Comparison& c : Compare()) {
    if (!c.OnTread() || c.spread > 1) continue;
    EXPECT_NEAR(c.hertz.approach / c.contact.approach, 1, 0.005) << "y = " << c.contact.y;
    EXPECT_NEAR(c.hertz.pressure / c.contact.pressure, 1, 0.007) << "y = " << c.contact.y;
    ++compared;
  }
  EXPECT_EQ(compared, 23);
}

/// On the crown (y = 0, two minima of the gap 10 mm apart, one patch) Hertz is off by 10 %; virtual penetration by 2.5
/// %.
TEST_F(Compared, TheCrownAsksForElasticContact) {
  for (const Comparison& c : Compare()) {
    if (std::abs(c.contact.y) > 1e-6) continue;
    EXPECT_GT(c.hertz.approach / c.contact.approach, 1.09);
    EXPECT_NEAR(c.elastic.approach / c.contact.approach, 1, 0.025);
    EXPECT_NEAR(1.5 * c.contact.force / (std::acos(-1) * c.elastic.a * c.elastic.b) / c.contact.pressure, 1, 0.01);
  }
}

/// Virtual penetration on the tread: its own error against Hertz is 3 % (unit test), and so it is here. The area is
/// counted in elements of 0.2 mm by CONTACT, which are 2 % more than those of Hertz.
TEST_F(Compared, VirtualPenetrationIsWithinItsOwnErrorOnTheTread) {
  for (const Comparison& c : Compare()) {
    if (!c.OnTread() || c.spread > 1) continue;
    EXPECT_NEAR(c.elastic.approach / c.contact.approach, 1, 0.03) << "y = " << c.contact.y;
    EXPECT_NEAR(std::acos(-1) * c.elastic.a * c.elastic.b / c.contact.area, 1, 0.05) << "y = " << c.contact.y;
  }
}

/// CONTACT's position is the weighted centre of the contact, as that of elastic contact here. Compared where it does
/// not jump within reach of the ellipse (jumps at 0.21 and 4.85 mm) and yaw is up to 12 mrad: the wheelset's cosine
/// then draws the wheels 0.05 mm inward, which the table does not know.
TEST_F(Compared, ElasticPositionsAreThoseOfContactAwayFromJumps) {
  int compared = 0;
  for (const Comparison& c : Compare()) {
    const double y = c.contact.y;
    if (y < -5.01e-3 || (y > -0.99e-3 && y < 1.49e-3) || y > 4.01e-3) continue;
    EXPECT_NEAR(c.elastic.a_rail, c.contact.a_rail, 0.06e-3) << "y = " << y;
    EXPECT_NEAR(c.elastic.a_wheel - 0.75, c.contact.y_wheel, 0.07e-3) << "y = " << y;
    ++compared;
  }
  EXPECT_EQ(compared, 15);
}

// --- conicity of our pair ---

/// "About 0.18 at 3 mm" is the usual figure for S1002 on UIC60, 1:40, 1435 mm; from CONTACT's rolling radii in steps of
/// 0.5 mm it is 0.182.
TEST(NominalGeometry, HasTheUsualConicityAtThreeMillimetres) {
  TrackGeometry geometry = ReadTrackGeometry(fs::path(UICLINK_SOURCE_DIR) / "data/geometry/nominal-1435.toml");
  for (const ContactModel model : {ContactModel::kRigid, ContactModel::kElastic}) {
    geometry.contact = model;
    const RollingRadiusDifference d = CalcRollingRadiusDifference(CalcContactTable(geometry));
    EXPECT_NEAR(CalcEquivalentConicity(d, 3e-3), 0.182, 0.005);
  }
}

}  // namespace
}  // namespace uiclink
