#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "identify/digitise/picture.h"

namespace uiclink {

/// How a record is drawn as a plot, and what happens to the page afterwards.
struct PlotStyle {
  std::string name;
  int width = 1000, height = 700;          ///< of the picture [px]
  double line_width = 2;                   ///< [px]
  std::array<int, 3> colour{180, 60, 20};  ///< of the curve: blue, green, red
  double frame_width = 1;                  ///< [px]
  int frame_grey = 0;
  enum class Grid { kNone, kSolid, kDotted, kDashed } grid = Grid::kNone;
  int grid_grey = 200;
  bool zero_line = false;  ///< a thin black line at y = 0
  bool ticks_inside = false;
  double dash = 0, hole = 0;  ///< of a dashed curve [px]; 0: solid
  bool legend = false;        ///< text and a sample of the line in the upper right corner
  bool second = false;        ///< another curve, of colour `second_colour`, across the first
  std::array<int, 3> second_colour{40, 40, 210};
  bool dark = false;  ///< light on dark
  double rotation_deg = 0;
  bool photo = false;     ///< perspective, uneven light, blur, noise, a table around the page
  double bow = 0;         ///< of the page, as part of its height
  double blur = 0;        ///< [px]
  double noise = 0;       ///< standard deviation [levels]
  int jpeg = 0;           ///< quality; 0: no JPEG
  bool no_frame = false;  ///< the axes' left and bottom lines only
  bool gnuplot = false;   ///< drawn by gnuplot (pngcairo) instead of by OpenCV
  double t_low = 0, t_high = 15, y_low = -35, y_high = 35;
};

/// A plot and where its axes lie.
struct DrawnPlot {
  digitise::Picture picture;
  double left = 0, right = 0, top = 0, bottom = 0;  ///< frame before the page was turned [px]
  double X(const PlotStyle& s, double t) const { return left + (right - left) * (t - s.t_low) / (s.t_high - s.t_low); }
  double Y(const PlotStyle& s, double y) const {
    return bottom + (top - bottom) * (y - s.y_low) / (s.y_high - s.y_low);
  }
};

/// Draws displacements y [mm] at times t [s]. Nothing here shares code with what reads the picture: lines are filled in
/// pixels of a half to a quarter of the size, averaged. With style.gnuplot, gnuplot draws them (gnuplot must be there).
/// @param other  the second curve
DrawnPlot DrawPlot(const std::vector<double>& t, const std::vector<double>& y, const std::vector<double>& other,
                   const PlotStyle& style);

/// Distances between what was read and what was drawn, in pixels of the plot: of each sample from the drawn line, and
/// of each drawn point from the line through the samples.
struct ReadingError {
  double rms = 0;
  double largest = 0;
  double where = 0;  ///< time of the largest [s]
  double chi = 0;    ///< rms of (error of the row / its stated standard deviation)
};
ReadingError CompareWithDrawn(const std::vector<double>& t, const std::vector<double>& y, const DrawnPlot& plot,
                              const PlotStyle& style, const std::vector<double>& read_t,
                              const std::vector<double>& read_y, const std::vector<double>& read_uncertainty);

}  // namespace uiclink
