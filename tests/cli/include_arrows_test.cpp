// The arrows of the design, read off the #include lines: identify -> vehicle -> {data, reports, dynamics} -> model.
//
// A room is a folder with code of its own. Every source file is read, every include is resolved (from the file's
// folder, then from the root, in quotes or in angle brackets) and looked up in the table below. tests/ may include
// everything and is not read; no room may include tests/.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using Words = std::set<std::string>;

/// What a room may include. A library in a header is seen by everybody who includes that header, so few are allowed
/// there.
struct Room {
  std::string name;
  Words rooms;             ///< rooms of ours, beside itself
  Words header_libraries;  ///< in its headers and sources
  Words source_libraries;  ///< in its sources alone
  /// Further rooms and libraries, in the files alone whose name or path matches the regular expression.
  std::vector<std::pair<std::string, Words>> exceptions = {};
};

const std::vector<Room>& Rooms() {
  static const std::vector<Room> rooms{
      {"model", {}, {"eigen", "ceres/jet"}, {}},
      {"data", {"model"}, {}, {"toml++", "fmt", "openssl", "posix"}},
      {"reports", {"model"}, {}, {"json", "fmt", "posix"}},
      {"dynamics", {}, {"eigen"}, {}},
      {"vehicle",
       {"data", "reports", "dynamics", "model"},
       {"eigen", "ceres/jet", "json_fwd"},
       {"sundials", "ceres", "matio", "json", "fmt", "cli11", "posix"},
       {{R"(sqlite\.cpp)", {"sqlite"}}, {R"(mpi_team\.cpp)", {"mpi"}}}},
      {"identify",
       {"data", "reports", "model"},
       {"eigen", "json_fwd"},
       {"ceres", "ceres/jet", "eigen", "matio", "json", "fmt", "cli11", "posix"},
       {{"validate.*", {"vehicle"}}, {R"((digitise|track).*\.cpp|identify/(digitise|track)/\w+\.cpp)", {"opencv"}}}},
      {"measurements/rig", {}, {}, {"toml++", "json", "fmt", "cli11", "posix"}},
  };
  return rooms;
}

/// The library of a header by its spelling in an #include; empty for the C++ standard library (no dot, no slash).
std::string LibraryOf(const std::string& header) {
  static const std::vector<std::pair<std::string, std::string>> patterns{
      {"[a-z_]+", ""},
      {R"(ceres/jet(_fwd)?\.h)", "ceres/jet"},
      {"ceres/.*|glog/.*", "ceres"},  // Ceres says through glog what a user shall not see
      {"(unsupported/)?Eigen/.*", "eigen"},
      {"CLI/.*", "cli11"},
      {"fmt/.*", "fmt"},
      {R"(matio\.h|H5\w+\.h)", "matio"},  // HDF5 reads what matio offers, and prints its errors unless told not to
      {R"(nlohmann/json_fwd\.hpp)", "json_fwd"},  // names only
      {"nlohmann/.*", "json"},
      {"opencv2/.*", "opencv"},
      {"openssl/.*", "openssl"},
      {R"(sqlite3\.h)", "sqlite"},
      {R"(mpi\.h)", "mpi"},
      {"(arkode|cvode|cvodes|kinsol|nvector|sundials|sunlinsol|sunmatrix|sunnonlinsol)/.*", "sundials"},
      {R"(toml(\+\+|plusplus)/.*|toml\+\+\.h)", "toml++"},
      {R"((unistd|fcntl|signal|poll|spawn|termios)\.h|sys/.*)", "posix"},
  };
  for (const auto& [pattern, library] : patterns) {
    if (std::regex_match(header, std::regex(pattern))) return library;
  }
  return header;  // an unknown one is allowed nowhere
}

bool IsHeader(const fs::path& file) { return file.extension() != ".cpp" && file.extension() != ".cc"; }

bool IsSource(const fs::path& file) {
  static const Words extensions{".h", ".hpp", ".hh", ".inc", ".ipp", ".tpp", ".cpp", ".cc"};
  return extensions.contains(file.extension().string());
}

/// The room of a path relative to the root; null for files outside of all rooms.
const Room* RoomOf(const fs::path& path) {
  const std::string text = path.generic_string();
  for (const Room& room : Rooms()) {
    if (text.starts_with(room.name + "/")) return &room;
  }
  return nullptr;
}

bool MayUse(const Room& room, const fs::path& file, const std::string& word) {
  if (room.rooms.contains(word) || room.header_libraries.contains(word)) return true;
  if (!IsHeader(file) && room.source_libraries.contains(word)) return true;
  return std::ranges::any_of(room.exceptions, [&](const auto& exception) {
    const std::regex pattern(exception.first);
    return exception.second.contains(word) &&
           (std::regex_match(file.filename().string(), pattern) || std::regex_match(file.generic_string(), pattern));
  });
}

