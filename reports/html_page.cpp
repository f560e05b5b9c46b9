#include "reports/html_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>
#include <string_view>

#include "reports/chart.h"
#include "reports/embedded.h"
#include "reports/escape.h"
#include "reports/inline_svg.h"
#include "reports/thin_figure.h"

namespace uiclink {
namespace {

constexpr double kMagnified = 4;  // what charts are thinned for

void AppendCells(const HtmlPage::Cells& cells, bool head, std::string* html) {
  *html += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const HtmlPage::Cell& cell = cells[i];
    const char* const tag = head || i == 0 ? "th" : "td";
    const char* const scope = head     ? (cell.columns > 1 ? " scope=\"colgroup\"" : " scope=\"col\"")
                              : i == 0 ? " scope=\"row\""
                                       : "";
    std::string text = EscapeMarkup(cell.text);
    if (!cell.link.empty()) text = fmt::format("<a href=\"{}\">{}</a>", EscapeMarkup(cell.link), text);
    *html += fmt::format("<{}{}{}{}>{}</{}>", tag, scope,
                         cell.columns > 1 ? fmt::format(" colspan=\"{}\"", cell.columns) : "",
                         cell.style.empty() ? "" : fmt::format(" class=\"{}\"", cell.style), text, tag);
  }
  *html += "</tr>\n";
}

bool IsId(std::string_view id) {
  const auto is_letter = [](char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0; };
  return !id.empty() && is_letter(id.front()) && std::ranges::all_of(id, [&](char c) {
    return is_letter(c) || std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_';
  });
}

/// The text below a figure: what it shows, and its files.
std::string Caption(const std::string& description, const HtmlPage::Cells& files) {
  std::string html = "<figcaption>" + EscapeMarkup(description);
  for (const HtmlPage::Cell& file : files)
    html += fmt::format(" <a href=\"{}\">{}</a>", EscapeMarkup(file.link), EscapeMarkup(file.text));
  return html + "</figcaption>\n";
}

/// A licence must stay with what it is for; in a comment it may not end that.
std::string AsComment(std::string_view text) {
  std::string comment(text);
  for (std::size_t at = 0; (at = comment.find("--", at)) != std::string::npos;) comment.replace(at, 2, "- ");
  return comment;
}

}  // namespace

void HtmlPage::Heading(int level, const std::string& text, const std::string& id) {
  std::string name = id;
  if (level == 2) {
    if (name.empty()) name = fmt::format("section-{}", contents_.size() + 1);
    contents_.push_back({name, text});
  }
  body_ += fmt::format("<h{}{}>{}</h{}>\n", level, name.empty() ? "" : fmt::format(" id=\"{}\"", EscapeMarkup(name)),
                       EscapeMarkup(text), level);
}

void HtmlPage::Paragraph(const std::string& text, const std::string& style) {
  body_ += fmt::format("<p{}>{}</p>\n", style.empty() ? "" : fmt::format(" class=\"{}\"", style), EscapeMarkup(text));
}

void HtmlPage::Code(const std::string& text) { body_ += fmt::format("<p><code>{}</code></p>\n", EscapeMarkup(text)); }

void HtmlPage::Link(const std::string& address, const std::string& text) {
  body_ += fmt::format("<p><a href=\"{}\">{}</a></p>\n", EscapeMarkup(address), EscapeMarkup(text));
}

void HtmlPage::Table(const std::string& caption, const std::vector<Cells>& head, const std::vector<Cells>& rows) {
  body_ += fmt::format("<div class=\"table\"><table>\n<caption>{}</caption>\n<thead>\n", EscapeMarkup(caption));
  for (const Cells& cells : head) AppendCells(cells, true, &body_);
  body_ += "</thead>\n<tbody>\n";
  for (const Cells& cells : rows) AppendCells(cells, false, &body_);
  body_ += "</tbody>\n</table></div>\n";
}

void HtmlPage::Table(const std::string& caption, const TextTable& table) {
  const std::vector<TextTable::Column>& columns = table.columns();
  const bool two_lines = std::ranges::any_of(columns, [](const auto& column) { return column.head.size() > 1; });
  std::vector<Cells> head(two_lines ? 2 : 1), rows;
  for (const TextTable::Column& column : columns) {
    if (column.head.size() > 1 && column.head[0].empty() && !head[0].empty()) {
      ++head[0].back().columns;
    } else {
      head[0].push_back({.text = column.head[0]});
    }
    if (two_lines) head[1].push_back({.text = column.head.size() > 1 ? column.head[1] : ""});
  }
  for (const std::vector<std::string>& cells : table.rows()) {
    if (cells.empty()) continue;  // a rule
    Cells& row = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i)
      row.push_back({.text = cells[i].substr(std::min(cells[i].find_first_not_of(' '), cells[i].size())),
                     .style = columns[i].align == TextTable::Align::kRight ? "number" : ""});
  }
  Table(caption, head, rows);
}

