#pragma once

#include <functional>
#include <string>
#include <vector>

#include "reports/figure.h"
#include "vehicle/page/wagon_book.h"
#include "vehicle/wagon_inputs.h"

namespace CLI {
class App;
}

namespace uiclink {

// Exit codes of both programs.
inline constexpr int kAllDone = 0;      ///< all done
inline constexpr int kSomeLeftOut = 1;  ///< done, but something was left out or is not trustworthy
inline constexpr int kNothingDone = 2;  ///< nothing could be done

/// A command of the program `wagon`: what CLI11 knows of it, and what it does once its options are parsed. A new
/// command is a file with such a function, a line below, and one in Commands() of main.cpp.
struct Command {
  CLI::App* app = nullptr;
  std::function<int()> run;  ///< gives the exit code
};

Command AddSimulateCommand(CLI::App* program);
Command AddStabilityCommand(CLI::App* program);
Command AddBifurcationCommand(CLI::App* program);
Command AddSpectrumCommand(CLI::App* program);
Command AddContactCommand(CLI::App* program);
Command AddInertiaCommand(CLI::App* program);
Command AddElementCommand(CLI::App* program);
Command AddSweepCommand(CLI::App* program);
Command AddReproduceCommand(CLI::App* program);

// Speeds that options take [m/s]: creepages grow without bound towards zero, and no track has the highest.
inline constexpr double kLowestSpeed = 0.01;
inline constexpr double kHighestSpeed = 300;

/// Where results go.
struct Output {
  std::string folder;  ///< of files; empty: none are written
  std::string json;    ///< file for the JSON; "-": standard output, alone there; empty: none
  bool quiet = false;  ///< no tables on standard output
  bool report = true;  ///< a page beside the files

  bool JsonToStdout() const { return json == "-"; }
};

/// --out, --json, --quiet, --no-report. @param folder  the default of --out, for help; empty: the command only writes
/// where asked.
void AddOutputOptions(CLI::App* app, Output* output, const std::string& folder);
void AddReportOption(CLI::App* app, Output* output);  ///< --no-report alone

// What kind of wagon: parts of WagonChoice as options.
void AddBodyOptions(CLI::App* app, WagonChoice* choice);     ///< --wagon, --cargo, --com, --partitions
void AddContactOptions(CLI::App* app, WagonChoice* choice);  ///< --geometry, --contact-table
/// All of them: these, --set, --suspension, --no-guidance, --penetration, --friction, --roll.
void AddWagonOptions(CLI::App* app, WagonChoice* choice);

/// The rule for a number within bounds, both included, for CLI::Option::check: why `text` is no such number; empty if
/// it is one. Beyond the bounds the model has no meaning, or a run no end.
std::function<std::string(const std::string&)> CheckBetween(double low, double high, const std::string& unit);

/// Lines of help of at most 110 columns, and no rules beside the types: CLI11 itself breaks no line.
void TidyHelp(CLI::App* app);

/// Before a long computation rather than after it: that its files can be written.
/// @param files  further ones, beside the folder and the JSON; empty names are skipped.
/// @throws InputError for the first that cannot.
void CheckWritable(const Output& output, const std::vector<std::string>& files = {});

/// JSON, then the table, to where the user wants them. @throws InputError where they cannot be written.
void Emit(const Output& output, const std::string& text, const std::string& json);

/// Notices go to standard error, so that they are seen with --quiet and --json -.
void PrintNotices(const std::vector<std::string>& notices);

/// What was typed, for reports; Main says so before a command runs.
void KeepCommandLine(int argc, const char* const* argv);

/// Writes figures and says what was written.
class FigureWriter {
 public:
  explicit FigureWriter(const Output& output) : output_(output) {}
  /// folder/name.svg and, if `with_data`, folder/name.csv with every point. Nothing without a folder. Where gnuplot is
  /// missing the picture is left out, with a notice.
  void Write(const std::string& name, const Figure& figure, bool with_data);
  /// Another file of the folder, whole or not at all.
  void WriteText(const std::string& name, const std::string& content);

  /// The report of a command: folder/name, with links to the files that were written before. Nothing with --no-report.
  void WriteReport(const std::string& name, const std::function<std::string(const PageOrigin&)>& compose);

  /// "Written: out/histories.csv out/histories.svg\n"; empty if nothing was.
  std::string Written() const;
  bool complete() const { return notices_.empty(); }  ///< every picture was drawn
  const std::vector<std::string>& notices() const { return notices_; }

 private:
  Output output_;
  std::vector<std::string> files_;
  std::vector<std::string> notices_;
};

/// While it lives, Ctrl-C and a polite kill end what is being computed, not the program.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool Interrupted();
};

/// "37 s", "2 min 5 s", "1 h 3 min".
std::string FormatDuration(double s);

/// Progress for a person at a terminal, on standard error; silent otherwise.
class Progress {
 public:
  explicit Progress(const Output& output);
  ~Progress() { Clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void Show(const std::string& what) const;
  void Clear() const;
  bool shown() const { return shown_; }

 private:
  bool shown_;
};

}  // namespace uiclink
