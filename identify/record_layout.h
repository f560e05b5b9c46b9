#pragma once

// How a text record is written: lines, fields, and which separators and decimal signs it uses; not installed.

#include <cstring>
#include <string>
#include <string_view>

#include "identify/record_parts.h"

namespace uiclink::record_parts {

/// Walks over the lines of a text: LF, CRLF, or, in a text without any LF, lone CR.
class Lines {
 public:
  explicit Lines(std::string_view text)
      : rest_(text), end_of_line_(text.find('\n') == std::string_view::npos ? '\r' : '\n') {}

  /// False at the end. `line` comes without its end; a CR before the LF is taken off.
  bool Next(std::string_view* line) {
    if (rest_.empty()) return false;
    const void* found = std::memchr(rest_.data(), end_of_line_, rest_.size());
    terminated_ = found != nullptr;
    const std::size_t length =
        terminated_ ? static_cast<std::size_t>(static_cast<const char*>(found) - rest_.data()) : rest_.size();
    *line = rest_.substr(0, length);
    rest_.remove_prefix(terminated_ ? length + 1 : length);
    while (!line->empty() && line->back() == '\r') line->remove_suffix(1);
    ++number_;
    return true;
  }

  int number() const { return number_; }           ///< of the line last returned, 1-based
  bool terminated() const { return terminated_; }  ///< false: the file ends within that line

 private:
  std::string_view rest_;
  char end_of_line_;
  int number_ = 0;
  bool terminated_ = true;
};

/// A line and its number, 1-based.
struct Line {
  std::string_view text;
  int number = 0;
};

/// The two fields that we need of a row, and how many it has.
struct Row {
  int columns = 0;
  std::string_view time;
  std::string_view value;

  void Add(std::string_view field, const ColumnChoice& choice) {
    ++columns;
    if (columns == choice.time) time = field;
    if (columns == choice.value) value = field;
  }
};

/// How the data of a file are written.
struct Layout {
  char separator = ' ';  ///< a blank stands for runs of blanks and tabs
  int columns = 0;
  ColumnChoice choice;
};

/// Finds out how the data are written from the first few hundred lines.
/// @throws InputError when there are no data, or their commas can be read in two ways.
Layout FindLayout(std::string_view text, const std::string& file, const ReadOptions& options);

/// Says why `text` holds no data: empty, only comments, or words.
[[noreturn]] void ThrowNoData(std::string_view text, const std::string& file);

/// Fields up to a comment.
Row Split(char separator, std::string_view line, const ColumnChoice& choice);

/// The separator that this row itself uses: header rows need not follow the data.
char OwnSeparator(std::string_view line);

bool IsComment(std::string_view line);

/// More digits than letters: a line of data rather than of words. Only for finding out how the data are written.
bool IsMostlyDigits(std::string_view line);

std::string_view TrimBlanks(std::string_view text);

}  // namespace uiclink::record_parts
