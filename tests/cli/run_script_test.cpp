// The script `run`: in small trees of its own, with stand-ins for apt-get, dpkg-query, sudo and id, so that nothing of
// this machine is touched; and its table of packages against what the real tree asks CMake for.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "tests/cli/temporary_folder.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const fs::path kRoot = UICLINK_SOURCE_DIR;

std::string Text(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

constexpr const char* kTreeCMakeLists = R"(
cmake_minimum_required(VERSION 3.25)
project(tree LANGUAGES CXX)
option(UICLINK_BUILD_TESTS "" ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
add_subdirectory(identify)
if(EXISTS ${PROJECT_SOURCE_DIR}/vehicle)
  add_subdirectory(vehicle)
endif()
if(UICLINK_BUILD_TESTS)
  enable_testing()
  add_test(NAME quick COMMAND uiclink_identify_program)
  add_test(NAME slow COMMAND uiclink_identify_program)
  set_tests_properties(slow PROPERTIES LABELS long)
endif()
)";

/// Prints the folder it runs in and its arguments; its exit code is the number of arguments.
constexpr const char* kTreeProgram = R"(
#include <filesystem>
#include <iostream>
int main(int argc, char** argv) {
  std::cout << std::filesystem::current_path().string() << '\n';
  for (int i = 1; i < argc; ++i) std::cout << argv[i] << '\n';
  return argc - 1;
}
)";

// Says of every package that it is installed, but for those in the file `missing`.
constexpr const char* kDpkgQuery = R"(#!/bin/bash
for word; do
  case $word in -*) ;; *\$*) ;; *) grep -qx -- "$word" "$STAND_INS/missing" || echo "installed $word" ;; esac
done
[[ ! -s $STAND_INS/missing ]]
)";

constexpr const char* kAptGet = R"(#!/bin/bash
echo "$DEBIAN_FRONTEND apt-get $*" >>"$STAND_INS/calls"
echo "words that do not belong on standard output"
)";

constexpr const char* kSudo = R"(#!/bin/bash
echo "sudo $1" >>"$STAND_INS/calls"
[[ $1 != -n ]] || shift
[[ $SUDO_WORKS == yes ]] && exec "$@"
)";

constexpr const char* kId = R"(#!/bin/bash
echo "$USER_ID"
)";

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

class RunScript : public testing::Test {
 protected:
  RunScript() : tree_(folder_.path() / "a tree") {
    fs::create_directories(tree_);
    for (const char* file : {"run", "CMakePresets.json"}) fs::copy(kRoot / file, tree_ / file);
    Write("CMakeLists.txt", kTreeCMakeLists);
    AddProgram("identify", "identify");
    for (const auto& [tool, text] : std::map<std::string, std::string>{
             {"dpkg-query", kDpkgQuery}, {"apt-get", kAptGet}, {"sudo", kSudo}, {"id", kId}}) {
      folder_.Write("bin/" + tool, text);
      fs::permissions(folder_.path() / "bin" / tool, fs::perms::owner_all);
    }
    folder_.Write("bin/calls", "");
    SetMissing("");
  }

  /// Writes a file of the tree.
  void Write(const fs::path& file, const std::string& text) const { folder_.Write(tree_ / file, text); }

  void AddProgram(const std::string& room, const std::string& name) const {
    const std::string target = "uiclink_" + name + "_program";
    Write(fs::path(room) / "CMakeLists.txt", "add_executable(" + target + " main.cpp)\nset_target_properties(" +
                                                 target + " PROPERTIES OUTPUT_NAME " + name + ")\n");
    Write(fs::path(room) / "main.cpp", kTreeProgram);
  }

  void SetMissing(const std::string& packages) const { folder_.Write("bin/missing", packages); }
  std::string Calls() const { return Text(folder_.path() / "bin/calls"); }

  /// Runs a line of shell in `folder` with the stand-ins before everything else on the path.
  Outcome Shell(const std::string& line, const fs::path& folder, const std::string& environment = "") const {
    const auto quoted = [](const fs::path& path) { return "'" + path.string() + "'"; };
    const fs::path out = folder_.path() / "out.txt", err = folder_.path() / "err.txt";
    const std::string command = "cd " + quoted(folder) + " && unset UICLINK_NO_INSTALL CI && export STAND_INS=" +
                                quoted(folder_.path() / "bin") + " PATH=" + quoted(folder_.path() / "bin") +
                                ":\"$PATH\" USER_ID=0 SUDO_WORKS=no " + environment + " && { " + line + "; } >" +
                                quoted(out) + " 2>" + quoted(err) + " </dev/null";
    const int status = std::system(command.c_str());
    return {.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1, .out = Text(out), .err = Text(err)};
  }
  Outcome Run(const std::string& arguments, const std::string& environment = "") const {
    return Shell("./run " + arguments, tree_, environment);
  }

