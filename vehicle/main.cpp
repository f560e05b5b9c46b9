// The program `wagon`: a two-axle freight wagon on the links that `identify` has found.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <vector>

#include "data/input_error.h"
#include "vehicle/commands.h"

namespace uiclink {
namespace {

std::vector<Command> AddCommands(CLI::App* program) {
  return {AddSimulateCommand(program), AddStabilityCommand(program), AddBifurcationCommand(program),
          AddSpectrumCommand(program), AddContactCommand(program),   AddInertiaCommand(program),
          AddElementCommand(program),  AddSweepCommand(program),     AddReproduceCommand(program)};
}

/// CLI11 takes the first word of a command line that is no command for an argument too many, and does not name it.
void CheckCommand(int argc, char** argv, const std::vector<Command>& commands) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string names;
  for (const Command& command : commands) {
    if (command.app->get_name() == argv[1]) return;
    names += (names.empty() ? "" : ", ") + command.app->get_name();
  }
  throw UsageError(fmt::format("expected one of {}, found \"{}\"", names, argv[1]));
}

int Main(int argc, char** argv) {
  CLI::App program{"wagon: a Hbbills 311 two-axle freight wagon on UIC link suspensions"};
  program.set_version_flag("--version", std::string("wagon ") + UICLINK_VERSION + " (uiclink)");
  program.require_subcommand(1);
  program.footer(
      "Examples:\n"
      "  wagon stability --set set1\n"
      "  wagon bifurcation --set set1 --geometry thesis-equivalent\n"
      "  wagon simulate --set out/parameters.toml --cargo packed --speed 30 --time 60 --start front_lateral=5mm\n"
      "  wagon contact --geometry nominal-1435 --out out\n"
      "  wagon inertia --cargo water\n"
      "Each command explains itself: wagon simulate --help\n\n"
      "Exit codes: 0 all done; 1 done, but something was left out or is not trustworthy; 2 nothing could be done.");
  const std::vector<Command> commands = AddCommands(&program);
  for (const Command& command : commands) TidyHelp(command.app);
  try {
    CheckCommand(argc, argv, commands);
    KeepCommandLine(argc, argv);
    program.parse(argc, argv);
    for (const Command& command : commands) {
      if (command.app->parsed()) return command.run();
    }
    return kNothingDone;
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? kAllDone : kNothingDone;
  } catch (const InputError& error) {  // "file:line: expected ..., found ..."
    fmt::print(stderr, "{}\n", error.what());
    return kNothingDone;
  } catch (const std::exception& error) {
    fmt::print(stderr, "wagon: {}\n", error.what());
    return kNothingDone;
  }
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) { return uiclink::Main(argc, argv); }
