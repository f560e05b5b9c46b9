// wagon inertia: mass, centre of mass and moments of inertia, part by part and for each freight.

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "vehicle/commands.h"
#include "vehicle/inertia_report.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

struct Arguments {
  WagonChoice choice;
  std::vector<std::string> cargoes{"empty", "water", "gold", "packed"};
  Output output;
};

int RunInertia(const Arguments& arguments) {
  WagonInputs inputs;
  std::vector<Freight> freights;
  for (const std::string& cargo : arguments.cargoes) {
    WagonChoice choice = arguments.choice;
    choice.cargo = cargo;
    WagonInputs with_cargo;
    ReadWagonBody(choice, &with_cargo);
    if (freights.empty()) {
      inputs = with_cargo;
    } else {
      inputs.files.push_back(with_cargo.files.back());
      for (const std::string& notice : with_cargo.notices) inputs.notices.push_back(notice);
    }
    freights.push_back(with_cargo.freight);
  }
  inputs.choice = arguments.choice;
  inputs.body = {};  // there is one for each freight, in the result itself
  PrintNotices(inputs.notices);
  const InertiaOptions& options = arguments.choice.inertia;
  const std::string json = FormatInertiaJson(inputs.data, freights, options, InputsToJson(inputs).dump());
  FigureWriter files(arguments.output);
  files.WriteText("inertia.json", json);
  Emit(arguments.output, FormatInertiaReport(inputs.data, freights, options) + files.Written(), json);
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
