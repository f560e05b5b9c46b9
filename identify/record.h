#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/parameter_set.h"

namespace uiclink {

/// What the caller knows about files that do not say it themselves.
struct ReadOptions {
  std::optional<double> rate_hz;         ///< sampling rate of files without a time column [Hz]
  std::optional<int> column;             ///< column of the displacement, 1 = first; default: the column after time
  std::optional<Direction> direction;    ///< overrides header and file name
  std::optional<double> mass_kg;         ///< overrides the header
  std::optional<double> g;               ///< overrides the header [m/s^2]
};

/// A measured ring-down. Displacements are the sensor's, in metres, never zero-shifted.
struct Record {
  std::string file;                       ///< as given by the user
  std::optional<Direction> direction;     ///< option, header, or file name; empty where none of them says
  double mass_kg = 378.2;                 ///< mass on the link (thesis, 4.2) unless header or option say otherwise
  double g = kThesisGravity;              ///< [m/s^2]
  double sampling_hz = 0;                 ///< mean rate [Hz]
  bool uniform = true;                    ///< equally spaced samples: t[i] = t[0] + i / sampling_hz
  std::vector<double> t;                  ///< time [s], strictly increasing
  std::vector<double> y;                  ///< displacement [m], same length as t
  std::string source;                     ///< "# source:" of the header
  std::vector<std::string> notices;       ///< what was assumed, in words for the user ("mass 378.2 kg assumed")
};

/// Reads a text record or a MATLAB file (DESIGN: time [s] and displacement [mm], one sample a line).
/// @throws InputError (data/input_error.h) with file, line, what was expected and what was found.
Record ReadRecord(const std::filesystem::path& path, const ReadOptions& options = {});

/// The text part of ReadRecord: `text` is the whole file, `file` its name for messages.
Record ParseRecord(std::string_view text, const std::string& file, const ReadOptions& options = {});

}  // namespace uiclink
