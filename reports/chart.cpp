#include "reports/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "reports/chart_data.h"
#include "reports/escape.h"
#include "reports/figure_layout.h"
#include "reports/figure_style.h"

namespace uiclink {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kVeil = "rgba(255,255,255,0.7)";  // behind texts that may stand on lines
constexpr std::size_t kPlain = 64;                      // longer series are packed

/// plotly.js knows tags, the entities of those, and, where it shows values, names in %{...}.
std::string EscapeText(const std::string& text) {
  std::string escaped = EscapeMarkup(text);
  for (const auto& [what, by] : {std::pair{"&quot;", "\""}, {"&#39;", "'"}, {"%", "&#37;"}, {"\n", " "}, {"\t", " "}}) {
    const std::string_view word = what;
    for (std::size_t at = 0; (at = escaped.find(word, at)) != std::string::npos; ++at)
      escaped.replace(at, word.size(), by);
  }
  return escaped;
}

/// "xaxis", "xaxis2", ... and "x", "x2", ..., as plotly.js counts.
std::string Numbered(const std::string& word, std::size_t index) {
  return index == 0 ? word : word + std::to_string(index + 1);
}

double Bend(const FigureAxis& axis, double value) { return axis.log ? std::log10(value) : value; }

bool IsShown(const FigureAxis& axis, double value) { return std::isfinite(value) && (!axis.log || value > 0); }

/// As many digits as tell the values of an axis apart to 1e-6 of their range, six at least.
Json PlainValues(const std::vector<double>& values, const FigureAxis& axis) {
  double low = INFINITY, high = -INFINITY;
  for (const double value : values) {
    if (!IsShown(axis, value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  const double size = std::max(std::abs(low), std::abs(high));
  const double lost = high > low && !axis.log ? std::floor(std::log10(size / (high - low))) : 0;
  const int digits = static_cast<int>(std::clamp(6 + lost, 6.0, 17.0));
  Json array = Json::array();
  for (const double value : values)
    array.push_back(IsShown(axis, value) ? Json(std::stod(fmt::format("{:.{}g}", value, digits))) : Json(nullptr));
  return array;
}

Json Values(const std::vector<double>& values, const FigureAxis& axis) {
  if (values.size() <= kPlain) return PlainValues(values, axis);
  const PackedValues packed = PackValues(values, axis.log);
  return {{"from", packed.from}, {"to", packed.to}, {"log", axis.log}, {"u16", packed.numbers}};
}

/// The mark at the size that gnuplot gives it, or nearly so.
Json Marker(FigureMark mark, const char* colour) {
  const auto make = [&](const char* symbol, double size, double line) {
    return Json{{"symbol", symbol}, {"size", size}, {"color", colour}, {"line", {{"width", line}, {"color", colour}}}};
  };
  switch (mark) {
    case FigureMark::kDot:
      return make("circle", 2.6, 0);
    case FigureMark::kCircle:
      return make("circle-open", 7, 1.2);
    case FigureMark::kDisc:
      return make("circle", 6, 0);
    case FigureMark::kSquare:
      return make("square-open", 7, 1.2);
    case FigureMark::kTriangle:
      return make("triangle-up-open", 8, 1.2);
    case FigureMark::kCross:
      return make("x-thin-open", 6, 1.4);
    case FigureMark::kNone:
      break;
  }
  throw std::invalid_argument("FormatChart: no such mark");
}

const char* Dash(FigureLine line) {
  switch (line) {
    case FigureLine::kDashed:
      return "7px,4px";
    case FigureLine::kDotted:
      return "1.5px,3px";
    case FigureLine::kSolid:
    case FigureLine::kNone:
      break;
  }
  return "solid";
}

/// "%{x:.5~g} s"
std::string HoverValue(char name, const FigureAxis& axis) {
  return fmt::format("%{{{}:.5~g}}{}", name, axis.unit.empty() ? "" : " " + EscapeText(axis.unit));
}

/// Where panel `p` has its axes.
struct AxisNames {
  explicit AxisNames(std::size_t p) : x(Numbered("x", p)), y(Numbered("y", p)) {}
  std::string x, y;
};

class Chart {
 public:
  explicit Chart(const Figure& figure) : figure_(figure), layout_(CalcLayout(WithoutEqualScales(figure))) {
    LinkAxes();
    for (std::size_t p = 0; p < figure.panels.size(); ++p) AddPanel(p);
  }

  std::string Format() const {
    Json layout = axes_;
    layout["annotations"] = annotations_;
    layout["shapes"] = shapes_;
    const Json grid{{"columns", std::min(figure_.columns, figure_.panels.size())},
                    {"panel_height", figure_.panel_height},
                    {"title", EscapeText(figure_.title)},
                    {"panels", panels_}};
    const Json chart{{"data", data_}, {"layout", layout}, {"grid", grid}, {"links", links_}};
    std::string text = chart.dump(-1, ' ', false, Json::error_handler_t::replace);
    // Inside of a script element '<' could begin its end, and stands in strings only.
    for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
    return text;
  }

 private:
  /// plotly.js makes scales equal itself, for the size that the panel really has.
  static Figure WithoutEqualScales(Figure figure) {
    for (FigurePanel& panel : figure.panels) panel.equal_scales = false;
    return figure;
  }

  /// Axes that zoom together show the same from the start: what all of them show.
  void LinkAxes() {
    std::map<
        std::tuple<std::string, std::string, std::string, bool, bool, std::optional<double>, std::optional<double>>,
        std::vector<std::size_t>>
        groups;
    matches_.assign(figure_.panels.size(), {});
    for (std::size_t p = 0; p < figure_.panels.size(); ++p) {
      const FigurePanel& panel = figure_.panels[p];
      const FigureAxis& x = panel.x;
      if (!x.link.empty()) {
        groups[{x.link, "", "", x.log, x.reversed, {}, {}}].push_back(p);
        links_[x.link].push_back(Numbered("xaxis", p));
      } else if (!x.label.empty() && x.numbers && !panel.equal_scales) {
        groups[{"", x.label, x.unit, x.log, x.reversed, x.low, x.high}].push_back(p);
      }
    }
    for (const auto& [key, panels] : groups) {
      AxisRange all = layout_.panels[panels.front()].x;
      for (const std::size_t p : panels) {
        all.low = std::min(all.low, layout_.panels[p].x.low);
        all.high = std::max(all.high, layout_.panels[p].x.high);
      }
      for (const std::size_t p : panels) {
        layout_.panels[p].x = all;
        if (p != panels.front()) matches_[p] = AxisNames(panels.front()).x;
      }
    }
  }

  void AddPanel(std::size_t p) {
    const FigurePanel& panel = figure_.panels[p];
    const AxisNames names(p);
    Json x = Axis(panel.x, layout_.panels[p].x), y = Axis(panel.y, layout_.panels[p].y);
    x["anchor"] = names.y;
    y["anchor"] = names.x;
    if (!matches_[p].empty()) x["matches"] = matches_[p];
    if (panel.equal_scales) y["scaleanchor"] = names.x;
    axes_[Numbered("xaxis", p)] = std::move(x);
    axes_[Numbered("yaxis", p)] = std::move(y);
    Json entry{{"x", Numbered("xaxis", p)}, {"y", Numbered("yaxis", p)}, {"title", -1}};
    if (!panel.title.empty()) {
      entry["title"] = annotations_.size();
      AddText(panel.title, {{"xref", "paper"}, {"yref", "paper"}, {"xanchor", "left"}, {"yanchor", "bottom"}});
    }
    entry["legend"] = AddSeries(p);
    AddHorizontalGuides(panel, names);
    entry["guides"] = AddVerticalGuides(panel, names);
    AddNotes(panel, names);
    panels_.push_back(std::move(entry));
  }

  static Json Axis(const FigureAxis& axis, const AxisRange& range) {
    const double low = Bend(axis, range.low), high = Bend(axis, range.high);
    Json json{{"type", axis.log ? "log" : "linear"},
              {"range", axis.reversed ? Json{high, low} : Json{low, high}},
              {"title", {{"text", EscapeText(AxisTitle(axis))}}}};
    if (!axis.numbers) json.update({{"showticklabels", false}, {"ticks", ""}, {"showgrid", false}});
    return json;
  }

  void AddText(const std::string& text, Json place) {
    place["text"] = EscapeText(text);
    annotations_.push_back(std::move(place));
  }

  /// Indices of the series in the legend. Each has a legend of its own, so that they can be put where there is room:
  /// plotly.js breaks the lines of one legend by the width of the whole figure, not of a panel.
  Json AddSeries(std::size_t p) {
    Json in_legend = Json::array();
    const FigurePanel& panel = figure_.panels[p];
    const AxisNames names(p);
    const std::vector<SeriesStyle> styles = CalcStyles(panel);
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const FigureSeries& series = panel.series[s];
      const char* const colour = ColourCode(styles[s].colour);
      const bool line = series.line != FigureLine::kNone || series.mark == FigureMark::kNone;
      const bool mark = series.mark != FigureMark::kNone;
      Json trace{{"name", EscapeText(series.name)},
                 {"showlegend", !series.name.empty()},
                 {"xaxis", names.x},
                 {"yaxis", names.y},
                 {"mode", line && mark ? "lines+markers"
                          : line       ? "lines"
                                       : "markers"},
                 {"hovertemplate", HoverValue('x', panel.x) + ", " + HoverValue('y', panel.y) +
                                       (series.name.empty() ? "<extra></extra>" : "")}};
      if (line) trace["line"] = {{"color", colour}, {"width", series.width}, {"dash", Dash(styles[s].line)}};
      if (mark) trace["marker"] = Marker(series.mark, colour);
      trace["x"] = Values(series.x, panel.x);
      trace["y"] = Values(series.y, panel.y);
      if (!series.name.empty()) {
        trace["legend"] = Numbered("legend", legends_++);
        in_legend.push_back(data_.size());
      }
      data_.push_back(std::move(trace));
    }
    return in_legend;
  }

  void AddLine(Json place) {
    place.update(
        {{"type", "line"}, {"layer", "above"}, {"line", {{"color", "#707070"}, {"width", 1}, {"dash", "2px,2px"}}}});
    shapes_.push_back(std::move(place));
  }

  void AddHorizontalGuides(const FigurePanel& panel, const AxisNames& names) {
    for (const FigureGuide& guide : panel.horizontal_guides) {
      if (!IsShown(panel.y, guide.value)) continue;
      AddLine({{"xref", names.x + " domain"},
               {"x0", 0},
               {"x1", 1},
               {"yref", names.y},
               {"y0", guide.value},
               {"y1", guide.value}});
      if (guide.text.empty()) continue;
      AddText(guide.text, {{"xref", names.x + " domain"},
                           {"x", 1},
                           {"xanchor", "right"},
                           {"yref", names.y},
                           {"y", Bend(panel.y, guide.value)},
                           {"yanchor", "bottom"},
                           {"font", GuideFont()},
                           {"bgcolor", kVeil}});
    }
  }

  /// Indices of the texts.
  Json AddVerticalGuides(const FigurePanel& panel, const AxisNames& names) {
    Json texts = Json::array();
    for (const FigureGuide& guide : panel.vertical_guides) {
      if (!IsShown(panel.x, guide.value)) continue;
      AddLine({{"yref", names.y + " domain"},
               {"y0", 0},
               {"y1", 1},
               {"xref", names.x},
               {"x0", guide.value},
               {"x1", guide.value}});
      if (guide.text.empty()) continue;
      texts.push_back(annotations_.size());
      AddText(guide.text, {{"yref", names.y + " domain"},
                           {"y", 1},
                           {"yanchor", "top"},
                           {"xref", names.x},
                           {"x", Bend(panel.x, guide.value)},
                           {"xanchor", "left"},
                           {"font", GuideFont()},
                           {"bgcolor", kVeil}});
    }
    return texts;
  }

  static Json GuideFont() { return {{"size", 11}, {"color", "#505050"}}; }

  void AddNotes(const FigurePanel& panel, const AxisNames& names) {
    for (const FigureNote& note : panel.notes) {
      if (!IsShown(panel.x, note.x) || !IsShown(panel.y, note.y)) continue;
      AddText(note.text, {{"xref", names.x},
                          {"x", Bend(panel.x, note.x)},
                          {"xanchor", "left"},
                          {"xshift", 6},
                          {"yref", names.y},
                          {"y", Bend(panel.y, note.y)},
                          {"yanchor", "middle"},
                          {"yshift", 5}});
    }
  }

  const Figure& figure_;
  FigureLayout layout_;
  std::vector<std::string> matches_;  ///< of each panel, the x axis that its own follows; empty: none
  Json data_ = Json::array(), axes_ = Json::object(), annotations_ = Json::array(), shapes_ = Json::array();
  Json panels_ = Json::array(), links_ = Json::object();
  std::size_t legends_ = 0;
};

}  // namespace

std::string FormatChart(const Figure& figure) {
  CheckFigure(figure);
  return Chart(figure).Format();
}

}  // namespace uiclink
