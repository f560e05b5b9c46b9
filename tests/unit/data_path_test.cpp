#include "data/data_path.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "data/input_error.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

class DataPath : public testing::Test {
 protected:
  ~DataPath() override { unsetenv("UICLINK_DATA"); }
  static std::string Fault(const std::string& text) {
    try {
      FindDataFile("parameter_sets", text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(DataPath, ATestInTheBuildTreeFindsTheSourceTree) {
  EXPECT_EQ(fs::canonical(DataFolder()), fs::canonical(fs::path(UICLINK_SOURCE_DIR) / "data"));
  EXPECT_THAT(DataNames("parameter_sets"), testing::IsSupersetOf({"set1", "set2"}));
  EXPECT_EQ(fs::canonical(FindDataFile("parameter_sets", "set1")),
            fs::canonical(fs::path(UICLINK_SOURCE_DIR) / "data/parameter_sets/set1.toml"));
}

TEST_F(DataPath, TheEnvironmentComesFirst) {
  folder_.Write("parameter_sets/mine.toml", "");
  folder_.Write("parameter_sets/README.md", "");
  setenv("UICLINK_DATA", folder_.path().c_str(), 1);
  EXPECT_EQ(DataFolder(), folder_.path());
  EXPECT_THAT(DataNames("parameter_sets"), testing::ElementsAre("mine"));
  EXPECT_EQ(FindDataFile("parameter_sets", "mine"), folder_.path() / "parameter_sets/mine.toml");
  setenv("UICLINK_DATA", (folder_.path() / "none").c_str(), 1);
  EXPECT_THROW(DataFolder(), InputError);
}

TEST_F(DataPath, WhatLooksLikeAPathIsOne) {
  folder_.Write("set1.toml", "");
  const fs::path file = folder_.path() / "set1.toml";
  EXPECT_EQ(FindDataFile("parameter_sets", file.string()), file);
  EXPECT_EQ(FindDataFile("parameter_sets", "/dev/null"), "/dev/null") << "a pipe would do";
}

TEST_F(DataPath, SaysWhereNoNameIs) {
  folder_.Write("wagons/one.toml", "");
  setenv("UICLINK_DATA", folder_.path().c_str(), 1);
  EXPECT_THAT(Fault("set1"), testing::HasSubstr("expected a file (the folder " + folder_.path().string() +
                                                "/parameter_sets of data files has none), found none"));
}

TEST_F(DataPath, SaysWhichNamesThereAre) {
  folder_.Write("parameter_sets/set1.toml", "");
  folder_.Write("parameter_sets/set2.toml", "");
  setenv("UICLINK_DATA", folder_.path().c_str(), 1);
  EXPECT_EQ(Fault("set3"), "set3: expected a file or one of set1, set2, found neither");
  EXPECT_EQ(Fault("./set1.tml"), "./set1.tml: expected a file or one of set1, set2, found neither");
  EXPECT_EQ(Fault("/"), "/: expected a file or one of set1, set2, found a folder");
  EXPECT_EQ(Fault(""), "\"\": expected a file or one of set1, set2, found neither");
}

}  // namespace
}  // namespace uiclink
