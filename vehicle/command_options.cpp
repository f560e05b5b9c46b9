// Options and outputs that commands share.

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>

#include "data/data_path.h"
#include "data/file.h"
#include "data/input_error.h"
#include "reports/escape.h"
#include "reports/wrap.h"
#include "vehicle/commands.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

/// An option whose values have names.
template <typename T>
CLI::Option* AddChoice(CLI::App* app, const std::string& name, T* value, const std::vector<T>& values,
                       const std::string& help) {
  std::map<std::string, T> words;
  std::string list;
  for (const T v : values) {
    words.emplace(Name(v), v);
    list += (list.empty() ? "" : "|") + std::string(Name(v));
  }
  const auto take = [value, words](const std::string& word) { *value = words.at(word); };
  std::vector<std::string> names;
  for (const auto& [word, v] : words) names.push_back(word);
  return app->add_option_function<std::string>(name, take, help)
      ->check(CLI::IsMember(names))
      ->type_name(list)
      ->default_str(Name(*value));
}

/// "NAME|FILE", with the names that there are in the help.
std::string NamesHelp(const std::string& what, std::string_view subfolder) {
  try {
    return fmt::format("{}: {}, or a file", what, fmt::join(DataNames(subfolder), ", "));
  } catch (const InputError&) {  // no data at all: the command will say so
    return what + ": a name or a file";
  }
}

/// Finite; nothing where the text is no number.
std::optional<double> ParseNumber(const std::string& text) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

constexpr const char* kGroup = "The wagon";

/// A folder that is there or can be made. What only writing shows, a full disk, shows then.
void CheckFolder(const fs::path& path) {
  std::error_code ignored;
  fs::path nearest = fs::absolute(path.empty() ? "." : path, ignored);
  while (!fs::exists(nearest, ignored) && nearest.has_relative_path()) nearest = nearest.parent_path();
  if (!fs::is_directory(nearest, ignored))
    throw InputError(path.string(), 0, "expected a folder for results, found the file " + nearest.string());
  if (::access(nearest.c_str(), W_OK | X_OK) != 0)
    throw InputError(path.string(), 0, "expected a folder to write to, found no permission at " + nearest.string());
}

void CheckFile(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored))
    throw InputError(path.string(), 0, "expected a file that can be written, found a directory");
  if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return;  // a pipe, a device
  CheckFolder(path.parent_path());
}

}  // namespace

void AddOutputOptions(CLI::App* app, Output* output, const std::string& folder) {
  output->folder = folder;
  app->add_option("--out", output->folder,
                  "folder of the results" + std::string(folder.empty() ? " (default: none are written)" : ""))
      ->type_name("DIR")
      ->default_str(folder);
  app->add_option("--json", output->json, "write the result as JSON to FILE; - for standard output, alone there")
      ->type_name("FILE");
  app->add_flag("--quiet,-q", output->quiet, "no tables on standard output");
  AddReportOption(app, output);
}

void AddReportOption(CLI::App* app, Output* output) {
  app->add_flag_callback(
      "--no-report", [output] { output->report = false; }, "no report as an HTML page among the results");
}

void AddBodyOptions(CLI::App* app, WagonChoice* choice) {
  app->add_option("--wagon", choice->wagon, NamesHelp("wagon", "wagons"))
      ->type_name("NAME|FILE")
      ->capture_default_str()
      ->group(kGroup);
  app->add_option("--cargo", choice->cargo, NamesHelp("freight", "freight"))
      ->type_name("NAME|FILE")
      ->capture_default_str()
      ->group(kGroup);
  const auto set_com = [choice](const std::string& word) {
    const Partitions partitions = choice->inertia.partitions;
    choice->inertia = word == Name(CentreOfMass::kPrinted) ? InertiaOptions::Printed() : InertiaOptions{};
    choice->inertia.partitions = partitions;
  };
  app->add_option_function<std::string>(
         "--com", set_com, "centre of mass and inertia: as appendix G of the thesis prints them, or corrected")
      ->check(CLI::IsMember({"printed", "corrected"}))
      ->type_name("printed|corrected")
      ->default_str("corrected")
      ->group(kGroup);
  AddChoice(app, "--partitions", &choice->inertia.partitions, {Partitions::kAtEnds, Partitions::kSpread},
            "where the four partition walls stand")
      ->group(kGroup);
}

void AddContactOptions(CLI::App* app, WagonChoice* choice) {
  CLI::Option* const geometry =
      app->add_option("--geometry", choice->geometry, NamesHelp("wheels on rails", "geometry"))
          ->type_name("NAME|FILE")
          ->capture_default_str()
          ->group(kGroup);
  app->add_option("--contact-table", choice->contact_table,
                  "contact table instead of the geometry's own (wagon contact --out FILE writes one)")
      ->type_name("FILE")
      ->excludes(geometry)
      ->group(kGroup);
}

