#include "reports/text_table.h"

#include <algorithm>

namespace uiclink {
namespace {

std::vector<std::string> SplitLines(const std::string& text) {
  std::vector<std::string> lines(1);
  for (const char c : text) {
    if (c == '\n') {
      lines.emplace_back();
    } else {
      lines.back() += c;
    }
  }
  return lines;
}

std::string Pad(const std::string& text, std::size_t width, TextTable::Align align) {
  const std::string blanks(width - std::min(width, DisplayWidth(text)), ' ');
  return align == TextTable::Align::kRight ? blanks + text : text + blanks;
}

std::string WithoutTrailingBlanks(std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace

std::size_t DisplayWidth(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

void TextTable::AddColumn(const std::string& head, Align align) { columns_.push_back({SplitLines(head), align}); }

void TextTable::AddRow(std::vector<std::string> cells) {
  cells.resize(columns_.size());
  rows_.push_back(std::move(cells));
}

void TextTable::AddRule() { rows_.emplace_back(); }

std::string TextTable::Format(int indent) const {
  std::vector<std::size_t> widths;
  std::size_t head_lines = 0, total = 0;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t width = 0;
    for (const std::string& line : columns_[c].head) width = std::max(width, DisplayWidth(line));
    for (const auto& row : rows_)
      if (!row.empty()) width = std::max(width, DisplayWidth(row[c]));
    widths.push_back(width);
    head_lines = std::max(head_lines, columns_[c].head.size());
    total += width + (c == 0 ? 0 : 2);
  }
  const std::string margin(static_cast<std::size_t>(indent), ' ');
  std::string rule = margin;
  for (std::size_t i = 0; i < total; ++i) rule += "─";
  rule += '\n';

  std::string text;
  const auto add_line = [&](auto cell_of) {
    std::string line = margin;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (c > 0) line += "  ";
      line += Pad(cell_of(c), widths[c], columns_[c].align);
    }
    text += WithoutTrailingBlanks(line) + '\n';
  };
  for (std::size_t i = 0; i < head_lines; ++i)
    add_line([&](std::size_t c) { return i < columns_[c].head.size() ? columns_[c].head[i] : std::string(); });
  text += rule;
  for (const auto& row : rows_) {
    if (row.empty()) {
      text += rule;
    } else {
      add_line([&](std::size_t c) { return row[c]; });
    }
  }
  return text;
}

}  // namespace uiclink
