#include "identify/record_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "data/input_error.h"

namespace uiclink::record_parts {
namespace {

bool IsDigit(char c) { return c >= '0' && c <= '9'; }
bool IsBlank(char c) { return c == ' ' || c == '\t'; }
bool StartsComment(char c) { return c == '#' || c == '%'; }

std::string_view WithoutComment(std::string_view line) { return line.substr(0, line.find_first_of("#%")); }

// Runs of blanks between fields.
Row SplitAtBlanks(std::string_view line, const ColumnChoice& choice) {
  Row row;
  std::size_t i = 0;
  while (true) {
    while (i < line.size() && IsBlank(line[i])) ++i;
    if (i == line.size() || StartsComment(line[i])) return row;
    const std::size_t start = i;
    while (i < line.size() && !IsBlank(line[i]) && !StartsComment(line[i])) ++i;
    row.Add(line.substr(start, i - start), choice);
  }
}

// One separator between fields, so that an empty field counts; one at the end of the line does not open a field.
Row SplitAt(char separator, std::string_view line, const ColumnChoice& choice) {
  Row row;
  line = TrimBlanks(WithoutComment(line));
  while (!line.empty()) {
    const std::size_t end = std::min(line.find(separator), line.size());
    row.Add(TrimBlanks(line.substr(0, end)), choice);
    line.remove_prefix(std::min(end + 1, line.size()));
  }
  return row;
}

/// What the commas and points in a line of numbers suggest.
struct Punctuation {
  bool semicolon = false, tab = false, blank = false, point = false;
  int commas = 0;
  bool loose_comma = false;  ///< a comma that does not stand between two digits: no decimal sign
  bool tight_comma = false;  ///< one that does
  bool zero_led = false;     ///< as in "0,005": what follows the comma cannot be a number of its own
};

Punctuation Inspect(std::string_view line) {
  Punctuation p;
  line = TrimBlanks(WithoutComment(line));
  for (std::size_t i = 0; i < line.size(); ++i) {
    switch (line[i]) {
      case ';':
        p.semicolon = true;
        break;
      case '\t':
        p.tab = true;
        break;
      case ' ':
        p.blank = true;
        break;
      case '.':
        p.point = true;
        break;
      case ',':
        ++p.commas;
        if (i > 0 && IsDigit(line[i - 1]) && i + 1 < line.size() && IsDigit(line[i + 1])) {
          p.tight_comma = true;
          p.zero_led |= line[i + 1] == '0' && i + 2 < line.size() && IsDigit(line[i + 2]);
        } else {
          p.loose_comma = true;
        }
        break;
      default:
        break;
    }
  }
  return p;
}

/// The first lines of a file that hold data, and the last row of words above them.
struct Sample {
  std::vector<Line> rows;
  Line header;
};

Sample TakeSample(std::string_view text) {
  constexpr std::size_t kEnough = 256;
  Sample sample;
  Lines lines(text);
  std::string_view line;
  while (sample.rows.size() < kEnough && lines.Next(&line)) {
    if (Trim(line).empty() || IsComment(line)) continue;
    if (IsMostlyDigits(line)) {
      sample.rows.push_back({line, lines.number()});
    } else if (sample.rows.empty()) {
      sample.header = {line, lines.number()};
    }
  }
  return sample;
}

/// Counts of lines in the sample that show some sign.
struct Votes {
  int all = 0, semicolon = 0, tab = 0, blank = 0, point = 0;
  int comma = 0, several_commas = 0, loose_comma = 0, tight_comma = 0, zero_led = 0;

