#include "identify/command_line.h"

#include <fmt/chrono.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <exception>
#include <filesystem>

#include "data/checksum.h"
#include "reports/escape.h"

namespace uiclink {
namespace {

std::string ValueOf(const CLI::Option& option) {
  if (option.count() == 0) return option.get_default_str();
  if (option.get_items_expected_max() == 0) return "yes";  // a flag
  std::string text;
  for (const std::string& result : option.results()) text += (text.empty() ? "" : " ") + result;
  return text;
}

}  // namespace

Provenance DescribeCommandLine(int argc, const char* const* argv, const CLI::App& app,
                               const std::vector<std::string>& files) {
  Provenance provenance;
  provenance.command = QuoteCommand(argc, argv);
  provenance.written = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)));
  for (const CLI::Option* const option : app.get_options()) {
    if (option->get_positional() || option->get_lnames().empty()) continue;
    const std::string& name = option->get_lnames().front();
    if (name != "help" && name != "version") provenance.options.emplace_back("--" + name, ValueOf(*option));
  }
  for (const std::string& file : files) {
    Provenance::Input input{.file = file, .sha256 = {}};
    try {
      // A device never ends, and a pipe waits: those are no records anyway.
      if (std::filesystem::is_regular_file(file)) input.sha256 = CalcFileSha256(file);
    } catch (const std::exception&) {
    }  // the page says that it could not be read
    provenance.inputs.push_back(std::move(input));
  }
  return provenance;
}

}  // namespace uiclink
