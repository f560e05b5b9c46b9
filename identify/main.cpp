// The program `identify`: records in, parameters out.

#include <fmt/core.h>
#include <glog/logging.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "data/data_path.h"
#include "data/file.h"
#include "data/input_error.h"
#include "data/parameter_set_file.h"
#include "identify/command_line.h"
#include "identify/commands.h"
#include "identify/compare.h"
#include "identify/diagnosis.h"
#include "identify/effects_report.h"
#include "identify/identification.h"
#include "identify/page/report_page.h"
#include "identify/record.h"
#include "identify/report.h"
#include "identify/report_wagon.h"
#include "identify/thinning.h"
#include "identify/validate.h"

namespace uiclink {
namespace {

// Exit codes of DESIGN: 0 all done; 1 done, but something was left out or is not trustworthy; 2 nothing could be done.
constexpr int kAllDone = 0;
constexpr int kSomeLeftOut = 1;
constexpr int kNothingDone = 2;

struct Arguments {
  std::vector<std::string> records;
  std::vector<std::string> sets;
  std::string out = "out";
  std::string json;
  bool quiet = false;
  bool no_diagnosis = false;
  bool no_wagon = false;
  bool no_report = false;
  bool wagon = false;  // compare
  std::string direction;
  std::string sliders;
  std::optional<double> cutoff_mm;
  ReadOptions read;
  IdentifyOptions identify;
  ValidateOptions validate;
  Provenance provenance;  // of the report

  bool JsonToStdout() const { return json == "-"; }
};

void AddReadOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--direction", arguments->direction, "direction of all records, where files do not say it")
      ->check(CLI::IsMember({"lateral", "longitudinal"}));
  app->add_option("--mass", arguments->read.mass_kg, "mass on the link [kg] (default: the record's header, or 378.2)")
      ->check(CLI::PositiveNumber);
  app->add_option("--g", arguments->read.g, "acceleration of gravity [m/s^2] (default: the record's header, or 9.82)")
      ->check(CLI::PositiveNumber);
  app->add_option("--rate", arguments->read.rate_hz, "sampling rate [Hz] of records without a time column")
      ->check(CLI::PositiveNumber);
  app->add_option("--column", arguments->read.column, "column of the displacement, 1 = first (default: after time)")
      ->check(CLI::PositiveNumber);
  app->add_option("--unit", arguments->read.displacement_unit, "unit of the displacement: " + DisplacementUnits());
}

/// @param runs  there is a wagon unless --no-wagon says otherwise; else there is none unless --wagon does.
void AddValidateOptions(CLI::App* app, bool runs, Arguments* arguments) {
  const auto is_file_of = [](const char* subfolder) {
    return [subfolder](const std::string& text) -> std::string {
      try {
        FindDataFile(subfolder, text);
        return {};
      } catch (const InputError& error) {
        return error.what();
      }
    };
  };
  const auto is_speed = [](const std::string& text) -> std::string {  // CLI::Range lets "nan" pass
    double speed = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), speed);
    return error == std::errc() && end == text.data() + text.size() && speed >= 1 && speed <= 100
               ? ""
               : "expected a number from 1 to 100 m/s, found \"" + text + '"';
  };
  CLI::Option* const flag =
      runs ? app->add_flag("--no-wagon", arguments->no_wagon, "do not run the wagon on the identified links")
           : app->add_flag("--wagon", arguments->wagon, "put the sets on the wagon as well");
  const auto only_with_wagon = [&](CLI::Option* option) { runs ? option->excludes(flag) : option->needs(flag); };
  CLI::Option* const cargo =
      app->add_option("--cargo", arguments->validate.cargo, "the wagon's freight: a name or a file")
          ->type_name("NAME|FILE")
          ->check(is_file_of("freight"), "")
          ->capture_default_str();
  CLI::Option* const geometry =
      app->add_option("--geometry", arguments->validate.geometry, "its wheels on their rails: a name or a file")
          ->type_name("NAME|FILE")
          ->check(is_file_of("geometry"), "")
          ->capture_default_str();
  CLI::Option* const speed =
      app->add_option("--wagon-speed", arguments->validate.speed, "speed of its hunting run [m/s]")
          ->type_name("V")
          ->check(is_speed, "")
          ->capture_default_str();
  CLI::Option* const draws =
      app->add_option("--draws", arguments->validate.hunting_draws,
                      "sets drawn from the covariance of a set, for 95 % bounds of its hunting; 0: none. Those of the "
                      "critical speed need none")
          ->type_name("N")
          ->check(CLI::Range(0, 100000), "")
          ->capture_default_str();
  for (CLI::Option* const option : {cargo, geometry, speed, draws}) only_with_wagon(option);
}

