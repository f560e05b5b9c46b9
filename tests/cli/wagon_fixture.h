#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/cli/program_run.h"
#include "tests/cli/temporary_folder.h"

namespace uiclink {

using Json = nlohmann::json;

/// A test of the built program `wagon` in an empty folder of its own.
class WagonProgram : public testing::Test {
 protected:
  ProgramResult Run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), UICLINK_WAGON);
    return RunProgram(arguments, {.folder = Folder()});
  }

  /// The JSON that a command prints; a failure where it prints anything else or ends with another code.
  Json RunJson(std::vector<std::string> arguments, int exit_code = 0) const {
    arguments.insert(arguments.end(), {"--json", "-"});
    const ProgramResult result = Run(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    return Json::parse(result.out, nullptr, false);
  }

  const std::filesystem::path& Folder() const { return folder_.path(); }
  void Write(const std::string& file, const std::string& text) const { folder_.Write(file, text); }
  bool Exists(const std::string& file) const { return std::filesystem::exists(Folder() / file); }
  std::string Read(const std::string& file) const { return ReadAll(Folder() / file); }

  /// The names of everything in a folder, sorted.
  std::vector<std::string> List(const std::string& folder = ".") const {
    std::vector<std::string> names;
    if (!Exists(folder)) return names;
    for (const auto& entry : std::filesystem::directory_iterator(Folder() / folder))
      names.push_back(entry.path().filename());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  TemporaryFolder folder_;
};

/// A file that comes with the programs.
inline std::string DataFile(const std::string& file) {
  return (std::filesystem::path(UICLINK_SOURCE_DIR) / "data" / file).string();
}

}  // namespace uiclink