void HtmlPage::Insert(const std::string& markup, std::string_view script) {
  body_ += markup;
  if (std::ranges::find(scripts_, script) == scripts_.end()) scripts_.push_back(script);
}

void HtmlPage::Picture(const std::string& svg, const std::string& description) {
  body_ += "<figure>\n" + InlineSvg(svg, fmt::format("p{}-", ++pictures_), description) + "\n" +
           Caption(description, {}) + "</figure>\n";
}

void HtmlPage::TakeId(const std::string& id) {
  if (!IsId(id)) throw std::invalid_argument("HtmlPage::Chart: id = \"" + id + "\", must be letters, digits, - and _");
  if (std::ranges::find(chart_ids_, id) != chart_ids_.end())
    throw std::invalid_argument("HtmlPage::Chart: id = \"" + id + "\" was taken before");
  chart_ids_.push_back(id);
}

void HtmlPage::Chart(const Figure& figure, const std::string& id, const std::string& description, const Cells& files) {
  TakeId(id);
  Figure thin = figure;
  ThinToPixels(&thin, plotly_.empty() ? 1 : kMagnified);
  if (plotly_.empty()) {
    AppendPicture(thin, id, description, files);
  } else {
    AppendChart(FormatChart(thin), id, description, files, figure.panel_height);
  }
}

void HtmlPage::StoredChart(const std::string& chart, const std::string& svg, const std::string& id,
                           const std::string& description) {
  constexpr int kHeight = 240;  // the script knows better
  if (plotly_.empty() || chart.empty()) return Picture(svg, description);
  TakeId(id);
  AppendChart(chart, id, description, {}, kHeight);
}

void HtmlPage::AppendChart(const std::string& chart, const std::string& id, const std::string& description,
                           const Cells& files, int height) {
  body_ += fmt::format(
      "<figure class=\"chart\" id=\"{}\">\n<div class=\"plot\" role=\"img\" aria-label=\"{}\" "
      "style=\"min-height: {}px\"></div>\n{}<script type=\"application/json\">{}</script>\n</figure>\n",
      id, EscapeMarkup(description), height, Caption(description, files), chart);
}

void HtmlPage::AppendPicture(const Figure& figure, const std::string& id, const std::string& description,
                             const Cells& files) {
  body_ += fmt::format("<figure id=\"{}\">\n", id);
  try {
    body_ += InlineSvg(RenderSvg(figure), fmt::format("p{}-", ++pictures_), description) + "\n";
  } catch (const FigureError& error) {
    body_ += fmt::format("<p class=\"warning\">{}</p>\n", EscapeMarkup(error.what()));
  }
  body_ += Caption(description, files) + "</figure>\n";
}

std::string HtmlPage::FormatContents() const {
  if (contents_.size() < 3) return {};
  std::string html = "<nav aria-label=\"Contents\">\n<p>Contents</p>\n<ol>\n";
  for (const Entry& entry : contents_)
    html += fmt::format("<li><a href=\"#{}\">{}</a></li>\n", EscapeMarkup(entry.id), EscapeMarkup(entry.text));
  return html + "</ol>\n</nav>\n";
}

std::string HtmlPage::FormatScripts() const {
  std::vector<std::string_view> scripts = scripts_;
  std::string html;
  if (!chart_ids_.empty() && !plotly_.empty()) {
    html = "<!-- The charts are drawn by plotly.js, under this licence:\n" + AsComment(PlotlyLicense()) + "-->\n";
    scripts.insert(scripts.end(), {plotly_, ChartScript()});
  }
  for (const std::string_view script : scripts) html.append("<script>").append(script).append("</script>\n");
  return html;
}

std::string HtmlPage::Format() const {
  const std::string contents = FormatContents();
  const std::string missing = chart_ids_.empty() || !plotly_.empty()
                                  ? ""
                                  : "<p class=\"quiet\">The figures are pictures only: this program was built without "
                                    "Plotly, which makes charts to zoom and read values from.</p>\n";
  const std::string no_script = chart_ids_.empty() || plotly_.empty()
                                    ? ""
                                    : "<noscript><p class=\"warning\">The figures of this page need JavaScript."
                                      "</p></noscript>\n";
  return fmt::format(
             "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n"
             "<style>\n{}</style>\n</head>\n<body{}>\n{}<main>\n<h1>{}</h1>\n{}{}{}</main>\n",
             EscapeMarkup(title_), PageStyle(), contents.empty() ? "" : " class=\"contents\"", contents,
             EscapeMarkup(title_), missing, no_script, body_) +
         FormatScripts() + "</body>\n</html>\n";
}

}  // namespace uiclink
