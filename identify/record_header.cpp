// What files say about themselves: units, `key: value`, names; and the words and numbers that all readers share.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

#include "data/input_error.h"
#include "identify/record_parts.h"

namespace uiclink::record_parts {
namespace {

constexpr std::array kUnits = {
    Unit{"mm", 1e-3, false},  Unit{"cm", 1e-2, false},   Unit{"m", 1.0, false},
    Unit{"um", 1e-6, false},  Unit{"in", 0.0254, false},  // international inch, exact
    Unit{"mrad", 1e-3, true}, Unit{"rad", 1.0, true},    Unit{"deg", std::numbers::pi / 180, true},
};

struct Alias {
  std::string_view spelling;
  std::string_view name;
};

constexpr std::array kUnitAliases = {
    Alias{"\xC2\xB5m", "um"},  // U+00B5 micro sign
    Alias{"\xCE\xBCm", "um"},  // U+03BC Greek mu
    Alias{"\xB5m", "um"},      // Latin-1
    Alias{"micron", "um"},     Alias{"inch", "in"},     Alias{"\"", "in"},
    Alias{"metre", "m"},       Alias{"meter", "m"},     Alias{"millimetre", "mm"},
    Alias{"millimeter", "mm"}, Alias{"degrees", "deg"}, Alias{"\xC2\xB0", "deg"},
};

constexpr std::array kKeyAliases = {
    Alias{"sample_rate", "sampling_hz"},    Alias{"sampling_rate", "sampling_hz"},
    Alias{"sample_rate_hz", "sampling_hz"}, Alias{"sampling_rate_hz", "sampling_hz"},
    Alias{"rate_hz", "sampling_hz"},        Alias{"fs", "sampling_hz"},
    Alias{"unit", "displacement_unit"},
};

// Keys that begin like ours but are not: what the user probably meant.
constexpr std::array kNearMisses = {
    Alias{"mass", "mass_kg"},     Alias{"dir", "direction"},          Alias{"sampl", "sampling_hz"},
    Alias{"freq", "sampling_hz"}, Alias{"disp", "displacement_unit"}, Alias{"gravity", "g"},
};

template <std::size_t n>
std::string_view Resolve(const std::array<Alias, n>& aliases, std::string_view spelling) {
  const auto it = std::find_if(aliases.begin(), aliases.end(), [&](const Alias& a) { return a.spelling == spelling; });
  return it == aliases.end() ? spelling : it->name;
}

char LowerChar(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool IsLetter(char c) { return LowerChar(c) >= 'a' && LowerChar(c) <= 'z'; }

// "378.2 kg": a number above 0, with or without the unit that the key implies.
double PositiveValue(std::string_view value, std::string_view what, std::string_view unit, const std::string& file,
                     int line) {
  std::string_view digits = value;
  if (digits.size() > unit.size() && Lower(digits.substr(digits.size() - unit.size())) == Lower(unit)) {
    digits = Trim(digits.substr(0, digits.size() - unit.size()));
  }
  const std::optional<double> number = ParseNumber(digits);
  if (!number || !(*number > 0) || !std::isfinite(*number)) {
    throw InputError(file, line, fmt::format("expected {} in {} above 0, found {}", what, unit, Quote(value)));
  }
  return *number;
}

Direction DirectionValue(std::string_view value, const std::string& file, int line) {
  const std::string word = Lower(value);
  if (word == Name(Direction::kLateral)) return Direction::kLateral;
  if (word == Name(Direction::kLongitudinal)) return Direction::kLongitudinal;
  throw InputError(file, line, fmt::format("expected direction lateral or longitudinal, found {}", Quote(value)));
}

const Unit* UnitValue(std::string_view value, const std::string& file, int line) {
  if (const Unit* unit = FindUnit(value)) return unit;
  throw InputError(file, line,
                   fmt::format("expected a displacement unit ({}), found {}", DisplacementUnits(), Quote(value)));
}

void NoticeNearMiss(std::string_view key, int line, Header* header) {
  for (const Alias& near : kNearMisses) {
    if (key.starts_with(near.spelling)) {
      header->notices.push_back(fmt::format("{}header key {} is not used; did you mean \"{}\"?",
                                            line > 0 ? fmt::format("line {}: ", line) : "", Quote(key), near.name));
      return;
    }
  }
}

bool ContainsWord(std::string_view text, std::string_view word) {
  for (std::size_t at = text.find(word); at != std::string_view::npos; at = text.find(word, at + 1)) {
    const bool starts = at == 0 || !IsLetter(text[at - 1]);
    const std::size_t end = at + word.size();
    if (starts && (end == text.size() || !IsLetter(text[end]))) return true;
  }
  return false;
}

}  // namespace

const Unit* FindUnit(std::string_view name) {
  const std::string lower = Lower(Trim(name));
  const std::string_view resolved = Resolve(kUnitAliases, lower);
  const auto it = std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& unit) { return unit.name == resolved; });
  return it == kUnits.end() ? nullptr : &*it;
}