void AddOutputOptions(CLI::App* app, Arguments* arguments) {
  app->add_option("--json", arguments->json, "write the result as JSON to FILE; - for standard output, alone there")
      ->type_name("FILE");
  app->add_flag("--quiet,-q", arguments->quiet, "no tables on standard output");
}

/// Progress for a person at a terminal; silent otherwise.
class Progress {
 public:
  explicit Progress(bool quiet) : shown_(!quiet && isatty(STDERR_FILENO) != 0) {}
  void operator()(const std::string& what, int done, int of) const {
    if (!shown_) return;
    fmt::print(stderr, "\r{} {}/{} ", what, done, of);
    if (done >= of) Clear();
    std::fflush(stderr);
  }
  void Clear() const {
    if (shown_) fmt::print(stderr, "\r\033[K");
  }

 private:
  bool shown_;
};

/// Reads what can be read; the others are named and left out.
std::vector<Record> ReadRecords(const Arguments& arguments, std::vector<Rejected>* rejected) {
  std::vector<Record> records;
  std::set<std::filesystem::path> seen;
  for (const std::string& file : arguments.records) {
    try {
      // Counted twice, a record would make the bounds narrower than they are.
      std::error_code none;
      const std::filesystem::path canonical = std::filesystem::weakly_canonical(file, none);
      if (!none && !seen.insert(canonical).second)
        throw InputError(file, 0, "expected every record once, found it a second time");
      Record record = ReadRecord(file, arguments.read);
      if (!record.direction)
        throw InputError(file, 0,
                         "expected a direction (header \"# direction: lateral\", a file name with lateral or "
                         "longitudinal, or --direction), found none");
      ThinRecord(&record);
      records.push_back(std::move(record));
    } catch (const InputError& error) {
      rejected->push_back({file, error.what()});
    }
  }
  return records;
}

int CountLeftOut(const RunResult& run) {
  int left_out = static_cast<int>(run.rejected.size());
  for (const Identification& id : run.directions) left_out += static_cast<int>(id.records.size()) - id.CountUsed();
  return left_out;
}

bool AnyUsed(const RunResult& run) {
  for (const Identification& id : run.directions)
    if (id.CountUsed() > 0) return true;
  return false;
}

/// Messages about what was left out go to standard error as well, so that they are seen with --quiet and --json -.
void PrintLeftOut(const RunResult& run) {
  for (const Rejected& rejected : run.rejected) fmt::print(stderr, "{}\n", rejected.message);
  for (const Identification& id : run.directions)
    for (const RecordResult& record : id.records)
      if (!record.used) fmt::print(stderr, "{}: {}\n", record.record.file, record.reason);
}

void PrintNotices(const RunResult& run) {
  for (const Identification& id : run.directions)
    for (const RecordResult& record : id.records)
      for (const std::string& notice : record.record.notices)
        fmt::print(stderr, "{}: note: {}\n", record.record.file, notice);
}

void PrintNothingDone(std::size_t records) {
  if (records == 1) {
    fmt::print(stderr, "identify: the record cannot be used\n");
  } else {
    fmt::print(stderr, "identify: none of the {} records can be used\n", records);
  }
}

void Emit(const Arguments& arguments, const std::string& text, const std::string& json) {
  if (!arguments.json.empty() && !arguments.JsonToStdout()) WriteFileWhole(arguments.json, json);
  if (arguments.JsonToStdout()) {
    std::cout << json;
  } else if (!arguments.quiet) {
    std::cout << text;
  }
  if (!std::cout.flush()) throw InputError("standard output", 0, "expected room for the result, found none");
}

/// Writes what the wagon reads, and gives it: the identified set, and the plain model's where causes were named. A
/// plain set of an earlier run would be taken for this run's.
std::vector<ValidationSet> WriteSets(const RunResult& run, const std::filesystem::path& out) {
  std::vector<ValidationSet> sets{MakeValidationSet(run, /*with_causes=*/true, (out / "parameters.toml").string())};
  const std::filesystem::path plain = out / "parameters_plain.toml";
  WriteParameterSet(sets.front().set, sets.front().file);
  if (HasCauses(run)) {
    sets.push_back(MakeValidationSet(run, /*with_causes=*/false, plain.string()));
    WriteParameterSet(sets.back().set, plain);
  } else {
    std::error_code none;
    std::filesystem::remove(plain, none);
  }
  return sets;
}

