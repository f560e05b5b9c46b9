#include "vehicle/contact/contact_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

using Rule = ContactColumn::Rule;

bool Obeys(Rule rule, double value) {
  if (rule == Rule::kPositive) return value > 0;
  if (rule == Rule::kAngle) return std::abs(value) < std::numbers::pi / 2;
  return true;
}

std::string Describe(Rule rule) {
  if (rule == Rule::kPositive) return "a number > 0";
  if (rule == Rule::kAngle) return "an angle between -pi/2 and pi/2 [rad]";
  return "a finite number";
}

std::vector<std::string_view> Split(std::string_view line) {
  constexpr std::string_view kBlanks = " \t";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(kBlanks); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::string_view Trim(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
}

/// A finite number with nothing behind it, whatever the locale.
std::optional<double> ParseNumber(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// What a message quotes of a file that may be anything.
std::string Quote(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string quoted = "\"";
  for (const char c : text.substr(0, kLongest)) {
    const auto byte = static_cast<unsigned char>(c);
    quoted += byte < 0x20 || byte >= 0x7f ? '?' : c;
  }
  return quoted + (text.size() > kLongest ? "...\"" : "\"");
}

class TableParser {
 public:
  explicit TableParser(std::string file) : file_(std::move(file)) {}

  ContactTable Parse(std::string_view text) {
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    while (!text.empty()) {
      ++line_;
      const std::size_t end = std::min(text.find('\n'), text.size());
      std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (line.ends_with('\r')) line.remove_suffix(1);
      ParseLine(Trim(line));
    }
    CheckWhole();
    if (!faults_.empty()) ThrowFaults();
    return std::move(table_);
  }

 private:
  void ParseLine(std::string_view line) {
    if (line.empty()) return;
    if (line.front() == '#') {
      ParseComment(line.substr(1));
    } else if (columns_.empty()) {
      ParseHead(Split(line));
    } else {
      ParseRow(Split(line));
    }
  }

  /// "# key: value" with one of our keys; any other comment is left alone.
  void ParseComment(std::string_view comment) {
    const std::size_t colon = comment.find(':');
    if (colon == std::string_view::npos) return;
    const std::string_view key = Trim(comment.substr(0, colon));
    const std::string_view value = Trim(comment.substr(colon + 1));
    if (key != "name" && key != "r0" && key != "shear_modulus") return;
    if (!keys_.emplace(std::string(key), line_).second) {
      Fault(line_, fmt::format("expected \"# {}:\" once, found it again", key));
    } else if (key == "name") {
      table_.name = value;
    } else {
      const std::optional<double> number = ParseNumber(value);
      if (!number || *number <= 0) Fault(line_, fmt::format("expected {} > 0, found {}", key, Quote(value)));
      (key == "r0" ? table_.r0 : table_.shear_modulus) = number.value_or(0);
    }
  }

  void ParseHead(const std::vector<std::string_view>& names) {
    std::map<std::string_view, int> seen;
    for (const std::string_view name : names) {
      const auto* const known = std::ranges::find(kContactColumns, name, &ContactColumn::name);
      columns_.push_back(known == kContactColumns.end() ? nullptr : known);
      if (known == kContactColumns.end())
        Fault(line_, fmt::format("expected the name of a column, found {}", Quote(name)));
      else if (++seen[name] == 2)
        Fault(line_, fmt::format("expected every column once, found \"{}\" again", name));
    }
    for (const ContactColumn& column : kContactColumns) {
      if (!seen.contains(column.name)) Fault(line_, fmt::format("expected a column \"{}\", found none", column.name));
    }
  }

  void ParseRow(const std::vector<std::string_view>& cells) {
    if (cells.size() != columns_.size()) {
      Fault(line_, fmt::format("expected {} numbers, found {}", columns_.size(), cells.size()));
      return;
    }
    ContactRow row;
    bool good = true;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (columns_[i] == nullptr) continue;
      const ContactColumn& column = *columns_[i];
      const std::optional<double> value = ParseNumber(cells[i]);
      if (value && Obeys(column.rule, *value)) {
        row.*column.value = *value;
      } else {
        good = false;
        Fault(line_, fmt::format("expected {} as {}, found {}", Describe(column.rule), column.name, Quote(cells[i])));
      }
    }
    if (!good) return;
    CheckOrder(row.y);
    table_.rows.push_back(row);
  }

  void CheckOrder(double y) {
    const std::vector<ContactRow>& rows = table_.rows;
    if (rows.empty()) return;
    if (y < rows.back().y) {
      Fault(line_, fmt::format("expected rows by increasing y, found {} after {}", y, rows.back().y));
    } else if (rows.size() > 1 && y == rows.back().y && y == rows[rows.size() - 2].y) {
      Fault(line_, fmt::format("expected at most two rows at one y, found a third at {}", y));
    }
  }

  void CheckWhole() {
    for (const char* key : {"name", "r0", "shear_modulus"}) {
      if (!keys_.contains(key)) Fault(0, fmt::format("expected a line \"# {}: ...\", found none", key));
    }
    if (columns_.empty()) Fault(0, "expected a row with the names of the columns, found none");
    if (!faults_.empty()) return;
    if (table_.rows.size() < 2) {
      Fault(0, fmt::format("expected two rows or more, found {}", table_.rows.size()));
    } else if (table_.rows.front().y >= 0 || table_.rows.back().y <= 0) {
      Fault(0, fmt::format("expected y on both sides of zero (the right wheel is the left one at -y), found {} to {}",
                           table_.rows.front().y, table_.rows.back().y));
    }
  }

  void Fault(int line, std::string message) { faults_.emplace_back(line, std::move(message)); }

  [[noreturn]] void ThrowFaults() const {
    constexpr std::size_t kMostShown = 20;
    std::string text = faults_.front().second;
    for (std::size_t i = 1; i < std::min(faults_.size(), kMostShown); ++i) {
      const auto& [line, message] = faults_[i];
      text += line > 0 ? fmt::format("\n{}:{}: {}", file_, line, message) : fmt::format("\n{}: {}", file_, message);
    }
    if (faults_.size() > kMostShown) text += fmt::format("\n{}: and {} more", file_, faults_.size() - kMostShown);
    throw InputError(file_, faults_.front().first, text);
  }

  std::string file_;
  int line_ = 0;
  ContactTable table_;
  std::map<std::string, int> keys_;            ///< those met, with their lines
  std::vector<const ContactColumn*> columns_;  ///< in the order of the file; null for unknown ones
  std::vector<std::pair<int, std::string>> faults_;
};

}  // namespace

