#include "reports/inline_svg.h"

#include <fmt/format.h>

#include <regex>
#include <sstream>
#include <string_view>

#include "reports/escape.h"

namespace uiclink {
namespace {

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

std::string InlineSvg(const std::string& svg, const std::string& prefix, const std::string& description) {
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) return {};
  std::string text = SayOnce(svg.substr(begin));
  text = std::regex_replace(text, std::regex(R"((\bid=["'])([^"']+))"), "$1" + prefix + "$2");
  text = std::regex_replace(text, std::regex(R"((href=["']#)([^"']+))"), "$1" + prefix + "$2");
  text = std::regex_replace(text, std::regex(R"(url\(#([^)]+)\))"), "url(#" + prefix + "$1)");
  text.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", EscapeMarkup(description)));
  return text;
}

}  // namespace uiclink
