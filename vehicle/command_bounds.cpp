// What uncertain parameters do to the results of a command: options, draws, files.

#include "vehicle/command_bounds.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>

#include "data/input_error.h"
#include "vehicle/hunting/bounds_report.h"

namespace uiclink {

void AddBoundsOptions(CLI::App* app, BoundsArguments* arguments, std::size_t draws) {
  arguments->draws = draws;
  const auto asked = [arguments](const auto&) { arguments->asked = true; };
  app->add_option("--draws", arguments->draws,
                  "sets drawn from the covariance of the set for 95 % bounds; 0: none. A set without covariance has "
                  "no bounds")
      ->type_name("N")
      ->check(CheckBetween(0, 1e6, "draws"))
      ->each(asked)
      ->capture_default_str();
  const auto set_corners = [arguments](const std::string& text) {
    arguments->corners_as_in_set = text == "set";
    if (!arguments->corners_as_in_set) arguments->corner_scatter = std::stod(text);
  };
  const auto is_scatter = [percent = CheckBetween(0, 100, "%")](const std::string& text) {
    return text == "set" || percent(text).empty() ? "" : percent(text) + "; or set";
  };
  app->add_option_function<std::string>(
         "--corner-scatter", set_corners,
         "links differ from corner to corner: standard deviation of k, k_i and T0 of each, in percent; set: of each "
         "parameter, the spread between links that its set has (identify writes one where records differ)")
      ->type_name("P|set")
      ->check(is_scatter)
      ->each(asked)
      ->default_str("0");
  app->add_option("--coverage", arguments->coverage,
                  "half of a 95 % interval of the set in standard deviations: more than 1.96 where it stands on few "
                  "records (Student: ten 2.26, five 2.78, three 4.30). Default: what the set says of itself, else 1.96")
      ->type_name("C")
      ->check(CheckBetween(0.1, 100, ""));
  app->add_option("--seed", arguments->seed, "of what is drawn")->type_name("N")->capture_default_str();
}

std::optional<SetScatter> MakeScatter(const BoundsArguments& arguments, const WagonInputs& inputs) {
  if (arguments.draws == 0) return std::nullopt;
  const double corner = 0.01 * arguments.corner_scatter;
  try {
    SetScatter scatter(
        inputs.links,
        {.draws = arguments.draws,
         .seed = arguments.seed,
         .corner = {.k = corner, .slider_k = corner, .slider_T0 = corner, .from_set = arguments.corners_as_in_set},
         .coverage = {arguments.coverage, arguments.coverage}});
    const bool corners_differ = std::ranges::any_of(scatter.parameters(), &UncertainParameter::is_factor);
    if (!scatter.empty() && (corners_differ || !arguments.corners_as_in_set)) return scatter;
  } catch (const std::exception& error) {
    throw InputError("--draws", 0, error.what());
  }
  if (arguments.corners_as_in_set) {
    throw InputError("--corner-scatter set", 0,
                     "expected a set whose covariance has a spread (identify writes one where records do not share "
                     "their link), found none");
  }
  if (arguments.asked) {
    throw InputError("--draws", 0,
                     "expected a set with a covariance (identify writes one) or --corner-scatter above 0, found "
                     "neither");
  }
  return std::nullopt;
}

PropagateOptions MakePropagateOptions(const Progress& progress, const std::string& what) {
  PropagateOptions options;
  options.on_done = [&progress, what](std::size_t done, std::size_t of) {
    progress.Show(fmt::format("{}: {} of {}", what, done, of));
  };
  return options;
}

std::string WithKey(const std::string& json, const std::string& key, const Json& value) {
  Json document = Json::parse(json);
  document[key] = value;
  return FormatJson(document);
}

std::string WithLowAndHigh(const std::string& json, const std::string& key, const ScalarBounds& bounds) {
  Json document = Json::parse(json);
  if (!document.contains(key) || !document[key].is_object()) return json;
  const Json told = BoundsToJson(bounds);
  for (const char* part : {"low", "high", "shares"}) document[key][part] = told[part];
  return FormatJson(document);
}

PageBounds MakePageBounds(const std::optional<SetScatter>& scatter, const std::vector<ScalarBounds>& all) {
  return scatter && !all.empty() ? PageBounds{&*scatter, &all} : PageBounds{};
}

void WriteBounds(const std::string& title, const SetScatter& scatter, const std::vector<ScalarBounds>& all,
                 FigureWriter* files) {
  const Figure figure = BoundsFigure(title, all);
  if (!figure.panels.empty()) files->Write("bounds", figure, false);
  files->WriteText("bounds_draws.csv", FormatDraws(scatter, all));
}

}  // namespace uiclink
