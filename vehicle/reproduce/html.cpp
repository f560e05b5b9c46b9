#include "vehicle/reproduce/html.h"

#include <fmt/format.h>

#include <regex>
#include <sstream>

namespace uiclink::reproduce {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.45 system-ui, sans-serif; max-width: 76rem; margin: 1.5rem auto; padding: 0 1rem; color: #1a1a1a; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; border-top: 1px solid #bbb; padding-top: .8rem; }
table { border-collapse: collapse; margin: .8rem 0; width: 100%; font-size: .92rem; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { border: 1px solid #bbb; padding: .25rem .5rem; text-align: left; vertical-align: top; }
thead th { background: #eee; } tbody th { font-weight: normal; min-width: 14rem; }
td.number { font-variant-numeric: tabular-nums; }
td.met { background: #e3f1e5; } td.explained { background: #fdf3d8; } td.unexplained { background: #fbe2dc; }
code { display: block; background: #f4f4f4; padding: .3rem .5rem; overflow-wrap: anywhere; font-size: .85rem; }
figure { margin: 1rem 0; } figure svg { max-width: 100%; height: auto; } figcaption { color: #444; font-size: .9rem; }
.warning { background: #fbe2dc; padding: .4rem .6rem; } .quiet { color: #444; font-size: .9rem; }
@media print { body { max-width: none; font-size: 10pt; } figure, tr { break-inside: avoid; } h2 { break-after: avoid; } }
)";

void AppendCells(const HtmlPage::Cells& cells, bool head, std::string* html) {
  *html += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const HtmlPage::Cell& cell = cells[i];
    const char* const tag = head || i == 0 ? "th" : "td";
    const char* const scope = head     ? (cell.columns > 1 ? " scope=\"colgroup\"" : " scope=\"col\"")
                              : i == 0 ? " scope=\"row\""
                                       : "";
    std::string text = EscapeHtml(cell.text);
    if (!cell.link.empty()) text = fmt::format("<a href=\"{}\">{}</a>", EscapeHtml(cell.link), text);
    *html += fmt::format("<{}{}{}{}>{}</{}>", tag, scope,
                         cell.columns > 1 ? fmt::format(" colspan=\"{}\"", cell.columns) : "",
                         cell.style.empty() ? "" : fmt::format(" class=\"{}\"", cell.style), text, tag);
  }
  *html += "</tr>\n";
}

void ReplaceAll(std::string_view what, std::string_view by, std::string* text) {
  for (std::size_t at = text->find(what); at != std::string::npos; at = text->find(what, at + by.size()))
    text->replace(at, what.size(), by);
}

/// Discs of one size and colour, a line of text each, as one path of dots.
std::string JoinDiscs(const std::string& svg) {
  static const std::regex disc(
      R"(\s*<use xlink:href='#gpPt6' transform='translate\(([^)]*)\) scale\(([^)]*)\)' color='([^']*)'/>\s*)");
  std::istringstream lines(svg);
  std::string joined, open;
  for (std::string line; std::getline(lines, line);) {
    std::smatch at;
    const bool is_disc = line.find("#gpPt6' transform") != std::string::npos && std::regex_match(line, at, disc);
    const std::string style = is_disc ? fmt::format(R"(stroke-width='{:g}' stroke-linecap='round' stroke='{}' d=')",
                                                    2 * std::stod(at[2]), at[3].str())
                                      : "";
    if (style != open) {
      if (!open.empty()) joined += "'/>\n";
      if (is_disc) joined += "<path " + style;
      open = style;
    }
    joined += is_disc ? "M" + at[1].str() + " h0" : line + "\n";
  }
  if (!svg.ends_with('\n')) joined.pop_back();
  return joined;
}

/// gnuplot says again at every tic what the whole picture can say once: half of a small picture is that.
std::string SayOnce(std::string svg) {
  constexpr std::string_view kCanvas = "<g id=\"gnuplot_canvas\">";
  if (svg.find(kCanvas) == std::string::npos) return svg;
  svg = JoinDiscs(svg);
  svg = std::regex_replace(svg, std::regex(R"(<g [^>]*>\s*</g>\s*)"), "");
  svg = std::regex_replace(svg, std::regex(R"(<tspan font-family="Helvetica" >([^<]*)</tspan>)"), "$1");
  ReplaceAll(R"(<g fill="none" color="black" stroke="currentColor" stroke-width)", "<g stroke-width", &svg);
  ReplaceAll(R"( stroke-linecap="butt" stroke-linejoin="miter")", "", &svg);
  ReplaceAll(R"( font-family="Helvetica")", "", &svg);
  ReplaceAll(R"( class="gridline")", "", &svg);
  ReplaceAll("rgb(64,64,64)", "#404040", &svg);
  ReplaceAll("rgb( 64,  64,  64)", "#404040", &svg);
  ReplaceAll("rgb(228, 228, 228)", "#e4e4e4", &svg);
  svg = std::regex_replace(svg, std::regex(R"(\s+(<text>[^<]*</text>)\s+)"), "$1");
  // A line of the grid and the tic after it.
  svg = std::regex_replace(
      svg, std::regex(R"re((<g stroke-width="0.80">\s*<path[^>]*/>)</g>\s*<g stroke-width="0.80">)re"), "$1");
  // Tenths of a pixel are what one sees.
  svg = std::regex_replace(svg, std::regex(R"re((\d\.\d)\d(?=,-?\d| [LM]\d| h0|  '|\)["' ]))re"), "$1");
  ReplaceAll(R"(fill="#ffffff"/>)", R"(fill="#ffffff" stroke="none"/>)", &svg);
  ReplaceAll(kCanvas,
             R"(<g id="gnuplot_canvas" fill="none" color="black" stroke="currentColor" stroke-linecap="butt" )"
             R"(stroke-linejoin="miter" font-family="Helvetica">)",
             &svg);
  return svg;
}

}  // namespace

std::string EscapeHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string InlineSvg(const std::string& svg, const std::string& prefix, const std::string& description) {
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) return {};
  std::string text = SayOnce(svg.substr(begin));
  text = std::regex_replace(text, std::regex(R"((\bid=["'])([^"']+))"), "$1" + prefix + "$2");
  text = std::regex_replace(text, std::regex(R"((href=["']#)([^"']+))"), "$1" + prefix + "$2");
  text = std::regex_replace(text, std::regex(R"(url\(#([^)]+)\))"), "url(#" + prefix + "$1)");
  text.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", EscapeHtml(description)));
  return text;
}

void HtmlPage::Heading(int level, const std::string& text, const std::string& id) {
  body_ += fmt::format("<h{}{}>{}</h{}>\n", level, id.empty() ? "" : fmt::format(" id=\"{}\"", EscapeHtml(id)),
                       EscapeHtml(text), level);
}

void HtmlPage::Paragraph(const std::string& text, const std::string& style) {
  body_ += fmt::format("<p{}>{}</p>\n", style.empty() ? "" : fmt::format(" class=\"{}\"", style), EscapeHtml(text));
}

void HtmlPage::Code(const std::string& text) { body_ += fmt::format("<p><code>{}</code></p>\n", EscapeHtml(text)); }

void HtmlPage::Link(const std::string& address, const std::string& text) {
  body_ += fmt::format("<p><a href=\"{}\">{}</a></p>\n", EscapeHtml(address), EscapeHtml(text));
}

void HtmlPage::Table(const std::string& caption, const std::vector<Cells>& head, const std::vector<Cells>& rows) {
  body_ += fmt::format("<table>\n<caption>{}</caption>\n<thead>\n", EscapeHtml(caption));
  for (const Cells& cells : head) AppendCells(cells, true, &body_);
  body_ += "</thead>\n<tbody>\n";
  for (const Cells& cells : rows) AppendCells(cells, false, &body_);
  body_ += "</tbody>\n</table>\n";
}

void HtmlPage::Picture(const std::string& svg, const std::string& description) {
  body_ += fmt::format("<figure>\n{}\n<figcaption>{}</figcaption>\n</figure>\n",
                       InlineSvg(svg, fmt::format("p{}-", ++pictures_), description), EscapeHtml(description));
}

std::string HtmlPage::Format() const {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{}</title>\n<style>{}</style>\n"
      "</head>\n<body>\n<h1>{}</h1>\n{}</body>\n</html>\n",
      EscapeHtml(title_), kStyle, EscapeHtml(title_), body_);
}

}  // namespace uiclink::reproduce
