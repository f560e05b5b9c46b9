// Text records: header and data in one pass over the lines.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "data/input_error.h"
#include "identify/record_layout.h"
#include "identify/record_parts.h"

namespace uiclink::record_parts {
namespace {

/// nan, inf, or a number: something that was meant as a reading.
bool IsNumberLike(std::string_view field) { return ParseNumber(field).has_value(); }

// --- header ----------------------------------------------------------------------------------------------------

void ReadComment(std::string_view line, int number, const std::string& file, Header* header) {
  line = Trim(line);
  const std::size_t start = line.find_first_not_of("#% \t");
  if (start == std::string_view::npos) return;
  line.remove_prefix(start);
  const std::size_t colon = line.find_first_of(":=");
  // A key is one word; a comment like "measured at 12:30" is a sentence.
  if (colon == std::string_view::npos || Trim(line.substr(0, colon)).find(' ') != std::string_view::npos) return;
  SetHeaderKey(line.substr(0, colon), line.substr(colon + 1), file, number, header);
}

/// What stands in the brackets of "y [mm]" or "y (mm)"; the whole field where it has none ("mm" in a row of units).
struct Bracketed {
  std::string_view text;
  bool square = false;
};

Bracketed FindBracketed(std::string_view field) {
  for (const std::string_view pair : {"[]", "()"}) {
    const std::size_t open = field.find(pair[0]);
    const std::size_t close = field.find(pair[1], open == std::string_view::npos ? 0 : open);
    if (open != std::string_view::npos && close != std::string_view::npos) {
      return {Trim(field.substr(open + 1, close - open - 1)), pair[0] == '['};
    }
  }
  return {Trim(field), false};
}

/// Seconds of one unit of the time column; empty where the field names none.
std::optional<double> TimeUnit(std::string_view field) {
  const std::string unit = Lower(FindBracketed(field).text);
  if (unit == "s" || unit == "sec" || unit == "seconds") return 1.0;
  if (unit == "ms" || unit == "msec") return 1e-3;
  if (unit == "us" || unit == "\xC2\xB5s" || unit == "\xCE\xBCs") return 1e-6;
  if (unit == "min") return 60.0;
  return std::nullopt;
}

/// A row of words above the data: names and units of the columns.
void ReadColumnNames(const Line& line, const Layout& layout, Header* header, double* time_unit) {
  const char separator = OwnSeparator(line.text);
  const Row names = Split(separator, line.text, layout.choice);
  if (names.columns != layout.columns) return;
  if (const std::optional<double> unit = TimeUnit(names.time)) *time_unit = *unit;
  if (const std::optional<Direction> direction = DirectionInName(names.value)) header->column_direction = direction;
  const Bracketed bracketed = FindBracketed(names.value);
  if (const Unit* unit = FindUnit(bracketed.text)) {
    header->column_unit = unit;
  } else if (bracketed.square) {
    header->unknown_unit = std::string(bracketed.text);
    header->unknown_unit_line = line.number;
  }
}

/// "sample_rate, duration" above "1000, 5": names and values of a header. They go through the same keys as comments.
void ReadHeaderValues(const Line& names, std::string_view values, int number, const std::string& file, Header* header) {
  const char separator = OwnSeparator(names.text);
  const bool had_rate = header->sampling_hz.has_value();
  const int columns = Split(separator, names.text, {}).columns;
  for (int column = 1; column <= columns; ++column) {
    const ColumnChoice choice{.time = 0, .value = column};
    const Row name = Split(separator, names.text, choice);
    SetHeaderKey(name.value, Split(separator, values, choice).value, file, number, header);
  }
  if (header->sampling_hz && !had_rate) {
    header->notices.push_back(
        fmt::format("sampling rate {:g} Hz taken from the header (line {})", *header->sampling_hz, number));
  }
}

// --- data ------------------------------------------------------------------------------------------------------

/// Collects what is wrong with the lines: the first fault in full, of the others how many there are.
class Faults {
 public:
  enum Kind { kColumns, kEmpty, kNotFinite, kNotANumber, kKinds };

  template <typename MakeMessage>
  void Add(Kind kind, int line, MakeMessage make_message) {
    if (line_ == 0) {
      kind_ = kind;
      line_ = line;
      message_ = make_message();
    }
    ++counts_[kind];
  }

