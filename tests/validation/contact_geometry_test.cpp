// Wheel and rail profiles, contact search and conicity against published data in ../shared/reference: sampled benchmark
// profiles and case of the Manchester contact benchmark (results of the program CONTACT), reference wheels of
// EN 15302:2021.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/validation/en15302_reference.h"
#include "vehicle/contact/conicity.h"
#include "vehicle/contact/contact_search.h"
#include "vehicle/contact/profile_file.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using en15302::kMm;

const fs::path kProfiles = fs::path(UICLINK_SOURCE_DIR) / "../shared/reference/profiles";

TrackGeometry NominalGeometry() {
  return ReadTrackGeometry(UICLINK_SOURCE_DIR "/data/geometry/nominal-1435-rigid.toml");
}

const WheelsetOnRails& Nominal() {
  static const WheelsetOnRails wheelset(NominalGeometry());
  return wheelset;
}

class BenchmarkFiles : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kProfiles)) GTEST_SKIP() << "no reference data at " << kProfiles;
  }
};

TEST_F(BenchmarkFiles, S1002IsTheSampledOne) {
  const ProfilePoints points = ReadProfilePoints(kProfiles / "MBench_S1002_v3.prw", ProfileKind::kWheel);
  ASSERT_EQ(points.size(), 399u);
  double worst = 0;
  for (const auto& [y, z] : points) worst = std::max(worst, std::abs(WheelS1002().Eval(y).z - z));
  RecordProperty("worst_nm", std::to_string(worst * 1e9));
  EXPECT_LT(worst, 1e-4 * kMm);  // half of the step that is closed at y = -35 mm, 0.6e-4 mm, and z(0) = 0
}

/// Largest distance of the points from the placed rail [m], for their origin at s.
double FindLargestDistance(const ProfilePoints& points, const Profile& rail, double s) {
  double worst = 0;
  for (const auto& [y, z] : points) {
    const ProfilePoint p = rail.Eval(y + s);
    worst = std::max(worst, std::abs(p.z - z) / std::hypot(1, p.slope));
  }
  return worst;
}

