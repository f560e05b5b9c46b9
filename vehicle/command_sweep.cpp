// wagon sweep: all runs of a campaign, into one file.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "data/checksum.h"
#include "data/file.h"
#include "data/input_error.h"
#include "model/parallel.h"
#include "vehicle/commands.h"
#include "vehicle/page/sweep_page.h"
#include "vehicle/report_json.h"
#include "vehicle/sweep/mpi_team.h"
#include "vehicle/sweep/sweep.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string campaign;
  std::string store;
  std::string csv;
  bool list = false;
  bool status = false;
  bool restart = false;
  int threads = 0;  // 0: all cores; one for each process of mpirun
  Output output;
};

fs::path StorePath(const Arguments& arguments) {
  return arguments.store.empty() ? fs::path("out") / fs::path(arguments.campaign).stem().concat(".sqlite")
                                 : fs::path(arguments.store);
}

std::string Plural(std::size_t count, const std::string& what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

// --- before the runs -------------------------------------------------------------------------------------------------

std::string DescribeRun(const SweepPlan& plan, std::size_t run) {
  const std::vector<std::optional<AxisValue>> values = plan.Values(run);
  std::string text = fmt::format("{}  {}", run, plan.Id(run).substr(0, 12));
  for (const std::size_t axis : plan.ShownAxes()) {
    if (values[axis]) text += fmt::format("  {}={}", SweepAxes()[axis].name, FormatValue(*values[axis]));
  }
  if (plan.Sample(run)) text += fmt::format("  sample={}", *plan.Sample(run));
  return text;
}

int List(const Arguments& arguments, const SweepPlan& plan) {
  constexpr std::size_t kFirst = 10;
  const std::string store = StorePath(arguments).string();
  std::string text =
      fmt::format("{}: {}, kind {}\n", plan.campaign().name, Plural(plan.size(), "run"), plan.campaign().kind->name());
  Json json{{"schema", "wagon-sweep/1"}, {"campaign", plan.campaign().name}, {"runs", plan.size()}};
  for (std::size_t run = 0; run < std::min(plan.size(), kFirst); ++run) text += DescribeRun(plan, run) + "\n";
  if (plan.size() > kFirst) text += fmt::format("... {} more\n", plan.size() - kFirst);
  text += fmt::format("Store: {}{}\n", store, fs::exists(store) ? "" : " (not begun)");
  Emit(arguments.output, text, FormatJson(json));
  return kAllDone;
}

// --- after the runs --------------------------------------------------------------------------------------------------

std::string FormatCounts(const StoreCounts& counts, std::size_t planned) {
  std::string text = fmt::format("{} of {}: {} done", counts.total(), Plural(planned, "run"), counts[RunStatus::kDone]);
  for (const RunStatus status : {RunStatus::kWheelLift, RunStatus::kDerailed, RunStatus::kFailed}) {
    if (counts[status] > 0) text += fmt::format(", {} {}", counts[status], Name(status));
  }
  text += "\n";
  std::size_t shown = 0;
  for (const auto& [reason, runs] : counts.reasons) {
    if (++shown > 5) break;
    text += fmt::format("  failed {} times: {}\n", runs, reason);
  }
  if (counts.reasons.size() > 5) text += fmt::format("  {} more reasons in the store\n", counts.reasons.size() - 5);
  return text;
}

Json CountsToJson(const SweepPlan& plan, const StoreCounts& counts, const fs::path& store) {
  Json json{{"schema", "wagon-sweep/1"}, {"version", UICLINK_VERSION}, {"campaign", plan.campaign().name},
            {"store", store.string()},   {"runs", plan.size()},        {"rows", counts.total()}};
  for (int status = 0; status < kRunStatuses; ++status)
    json[Name(static_cast<RunStatus>(status))] = counts[static_cast<RunStatus>(status)];
  json["failures"] = counts.reasons;
  return json;
}

/// The page beside the store; its name with a blank before it.
std::string WriteReport(const Arguments& arguments, const SweepPlan& plan, const fs::path& store) {
  if (!arguments.output.report) return {};
  Output output = arguments.output;
  output.folder = store.has_parent_path() ? store.parent_path().string() : ".";
  const std::string name = store.stem().string() + "_report.html";
  FigureWriter files(output);
  files.WriteReport(
      name, [&](const PageOrigin& origin) { return ComposeSweepPage(plan, arguments.campaign, store, origin); });
  return " " + (fs::path(output.folder) / name).string();
}

/// Counts, CSV, exit code.
int Report(const Arguments& arguments, const SweepPlan& plan, const std::optional<SweepResult>& result) {
  const fs::path store = StorePath(arguments);
  const StoreCounts counts = SweepStore::Count(store);
  std::string text = FormatCounts(counts, plan.size());
  Json json = CountsToJson(plan, counts, store);
  if (result) {
    const double rate = result->wall_s > 0 ? static_cast<double>(result->done) / result->wall_s : 0;
    text +=
        fmt::format("{} in {:.1f} s here, {:.1f} runs a second\n", Plural(result->done, "run"), result->wall_s, rate);
    json["now"] = {{"runs", result->done},
                   {"wall_s", result->wall_s},
                   {"run_s", result->run_s},
                   {"lost_processes", result->lost_members},
                   {"interrupted", result->interrupted}};
  }
  std::string written = store.string();
  if (!arguments.csv.empty()) {
    WriteFileWhole(arguments.csv, SweepStore::FormatCsv(store));
    written += " " + arguments.csv;
  }
  if (counts.total() > 0) written += WriteReport(arguments, plan, store);
  Emit(arguments.output, text + "Written: " + written + "\n", FormatJson(json));
  if (result && result->interrupted) fmt::print(stderr, "wagon: interrupted; resume with the same command\n");
  if (result && result->lost_members > 0)
    fmt::print(stderr, "wagon: {} lost; the others did their runs\n", Plural(result->lost_members, "process"));
  return counts.total() < plan.size() || counts[RunStatus::kFailed] > 0 ? kSomeLeftOut : kAllDone;
}

// --- the runs --------------------------------------------------------------------------------------------------------

int RunRoot(const Arguments& arguments, const SweepPlan& plan, Team* team, SweepStore* store) {
  const std::size_t before = plan.size() - store->missing().size();
  const Progress progress(arguments.output);
  const auto show = [&](const SweepProgress& now) {
    progress.Show(fmt::format("{} of {} runs, {} left", before + now.done, plan.size(),
                              now.done > 0 ? FormatDuration(now.left_s) : "?"));
  };
  const SweepResult result = RunSweep(
      team, store, [] { return !InterruptGuard::Interrupted(); }, show);
  progress.Clear();
  return Report(arguments, plan, result);
}

std::unique_ptr<SweepStore> OpenStore(const Arguments& arguments, const SweepPlan& plan) {
  const fs::path path = StorePath(arguments);
  CheckWritable(arguments.output, {path.string(), arguments.csv});
  if (path.has_parent_path()) fs::create_directories(path.parent_path());
  const auto existing = arguments.restart ? SweepStore::Existing::kReplace : SweepStore::Existing::kGoOn;
  return std::make_unique<SweepStore>(path, plan, UICLINK_VERSION, existing);
}

int RunAlone(const Arguments& arguments) {
  const SweepPlan plan(ReadCampaign(arguments.campaign));
  if (arguments.list) return List(arguments, plan);
  PrintNotices(plan.notices());
  if (arguments.status) return Report(arguments, plan, {});
  const InterruptGuard guard;
  const std::unique_ptr<SweepStore> store = OpenStore(arguments, plan);
  LocalTeam team(plan, CountThreads(arguments.threads));
  return RunRoot(arguments, plan, &team, store.get());
}

/// All runs of a plan in one word.
std::string IdsOf(const SweepPlan& plan) {
  std::string ids;
  for (std::size_t run = 0; run < plan.size(); ++run) ids += plan.Id(run);
  return CalcSha256(ids);
}

int RunUnderMpi(const Arguments& arguments) {
  MpiSession mpi;
  const bool root = mpi.rank() == 0;
  std::unique_ptr<SweepPlan> plan;
  std::unique_ptr<SweepStore> store;
  std::exception_ptr fault;
  const InterruptGuard guard;
  try {  // a campaign that cannot be used is told once
    if (root) plan = std::make_unique<SweepPlan>(ReadCampaign(arguments.campaign));
    if (root && !arguments.list && !arguments.status) store = OpenStore(arguments, *plan);
  } catch (...) {
    fault = std::current_exception();
  }
  const bool go_on = mpi.Broadcast(store ? "runs" : "") == "runs";
  if (fault) std::rethrow_exception(fault);
  if (root && !store) return arguments.list ? List(arguments, *plan) : Report(arguments, *plan, {});
  if (!go_on) return kAllDone;
  const std::string text = mpi.Broadcast(root ? plan->campaign().text : "");
  try {
    if (!root) plan = std::make_unique<SweepPlan>(ParseCampaign(text, arguments.campaign));
  } catch (const std::exception&) {  // as a difference in ids
  }
  if (!mpi.SameEverywhere(plan ? IdsOf(*plan) : "")) {
    if (!root) return kNothingDone;
    throw UsageError("sweep: expected the same input files on all computers, found differences");
  }
  const int threads = arguments.threads > 0 ? arguments.threads : 1;
  if (!root) {
    mpi.Serve(*plan, threads);
    return kAllDone;
  }
  PrintNotices(plan->notices());
  const std::unique_ptr<Team> team = mpi.MakeTeam(*plan, threads);
  return RunRoot(arguments, *plan, team.get(), store.get());
}

}  // namespace

