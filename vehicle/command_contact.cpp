// wagon contact: the contact of wheels and rails over the lateral displacement, as a table, in figures and as conicity.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "vehicle/commands.h"
#include "vehicle/contact_report.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  WagonChoice choice;
  Output output;
};

/// Files of the results: those of a folder, or a table of the user's name with the figures beside it.
struct Names {
  std::string folder;
  std::string table = "contact_table.txt";
  std::string prefix = "contact_";
};

/// --out FILE is the table; a folder, or a name without an extension, is where all files go.
Names ChooseNames(const std::string& out) {
  const fs::path path(out);
  std::error_code ignored;
  if (out.empty() || !path.has_extension() || fs::is_directory(path, ignored)) return {.folder = out};
  const std::string folder = path.parent_path().string();
  return {
      .folder = folder.empty() ? "." : folder, .table = path.filename().string(), .prefix = path.stem().string() + "_"};
}

int RunContact(const Arguments& arguments) {
  WagonInputs inputs;
  inputs.choice = arguments.choice;
  ReadWagonContact(arguments.choice, &inputs);
  PrintNotices(inputs.notices);
  const ContactAnalysis analysis = AnalyseContact(inputs);
  const std::string json = FormatContactJson(inputs, analysis);
  const Names names = ChooseNames(arguments.output.folder);
  Output output = arguments.output;
  output.folder = names.folder;
  FigureWriter files(output);
  files.WriteText(names.table, FormatContactTable(inputs.table));
  files.Write(names.prefix + "quantities", ContactTableFigure(inputs), false);
  files.Write(names.prefix + "conicity", ConicityFigure(inputs, analysis), true);
  files.WriteText(names.prefix + "result.json", json);
  files.WriteReport(names.prefix + "report.html", [&](const PageOrigin& origin) {
    return ComposeContactPage(inputs, analysis, names.prefix, origin);
  });
  PrintNotices(files.notices());
  Emit(arguments.output, FormatContact(inputs, analysis) + files.Written(), json);
  return files.complete() ? kAllDone : kSomeLeftOut;
}

}  // namespace

Command AddContactCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app =
      program->add_subcommand("contact", "contact of wheels and rails: table, conicity, jumps, figures");
  AddOutputOptions(app, &arguments->output, "");
  app->get_option("--out")
      ->description(
          "write the contact table to FILE and figures beside it, or all to the folder DIR (default: nothing is "
          "written)")
      ->type_name("FILE|DIR");
  AddContactOptions(app, &arguments->choice);
  app->footer(
      "Examples:\n"
      "  wagon contact\n"
      "  wagon contact --geometry thesis-equivalent --out table.txt      # --contact-table table.txt puts it back\n"
      "  wagon contact --out out --json - | jq '.conicity[] | select(.amplitude == 0.003)'");
  return {app, [arguments] { return RunContact(*arguments); }};
}

}  // namespace uiclink