/// The identified sets on the wagon. What fails there is said, and takes nothing else down.
Validation Validate(const std::vector<ValidationSet>& sets, const Arguments& arguments, const Progress& progress) {
  ValidateOptions options = arguments.validate;
  options.threads = arguments.identify.threads;
  options.progress = progress;
  Validation validation = ValidateOnWagon(sets, options);
  progress.Clear();
  for (const std::string& line : FormatWagonFailures(validation)) fmt::print(stderr, "{}\n", line);
  return validation;
}

/// The report and its figures. @returns what to say about them at the end.
std::string WriteReport(const RunResult& run, std::span<const ValidationSet> sets,
                        std::span<const ReadingResiduals> residuals, const Arguments& arguments) {
  const std::string missing = WriteReportPage({.run = &run,
                                               .sets = sets,
                                               .residuals = residuals,
                                               .provenance = &arguments.provenance,
                                               .threads = arguments.identify.threads},
                                              arguments.out);
  if (!missing.empty()) fmt::print(stderr, "report: no pictures beside it: {}\n", missing);
  return "Report: " + arguments.out + "/report.html\n";
}

int RunIdentify(Arguments arguments) {
  const Progress progress(arguments.quiet || arguments.JsonToStdout());
  arguments.identify.progress = progress;
  if (arguments.cutoff_mm) arguments.identify.sine.cutoff = 1e-3 * *arguments.cutoff_mm;
  arguments.identify.sliders = arguments.sliders == "auto" ? kAutoSliders
                               : arguments.sliders.empty() ? 0
                                                           : std::stoi(arguments.sliders);
  RunResult run;
  std::vector<Record> records = ReadRecords(arguments, &run.rejected);
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
    std::vector<Record> of_direction;
    for (Record& record : records)
      if (record.direction == direction) of_direction.push_back(std::move(record));
    if (!of_direction.empty())
      run.directions.push_back(Identify(direction, std::move(of_direction), arguments.identify));
  }
  if (!arguments.no_diagnosis)
    for (const Identification& id : run.directions)
      run.diagnoses.push_back(id.CountUsed() > 0
                                  ? Diagnose(id, {.threads = arguments.identify.threads, .progress = progress})
                                  : Diagnosis{});
  progress.Clear();
  PrintLeftOut(run);
  if (!AnyUsed(run)) {
    PrintNothingDone(arguments.records.size());
    return kNothingDone;
  }
  PrintNotices(run);
  const std::vector<std::string> warnings = FormatDiagnosisWarnings(run);
  for (const std::string& warning : warnings) fmt::print(stderr, "{}\n", warning);
  const std::filesystem::path out(arguments.out);
  const std::vector<ValidationSet> sets = WriteSets(run, out);
  if (!arguments.no_wagon) run.wagon = Validate(sets, arguments, progress);
  const std::string json = FormatJson(run);
  WriteFileWhole(out / "result.json", json);
  const std::vector<ReadingResiduals> residuals = CalcReadingResiduals(run);
  WriteFileWhole(out / "residuals.csv", FormatResiduals(run, residuals));
  const std::string report = arguments.no_report ? "" : WriteReport(run, sets, residuals, arguments);
  Emit(arguments,
       FormatReport(run) + (run.wagon ? FormatWagon(*run.wagon) : "") +
           fmt::format("Written: {0}/parameters.toml {1}{0}/result.json {0}/residuals.csv\n{2}", arguments.out,
                       HasCauses(run) ? arguments.out + "/parameters_plain.toml " : "", report),
       json);
  bool trustworthy = warnings.empty() && (!run.wagon || run.wagon->Complete());
  for (const Identification& id : run.directions) trustworthy &= id.warnings.empty();
  return CountLeftOut(run) == 0 && trustworthy ? kAllDone : kSomeLeftOut;
}

int RunCompare(const Arguments& arguments) {
  std::vector<ParameterSet> sets;
  for (const std::string& file : arguments.sets) sets.push_back(ReadParameterSet(file));
  std::vector<Rejected> rejected;
  std::vector<Record> records = ReadRecords(arguments, &rejected);
  CompareResult result = Compare(arguments.sets, sets, std::move(records));
  result.rejected = std::move(rejected);
  for (const std::string& line : FormatLeftOut(result)) fmt::print(stderr, "{}\n", line);
  if (!arguments.records.empty() && result.CountUsed() == 0) {
    PrintNothingDone(arguments.records.size());
    return kNothingDone;
  }
  for (const std::string& notice : result.notices) fmt::print(stderr, "{}\n", notice);
  if (arguments.wagon) {
    Arguments with_options = arguments;
    with_options.validate.side_by_side = true;
    result.wagon =
        Validate(MakeComparedSets(result, sets), with_options, Progress(arguments.quiet || arguments.JsonToStdout()));
  }
  Emit(arguments, FormatComparison(result), FormatComparisonJson(result));
  return result.CountLeftOut() == 0 && (!result.wagon || result.wagon->Complete()) ? kAllDone : kSomeLeftOut;
}

