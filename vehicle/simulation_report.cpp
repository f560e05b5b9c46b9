#include "vehicle/simulation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reports/text_table.h"
#include "reports/wrap.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

constexpr std::array kAllMotions{TrackedMotion::kFrontLateral,     TrackedMotion::kRearLateral,
                                 TrackedMotion::kBodyLateral,      TrackedMotion::kFrontLongitudinal,
                                 TrackedMotion::kRearLongitudinal, TrackedMotion::kBodyYaw,
                                 TrackedMotion::kBodyRoll};
static_assert(kAllMotions.size() == kMotionCount);
constexpr std::array<const char*, kAxles> kAxleNames{"front", "rear"};

std::size_t IndexOf(TrackedMotion motion) { return static_cast<std::size_t>(motion); }
bool IsAngle(TrackedMotion motion) { return motion == TrackedMotion::kBodyYaw || motion == TrackedMotion::kBodyRoll; }
bool IsLongitudinal(TrackedMotion motion) {
  return motion == TrackedMotion::kFrontLongitudinal || motion == TrackedMotion::kRearLongitudinal;
}

const char* EndWord(SimulationEnd end) {
  switch (end) {
    case SimulationEnd::kDuration:
      return "duration";
    case SimulationEnd::kWheelLift:
      return "wheel_lift";
    case SimulationEnd::kDerailed:
      return "derailed";
    case SimulationEnd::kStopped:
      return "stopped";
    case SimulationEnd::kFailed:
      return "failed";
  }
  return "?";
}

// --- JSON ----------------------------------------------------------------------------------------------------------

Json AmplitudesToJson(const SimulationResult& result, bool angles) {
  Json json = Json::object();
  for (const TrackedMotion motion : kAllMotions) {
    if (IsAngle(motion) == angles)
      json[kMotionNames[IndexOf(motion)]] = NumberOrNull(1e3 * result.motions[IndexOf(motion)].amplitude);
  }
  return json;
}

/// The strongest line for lateral motions and angles (null where nothing moves), all lines for longitudinal ones.
Json FrequenciesToJson(const SimulationResult& result) {
  Json json = Json::object();
  for (const TrackedMotion motion : kAllMotions) {
    const std::vector<double>& frequencies = result.motions[IndexOf(motion)].frequencies;
    Json& entry = json[kMotionNames[IndexOf(motion)]];
    if (IsLongitudinal(motion)) {
      entry = frequencies;
    } else {
      entry = frequencies.empty() ? Json(nullptr) : Json(frequencies.front());
    }
  }
  return json;
}

Json SpectrumToJson(const SimulationResult& result) {
  Json json = Json::object();
  for (const TrackedMotion motion : kAllMotions) {
    const MotionFigures& figures = result.motions[IndexOf(motion)];
    Json peaks = Json::array();
    for (std::size_t i = 0; i < figures.frequencies.size(); ++i) {
      peaks.push_back({{"frequency_hz", figures.frequencies[i]},
                       {IsAngle(motion) ? "amplitude_mrad" : "amplitude_mm", 1e3 * figures.frequency_amplitudes[i]}});
    }
    json[kMotionNames[IndexOf(motion)]] = std::move(peaks);
  }
  return json;
}

/// Calls take(key, use) for every axle and direction.
template <typename Take>
void ForEachGuidance(const SimulationResult& result, Take take) {
  for (std::size_t axle = 0; axle < kAxles; ++axle)
    take(std::string(kAxleNames[axle]) + "_lateral", result.lateral[axle]);
  for (std::size_t axle = 0; axle < kAxles; ++axle) {
    take(std::string(kAxleNames[axle]) + "_longitudinal", result.longitudinal[axle]);
  }
}

Json ToJson(const Impacts& impacts) { return {{"count", impacts.count}, {"peak_N", impacts.peak_N}}; }

