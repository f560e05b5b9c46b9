#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "model/parameter_set.h"

namespace uiclink {

/// What the caller knows about files that do not say it themselves.
struct ReadOptions {
  std::optional<double> rate_hz = {};       ///< sampling rate [Hz], > 0: for files without a time column
  std::optional<int> column = {};           ///< column of the displacement, 1 = first; default: the one after time
  std::optional<Direction> direction = {};  ///< overrides header and file name
  std::optional<double> mass_kg = {};       ///< overrides the header, > 0
  std::optional<double> g = {};             ///< overrides the header [m/s^2], > 0
  std::optional<std::string> displacement_unit = {};  ///< overrides the header; see DisplacementUnits()
};

/// A measured ring-down. Displacements are the sensor's, in metres, never zero-shifted.
struct Record {
  std::string file;                      ///< as given by the user
  std::optional<Direction> direction;    ///< option, header, column name or file name; empty where none of them says
  double mass_kg = 378.2;                ///< mass on the link (thesis, 4.2) unless header or option say otherwise
  double g = kThesisGravity;             ///< [m/s^2]
  double sampling_hz = 0;                ///< mean rate [Hz]
  bool uniform = true;                   ///< equally spaced samples: t[i] = t[0] + i / sampling_hz
  std::vector<double> t;                 ///< time [s], strictly increasing
  std::vector<double> y;                 ///< displacement [m], same length as t
  std::vector<double> uncertainty = {};  ///< stated standard deviation of each y [m]; empty where none is stated
  std::string source;                    ///< "# source:" of the header
  std::vector<std::string> notices;      ///< what was assumed, in words for the user ("mass 378.2 kg assumed ...")
};

/// Fewest samples that the reader accepts. Less than two periods of eight samples say nothing about a decay.
inline constexpr std::size_t kMinSamples = 16;

/// Largest displacement that the reader believes [m]; above it the unit is wrong. Angles count as arcs of radius 1 m
/// (1 rad = 1 m), so a pendulum that turns over still passes.
inline constexpr double kMaxDisplacement = 5.0;

/// Names of the accepted units, for messages and help: "mm, cm, m, um, in, mrad, rad, deg".
std::string DisplacementUnits();

/// Reads a text record or a MATLAB file.
///
/// Text: one sample a line, time [s] and displacement [mm]. `#` or `%` starts a comment; comment lines `key: value`
/// set direction, mass_kg, g, sampling_hz, displacement_unit and source. Rows of words above the data are column
/// names, whose units in brackets count ("y [cm]", "t [ms]"). Columns are separated by tab, comma, semicolon or
/// blanks; decimal points or commas, one kind per file; LF, CRLF or CR; UTF-8 with or without byte-order mark, UTF-16
/// with one. One column is the displacement and needs a rate (option, header, or a header's value line: a numeric line
/// below a row of as many words, whose number of columns differs from that of all lines that follow).
/// With a rate from the options the time column, if there is one, is not used.
///
/// A third column named "uncertainty..." holds the standard deviation of each displacement, in the same unit.
///
/// MATLAB: levels 4, 5 and 7.3. A matrix with time in its first column, or a time vector (t, time, ...) and series of
/// the same length; structs count as "struct.field", cell arrays of pieces are joined, as are pairs of time and
/// series that follow each other without a gap. Columns are counted 1 = time, then the channels in the order of the
/// file. Scalars and strings named like the header's keys (also fs, dt) count as header.
///
/// Time stamps that lie on an equally spaced grid within the rounding of their last decimal are put on that grid.
/// Increasing but irregular ones are kept (`uniform` is false). In an otherwise even record a step above 1.5 times the
/// median is a gap, hence a fault.
///
/// @throws InputError (data/input_error.h) with file, line, what was expected, what was found and what to do.
/// @throws std::invalid_argument when an option is out of range.
Record ReadRecord(const std::filesystem::path& path, const ReadOptions& options = {});

/// The text part of ReadRecord: `text` is the whole file, `file` its name (for messages and for the direction).
Record ParseRecord(std::string_view text, const std::string& file, const ReadOptions& options = {});

}  // namespace uiclink
