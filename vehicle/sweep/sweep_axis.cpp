#include "vehicle/sweep/sweep_axis.h"

#include <fmt/format.h>

#include <algorithm>

#include "vehicle/commands.h"
#include "vehicle/report_json.h"

namespace uiclink {
namespace {

using Apply = std::function<void(const AxisValue&, RunSetup*)>;

Range Between(const std::string& unit, double low, double high) { return {.unit = unit, .low = low, .high = high}; }

template <typename Set>
Apply Number(Set set) {
  return [set](const AxisValue& value, RunSetup* setup) { set(std::get<double>(value), setup); };
}

template <typename Set>
Apply Text(Set set) {
  return [set](const AxisValue& value, RunSetup* setup) { set(std::get<std::string>(value), setup); };
}

/// "lateral=a.toml, rear=set2" -> its parts.
std::vector<std::string> SplitSets(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    if (first < end) parts.push_back(text.substr(first, text.find_last_not_of(' ', end - 1) + 1 - first));
    begin = end + 1;
  }
  return parts;
}

template <typename T>
std::vector<std::string> Words(const std::vector<T>& values) {
  std::vector<std::string> words;
  for (const T value : values) words.emplace_back(Name(value));
  return words;
}

/// An axis of named choices.
template <typename T, typename Set>
SweepAxis Choice(const std::string& name, const std::vector<T>& values, T fallback, Set set) {
  const auto apply = [values, set](const std::string& word, RunSetup* setup) {
    set(*std::ranges::find_if(values, [&](T value) { return word == Name(value); }), setup);
  };
  return {
      .name = name, .range = {}, .words = Words(values), .fallback = std::string(Name(fallback)), .apply = Text(apply)};
}

/// A number of a file that the campaign may replace.
SweepAxis Replacement(const std::string& name, Range range, double SI_per_unit,
                      std::optional<double> RunSetup::*member) {
  const auto apply = [SI_per_unit, member](double value, RunSetup* setup) { setup->*member = SI_per_unit * value; };
  return {.name = name, .range = std::move(range), .apply = Number(apply)};
}

SweepAxis Start(const std::string& name, Range range, double Perturbation::*member) {
  const auto apply = [member](double value, RunSetup* setup) { setup->by.*member = 1e-3 * value; };
  return {.name = name,
          .range = std::move(range),
          .words = {},
          .fallback = 0.0,
          .apply = Number(apply),
          .is_motion = true,
          .is_start = true};
}

SweepAxis File(const std::string& name, std::optional<AxisValue> fallback, std::string WagonChoice::*member) {
  const auto apply = [member](const std::string& text, RunSetup* setup) { setup->choice.*member = text; };
  return {.name = name, .range = {}, .words = {}, .fallback = std::move(fallback), .apply = Text(apply)};
}

void AddTrack(std::vector<SweepAxis>* axes) {
  const Range across = Between("mm", 300, 3000);
  axes->push_back(File("geometry", "nominal-1435", &WagonChoice::geometry));
  axes->push_back(File("contact_table", {}, &WagonChoice::contact_table));
  axes->push_back({.name = "wheel_profile", .range = {}, .apply = Text([](const std::string& text, RunSetup* setup) {
                                                           setup->wheel_profile = text;
                                                         })});
  axes->push_back({.name = "rail_profile", .range = {}, .apply = Text([](const std::string& text, RunSetup* setup) {
                                                          setup->rail_profile = text;
                                                        })});
  axes->push_back(Replacement("gauge_mm", across, 1e-3, &RunSetup::gauge));
  axes->push_back(Replacement("back_to_back_mm", across, 1e-3, &RunSetup::back_to_back));
  axes->push_back(Replacement("rail_offset_mm", Between("mm", -100, 100), 1e-3, &RunSetup::rail_offset));
  axes->push_back(Replacement("cant", Between("-", -0.2, 0.2), 1, &RunSetup::cant));
  axes->push_back(Replacement("wheel_load_N", Between("N", 100, 1e6), 1, &RunSetup::wheel_load));
}

void AddBody(std::vector<SweepAxis>* axes) {
  const Range clearance = Between("mm", 0, 1000), stiffness = Between("N/m", 1, 1e12);
  axes->push_back(File("wagon", "hbbills311", &WagonChoice::wagon));
  axes->push_back(File("cargo", "empty", &WagonChoice::cargo));
  axes->push_back(Choice<CentreOfMass>("com", {CentreOfMass::kPrinted, CentreOfMass::kCorrected},
                                       CentreOfMass::kCorrected, [](CentreOfMass com, RunSetup* setup) {
                                         InertiaOptions& inertia = setup->choice.inertia;
                                         const Partitions partitions = inertia.partitions;
                                         inertia = com == CentreOfMass::kPrinted ? InertiaOptions::Printed()
                                                                                 : InertiaOptions{};
                                         inertia.partitions = partitions;
                                       }));
  axes->push_back(Choice<Partitions>(
      "partitions", {Partitions::kAtEnds, Partitions::kSpread}, Partitions::kAtEnds,
      [](Partitions partitions, RunSetup* setup) { setup->choice.inertia.partitions = partitions; }));
  axes->push_back(Replacement("lateral_clearance_mm", clearance, 1e-3, &RunSetup::lateral_clearance));
  axes->push_back(Replacement("longitudinal_clearance_mm", clearance, 1e-3, &RunSetup::longitudinal_clearance));
  axes->push_back(Replacement("lateral_stop_N_per_m", stiffness, 1, &RunSetup::lateral_stiffness));
  axes->push_back(Replacement("longitudinal_stop_N_per_m", stiffness, 1, &RunSetup::longitudinal_stiffness));
}

void AddOptions(std::vector<SweepAxis>* axes) {
  axes->push_back(Choice<Suspension>(
      "suspension", {Suspension::kLinear, Suspension::kParabolic, Suspension::kLeaf}, Suspension::kParabolic,
      [](Suspension suspension, RunSetup* setup) { setup->choice.options.suspension = suspension; }));
  axes->push_back(Choice<Penetration>(
      "penetration", {Penetration::kTouching, Penetration::kPrinted}, Penetration::kTouching,
      [](Penetration penetration, RunSetup* setup) { setup->choice.options.penetration = penetration; }));
  axes->push_back({.name = "roll",
                   .range = {},
                   .words = {"printed", "corrected"},
                   .fallback = "corrected",
                   .apply = Text([](const std::string& word, RunSetup* setup) {
                     setup->choice.options.printed_roll = word == "printed";
                   })});
  axes->push_back(
      {.name = "guidance",
       .range = {},
       .words = {"on", "off"},
       .fallback = "on",
       .apply = Text([](const std::string& word, RunSetup* setup) { setup->choice.options.guidance = word == "on"; })});
  axes->push_back({.name = "friction",
                   .range = Between("-", 1e-6, 10),
                   .words = {},
                   .fallback = WagonOptions{}.mu,
                   .apply = Number([](double mu, RunSetup* setup) { setup->choice.options.mu = mu; })});
}

void AddLinks(std::vector<SweepAxis>* axes) {
  axes->push_back(
      {.name = "set",
       .range = {},
       .words = {},
       .fallback = "set1",
       .apply = Text([](const std::string& text, RunSetup* setup) { setup->choice.sets = SplitSets(text); })});
  // No fallback: runs of campaigns that do not know it keep their identity.
  axes->push_back({.name = "draw",
                   .range = {},
                   .words = {"nothing", "set", "corners", "set+corners"},
                   .apply = Text([](const std::string& word, RunSetup* setup) {
                     setup->draw_sets = word.starts_with("set");
                     setup->draw_corners = word.ends_with("corners");
                   })});
  axes->push_back({.name = "scatter_percent",
                   .range = Between("%", 0, 100),
                   .words = {},
                   .fallback = 0.0,
                   .apply = Number([](double percent, RunSetup* setup) { setup->scatter = percent / 100; })});
}

void AddMotion(std::vector<SweepAxis>* axes) {
  const Range length = Between("mm", -200, 200), angle = Between("mrad", -100, 100);  // as in start_state.cpp
  axes->push_back({.name = "start",
                   .range = {},
                   .words = {},
                   .fallback = "equilibrium",
                   .apply = Text([](const std::string& text, RunSetup* setup) { setup->start = text; }),
                   .is_motion = true,
                   .is_start = true});
  axes->push_back(Start("front_lateral_mm", length, &Perturbation::front_y));
  axes->push_back(Start("rear_lateral_mm", length, &Perturbation::rear_y));
  axes->push_back(Start("body_lateral_mm", length, &Perturbation::body_y));
  axes->push_back(Start("front_yaw_mrad", angle, &Perturbation::front_psi));
  axes->push_back(Start("rear_yaw_mrad", angle, &Perturbation::rear_psi));
  axes->push_back(Start("body_yaw_mrad", angle, &Perturbation::body_psi));
  axes->push_back(Start("body_roll_mrad", angle, &Perturbation::body_phi));
  axes->push_back({.name = "speed",
                   .range = Between("m/s", kLowestSpeed, kHighestSpeed),
                   .words = {},
                   .fallback = 20.0,
                   .apply = Number([](double V, RunSetup* setup) { setup->speed = V; }),
                   .is_motion = true});
}

}  // namespace

std::string FormatValue(const AxisValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return std::get<std::string>(value);
}

const std::vector<SweepAxis>& SweepAxes() {
  static const std::vector<SweepAxis> axes = [] {
    std::vector<SweepAxis> all;
    AddTrack(&all);
    AddBody(&all);
    AddOptions(&all);
    AddLinks(&all);
    AddMotion(&all);
    return all;
  }();
  return axes;
}

std::optional<std::size_t> FindAxis(const std::string& name) {
  const auto found = std::ranges::find(SweepAxes(), name, &SweepAxis::name);
  if (found == SweepAxes().end()) return std::nullopt;
  return static_cast<std::size_t>(found - SweepAxes().begin());
}

}  // namespace uiclink