void AddGuidance(const SimulationResult& result, Json* json) {
  Json used, used_in_window, impacts, impacts_in_window;
  ForEachGuidance(result, [&](const std::string& key, const GuidanceUse& use) {
    used[key] = 1e3 * use.clearance_used;
    used_in_window[key] = 1e3 * use.clearance_used_in_window;
    impacts[key] = ToJson(use.impacts);
    impacts_in_window[key] = ToJson(use.impacts_in_window);
  });
  (*json)["clearance_used_mm"] = used;
  (*json)["impacts"] = impacts;
  (*json)["in_window"] = {{"clearance_used_mm", used_in_window}, {"impacts", impacts_in_window}};
}

// --- text ----------------------------------------------------------------------------------------------------------

// --- histories -----------------------------------------------------------------------------------------------------

/// A column of what `of` gives of every sample.
template <typename Of>
std::vector<double> Gather(const SimulationResult& result, Of of) {
  std::vector<double> values;
  values.reserve(result.samples.size());
  for (std::size_t i = 0; i < result.samples.size(); ++i) values.push_back(of(i));
  return values;
}

void AddForceColumns(const SimulationResult& result, std::vector<DataColumn>* columns) {
  using Array = std::array<double, kCorners> WagonForces::*;
  static constexpr std::array<std::pair<const char*, Array>, 5> kArrays{{{"link_x", &WagonForces::link_x},
                                                                         {"link_y", &WagonForces::link_y},
                                                                         {"spring", &WagonForces::spring},
                                                                         {"guide_x", &WagonForces::guide_x},
                                                                         {"guide_y", &WagonForces::guide_y}}};
  for (std::size_t c = 0; c < kCorners; ++c) {
    const std::string corner = kCornerNames[c];
    columns->push_back(
        {corner + "_wheel_load", "N", Gather(result, [&](std::size_t i) { return result.forces[i].wheels[c].Q; })});
    columns->push_back(
        {corner + "_wheel_lateral", "N", Gather(result, [&](std::size_t i) { return result.forces[i].wheels[c].Y; })});
    for (const auto& [name, array] : kArrays) {
      columns->push_back({corner + "_" + name, "N",
                          Gather(result, [&, array = array](std::size_t i) { return (result.forces[i].*array)[c]; })});
    }
  }
}

FigureSeries TimeSeries(const SimulationResult& result, const std::string& name, std::size_t component, double factor) {
  return {.name = name,
          .x = Gather(result, [&](std::size_t i) { return result.samples[i].t; }),
          .y = Gather(result, [&](std::size_t i) { return factor * result.samples[i].x[component]; })};
}

FigureSeries MotionSeries(const SimulationResult& result, const std::string& name, TrackedMotion motion) {
  return TimeSeries(result, name, kMotionIndex[IndexOf(motion)], 1e3);
}

FigurePanel WheelLoadPanel(const SimulationResult& result) {
  FigurePanel panel{.title = "wheel loads", .x = {"time", "s"}, .y = {"vertical force", "kN"}};
  for (std::size_t c = 0; c < kCorners; ++c) {
    std::string name = kCornerNames[c];
    std::ranges::replace(name, '_', ' ');
    panel.series.push_back({.name = name,
                            .x = Gather(result, [&](std::size_t i) { return result.samples[i].t; }),
                            .y = Gather(result, [&](std::size_t i) { return 1e-3 * result.forces[i].wheels[c].Q; })});
  }
  return panel;
}

