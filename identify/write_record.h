#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/parameter_set.h"

namespace uiclink {

/// What goes into a text record that ReadRecord reads: digitised, tracked or otherwise made here.
struct WrittenRecord {
  std::string source;                  ///< in words, one line
  std::optional<Direction> direction;  ///< empty: the file does not say it
  std::optional<double> mass_kg;       ///< [kg]
  std::optional<double> g;             ///< [m/s^2]
  std::string unit = "mm";             ///< of y and uncertainty: one of DisplacementUnits()
  std::vector<double> t;               ///< [s], strictly increasing
  std::vector<double> y;               ///< displacement [unit]
  std::vector<double> uncertainty;     ///< standard deviation of each y [unit]; empty, or as many as y
};

/// The record as text: lines `# key: value` (`missing_samples` where t has gaps, which ReadRecord then takes), a row of
/// column names ("time_s", "displacement_mm", "uncertainty_mm"), then one sample a line, separated by tabs. Times have
/// the fewest decimals (at most 9) that keep them to 1 ns, displacements as many as a hundredth of the median
/// uncertainty needs (six without one).
/// @throws std::invalid_argument when the columns differ in length, a value is not finite, or t does not increase.
std::string FormatRecord(const WrittenRecord& record);

}  // namespace uiclink
