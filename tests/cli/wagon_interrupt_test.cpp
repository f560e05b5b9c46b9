// wagon simulate, interrupted: it writes what it has.

#include <gmock/gmock.h>

#include <chrono>
#include <thread>

#include "tests/cli/running_program.h"
#include "tests/cli/wagon_fixture.h"

namespace uiclink {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

/// Waits until the process has its own handler for the signal (or has ended).
void WaitForHandler(Running* running, int signal) {
  const std::string key = "SigCgt:";
  while (!running->Ended()) {
    const std::string status = ReadAll("/proc/" + std::to_string(running->pid()) + "/status");
    const std::size_t at = status.find(key);
    if (at != std::string::npos && (std::stoull(status.substr(at + key.size()), nullptr, 16) >> (signal - 1) & 1) != 0)
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST_F(WagonProgram, ARunInTimeThatIsInterruptedWritesWhatItHas) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Running running(
        {UICLINK_WAGON, "simulate", "--geometry", "thesis-equivalent", "--time", "1000000", "--start",
         "front_lateral=5mm", "--speed", "24", "--output-rate", "1", "--no-forces", "--json", "-", "--quiet"},
        {.folder = Folder()});
    WaitForHandler(&running, signal);
    running.Signal(signal);
    const ProgramResult result = running.Wait();
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr("wagon: the run ended early: "));
    EXPECT_THAT(result.out, StartsWith("{"));
    EXPECT_TRUE(Exists("out/simulation.json"));
    std::filesystem::remove_all(Folder() / "out");
  }
}

}  // namespace
}  // namespace uiclink
