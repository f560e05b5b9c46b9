#include "vehicle/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "reports/text_table.h"
#include "vehicle/report_json.h"
#include "vehicle/wagon_state.h"

namespace uiclink {
namespace {

/// Place among the crossings; none where there is no critical speed.
std::optional<std::size_t> FindCritical(const StabilityResult& result) {
  if (!result.linear_critical_speed) return std::nullopt;
  for (std::size_t i = 0; i < result.crossings.size(); ++i) {
    if (result.crossings[i].V == *result.linear_critical_speed) return i;
  }
  return std::nullopt;
}

CrossingType TypeOf(const StabilityRun& run, std::size_t crossing) {
  return crossing < run.types.size() ? run.types[crossing] : CrossingType{.type = {}};
}

Json TypeToJson(const CrossingType& type) { return type.type.empty() ? Json(nullptr) : Json(type.type); }

/// What the type stands on, beside it.
void AddTypeDetails(const CrossingType& type, Json* json) {
  if (!type.type.empty()) {
    (*json)["type_decided_at_mm"] = 1e3 * type.decided_at;
    (*json)["other_type_below_mm"] = type.other_below > 0 ? Json(1e3 * type.other_below) : Json(nullptr);
  } else if (!type.reason.empty()) {
    (*json)["type_unknown_because"] = type.reason;
  }
}

/// How much a motion takes part, as one number with a phase.
struct Part {
  const char* name;
  std::size_t place;
};
constexpr std::array<Part, 8> kParts{{{"front_lateral", wheelset::kY},
                                      {"front_yaw", wheelset::kPsi},
                                      {"rear_lateral", kRearWheelset + wheelset::kY},
                                      {"rear_yaw", kRearWheelset + wheelset::kPsi},
                                      {"body_lateral", kBody + body::kY},
                                      {"body_roll", kBody + body::kPhi},
                                      {"body_yaw", kBody + body::kPsi},
                                      {"body_vertical", kBody + body::kZ}}};

/// Amplitudes in m and rad, relative to the largest displacement of all; phases in degrees.
Json ShapeToJson(const LinearMode& mode) {
  Json json = Json::object();
  for (const Part& part : kParts) {
    const std::complex<double> value = mode.shape[part.place];
    json[part.name] = {{"amplitude", std::abs(value)}, {"phase_deg", std::arg(value) * 180 / std::numbers::pi}};
  }
  return json;
}

Json CrossingToJson(const Crossing& crossing, const CrossingType& type) {
  Json json{{"speed", crossing.V},
            {"frequency_hz", crossing.frequency_hz},
            {"direction", crossing.to_unstable ? "unstable" : "stable"},
            {"type", TypeToJson(type)}};
  AddTypeDetails(type, &json);
  json["real_part_slope_1_per_m"] = NumberOrNull(crossing.real_part_slope);
  json["shape"] = ShapeToJson(crossing.mode);
  return json;
}

double Frequency(const std::complex<double>& root) { return root.imag() / (2 * std::numbers::pi); }

/// Points of the figure: what a slow eigenvalue is at each speed.
FigureSeries SlowRoots(const StabilityRun& run, const std::string& name, bool unstable,
                       double (*x)(double V, std::complex<double> root), double (*y)(std::complex<double> root)) {
  FigureSeries series{.name = name,
                      .line = FigureLine::kNone,
                      .mark = FigureMark::kDot,
                      .colour = unstable ? FigureColour::kVermilion : FigureColour::kBlue};
  for (const RootsAtSpeed& at : run.roots) {
    for (const std::complex<double>& root : at.roots) {
      if (!IsSlowRoot(root) || (root.real() > 0) != unstable) continue;
      series.x.push_back(x(at.V, root));
      series.y.push_back(y(root));
    }
  }
  return series;
}

}  // namespace

bool IsSlowRoot(const std::complex<double>& root) {
  constexpr double kFastest = 40;   // [rad/s]
  constexpr double kDampest = -30;  // [1/s]
  return root.imag() >= 0 && root.imag() < kFastest && root.real() > kDampest;
}

std::string FormatStabilityJson(const StabilityRun& run) {
  Json json = BeginResult("stability", run.inputs);
  if (const std::optional<std::size_t> critical = FindCritical(run.result)) {
    const Crossing& crossing = run.result.crossings[*critical];
    const CrossingType type = TypeOf(run, *critical);
    json["linear_critical_speed"] = {
        {"value", crossing.V}, {"frequency_hz", crossing.frequency_hz}, {"type", TypeToJson(type)}};
    AddTypeDetails(type, &json["linear_critical_speed"]);
  } else {
    json["linear_critical_speed"] = nullptr;
  }
  json["crossings"] = Json::array();
  for (std::size_t i = 0; i < run.result.crossings.size(); ++i)
    json["crossings"].push_back(CrossingToJson(run.result.crossings[i], TypeOf(run, i)));
  json["unstable_at_start"] = run.result.unstable_at_start;
  json["structural_zeros"] = run.result.structural_zeros;
  json["searched"] = {{"from", run.options.from},
                      {"to", run.result.searched_to},
                      {"step", run.options.step},
                      {"tolerance", run.options.tolerance}};
  json["wall_s"] = run.wall_s;
  return FormatJson(json);
}

std::string FormatCrossingType(const CrossingType& type) {
  if (type.type.empty()) return type.reason.empty() ? "" : "type not known: " + type.reason;
  std::string text = fmt::format("{}, decided by the cycle of {:g} mm", type.type, 1e3 * type.decided_at);
  if (type.other_below > 0) {
    text += fmt::format("; {} at {:g} mm", type.type == "supercritical" ? "subcritical" : "supercritical",
                        1e3 * type.other_below);
  }
  return text;
}

TextTable MakeCrossingTable(const StabilityRun& run) {
  TextTable table;
  table.AddColumn("crossing at\n[m/s]");
  table.AddColumn("frequency\n[Hz]");
  table.AddColumn("becomes", TextTable::Align::kLeft);
  table.AddColumn("type", TextTable::Align::kLeft);
  for (std::size_t i = 0; i < run.result.crossings.size(); ++i) {
    const Crossing& crossing = run.result.crossings[i];
    const std::string type = TypeOf(run, i).type;
    table.AddRow({fmt::format("{:.6f}", crossing.V), fmt::format("{:.4f}", crossing.frequency_hz),
                  crossing.to_unstable ? "unstable" : "stable", type.empty() ? "-" : type});
  }
  return table;
}

std::string FormatStability(const StabilityRun& run) {
  const StabilityResult& result = run.result;
  std::string text =
      fmt::format("{}, cargo {}, contact {}\n", run.inputs.data.name, run.inputs.freight.name, run.inputs.table.name) +
      FormatSets(run.inputs) + "\n";
  if (const std::optional<std::size_t> critical = FindCritical(result)) {
    const Crossing& crossing = result.crossings[*critical];
    text += fmt::format("Linear critical speed {:.6f} m/s ({:.1f} km/h), {:.3f} Hz.\n", crossing.V, 3.6 * crossing.V,
                        crossing.frequency_hz);
    if (const std::string type = FormatCrossingType(TypeOf(run, *critical)); !type.empty())
      text += "Hopf bifurcation: " + type + ".\n";
  } else if (result.unstable_at_start > 0) {
    text += fmt::format("Unstable already at {:g} m/s: {} eigenvalues with positive real part.\n", run.options.from,
                        result.unstable_at_start);
  } else {
    text += fmt::format("Stable from {:g} to {:g} m/s.\n", run.options.from, result.searched_to);
  }
  if (!result.crossings.empty()) text += "\n" + MakeCrossingTable(run).Format();
  text += fmt::format("\nAll joints stick: {} structural zero eigenvalues are left out. {:.2g} s of computing.\n",
                      result.structural_zeros, run.wall_s);
  return text;
}

std::vector<DataColumn> RootColumns(const StabilityRun& run) {
  std::vector<DataColumn> columns{{"speed", "m/s", {}}, {"real_part", "1/s", {}}, {"imaginary_part", "rad/s", {}}};
  for (const RootsAtSpeed& at : run.roots) {
    for (const std::complex<double>& root : at.roots) {
      if (root.imag() < 0) continue;
      columns[0].values.push_back(at.V);
      columns[1].values.push_back(root.real());
      columns[2].values.push_back(root.imag());
    }
  }
  return columns;
}

Figure RootLocusFigure(const StabilityRun& run) {
  const auto speed = [](double V, std::complex<double>) { return V; };
  const auto real_part_x = [](double, std::complex<double> root) { return root.real(); };
  const auto real_part = [](std::complex<double> root) { return root.real(); };
  const auto frequency = [](std::complex<double> root) { return Frequency(root); };
  Figure figure{.title = fmt::format("eigenvalues of {}, {}, {}", run.inputs.data.name, run.inputs.freight.name,
                                     run.inputs.table.name),
                .columns = 2,
                .width = 1200,
                .panel_height = 330};
  std::vector<FigureGuide> critical;
  for (const Crossing& crossing : run.result.crossings)
    critical.push_back({crossing.V, fmt::format("{:.2f} m/s", crossing.V)});
  const FigureAxis speed_axis{.label = "speed", .unit = "m/s"};
  const FigureAxis growth_axis{.label = "real part", .unit = "1/s"};
  const FigureAxis frequency_axis{.label = "frequency", .unit = "Hz"};
  const auto both = [&](auto x, auto y) {
    return std::vector<FigureSeries>{SlowRoots(run, "stable", false, x, y), SlowRoots(run, "unstable", true, x, y)};
  };
  figure.panels.push_back({.title = "growth",
                           .x = speed_axis,
                           .y = growth_axis,
                           .series = both(speed, real_part),
                           .horizontal_guides = {{0, ""}},
                           .vertical_guides = critical});
  figure.panels.push_back({.title = "frequency",
                           .x = speed_axis,
                           .y = frequency_axis,
                           .series = both(speed, frequency),
                           .vertical_guides = critical});
  figure.panels.push_back({.title = "root locus",
                           .x = growth_axis,
                           .y = frequency_axis,
                           .series = both(real_part_x, frequency),
                           .vertical_guides = {{0, ""}}});
  FigurePanel close_up{.title = "root locus near the limit",
                       .x = growth_axis,
                       .y = frequency_axis,
                       .series = both(real_part_x, frequency),
                       .vertical_guides = {{0, ""}}};
  close_up.x.low = -1.5;
  close_up.x.high = 1.5;
  close_up.y.low = 0;
  for (const Crossing& crossing : run.result.crossings)
    close_up.notes.push_back({0, crossing.frequency_hz, fmt::format("{:.2f} m/s", crossing.V)});
  figure.panels.push_back(std::move(close_up));
  return figure;
}

}  // namespace uiclink