ContactTable ParseContactTable(std::string_view text, const std::string& file) { return TableParser(file).Parse(text); }

ContactTable ReadContactTable(const std::filesystem::path& path) {
  return ParseContactTable(ReadFileWhole(path), path.string());
}

std::string FormatContactTable(const ContactTable& table) {
  std::string text =
      "# Contact of the left wheel over the lateral displacement y of the wheelset; the right wheel is the left "
      "one at -y, mirrored.\n# SI units, angles in rad. Two rows at one y: the contact jumps. Format: "
      "data/README.md.\n";
  text += fmt::format("# name: {}\n# r0: {}\n# shear_modulus: {}\n", table.name, table.r0, table.shear_modulus);
  for (const ContactColumn& column : kContactColumns) fmt::format_to(std::back_inserter(text), " {:>23}", column.name);
  text += '\n';
  for (const ContactRow& row : table.rows) {
    for (const ContactColumn& column : kContactColumns)
      fmt::format_to(std::back_inserter(text), " {:>23}", row.*column.value);
    text += '\n';
  }
  // One set of rules for both ways: what cannot be read must not be written.
  try {
    if (ParseContactTable(text, "FormatContactTable").name != table.name) throw InputError("name", 0, "not one line");
  } catch (const InputError& error) {
    throw std::invalid_argument(std::string("FormatContactTable: not a valid contact table; in its text,\n") +
                                error.what());
  }
  return text;
}

}  // namespace uiclink
