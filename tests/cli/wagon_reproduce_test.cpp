// wagon reproduce: killed and gone on with, its pages, and that its figures are those of the other commands.

#include <gmock/gmock.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> kTwo{"reproduce", "--quick",  "--geometry", "thesis-equivalent",
                                    "--only",    "fig-10.2", "--only",     "10.7",
                                    "--threads", "1",        "--out",      "out"};

const Json* FindItem(const Json& result, const std::string& id) {
  for (const Json& item : result["items"])
    if (item["id"] == id) return &item;
  return nullptr;
}

double ValueOf(const Json& result, const std::string& id, const std::string& what) {
  const Json* const item = FindItem(result, id);
  if (item == nullptr) return std::nan("");
  for (const Json& row : (*item)["rows"]) {
    const Json& value = row["ours"]["thesis-equivalent"]["value"];
    if (row["what"] == what && value.is_number()) return value;
  }
  return std::nan("");
}

/// Starts the program and kills it as soon as the first result is there.
void KillAfterFirstResult(const std::filesystem::path& folder) {
  std::vector<std::string> words = kTwo;
  words.insert(words.begin(), UICLINK_WAGON);
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (chdir(folder.c_str()) == 0) execv(argv[0], argv.data());
    _exit(126);
  }
  const std::filesystem::path results = folder / "out/results/thesis-equivalent";
  const auto patience = std::chrono::steady_clock::now() + std::chrono::minutes(4);
  const auto any = [&] { return std::filesystem::exists(results) && !std::filesystem::is_empty(results); };
  while (!any() && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
}

TEST_F(WagonProgram, ReproduceGoesOnAfterAKillAndHasTheFiguresOfTheOtherCommands) {
  KillAfterFirstResult(Folder());
  ASSERT_FALSE(List("out/results/thesis-equivalent").empty());
  const Json second = RunJson(kTwo);
  EXPECT_LE(second["computed"], 1);
  EXPECT_THAT(List("out/results/thesis-equivalent"), ElementsAre("fig-10.2.json", "fig-10.7.json"));
  EXPECT_THAT(List("out"),
              ElementsAre("10.2.1.html", "10.2.2.html", "10.5.html", "index.html", "reproduce.json", "results"));
  EXPECT_THAT(Read("out/10.2.1.html"), HasSubstr("aria-label=\"thesis-equivalent: eigenvalues around 18.40 m/s\""));
  const std::string page = Read("out/10.2.2.html");
  EXPECT_EQ(RunJson(kTwo)["computed"], 0);
  EXPECT_EQ(Read("out/10.2.2.html"), page);

  const std::vector<std::string> wagon{"--set", "set1", "--geometry", "thesis-equivalent", "--com", "printed"};
  std::vector<std::string> stability{"stability", "--no-type", "--step", "1"};
  stability.insert(stability.end(), wagon.begin(), wagon.end());
  EXPECT_EQ(ValueOf(second, "fig-10.2", "linear critical speed [m/s]"),
            RunJson(stability)["linear_critical_speed"]["value"]);
  std::vector<std::string> simulate{"simulate", "--speed", "40",       "--start", "front_lateral=5mm, rear_lateral=5mm",
                                    "--time",   "30",      "--window", "10"};
  simulate.insert(simulate.end(), wagon.begin(), wagon.end());
  const Json run = RunJson(simulate);
  EXPECT_EQ(ValueOf(second, "fig-10.7", "rear wheelset, half width [mm]"), run["amplitude_mm"]["rear_lateral"]);
  EXPECT_EQ(ValueOf(second, "fig-10.7", "hunting frequency [Hz]"), run["frequency_hz"]["body_lateral"]);
}

TEST_F(WagonProgram, ReproduceNamesWhatItDoesNotKnow) {
  const ProgramResult item = Run({"reproduce", "--only", "10.31"});
  EXPECT_EQ(item.exit_code, 2);
  EXPECT_THAT(item.err, HasSubstr("--only: expected an item (wagon reproduce --list), found \"10.31\""));
  const ProgramResult section = Run({"reproduce", "--section", "9.1"});
  EXPECT_EQ(section.exit_code, 2);
  EXPECT_THAT(section.err, HasSubstr("--section: expected one of 10.1 to 10.5, found \"9.1\""));
  EXPECT_THAT(Run({"reproduce", "--list", "--only", "10.9"}).out, HasSubstr("fig-10.8"));
  EXPECT_THAT(List(), ElementsAre());
}

}  // namespace
}  // namespace uiclink
