#include "vehicle/start_state.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

TEST(ParsePerturbation, TakesPlacesWithUnits) {
  const Perturbation by = ParsePerturbation(
      "front_lateral=5mm, rear_lateral = -0.25 "
      "cm,body_lateral=+1e-3m,body_roll=1mrad,body_yaw=1deg,front_yaw=0.05rad,rear_yaw=0mrad");
  // Products of one rounding each.
  EXPECT_DOUBLE_EQ(by.front_y, 5e-3);
  EXPECT_DOUBLE_EQ(by.rear_y, -2.5e-3);
  EXPECT_DOUBLE_EQ(by.body_y, 1e-3);
  EXPECT_DOUBLE_EQ(by.body_phi, 1e-3);
  EXPECT_DOUBLE_EQ(by.body_psi, std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(by.front_psi, 0.05);
  EXPECT_EQ(by.rear_psi, 0);
}

TEST(ParsePerturbation, LeavesTheOthersAtRest) {
  const Perturbation by = ParsePerturbation("rear_lateral=1mm");
  EXPECT_EQ(by.front_y, 0);
  EXPECT_EQ(by.body_phi, 0);
}

std::string Fault(const std::string& text) {
  try {
    ParsePerturbation(text);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(ParsePerturbation, NamesThePartThatIsWrong) {
  const std::string places =
      "--start: expected PLACE=VALUE with PLACE one of body_lateral, body_roll, body_yaw, front_lateral, front_yaw, "
      "rear_lateral, rear_yaw, found ";
  EXPECT_EQ(Fault("front=5mm"), places + "\"front=5mm\"");
  EXPECT_EQ(Fault("front_lateral=5mm,"), places + "\"\"");
  EXPECT_EQ(Fault("front_lateral"), places + "\"front_lateral\"");
  const std::string length = "--start: expected a number with its unit (cm, m, mm), found ";
  EXPECT_EQ(Fault("front_lateral=5"), length + "\"front_lateral=5\"");
  EXPECT_EQ(Fault("front_lateral=5mrad"), length + "\"front_lateral=5mrad\"");
  EXPECT_EQ(Fault("front_lateral=nan mm"), length + "\"front_lateral=nan mm\"");
  EXPECT_EQ(Fault("front_lateral=mm"), length + "\"front_lateral=mm\"");
  EXPECT_EQ(Fault("body_roll=5mm"),
            "--start: expected a number with its unit (deg, mrad, rad), found \"body_roll=5mm\"");
  EXPECT_EQ(Fault("front_yaw=1rad"), "--start: expected at most 100 mrad to either side, found \"front_yaw=1rad\"");
  EXPECT_EQ(Fault("body_lateral=-1e300m"),
            "--start: expected at most 200 mm to either side, found \"body_lateral=-1e300m\"");
  EXPECT_EQ(Fault("body_roll=5mrad,body_roll=4mrad"), "--start: expected each place once, found \"body_roll=4mrad\"");
}

}  // namespace
}  // namespace uiclink
