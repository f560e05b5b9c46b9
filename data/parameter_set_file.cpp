#include "data/parameter_set_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>
#include <vector>

#include "data/file.h"
#include "data/input_error.h"
#include "data/table.h"

namespace uiclink {
namespace {

constexpr Direction kDirections[] = {Direction::kLateral, Direction::kLongitudinal};

/// Every name that std and covariance may use: the plain model's symbols, then "effect.symbol".
std::vector<std::string> AllSymbols(const DirectionParameters& parameters) {
  std::vector<std::string> symbols = ParameterSymbols(static_cast<int>(parameters.sliders.size()));
  for (const EffectValues& effect : parameters.effects) {
    for (const auto& [symbol, value] : effect.parameters) symbols.push_back(effect.id + "." + symbol);
  }
  return symbols;
}

// --- reading ---

Slider<double> ReadSlider(Table table) {
  Slider<double> slider;
  slider.k = table.Number("k", Range::Positive("1/m"));
  slider.T0 = table.Number("T0", Range::NotNegative("-"));
  return slider;
}

EffectValues ReadEffect(Table table) {
  EffectValues effect{.id = table.String("id"), .parameters = {}};
  for (const std::string& key : table.Keys()) {
    if (key == "id") continue;
    effect.parameters.emplace_back(key, table.Number(key, Range::Any("unit of the effect")));
  }
  return effect;
}

/// "effect.symbol" must name one parameter.
void CheckEffectsDiffer(Table& table, const std::vector<EffectValues>& effects) {
  std::set<std::string> seen;
  for (const EffectValues& effect : effects) {
    if (!seen.insert(effect.id).second) {
      table.Report("effects", "every effect once", fmt::format("\"{}\" twice", effect.id));
    }
  }
}

void CheckOrder(Table& table, const std::vector<std::string>& order, const std::vector<std::string>& symbols) {
  std::set<std::string> seen;
  for (const std::string& symbol : order) {
    const bool known = std::find(symbols.begin(), symbols.end(), symbol) != symbols.end();
    if (!known) table.Report("order", fmt::format("names among {}", fmt::join(symbols, ", ")), '"' + symbol + '"');
    if (!seen.insert(symbol).second) table.Report("order", "every parameter once", fmt::format("\"{}\" twice", symbol));
  }
}

/// Symmetric to 1e-9 of the geometric mean of the variances (a file may have been rounded); correlations within [-1, 1]
/// to the same slack; variances >= 0.
bool HasShape(Table& table, const Covariance& covariance) {
  const std::size_t n = covariance.order.size();
  if (covariance.matrix.size() != n) {
    table.Report("matrix", fmt::format("{} rows as in order", n), fmt::format("{}", covariance.matrix.size()));
    return false;
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t found = covariance.matrix[i].size();
    if (found == n) continue;
    table.Report("matrix", fmt::format("{} numbers in row {}", n, i + 1), fmt::format("{}", found));
    return false;
  }
  return true;
}

bool HasVariances(Table& table, const Covariance& covariance) {
  bool good = true;
  for (std::size_t i = 0; i < covariance.order.size(); ++i) {
    const double variance = covariance.matrix[i][i];
    if (!(variance < 0)) continue;  // NaN stands for a fault that has been noted
    table.Report("matrix", "a variance >= 0 of " + covariance.order[i], fmt::format("{}", variance));
    good = false;
  }
  return good;
}

/// Symmetric to 1e-9 of the geometric mean of the variances (a file may have been rounded); correlations within [-1, 1]
/// to the same slack.
void CheckMatrix(Table& table, const Covariance& covariance) {
  constexpr double kSlack = 1e-9;
  if (!HasShape(table, covariance) || !HasVariances(table, covariance)) return;
  const auto& m = covariance.matrix;
  for (std::size_t i = 0; i < m.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double scale = std::sqrt(m[i][i]) * std::sqrt(m[j][j]);
      const std::string pair = fmt::format("{}, {}", covariance.order[i], covariance.order[j]);
      if (std::abs(m[i][j] - m[j][i]) > kSlack * scale) {
        table.Report("matrix", "a symmetric matrix", fmt::format("{} and {} for {}", m[i][j], m[j][i], pair));
      } else if (std::abs(m[i][j]) > (1 + kSlack) * scale) {
        table.Report("matrix", fmt::format("a covariance of {} within +-{}", pair, scale), fmt::format("{}", m[i][j]));
      }
    }
  }
}

/// A table of numbers >= 0 by symbol.
std::map<std::string, double> ReadBySymbol(Table table, const std::vector<std::string>& symbols) {
  std::map<std::string, double> values;
  for (const std::string& symbol : symbols) {
    if (const auto value = table.OptionalNumber(symbol, Range::NotNegative("unit of the parameter")))
      values[symbol] = *value;
  }
  return values;
}

Covariance ReadCovariance(Table table, const std::vector<std::string>& symbols) {
  Covariance covariance{.order = table.Strings("order"),
                        .matrix = table.Rows("matrix", Range::Any("product of units")),
                        .coverage = table.OptionalNumber("coverage", Range::Positive("standard deviations"))};
  if (const std::optional<Table> spread = table.OptionalTable("spread"))
    covariance.spread = ReadBySymbol(*spread, symbols);
  CheckOrder(table, covariance.order, symbols);
  if (table.Has("order") && table.Has("matrix")) CheckMatrix(table, covariance);
  return covariance;
}

DirectionParameters ReadDirection(Table table) {
  DirectionParameters parameters;
  parameters.k = table.Number("k", Range::Positive("1/m"));
  for (const Table& slider : table.Tables("sliders")) parameters.sliders.push_back(ReadSlider(slider));
  for (const Table& effect : table.OptionalTables("effects")) parameters.effects.push_back(ReadEffect(effect));
  CheckEffectsDiffer(table, parameters.effects);
  const std::vector<std::string> symbols = AllSymbols(parameters);
  if (const std::optional<Table> std = table.OptionalTable("std")) parameters.std = ReadBySymbol(*std, symbols);
  if (std::optional<Table> covariance = table.OptionalTable("covariance")) {
    parameters.covariance = ReadCovariance(*covariance, symbols);
  }
  return parameters;
}

// --- writing ---

/// Shortest text that reads back as the same double, always a TOML float.
std::string Text(double value) {
  std::string text = fmt::format("{}", value);
  if (std::isfinite(value) && text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string Texts(const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(Text(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

/// A TOML basic string.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string Key(const std::string& key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' || c == '-';
  });
  return bare ? key : Quoted(key);
}

std::string FormatSliders(const std::vector<Slider<double>>& sliders) {
  if (sliders.empty()) return "sliders = []\n";
  std::string text = "sliders = [  # k: 1/m, divided by M g; T0: -, divided by M g\n";
  for (const Slider<double>& slider : sliders)
    text += fmt::format("  {{ k = {}, T0 = {} }},\n", Text(slider.k), Text(slider.T0));
  return text + "]\n";
}

std::string FormatEffects(const std::vector<EffectValues>& effects) {
  if (effects.empty()) return "";
  std::string text = "effects = [  # beside the plain model; units: identify effects\n";
  for (const EffectValues& effect : effects) {
    text += "  { id = " + Quoted(effect.id);
    for (const auto& [symbol, value] : effect.parameters) text += fmt::format(", {} = {}", Key(symbol), Text(value));
    text += " },\n";
  }
  return text + "]\n";
}

/// "{ k = 0.1, k1 = 0.2 }"
std::string FormatBySymbol(const DirectionParameters& parameters, const std::map<std::string, double>& values) {
  std::vector<std::string> known =
      AllSymbols(parameters);  // order of the file; strangers last, where reading back finds them
  for (const auto& [symbol, value] : values) {
    if (std::find(known.begin(), known.end(), symbol) == known.end()) known.push_back(symbol);
  }
  std::vector<std::string> entries;
  for (const std::string& symbol : known) {
    const auto value = values.find(symbol);
    if (value != values.end()) entries.push_back(Key(symbol) + " = " + Text(value->second));
  }
  return fmt::format("{{ {} }}", fmt::join(entries, ", "));
}

std::string FormatStd(const DirectionParameters& parameters) {
  if (parameters.std.empty()) return "";
  return fmt::format("std = {}  # standard deviations, units of the parameters\n",
                     FormatBySymbol(parameters, parameters.std));
}

std::string FormatCovariance(const DirectionParameters& parameters) {
  const std::optional<Covariance>& covariance = parameters.covariance;
  if (!covariance) return "";
  std::vector<std::string> order;
  for (const std::string& symbol : covariance->order) order.push_back(Quoted(symbol));
  std::string text = fmt::format("covariance = {{ order = [{}], ", fmt::join(order, ", "));
  if (covariance->coverage) text += fmt::format("coverage = {}, ", Text(*covariance->coverage));
  if (!covariance->spread.empty()) text += fmt::format("spread = {}, ", FormatBySymbol(parameters, covariance->spread));
  text += "matrix = [  # products of the parameters' units\n";
  for (const std::vector<double>& row : covariance->matrix) text += "  " + Texts(row) + ",\n";
  return text + "] }\n";
}

std::string FormatDirection(Direction direction, const DirectionParameters& parameters) {
  return fmt::format("\n[{}]\nk = {}  # 1/m, divided by M g\n", Name(direction), Text(parameters.k)) +
         FormatSliders(parameters.sliders) + FormatEffects(parameters.effects) + FormatStd(parameters) +
         FormatCovariance(parameters);
}

}  // namespace

ParameterSet ParseParameterSet(std::string_view text, const std::string& file) {
  Table table = Table::Parse(text, file);
  ParameterSet set;
  set.name = table.String("name");
  set.source = table.String("source");
  set.load_N = table.Number("load_N", Range::Positive("N"));
  set.g = table.OptionalNumber("g", Range::Positive("m/s^2")).value_or(kThesisGravity);
  for (const Direction direction : kDirections) {
    std::optional<Table> part = table.OptionalTable(Name(direction));
    if (!part) continue;
    (direction == Direction::kLateral ? set.lateral : set.longitudinal) = ReadDirection(*part);
  }
  if (!table.Has("lateral") && !table.Has("longitudinal")) {
    table.Report("", "a table [lateral] or [longitudinal]", "neither");
  }
  table.Finish();
  return set;
}

ParameterSet ReadParameterSet(const std::filesystem::path& path) {
  return ParseParameterSet(ReadFileWhole(path), path.string());
}

std::string FormatParameterSet(const ParameterSet& set) {
  std::string text =
      "# Parameters of a UIC link suspension for Piotrowski's dry-friction model. Format: data/README.md.\n";
  text += "name = " + Quoted(set.name) + "\n";
  text += "source = " + Quoted(set.source) + "\n";
  text += fmt::format("load_N = {}  # M g during the measurement [N]\n", Text(set.load_N));
  text += fmt::format("g = {}  # m/s^2, that the set was normalised with\n", Text(set.g));
  for (const Direction direction : kDirections) {
    if (set[direction]) text += FormatDirection(direction, *set[direction]);
  }
  // One set of rules for both ways: what cannot be read must not be written.
  try {
    ParseParameterSet(text, "FormatParameterSet");
  } catch (const InputError& error) {
    throw std::invalid_argument(std::string("FormatParameterSet: not a valid parameter set; in its text,\n") +
                                error.what());
  }
  return text;
}

void WriteParameterSet(const ParameterSet& set, const std::filesystem::path& path) {
  WriteFileWhole(path, FormatParameterSet(set));
}

}  // namespace uiclink