  TemporaryFolder folder_;
  fs::path tree_;
};

TEST_F(RunScript, HelpNamesEveryCommand) {
  for (const char* word : {"help", "--help", "-h"}) {
    const Outcome help = Run(word);
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.err, IsEmpty());
    for (const char* command : {"identify", "wagon", "rig", "tests [--long]", "bench", "help"}) {
      EXPECT_THAT(help.out, HasSubstr(std::string("\n  ") + command + " "));
    }
  }
}

TEST_F(RunScript, WithoutCommandItShowsTheUsageAndFails) {
  const Outcome outcome = Run("");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_EQ(outcome.err, Run("help").out);
}

TEST_F(RunScript, NamesAnUnknownCommand) {
  const Outcome outcome = Run("identfy record.txt");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_EQ(outcome.err, "run: unknown command 'identfy'; ./run help lists them\n");
}

TEST_F(RunScript, RunsTheProgramInTheUsersFolderAndSaysNothingElseOnStandardOutput) {
  const fs::path elsewhere = folder_.path() / "else where";
  fs::create_directories(elsewhere);
  fs::create_symlink(tree_ / "run", elsewhere / "link");
  const std::string expected = elsewhere.string() + "\nrecords/a b.txt\n--json\n-\n";

  const Outcome first = Shell("./link identify 'records/a b.txt' --json -", elsewhere);
  EXPECT_EQ(first.out, expected) << first.err;
  EXPECT_EQ(first.exit_code, 3);

  const Outcome second = Shell("../a\\ tree/run identify 'records/a b.txt' --json -", elsewhere);
  EXPECT_EQ(second.out, expected);
  EXPECT_THAT(second.err, IsEmpty()) << "nothing was out of date";
  EXPECT_EQ(second.exit_code, 3);
}

TEST_F(RunScript, BuildsAgainWhatHasChangedAndFollowsATreeThatMoves) {
  ASSERT_EQ(Run("identify").exit_code, 0);
  Write("identify/main.cpp", "int main() { return 42; }\n");
  EXPECT_EQ(Run("identify").exit_code, 42);

  fs::rename(tree_, folder_.path() / "moved");
  const Outcome moved = Shell("./run identify", folder_.path() / "moved");
  EXPECT_EQ(moved.exit_code, 42) << moved.err;
}

TEST_F(RunScript, ShowsWhyABuildFails) {
  Write("identify/main.cpp", "#error no such luck\n");
  const Outcome outcome = Run("identify");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_THAT(outcome.err,
              AllOf(HasSubstr("no such luck"), HasSubstr("run: building uiclink_identify_program failed")));
}

TEST_F(RunScript, AProgramThatIsNotThereIsSaidSoBeforeAnythingIsInstalled) {
  SetMissing("g++\n");
  const Outcome outcome = Run("wagon stability");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(outcome.err, "run: the program 'wagon' is not part of this version\n");
  EXPECT_EQ(Run("bench").err, "run: there are no benchmarks in this version\n");
  EXPECT_THAT(Calls(), IsEmpty());
}

TEST_F(RunScript, AProgramThatComesLaterIsFoundInATreeBuiltBefore) {
  ASSERT_EQ(Run("identify").exit_code, 0);
  AddProgram("vehicle", "wagon");
  Write("CMakeLists.txt", kTreeCMakeLists + std::string("# changed\n"));
  const Outcome outcome = Run("wagon stability");
  EXPECT_EQ(outcome.out, tree_.string() + "\nstability\n") << outcome.err;
}

