#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "vehicle/wagon.h"

namespace uiclink {

/// A saved run: where it is, how fast, and what it stands on.
struct SavedState {
  WagonState state;
  double V = 0;          ///< [m/s]
  std::string identity;  ///< of all inputs, one line (checksums of files, options), as the program composes it
};

/// Text: `# wagon-state/1`, then `key: value` lines; numbers as hexadecimal floating point, so that they read back bit
/// by bit.  Joints corner by corner: p, slides, engaged of each slider.
std::string FormatState(const Wagon& wagon, const SavedState& saved);
/// Writes it whole or not at all (data/file.h).
void WriteStateFile(const std::filesystem::path& path, const Wagon& wagon, const SavedState& saved);

/// @throws InputError with file and line; also when the file's identity differs from `identity` (both are in the
/// message), or its joints are not those of the wagon. An empty `identity` accepts any.
SavedState ReadStateFile(const std::filesystem::path& path, const Wagon& wagon, std::string_view identity);
SavedState ParseState(std::string_view text, const std::string& file, const Wagon& wagon, std::string_view identity);

}  // namespace uiclink
