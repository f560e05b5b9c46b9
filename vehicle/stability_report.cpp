#include "vehicle/stability_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "reports/text_table.h"
#include "vehicle/report_json.h"
#include "vehicle/wagon_state.h"

namespace uiclink {
namespace {

const Crossing* FindCritical(const StabilityResult& result) {
  if (!result.linear_critical_speed) return nullptr;
  for (const Crossing& crossing : result.crossings) {
    if (crossing.V == *result.linear_critical_speed) return &crossing;
  }
  return nullptr;
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

Json CrossingToJson(const Crossing& crossing) {
  return {{"speed", crossing.V},
          {"frequency_hz", crossing.frequency_hz},
          {"direction", crossing.to_unstable ? "unstable" : "stable"},
          {"real_part_slope_1_per_m", NumberOrNull(crossing.real_part_slope)},
          {"shape", ShapeToJson(crossing.mode)}};
}

double Frequency(const std::complex<double>& root) { return root.imag() / (2 * std::numbers::pi); }

/// Hunting and the body's swaying on its springs; Hertz contact and creep are 100 times as fast.
bool IsSlow(const std::complex<double>& root) {
  constexpr double kFastest = 40;   // [rad/s]
  constexpr double kDampest = -30;  // [1/s]
  return root.imag() >= 0 && root.imag() < kFastest && root.real() > kDampest;
}

/// Points of the figure: what a slow eigenvalue is at each speed.
FigureSeries SlowRoots(const StabilityRun& run, const std::string& name, bool unstable,
                       double (*x)(double V, std::complex<double> root), double (*y)(std::complex<double> root)) {
  FigureSeries series{.name = name,
                      .line = FigureLine::kNone,
                      .mark = FigureMark::kDot,
                      .colour = unstable ? FigureColour::kVermilion : FigureColour::kBlue};
  for (const RootsAtSpeed& at : run.roots) {
    for (const std::complex<double>& root : at.roots) {
      if (!IsSlow(root) || (root.real() > 0) != unstable) continue;
      series.x.push_back(x(at.V, root));
      series.y.push_back(y(root));
    }
  }
  return series;
}

}  // namespace

std::string FormatStabilityJson(const StabilityRun& run) {
  Json json = BeginResult("stability", run.inputs);
  if (const Crossing* const critical = FindCritical(run.result)) {
    // The type asks for the nonlinear wagon, which this command does not look at.
    json["linear_critical_speed"] = {
        {"value", critical->V}, {"frequency_hz", critical->frequency_hz}, {"type", nullptr}};
  } else {
    json["linear_critical_speed"] = nullptr;
  }
  json["crossings"] = Json::array();
  for (const Crossing& crossing : run.result.crossings) json["crossings"].push_back(CrossingToJson(crossing));
  json["unstable_at_start"] = run.result.unstable_at_start;
  json["structural_zeros"] = run.result.structural_zeros;
  json["searched"] = {{"from", run.options.from},
                      {"to", run.result.searched_to},
                      {"step", run.options.step},
                      {"tolerance", run.options.tolerance}};
  json["wall_s"] = run.wall_s;
  return FormatJson(json);
}

std::string FormatStability(const StabilityRun& run) {
  const StabilityResult& result = run.result;
  std::string text =
      fmt::format("{}, cargo {}, contact {}\n", run.inputs.data.name, run.inputs.freight.name, run.inputs.table.name) +
      FormatSets(run.inputs) + "\n";
  if (const Crossing* const critical = FindCritical(result)) {
    text += fmt::format("Linear critical speed {:.6f} m/s ({:.1f} km/h), {:.3f} Hz.\n", critical->V, 3.6 * critical->V,
                        critical->frequency_hz);
  } else if (result.unstable_at_start > 0) {
    text += fmt::format("Unstable already at {:g} m/s: {} eigenvalues with positive real part.\n", run.options.from,
                        result.unstable_at_start);
  } else {
    text += fmt::format("Stable from {:g} to {:g} m/s.\n", run.options.from, result.searched_to);
  }
  if (!result.crossings.empty()) {
    TextTable table;
    table.AddColumn("crossing at\n[m/s]");
    table.AddColumn("frequency\n[Hz]");
    table.AddColumn("becomes", TextTable::Align::kLeft);
    for (const Crossing& crossing : result.crossings) {
      table.AddRow({fmt::format("{:.6f}", crossing.V), fmt::format("{:.4f}", crossing.frequency_hz),
                    crossing.to_unstable ? "unstable" : "stable"});
    }
    text += "\n" + table.Format();
  }
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