TEST_F(RunScript, TestsAreBuiltIntoATreeThatHadNoneAndLongOnesWaitToBeAsked) {
  ASSERT_EQ(Run("identify").exit_code, 0);
  const Outcome quick = Run("tests");
  EXPECT_EQ(quick.exit_code, 0) << quick.err;
  EXPECT_THAT(quick.out, HasSubstr("100% tests passed, 0 tests failed out of 1\n"));
  EXPECT_THAT(Run("tests --long").out, HasSubstr("100% tests passed, 0 tests failed out of 2\n"));
  EXPECT_THAT(Run("tests --long -R slow").out, HasSubstr("100% tests passed, 0 tests failed out of 1\n"));
  EXPECT_NE(Run("tests -R no_such_test").exit_code, 0) << "no test at all is no success";

  Write("identify/main.cpp", "int main() { return 1; }\n");
  const Outcome failing = Run("tests");
  EXPECT_NE(failing.exit_code, 0);
  EXPECT_THAT(failing.out, HasSubstr("0% tests passed, 1 tests failed out of 1\n"));
}

TEST_F(RunScript, RootInstallsOnlyWhatIsMissingForTheCommand) {
  SetMissing("libceres-dev\nlibgtest-dev\n");
  const Outcome outcome = Run("identify");
  EXPECT_EQ(outcome.out, tree_.string() + "\n");
  EXPECT_THAT(outcome.err, HasSubstr("run: installing Debian packages: libceres-dev\n"));
  EXPECT_TRUE(std::regex_match(
      Calls(), std::regex("noninteractive apt-get .* update\n"
                          "noninteractive apt-get -q -y .* install --no-install-recommends libceres-dev\n")))
      << Calls();

  Run("tests");
  EXPECT_THAT(Calls(), HasSubstr("install --no-install-recommends libceres-dev libgtest-dev\n"));
}

TEST_F(RunScript, NothingIsInstalledWhenNothingIsMissingOrWhenForbidden) {
  EXPECT_EQ(Run("identify").exit_code, 0);
  SetMissing("libceres-dev\n");
  EXPECT_EQ(Run("identify", "UICLINK_NO_INSTALL=1").exit_code, 0);
  EXPECT_THAT(Calls(), IsEmpty());
}

TEST_F(RunScript, APackageWhoseCommandIsThereFromElsewhereIsNotAskedFor) {
  const std::string script = Text(kRoot / "run"), row = "nodejs|node ";
  ASSERT_THAT(script, HasSubstr(row));
  Write("run", std::string(script).replace(script.find(row), row.size(), "nodejs|some-node "));
  SetMissing("nodejs\nlibfmt-dev\n");
  EXPECT_EQ(Run("identify").exit_code, 0);
  EXPECT_THAT(Calls(), HasSubstr("install --no-install-recommends libfmt-dev nodejs\n"));

  folder_.Write("bin/some-node", "#!/bin/bash\n");
  fs::permissions(folder_.path() / "bin/some-node", fs::perms::owner_all);
  folder_.Write("bin/calls", "");
  EXPECT_EQ(Run("identify").exit_code, 0);
  EXPECT_THAT(Calls(), HasSubstr("install --no-install-recommends libfmt-dev\n"));
}

TEST_F(RunScript, AUserInstallsThroughSudoWhichNeverWaitsForAPasswordThatNobodyTypes) {
  SetMissing("libfmt-dev\n");
  EXPECT_EQ(Run("identify", "USER_ID=1000 SUDO_WORKS=yes").exit_code, 0);
  EXPECT_TRUE(std::regex_match(Calls(), std::regex("sudo -n\nsudo -n\n.* update\nsudo -n\n.* install .* libfmt-dev\n")))
      << Calls();
}

TEST_F(RunScript, AUserWithoutRightsIsToldWhatToAskFor) {
  SetMissing("libfmt-dev\nlibceres-dev\n");
  const Outcome outcome = Run("identify", "USER_ID=1000 SUDO_WORKS=no");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.out, IsEmpty());
  EXPECT_EQ(outcome.err,
            "run: Debian packages are missing and only root can install them: "
            "apt-get update && apt-get install --no-install-recommends libceres-dev libfmt-dev\n");
  EXPECT_THAT(Calls(), Not(HasSubstr("apt-get")));
}

/// For whom a package is needed: "programs", "tests" or "bench", as in the table of `run`.
using Users = std::set<std::string>;