void AddWagonOptions(CLI::App* app, WagonChoice* choice) {
  app->add_option("--set", choice->sets,
                  NamesHelp("links", "parameter_sets") +
                      "; WHERE=FILE for some of them: lateral, longitudinal, front, rear-left, front-left.lateral, "
                      "...; repeatable (default: set1)")
      ->type_name("[WHERE=]NAME|FILE")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kGroup);
  AddBodyOptions(app, choice);
  AddContactOptions(app, choice);
  AddChoice(app, "--suspension", &choice->options.suspension,
            {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf},
            "vertical springs; linear: the links have no sliders either")
      ->group(kGroup);
  app->add_flag_callback(
         "--no-guidance", [choice] { choice->options.guidance = false; }, "axle boxes never touch their guides")
      ->group(kGroup);
  AddChoice(app, "--penetration", &choice->options.penetration, {Penetration::kTouching, Penetration::kPrinted},
            "what the approach of wheel and rail is measured from")
      ->group(kGroup);
  app->add_option("--friction", choice->options.mu, "of wheel on rail")
      ->type_name("MU")
      ->check(CheckBetween(1e-6, 10, ""))
      ->capture_default_str()
      ->group(kGroup);
  const auto set_roll = [choice](const std::string& word) { choice->options.printed_roll = word == "printed"; };
  app->add_option_function<std::string>("--roll", set_roll,
                                        "roll of the wheelsets: as (2.4) prints it, or with the creep forces' moment")
      ->check(CLI::IsMember({"printed", "corrected"}))
      ->type_name("printed|corrected")
      ->default_str("corrected")
      ->group(kGroup);
}

std::function<std::string(const std::string&)> CheckBetween(double low, double high, const std::string& unit) {
  return [low, high, space_and_unit = unit.empty() ? "" : " " + unit](const std::string& text) -> std::string {
    const std::optional<double> value = ParseNumber(text);
    if (value && low <= *value && *value <= high) return "";
    return fmt::format("expected a number from {:g} to {:g}{}, found \"{}\"", low, high, space_and_unit, text);
  };
}

void TidyHelp(CLI::App* app) {
  constexpr std::size_t kColumns = 80;  // beside the names of options, which take 30
  for (CLI::Option* const option : app->get_options()) {
    option->description(Wrap(option->get_description(), 0, kColumns));
    try {
      for (int i = 0;; ++i) option->get_validator(i)->description("");
    } catch (const CLI::OptionNotFound&) {  // CLI11 does not say how many there are
    }
  }
}

void CheckWritable(const Output& output, const std::vector<std::string>& files) {
  if (!output.folder.empty()) CheckFolder(output.folder);
  if (!output.json.empty() && !output.JsonToStdout()) CheckFile(output.json);
  for (const std::string& file : files) {
    if (!file.empty()) CheckFile(file);
  }
}

void Emit(const Output& output, const std::string& text, const std::string& json) {
  if (!output.json.empty() && !output.JsonToStdout()) WriteFileWhole(output.json, json);
  if (output.JsonToStdout()) {
    std::cout << json;
  } else if (!output.quiet) {
    std::cout << text;
  }
  if (!std::cout.flush()) throw InputError("standard output", 0, "expected room for the result, found none");
}

void PrintNotices(const std::vector<std::string>& notices) {
  for (const std::string& notice : notices) fmt::print(stderr, "note: {}\n", notice);
}

void FigureWriter::Write(const std::string& name, const Figure& figure, bool with_data) {
  if (output_.folder.empty()) return;
  if (with_data) WriteText(name + ".csv", FormatFigureData(figure));
  try {
    WriteText(name + ".svg", RenderSvg(figure));
  } catch (const FigureError& error) {
    notices_.push_back(fmt::format("{}.svg is left out: {}", name, error.what()));
  }
}

void FigureWriter::WriteText(const std::string& name, const std::string& content) {
  if (output_.folder.empty()) return;
  const std::filesystem::path path = std::filesystem::path(output_.folder) / name;
  WriteFileWhole(path, content);
  files_.push_back(path.string());
}

namespace {
std::string command_line;
}

void KeepCommandLine(int argc, const char* const* argv) { command_line = QuoteCommand(argc, argv); }

void FigureWriter::WriteReport(const std::string& name, const std::function<std::string(const PageOrigin&)>& compose) {
  if (output_.folder.empty() || !output_.report) return;
  PageOrigin origin{.command = command_line,
                    .written = fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr))),
                    .files = {}};
  for (const std::string& file : files_) origin.files.push_back(fs::path(file).filename().string());
  WriteText(name, compose(origin));
}

std::string FigureWriter::Written() const {
  return files_.empty() ? "" : fmt::format("Written: {}\n", fmt::join(files_, " "));
}

namespace {
volatile std::sig_atomic_t interrupted = 0;
/// The second time it is meant as it is.
void OnSignal(int signal) {
  interrupted = 1;
  std::signal(signal, SIG_DFL);
}
}  // namespace

InterruptGuard::InterruptGuard() {
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::Interrupted() { return interrupted != 0; }

std::string FormatDuration(double s) {
  if (s < 60) return fmt::format("{:.0f} s", std::ceil(s));
  if (s < 3600) return fmt::format("{:.0f} min {:.0f} s", std::floor(s / 60), std::floor(std::fmod(s, 60)));
  return fmt::format("{:.0f} h {:.0f} min", std::floor(s / 3600), std::floor(std::fmod(s, 3600) / 60));
}

Progress::Progress(const Output& output)
    : shown_(!output.quiet && !output.JsonToStdout() && isatty(STDERR_FILENO) != 0) {}

void Progress::Show(const std::string& what) const {
  if (!shown_) return;
  fmt::print(stderr, "\r\033[K{} ", what);
  std::fflush(stderr);
}

void Progress::Clear() const {
  if (shown_) fmt::print(stderr, "\r\033[K");
}

}  // namespace uiclink
