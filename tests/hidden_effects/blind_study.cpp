// Blind study: the rig hides effects in records, `identify` is run on them as a user would, and only its JSON is looked
// at. How often is the hidden effect named?
//
// Short form (default): one case of each effect and a few others, with limits that such a number can show. Long form
// (--long or UICLINK_LONG=1): every figure that the diagnosis is held to, and confusion.md in the current folder.
//
//   blind_study                              short form
//   blind_study --long --jobs 2              long form
//   blind_study --case 17 --keep DIR         one case again; its records and identify's answer stay in DIR
//   blind_study --kind single --count 190 --effect clearance
// Exit codes: 0 within the limits; 1 not; 2 nothing could be done.

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli/program_run.h"
#include "tests/cli/temporary_folder.h"
#include "tests/hidden_effects/blind_cases.h"
#include "tests/hidden_effects/blind_score.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::uint64_t seed = 3;
  bool is_long = false;
  int jobs = 2;
  std::vector<int> cases;          ///< these alone
  std::vector<std::string> kinds;  ///< these alone; empty: all
  std::vector<std::string> effects;
  int first = 0;   ///< number of the first case within each kind
  int count = -1;  ///< of each kind; negative: as the form has it
  fs::path keep;
  fs::path identify = UICLINK_IDENTIFY;
};

/// How many cases of each kind, in the order of kCaseKinds. The long form's single effects are a multiple of the
/// catalogue's, as near to 480 as that gets from above.
std::vector<int> CountsOfForm(bool is_long) {
  const int effects = static_cast<int>(ObservableEffects().size());
  if (is_long) return {(480 + effects - 1) / effects * effects, 150, 48, 60, 45};
  return {effects, 6, 3, 3, 3};
}

std::vector<int> ChooseCases(const Options& options) {
  if (!options.cases.empty()) return options.cases;
  std::vector<int> chosen;
  const std::vector<int> counts = CountsOfForm(options.is_long);
  for (std::size_t kind = 0; kind < counts.size(); ++kind) {
    const std::string name(Name(kCaseKinds[kind]));
    if (!options.kinds.empty() && std::find(options.kinds.begin(), options.kinds.end(), name) == options.kinds.end())
      continue;
    const int count = options.count >= 0 ? options.count : counts[kind];
    for (int i = options.first; i < std::min(options.first + count, kCasesPerKind); ++i) {
      const int number = static_cast<int>(kind) * kCasesPerKind + i;
      const std::vector<std::string> hidden = DrawBlindCase(options.seed, number).effects;
      const bool wanted =
          options.effects.empty() || std::any_of(hidden.begin(), hidden.end(), [&](const auto& effect) {
            return std::find(options.effects.begin(), options.effects.end(), effect) != options.effects.end();
          });
      if (wanted) chosen.push_back(number);
    }
  }
  return chosen;
}

/// The options of `identify` that this version has.
std::vector<std::string> CommandOf(const Options& options) {
  const ProgramResult help = RunProgram({options.identify.string(), "--help"}, {.folder = "."});
  if (help.exit_code != 0) throw std::runtime_error(options.identify.string() + " cannot be run");
  std::vector<std::string> command{options.identify.string(), "--json", "-", "--quiet", "--threads", "1"};
  if (help.out.find("--no-wagon") != std::string::npos) command.emplace_back("--no-wagon");
  return command;
}

void KeepCase(const fs::path& from, const fs::path& to, const std::string& answer) {
  fs::create_directories(to);
  fs::copy(from, to, fs::copy_options::overwrite_existing | fs::copy_options::recursive);
  std::ofstream(to / "answer.json") << answer;
}

