#include "vehicle/hunting/wagon_parameter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "model/effect.h"
#include "vehicle/contact/contact_curve.h"
#include "vehicle/hunting/set_scatter.h"

namespace uiclink {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
using Corners = std::array<bool, kCorners>;
constexpr Corners kAllCorners{true, true, true, true};

/// Of the larger end of the range: the step of differences (ParameterSlopes).
constexpr double kStep = 1e-5;

/// A number that has a place of its own in the inputs.
struct OwnPlace {
  const char* name;
  const char* unit;
  double per_SI;
  double* (*place)(WagonInputs*);
};
constexpr std::array<OwnPlace, 13> kOwnPlaces{{
    {"friction", "-", 1, [](WagonInputs* inputs) { return &inputs->choice.options.mu; }},
    {"lateral_clearance_mm", "mm", 1e3, [](WagonInputs* inputs) { return &inputs->data.guidance.lateral.clearance; }},
    {"longitudinal_clearance_mm", "mm", 1e3,
     [](WagonInputs* inputs) { return &inputs->data.guidance.longitudinal.clearance; }},
    {"lateral_stop_N_per_m", "N/m", 1, [](WagonInputs* inputs) { return &inputs->data.guidance.lateral.k; }},
    {"longitudinal_stop_N_per_m", "N/m", 1, [](WagonInputs* inputs) { return &inputs->data.guidance.longitudinal.k; }},
    {"body_mass_kg", "kg", 1, [](WagonInputs* inputs) { return &inputs->body.m; }},
    {"body_roll_inertia_kg_m2", "kg m^2", 1, [](WagonInputs* inputs) { return &inputs->body.I_x; }},
    {"body_yaw_inertia_kg_m2", "kg m^2", 1, [](WagonInputs* inputs) { return &inputs->body.I_z; }},
    {"body_height_mm", "mm", 1e3, [](WagonInputs* inputs) { return &inputs->body.h; }},
    {"wheelset_mass_kg", "kg", 1, [](WagonInputs* inputs) { return &inputs->data.wheelset.m; }},
    {"wheelset_roll_inertia_kg_m2", "kg m^2", 1, [](WagonInputs* inputs) { return &inputs->data.wheelset.I_x; }},
    {"wheelset_pitch_inertia_kg_m2", "kg m^2", 1, [](WagonInputs* inputs) { return &inputs->data.wheelset.I_y; }},
    {"wheelset_yaw_inertia_kg_m2", "kg m^2", 1, [](WagonInputs* inputs) { return &inputs->data.wheelset.I_z; }},
}};

/// Keys of `wagon sweep` that go through the contact table.
constexpr std::array<std::string_view, 9> kOfContact{"gauge_mm",     "back_to_back_mm", "rail_offset_mm",
                                                     "cant",         "wheel_load_N",    "wheel_profile",
                                                     "rail_profile", "geometry",        "contact_table"};

WagonParameter MakeOwn(const OwnPlace& own, const WagonInputs& inputs) {
  WagonInputs copy = inputs;
  return {.name = own.name,
          .unit = own.unit,
          .value = own.per_SI * *own.place(&copy),
          .low = 0,
          .high = kInfinite,
          .set = [own](double value, WagonInputs* changed) { *own.place(changed) = value / own.per_SI; }};
}

double CargoMass(const Freight& freight) {
  double mass = freight.even ? freight.even->mass : 0;
  for (const FreightBox& box : freight.boxes) mass += box.mass;
  return mass;
}

/// The freight as it lies, heavier or lighter: its mass, and with its shape its inertia.
std::optional<WagonParameter> MakeCargoMass(const WagonInputs& inputs) {
  const double own = CargoMass(inputs.freight);
  if (!(own > 0)) return std::nullopt;
  const auto set = [](double value, WagonInputs* changed) {
    Freight& freight = changed->freight;
    const double factor = value / CargoMass(freight);
    if (freight.even) {
      freight.even->mass *= factor;
      freight.even->density *= factor;
    }
    for (FreightBox& box : freight.boxes) box.mass *= factor;
    changed->body = CalcBodyInertia(changed->data, freight, changed->choice.inertia);
  };
  return WagonParameter{.name = "cargo_mass_kg", .unit = "kg", .value = own, .low = 0, .high = kInfinite, .set = set};
}

// ---------------------------------------------------------------- links

DirectionParameters& LinkOf(WagonInputs* inputs, std::size_t corner, Direction direction) {
  CornerLinks& links = inputs->links[corner];
  return direction == Direction::kLateral ? links.lateral : links.longitudinal;
}

/// Unit and bounds of a symbol; a stiffness or friction limit of zero is a joint less.
void Describe(const std::string& symbol, WagonParameter* parameter) {
  parameter->low = 0;
  parameter->high = kInfinite;
  parameter->unit = symbol.starts_with("T0") ? "-" : "1/m";
  const std::size_t dot = symbol.find('.');
  if (dot == std::string::npos) return;
  const Effect* effect = FindEffect(std::string_view(symbol).substr(0, dot));
  if (effect == nullptr) return;
  for (const EffectParameter& p : effect->parameters) {
    if (p.symbol != symbol.substr(dot + 1)) continue;
    parameter->unit = p.unit;
    parameter->low = p.low;
    parameter->high = p.high;
  }
}

/// A number of the links of some corners; none where one of them lacks it.
std::optional<WagonParameter> MakeOfLinks(const std::string& name, const Corners& corners, Direction direction,
                                          const std::string& symbol, const WagonInputs& inputs) {
  WagonInputs copy = inputs;
  std::optional<double> value;
  for (std::size_t corner = 0; corner < kCorners; ++corner) {
    if (!corners[corner]) continue;
    DirectionParameters& link = LinkOf(&copy, corner, direction);
    const std::vector<std::string> left_out = EffectsLeftOut(link);
    if (std::ranges::find(left_out, symbol.substr(0, symbol.find('.'))) != left_out.end()) return std::nullopt;
    const double* const found = FindParameter(&link, symbol);
    if (found == nullptr) return std::nullopt;
    if (value && *value != *found)
      throw UsageError(
          fmt::format("--parameter {}: expected corners that have it in common, found {:g} and {:g}; name the corners, "
                      "front.{}",
                      name, *value, *found, name));
    value = *found;
  }
  WagonParameter parameter{.name = name, .unit = "", .value = *value, .set = {}};
  Describe(symbol, &parameter);
  parameter.set = [corners, direction, symbol](double changed, WagonInputs* target) {
    for (std::size_t corner = 0; corner < kCorners; ++corner)
      if (corners[corner]) *FindParameter(&LinkOf(target, corner, direction), symbol) = changed;
  };
  return parameter;
}

/// "front-left.lateral.k1" in its parts; none where it has another form.
std::optional<WagonParameter> FindOfLinks(const std::string& name, const WagonInputs& inputs) {
  Corners corners = kAllCorners;
  std::string_view rest = name;
  const auto take = [&rest] {
    const std::size_t dot = rest.find('.');
    const std::string word(rest.substr(0, dot));
    rest.remove_prefix(dot == std::string_view::npos ? rest.size() : dot + 1);
    return word;
  };
  std::string word = take();
  if (const std::optional<Corners> place = FindCorners(word)) {
    corners = *place;
    word = take();
  }
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal})
    if (word == Name(direction) && !rest.empty())
      return MakeOfLinks(name, corners, direction, std::string(rest), inputs);
  return std::nullopt;
}

