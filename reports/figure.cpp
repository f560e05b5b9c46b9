#include "reports/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string_view>
#include <utility>

#include "reports/csv.h"
#include "reports/escape.h"
#include "reports/figure_layout.h"
#include "reports/figure_style.h"
#include "reports/gnuplot.h"
#include "reports/pictures.h"

namespace uiclink {
namespace {

enum class Format { kSvg, kPng };

/// Number and size of gnuplot's point.
std::string PointStyle(FigureMark mark) {
  switch (mark) {
    case FigureMark::kDot:
      return "pt 7 ps 0.25";
    case FigureMark::kCircle:
      return "pt 6 ps 0.7";
    case FigureMark::kDisc:
      return "pt 7 ps 0.6";
    case FigureMark::kSquare:
      return "pt 4 ps 0.7";
    case FigureMark::kTriangle:
      return "pt 8 ps 0.8";
    case FigureMark::kCross:
      return "pt 2 ps 0.7";
    case FigureMark::kNone:
      break;
  }
  return "pt 0";
}

const char* DashStyle(FigureLine line) {
  switch (line) {
    case FigureLine::kDashed:
      return "(7,4)";
    case FigureLine::kDotted:
      return "(1.5,3)";
    case FigureLine::kSolid:
    case FigureLine::kNone:
      break;
  }
  return "solid";
}

/// Text of a user's as a string of gnuplot's: in single quotes it substitutes nothing. Control characters are blanks.
std::string Quote(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') quoted += '\'';
    quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + "'";
}

/// Writes the script that draws a figure. Everything has its place in pixels (CalcLayout); gnuplot chooses the tics.
class Script {
 public:
  /// @param with_data  else the data are there from a script before.
  Script(const Figure& figure, Format format, bool with_data = true)
      : figure_(figure),
        layout_(CalcLayout(figure)),
        points_(format == Format::kSvg ? 1 : 0.75),
        label_rise_(format == Format::kSvg ? 0.6 : 0) {
    Add("set encoding utf8\n");
    Add("set terminal {} size {},{} font 'Helvetica,{}' background '#ffffff'\n",
        format == Format::kSvg ? "svg" : "pngcairo", figure.width, layout_.height, 13 * points_);
    for (std::size_t p = 0; with_data && p < figure.panels.size(); ++p) AddData(p);
    Add("set multiplot\nset border 3 lw 0.8 lc rgb '#404040'\nset tics nomirror out scale 0.6\n"
        "set grid lt 1 lc rgb '#e4e4e4' lw 0.8 dt solid\n");
    for (std::size_t p = 0; p < figure.panels.size(); ++p) AddPanel(p);
    Add("unset multiplot\n");
  }

  const std::string& text() const { return text_; }

 private:
  template <typename... Arguments>
  void Add(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Arguments>(arguments)...);
  }

  /// A data block for each series: a point a line, an empty line where the line breaks.
  void AddData(std::size_t p) {
    const FigurePanel& panel = figure_.panels[p];
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const FigureSeries& series = panel.series[s];
      Add("$data_{}_{} << end_of_data\n", p, s);
      for (const std::size_t i : ThinForDrawing(series.x, series.y)) {
        if (IsDrawn(panel, series, i)) {
          Add("{} {}\n", series.x[i], series.y[i]);
        } else {
          Add("\n");
        }
      }
      Add("end_of_data\n");
    }
  }

  static bool IsDrawn(const FigurePanel& panel, const FigureSeries& series, std::size_t i) {
    const double x = series.x[i], y = series.y[i];
    return std::isfinite(x) && std::isfinite(y) && (!panel.x.log || x > 0) && (!panel.y.log || y > 0);
  }

  /// Marks, labels and arrows of a panel must not stay for the next.
  void AddPanel(std::size_t p) {
    const FigurePanel& panel = figure_.panels[p];
    const PanelBox& box = layout_.panels[p].box;
    Add("unset label\nunset arrow\nunset logscale\nset key off\n");
    if (p == 0 && !figure_.title.empty()) {
      Add("set label {} at screen 0.5,{} center noenhanced font ',{}'\n", Quote(figure_.title), Height(20),
          15 * points_);
    }
    Add("set lmargin at screen {}\nset rmargin at screen {}\nset tmargin at screen {}\nset bmargin at screen {}\n",
        Width(box.left), Width(box.right), Height(box.top), Height(box.bottom));
    AddAxis('x', panel.x, layout_.panels[p].x);
    AddAxis('y', panel.y, layout_.panels[p].y);
    Add("set xlabel {} noenhanced offset 0,{}\n", Quote(AxisTitle(panel.x)), label_rise_);
    AddVerticalTitle(panel.y, box);
    AddTitle(panel, box);
    AddGuides(panel);
    for (const FigureNote& note : panel.notes) {
      Add("set label {} at first {},{} left noenhanced offset 0.6,0.4 front\n", Quote(note.text), note.x, note.y);
    }
    AddPlot(p);
    for (const auto& [name, axis] : {std::pair{'x', &panel.x}, std::pair{'y', &panel.y}})
      if (!axis->numbers) Add("set {}tics nomirror out scale 0.6\n", name);
  }