Command AddSweepCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app = program->add_subcommand("sweep", "all runs of a campaign, into one SQLite file");
  app->add_option("campaign", arguments->campaign, "the campaign (data/campaigns/README.md has the format)")
      ->type_name("CAMPAIGN.toml")
      ->required();
  app->add_option("--store", arguments->store, "the SQLite file (default: out/CAMPAIGN.sqlite)")->type_name("FILE");
  app->add_option("--csv", arguments->csv, "write all rows as CSV, too")->type_name("FILE");
  app->add_flag("--list", arguments->list, "how many runs, and the first of them; does none");
  app->add_flag("--status", arguments->status,
                "how far the store is, also while another process is at work; does no run, writes the --csv");
  app->add_flag("--restart", arguments->restart, "throw the runs of the store away and begin anew");
  app->add_option("--threads", arguments->threads, "of this process (default: all cores; under mpirun 1 a process)")
      ->type_name("N")
      ->check(CheckBetween(1, 1024, ""));
  app->add_option("--json", arguments->output.json, "write the counts as JSON to FILE; - for standard output")
      ->type_name("FILE");
  app->add_flag("--quiet,-q", arguments->output.quiet, "no table on standard output");
  AddReportOption(app, &arguments->output);
  app->footer(
      "Examples:\n"
      "  wagon sweep data/campaigns/speeds.toml --list\n"
      "  wagon sweep data/campaigns/speeds.toml --csv speeds.csv\n"
      "  mpirun -n 8 wagon sweep data/campaigns/speeds.toml     # --enable-recovery: goes on when a process dies\n"
      "  sqlite3 out/speeds.sqlite \"SELECT cargo, speed, amplitude_front_lateral_mm FROM runs ORDER BY 1, 2\"\n\n"
      "Killed or interrupted at any moment, the same command goes on where it was; more values in the campaign are\n"
      "more runs. A process that dies costs its runs in hand, four on each core (kind simulate). A run that failed is "
      "a\n"
      "row with its reason, and the exit code is 1.");
  return {app, [arguments] { return StartedByMpi() ? RunUnderMpi(*arguments) : RunAlone(*arguments); }};
}

}  // namespace uiclink