  /// A sign counts when more than one line in eight shows it: a stray header line must not decide.
  bool Many(int count) const { return 8 * count > all; }
};

Votes Count(const std::vector<Line>& rows) {
  Votes votes;
  for (const Line& row : rows) {
    const Punctuation p = Inspect(row.text);
    ++votes.all;
    votes.semicolon += p.semicolon;
    votes.tab += p.tab;
    votes.blank += p.blank;
    votes.point += p.point;
    votes.comma += p.commas > 0;
    votes.several_commas += p.commas > 1;
    votes.loose_comma += p.loose_comma;
    votes.tight_comma += p.tight_comma;
    votes.zero_led += p.zero_led;
  }
  return votes;
}

/// Whether the commas in the data separate columns (or are decimal signs). They do where something shows that they
/// cannot be decimal: a point in the numbers, as many commas in the row of words, a comma beside a sign or a blank.
bool CommasSeparate(const Votes& votes, const Sample& sample, const ReadOptions& options, const std::string& file) {
  if (votes.Many(votes.point)) return true;
  const std::string_view last = sample.rows.back().text;
  if (OwnSeparator(sample.header.text) == ',' && Inspect(sample.header.text).commas == Inspect(last).commas)
    return true;
  const bool several = votes.Many(votes.several_commas);
  if (votes.Many(votes.loose_comma)) {
    if (!several || !votes.Many(votes.tight_comma)) return true;  // "0,-12" or "0, 12, 13"
  } else {
    if (votes.Many(votes.tab) || votes.Many(votes.blank)) return false;  // "0,005 1,25"
    const bool columns_known = options.column.value_or(1) > 1 && !votes.Many(votes.zero_led);
    if (!several || columns_known) return columns_known;
  }
  throw InputError(file, sample.rows.back().number,
                   fmt::format("expected numbers that can be told apart, found commas that may be decimal signs or "
                               "separate columns: {}; use decimal points, or semicolons between the columns",
                               Quote(last)));
}

/// The separator of the data; blank stands for runs of blanks and tabs.
char FindSeparator(const Sample& sample, const ReadOptions& options, const std::string& file) {
  const Votes votes = Count(sample.rows);
  if (votes.Many(votes.semicolon)) return ';';
  if (votes.Many(votes.comma) && CommasSeparate(votes, sample, options, file)) return ',';
  return 2 * votes.tab > votes.all ? '\t' : ' ';
}

/// The number of columns that most rows have.
int UsualColumns(const std::vector<Line>& rows, char separator) {
  std::vector<int> counts;
  counts.reserve(rows.size());
  for (const Line& row : rows) counts.push_back(Split(separator, row.text, {}).columns);
  std::sort(counts.begin(), counts.end());
  int best = 0;
  std::ptrdiff_t most = 0;
  for (auto it = counts.begin(); it != counts.end();) {
    const auto next = std::upper_bound(it, counts.end(), *it);
    if (next - it > most) {
      most = next - it;
      best = *it;
    }
    it = next;
  }
  return best;
}

}  // namespace

bool IsComment(std::string_view line) {
  const std::string_view trimmed = Trim(line);
  return !trimmed.empty() && StartsComment(trimmed.front());
}

std::string_view TrimBlanks(std::string_view text) {
  while (!text.empty() && IsBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && IsBlank(text.back())) text.remove_suffix(1);
  return text;
}

Row Split(char separator, std::string_view line, const ColumnChoice& choice) {
  return separator == ' ' ? SplitAtBlanks(line, choice) : SplitAt(separator, line, choice);
}

char OwnSeparator(std::string_view line) {
  for (const char separator : {';', '\t', ','}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return ' ';
}

bool IsMostlyDigits(std::string_view line) {
  int digits = 0;
  int others = 0;
  for (const char c : WithoutComment(line)) {
    if (IsDigit(c)) ++digits;
    if ((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80) ++others;
  }
  return digits > others;
}

void ThrowNoData(std::string_view text, const std::string& file) {
  constexpr std::string_view kExpected = "expected lines of time [s] and displacement [mm]";
  if (Trim(text).empty()) throw InputError(file, 0, fmt::format("{}, found an empty file", kExpected));
  Lines lines(text);
  for (std::string_view line; lines.Next(&line);) {
    if (Trim(line).empty() || IsComment(line)) continue;
    throw InputError(file, lines.number(), fmt::format("{}, found text: {}", kExpected, Quote(Trim(line))));
  }
  throw InputError(file, lines.number(), fmt::format("{}, found only comments", kExpected));
}

Layout FindLayout(std::string_view text, const std::string& file, const ReadOptions& options) {
  const Sample sample = TakeSample(text);
  if (sample.rows.empty()) ThrowNoData(text, file);
  Layout layout;
  layout.separator = FindSeparator(sample, options, file);
  layout.columns = UsualColumns(sample.rows, layout.separator);
  layout.choice = ChooseColumns(layout.columns, options, file, sample.rows.back().number);
  return layout;
}

}  // namespace uiclink::record_parts