std::vector<std::string> ListSymbols(const DirectionParameters& link) {
  std::vector<std::string> symbols = ParameterSymbols(static_cast<int>(link.sliders.size()));
  for (const EffectValues& effect : link.effects)
    for (const auto& [symbol, value] : effect.parameters) symbols.push_back(effect.id + "." + symbol);
  return symbols;
}

}  // namespace

std::vector<WagonParameter> ListWagonParameters(const WagonInputs& inputs) {
  std::vector<WagonParameter> parameters;
  for (const Direction direction : {Direction::kLateral, Direction::kLongitudinal}) {
    WagonInputs copy = inputs;
    for (const std::string& symbol : ListSymbols(LinkOf(&copy, 0, direction))) {
      try {
        if (auto found = FindOfLinks(fmt::format("{}.{}", Name(direction), symbol), inputs))
          parameters.push_back(std::move(*found));
      } catch (const UsageError&) {  // corners differ in it
      }
    }
  }
  for (const OwnPlace& own : kOwnPlaces) parameters.push_back(MakeOwn(own, inputs));
  if (auto cargo = MakeCargoMass(inputs)) parameters.push_back(std::move(*cargo));
  return parameters;
}

WagonParameter FindWagonParameter(const WagonInputs& inputs, const std::string& name) {
  if (auto found = FindOfLinks(name, inputs)) return std::move(*found);
  if (std::ranges::find(kOfContact, name) != kOfContact.end())
    throw UsageError(
        fmt::format("--parameter {}: it acts through the contact table, which is computed anew for every value and has "
                    "no derivative by it; a campaign of `wagon sweep` varies it",
                    name));
  std::vector<std::string> names;
  for (WagonParameter& parameter : ListWagonParameters(inputs)) {
    if (parameter.name == name) return std::move(parameter);
    names.push_back(parameter.name);
  }
  throw UsageError(fmt::format("--parameter {}: expected one of {}{}", name, fmt::join(names, ", "),
                               name == "cargo_mass_kg" ? "; there is no cargo" : ""));
}

WagonFamily FamilyByParameter(const WagonInputs& inputs, const WagonParameter& parameter, double speed, double low,
                              double high) {
  const double step = kStep * std::max(std::abs(low), std::abs(high));
  if (!(low - step > parameter.low && high + step < parameter.high && low < high))
    throw UsageError(fmt::format("--range: expected {:g} < LOW < HIGH{} [{}] of {}, found {:g},{:g}", parameter.low,
                                 parameter.high < kInfinite ? fmt::format(" < {:g}", parameter.high) : "",
                                 parameter.unit, parameter.name, low, high));
  const auto contact = std::make_shared<const ContactCurve>(inputs.table);
  const auto nominal = std::make_shared<WagonInputs>(inputs);
  nominal->table = {};  // not to be copied each time
  const auto make = [contact, nominal, set = parameter.set](double value) {
    WagonInputs changed = *nominal;
    set(value, &changed);
    return std::make_shared<const Wagon>(changed.data, changed.body, changed.loaded, changed.links, *contact,
                                         changed.choice.options);
  };
  return {.name = parameter.name,
          .unit = parameter.unit,
          .make = make,
          .varies_speed = false,
          .speed = speed,
          .step = step};
}

}  // namespace uiclink
