#pragma once

#include <string>
#include <vector>

namespace uiclink {

/// A table for a terminal: columns as wide as their widest cell, numbers to the right, words to the left.
class TextTable {
 public:
  enum class Align { kLeft, kRight };

  /// @param head  one or two lines (separated by '\n'), the second for the unit.
  void AddColumn(const std::string& head, Align align = Align::kRight);
  /// One cell for each column; missing cells are empty.
  void AddRow(std::vector<std::string> cells);
  /// A thin rule between the rows so far and the next ones.
  void AddRule();

  struct Column {
    std::vector<std::string> head;  ///< its lines
    Align align;
  };
  const std::vector<Column>& columns() const { return columns_; }
  /// As many cells as columns; an empty row is a rule.
  const std::vector<std::vector<std::string>>& rows() const { return rows_; }

  /// The table with a rule under its head, each line indented by `indent` blanks and ended by '\n'.
  std::string Format(int indent = 0) const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Number of columns that UTF-8 text takes on a terminal: code points, since we write no wide ones.
std::size_t DisplayWidth(const std::string& text);

}  // namespace uiclink
