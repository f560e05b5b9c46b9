// wagon reproduce: chapter 10 of the thesis, ours beside theirs.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "data/file.h"
#include "vehicle/commands.h"
#include "vehicle/reproduce/pages.h"

namespace uiclink {
namespace {

namespace rp = reproduce;

struct Arguments {
  rp::ReproduceOptions options;
  bool rigid = false;
  bool list = false;
  Output output;
};

std::string FormatList(const rp::ReproduceOptions& options) {
  std::string text;
  for (const rp::Item* item : rp::SelectItems(options)) {
    text += fmt::format("{:<8} {:<20} {}{}\n", item->section, item->id, item->title,
                        item->covers.empty() ? "" : fmt::format(" ({})", fmt::join(item->covers, ", ")));
  }
  return text;
}

void AddRigid(std::vector<std::string>* geometries) {
  const std::vector<std::string> elastic = *geometries;
  for (const std::string& geometry : elastic)
    if (!geometry.ends_with("-rigid")) geometries->push_back(geometry + "-rigid");
}

std::string ProgressWords(const rp::ReproduceProgress& now) {
  constexpr std::size_t kShown = 2;
  std::string running;
  for (std::size_t i = 0; i < std::min(now.running.size(), kShown); ++i)
    running += (i > 0 ? ", " : "") + now.running[i];
  if (now.running.size() > kShown) running += ", ...";
  return fmt::format("{} of {}, {} left: {}", now.done, now.total, now.left_s > 0 ? FormatDuration(now.left_s) : "?",
                     running);
}

bool Failed(const rp::Reproduction& reproduction) {
  return std::ranges::any_of(reproduction.results,
                             [](const auto& entry) { return !entry.second.failure.empty() || !entry.second.drawn; });
}

int RunReproduce(const Arguments& arguments) {
  rp::ReproduceOptions options = arguments.options;
  if (arguments.list) {
    Emit(arguments.output, FormatList(options), "");
    return kAllDone;
  }
  rp::SelectItems(options);  // names that there are not, before anything is computed
  if (arguments.rigid) AddRigid(&options.geometries);
  options.folder = arguments.output.folder;
  CheckWritable(arguments.output);
  const InterruptGuard guard;
  const Progress progress(arguments.output);
  options.go_on = [] { return !InterruptGuard::Interrupted(); };
  if (progress.shown()) options.on_progress = [&](const auto& now) { progress.Show(ProgressWords(now)); };
  const rp::Reproduction reproduction = rp::Reproduce(options);
  progress.Clear();

  FigureWriter files(arguments.output);
  for (const auto& [name, page] : rp::FormatPages(reproduction)) files.WriteText(name, page);
  const std::string json = rp::FormatReproductionJson(reproduction);
  files.WriteText("reproduce.json", json);
  Emit(arguments.output, rp::FormatReproduction(reproduction) + files.Written(), json);
  if (reproduction.interrupted) fmt::print(stderr, "wagon: interrupted; go on with the same command\n");
  return reproduction.interrupted || Failed(reproduction) ? kSomeLeftOut : kAllDone;
}

}  // namespace

Command AddReproduceCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app =
      program->add_subcommand("reproduce", "chapter 10 of the thesis: every table and figure, ours beside theirs");
  rp::ReproduceOptions& options = arguments->options;
  app->add_option("--only", options.only, "items, by id, figure or table: fig-10.1a, 10.9; repeatable")
      ->type_name("ID");
  app->add_option("--section", options.sections, "sections: 10.2.1; repeatable")->type_name("NUMBER");
  app->add_option("--geometry", options.geometries, "wheels on rails, the columns of the pages")
      ->type_name("NAME|FILE")
      ->capture_default_str();
  app->add_flag("--rigid", arguments->rigid, "the -rigid variant of each geometry beside it");
  app->add_flag("--quick", options.quick, "cut runs short and follow no branches: to look at the pages, no results");
  app->add_flag("--again", options.again, "compute what is there already");
  app->add_flag("--list", arguments->list, "say which items there are");
  app->add_option("--threads", options.threads, "0: all cores")
      ->type_name("N")
      ->check(CheckBetween(0, 1024, ""))
      ->capture_default_str();
  AddOutputOptions(app, &arguments->output, "out/reproduce");
  app->footer(
      "Examples:\n"
      "  wagon reproduce\n"
      "  wagon reproduce --section 10.4 --geometry thesis-equivalent --rigid\n"
      "  wagon reproduce --only 10.25 --json - --quiet | jq '.items[].rows[] | {what, theirs, ours}'\n\n"
      "Writes index.html, a page for each section, reproduce.json, and results/GEOMETRY/ID.json as items finish: a "
      "run\n"
      "that is stopped or killed goes on with the same command. Exit code 1 when it was interrupted, or an item "
      "failed.");
  return {app, [arguments] { return RunReproduce(*arguments); }};
}

}  // namespace uiclink