CaseResult RunCase(const Options& options, const std::vector<std::string>& command, int number) {
  CaseResult result;
  result.blind = DrawBlindCase(options.seed, number);
  const TemporaryFolder folder;
  WrittenCase written;
  try {
    written = WriteBlindCase(result.blind, folder.path());
  } catch (const std::exception& error) {
    result.fault = std::string("the rig: ") + error.what();
    return result;
  }
  std::vector<std::string> words = command;
  words.insert(words.end(), written.files.begin(), written.files.end());
  const auto begin = std::chrono::steady_clock::now();
  const ProgramResult run = RunProgram(words, {.folder = folder.path()});
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  result.exit_code = run.exit_code;
  if (run.exit_code > 1) {
    result.fault = fmt::format("identify ended with {}: {}", run.exit_code, run.err.substr(0, run.err.find('\n')));
  } else {
    ReadAnswer(run.out, written, &result);
  }
  if (!options.keep.empty()) KeepCase(folder.path(), options.keep / fmt::format("case_{}", number), run.out);
  return result;
}

/// Runs the cases on `jobs` threads, each of which waits for a process of its own; rows are printed as they come.
std::vector<CaseResult> RunCases(const Options& options, const std::vector<int>& cases) {
  const std::vector<std::string> command = CommandOf(options);
  std::vector<CaseResult> results(cases.size());
  std::atomic<std::size_t> next{0};
  std::mutex output;
  std::exception_ptr failure;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < cases.size(); i = next++) {
        results[i] = RunCase(options, command, cases[i]);
        const std::lock_guard lock(output);
        fmt::print("{}", FormatRow(results[i]));
        std::fflush(stdout);
      }
    } catch (...) {
      const std::lock_guard lock(output);
      failure = std::current_exception();
      next = cases.size();
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < options.jobs; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  if (failure) std::rethrow_exception(failure);
  return results;
}

/// Holds figures against limits and says which do not keep them.
class Limits {
 public:
  void AtLeast(const char* what, const Share& share, double percent) {
    if (share.all > 0 && share.Percent() < percent) Miss(what, share, "at least", percent);
  }
  void AtMost(const char* what, const Share& share, double percent) {
    if (share.all > 0 && share.Percent() > percent) Miss(what, share, "at most", percent);
  }
  void Require(bool holds, const std::string& what) {
    if (!holds) Say(what);
  }
  bool AreKept() const { return kept_; }

 private:
  void Miss(const char* what, const Share& share, const char* side, double percent) {
    Say(fmt::format("{}: expected {} {:g} %, found {:.1f} % ({} of {})", what, side, percent, share.Percent(),
                    share.right, share.all));
  }
  void Say(const std::string& text) {
    fmt::print("LIMIT MISSED: {}\n", text);
    kept_ = false;
  }
  bool kept_ = true;
};

/// The limits that the diagnosis is held to.
void CheckLong(const Summary& s, Limits* limits) {
  limits->AtLeast("single effects named, alone", s.alone, 90);
  limits->AtLeast("single effects named or among at most two rivals", s.named_or_rival, 97);
  limits->AtMost("false alarms on clean cases", s.false_alarms, 2);
  limits->AtLeast("pairs found", s.pairs_found, 80);
  limits->AtMost("out-of-catalogue cases called adequate", s.outside_adequate, 0);
  limits->AtMost("out-of-catalogue cases called explained", s.outside_explained, 10);
  for (std::size_t i = 0; i < 3; ++i) {
    const char* names[] = {"k inside the extended fit's bounds", "k1 inside the extended fit's bounds",
                           "T01 inside the extended fit's bounds"};
    limits->AtLeast(names[i], s.extended_inside[i], 90);
  }
}

/// What a handful of cases can show. Of n counted single effects at most one may be wrong: with 97 % right, two or more
/// of 12 are wrong in one study of 20, but the seed is fixed, so this either holds or shows a change.
void CheckShort(const Summary& s, Limits* limits) {
  limits->Require(s.named_or_rival.all - s.named_or_rival.right <= 1,
                  fmt::format("single effects: expected at most 1 neither named nor a rival, found {} of {}",
                              s.named_or_rival.all - s.named_or_rival.right, s.named_or_rival.all));
  limits->AtLeast("single effects named, alone", s.alone, 75);
  limits->AtMost("false alarms on clean cases", s.false_alarms, 0);
  limits->AtLeast("pairs found", s.pairs_found, 50);
  limits->AtMost("out-of-catalogue cases called adequate", s.outside_adequate, 0);
  limits->Require(s.outside_explained.right <= 1, "out-of-catalogue cases: more than 1 called explained");
}