void SetHeaderKey(std::string_view key, std::string_view value, const std::string& file, int line, Header* header) {
  std::string lower = Lower(Trim(key));
  std::replace(lower.begin(), lower.end(), ' ', '_');
  const std::string_view name = Resolve(kKeyAliases, lower);
  value = Trim(value);
  if (name == "direction") {
    header->direction = DirectionValue(value, file, line);
  } else if (name == "mass_kg") {
    header->mass_kg = PositiveValue(value, "a mass", "kg", file, line);
  } else if (name == "g") {
    header->g = PositiveValue(value, "an acceleration of gravity", "m/s^2", file, line);
  } else if (name == "sampling_hz") {
    header->sampling_hz = PositiveValue(value, "a sampling rate", "Hz", file, line);
  } else if (name == "missing_samples") {
    const std::optional<double> number = ParseNumber(value);
    if (!number || !(*number >= 0)) {
      throw InputError(file, line, fmt::format("expected a number of missing samples, found {}", Quote(value)));
    }
    header->samples_missing = *number > 0;
  } else if (name == "displacement_unit") {
    header->unit = UnitValue(value, file, line);
  } else if (name == "source") {
    header->source = std::string(value);
  } else {
    NoticeNearMiss(lower, line, header);
  }
}

int SampleLines::LineOf(std::size_t sample) const {
  const auto after = std::upper_bound(runs_.begin(), runs_.end(), sample,
                                      [](std::size_t s, const Run& run) { return s < run.sample; });
  if (after == runs_.begin()) return 0;
  const Run& run = *std::prev(after);
  return run.line + static_cast<int>(sample - run.sample);
}

ColumnChoice ChooseColumns(int columns, const ReadOptions& options, const std::string& file, int line) {
  ColumnChoice choice{.time = columns > 1 ? 1 : 0, .value = columns > 1 ? 2 : 1};
  if (!options.column) return choice;
  choice.value = *options.column;
  if (choice.value > columns) {
    throw InputError(file, line,
                     fmt::format("expected a displacement in column {} (--column {}), found {} column{}", choice.value,
                                 choice.value, columns, columns == 1 ? "" : "s"));
  }
  if (options.rate_hz) choice.time = 0;  // the user knows both: whatever the first column is, it is not needed
  if (choice.time == choice.value) {
    throw InputError(file, line,
                     "expected the displacement beside the time in column 1, found --column 1; give the "
                     "sampling rate as well (--rate HZ) if the file has no time column");
  }
  return choice;
}

std::optional<double> ParseNumber(std::string_view field) {
  if (!field.empty() && field.front() == '+') {  // from_chars takes no plus sign
    field.remove_prefix(1);
    if (!field.empty() && (field.front() == '-' || field.front() == '+')) return std::nullopt;
  }
  const char* const end = field.data() + field.size();
  double number = 0;
  const auto [stop, error] = std::from_chars(field.data(), end, number);
  if (error == std::errc() && stop == end) return number;
  if (error == std::errc::result_out_of_range) {
    // 1e-400 is a small number, 1e400 is none. The exponent's sign tells them apart.
    const bool tiny = field.find("e-") != std::string_view::npos || field.find("E-") != std::string_view::npos;
    return stop == end && tiny ? std::optional(0.0) : std::nullopt;
  }

  // Second spelling: decimal comma, Fortran's exponent D.
  std::array<char, 64> buffer;
  if (field.empty() || field.size() > buffer.size() || field.find_first_of(",Dd") == std::string_view::npos) {
    return std::nullopt;
  }
  if (field.find(',') != std::string_view::npos && field.find('.') != std::string_view::npos) return std::nullopt;
  std::transform(field.begin(), field.end(), buffer.begin(), [](char c) {
    return c == ',' ? '.' : (c == 'D' || c == 'd') ? 'e' : c;
  });
  const char* const buffer_end = buffer.data() + field.size();
  const auto again = std::from_chars(buffer.data(), buffer_end, number);
  return again.ec == std::errc() && again.ptr == buffer_end ? std::optional(number) : std::nullopt;
}

std::string_view Trim(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), LowerChar);
  return lower;
}

std::string Quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string quoted = "\"";
  for (const char c : text.substr(0, kLongest)) {
    if (c >= ' ' && c <= '~') {
      quoted += c;
    } else {
      quoted += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  return quoted + (text.size() > kLongest ? "...\"" : "\"");
}

std::optional<Direction> DirectionInName(std::string_view name) {
  const std::string lower = Lower(name);
  const bool lateral = ContainsWord(lower, Name(Direction::kLateral));
  const bool longitudinal = ContainsWord(lower, Name(Direction::kLongitudinal));
  if (lateral == longitudinal) return std::nullopt;
  return lateral ? Direction::kLateral : Direction::kLongitudinal;
}

}  // namespace uiclink::record_parts

namespace uiclink {

std::string DisplacementUnits() {
  std::string names;
  for (const record_parts::Unit& unit : record_parts::kUnits) {
    if (!names.empty()) names += ", ";
    names += unit.name;
  }
  return names;
}

}  // namespace uiclink