  void ThrowIfAny(const std::string& file) const {
    if (line_ == 0) return;
    const int alike = counts_[kind_] - 1;
    int others = -1 - alike;
    for (const int count : counts_) others += count;
    std::string message = message_;
    if (alike > 0) message += fmt::format("; and {} more line{} like it", alike, alike == 1 ? "" : "s");
    if (others > 0) message += fmt::format("; and {} line{} with other faults", others, others == 1 ? "" : "s");
    throw InputError(file, line_, message);
  }

 private:
  Kind kind_ = kColumns;
  int line_ = 0;
  std::string message_;
  std::array<int, kKinds> counts_{};
};

/// Value of a field; a fault, and NaN, where it is none.
double ReadField(std::string_view field, const char* what, int line, Faults* faults) {
  const std::optional<double> number = ParseNumber(field);
  if (number && std::isfinite(*number)) return *number;
  constexpr const char* kAdvice = "cut or interpolate such lines, or mark them as comments with #";
  if (field.empty()) {
    faults->Add(Faults::kEmpty, line,
                [&] { return fmt::format("expected {}, found an empty field; {}", what, kAdvice); });
  } else {
    faults->Add(number ? Faults::kNotFinite : Faults::kNotANumber, line,
                [&] { return fmt::format("expected {}, found {}; {}", what, Quote(field), kAdvice); });
  }
  return std::nan("");
}

/// The one pass over the lines.
class TextReader {
 public:
  TextReader(const Layout& layout, const std::string& file) : layout_(layout), file_(file) {
    raw_.columns = layout.columns;
    raw_.value_column = layout.choice.value;
  }

  RawRecord Read(std::string_view text) {
    raw_.value.reserve(text.size() / kTypicalLine);
    if (layout_.choice.time > 0) raw_.time.reserve(text.size() / kTypicalLine);
    Lines lines(text);
    for (std::string_view line; lines.Next(&line);) ReadLine(line, lines.number(), lines.terminated());
    faults_.ThrowIfAny(file_);
    if (raw_.value.empty()) ThrowNoData(text, file_);
    return std::move(raw_);
  }

 private:
  static constexpr ColumnChoice kUncertainty{.time = 0, .value = 3};
  static constexpr std::size_t kTypicalLine = 14;  // "12.345\t-12.345\n"

  void ReadLine(std::string_view line, int number, bool terminated) {
    const Row row = Split(layout_.separator, line, layout_.choice);
    if (row.columns == 0) {
      ReadEmptyLine(line, number);
    } else if (!in_data_ && IsHeaderValues(row, line)) {
      ReadHeaderValues(header_row_, line, number, file_, &raw_.header);
      header_row_ = {};
    } else if (!in_data_ && IsHeader(row, line)) {
      header_row_ = {line, number};
      comment_ = {};
      ReadColumnNames(header_row_, layout_, &raw_.header, &time_unit_);
      uncertain_ = NamesUncertainty(line);
    } else if (row.columns != layout_.columns) {
      WrongColumns(row, line, number, terminated);
    } else {
      StartData();
      ReadRow(row, line, number);
    }
  }

  void ReadEmptyLine(std::string_view line, int number) {
    if (!IsComment(line)) return;
    ReadComment(line, number, file_, &raw_.header);
    if (!in_data_) comment_ = {line.substr(line.find_first_of("#%") + 1), number};
  }

  bool IsHeader(const Row& row, std::string_view line) const {
    const std::string_view first = layout_.choice.time > 0 ? row.time : row.value;
    if (!first.empty() && !IsNumberLike(first)) return true;
    return row.columns != layout_.columns && !IsMostlyDigits(line);  // "2003 records of four links"
  }

  /// A row of numbers right below a row of as many words, unlike the data in its number of columns.
  bool IsHeaderValues(const Row& row, std::string_view line) const {
    if (header_row_.text.empty() || row.columns == layout_.columns || !IsMostlyDigits(line)) return false;
    const char separator = OwnSeparator(header_row_.text);
    return Split(separator, header_row_.text, {}).columns == Split(separator, line, {}).columns;
  }

