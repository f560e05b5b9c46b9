#pragma once

#include <span>
#include <string>

#include "reports/csv.h"

namespace uiclink {

/// A text in a MATLAB file.
struct MatText {
  std::string name;  ///< letters, digits and '_', no digit in front, at most 63
  std::string text;
};

/// Columns and texts as the bytes of a MATLAB file (level 5, not compressed): a column vector of doubles each, with the
/// name of ColumnWord, and a row of characters each. The same arguments give the same bytes.
/// @throws std::invalid_argument if two variables have one name, or a column has 2^28 values or more (level 5 counts
///         bytes of a variable in 31 bits).
std::string FormatMatFile(std::span<const DataColumn> columns, std::span<const MatText> texts = {});

}  // namespace uiclink