TEST_F(BenchmarkFiles, Uic60IsTheSampledOne) {
  const ProfilePoints points = ReadProfilePoints(kProfiles / "MBench_UIC60_v3.prr", ProfileKind::kRail);
  ASSERT_GT(points.size(), 480u);
  const Profile rail = PlaceRail(RailUic60(), NominalGeometry());
  // The file has its origin near the highest point, which is 6 um off the true one (the top is flat).
  double low = 0.7605;
  double high = 0.7606;
  for (int i = 0; i < 60; ++i) {
    const double third = (high - low) / 3;
    if (FindLargestDistance(points, rail, low + third) < FindLargestDistance(points, rail, high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  EXPECT_NEAR(low, 0.760538539, 1e-5);
  RecordProperty("worst_nm", std::to_string(FindLargestDistance(points, rail, low) * 1e9));
  EXPECT_LT(FindLargestDistance(points, rail, low), 1e-3 * kMm);
}

TEST_F(BenchmarkFiles, ThroughFilesTheContactIsTheSame) {
  TrackGeometry from_files = NominalGeometry();
  from_files.wheel = (kProfiles / "MBench_S1002_v3.prw").string();
  from_files.rail = (kProfiles / "MBench_UIC60_v3.prr").string();
  from_files.cant = 0;  // the file's head is canted already
  const WheelsetOnRails wheelset(from_files);
  double worst_position = 0;
  double worst_radius = 0;
  for (int i = -70; i <= 70; ++i) {
    const double y = 1e-4 * i;
    if (std::abs(std::abs(i) - 2) < 1 || std::abs(std::abs(i) - 48.5) < 1) continue;  // next to the jumps
    const KinematicContact a = FindKinematicContact(wheelset, y);
    const KinematicContact b = FindKinematicContact(Nominal(), y);
    EXPECT_NEAR(a.z_lift, b.z_lift, 5e-7) << y;  // worst on the flange (70 degrees)
    worst_position = std::max(worst_position, std::abs(a.left[0].y_wheel - b.left[0].y_wheel));
    worst_radius = std::max(worst_radius, std::abs(a.left[0].r - b.left[0].r));
  }
  RecordProperty("worst_position_um", std::to_string(worst_position * 1e6));
  RecordProperty("worst_radius_um", std::to_string(worst_radius * 1e6));
  // Between the points (0.33 mm) the spline rounds the steps of the curvature, at most where the rail's R 80 meets R 13
  // (64 1/m): slopes off by 64 x 0.33e-3 / 12 = 2e-3 over a relative curvature of about 70 1/m there.
  EXPECT_LT(worst_position, 0.03 * kMm);
  EXPECT_LT(worst_radius, 0.02 * kMm);
}

// ---- CONTACT, case
// ---------------------------------------------------------------------------------------------

struct BenchmarkRow {
  bool flange;  ///< the wheel whose flange nears its rail
  double y, yaw, roll, lift;
  double y_wheel, approach;
};

/// The file's axes: y right, z down, right wheel = flange side.
std::vector<BenchmarkRow> ReadCase() {
  std::ifstream file(kProfiles / "mbench_a22_contact_results.csv");
  std::string line;
  std::getline(file, line);
  std::vector<BenchmarkRow> rows;
  while (std::getline(file, line)) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
    const auto number = [&](std::size_t i) { return std::stod(words.at(i)); };
    const bool flange = words.at(0) == "right";
    rows.push_back({flange, number(2) * kMm, number(3), -number(4), -number(5) * kMm,
                    number(12) * kMm * (flange ? 1 : -1), number(15) * kMm});
  }
  return rows;
}

/// A yawed wheelset is narrower, a cos(yaw): each wheel nearer the track centre by this [m].
double CalcNarrowing(const BenchmarkRow& row, double y_wheel) { return (0.75 + y_wheel) * (1 - std::cos(row.yaw)); }

/// A yawed wheel reaches lower ahead of (or behind) its axle: the point at the angle t is r t^2 / 2 higher and r t yaw
/// aside, where the profile is lower by slope r t yaw; lowest for t = slope yaw [m].
double CalcYawDrop(const BenchmarkRow& row, const GapPoint& p) {
  return 0.5 * (0.46 - p.wheel.z) * std::pow(p.wheel.slope * row.yaw, 2);
}

/// The wheel in CONTACT's pose, pressed into the rail: what CONTACT calls contact point is the centre of the
/// interpenetration, weighted with its square over the area; across the patch that is the depth to the power 2.5.
struct Interpenetration {
  double depth = 0;    ///< largest, along the normal [m]
  double y_wheel = 0;  ///< centre
};

Interpenetration FindInterpenetration(const BenchmarkRow& row) {
  const WheelSide side = row.flange ? WheelSide::kLeft : WheelSide::kRight;
  Interpenetration result;
  double sum = 0;
  for (double y_wheel = row.y_wheel - 0.015; y_wheel < row.y_wheel + 0.015; y_wheel += 2e-6) {
    const double narrower = CalcNarrowing(row, y_wheel);
    const GapPoint p = Nominal().EvalGap(side, y_wheel, row.flange ? row.y - narrower : row.y + narrower, row.roll);
    const double depth = -(p.gap - CalcYawDrop(row, p) + row.lift) / std::hypot(1, p.rail.slope);
    if (!(depth > 0)) continue;
    const double weight = std::pow(depth, 2.5);
    sum += weight;
    result.y_wheel += weight * y_wheel;
    result.depth = std::max(result.depth, depth);
  }
  result.y_wheel /= sum;
  return result;
}

TEST_F(BenchmarkFiles, ContactsPoseTouchesAsContactSays) {
  // Roll and lift of CONTACT in our geometry: the interpenetration must be the approach that CONTACT found with them,
  // on both wheels, and its centre CONTACT's contact point. Beyond y = 4.6 mm the patch is in the flange root, where
  // the interpenetration of a R 13 wheel and a R 13 rail says little.
  for (const BenchmarkRow& row : ReadCase()) {
    if (row.y > 4.6 * kMm) continue;
    SCOPED_TRACE(std::to_string(row.y / kMm) + (row.flange ? " mm, flange side" : " mm, other side"));
    const Interpenetration found = FindInterpenetration(row);
    EXPECT_NEAR(found.y_wheel, row.y_wheel, 0.06 * kMm);
    // Printed to 0.01 um (approach) and 0.1 um (lift of either wheel).
    EXPECT_NEAR(found.depth, row.approach, 0.25e-6);
  }
}

TEST_F(BenchmarkFiles, RigidContactIsWhereContactFindsIt) {
  // The rigid point against the centre of a patch: they part where the pair is conformal (|y| < 2 mm: CONTACT's patch
  // is 17 mm long there) and next to the jumps; on the flange side of the tread they agree.
  int compared = 0;
  for (const BenchmarkRow& row : ReadCase()) {
    if (!row.flange || row.y < 1.9 * kMm || row.y > 4.6 * kMm) continue;
    const KinematicContact contact = FindKinematicContact(Nominal(), row.y);
    EXPECT_NEAR(contact.left[0].y_wheel, row.y_wheel, 0.06 * kMm) << row.y;
    ++compared;
  }
  EXPECT_EQ(compared, 6);
}

TEST_F(BenchmarkFiles, RollAndLiftAreContactsWithoutApproachAndYaw) {
  // CONTACT's wheels sink in by their approach and are yawed: to first order each minimum of the gap lies higher by
  // `raise` in the rigid pose. Two equations, dz + g_l dphi = raise_l, dz - g_r dphi = raise_r.
  const std::vector<BenchmarkRow> rows = ReadCase();
  int compared = 0;
  for (const BenchmarkRow& flange : rows) {
    if (!flange.flange || flange.y > 4.6 * kMm) continue;
    const auto other = std::find_if(rows.begin(), rows.end(),
                                    [&](const BenchmarkRow& row) { return !row.flange && row.y == flange.y; });
    ASSERT_NE(other, rows.end());
    const KinematicContact contact = FindKinematicContact(Nominal(), flange.y);
    const auto point = [&](WheelSide side) {
      return Nominal().EvalGap(side, contact.side(side)[0].y_wheel, flange.y, contact.phi_roll);
    };
    const GapPoint left = point(WheelSide::kLeft);
    const GapPoint right = point(WheelSide::kRight);
    const auto raise = [](const BenchmarkRow& row, const GapPoint& p) {
      return row.approach * std::hypot(1, p.rail.slope) + p.rail.slope * CalcNarrowing(row, p.a_rail - 0.75) -
             CalcYawDrop(row, p);
    };
    const double roll = (raise(flange, left) - raise(*other, right)) / (left.gap_roll + right.gap_roll);
    const double lift = raise(flange, left) - left.gap_roll * roll;
    // Printed: lift to 0.1 um, and it differs by up to 0.7 um between the runs of the two wheels (y = 0.5 mm).
    EXPECT_NEAR(contact.phi_roll, flange.roll + roll, 0.5e-6) << flange.y;
    EXPECT_NEAR(contact.z_lift, 0.5 * (flange.lift + other->lift) + lift, 0.5e-6) << flange.y;
    ++compared;
  }
  EXPECT_EQ(compared, 10);
}

// ---- EN 15302
// --------------------------------------------------------------------------------------------------------

TEST(En15302, RollingRadiusDifferencesOfTheReferenceWheels) {
  for (const en15302::ReferenceDifference& reference : en15302::ReferenceDifferences()) {
    SCOPED_TRACE("wheel " + reference.wheel);
    const WheelOnRail side = en15302::OnRailA(reference.profile);
    const WheelsetOnRails wheelset(side, side, 0.46);
    const std::vector<Jump> jumps = FindJumps(wheelset, 0, 8 * kMm, {.roll = false});
    double worst = 0;
    for (std::size_t i = 0; i < reference.delta_r_mm.size(); ++i) {
      const double y = 0.1 * kMm * static_cast<double>(i + 1);
      if (std::abs(y - reference.misprint_mm * kMm) < 1e-6) continue;
      const KinematicContact contact = FindKinematicContact(wheelset, y, {.roll = false});
      double deviation = std::abs(contact.left[0].r - contact.right[0].r - reference.delta_r_mm[i] * kMm);
      // Wheel B jumps 0.02 um from y = 3 mm: printed digits decide on which side of it the contact is.
      for (const Jump& jump : jumps) {
        if (std::abs(jump.y - y) > 0.1e-6) continue;
        for (const ContactCandidate& c : {jump.before, jump.after}) {
          deviation = std::min(deviation, std::abs(c.r - contact.right[0].r - reference.delta_r_mm[i] * kMm));
        }
      }
      EXPECT_LT(deviation, 0.001 * kMm) << "y = " << y / kMm << " mm";
      worst = std::max(worst, deviation);
    }
    RecordProperty("worst_nm_wheel_" + reference.wheel, std::to_string(worst * 1e9));
  }
}

/// A line of ben_E*.dat.
struct ReferenceConicity {
  double amplitude, conicity, upper, lower;
};

std::vector<ReferenceConicity> ReadConicities(int combination) {
  std::ifstream file(kProfiles / ("ben_E" + std::to_string(combination) + ".dat"));
  std::vector<ReferenceConicity> rows;
  double extended_upper = 0;
  double extended_lower = 0;
  for (ReferenceConicity row{};
       file >> row.amplitude >> row.conicity >> row.upper >> row.lower >> extended_upper >> extended_lower;) {
    row.amplitude *= kMm;
    rows.push_back(row);
  }
  return rows;
}

/// E1 to E4: wheels A, B, H, I; E5 to E8: the right one with a diameter 2 mm smaller; E9: right A, left B. Zones as the
/// standard prints them.
WheelsetOnRails MakeCombination(int combination) {
  const auto on_rail = [](const Profile& wheel, double r0) {
    return WheelOnRail{wheel, en15302::ReferenceRailA().Shifted(0.75, 0), 0.75, r0};
  };
  if (combination == 9) {
    return WheelsetOnRails(on_rail(en15302::ReferenceWheelB(), 0.46), on_rail(en15302::ReferenceWheelA(), 0.46), 0.46);
  }
  const Profile wheel = en15302::ReferenceDifferences()[static_cast<std::size_t>((combination - 1) % 4)].profile;
  return WheelsetOnRails(on_rail(wheel, 0.46), on_rail(wheel, combination > 4 ? 0.459 : 0.46), 0.46);
}

/// delta_r as the standard takes it: every 0.1 mm, straight lines between, also across jumps.
RollingRadiusDifference SampleOnStandardGrid(const WheelsetOnRails& wheelset) {
  RollingRadiusDifference d;
  for (int i = -100; i <= 100; ++i) {
    const KinematicContact contact = FindKinematicContact(wheelset, 1e-4 * i, {.roll = false});
    d.y.push_back(contact.y);
    d.delta_r.push_back(contact.left[0].r - contact.right[0].r);
  }
  return d;
}

TEST_F(BenchmarkFiles, ConicitiesOfAllNineCombinations) {
  for (int combination = 1; combination <= 9; ++combination) {
    SCOPED_TRACE("E" + std::to_string(combination));
    const std::vector<ReferenceConicity> reference = ReadConicities(combination);
    ASSERT_EQ(reference.size(), 66u);
    const WheelsetOnRails wheelset = MakeCombination(combination);
    const RollingRadiusDifference on_grid = SampleOnStandardGrid(wheelset);
    const RollingRadiusDifference with_jumps =
        CalcRollingRadiusDifference(wheelset, 10 * kMm, 0.05 * kMm, {.roll = false});
    double worst = 0;
    double worst_with_jumps = 0;
    for (const ReferenceConicity& row : reference) {
      const double conicity = CalcEquivalentConicity(on_grid, row.amplitude);
      EXPECT_GE(conicity, row.lower) << row.amplitude;
      EXPECT_LE(conicity, row.upper) << row.amplitude;
      worst = std::max(worst, std::abs(conicity - row.conicity));
      const double exact = CalcEquivalentConicity(with_jumps, row.amplitude);
      worst_with_jumps = std::max(worst_with_jumps, std::abs(exact - row.conicity));
      // E2 at 3 mm: wheel B jumps 0.03 um before the end of the motion, on the standard's grid up to 0.1 mm before.
      // Annex K prints 0.030 there (we have 0.0255), this file 0.058.
      if (combination == 2 && std::abs(row.amplitude - 3 * kMm) < 1e-6) continue;
      EXPECT_GE(exact, row.lower) << row.amplitude;
      EXPECT_LE(exact, row.upper) << row.amplitude;
    }
    RecordProperty("worst_E" + std::to_string(combination), std::to_string(worst));
    RecordProperty("worst_with_jumps_E" + std::to_string(combination), std::to_string(worst_with_jumps));
  }
}

TEST_F(BenchmarkFiles, TheStandardsOwnDifferencesGiveItsConicities) {
  // The integral alone: delta_r of Annex J, printed to 0.001 mm every 0.1 mm.
  const auto references = en15302::ReferenceDifferences();
  for (int combination = 1; combination <= 8; ++combination) {
    SCOPED_TRACE("E" + std::to_string(combination));
    const en15302::ReferenceDifference& reference = references[static_cast<std::size_t>((combination - 1) % 4)];
    std::vector<double> delta_r = reference.delta_r_mm;
    if (reference.wheel == "A") delta_r[16] = 0.5275;  // the misprints: midway, and 2.514 as on the other side
    if (reference.wheel == "H") delta_r[30] = 2.514;
    RollingRadiusDifference d;
    const int n = static_cast<int>(delta_r.size());
    for (int i = -n; i <= n; ++i) {
      const double value = i == 0 ? 0 : std::copysign(delta_r[static_cast<std::size_t>(std::abs(i) - 1)], i);
      d.y.push_back(1e-4 * i);
      d.delta_r.push_back(value * kMm + (combination > 4 ? kMm : 0));
    }
    int compared = 0;
    for (const ReferenceConicity& row : ReadConicities(combination)) {
      const double conicity = CalcEquivalentConicity(d, row.amplitude);
      if (std::isnan(conicity)) continue;  // the motion leaves the table
      ++compared;
      EXPECT_NEAR(conicity, row.conicity, 0.004) << row.amplitude;  // worst next to jumps; median 0.0001 to 0.001
    }
    EXPECT_GT(compared, 40);
  }
}

// ---- our pair
// --------------------------------------------------------------------------------------------------------

TEST(NominalPair, EquivalentConicityIs018At3mm) {
  const RollingRadiusDifference level = CalcRollingRadiusDifference(Nominal(), 9 * kMm, 0.05 * kMm, {.roll = false});
  const RollingRadiusDifference rolled = CalcRollingRadiusDifference(Nominal(), 9 * kMm, 0.05 * kMm, {.roll = true});
  // The usual figure is "about 0.18"; an independent computation by the method of EN 15302 gave 0.180, from
  // CONTACT's elastic positions 0.182.
  EXPECT_NEAR(CalcEquivalentConicity(level, 3 * kMm), 0.180, 0.001);
  EXPECT_NEAR(CalcEquivalentConicity(rolled, 3 * kMm), 0.1836, 0.001);
  EXPECT_NEAR(CalcHarmonicConicity(rolled, 3 * kMm), 0.185, 0.002);
}

/// Points every `spacing` along the curve, heights in error by a normal deviate, printed to 0.1 um.
ProfilePoints Measure(const Profile& profile, double y_from, double y_to, double spacing, double noise, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  ProfilePoints points;
  for (double y = y_from; y < y_to;) {
    const ProfilePoint p = profile.Eval(y);
    points.emplace_back(y, std::round((p.z + noise * normal(generator)) * 1e7) * 1e-7);
    y += spacing / std::hypot(1, p.slope);
  }
  return points;
}

struct Deviations {
  double median_position, worst_position, worst_lift, conicity;
};

/// Of a pair measured with noise and smoothed, from the exact one, up to y = 6 mm and 0.4 mm from the jumps.
Deviations CompareMeasured(double noise, double sigma, unsigned seed) {
  const auto fit = [&](const Profile& profile, double from, double to, unsigned s) {
    return FitProfile(profile.name(), Measure(profile, from, to, 0.2e-3, noise, s), sigma);
  };
  const Profile wheel = fit(WheelS1002(), -0.0695, 0.06, seed);
  const Profile rail = fit(RailUic60(), -0.0365, 0.0365, seed + 1);
  const WheelOnRail side{wheel.Shifted(0, -wheel.Eval(0).z), PlaceRail(rail, NominalGeometry()), 0.75, 0.46};
  const WheelsetOnRails measured(side, side, 0.46);
  Deviations d{};
  std::vector<double> positions;
  for (int i = -60; i <= 60; ++i) {
    const double y = 1e-4 * i;
    const KinematicContact a = FindKinematicContact(measured, y);
    const KinematicContact b = FindKinematicContact(Nominal(), y);
    d.worst_lift = std::max(d.worst_lift, std::abs(a.z_lift - b.z_lift));
    const bool jumps = std::abs(std::abs(y) - 0.209e-3) < 4e-4 || std::abs(std::abs(y) - 4.848e-3) < 4e-4;
    if (!jumps) positions.push_back(std::abs(a.left[0].y_wheel - b.left[0].y_wheel));
  }
  std::sort(positions.begin(), positions.end());
  d.median_position = positions[positions.size() / 2];
  d.worst_position = positions.back();
  d.conicity =
      CalcEquivalentConicity(CalcRollingRadiusDifference(measured, 8 * kMm, 0.1 * kMm, {.roll = false}), 3 * kMm);
  return d;
}

TEST(MeasuredProfiles, GiveTheSameContact) {
  // Heights printed to 0.1 um: their rounding (0.03 um) is what the smoothing is told.
  const Deviations d = CompareMeasured(0, 0.03e-6, 1);
  RecordProperty("median_position_um", std::to_string(d.median_position * 1e6));
  RecordProperty("worst_position_um", std::to_string(d.worst_position * 1e6));
  EXPECT_LT(d.median_position, 0.03 * kMm);
  EXPECT_LT(d.worst_position, 0.25 * kMm);  // where the pair is conformal: slopes in error by 1e-4 over 0.8 1/m
  EXPECT_LT(d.worst_lift, 0.2e-6);
  EXPECT_NEAR(d.conicity, 0.180, 0.001);
}

TEST(MeasuredProfiles, WithTenMicrometresOfNoiseGiveNearlyTheSame) {
  // Slopes are known to about sigma sqrt(12 h / L^3) = 6e-4 over L = 10 mm (h = 0.2 mm between points), which moves the
  // contact by 6e-4 over the pair's relative curvature: 0.1 mm on the tread, 0.8 mm and more at the conformal crown.
  for (const unsigned seed : {1u, 11u, 21u}) {
    const Deviations d = CompareMeasured(10e-6, 10e-6, seed);
    RecordProperty("median_position_um_" + std::to_string(seed), std::to_string(d.median_position * 1e6));
    RecordProperty("worst_position_um_" + std::to_string(seed), std::to_string(d.worst_position * 1e6));
    RecordProperty("conicity_" + std::to_string(seed), std::to_string(d.conicity));
    EXPECT_LT(d.median_position, 0.5 * kMm);
    EXPECT_LT(d.worst_position, 3 * kMm);
    EXPECT_LT(d.worst_lift, 15e-6);
    EXPECT_NEAR(d.conicity, 0.180, 0.01);
  }
}

}  // namespace
}  // namespace uiclink
