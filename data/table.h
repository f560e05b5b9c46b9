#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace uiclink {

/// Numbers that a key may have, and their unit for messages. Not-a-number and infinity are never among them.
struct Range {
  std::string unit;  ///< "1/m"; "-" for a number without dimension
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_included = true;
  bool high_included = true;

  static Range Any(std::string unit) { return {.unit = std::move(unit)}; }
  static Range Positive(std::string unit) { return {.unit = std::move(unit), .low = 0, .low_included = false}; }
  static Range NotNegative(std::string unit) { return {.unit = std::move(unit), .low = 0}; }

  bool Contains(double value) const;
  /// "k > 0 [1/m]", "0 <= mu < 1 [-]", "a finite number c [s/m]".
  std::string Describe(std::string_view key) const;
};

/// A table of a TOML file, read key by key: typed values, checked, with file and line in every message.
///
///   Table file = Table::Read("link.toml");
///   const double load = file.Number("load_N", Range::Positive("N"));
///   if (std::optional<Table> lateral = file.OptionalTable("lateral")) k = lateral->Number("k",
///   Range::Positive("1/m")); file.Finish();
///
/// A fault does not throw at once: the getter notes it and returns a stand-in (NaN, empty), and Finish() throws all
/// faults of the file together. Keys that nobody asked for are faults too, so that a misspelt option is not silently
/// ignored. Tables of one file share its faults; copies are cheap. One thread at a time.
class Table {
 public:
  /// @throws InputError where the file cannot be read or is no TOML.
  static Table Read(const std::filesystem::path& path);
  /// @param text the whole file. @param file its name for messages.
  static Table Parse(std::string_view text, const std::string& file);

  // Required keys: a missing one is a fault.
  double Number(std::string_view key, const Range& range);                ///< NaN after a fault
  std::string String(std::string_view key);                               ///< empty after a fault
  bool Bool(std::string_view key);                                        ///< false after a fault
  std::vector<double> Numbers(std::string_view key, const Range& range);  ///< array; NaN for faulty elements
  std::vector<std::string> Strings(std::string_view key);                 ///< array; empty for faulty elements
  std::vector<std::vector<double>> Rows(std::string_view key,
                                        const Range& range);  ///< array of arrays, not checked to be square
  std::vector<Table> Tables(std::string_view key);            ///< array of tables; faulty elements left out

  // Optional keys: nullopt where the key is missing; after a fault too, unless the stand-in above exists.
  std::optional<double> OptionalNumber(std::string_view key, const Range& range);
  std::optional<std::string> OptionalString(std::string_view key);
  std::optional<bool> OptionalBool(std::string_view key);
  std::optional<Table> OptionalTable(std::string_view key);
  std::vector<Table> OptionalTables(std::string_view key);  ///< empty where the key is missing

  bool Has(std::string_view key) const;       ///< does not count as asking for the key
  bool HasTable(std::string_view key) const;  ///< the key is there and is a table; does not count as asking for it
  std::vector<std::string> Keys() const;      ///< in the order of the file; does not count as asking for them
  void Know(const std::vector<std::string>& keys);  ///< counts as asking for them, whether they are there or not
  const std::string& name() const;  ///< "lateral.sliders[2]" (counted from 1); empty for the file itself

  /// Notes a fault that the caller found: "expected <expected>, found <found>", at the line of `key` (or of the table).
  void Report(std::string_view key, const std::string& expected, const std::string& found);

  /// @throws InputError if any table of this file had a fault or a key that nobody asked for: one line for each, in the
  ///         order of the file; InputError::line() is the first one's.
  void Finish() const;

 private:
  struct Document;
  Table(std::shared_ptr<Document> document, std::size_t index) : document_(std::move(document)), index_(index) {}

  std::shared_ptr<Document> document_;  ///< text tree, faults, and what has been asked for; shared by all its tables
  std::size_t index_;                   ///< this table among those of the document
};

}  // namespace uiclink
