#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace uiclink {

/// A quantity over time, or over whatever the first column is.
struct DataColumn {
  std::string name;  ///< "front_lateral"
  std::string unit;  ///< "mm"; empty or "-" for a number without dimension
  std::vector<double> values;
};

/// Name and unit as one word, for heads of columns and names of variables: "front_lateral_mm", "speed_m_per_s",
/// "acceleration_m_per_s2", "multiplier". Letters, digits and '_' alone, no digit in front; at most 63 of them, as
/// MATLAB wants it. "%" becomes "percent".
std::string ColumnWord(const DataColumn& column);

/// A head of ColumnWord and a line for each row. Every number reads back as the same double; what is not finite is an
/// empty cell.
/// @throws std::invalid_argument if columns differ in length or two have one word.
std::string FormatCsv(std::span<const DataColumn> columns);

/// Text as one cell: in quotation marks where commas, quotation marks or line ends need them (RFC 4180).
std::string CsvCell(std::string_view text);

}  // namespace uiclink
