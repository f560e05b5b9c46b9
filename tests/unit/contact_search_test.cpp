#include "vehicle/contact/contact_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "vehicle/contact/profile_file.h"

namespace uiclink {
namespace {

constexpr double kHalfDistance = 0.75;
constexpr double kRadius = 0.46;

WheelsetOnRails Symmetric(Profile wheel, Profile rail) {
  const WheelOnRail side{std::move(wheel), std::move(rail), kHalfDistance, kRadius};
  return WheelsetOnRails(side, side, kRadius);
}

Profile RoundRail(double y_centre, double radius) {
  return Profile("round", {ProfilePiece::UpperArc(y_centre - 0.03, y_centre + 0.03, y_centre, -radius, radius)});
}

TrackGeometry NominalGeometry() {
  return ReadTrackGeometry(UICLINK_SOURCE_DIR "/data/geometry/nominal-1435-rigid.toml");
}

const WheelsetOnRails& Nominal() {
  static const WheelsetOnRails wheelset(NominalGeometry());
  return wheelset;
}

TEST(ContactSearch, ConeOnARoundRail) {
  // A straight generator touches a circle where their distance is the radius. With the roll phi the left one is
  // inclined by delta + phi, the right one by delta - phi.
  const double slope = 0.05;
  const double radius = 0.3;
  const double rail_at = 0.752;
  const double delta = std::atan(slope);
  const WheelsetOnRails wheelset = Symmetric(
      Profile("cone", {ProfilePiece::Polynomial(-0.04, 0.04, 0, std::array{0.0, slope})}), RoundRail(rail_at, radius));
  for (const double y : {0.0, 0.003, -0.006}) {
    const KinematicContact contact = FindKinematicContact(wheelset, y);
    for (const WheelSide side : {WheelSide::kLeft, WheelSide::kRight}) {
      const double sign = side == WheelSide::kLeft ? 1 : -1;
      const double phi = sign * contact.phi_roll;
      ASSERT_EQ(contact.side(side).size(), 1u);
      const ContactCandidate& c = contact.side(side)[0];
      // A point of the generator (the tape circle) in the track; its distance from the circle's centre along the
      // normal.
      const double s = sign * y + kHalfDistance * std::cos(phi) + kRadius * std::sin(phi);
      const double z = kRadius + contact.z_lift + kHalfDistance * std::sin(phi) - kRadius * std::cos(phi);
      const double angle = delta + phi;
      EXPECT_NEAR(-(rail_at - s) * std::sin(angle) + (-radius - z) * std::cos(angle), -radius, 2e-15) << y;
      EXPECT_NEAR(c.a_rail, rail_at - radius * std::sin(angle), 1e-14);
      EXPECT_NEAR(c.z_rail, radius * (std::cos(angle) - 1), 1e-15);
      EXPECT_NEAR(c.y_wheel, ((rail_at - s) * std::cos(angle) + (-radius - z) * std::sin(angle)) * std::cos(delta),
                  1e-14);
      EXPECT_NEAR(c.delta, delta, 1e-14);
      EXPECT_NEAR(c.r, kRadius - slope * c.y_wheel, 1e-15);
      EXPECT_NEAR(c.a_wheel, kHalfDistance + c.y_wheel, 1e-15);
      EXPECT_EQ(c.curvature_wheel, 0);
      EXPECT_NEAR(c.curvature_rail, 1 / radius, 1e-12);
      EXPECT_EQ(c.gap, 0);
      EXPECT_FALSE(c.at_joint);
    }
    if (y == 0) {
      EXPECT_NEAR(contact.phi_roll, 0, 1e-15);
    }
  }
}

TEST(ContactSearch, HollowWheelOnARoundRail) {
  // Equal slopes on two circles (centres x_w + y and x_r):  x = (R_w x_r - R_r (x_w + y)) / (R_w - R_r); without roll.
  const double wheel_radius = 0.5;
  const double rail_radius = 0.3;
  const double wheel_centre = 0.748;
  const double rail_centre = 0.753;
  const double drop = std::sqrt(wheel_radius * wheel_radius - std::pow(wheel_centre - kHalfDistance, 2));
  const WheelsetOnRails wheelset = Symmetric(
      Profile("hollow", {ProfilePiece::UpperArc(-0.05, 0.05, wheel_centre - kHalfDistance, -drop, wheel_radius)}),
      RoundRail(rail_centre, rail_radius));
  for (const double y : {0.0, 0.002, -0.003}) {
    const KinematicContact contact = FindKinematicContact(wheelset, y, {.roll = false});
    EXPECT_EQ(contact.phi_roll, 0);
    const auto expected = [&](double shift) {
      return (wheel_radius * rail_centre - rail_radius * (wheel_centre + shift)) / (wheel_radius - rail_radius);
    };
    // The minimum's place is known to rounding / (curvature of the gap): 1e-16 / 1.3 = 1e-16; the slopes cancel to
    // 1e-16.
    EXPECT_NEAR(contact.left[0].a_rail, expected(y), 1e-14);
    EXPECT_NEAR(contact.right[0].a_rail, expected(-y), 1e-14);
    EXPECT_NEAR(contact.left[0].curvature_wheel, -1 / wheel_radius, 1e-12);
    EXPECT_NEAR(contact.left[0].curvature_rail, 1 / rail_radius, 1e-12);
    EXPECT_NEAR(std::sin(contact.left[0].delta), -(expected(y) - rail_centre) / rail_radius, 1e-13);
  }
}

TEST(ContactSearch, CornersTouchAsCandidatesOfTheirOwn) {
  // A wheel with an edge at y = 2 mm on a round rail: the edge touches, the angle is the rail's.
  const Profile edged("edge", {ProfilePiece::Polynomial(-0.04, 0.002, 0.002, std::array{0.0, -0.1}),
                               ProfilePiece::Polynomial(0.002, 0.04, 0.002, std::array{0.0, 0.2})});
  const KinematicContact edge = FindKinematicContact(Symmetric(edged, RoundRail(0.755, 0.3)), 0.001);
  ASSERT_EQ(edge.left.size(), 1u);
  EXPECT_TRUE(edge.left[0].at_joint);
  EXPECT_EQ(edge.left[0].y_wheel, 0.002);
  EXPECT_NEAR(std::tan(edge.left[0].delta + edge.phi_roll), (0.755 - edge.left[0].a_rail) / (0.3 + edge.left[0].z_rail),
              1e-14);

  // The ridge of a roof under a hollow wheel: the wheel's angle.
  const Profile roof("roof", {ProfilePiece::Polynomial(0.70, 0.753, 0.753, std::array{0.0, 0.3}),
                              ProfilePiece::Polynomial(0.753, 0.80, 0.753, std::array{0.0, -0.3})});
  const Profile hollow("hollow", {ProfilePiece::UpperArc(-0.04, 0.04, 0, -0.5, 0.5)});
  const KinematicContact ridge = FindKinematicContact(Symmetric(hollow, roof), 0.001, {.roll = false});
  ASSERT_EQ(ridge.left.size(), 1u);
  EXPECT_TRUE(ridge.left[0].at_joint);
  EXPECT_NEAR(ridge.left[0].a_rail, 0.753, 1e-13);
  EXPECT_NEAR(std::sin(ridge.left[0].delta), -0.002 / 0.5, 1e-12);
}

TEST(ContactSearch, TouchesTheLowerEdgeOfAStep) {
  // A hollow tread with a step of +-1 um where it would touch. Lower on the field side: the edge of that piece, or its
  // own minimum; in any case nothing of the wheel is lower than what touches.
  for (const double step : {1e-6, -1e-6}) {
    const Profile stepped("step", {ProfilePiece::Polynomial(-0.04, 0, 0, std::array{0.0, 0.01, -0.5}),
                                   ProfilePiece::Polynomial(0, 0.04, 0, std::array{step, 0.01, -0.5})});
    const WheelsetOnRails wheelset = Symmetric(stepped, RoundRail(0.753, 0.3));  // slope 0.01 at 0.750
    const KinematicContact contact = FindKinematicContact(wheelset, 0, {.roll = false});
    const ContactCandidate& touching = contact.left[0];
    EXPECT_EQ(touching.at_joint, touching.y_wheel == 0);
    EXPECT_EQ(touching.y_wheel < 0 || (touching.at_joint && step > 0), step > 0);
    const auto lowest = [&](double y_wheel, JointSide joint_side) {
      return wheelset.EvalGap(WheelSide::kLeft, y_wheel, 0, 0, joint_side).gap + contact.z_lift;
    };
    for (double y_wheel = -0.02; y_wheel < 0.02; y_wheel += 1e-5) EXPECT_GE(lowest(y_wheel, JointSide::kAbove), -1e-15);
    EXPECT_GE(lowest(0, JointSide::kBelow), -1e-15);
    EXPECT_GE(lowest(0, JointSide::kAbove), -1e-15);
  }
}

TEST(ContactSearch, GapHasItsDerivatives) {
  const double h = 1e-6;
  for (const WheelSide side : {WheelSide::kLeft, WheelSide::kRight}) {
    for (const double y_wheel : {-0.028, -0.012, 0.005, 0.02}) {
      const double y = 0.002;
      const double phi = 0.001;
      const auto gap = [&](double dy, double dphi) { return Nominal().EvalGap(side, y_wheel + dy, y, phi + dphi); };
      const double sign = side == WheelSide::kLeft ? 1 : -1;  // gap_roll is by this side's own roll
      // Central differences: h^2 f'''/6 with f''' = 3 u / R^2 cos^-5 up to 1e5 1/m^2 in the rail's corner.
      EXPECT_NEAR(gap(0, 0).gap_slope, (gap(h, 0).gap - gap(-h, 0).gap) / (2 * h), 5e-8);
      EXPECT_NEAR(gap(0, 0).gap_second, (gap(h, 0).gap_slope - gap(-h, 0).gap_slope) / (2 * h), 1e-4);
      EXPECT_NEAR(sign * gap(0, 0).gap_roll, (gap(0, h).gap - gap(0, -h).gap) / (2 * h), 1e-8);
    }
  }
}

/// Local minima of the gap on a grid of 1 um, with their gaps.
std::vector<std::pair<double, double>> SearchByForce(WheelSide side, double y, double phi) {
  constexpr double kStep = 1e-6;
  std::vector<std::pair<double, double>> minima;
  double before = NAN;
  double here = NAN;
  for (double y_wheel = -0.069; y_wheel < 0.0599; y_wheel += kStep) {
    const double after = Nominal().EvalGap(side, y_wheel, y, phi).gap;
    if (here < before && here <= after) minima.emplace_back(y_wheel - kStep, here);
    before = here;
    here = after;
  }
  return minima;
}

TEST(ContactSearch, FindsEveryLocalMinimum) {
  for (const double y : {0.0, 0.0002, 0.0035, 0.0047, 0.0052, 0.0071}) {
    const KinematicContact contact = FindKinematicContact(Nominal(), y);
    for (const WheelSide side : {WheelSide::kLeft, WheelSide::kRight}) {
      const auto expected = SearchByForce(side, y, contact.phi_roll);
      const CandidateList& found = contact.side(side);
      ASSERT_EQ(found.size(), expected.size()) << y;
      double lowest = 1;
      for (const auto& [y_wheel, gap] : expected) lowest = std::min(lowest, gap);
      for (const auto& [y_wheel, gap] : expected) {
        const auto nearest =
            std::min_element(found.begin(), found.end(), [&, at = y_wheel](const auto& a, const auto& b) {
              return std::abs(a.y_wheel - at) < std::abs(b.y_wheel - at);
            });
        EXPECT_NEAR(nearest->y_wheel, y_wheel, 1.5e-6);
        EXPECT_NEAR(nearest->gap, gap - lowest, 1e-11);  // 0.5 um off a minimum of curvature 80 1/m: 1e-11 m
      }
      for (std::size_t i = 1; i < found.size(); ++i) EXPECT_LE(found[i - 1].gap, found[i].gap);
    }
  }
}

TEST(ContactSearch, IsMirrorSymmetricAndKnowsNoStartValue) {
  for (const double y : {0.0007, 0.0033, 0.0062}) {
    const KinematicContact left = FindKinematicContact(Nominal(), y);
    const KinematicContact right = FindKinematicContact(Nominal(), -y);
    EXPECT_NEAR(left.phi_roll, -right.phi_roll, 1e-14);
    EXPECT_NEAR(left.z_lift, right.z_lift, 1e-14);
    EXPECT_NEAR(left.left[0].y_wheel, right.right[0].y_wheel, 1e-12);
    EXPECT_NEAR(left.right[0].y_wheel, right.left[0].y_wheel, 1e-12);
    for (const double guess : {-0.03, 0.001, 0.02, 1.0}) {
      const KinematicContact again = FindKinematicContact(Nominal(), y, {}, guess);
      EXPECT_NEAR(again.phi_roll, left.phi_roll, 2e-14);  // heights to 2e-15 m over 1.5 m, or over 0.2 m at 70 degrees
      EXPECT_NEAR(again.left[0].y_wheel, left.left[0].y_wheel, 1e-12);
    }
  }
}

TEST(ContactSearch, BothWheelsTouchAndNothingPenetrates) {
  for (int i = 0; i <= 100; ++i) {
    const double y = -0.01 + 0.0002 * i;
    const KinematicContact contact = FindKinematicContact(Nominal(), y);
    for (const WheelSide side : {WheelSide::kLeft, WheelSide::kRight}) {
      const ContactCandidate& c = contact.side(side)[0];
      EXPECT_NEAR(Nominal().EvalGap(side, c.y_wheel, y, contact.phi_roll).gap + contact.z_lift, 0, 2e-15) << y;
      for (double y_wheel = -0.068; y_wheel < 0.06; y_wheel += 1e-4) {
        const GapPoint p = Nominal().EvalGap(side, y_wheel, y, contact.phi_roll);
        const bool clear = !std::isfinite(p.gap) || p.gap + contact.z_lift > -1e-14;
        EXPECT_TRUE(clear) << y << " " << y_wheel << " " << p.gap;
      }
    }
  }
}

TEST(ContactSearch, RollFollowsTheLift) {
  // Only heights move the wheelset: d z_lift + a d phi is the lift of each contact point. The conserved check here:
  // roll by the sum of dgap/dphi, from two neighbouring displacements, by the implicit function theorem.
  const double y = 0.002;
  const double h = 1e-6;
  const KinematicContact at = FindKinematicContact(Nominal(), y);
  const GapPoint left = Nominal().EvalGap(WheelSide::kLeft, at.left[0].y_wheel, y, at.phi_roll);
  const GapPoint right = Nominal().EvalGap(WheelSide::kRight, at.right[0].y_wheel, y, at.phi_roll);
  const double expected = (left.rail.slope + right.rail.slope) / (left.gap_roll + right.gap_roll);
  const double found =
      (FindKinematicContact(Nominal(), y + h).phi_roll - FindKinematicContact(Nominal(), y - h).phi_roll) / (2 * h);
  EXPECT_NEAR(found, expected, 1e-6 * std::abs(expected));  // h^2 of a smooth function, and 1e-15 / h
}

TEST(FindJumps, TiesBothMinimaToRounding) {
  const std::vector<Jump> jumps = FindJumps(Nominal(), -0.008, 0.008);
  ASSERT_EQ(jumps.size(), 4u);
  const std::array<WheelSide, 4> sides{WheelSide::kRight, WheelSide::kRight, WheelSide::kLeft, WheelSide::kLeft};
  for (std::size_t i = 0; i < 4; ++i) {
    const Jump& jump = jumps[i];
    EXPECT_EQ(jump.side, sides[i]);
    EXPECT_NEAR(jump.y, -jumps[3 - i].y, 1e-12);
    EXPECT_LT(std::max(jump.before.gap, jump.after.gap), 2e-14);  // heights to 2e-15 m, twice, and the roll's share
    EXPECT_GT(std::abs(jump.before.y_wheel - jump.after.y_wheel), 0.001);
    // On either side the right one touches.
    const KinematicContact before = FindKinematicContact(Nominal(), jump.y - 1e-9);
    const KinematicContact after = FindKinematicContact(Nominal(), jump.y + 1e-9);
    EXPECT_NEAR(before.side(jump.side)[0].y_wheel, jump.before.y_wheel, 1e-7);
    EXPECT_NEAR(after.side(jump.side)[0].y_wheel, jump.after.y_wheel, 1e-7);
    EXPECT_NEAR(before.phi_roll, after.phi_roll, 1e-9);  // the pose does not jump
    EXPECT_NEAR(before.z_lift, after.z_lift, 1e-9);
  }
  EXPECT_NEAR(jumps[2].y, 0.000209, 1e-6);
  EXPECT_NEAR(jumps[3].y, 0.004848, 1e-6);
}

TEST(FindJumps, OfTwoConesIsWhereTheyTie) {
  // Two straight treads of slopes 0.2 and 0.02 that meet in a hollow corner; round rail, no roll. A line through the
  // corner, at (u, w) from the circle's centre, touches the circle when w - u tan d = R / cos d; both do when
  // u (tan d_1 - tan d_2) = -R (1/cos d_1 - 1/cos d_2).
  const double radius = 0.3;
  const double corner = -0.035;
  const Profile wheel("two cones", {ProfilePiece::Polynomial(-0.09, corner, corner, std::array{0.0, 0.2}),
                                    ProfilePiece::Polynomial(corner, 0.05, corner, std::array{0.0, 0.02})});
  const Profile rail("round", {ProfilePiece::UpperArc(0.66, 0.84, 0.75, -radius, radius)});
  const double u = -radius * (std::hypot(1, 0.2) - std::hypot(1, 0.02)) / (0.2 - 0.02);
  const double y_tie = u - corner;  // the corner is at 0.75 + corner + y
  const std::vector<Jump> jumps = FindJumps(Symmetric(wheel, rail), -0.006, 0.006, {.roll = false});
  ASSERT_EQ(jumps.size(), 2u);
  EXPECT_EQ(jumps[0].side, WheelSide::kRight);
  EXPECT_EQ(jumps[1].side, WheelSide::kLeft);
  EXPECT_NEAR(jumps[0].y, -y_tie, 1e-13);
  EXPECT_NEAR(jumps[1].y, y_tie, 1e-13);
  EXPECT_NEAR(jumps[1].before.delta, std::atan(0.02), 1e-13);
  EXPECT_NEAR(jumps[1].after.delta, std::atan(0.2), 1e-13);
}

TEST(ContactSearch, DoesNotAllocate) {
  const KinematicContact first = FindKinematicContact(Nominal(), 0);
  const std::size_t before = CountAllocations();
  double phi = first.phi_roll;
  for (int i = 0; i < 100; ++i) phi = FindKinematicContact(Nominal(), 1e-4 * i, {}, phi).phi_roll;
  EXPECT_EQ(CountAllocations(), before);
}

TEST(ContactSearch, SaysWhenAProfileIsTooShort) {
  // The flange meets the end of a rail that was measured only 5 mm down.
  const Profile rail = PlaceRail(RailUic60(), NominalGeometry());
  const WheelOnRail side{WheelS1002(), rail.Cut(0.7221, 0.785), kHalfDistance, kRadius};
  const WheelsetOnRails wheelset(side, side, kRadius);
  EXPECT_NO_THROW(FindKinematicContact(wheelset, 0.002));
  EXPECT_THROW(FindKinematicContact(wheelset, 0.009), std::domain_error);
  // And nothing below the wheel at all.
  const WheelOnRail apart{WheelS1002(), rail.Shifted(0.3, 0), kHalfDistance, kRadius};
  EXPECT_THROW(FindKinematicContact(WheelsetOnRails(apart, apart, kRadius), 0), std::domain_error);
}

TEST(ContactSearch, StandsNoisyProfiles) {
  // Many shallow minima that come and go with the roll: the search settles, and a candidate list that is full keeps the
  // lowest ones.
  std::mt19937 generator(7);
  std::normal_distribution<double> noise(0, 2e-7);
  ProfilePoints points;
  for (double y = -0.069; y < 0.06; y += 1e-4) points.emplace_back(y, WheelS1002().Eval(y).z + noise(generator));
  const WheelOnRail side{FitProfile("rough", points, 0), PlaceRail(RailUic60(), NominalGeometry()), kHalfDistance,
                         kRadius};
  const WheelsetOnRails wheelset(side, side, kRadius);
  for (int i = -60; i <= 60; ++i) {
    const KinematicContact contact = FindKinematicContact(wheelset, 1e-4 * i);
    const KinematicContact exact = FindKinematicContact(Nominal(), 1e-4 * i);
    EXPECT_NEAR(contact.z_lift, exact.z_lift, 2e-6);  // a few deviations of the noise, and its overshoot between points
    EXPECT_NEAR(contact.left[0].gap, 0, 1e-12);
    EXPECT_NEAR(contact.right[0].gap, 0, 1e-12);
  }
}

}  // namespace
}  // namespace uiclink