/// Why `file` (relative to `root`) may not have #include <header> or "header"; empty when it may.
std::string Objection(const fs::path& root, const Room& room, const fs::path& file, const std::string& header) {
  const fs::path beside = (file.parent_path() / header).lexically_normal();
  const fs::path path = fs::exists(root / beside) ? beside : fs::path(header).lexically_normal();
  if (const Room* other = RoomOf(path)) {
    if (other == &room || MayUse(room, file, other->name)) return {};
    return room.name + " may not include " + other->name;
  }
  if (fs::exists(root / path)) return room.name + " may not include " + path.generic_string();
  const std::string library = LibraryOf(header);
  if (library.empty() || MayUse(room, file, library)) return {};
  return room.name + (IsHeader(file) ? " headers" : " sources") + " may not include " + library;
}

struct Findings {
  std::vector<std::string> objections;  ///< "model/slider.h:3: model may not include data", sorted
  std::set<std::string> rooms_read;
};

void ReadFile(const fs::path& root, const fs::path& file, Findings& findings) {
  const Room* room = RoomOf(file);
  if (room == nullptr) {
    findings.objections.push_back(file.generic_string() + ": a source file outside of every room");
    return;
  }
  findings.rooms_read.insert(room->name);
  static const std::regex include(R"(\s*#\s*include(?:_next)?\b\s*(.*))");
  static const std::regex name(R"re((?:"([^"]+)"|<([^>]+)>).*)re");
  std::ifstream stream(root / file);
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::smatch directive;
    if (!std::regex_match(line, directive, include)) continue;
    const std::string rest = directive[1];
    std::smatch header;
    const std::string objection = std::regex_match(rest, header, name)
                                      ? Objection(root, *room, file, header[1].matched ? header[1] : header[2])
                                      : "an #include that a reader cannot resolve: " + rest;
    if (!objection.empty()) {
      findings.objections.push_back(file.generic_string() + ":" + std::to_string(number) + ": " + objection);
    }
  }
}

/// Reads every source file under `root` but those of tests, build trees and hidden folders.
Findings CheckArrows(const fs::path& root) {
  static const Words skipped{"tests", "build", "out", "cmake", "docs"};
  Findings findings;
  for (auto entry = fs::recursive_directory_iterator(root); entry != fs::recursive_directory_iterator(); ++entry) {
    const fs::path file = entry->path().lexically_relative(root);
    const bool hidden = file.filename().string().starts_with(".");
    if (entry->is_directory() && (hidden || (entry.depth() == 0 && skipped.contains(file.string())))) {
      entry.disable_recursion_pending();
    } else if (entry->is_regular_file() && IsSource(file)) {
      ReadFile(root, file, findings);
    }
  }
  std::ranges::sort(findings.objections);
  return findings;
}

TEST(IncludeArrows, TheTreeHasOnlyThoseOfTheDesign) {
  const Findings findings = CheckArrows(UICLINK_SOURCE_DIR);
  EXPECT_THAT(findings.objections, testing::IsEmpty());
  EXPECT_THAT(findings.rooms_read, testing::IsSupersetOf({"model", "data", "identify", "measurements/rig"}));
}

/// A small tree in a temporary folder, in which wrong arrows can be planted.
class PlantedTree : public testing::Test {
 protected:
  PlantedTree() {
    for (const char* header : {"model/slider.h", "data/table.h", "reports/page.h", "vehicle/wagon.h",
                               "identify/record.h", "measurements/rig/link.h", "tests/unit/check.h"}) {
      tree_.Write(header, "#pragma once\n#include <vector>\n");
    }
  }

  /// The objections after one more file with this text.
  std::vector<std::string> Plant(const fs::path& file, const std::string& text) const {
    tree_.Write(file, text);
    return CheckArrows(tree_.path()).objections;
  }

  TemporaryFolder tree_;
};

using testing::ElementsAre;
using testing::IsEmpty;