  double Width(double pixels) const { return pixels / figure_.width; }
  double Height(double pixels) const { return 1 - pixels / layout_.height; }  // gnuplot counts from below

  void AddAxis(char name, const FigureAxis& axis, const AxisRange& range) {
    if (axis.log) Add("set logscale {}\n", name);
    if (!axis.numbers) Add("unset {}tics\n", name);
    Add("set format {} '{}'\n", name, axis.log ? "10^{%L}" : "%h");
    if (axis.reversed) {
      Add("set {}range [{}:{}]\n", name, range.high, range.low);
    } else {
      Add("set {}range [{}:{}]\n", name, range.low, range.high);
    }
  }

  /// Not by `set ylabel`: gnuplot puts that one left of the tics' numbers, as wide as it expects them to be, and leaves
  /// it out where that is beyond the edge of the picture.
  void AddVerticalTitle(const FigureAxis& axis, const PanelBox& box) {
    if (AxisTitle(axis).empty()) return;
    Add("set label {} at screen {},{} center rotate by 90 noenhanced\n", Quote(AxisTitle(axis)),
        Width(box.left - kVerticalTitle), Height(0.5 * (box.top + box.bottom)));
  }

  /// The title at the left of its line; the legend at the right of that line or in rows below it.
  void AddTitle(const FigurePanel& panel, const PanelBox& box) {
    const double baseline = box.legend_below_title ? box.top - 8 - LegendHeight(panel, box) : box.top - 8;
    if (!panel.title.empty()) {
      Add("set label {} at screen {},{} left noenhanced\n", Quote(panel.title), Width(box.left), Height(baseline - 4));
    }
    Add("set key at screen {},{} right bottom horizontal Left reverse noenhanced samplen 1.8 maxcols {} autotitle\n",
        Width(box.right), Height(box.top - 2), box.legend_columns);
  }

  static double LegendHeight(const FigurePanel& panel, const PanelBox& box) {
    const auto entries = static_cast<std::size_t>(
        std::ranges::count_if(panel.series, [](const FigureSeries& series) { return !series.name.empty(); }));
    constexpr double kRowHeight = 19;
    return kRowHeight * static_cast<double>((entries + box.legend_columns - 1) / box.legend_columns);
  }

  void AddGuides(const FigurePanel& panel) {
    constexpr const char* kLine = "nohead lw 0.9 dt (2,2) lc rgb '#707070' back";
    const std::string text_style = fmt::format("noenhanced font ',{}' tc rgb '#505050' front", 11 * points_);
    for (const FigureGuide& guide : panel.horizontal_guides) {
      if (!std::isfinite(guide.value) || (panel.y.log && guide.value <= 0)) continue;
      Add("set arrow from graph 0,first {0} to graph 1,first {0} {1}\n", guide.value, kLine);
      if (guide.text.empty()) continue;
      Add("set label {} at graph 1,first {} right offset -0.3,0.5 {}\n", Quote(guide.text), guide.value, text_style);
    }
    for (const FigureGuide& guide : panel.vertical_guides) {
      if (!std::isfinite(guide.value) || (panel.x.log && guide.value <= 0)) continue;
      Add("set arrow from first {0},graph 0 to first {0},graph 1 {1}\n", guide.value, kLine);
      if (guide.text.empty()) continue;
      Add("set label {} at first {},graph 0.96 left offset 0.4,0 {}\n", Quote(guide.text), guide.value, text_style);
    }
  }

  void AddPlot(std::size_t p) {
    const FigurePanel& panel = figure_.panels[p];
    const std::vector<SeriesStyle> styles = CalcStyles(panel);
    Add("plot ");
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const FigureSeries& series = panel.series[s];
      Add("{} with {} lc rgb '{}' lw {} dt {} {} {}, ", Source(p, s), Style(series), ColourCode(styles[s].colour),
          series.width, DashStyle(styles[s].line), series.mark == FigureMark::kNone ? "" : PointStyle(series.mark),
          series.name.empty() ? "notitle" : "title " + Quote(series.name));
    }
    Add("NaN notitle\n");  // a panel without series has axes, too
  }

  /// A data block without a point would be refused.
  std::string Source(std::size_t p, std::size_t s) const {
    const FigurePanel& panel = figure_.panels[p];
    for (std::size_t i = 0; i < panel.series[s].x.size(); ++i) {
      if (IsDrawn(panel, panel.series[s], i)) return fmt::format("$data_{}_{} using 1:2", p, s);
    }
    return "NaN";
  }

  static const char* Style(const FigureSeries& series) {
    if (series.mark == FigureMark::kNone) return "lines";
    return series.line == FigureLine::kNone ? "points" : "linespoints";
  }

  const Figure& figure_;
  FigureLayout layout_;
  double points_;      ///< size of text that is a pixel high: SVG counts in pixels, PNG in points at 96 a inch
  double label_rise_;  ///< of the label of the x axis [lines]: gnuplot's SVG sets it too low
  std::string text_;
};

