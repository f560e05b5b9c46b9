#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "vehicle/simulation.h"

namespace uiclink {

/// A histories.csv that `wagon simulate` wrote.
struct HistoryFile {
  double hz = 0;  ///< samples per second
  std::vector<SimulationSample> samples;
  /// Columns of the guides on the wheelsets [N], corner by corner; empty where the file has no forces.
  std::array<std::vector<double>, kCorners> guide_x, guide_y;
};

/// @throws InputError with file and line: no such file, columns of another kind of file (the first that is missing is
///         named), a cell that is no number, fewer than 64 samples, times that are not evenly spaced.
HistoryFile ReadHistoryFile(const std::filesystem::path& path);
HistoryFile ParseHistory(const std::string& text, const std::string& file);

/// A notice where the forces of the guides in the file are not those that this wagon has in its motion, so that the
/// file is of another wagon; empty where they are, or where the file has none.
std::string CompareGuides(const HistoryFile& history, const Wagon& wagon, const std::string& file);

}  // namespace uiclink