int Study(const Options& options) {
  const std::vector<int> cases = ChooseCases(options);
  if (cases.empty()) throw std::runtime_error("no case fits these options");
  fmt::print("{}", FormatHeading());
  const auto begin = std::chrono::steady_clock::now();
  const std::vector<CaseResult> results = RunCases(options, cases);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const std::string study = FormatStudy(results);
  double longest = 0, sum = 0;
  for (const CaseResult& r : results) longest = std::max(longest, r.wall_s), sum += r.wall_s;
  fmt::print("\n{}\n{:.1f} s on {} processes; identify: {:.2f} s a case, at most {:.2f} s; study seed {}\n", study,
             wall_s, options.jobs, sum / static_cast<double>(results.size()), longest, options.seed);
  if (options.is_long) std::ofstream("confusion.md") << study;

  const Summary summary = Summarise(results);
  Limits limits;
  std::string fault;
  for (const CaseResult& r : results)
    if (!r.fault.empty() && fault.empty()) fault = fmt::format("; the first, case {}: {}", r.blind.number, r.fault);
  limits.Require(summary.faults == 0,
                 fmt::format("{} of {} cases could not be scored{}", summary.faults, results.size(), fault));
  const bool is_whole = options.cases.empty() && options.kinds.empty() && options.effects.empty() && options.count < 0;
  if (is_whole) {  // about half of the drawn sizes are that visible: far fewer would prove nothing
    const int least = CountsOfForm(options.is_long)[0] / 5;
    limits.Require(summary.alone.all >= least,
                   fmt::format("single effects: expected at least {} that count, found {}", least, summary.alone.all));
  }
  limits.AtMost("friction asymmetry named", summary.unobservable_named, 0);
  if (options.is_long) {
    CheckLong(summary, &limits);
  } else {
    CheckShort(summary, &limits);
  }
  return limits.AreKept() ? 0 : 1;
}

bool IsAskedLong() {
  const char* asked = std::getenv("UICLINK_LONG");
  return asked != nullptr && std::string(asked) == "1";
}

}  // namespace
}  // namespace uiclink

int main(int argc, char** argv) {
  constexpr int kNothingDone = 2;
  uiclink::Options options;
  options.is_long = uiclink::IsAskedLong();
  CLI::App app{"Hides effects in the rig's records and looks at what identify says.", "blind_study"};
  app.add_flag("--long", options.is_long, "the long form, and confusion.md");
  app.add_option("--seed", options.seed, "study seed")->capture_default_str();
  app.add_option("--jobs", options.jobs, "processes at a time")->check(CLI::Range(1, 64))->capture_default_str();
  app.add_option("--case", options.cases, "these cases alone (numbers of the first column)");
  std::vector<std::string> kinds;
  for (const uiclink::CaseKind kind : uiclink::kCaseKinds) kinds.emplace_back(uiclink::Name(kind));
  app.add_option("--kind", options.kinds, "these kinds alone")->check(CLI::IsMember(kinds));
  app.add_option("--effect", options.effects, "only cases that hide one of these");
  app.add_option("--first", options.first, "first case of each kind")->check(CLI::NonNegativeNumber);
  app.add_option("--count", options.count, "cases of each kind")->check(CLI::Range(0, uiclink::kCasesPerKind));
  app.add_option("--keep", options.keep, "folder for the records and answers of the cases that are run");
  app.add_option("--identify", options.identify, "program to test")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kNothingDone;
  }
  try {
    return uiclink::Study(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "blind_study: {}\n", error.what());
    return kNothingDone;
  }
}
