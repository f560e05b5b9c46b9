#include "data/table.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <utility>

#include "data/file.h"
#include "data/input_error.h"

namespace uiclink {
namespace {

int LineOf(const toml::source_region& region) { return static_cast<int>(region.begin.line); }

/// What stands in the file, in words.
std::string Describe(const toml::node& node) {
  if (const auto* value = node.as_string()) return fmt::format("\"{}\"", value->get());
  if (const auto* value = node.as_integer()) return fmt::format("{}", value->get());
  if (const auto* value = node.as_floating_point()) return fmt::format("{}", value->get());
  if (const auto* value = node.as_boolean()) return value->get() ? "true" : "false";
  if (node.is_table()) return "a table";
  if (const auto* array = node.as_array()) return array->empty() ? "an empty array" : "an array";
  return "a date or time";
}

/// Levenshtein's distance: insertions, deletions and replacements of a character.
std::size_t CountEdits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

/// ` (did you mean "k"?)`, or the list of known keys where none is near.
std::string Hint(std::string_view key, const std::set<std::string, std::less<>>& known) {
  if (known.empty()) return " (no key is known here)";
  const auto nearest = std::min_element(known.begin(), known.end(), [key](const auto& a, const auto& b) {
    return CountEdits(key, a) < CountEdits(key, b);
  });
  // Two slips in a long word, one in a short one: beyond that a guess misleads.
  if (CountEdits(key, *nearest) <= std::min<std::size_t>(2, nearest->size() / 2))
    return fmt::format(" (did you mean \"{}\"?)", *nearest);
  return fmt::format(" (known: {})", fmt::join(known, ", "));
}

}  // namespace

// --- Range ---

bool Range::Contains(double value) const {
  return std::isfinite(value) && (low_included ? value >= low : value > low) &&
         (high_included ? value <= high : value < high);
}

std::string Range::Describe(std::string_view key) const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  const char* const above = low_included ? ">=" : ">";
  const char* const below = high_included ? "<=" : "<";
  if (has_low && has_high)
    return fmt::format("{} {} {} {} {} [{}]", low, low_included ? "<=" : "<", key, below, high, unit);
  if (has_low) return fmt::format("{} {} {} [{}]", key, above, low, unit);
  if (has_high) return fmt::format("{} {} {} [{}]", key, below, high, unit);
  return fmt::format("a finite number {} [{}]", key, unit);
}

// --- Document: the tree, what was asked for, what was wrong ---

struct Table::Document {
  struct Visit {
    const toml::table* table;
    std::string name;
    std::set<std::string, std::less<>> asked;
  };
  struct Fault {
    int line;
    std::string message;
  };

  std::string file;
  toml::table root;
  std::vector<Visit> visits;
  std::vector<Fault> faults;

  std::size_t Visit(const toml::table& table, std::string name) {
    visits.push_back({&table, std::move(name), {}});
    return visits.size() - 1;
  }

  int LineOfTable(std::size_t index) const { return index == 0 ? 0 : LineOf(visits[index].table->source()); }

  void AddFault(int line, const std::string& expected, const std::string& found) {
    faults.push_back({line, "expected " + expected + ", found " + found});
  }

  /// The node, or null; remembers that the key is known.
  const toml::node* Ask(std::size_t index, std::string_view key) {
    visits[index].asked.emplace(key);
    return visits[index].table->get(key);
  }

  const toml::node* AskRequired(std::size_t index, std::string_view key, const std::string& expected) {
    const toml::node* const node = Ask(index, key);
    const std::string& name = visits[index].name;
    if (!node) AddFault(LineOfTable(index), expected + (name.empty() ? "" : " in " + name), "nothing");
    return node;
  }

  double ToNumber(const toml::node& node, std::string_view key, const Range& range) {
    const std::optional<double> value = node.is_number() ? node.value<double>() : std::nullopt;
    if (value && range.Contains(*value)) return *value;
    std::string expected = range.Describe(key);
    if (value && !std::isfinite(*value) && expected[0] != 'a') expected += " and finite";
    AddFault(LineOf(node.source()), expected, Describe(node));
    return std::numeric_limits<double>::quiet_NaN();
  }