std::vector<FigurePanel> HistoryPanels(const SimulationResult& result) {
  std::vector<FigurePanel> panels;
  panels.push_back({.title = "lateral",
                    .x = {"time", "s"},
                    .y = {"displacement", "mm"},
                    .series = {MotionSeries(result, "front wheelset", TrackedMotion::kFrontLateral),
                               MotionSeries(result, "rear wheelset", TrackedMotion::kRearLateral),
                               MotionSeries(result, "body", TrackedMotion::kBodyLateral)}});
  panels.push_back({.title = "longitudinal",
                    .x = {"time", "s"},
                    .y = {"displacement", "mm"},
                    .series = {MotionSeries(result, "front wheelset", TrackedMotion::kFrontLongitudinal),
                               MotionSeries(result, "rear wheelset", TrackedMotion::kRearLongitudinal)}});
  panels.push_back({.title = "body",
                    .x = {"time", "s"},
                    .y = {"angle", "mrad"},
                    .series = {MotionSeries(result, "yaw", TrackedMotion::kBodyYaw),
                               MotionSeries(result, "roll", TrackedMotion::kBodyRoll)}});
  if (result.forces.size() == result.samples.size()) panels.push_back(WheelLoadPanel(result));
  return panels;
}

/// The panel from time `from` on.
FigurePanel From(const FigurePanel& panel, double from) {
  FigurePanel part = panel;
  for (FigureSeries& series : part.series) {
    const auto first = std::ranges::lower_bound(series.x, from) - series.x.begin();
    series.name.clear();
    series.x.erase(series.x.begin(), series.x.begin() + first);
    series.y.erase(series.y.begin(), series.y.begin() + first);
  }
  return part;
}

}  // namespace

TextTable MakeMotionTable(const SimulationResult& result) {
  TextTable table;
  table.AddColumn("motion", TextTable::Align::kLeft);
  table.AddColumn("amplitude");
  table.AddColumn("mean");
  table.AddColumn("unit", TextTable::Align::kLeft);
  table.AddColumn("frequencies [Hz]", TextTable::Align::kLeft);
  for (const TrackedMotion motion : kAllMotions) {
    const MotionFigures& figures = result.motions[IndexOf(motion)];
    std::string frequencies;
    for (const double f : figures.frequencies)
      frequencies += fmt::format("{}{:.3f}", frequencies.empty() ? "" : ", ", f);
    std::string name = kMotionNames[IndexOf(motion)];
    std::ranges::replace(name, '_', ' ');
    table.AddRow({name, fmt::format("{:.4f}", 1e3 * figures.amplitude), fmt::format("{:+.4f}", 1e3 * figures.mean),
                  IsAngle(motion) ? "mrad" : "mm", frequencies});
  }
  return table;
}

TextTable MakeGuidanceTable(const SimulationRun& run) {
  TextTable table;
  table.AddColumn("axle box against guide", TextTable::Align::kLeft);
  table.AddColumn("clearance\n[mm]");
  table.AddColumn("used\n[mm]");
  table.AddColumn("impacts");
  table.AddColumn("peak\n[kN]");
  const Guidance& guidance = run.inputs.data.guidance;
  ForEachGuidance(run.result, [&](const std::string& key, const GuidanceUse& use) {
    std::string name = key;
    std::ranges::replace(name, '_', ' ');
    const double clearance = (key.ends_with("lateral") ? guidance.lateral : guidance.longitudinal).clearance;
    table.AddRow({name, fmt::format("{:.1f}", 1e3 * clearance), fmt::format("{:.3f}", 1e3 * use.clearance_used),
                  std::to_string(use.impacts.count),
                  use.impacts.count > 0 ? fmt::format("{:.2f}", 1e-3 * use.impacts.peak_N) : "-"});
  });
  return table;
}

