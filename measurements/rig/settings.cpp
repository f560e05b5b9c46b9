#include <fmt/core.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string_view>

#include "measurements/rig/rig.h"

namespace uiclink::rig {
namespace {

/// The faults of one file, told in the order of its lines.
class Faults {
 public:
  explicit Faults(std::string file) : file_(std::move(file)) {}

  void Add(const toml::source_region& where, const std::string& message) {
    messages_.emplace(where.begin.line, message);
  }
  void ThrowIfAny() const {
    std::string text;
    for (const auto& [line, message] : messages_) {
      text += fmt::format("{}{}:{}: {}", text.empty() ? "" : "\n", file_, line, message);
    }
    if (!text.empty()) throw SettingsError(text);
  }

 private:
  std::string file_;
  std::multimap<toml::source_index, std::string> messages_;
};

enum class Need { kRequired, kOptional };

struct Range {
  double low = 0;
  double high = 0;
  bool open_low = false;  ///< low itself is out of range
};

constexpr Range kNotNegative{0, kNever};
constexpr Range kPositive{0, kNever, true};

std::string Describe(const Range& range) {
  if (std::isinf(range.high)) return fmt::format("{} {:g}", range.open_low ? ">" : ">=", range.low);
  return fmt::format("in {}{:g}, {:g}]", range.open_low ? "(" : "[", range.low, range.high);
}

std::string Show(const toml::node& node) {
  if (const auto word = node.value<std::string>()) return fmt::format("\"{}\"", *word);
  std::ostringstream text;
  node.visit([&](const auto& value) { text << value; });
  return text.str();
}

/// One table of the file. Remembers which keys were asked for; Finish() reports the others.
class Section {
 public:
  Section(const toml::table& table, std::string name, Faults& faults)
      : table_(table), name_(std::move(name)), faults_(faults) {}

  /// Reads `key` into `value`, multiplied by `scale` (the unit of the key in SI); `range` is in the unit of the key.
  void Number(std::string_view key, double& value, const Range& range, double scale = 1, Need need = Need::kOptional) {
    const toml::node* node = Find(key, need);
    if (node == nullptr) return;
    const std::optional<double> found = node->value<double>();
    const bool fits = found && *found >= range.low && *found <= range.high && !(range.open_low && *found == range.low);
    if (fits) {
      value = *found * scale;
    } else {
      Fault(*node, key, fmt::format("a number {}", Describe(range)));
    }
  }

  template <typename Integer>
  void Count(std::string_view key, Integer& value, std::int64_t low, std::int64_t high) {
    const toml::node* node = Find(key, Need::kOptional);
    if (node == nullptr) return;
    const std::optional<std::int64_t> found = node->value_exact<std::int64_t>();
    if (found && *found >= low && *found <= high) {
      value = static_cast<Integer>(*found);
    } else {
      Fault(*node, key, fmt::format("a whole number in [{}, {}]", low, high));
    }
  }

  /// Reads one of `words`; returns its place in the list, `fallback` when absent or wrong.
  std::size_t Word(std::string_view key, const std::vector<std::string>& words, Need need, std::size_t fallback = 0) {
    const toml::node* node = Find(key, need);
    if (node == nullptr) return fallback;
    const auto found = std::find(words.begin(), words.end(), node->value<std::string>().value_or(""));
    if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
    std::string list;
    for (const std::string& word : words) list += fmt::format("{}\"{}\"", list.empty() ? "" : " or ", word);
    Fault(*node, key, list);
    return fallback;
  }

  const toml::table* Table(std::string_view key, Need need = Need::kOptional) {
    const toml::node* node = Find(key, need);
    if (node == nullptr) return nullptr;
    if (node->as_table() == nullptr) Fault(*node, key, "a table");
    return node->as_table();
  }

  const toml::array* Array(std::string_view key) {
    const toml::node* node = Find(key, Need::kRequired);
    if (node == nullptr) return nullptr;
    if (node->as_array() == nullptr) Fault(*node, key, "an array");
    return node->as_array();
  }

  void Finish() const {
    for (const auto& [key, node] : table_) {
      if (asked_.count(std::string(key.str())) > 0) continue;
      std::string known;
      for (const std::string& name : asked_) known += (known.empty() ? "" : ", ") + name;
      faults_.Add(node.source(),
                  fmt::format("expected one of the keys {} {}, found \"{}\"", known, Place(), key.str()));
    }
  }

 private:
  const toml::node* Find(std::string_view key, Need need) {
    asked_.insert(std::string(key));
    const toml::node* node = table_.get(key);
    if (node == nullptr && need == Need::kRequired) {
      faults_.Add(table_.source(), fmt::format("expected \"{}\" {}, found no such key", key, Place()));
    }
    return node;
  }
  void Fault(const toml::node& node, std::string_view key, const std::string& expected) {
    faults_.Add(node.source(), fmt::format("expected {} for \"{}\" {}, found {}", expected, key, Place(), Show(node)));
  }
  std::string Place() const { return name_.empty() ? "at the top of the file" : fmt::format("in [{}]", name_); }

