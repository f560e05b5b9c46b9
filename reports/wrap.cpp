#include "reports/wrap.h"

#include <algorithm>

#include "reports/text_table.h"

namespace uiclink {

std::string Wrap(std::string_view text, std::size_t indent, std::size_t columns) {
  std::string wrapped;
  std::size_t column = indent;
  while (!text.empty()) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) break;
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word(text.substr(begin, end - begin));
    const std::string_view blanks = text.substr(0, column == indent ? 0 : begin);  // equations align with two
    if (column > indent && column + blanks.size() + DisplayWidth(word) > columns) {
      wrapped += '\n' + std::string(indent, ' ');
      column = indent;
    } else {
      wrapped += blanks;
      column += blanks.size();
    }
    wrapped += word;
    column += DisplayWidth(word);
    text.remove_prefix(end);
  }
  return wrapped;
}

std::string Paragraph(std::string_view text, std::size_t indent, std::size_t columns) {
  return std::string(indent, ' ') + Wrap(text, indent, columns) + '\n';
}

}  // namespace uiclink