std::string FormatSimulationJson(const SimulationRun& run) {
  const SimulationResult& result = run.result;
  Json json = BeginResult("simulate", run.inputs);
  json["speed"] = result.V;
  json["start"] = {{"from", run.start}, {"time_s", run.start_s}};
  json["end"] = {{"why", EndWord(result.end)},
                 {"reason", result.end_reason.empty() ? Json(nullptr) : Json(result.end_reason)},
                 {"time_s", result.state.t}};
  json["window_s"] = run.window;
  json["amplitude_mm"] = AmplitudesToJson(result, false);
  json["amplitude_mrad"] = AmplitudesToJson(result, true);
  json["frequency_hz"] = FrequenciesToJson(result);
  json["spectrum"] = SpectrumToJson(result);
  AddGuidance(result, &json);
  json["minimum_wheel_load_N"] = NumberOrNull(result.minimum_wheel_load);
  json["minimum_wheel_load_at"] = kCornerNames[result.minimum_wheel_corner];
  json["wheel_lift"] = result.wheel_lift;
  json["derailed"] = result.derailed;
  json["simulated_s"] = result.simulated;
  json["wall_s"] = result.wall_s;
  json["rhs_calls"] = result.counts.rhs_calls;
  json["steps"] = result.counts.steps;
  json["failed_steps"] = result.counts.failed_steps;
  json["events"] = result.counts.events;
  return FormatJson(json);
}

std::string FormatSimulation(const SimulationRun& run) {
  const SimulationResult& result = run.result;
  const WagonInputs& inputs = run.inputs;
  std::string text = fmt::format("{} at {:g} m/s, cargo {}, contact {}; start: {}\n", inputs.data.name, result.V,
                                 inputs.freight.name, inputs.table.name, run.start);
  text += FormatSets(inputs);
  const double window = std::min(run.window, result.simulated);
  text +=
      fmt::format("\nThe last {:.4g} s of {:.4g} s:\n\n", window, result.simulated) + MakeMotionTable(result).Format();
  text += "\n" + MakeGuidanceTable(run).Format();
  if (!inputs.choice.options.guidance) text += "(the guides are taken away: --no-guidance)\n";
  std::string corner = kCornerNames[result.minimum_wheel_corner];
  std::ranges::replace(corner, '_', ' ');
  text += fmt::format("\nSmallest wheel load {:.2f} kN ({}).\n", 1e-3 * result.minimum_wheel_load, corner);
  if (result.end != SimulationEnd::kDuration) text += Paragraph("The run ended early: " + result.end_reason, 0, 120);
  text += fmt::format("{:.3g} s of computing: {:.0f} times real time, {} steps, {} events, {} right-hand sides.\n",
                      result.wall_s, result.wall_s > 0 ? result.simulated / result.wall_s : 0.0, result.counts.steps,
                      result.counts.events, result.counts.rhs_calls);
  return text;
}

std::vector<DataColumn> HistoryColumns(const SimulationRun& run) {
  const SimulationResult& result = run.result;
  std::vector<DataColumn> columns{{"time", "s", Gather(result, [&](std::size_t i) { return result.samples[i].t; })}};
  const std::size_t size = run.inputs.choice.options.suspension == Suspension::kLeaf ? kMaxState : kMotions;
  for (std::size_t component = 0; component < size; ++component) {
    columns.push_back({kStateNames[component], kStateUnits[component],
                       Gather(result, [&](std::size_t i) { return result.samples[i].x[component]; })});
  }
  if (result.forces.size() == result.samples.size()) AddForceColumns(result, &columns);
  return columns;
}

Figure HistoryFigure(const SimulationRun& run) {
  constexpr double kCloseUp = 5;  // [s]: a few periods of hunting
  const SimulationResult& result = run.result;
  Figure figure{.title = fmt::format("{} at {:g} m/s, {}, {}", run.inputs.data.name, result.V, run.inputs.freight.name,
                                     run.inputs.table.name),
                .columns = 1,
                .panel_height = 220};
  const bool close_up = result.simulated > 2 * kCloseUp && !result.samples.empty();
  for (FigurePanel& panel : HistoryPanels(result)) {
    if (close_up) {
      figure.columns = 2;
      figure.width = 1300;
      FigurePanel part = From(panel, result.samples.back().t - kCloseUp);
      part.title = panel.title + fmt::format(", last {:g} s", kCloseUp);
      figure.panels.push_back(std::move(panel));
      figure.panels.push_back(std::move(part));
    } else {
      figure.panels.push_back(std::move(panel));
    }
  }
  return figure;
}

}  // namespace uiclink
