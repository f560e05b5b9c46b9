#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace uiclink::reproduce {

/// Text with what has a meaning in HTML replaced.
std::string EscapeHtml(std::string_view text);

/// A page of HTML 5 that needs nothing beside itself: style inside, no script. All text is escaped.
class HtmlPage {
 public:
  struct Cell {
    std::string text;
    std::string style = {};   ///< class; "", "number", or a word that the style sheet knows
    std::size_t columns = 1;  ///< that it spans
    std::string link = {};    ///< address; empty: none
  };
  using Cells = std::vector<Cell>;

  explicit HtmlPage(std::string title) : title_(std::move(title)) {}

  void Heading(int level, const std::string& text, const std::string& id = {});
  void Paragraph(const std::string& text, const std::string& style = {});
  void Code(const std::string& text);
  void Link(const std::string& address, const std::string& text);
  /// @param head  one or more rows of column heads. The first cell of a row is its head.
  void Table(const std::string& caption, const std::vector<Cells>& head, const std::vector<Cells>& rows);
  /// An SVG picture inside the page, its own ids made unique.
  /// @param description  what it shows, for who cannot see it; also its caption.
  void Picture(const std::string& svg, const std::string& description);

  std::string Format() const;

 private:
  std::string title_;
  std::string body_;
  std::size_t pictures_ = 0;
};

/// An SVG document as an element of a page: without its prologue, ids with a prefix, named by `description`.
std::string InlineSvg(const std::string& svg, const std::string& prefix, const std::string& description);

}  // namespace uiclink::reproduce
