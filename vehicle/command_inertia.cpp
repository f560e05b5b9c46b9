// wagon inertia: mass, centre of mass and moments of inertia, part by part and for each freight.

#include <CLI/CLI.hpp>
#include <memory>

#include "vehicle/commands.h"
#include "vehicle/inertia_report.h"
#include "vehicle/page/pages.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  std::vector<std::string> cargoes{"empty", "water", "gold", "packed"};
  Output output;
};

int RunInertia(const Arguments& arguments) {
  WagonInputs inputs;
  inputs.choice = arguments.choice;
  ReadWagonFile(arguments.choice, &inputs);
  std::vector<Freight> freights;
  for (const std::string& cargo : arguments.cargoes) {
    WagonChoice choice = arguments.choice;
    choice.cargo = cargo;
    ReadCargo(choice, &inputs);
    freights.push_back(inputs.freight);
  }
  inputs.body = {};  // there is one for each freight, in the result itself
  PrintNotices(inputs.notices);
  const std::string json = FormatInertiaJson(inputs, freights);
  FigureWriter files(arguments.output);
  files.WriteText("inertia.json", json);
  files.WriteReport("inertia_report.html",
                    [&](const PageOrigin& origin) { return ComposeInertiaPage(inputs, freights, origin); });
  Emit(arguments.output, FormatInertiaReport(inputs.data, freights, inputs.choice.inertia) + files.Written(), json);
  return kAllDone;
}

}  // namespace

Command AddInertiaCommand(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* const app = program->add_subcommand(
      "inertia", "mass, centre of mass and inertia of the body, part by part, for each freight");
  AddOutputOptions(app, &arguments->output, "");
  AddBodyOptions(app, &arguments->choice);
  app->remove_option(app->get_option("--cargo"));
  app->add_option("--cargo", arguments->cargoes, "freight: names or files, one or more")
      ->type_name("NAME|FILE ...")
      ->expected(1, -1)
      ->capture_default_str()
      ->group("The wagon");
  app->footer(
      "Examples:\n"
      "  wagon inertia\n"
      "  wagon inertia --cargo coils.toml --com corrected\n"
      "  wagon inertia --cargo water gold --json - | jq '.freights[].com_m.z'");
  return {app, [arguments] { return RunInertia(*arguments); }};
}

}  // namespace uiclink