/// The table of `run`: CMake package -> who needs it.
std::map<std::string, Users> PackageTable() {
  std::smatch table;
  const std::string script = Text(kRoot / "run");
  if (!std::regex_search(script, table, std::regex("package_table='\n([^']*)'"))) return {};
  std::map<std::string, Users> result;
  std::istringstream rows(table[1].str());
  for (std::string row; std::getline(rows, row);) {
    std::istringstream words(row);
    std::string users, package, debian_package;
    if (!(words >> users >> package >> debian_package)) {
      ADD_FAILURE() << "a row of three columns expected in the table of run: " << row;
    }
    if (package == "-") continue;
    std::istringstream list(users);
    for (std::string user; std::getline(list, user, ',');) result[package].insert(user);
  }
  return result;
}

/// What one CMake file asks for, and whether it does without: the X of find_package(X) (without REQUIRED: it does),
/// find_dependency(X), find_library(VARIABLE X) and find_path(VARIABLE X.h), and the modules of pkg_check_modules().
std::map<std::string, bool> PackagesOf(const fs::path& file) {
  const std::string text = std::regex_replace(Text(file), std::regex("#[^\n]*"), "");
  std::map<std::string, bool> packages;
  const std::regex call(
      R"((find_package|find_dependency|find_library|find_path|pkg_check_modules|pkg_search_module)\s*\(([^)]*)\))");
  for (std::sregex_iterator match(text.begin(), text.end(), call); match != std::sregex_iterator(); ++match) {
    const std::string command = (*match)[1], arguments = (*match)[2];
    std::istringstream words(arguments);
    std::string first, word;
    words >> first;
    if (command == "find_package" || command == "find_dependency") {
      packages[first] = command == "find_package" && arguments.find("REQUIRED") == std::string::npos;
      continue;
    }
    while (words >> word) {  // words in capitals are CMake's
      if (std::regex_match(word, std::regex("[A-Z_]+"))) continue;
      packages[word.substr(0, word.find_first_of("<>=."))] = false;
      if (!command.starts_with("pkg_")) break;
    }
  }
  packages.erase("Threads");  // of the C library
  return packages;
}

/// Who needs a package that this CMake file asks for.
Users UsersOf(const fs::path& file) {
  const std::string path = file.lexically_relative(kRoot).generic_string();
  if (path.starts_with("tests/bench/")) return {"bench"};
  if (path.starts_with("tests/support/")) return {"bench", "tests"};
  return path.starts_with("tests/") ? Users{"tests"} : Users{"programs"};
}

/// CMake package -> who needs it, by the CMake files of the tree.
std::map<std::string, Users> PackagesOfTheTree() {
  std::map<std::string, Users> result;
  for (auto entry = fs::recursive_directory_iterator(kRoot); entry != fs::recursive_directory_iterator(); ++entry) {
    const fs::path& file = entry->path();
    const std::string name = file.filename().string();
    // The consumer of the package test is a project of its own and finds nothing but our package.
    const bool foreign = file == kRoot / "build" || file == kRoot / "tests/package/consumer" || name.starts_with(".");
    if (entry->is_directory() && foreign) entry.disable_recursion_pending();
    if (name != "CMakeLists.txt" && !name.ends_with(".cmake") && !name.ends_with(".cmake.in")) continue;
    for (const auto& [package, optional] : PackagesOf(file))
      result[package].merge(optional ? Users{"tests"} : UsersOf(file));
  }
  return result;
}

TEST(RunScriptTable, InstallsEveryPackageThatTheTreeAsksFor) {
  const std::map<std::string, Users> table = PackageTable();
  const std::map<std::string, Users> tree = PackagesOfTheTree();
  ASSERT_TRUE(tree.contains("Ceres")) << "the CMake files were not read";
  for (const auto& [package, users] : tree) {
    ASSERT_TRUE(table.contains(package)) << "no row for find_package(" << package << ")";
    for (const std::string& user : users) {
      EXPECT_TRUE(table.at(package).contains(user) || table.at(package).contains("programs"))
          << package << " is needed by " << user;
    }
  }
}

TEST(RunScriptTable, InstallsNothingThatNobodyAsksFor) {
  const std::map<std::string, Users> tree = PackagesOfTheTree();
  for (const auto& [package, users] : PackageTable()) {
    ASSERT_TRUE(tree.contains(package)) << "nobody asks for " << package;
    for (const std::string& user : users) {
      EXPECT_TRUE(tree.at(package).contains(user)) << package << " is not needed by " << user;
    }
  }
}

}  // namespace
}  // namespace uiclink