  void WrongColumns(const Row& row, std::string_view line, int number, bool terminated) {
    if (!terminated && in_data_ && row.columns < layout_.columns) {
      raw_.header.notices.push_back(
          fmt::format("line {} left out: the file ends within it ({})", number, Quote(TrimBlanks(line))));
      return;
    }
    faults_.Add(Faults::kColumns, number, [&] {
      return fmt::format(
          "expected {} column{} as in most lines, found {} in {}; mark lines that are no data as "
          "comments with #",
          layout_.columns, layout_.columns == 1 ? "" : "s", row.columns, Quote(TrimBlanks(line)));
    });
  }

  /// NumPy and others write the names of the columns as the last comment above the data. Only units that we know count
  /// there: comments are free text.
  void StartData() {
    if (in_data_) return;
    in_data_ = true;
    if (comment_.text.empty()) return;
    Header names;
    ReadColumnNames(comment_, layout_, &names, &time_unit_);
    if (names.column_unit) raw_.header.column_unit = names.column_unit;
    if (names.column_direction) raw_.header.column_direction = names.column_direction;
  }

  /// "time_s displacement_mm uncertainty_mm": what digitised and tracked records say of each sample.
  bool NamesUncertainty(std::string_view names) const {
    if (layout_.columns != kUncertainty.value || layout_.choice.value != kUncertainty.value - 1) return false;
    return Lower(Split(OwnSeparator(names), names, kUncertainty).value).starts_with("uncertainty");
  }

  void ReadRow(const Row& row, std::string_view line, int number) {
    if (layout_.choice.time > 0) {
      raw_.time.push_back(ReadField(row.time, "a time in seconds", number, &faults_) * time_unit_);
    }
    raw_.lines.Add(raw_.value.size(), number);
    raw_.value.push_back(ReadField(row.value, "a displacement", number, &faults_));
    if (uncertain_) {
      const std::string_view field = Split(layout_.separator, line, kUncertainty).value;
      raw_.uncertainty.push_back(ReadField(field, "an uncertainty", number, &faults_));
    }
  }

  Layout layout_;
  const std::string& file_;
  RawRecord raw_;
  Faults faults_;
  Line header_row_;  // the last row of words above the data
  Line comment_;     // the last comment above the data, without its sign
  double time_unit_ = 1;
  bool in_data_ = false;
  bool uncertain_ = false;  // the third column holds the uncertainty of the second
};

/// Binary files in text's clothing: say what they are.
void RefuseBinary(std::string_view text, const std::string& file) {
  if (text.starts_with("PK\x03\x04")) {
    throw InputError(file, 0, "expected text, found a spreadsheet or zip archive; export the sheet as CSV");
  }
  const std::size_t nul = text.find('\0');
  if (nul == std::string_view::npos) return;
  const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
  throw InputError(file, static_cast<int>(line),
                   "expected text, found binary data (a NUL byte); export the record as text, or as .mat");
}

void AppendUtf8(char32_t code, std::string* out) {
  const auto byte = [out](char32_t value) { out->push_back(static_cast<char>(value)); };
  if (code < 0x80) {
    byte(code);
  } else if (code < 0x800) {
    byte(0xC0 | (code >> 6));
    byte(0x80 | (code & 0x3F));
  } else {
    // Surrogates are passed on one by one: they cannot be part of a number, and messages escape them.
    byte(0xE0 | (code >> 12));
    byte(0x80 | ((code >> 6) & 0x3F));
    byte(0x80 | (code & 0x3F));
  }
}

}  // namespace

std::string DecodeUtf16(std::string_view text) {
  const bool big_endian = text.starts_with("\xFE\xFF");
  std::string out;
  out.reserve(text.size() / 2);
  for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
    const auto first = static_cast<unsigned char>(text[i]);
    const auto second = static_cast<unsigned char>(text[i + 1]);
    AppendUtf8(static_cast<char32_t>(big_endian ? first << 8 | second : second << 8 | first), &out);
  }
  return out;
}

RawRecord ParseText(std::string_view text, const std::string& file, const ReadOptions& options) {
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    return ParseText(DecodeUtf16(text), file, options);
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  RefuseBinary(text, file);
  return TextReader(FindLayout(text, file, options), file).Read(text);
}

}  // namespace uiclink::record_parts
