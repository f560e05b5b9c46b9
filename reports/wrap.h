#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace uiclink {

/// Text broken at blanks so that no line is wider than `columns`, where words allow it; width is that of DisplayWidth.
/// Several blanks in a row are kept inside a line.
/// @param indent  blanks before every line but the first, which is taken to begin at that column.
std::string Wrap(std::string_view text, std::size_t indent, std::size_t columns);

/// The same with the first line indented too, and a line end after the last: a paragraph.
std::string Paragraph(std::string_view text, std::size_t indent, std::size_t columns);

}  // namespace uiclink