  std::optional<std::string> ToString(const toml::node& node, std::string_view key) {
    if (const auto* value = node.as_string()) return value->get();
    AddFault(LineOf(node.source()), fmt::format("{} = \"text\"", key), Describe(node));
    return std::nullopt;
  }

  std::optional<bool> ToBool(const toml::node& node, std::string_view key) {
    if (const auto* value = node.as_boolean()) return value->get();
    AddFault(LineOf(node.source()), fmt::format("{} = true or false", key), Describe(node));
    return std::nullopt;
  }

  /// The array, or null with a fault.
  const toml::array* ToArray(const toml::node& node, const std::string& expected) {
    if (const auto* array = node.as_array()) return array;
    AddFault(LineOf(node.source()), expected, Describe(node));
    return nullptr;
  }

  std::vector<double> ToNumbers(const toml::array& array, std::string_view key, const Range& range) {
    std::vector<double> numbers;
    for (const toml::node& element : array) {
      numbers.push_back(ToNumber(element, fmt::format("{}[{}]", key, numbers.size() + 1), range));
    }
    return numbers;
  }

  void AddUnknownKeys() {
    for (const struct Visit& visit : visits) {
      for (const auto& [key, node] : *visit.table) {
        if (visit.asked.contains(key.str())) continue;
        const std::string where = visit.name.empty() ? "" : " in " + visit.name;
        AddFault(LineOf(key.source()), "a known key" + where,
                 fmt::format("\"{}\"{}", key.str(), Hint(key.str(), visit.asked)));
      }
    }
  }
};

// --- Table ---

Table Table::Read(const std::filesystem::path& path) { return Parse(ReadFileWhole(path), path.string()); }

Table Table::Parse(std::string_view text, const std::string& file) {
  auto document = std::make_shared<Document>();
  document->file = file;
  try {
    document->root = toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw InputError(file, LineOf(error.source()), fmt::format("expected TOML, found: {}", error.description()));
  }
  document->Visit(document->root, "");
  return Table(std::move(document), 0);
}

double Table::Number(std::string_view key, const Range& range) {
  const toml::node* const node = document_->AskRequired(index_, key, range.Describe(key));
  return node ? document_->ToNumber(*node, key, range) : std::numeric_limits<double>::quiet_NaN();
}

std::optional<double> Table::OptionalNumber(std::string_view key, const Range& range) {
  const toml::node* const node = document_->Ask(index_, key);
  return node ? std::optional(document_->ToNumber(*node, key, range)) : std::nullopt;
}

std::string Table::String(std::string_view key) {
  const toml::node* const node = document_->AskRequired(index_, key, fmt::format("{} = \"text\"", key));
  return node ? document_->ToString(*node, key).value_or("") : "";
}

std::optional<std::string> Table::OptionalString(std::string_view key) {
  const toml::node* const node = document_->Ask(index_, key);
  return node ? document_->ToString(*node, key) : std::nullopt;
}

bool Table::Bool(std::string_view key) {
  const toml::node* const node = document_->AskRequired(index_, key, fmt::format("{} = true or false", key));
  return node && document_->ToBool(*node, key).value_or(false);
}

std::optional<bool> Table::OptionalBool(std::string_view key) {
  const toml::node* const node = document_->Ask(index_, key);
  return node ? document_->ToBool(*node, key) : std::nullopt;
}

std::vector<double> Table::Numbers(std::string_view key, const Range& range) {
  const std::string expected = fmt::format("{} = [numbers]", key);
  const toml::node* const node = document_->AskRequired(index_, key, expected);
  const toml::array* const array = node ? document_->ToArray(*node, expected) : nullptr;
  return array ? document_->ToNumbers(*array, key, range) : std::vector<double>();
}

std::vector<std::string> Table::Strings(std::string_view key) {
  const std::string expected = fmt::format("{} = [\"texts\"]", key);
  const toml::node* const node = document_->AskRequired(index_, key, expected);
  const toml::array* const array = node ? document_->ToArray(*node, expected) : nullptr;
  std::vector<std::string> strings;
  if (!array) return strings;
  for (const toml::node& element : *array) {
    strings.push_back(document_->ToString(element, fmt::format("{}[{}]", key, strings.size() + 1)).value_or(""));
  }
  return strings;
}