  const toml::table& table_;
  std::string name_;
  Faults& faults_;
  std::set<std::string> asked_;
};

void ReadJoints(const toml::array& array, Link& link, Faults& faults) {
  for (const toml::node& node : array) {
    const toml::table* table = node.as_table();
    if (table == nullptr) {
      faults.Add(node.source(), fmt::format("expected a slider {{ k = .., T0 = .. }}, found {}", Show(node)));
      continue;
    }
    Joint joint;
    Section section(*table, "link.sliders", faults);
    section.Number("k", joint.k, kPositive, 1, Need::kRequired);
    section.Number("T0", joint.T0, kNotNegative, 1, Need::kRequired);
    section.Number("T_start", joint.T_start, {-joint.T0, joint.T0});
    section.Finish();
    link.joints.push_back(joint);
  }
}

void ReadLink(const toml::table& table, Link& link, Faults& faults) {
  Section section(table, "link", faults);
  section.Number("k", link.k, kPositive, 1, Need::kRequired);
  if (const toml::array* sliders = section.Array("sliders")) ReadJoints(*sliders, link, faults);
  section.Finish();
}

void ReadEffects(const toml::table& table, EffectSizes& sizes, Faults& faults) {
  Section effects(table, "effects", faults);
  for (const Effect& effect : AllEffects()) {
    const toml::table* entry = effects.Table(effect.id);
    if (entry == nullptr) continue;
    Section section(*entry, fmt::format("effects.{}", effect.id), faults);
    for (const EffectParameter& p : effect.parameters) {
      const bool is_size = &p == effect.parameters.data();
      section.Number(p.symbol, sizes.*p.value, {p.low, p.high}, 1, is_size ? Need::kRequired : Need::kOptional);
    }
    section.Finish();
  }
  effects.Finish();
}

void ReadScatter(const toml::table& table, Scatter& scatter, Faults& faults) {
  constexpr Range kShare{0, 0.2};  // beyond, some draws of a long series would no longer be links
  Section section(table, "scatter", faults);
  section.Number("k", scatter.k, kShare);
  section.Number("slider_k", scatter.joint_k, kShare);
  section.Number("slider_T0", scatter.joint_T0, kShare);
  section.Finish();
}

void ReadPush(const toml::table& table, Push& push, Faults& faults) {
  Section section(table, "push", faults);
  section.Number("rest_s", push.rest_s, kNotNegative);
  section.Count("half_swings", push.half_swings, 1, 1000);
  section.Number("first_extremum_mm", push.first_extremum, kPositive, 1e-3);
  section.Number("first_extremum_scatter_mm", push.first_extremum_scatter, kNotNegative, 1e-3);
  section.Number("release_before_extremum", push.release_before_extremum, {0, 0.24, true});
  const std::size_t first = section.Word("first_extremum_side", {"random", "positive", "negative"}, Need::kOptional,
                                         static_cast<std::size_t>(push.first));
  push.first = static_cast<Push::First>(first);
  section.Finish();
}

void ReadSensor(const toml::table& table, Sensor& sensor, Faults& faults) {
  Section section(table, "sensor", faults);
  section.Number("noise_mm", sensor.noise, kNotNegative, 1e-3);
  section.Number("zero_offset_mm", sensor.zero_offset, {-1000, 1000}, 1e-3);
  section.Number("zero_scatter_mm", sensor.zero_scatter, kNotNegative, 1e-3);
  section.Number("range_mm", sensor.range, kPositive, 1e-3);
  section.Count("bits", sensor.bits, 2, 32);
  section.Number("sampling_hz", sensor.sampling_hz, {10, 1e6});
  section.Count("keep_every", sensor.keep_every, 1, 100000);
  section.Finish();
}

Settings ReadDocument(const toml::table& document, Faults& faults) {
  const std::vector<std::string> directions{"lateral", "longitudinal"};
  Settings settings;
  Section top(document, "", faults);
  settings.direction = directions[top.Word("direction", directions, Need::kRequired)];
  top.Number("mass_kg", settings.mass_kg, kPositive);
  top.Number("g", settings.link.g, kPositive);
  top.Number("duration_s", settings.duration_s, {0, 3600, true});
  top.Count("records", settings.records, 1, 1000000);
  top.Count("seed", settings.seed, 0, std::numeric_limits<std::int64_t>::max());
  top.Count("steps_per_sample", settings.steps_per_sample, 1, 10000);
  if (const toml::table* table = top.Table("link", Need::kRequired)) ReadLink(*table, settings.link, faults);
  if (const toml::table* table = top.Table("effects")) ReadEffects(*table, settings.link.effects, faults);
  if (const toml::table* table = top.Table("scatter")) ReadScatter(*table, settings.scatter, faults);
  if (const toml::table* table = top.Table("push")) ReadPush(*table, settings.push, faults);
  if (const toml::table* table = top.Table("sensor")) ReadSensor(*table, settings.sensor, faults);
  top.Finish();
  return settings;
}

}  // namespace

Settings ParseSettings(const std::string& text, const std::string& file) {
  Faults faults(file);
  toml::table document;
  try {
    document = toml::parse(text);
  } catch (const toml::parse_error& error) {
    faults.Add(error.source(), fmt::format("expected TOML, found: {}", error.description()));
    faults.ThrowIfAny();
  }
  Settings settings = ReadDocument(document, faults);
  faults.ThrowIfAny();
  settings.name = std::filesystem::path(file).filename().string();
  return settings;
}

Settings ReadSettings(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::stringstream text;
  if (!std::filesystem::is_regular_file(path) || !(text << stream.rdbuf())) {
    throw SettingsError(fmt::format("{}: expected a settings file that can be read, found none", path.string()));
  }
  return ParseSettings(text.str(), path.string());
}

}  // namespace uiclink::rig
