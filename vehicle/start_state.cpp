#include "vehicle/start_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>

#include "vehicle/equilibrium.h"
#include "vehicle/state_file.h"
#include "vehicle/wagon_inputs.h"

namespace uiclink {
namespace {

/// Unit -> SI.
using Units = std::map<std::string, double>;

struct Place {
  double Perturbation::*value;
  const Units* units;
  double most;        ///< [m] or [rad]: no wagon stands beyond
  const char* words;  ///< `most` for messages
};

// The equations of motion are linear in the angles.
constexpr double kMostLength = 0.2, kMostAngle = 0.1;
constexpr const char* kLengthWords = "at most 200 mm to either side";
constexpr const char* kAngleWords = "at most 100 mrad to either side";

const std::map<std::string, Place>& Places() {
  static const Units lengths{{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};
  static const Units angles{{"mrad", 1e-3}, {"rad", 1}, {"deg", std::numbers::pi / 180}};
  static const std::map<std::string, Place> places{
      {"front_lateral", {&Perturbation::front_y, &lengths, kMostLength, kLengthWords}},
      {"rear_lateral", {&Perturbation::rear_y, &lengths, kMostLength, kLengthWords}},
      {"body_lateral", {&Perturbation::body_y, &lengths, kMostLength, kLengthWords}},
      {"body_roll", {&Perturbation::body_phi, &angles, kMostAngle, kAngleWords}},
      {"body_yaw", {&Perturbation::body_psi, &angles, kMostAngle, kAngleWords}},
      {"front_yaw", {&Perturbation::front_psi, &angles, kMostAngle, kAngleWords}},
      {"rear_yaw", {&Perturbation::rear_psi, &angles, kMostAngle, kAngleWords}}};
  return places;
}

template <typename T>
std::string Keys(const std::map<std::string, T>& map) {
  std::string list;
  for (const auto& [key, value] : map) list += (list.empty() ? "" : ", ") + key;
  return list;
}

std::string Trim(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' '), last = text.find_last_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

[[noreturn]] void Throw(const std::string& part, const std::string& expected) {
  throw UsageError(fmt::format("--start: expected {}, found \"{}\"", expected, part));
}

double ParseQuantity(const std::string& part, const std::string& text, const Place& place) {
  const Units& units = *place.units;
  const std::string digits = text.starts_with('+') ? text.substr(1) : text;
  double value = 0;
  const char* const end = digits.data() + digits.size();
  const auto [rest, error] = std::from_chars(digits.data(), end, value);
  const auto unit = units.find(Trim(std::string(rest, end)));
  if (error != std::errc() || !std::isfinite(value) || unit == units.end()) {
    Throw(part, "a number with its unit (" + Keys(units) + ")");
  }
  if (!(std::abs(value * unit->second) <= place.most)) Throw(part, place.words);
  return value * unit->second;
}

bool IsFile(const std::string& text) {
  std::error_code ignored;
  return text != "equilibrium" && (text.find('=') == std::string::npos || std::filesystem::exists(text, ignored));
}

/// A wheelset beyond the contact table is on no rail.
void CheckOnRails(const Wagon& wagon, const WagonState& state, const std::string& start) {
  const double reach = std::min(-wagon.contact.y_min(), wagon.contact.y_max());
  for (const double y : {state.x[wheelset::kY], state.x[kRearWheelset + wheelset::kY]}) {
    if (std::abs(y) < reach) continue;
    throw UsageError(
        fmt::format("--start: expected wheelsets within the contact table, {:g} mm to either side, "
                    "found one at {:g} mm after {}",
                    1e3 * reach, 1e3 * y, start));
  }
}

}  // namespace

Perturbation ParsePerturbation(const std::string& text) {
  Perturbation by;
  std::set<std::string> seen;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = Trim(text.substr(begin, end - begin));
    begin = end + 1;
    const std::size_t equals = part.find('=');
    const std::string name = Trim(part.substr(0, equals));
    const auto place = Places().find(name);
    if (equals == std::string::npos || place == Places().end())
      Throw(part, "PLACE=VALUE with PLACE one of " + Keys(Places()));
    if (!seen.insert(name).second) Throw(part, "each place once");
    by.*place->second.value = ParseQuantity(part, Trim(part.substr(equals + 1)), place->second);
  }
  return by;
}

RunStart MakeRunStart(const std::string& text, const Wagon& wagon, double V) {
  if (IsFile(text)) {
    RunStart start{ReadStateFile(text, wagon, "").state, "the state of " + text};
    start.state.t = 0;
    return start;
  }
  if (text == "equilibrium") return {FindEquilibrium(wagon, V), "running equilibrium"};
  const Perturbation by = ParsePerturbation(text);  // before the equilibrium is looked for
  RunStart start{Perturb(wagon, FindEquilibrium(wagon, V), by), "running equilibrium with " + text};
  CheckOnRails(wagon, start.state, text);
  return start;
}

void CheckRunStart(const std::string& text) {
  if (text != "equilibrium" && !IsFile(text)) ParsePerturbation(text);
}

}  // namespace uiclink