std::vector<std::vector<double>> Table::Rows(std::string_view key, const Range& range) {
  const std::string expected = fmt::format("{} = [[numbers], ...]", key);
  const toml::node* const node = document_->AskRequired(index_, key, expected);
  const toml::array* const array = node ? document_->ToArray(*node, expected) : nullptr;
  std::vector<std::vector<double>> rows;
  if (!array) return rows;
  for (const toml::node& element : *array) {
    const std::string name = fmt::format("{}[{}]", key, rows.size() + 1);
    const toml::array* const row = document_->ToArray(element, name + " = [numbers]");
    rows.push_back(row ? document_->ToNumbers(*row, name, range) : std::vector<double>());
  }
  return rows;
}

std::vector<Table> Table::Tables(std::string_view key) {
  const std::string expected = fmt::format("{} = [tables]", key);
  const toml::node* const node = document_->AskRequired(index_, key, expected);
  const toml::array* const array = node ? document_->ToArray(*node, expected) : nullptr;
  std::vector<Table> tables;
  if (!array) return tables;
  const std::string prefix = name().empty() ? "" : name() + ".";
  int position = 0;
  for (const toml::node& element : *array) {
    const std::string element_name = fmt::format("{}{}[{}]", prefix, key, ++position);
    if (const auto* table = element.as_table()) {
      tables.push_back(Table(document_, document_->Visit(*table, element_name)));
    } else {
      document_->AddFault(LineOf(element.source()), "a table " + element_name, Describe(element));
    }
  }
  return tables;
}

std::vector<Table> Table::OptionalTables(std::string_view key) {
  return document_->Ask(index_, key) ? Tables(key) : std::vector<Table>();
}

std::optional<Table> Table::OptionalTable(std::string_view key) {
  const toml::node* const node = document_->Ask(index_, key);
  if (!node) return std::nullopt;
  if (const auto* table = node->as_table()) {
    return Table(document_,
                 document_->Visit(*table, name().empty() ? std::string(key) : fmt::format("{}.{}", name(), key)));
  }
  document_->AddFault(LineOf(node->source()), fmt::format("a table {}", key), Describe(*node));
  return std::nullopt;
}

bool Table::Has(std::string_view key) const { return document_->visits[index_].table->contains(key); }

bool Table::HasTable(std::string_view key) const {
  const toml::node* const node = document_->visits[index_].table->get(key);
  return node && node->is_table();
}

void Table::Know(const std::vector<std::string>& keys) {
  for (const std::string& key : keys) document_->visits[index_].asked.emplace(key);
}

std::vector<std::string> Table::Keys() const {
  std::vector<const toml::key*> keys;
  for (const auto& [key, node] : *document_->visits[index_].table) keys.push_back(&key);
  std::sort(keys.begin(), keys.end(), [](const toml::key* a, const toml::key* b) {
    const toml::source_position &p = a->source().begin, &q = b->source().begin;
    return std::pair(p.line, p.column) < std::pair(q.line, q.column);
  });
  std::vector<std::string> names;
  for (const toml::key* key : keys) names.emplace_back(key->str());
  return names;
}

const std::string& Table::name() const { return document_->visits[index_].name; }

void Table::Report(std::string_view key, const std::string& expected, const std::string& found) {
  const toml::node* const node = document_->visits[index_].table->get(key);
  document_->AddFault(node ? LineOf(node->source()) : document_->LineOfTable(index_), expected, found);
}

void Table::Finish() const {
  Document all = {document_->file, {}, document_->visits, document_->faults};
  all.AddUnknownKeys();
  if (all.faults.empty()) return;
  std::stable_sort(all.faults.begin(), all.faults.end(), [](const auto& a, const auto& b) { return a.line < b.line; });
  std::string message;
  for (const Document::Fault& fault : all.faults) {
    // The first line's "file:line: " is InputError's own.
    message +=
        message.empty() ? fault.message : std::string("\n") + InputError(all.file, fault.line, fault.message).what();
  }
  throw InputError(all.file, all.faults.front().line, message);
}

}  // namespace uiclink
