#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace uiclink {

/// A command of the program `identify` that has a file of its own.
struct Command {
  CLI::App* app = nullptr;   ///< says whether the command line chose it
  std::function<int()> run;  ///< does the work; the exit code. @throws InputError, which main() prints
};

/// `identify digitise`: a scanned, photographed or exported plot -> a record.
Command AddDigitiseCommand(CLI::App* program);

/// `identify track`: a filmed ring-down -> a record.
Command AddTrackCommand(CLI::App* program);

}  // namespace uiclink