TEST_F(PlantedTree, AllowedArrowsPass) {
  EXPECT_THAT(Plant("model/effects/drag.cpp", "#include \"model/slider.h\"\n#include \"../slider.h\"\n"), IsEmpty());
  EXPECT_THAT(Plant("model/arc.h", "#include <Eigen/Core>\n#include <ceres/jet.h>\n"), IsEmpty());
  EXPECT_THAT(Plant("data/table.cpp", "#include \"data/table.h\"\n#include <toml++/toml.h>\n"), IsEmpty());
  EXPECT_THAT(Plant("reports/page.cpp", "#include \"model/slider.h\"\n#include <nlohmann/json.hpp>\n"), IsEmpty());
  EXPECT_THAT(Plant("vehicle/wagon.cpp", "#include \"data/table.h\"\n#include \"reports/page.h\"\n"), IsEmpty());
  EXPECT_THAT(Plant("identify/main.cpp", "#include \"reports/page.h\"\n  #  include <CLI/CLI.hpp>  // why\n"),
              IsEmpty());
  EXPECT_THAT(Plant("identify/validate_wagon.cpp", "#include \"vehicle/wagon.h\"\n"), IsEmpty());
  EXPECT_THAT(Plant("identify/digitise.cpp", "#include <opencv2/core.hpp>\n"), IsEmpty());
  EXPECT_THAT(Plant("measurements/rig/main.cpp", "#include \"link.h\"\n"), IsEmpty());
  EXPECT_THAT(Plant("tests/unit/all.cpp", "#include \"vehicle/wagon.h\"\n"), IsEmpty());
}

TEST_F(PlantedTree, WrongArrowsAreNamedWithFileAndLine) {
  struct Case {
    std::string file, include, objection;
  };
  const std::vector<Case> cases{
      {"model/a.h", "\"data/table.h\"", "model may not include data"},
      {"model/a.cpp", "<reports/page.h>", "model may not include reports"},
      {"model/effects/a.cpp", "\"../../identify/record.h\"", "model may not include identify"},
      {"data/a.cpp", "\"reports/page.h\"", "data may not include reports"},
      {"data/a.cpp", "\"vehicle/wagon.h\"", "data may not include vehicle"},
      {"reports/a.cpp", "\"data/table.h\"", "reports may not include data"},
      {"vehicle/a.cpp", "\"identify/record.h\"", "vehicle may not include identify"},
      {"identify/fit.cpp", "\"vehicle/wagon.h\"", "identify may not include vehicle"},
      {"identify/a.cpp", "\"measurements/rig/link.h\"", "identify may not include measurements/rig"},
      {"identify/a.cpp", "\"tests/unit/check.h\"", "identify may not include tests/unit/check.h"},
      {"measurements/rig/a.cpp", "\"model/slider.h\"", "measurements/rig may not include model"},
      {"measurements/rig/a.cpp", "\"../../data/table.h\"", "measurements/rig may not include data"},
      {"measurements/rig/a.cpp", "<ceres/jet.h>", "measurements/rig sources may not include ceres/jet"},
      {"model/a.cpp", "<ceres/ceres.h>", "model sources may not include ceres"},
      {"model/a.h", "<fmt/format.h>", "model headers may not include fmt"},
      {"data/a.h", "<toml++/toml.h>", "data headers may not include toml++"},
      {"identify/a.h", "<ceres/ceres.h>", "identify headers may not include ceres"},
      {"identify/a.h", "<matio.h>", "identify headers may not include matio"},
      {"identify/a.cpp", "<opencv2/core.hpp>", "identify sources may not include opencv"},
      {"data/a.h", "<openssl/evp.h>", "data headers may not include openssl"},
      {"vehicle/a.cpp", "<openssl/evp.h>", "vehicle sources may not include openssl"},
      {"vehicle/a.h", "<matio.h>", "vehicle headers may not include matio"},
      {"vehicle/a.cpp", "<sqlite3.h>", "vehicle sources may not include sqlite"},
      {"vehicle/a.cpp", "<mpi.h>", "vehicle sources may not include mpi"},
      {"reports/a.h", "<nlohmann/json.hpp>", "reports headers may not include json"},
      {"vehicle/a.h", "<cvode/cvode.h>", "vehicle headers may not include sundials"},
      {"vehicle/a.cpp", "<boost/any.hpp>", "vehicle sources may not include boost/any.hpp"},
      {"model/a.cpp", "CONFIG_HEADER", "an #include that a reader cannot resolve: CONFIG_HEADER"},
  };
  for (const Case& c : cases) {
    EXPECT_THAT(Plant(c.file, "// line 1\n#include " + c.include + "\n"), ElementsAre(c.file + ":2: " + c.objection));
    fs::remove(tree_.path() / c.file);
  }
}

TEST_F(PlantedTree, SourcesOutsideOfEveryRoomAreNamed) {
  EXPECT_THAT(Plant("util/a.cpp", "#include <vector>\n"),
              ElementsAre("util/a.cpp: a source file outside of every room"));
}

}  // namespace
}  // namespace uiclink
