#include "reports/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>
#include <stdexcept>

namespace uiclink {
namespace {

constexpr std::size_t kLongestWord = 63;  // MATLAB's namelengthmax

/// "m/s^2" -> "m_per_s2", "N s/m" -> "N_s_per_m", "%" -> "percent".
std::string UnitWord(std::string_view unit) {
  if (unit.empty() || unit == "-") return {};
  std::string word = unit.starts_with('1') && unit.size() > 1 && unit[1] == '/' ? "" : "_";
  for (const char c : unit) {
    if (c == '/') {
      word += "_per_";
    } else if (c == '%') {
      word += "percent";
    } else if (c != '^' && !(c == '1' && word.empty())) {
      word += c;
    }
  }
  return word;
}

bool IsWordLetter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_';
}

}  // namespace

std::string ColumnWord(const DataColumn& column) {
  std::string word = column.name + UnitWord(column.unit);
  for (char& c : word) {
    if (!IsWordLetter(c)) c = '_';
  }
  if (word.empty() || (word[0] >= '0' && word[0] <= '9') || word[0] == '_') word.insert(0, "x");
  return word.substr(0, kLongestWord);
}

std::string FormatCsv(std::span<const DataColumn> columns) {
  std::string text;
  std::set<std::string> words;
  for (const DataColumn& column : columns) {
    const std::string word = ColumnWord(column);
    if (!words.insert(word).second) throw std::invalid_argument("FormatCsv: two columns are called " + word);
    if (column.values.size() != columns[0].values.size()) {
      throw std::invalid_argument(fmt::format("FormatCsv: column {} has {} rows, column {} has {}", word,
                                              column.values.size(), ColumnWord(columns[0]), columns[0].values.size()));
    }
    text += (text.empty() ? "" : ",") + word;
  }
  if (columns.empty()) return text;
  text += '\n';
  for (std::size_t row = 0; row < columns[0].values.size(); ++row) {
    const char* separator = "";
    for (const DataColumn& column : columns) {
      text += separator;
      separator = ",";
      if (std::isfinite(column.values[row])) fmt::format_to(std::back_inserter(text), "{}", column.values[row]);
    }
    text += '\n';
  }
  return text;
}

std::string CsvCell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string cell = "\"";
  for (const char c : text) {
    if (c == '"') cell += '"';
    cell += c;
  }
  return cell + '"';
}

}  // namespace uiclink
