// `identify track` from the command line: files, exit codes, messages.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/cli/identify_fixture.h"
#include "tests/support/film_maker.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class IdentifyTrack : public IdentifyProgram {
 protected:
  IdentifyTrack() {
    settings_ = {.width = 320,
                 .height = 120,
                 .pictures = 200,
                 .object_width = 60,
                 .object_height = 40,
                 .object_at = {160.2, 60.3},
                 .noise = 1,
                 .codec = "MJPG"};
    settings_.motion = [](double t) {
      return track::Point{60 * std::exp(-0.2 * t) * std::cos(2 * std::numbers::pi * t), 0};
    };
  }
  void Shoot(const FilmFaults& faults = {}) const { MakeFilm(settings_, Folder() / "film.avi", faults); }

  FilmSettings settings_;
};

TEST_F(IdentifyTrack, WritesARecordThatIdentifyReads) {
  Shoot();
  const ProgramResult run = Run({"track", "film.avi", "--mm-per-pixel", "0.4", "--roi", "195,44,50,32", "--direction",
                                 "lateral", "--mass", "378.2", "--record", "swing.txt"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.err, IsEmpty());
  EXPECT_THAT(run.out, HasSubstr("film.avi: 200 samples of 200 pictures (320 x 120)"));
  EXPECT_THAT(run.out, HasSubstr("Written: swing.txt swing.png"));
  EXPECT_THAT(Read("swing.txt"), HasSubstr("time_s\tdisplacement_mm\tuncertainty_mm\n"));
  EXPECT_TRUE(Exists("swing.png"));
  EXPECT_NE(Run({"swing.txt", "--no-wagon", "--no-diagnosis"}).exit_code, 2);
}

TEST_F(IdentifyTrack, JsonGoesAloneToStandardOutput) {
  Shoot();
  const ProgramResult run = Run({"track", "film.avi", "--mm-per-pixel", "0.4", "--record", "swing.txt", "--json", "-"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["schema"], "track/1");
  EXPECT_EQ(json["samples"], 200);
  EXPECT_EQ(json["camera"]["model"], "still");
}

TEST_F(IdentifyTrack, WhatIsLeftOutIsSaidWithExitCode1) {
  Shoot({.dropped = {61, 62}});
  const ProgramResult run =
      Run({"track", "film.avi", "--mm-per-pixel", "0.4", "--roi", "195,44,50,32", "--record", "swing.txt", "--quiet"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, IsEmpty());
  EXPECT_THAT(run.err, HasSubstr("film.avi: at 1.22 s the motion jumps as if 2 pictures were missing"));
  EXPECT_THAT(Read("swing.txt"), HasSubstr("# 2 pictures missing after picture 61 (1.2 s)\n"));
}

TEST_F(IdentifyTrack, UsageAndFilesAreRefusedWithExitCode2) {
  Write("text.mp4", "no film\n");
  const auto refuse = [this](std::vector<std::string> options, const std::string& message) {
    options.insert(options.begin(), "track");
    options.insert(options.end(), {"--record", "swing.txt"});
    const ProgramResult run = Run(options);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err, HasSubstr(message));
    EXPECT_THAT(run.out, IsEmpty());
    EXPECT_FALSE(Exists("swing.txt"));
  };
  refuse({"none.mp4", "--mm-per-pixel", "0.2"}, "none.mp4: expected a film, found no such file\n");
  refuse({"text.mp4", "--mm-per-pixel", "0.2"}, "text.mp4: expected a film (MP4, MKV, AVI, MOV, ...");
  refuse({"text.mp4"}, "--mm-per-pixel or --tag-mm is required");
  refuse({"text.mp4", "--mm-per-pixel", "nan"}, "expected a number above 0, found \"nan\"");
  refuse({"text.mp4", "--mm-per-pixel", "0.2", "--tag-mm", "40"}, "excludes");
  refuse({"text.mp4", "--mm-per-pixel", "0.2", "--roi", "1,2,3"}, "expected X,Y,W,H");
  refuse({"text.mp4", "--mm-per-pixel", "0.2", "--axis", "z"}, "--axis");
}

}  // namespace
}  // namespace uiclink