std::string Render(const Figure& figure, Format format) {
  CheckFigure(figure);
  return RunGnuplot(Script(figure, format).text());
}

/// Appends the indices of one block that ThinForDrawing keeps.
void KeepOutline(const std::vector<double>& x, const std::vector<double>& y, std::size_t begin, std::size_t end,
                 std::vector<std::size_t>* kept) {
  std::array<std::size_t, 6> keep{begin, begin, begin, begin, begin, end - 1};
  for (std::size_t i = begin; i < end; ++i) {
    if (x[i] < x[keep[1]]) keep[1] = i;
    if (x[i] > x[keep[2]]) keep[2] = i;
    if (y[i] < y[keep[3]]) keep[3] = i;
    if (y[i] > y[keep[4]]) keep[4] = i;
  }
  std::ranges::sort(keep);
  const auto last = std::unique(keep.begin(), keep.end());
  kept->insert(kept->end(), keep.begin(), last);
}

}  // namespace

std::vector<std::size_t> ThinForDrawing(const std::vector<double>& x, const std::vector<double>& y, std::size_t most) {
  const std::size_t size = std::min(x.size(), y.size());
  const auto is_gap = [&](std::size_t i) { return !std::isfinite(x[i]) || !std::isfinite(y[i]); };
  const std::size_t block = size <= most ? 1 : (6 * size + most - 1) / std::max<std::size_t>(most, 1);
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < size;) {
    if (is_gap(i)) {  // one index for the whole gap
      kept.push_back(i);
      while (i < size && is_gap(i)) ++i;
      continue;
    }
    std::size_t end = i + 1;
    while (end < size && end < i + block && !is_gap(end)) ++end;
    KeepOutline(x, y, i, end, &kept);
    i = end;
  }
  return kept;
}

namespace {

std::string NameSvg(const Figure& figure, std::string svg) {
  // What a browser shows as the name of the picture and a screen reader reads out.
  constexpr std::string_view kName = "<title>Gnuplot</title>";
  if (const std::size_t at = svg.find(kName); at != std::string::npos) {
    const std::string& name = figure.title.empty() ? figure.panels.front().title : figure.title;
    svg.replace(at, kName.size(), "<title>" + EscapeMarkup(name) + "</title>");
  }
  return svg;
}

/// Cuts what a stream begins with off it, up to the end of `last`, white space in front of it apart.
std::string TakeUpTo(std::string_view last, std::string_view* stream) {
  const std::size_t end = stream->find(last);
  if (end == std::string_view::npos) throw FigureError("the figure cannot be drawn: gnuplot left one out");
  std::string_view taken = stream->substr(0, end + last.size());
  stream->remove_prefix(taken.size());
  while (taken.starts_with('\n')) taken.remove_prefix(1);
  return std::string(taken);
}

}  // namespace

std::string RenderSvg(const Figure& figure) { return NameSvg(figure, Render(figure, Format::kSvg)); }

std::string RenderPng(const Figure& figure) { return Render(figure, Format::kPng); }

std::vector<Pictures> RenderPictures(std::span<const Figure> figures) {
  std::vector<Pictures> pictures;
  if (figures.empty()) return pictures;
  std::string script;
  for (const Figure& figure : figures) {
    CheckFigure(figure);
    script += Script(figure, Format::kSvg).text() + "set output\n";
    script += Script(figure, Format::kPng, /*with_data=*/false).text() + "set output\n";
  }
  constexpr std::string_view kSvgEnd = "</svg>\n", kPngEnd = "IEND\xae\x42\x60\x82";
  const std::string drawn = RunGnuplot(script);
  std::string_view rest = drawn;
  for (const Figure& figure : figures) {
    Pictures& both = pictures.emplace_back();
    both.svg = NameSvg(figure, TakeUpTo(kSvgEnd, &rest));
    both.png = TakeUpTo(kPngEnd, &rest);
  }
  return pictures;
}

std::string FormatFigureData(const Figure& figure) {
  CheckFigure(figure);
  std::string text = "panel,series,x,y,x_axis,y_axis\n";
  for (std::size_t p = 0; p < figure.panels.size(); ++p) {
    const FigurePanel& panel = figure.panels[p];
    const std::string panel_name = CsvCell(panel.title.empty() ? std::to_string(p + 1) : panel.title);
    const std::string axes = CsvCell(AxisTitle(panel.x)) + "," + CsvCell(AxisTitle(panel.y));
    for (std::size_t s = 0; s < panel.series.size(); ++s) {
      const FigureSeries& series = panel.series[s];
      const std::string name = CsvCell(series.name.empty() ? std::to_string(s + 1) : series.name);
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        fmt::format_to(std::back_inserter(text), "{},{},{},{},{}\n", panel_name, name, series.x[i], series.y[i], axes);
      }
    }
  }
  return text;
}

}  // namespace uiclink
