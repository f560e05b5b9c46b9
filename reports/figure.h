#pragma once

#include <cstddef>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace uiclink {

/// How the points of a series are joined.
enum class FigureLine { kNone, kSolid, kDashed, kDotted };
/// What stands at each point of a series.
enum class FigureMark { kNone, kDot, kCircle, kDisc, kSquare, kTriangle, kCross };

/// Seven colours that are told apart with any colour vision, and by their grey (Okabe and Ito, "Color universal
/// design", 2008; its yellow is left out, too faint on white). Series without a colour take them in this order; from
/// the eighth on they are dashed, too.
enum class FigureColour { kBlue, kVermilion, kGreen, kPurple, kSky, kOrange, kBlack };

/// One axis. Where a bound is missing it follows from the data.
struct FigureAxis {
  std::string label = {};  ///< "lateral displacement"
  std::string unit = {};   ///< "mm"; empty for a number without dimension
  bool log = false;        ///< logarithmic; values <= 0 are not drawn
  bool reversed = false;   ///< grows to the left, or downwards
  bool numbers = true;     ///< or no tics: places without a measure, such as bars with notes
  std::optional<double> low = std::nullopt;
  std::optional<double> high = std::nullopt;
  /// Of x axes, on a page (HtmlPage::Chart): those with the same word zoom and pan together, in all figures of the
  /// page. Without a word those of one figure do that have label, unit, scale and given bounds in common.
  std::string link = {};
};

/// Points (x[i], y[i]), in the units of the axes. A point with a value that is not finite is left out, and the line is
/// broken there.
struct FigureSeries {
  std::string name = {};  ///< in the legend; empty: not in it
  std::vector<double> x = {};
  std::vector<double> y = {};  ///< as many as x
  FigureLine line = FigureLine::kSolid;
  FigureMark mark = FigureMark::kNone;
  std::optional<FigureColour> colour = std::nullopt;  ///< the next one of the palette where missing
  double width = 1.4;                                 ///< of the line [px]
};

/// A thin grey line across the panel at one value. The axis reaches to it, unless its bounds are given.
struct FigureGuide {
  double value = 0;
  std::string text = {};  ///< written at its end; may be empty
};

/// Text inside the panel, in data coordinates, to the right of the point.
struct FigureNote {
  double x = 0;
  double y = 0;
  std::string text;
};

struct FigurePanel {
  std::string title = {};
  FigureAxis x = {};
  FigureAxis y = {};
  std::vector<FigureSeries> series = {};
  std::vector<FigureGuide> horizontal_guides = {};  ///< at values of y
  std::vector<FigureGuide> vertical_guides = {};    ///< at values of x
  std::vector<FigureNote> notes = {};
  bool equal_scales = false;  ///< one unit of x as long as one of y (profiles, ellipses, eigenvalues); linear axes only
};

/// A picture of one or more panels, filled row by row.
///
///   Figure figure{.title = "wagon at 24 m/s", .panels = {{.title = "front wheelset", .x = {"time", "s"}, ...}}};
///   WriteFileWhole("histories.svg", RenderSvg(figure));       // data/file.h: whole or not at all
///   WriteFileWhole("histories.csv", FormatFigureData(figure));
struct Figure {
  std::string title = {};
  std::vector<FigurePanel> panels = {};
  std::size_t columns = 1;  ///< panels beside each other
  int width = 1000;         ///< [px]
  int panel_height = 240;   ///< of one row of panels with its titles and labels [px]
};

/// A figure cannot be drawn: gnuplot is missing (what() names the Debian package) or refuses.
class FigureError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The figure as SVG or PNG, drawn by gnuplot in a process of its own. Long series are thinned by ThinForDrawing first.
/// The same figure gives the same bytes.
/// @throws std::invalid_argument if the figure is none: no panels, x and y of a series of different length, equal
///         scales on a logarithmic axis, bounds that are not finite or in the wrong order.
/// @throws FigureError where it cannot be drawn.
std::string RenderSvg(const Figure& figure);
std::string RenderPng(const Figure& figure);

/// Every point of every series, not thinned, as CSV: panel, series, x, y, x_axis, y_axis.
/// Numbers read back as the same double. @throws std::invalid_argument as above.
std::string FormatFigureData(const Figure& figure);

/// Indices, increasing, of the points that a line through (x[i], y[i]) needs at drawing size: all of them up to
/// `most`; else the points in blocks of equal count, and of each block its first and last point and those where x or y
/// is smallest or largest. So no extremum is lost, and every block keeps its outline. Gaps (values not finite) are
/// kept as one index each.
std::vector<std::size_t> ThinForDrawing(const std::vector<double>& x, const std::vector<double>& y,
                                        std::size_t most = 12000);

}  // namespace uiclink
