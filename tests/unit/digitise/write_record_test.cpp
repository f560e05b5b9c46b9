#include "identify/write_record.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "identify/noise.h"
#include "identify/record.h"

namespace uiclink {
namespace {

WrittenRecord Sample() {
  WrittenRecord record;
  record.source = "digitised from plot.png";
  record.direction = Direction::kLateral;
  record.mass_kg = 378.2;
  record.g = 9.82;
  for (int i = 0; i < 100; ++i) {
    record.t.push_back(0.25 + i / 40.0);
    record.y.push_back(20 * std::cos(0.2 * i));
    record.uncertainty.push_back(0.02 + 0.0001 * i);
  }
  return record;
}

TEST(FormatRecord, ReadsBackAsItWas) {
  const WrittenRecord written = Sample();
  const Record record = ParseRecord(FormatRecord(written), "r.txt");
  EXPECT_EQ(record.direction, Direction::kLateral);
  EXPECT_EQ(record.mass_kg, 378.2);
  EXPECT_EQ(record.g, 9.82);
  EXPECT_EQ(record.source, written.source);
  EXPECT_TRUE(record.uniform);
  EXPECT_DOUBLE_EQ(record.sampling_hz, 40);
  ASSERT_EQ(record.t.size(), written.t.size());
  ASSERT_EQ(record.uncertainty.size(), written.t.size());
  EXPECT_TRUE(record.notices.empty());
  for (std::size_t i = 0; i < written.t.size(); ++i) {
    EXPECT_NEAR(record.t[i], written.t[i], 1e-9);
    EXPECT_NEAR(1e3 * record.uncertainty[i], written.uncertainty[i], 0.51e-3);  // two digits
    EXPECT_NEAR(1e3 * record.y[i], written.y[i], 0.5e-4);  // four decimals: a hundredth of 0.025 mm, rounded up
  }
}

TEST(FormatRecord, HasAHeaderAndOneSampleALine) {
  const std::string text = FormatRecord(Sample());
  EXPECT_EQ(text.substr(0, text.find("0.250")),
            "# direction: lateral\n# mass_kg: 378.2\n# g: 9.82\n# displacement_unit: mm\n"
            "# source: digitised from plot.png\ntime_s\tdisplacement_mm\tuncertainty_mm\n");
  EXPECT_NE(text.find("\n0.250\t20.0000\t0.02\n0.275\t"), std::string::npos);
}

TEST(FormatRecord, OtherUnitsReadBackToo) {
  WrittenRecord written = Sample();
  written.unit = "cm";
  EXPECT_NEAR(ParseRecord(FormatRecord(written), "r.txt").y[0], 0.2, 1e-6);
}

TEST(FormatRecord, StatedUncertaintyIsTheLeastNoise) {
  const Record record = ParseRecord(FormatRecord(Sample()), "r.txt");
  const Noise alone = EstimateNoise(record.t, record.y);
  const Noise stated = EstimateNoise(record.t, record.y, record.uncertainty);
  EXPECT_LT(alone.sigma, 0.001e-3);                 // a smooth curve: rounding of four decimals
  EXPECT_NEAR(stated.sigma, 0.0251e-3, 0.0003e-3);  // rms of 0.0200 to 0.0299 mm, two digits each
  EXPECT_EQ(EstimateNoise(record.t, record.y, {}).sigma, alone.sigma);
}

TEST(FormatRecord, RefusesWhatIsNoRecord) {
  WrittenRecord record = Sample();
  record.y.pop_back();
  EXPECT_THROW(FormatRecord(record), std::invalid_argument);
  record = Sample();
  record.y[3] = std::nan("");
  EXPECT_THROW(FormatRecord(record), std::invalid_argument);
  record = Sample();
  record.t[3] = record.t[2];
  EXPECT_THROW(FormatRecord(record), std::invalid_argument);
}

}  // namespace
}  // namespace uiclink