int RunEffects(const Arguments& arguments) {
  Emit(arguments, FormatEffects(Effects()), FormatEffectsJson(Effects()));
  return kAllDone;
}

int Main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app{"identify: parameters of a UIC link suspension from its ring-down records"};
  app.set_version_flag("--version", std::string("identify ") + UICLINK_VERSION + " (uiclink)");
  app.footer(
      "Examples:\n"
      "  identify measurements/lateral_*.txt\n"
      "  identify --json - decay.csv --direction lateral --rate 200\n"
      "  identify compare data/parameter_sets/set1.toml out/parameters.toml --records measurements/lateral_*.txt\n"
      "  identify effects\n\n"
      "Exit codes: 0 all done; 1 done, but something was left out or is not trustworthy; 2 nothing could be done.");
  app.add_option("records", arguments.records, "records: text (time [s], displacement [mm]) or MATLAB files");
  app.add_option("--out", arguments.out, "folder of the results")->capture_default_str();
  AddOutputOptions(&app, &arguments);
  AddReadOptions(&app, &arguments);
  app.add_option("--sliders", arguments.sliders,
                 "sliders of the model: 1 to 4, or auto (default: 1 lateral, 4 longitudinal)")
      ->check(CLI::IsMember({"1", "2", "3", "4", "auto"}));
  app.add_option("--cutoff", arguments.cutoff_mm, "cut-off amplitude of the frequency method [mm] (default: chosen)")
      ->check(CLI::PositiveNumber);
  app.add_option("--starts", arguments.identify.starts.count, "fits from scattered starts, as a check")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  app.add_option("--seed", arguments.identify.starts.seed, "seed of the scattered starts")->capture_default_str();
  app.add_flag("--no-diagnosis", arguments.no_diagnosis, "fit the plain model only; do not ask what it lacks");
  app.add_flag("--no-report", arguments.no_report, "do not write the report (report.html, figures/)");
  AddValidateOptions(&app, /*runs=*/true, &arguments);
  app.add_option("--threads", arguments.identify.threads, "threads; 0: all of the machine")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);

  CLI::App* compare = app.add_subcommand("compare", "parameter sets side by side, on records and on the wagon");
  compare->add_option("sets", arguments.sets, "parameter-set files (TOML)")->required();
  compare->add_option("--records", arguments.records, "records to compare them on")->expected(1, -1);
  AddValidateOptions(compare, /*runs=*/false, &arguments);
  AddOutputOptions(compare, &arguments);
  AddReadOptions(compare, &arguments);
  compare->add_option("--threads", arguments.identify.threads, "threads; 0: all of the machine")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  compare->footer(
      "Examples:\n"
      "  identify compare data/parameter_sets/set1.toml out/parameters.toml --records measurements/lateral_*.txt\n"
      "  identify compare data/parameter_sets/set1.toml data/parameter_sets/set2.toml out/parameters_plain.toml \\\n"
      "    out/parameters.toml --wagon --geometry thesis-equivalent --wagon-speed 30");

  CLI::App* effects = app.add_subcommand("effects", "what the plain model may lack: the catalogue of effects");
  effects->footer(
      "Examples:\n"
      "  identify effects | less\n"
      "  identify effects --json - | jq '.effects[].id'");
  AddOutputOptions(effects, &arguments);
  const std::vector<Command> commands{AddDigitiseCommand(&app), AddTrackCommand(&app)};

  try {
    app.parse(argc, argv);
    if (!arguments.direction.empty())
      arguments.read.direction = arguments.direction == "lateral" ? Direction::kLateral : Direction::kLongitudinal;
    if (compare->parsed()) return RunCompare(arguments);
    if (effects->parsed()) return RunEffects(arguments);
    for (const Command& command : commands)
      if (command.app->parsed()) return command.run();
    if (arguments.records.empty()) throw CLI::RequiredError("records");
    if (!arguments.no_report) arguments.provenance = DescribeCommandLine(argc, argv, app, arguments.records);
    return RunIdentify(arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kAllDone : kNothingDone;
  } catch (const InputError& error) {  // an unreadable set, a folder that cannot be written
    fmt::print(stderr, "{}\n", error.what());
    return kNothingDone;
  } catch (const std::exception& error) {
    fmt::print(stderr, "identify: {}\n", error.what());
    return kNothingDone;
  }
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres' log lines are not for users
  return uiclink::Main(argc, argv);
}
