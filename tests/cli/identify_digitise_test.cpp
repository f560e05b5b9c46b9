// `identify digitise` as a user meets it: record, overlay, JSON, exit codes, messages.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "identify/digitise/picture.h"
#include "identify/record.h"
#include "tests/cli/identify_fixture.h"
#include "tests/support/drawn_plot.h"
#include "tests/support/shipped_record.h"

namespace uiclink {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class IdentifyDigitise : public IdentifyProgram {
 protected:
  void SetUp() override {
    const Record record = ShippedLateral(2);
    y_ = InMillimetres(record);
    plot_ = DrawPlot(record.t, y_, y_, style_);
    digitise::WritePicture(Folder() / "plot.png", plot_.picture);
  }

  PlotStyle style_{.name = "plot", .width = 640, .height = 450, .line_width = 2, .colour = {180, 119, 31}};
  std::vector<double> y_;
  DrawnPlot plot_;
  const std::vector<std::string> ranges_{"--x-range", "0,15", "--y-range", "-35,35"};

  ProgramResult Digitise(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"digitise", "plot.png"});
    return Run(arguments);
  }
  ProgramResult DigitiseFrame(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), ranges_.begin(), ranges_.end());
    return Digitise(std::move(arguments));
  }
};

TEST_F(IdentifyDigitise, WritesARecordThatReadsBackAndAnOverlay) {
  const ProgramResult run = DigitiseFrame({"--record", "r.txt", "--direction", "lateral", "--mass", "400"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out,
              AllOf(StartsWith("plot.png: blue (#1f77b4) curve, "), HasSubstr("Written: r.txt r.overlay.png\n")));
  const Record record = ReadRecord(Folder() / "r.txt");
  EXPECT_EQ(record.direction, Direction::kLateral);
  EXPECT_EQ(record.mass_kg, 400);
  EXPECT_TRUE(record.uniform);
  EXPECT_THAT(record.source, StartsWith("digitised from plot.png, blue (#1f77b4) curve, "));
  EXPECT_THAT(Read("r.txt"), HasSubstr("\ntime_s\tdisplacement_mm\tuncertainty_mm\n"));
  EXPECT_EQ(digitise::ReadPicture(Folder() / "r.overlay.png").width, 640);
  // Against the drawn record, at rest: 0.3 px of 0.19 mm.
  EXPECT_NEAR(1e3 * record.y[10], y_[static_cast<std::size_t>(std::lround(200 * record.t[10]))], 0.06);
}

TEST_F(IdentifyDigitise, PointsUnitsAndJson) {
  const auto point = [&](double t, double y) {
    return fmt::format("{:.3f},{:.3f}={},{}", plot_.X(style_, t), plot_.Y(style_, y), t, y / 10);
  };
  const ProgramResult run = Digitise({"--point", point(0, -30), "--point", point(15, 30), "--unit", "cm", "--record",
                                      "r.txt", "--curve", "blue", "--overlay", "o.png", "--json", "-"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["schema"], "digitise/1");
  EXPECT_EQ(json["scale"]["unit"], "cm");
  EXPECT_GT(json["checks"]["line_found"].get<double>(), 0.99);
  EXPECT_TRUE(json["warnings"].empty());
  EXPECT_EQ(ReadRecord(Folder() / "r.txt").t.size(), json["samples"].get<std::size_t>());
  EXPECT_TRUE(Exists("o.png"));
  EXPECT_FALSE(Exists("r.overlay.png"));
  EXPECT_NEAR(1e2 * ReadRecord(Folder() / "r.txt").y[10], y_[2] / 10, 0.01);
}

TEST_F(IdentifyDigitise, ExitsWithOneWhenTheRangesContradictTheTicks) {
  const ProgramResult run = Digitise({"--x-range", "0,14", "--y-range", "-35,35", "--record", "r.txt", "--quiet"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, AllOf(StartsWith("plot.png: the time axis has ticks at"), HasSubstr("is its range right?")));
  EXPECT_TRUE(Exists("r.txt"));
}

TEST_F(IdentifyDigitise, ExitsWithTwoAndWritesNothingOtherwise) {
  const struct {
    std::vector<std::string> arguments;
    const char* words;
  } cases[] = {
      {{"--record", "r.txt"}, "plot.png: expected what the axes show: --x-range and --y-range"},
      {{"--record", "r.txt", "--x-range", "15,0", "--y-range", "-35,35"}, "expected LOW,HIGH with LOW below HIGH"},
      {{"--record", "r.txt", "--x-range", "0,nan", "--y-range", "-35,35"}, "expected LOW,HIGH with LOW below HIGH"},
      {{"--record", "r.txt", "--point", "1,2,3"}, "expected PX,PY=T,Y"},
      {{"--record", "r.txt", "--x-range", "0,15", "--y-range", "-35,35", "--curve", "red"},
       "plot.png: expected a red curve, found 1 blue"},
      {{"--record", "r.txt", "--x-range", "0,15", "--y-range", "-35,35", "--unit", "furlong"}, "furlong"},
      {{"--x-range", "0,15", "--y-range", "-35,35"}, "--record is required"},
  };
  for (const auto& [arguments, words] : cases) {
    const ProgramResult run = Digitise(arguments);
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_THAT(run.out + run.err, HasSubstr(words));
    EXPECT_FALSE(Exists("r.txt"));
    EXPECT_FALSE(Exists("r.overlay.png"));
  }
  Write("plot.png", "no picture");
  const ProgramResult run = DigitiseFrame({"--record", "r.txt"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "plot.png: expected a picture (PNG, JPEG, TIFF, BMP, WebP), found none; export or scan the plot\n");
}

}  // namespace
}  // namespace uiclink
