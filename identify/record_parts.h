#pragma once

// What the text and the MATLAB reader share; not installed.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/record.h"

namespace uiclink::record_parts {

/// A unit of the displacement column and its size in metres. Angles are arcs of radius 1 m: 1 rad counts as 1 m.
struct Unit {
  std::string_view name;
  double metres;
  bool angle;
};

/// The unit of that name, nullptr if there is none. "µm" is accepted in UTF-8 and Latin-1.
const Unit* FindUnit(std::string_view name);

/// What a file says about itself.
struct Header {
  std::optional<Direction> direction;
  std::optional<double> mass_kg;
  std::optional<double> g;
  std::optional<double> sampling_hz;
  bool samples_missing = false;  ///< "missing_samples": the writer knows of gaps in the times
  const Unit* unit = nullptr;                 ///< "displacement_unit"
  const Unit* column_unit = nullptr;          ///< in the brackets of the column's name
  std::optional<Direction> column_direction;  ///< the column's name is a direction
  std::string unknown_unit;                   ///< in the brackets of the column's name, but not one that we know
  int unknown_unit_line = 0;
  std::string source;
  std::vector<std::string> notices;
};

/// Takes one `key: value`. Keys that are none of ours are ignored, near misses ("mass: 400") are noticed.
/// @throws InputError when the value does not fit the key.
void SetHeaderKey(std::string_view key, std::string_view value, const std::string& file, int line, Header* header);

/// Line numbers of samples, stored as runs of adjacent lines.
class SampleLines {
 public:
  void Add(std::size_t sample, int line) {
    if (runs_.empty() || line - runs_.back().line != static_cast<int>(sample - runs_.back().sample)) {
      runs_.push_back({sample, line});
    }
  }
  int LineOf(std::size_t sample) const;  ///< 0 where the file has no lines

 private:
  struct Run {
    std::size_t sample;
    int line;
  };
  std::vector<Run> runs_;
};

/// The columns that were asked for, before anybody judges them.
struct RawRecord {
  std::vector<double> time;              ///< [s]; empty where the file has no time column or it was not read
  std::vector<double> value;             ///< displacement in the unit of the file
  std::vector<double> uncertainty = {};  ///< of each value, same unit; empty where the file has none
  int columns = 0;                       ///< in the file
  int value_column = 0;                  ///< 1-based
  SampleLines lines;
  Header header;
};

/// Which columns to read of a file with so many columns.
struct ColumnChoice {
  int time = 0;  ///< 1-based, 0: none
  int value = 0;
};

/// @throws InputError when the options do not fit the number of columns.
ColumnChoice ChooseColumns(int columns, const ReadOptions& options, const std::string& file, int line);

/// Number at the whole of `field`: decimal point or comma, exponent e, E or D. Empty where it is none (nan and inf
/// are).
std::optional<double> ParseNumber(std::string_view field);

std::string_view Trim(std::string_view text);
std::string Lower(std::string_view text);

/// `text` in quotes, shortened, with everything unprintable escaped: safe to show to a user.
std::string Quote(std::string_view text);

/// The direction that a name says ("test_Lateral-3"), empty if none or both. "collateral" is no direction.
std::optional<Direction> DirectionInName(std::string_view name);

RawRecord ParseText(std::string_view text, const std::string& file, const ReadOptions& options);
RawRecord ReadMat(const std::filesystem::path& path, const std::string& file, const ReadOptions& options);

/// UTF-16 (with byte-order mark) as UTF-8.
std::string DecodeUtf16(std::string_view text);

}  // namespace uiclink::record_parts
