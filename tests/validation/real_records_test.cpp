// Measured free decays of real friction oscillators (../shared/real beside the project; see its README). They are
// pendulums on bearings, no links: the tests ask what can be said about them honestly, not for parameters that nobody
// knows.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>
#include <vector>

#include "identify/identification.h"

namespace uiclink {
namespace {

std::filesystem::path Folder() { return std::filesystem::path(UICLINK_SOURCE_DIR) / ".." / "shared" / "real"; }

class RealRecords : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(Folder())) GTEST_SKIP() << "no measured records beside the project";
  }

  static Identification Run(const std::vector<std::string>& files, const ReadOptions& options = {}) {
    std::vector<Record> records;
    for (const std::string& file : files) {
      ReadOptions read = options;
      read.direction = Direction::kLateral;
      records.push_back(ReadRecord(Folder() / file, read));
    }
    return Identify(Direction::kLateral, std::move(records));
  }

  static bool Warns(const Identification& id, const std::string& words) {
    for (const std::string& warning : id.warnings)
      if (warning.find(words) != std::string::npos) return true;
    return false;
  }
};

TEST_F(RealRecords, SmallSwingIsARigidSliderWithTheDecrementsFriction) {
  const Identification id = Run({"pendulum_small_swing.txt"});
  ASSERT_EQ(id.CountUsed(), 1);
  // Bearings have no spring beside their friction: a rigid slider, of which the textbook reads k = w^2/g off the period
  // and T0 = k dA/2 off the loss per half swing. Both by hand from the first and the eighth extremum:
  const std::vector<Extremum>& e = id.records[0].phases.extrema;
  ASSERT_GT(e.size(), 8u);
  const double w = std::numbers::pi * 7 / (e[7].t - e[0].t);
  const double k = w * w / kThesisGravity;
  const double loss = (std::abs(e[0].y - e[1].y) - std::abs(e[6].y - e[7].y)) / 2 / 6;
  // 3 %: the half swings are a little shorter near the end of a rigid slider's decay, and the losses differ by that
  // much.
  EXPECT_NEAR(id.link.k, k, 0.03 * k);
  EXPECT_NEAR(id.link.sliders()[0].T0, k * loss / 2, 0.05 * k * loss / 2);
  EXPECT_LT(id.quantities[0].low, k * 1.03);
  // Nearly rigid: critical displacement some noise levels or encoder steps (0.157 mrad), far below the swing of 66
  // mrad.
  EXPECT_LT(id.link.sliders()[0].T0 / id.link.sliders()[0].k, 1.5e-3);
  EXPECT_LT(id.rms, 0.02 * 0.066);  // the plain model explains 98 % of the swing
}

TEST_F(RealRecords, LargeSwingIsSaidNotToFollowTheModel) {
  // From 93 degrees a pendulum softens by 15 % in frequency: no k describes the whole record.
  const struct {
    const char* file;
    const char* unit;
  } cases[] = {{"pendulum_large_swing.txt", "mm"}, {"pendulum_large_swing.mat", "rad"}};
  for (const auto& [file, unit] : cases) {
    const Identification id = Run({file}, {.displacement_unit = unit});
    ASSERT_EQ(id.CountUsed(), 1) << id.records[0].reason;
    EXPECT_TRUE(Warns(id, "does not follow the motion")) << file;
  }
}

TEST_F(RealRecords, RotaryPendulumsDoNotShareOneLink) {
  // Three releases of one pendulum from 45 to 135 degrees: the larger the swing, the smaller the k that fits best.
  const Identification id = Run({"rotary_pendulum_01.txt", "rotary_pendulum_02.txt", "rotary_pendulum_03.txt"});
  ASSERT_EQ(id.CountUsed(), 3);
  EXPECT_FALSE(id.shared);
  EXPECT_GT(id.records[2].link.k, id.records[0].link.k);                // 45 degrees before 90
  EXPECT_GT(id.records[0].link.k, id.records[1].link.k);                // 90 before 135
  EXPECT_NEAR(id.records[0].noise.quantum, 1e-3 * 360.0 / 3960, 2e-6);  // encoder step 0.0909 degrees, read as mm
}

}  // namespace
}  // namespace uiclink
