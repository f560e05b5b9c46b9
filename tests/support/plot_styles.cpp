#include "tests/support/plot_styles.h"

namespace uiclink {
namespace {

using Grid = PlotStyle::Grid;
constexpr std::array<int, 3> kBlack{0, 0, 0}, kBlue{180, 119, 31}, kRed{40, 39, 214}, kGreen{44, 160, 44},
    kOrange{14, 127, 255}, kPurple{189, 103, 148}, kPureBlue{255, 0, 0}, kMagenta{255, 0, 255};

void AddWidthsAndSizes(std::vector<PlotStyle>* styles) {
  for (const double width : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0})
    styles->push_back({.name = "width", .line_width = width, .colour = kBlue});
  styles->push_back({.name = "size 500", .width = 500, .height = 350, .line_width = 1, .colour = kBlue});
  styles->push_back({.name = "size 640", .width = 640, .height = 480, .line_width = 1.5, .colour = kRed});
  styles->push_back(
      {.name = "size 800 legend", .width = 800, .height = 500, .line_width = 2, .colour = kGreen, .legend = true});
  styles->push_back(
      {.name = "size 1600", .width = 1600, .height = 1000, .line_width = 3, .colour = kBlue, .grid = Grid::kSolid});
  styles->push_back({.name = "size 2000", .width = 2000, .height = 1200, .line_width = 2, .colour = kBlack});
  styles->push_back(
      {.name = "size 3000", .width = 3000, .height = 2000, .line_width = 5, .colour = kBlue, .legend = true});
  styles->push_back({.name = "wide 2400x500", .width = 2400, .height = 500, .line_width = 2, .colour = kPurple});
}

void AddGridsAndColours(std::vector<PlotStyle>* styles) {
  styles->push_back({.name = "black on black frame", .line_width = 1.5, .colour = kBlack});
  styles->push_back({.name = "black, solid grid", .line_width = 1.5, .colour = kBlack, .grid = Grid::kSolid});
  styles->push_back(
      {.name = "black, dotted grid", .line_width = 2, .colour = kBlack, .grid = Grid::kDotted, .grid_grey = 120});
  styles->push_back(
      {.name = "black, dark dashed grid", .line_width = 2, .colour = kBlack, .grid = Grid::kDashed, .grid_grey = 60});
  styles->push_back(
      {.name = "black, black grid", .line_width = 2, .colour = kBlack, .grid = Grid::kSolid, .grid_grey = 0});
  styles->push_back(
      {.name = "black, zero line, legend", .line_width = 2, .colour = kBlack, .zero_line = true, .legend = true});
  styles->push_back({.name = "blue, zero line, ticks inside",
                     .line_width = 2,
                     .colour = kPureBlue,
                     .zero_line = true,
                     .ticks_inside = true});
  styles->push_back(
      {.name = "black, ticks inside", .line_width = 2, .colour = kBlack, .frame_width = 2, .ticks_inside = true});
  styles->push_back({.name = "orange, solid grid", .line_width = 2, .colour = kOrange, .grid = Grid::kSolid});
  styles->push_back({.name = "magenta, thick frame", .line_width = 3, .colour = kMagenta, .frame_width = 3});
  styles->push_back({.name = "grey frame", .line_width = 2, .colour = kRed, .frame_grey = 150, .grid = Grid::kDotted});
  styles->push_back({.name = "dark",
                     .line_width = 2,
                     .colour = {80, 220, 255},
                     .grid = Grid::kSolid,
                     .grid_grey = 200,
                     .dark = true});
}

void AddDashesAndSecondCurves(std::vector<PlotStyle>* styles) {
  styles->push_back({.name = "dashed 8-5", .line_width = 2, .colour = kBlue, .dash = 8, .hole = 5});
  styles->push_back({.name = "dashed 12-8 black grid",
                     .line_width = 2,
                     .colour = kBlack,
                     .grid = Grid::kSolid,
                     .dash = 12,
                     .hole = 8});
  styles->push_back({.name = "dashed 15-6 large",
                     .width = 2000,
                     .height = 1300,
                     .line_width = 3,
                     .colour = kRed,
                     .dash = 15,
                     .hole = 6});
  styles->push_back({.name = "dotted 3-4", .line_width = 2.5, .colour = kBlue, .dash = 3, .hole = 4});
  styles->push_back({.name = "second curve", .line_width = 1.5, .colour = kBlue, .second = true});
  styles->push_back({.name = "second curve, legend, grid",
                     .width = 1400,
                     .height = 900,
                     .line_width = 2,
                     .colour = kBlack,
                     .grid = Grid::kSolid,
                     .legend = true,
                     .second = true});
  styles->push_back({.name = "second curve green",
                     .line_width = 1.5,
                     .colour = kRed,
                     .legend = true,
                     .second = true,
                     .second_colour = kGreen});
}

void AddJpegs(std::vector<PlotStyle>* styles) {
  styles->push_back({.name = "JPEG 95", .line_width = 2, .colour = kBlue, .jpeg = 95});
  styles->push_back({.name = "JPEG 75 grid", .line_width = 2, .colour = kRed, .grid = Grid::kSolid, .jpeg = 75});
  styles->push_back({.name = "JPEG 50 black", .line_width = 2, .colour = kBlack, .grid = Grid::kSolid, .jpeg = 50});
  styles->push_back({.name = "JPEG 30 black", .line_width = 2, .colour = kBlack, .jpeg = 30});
  styles->push_back({.name = "JPEG 30 blue", .line_width = 3, .colour = kBlue, .jpeg = 30});
  styles->push_back({.name = "JPEG 50 second curve",
                     .width = 1600,
                     .height = 1000,
                     .line_width = 3,
                     .colour = kBlue,
                     .second = true,
                     .jpeg = 50});
  styles->push_back(
      {.name = "JPEG 75 size 640", .width = 640, .height = 480, .line_width = 1.5, .colour = kBlack, .jpeg = 75});
}

void AddTurnedAndPhotographed(std::vector<PlotStyle>* styles) {
  styles->push_back({.name = "turned 2", .line_width = 2, .colour = kBlue, .rotation_deg = 2});
  styles->push_back(
      {.name = "turned -2 black grid", .line_width = 2, .colour = kBlack, .grid = Grid::kSolid, .rotation_deg = -2});
  styles->push_back({.name = "scan 0.7",
                     .width = 1600,
                     .height = 1100,
                     .line_width = 2.5,
                     .colour = kBlack,
                     .rotation_deg = 0.7,
                     .blur = 0.7,
                     .noise = 4,
                     .jpeg = 85});
  styles->push_back({.name = "photo",
                     .width = 1800,
                     .height = 1300,
                     .line_width = 3,
                     .colour = kBlack,
                     .photo = true,
                     .blur = 1.0,
                     .noise = 4,
                     .jpeg = 85});
  styles->push_back({.name = "photo blue, grid",
                     .width = 2200,
                     .height = 1500,
                     .line_width = 4,
                     .colour = kPureBlue,
                     .grid = Grid::kSolid,
                     .rotation_deg = 1.5,
                     .photo = true,
                     .blur = 1.2,
                     .noise = 5,
                     .jpeg = 80});
  styles->push_back({.name = "photo bent",
                     .width = 1800,
                     .height = 1300,
                     .line_width = 3,
                     .colour = kRed,
                     .photo = true,
                     .bow = 0.01,
                     .blur = 1.0,
                     .noise = 4,
                     .jpeg = 85});
}

void AddGnuplots(std::vector<PlotStyle>* styles) {
  styles->push_back({.name = "gnuplot", .line_width = 1.5, .colour = kBlue, .gnuplot = true});
  styles->push_back({.name = "gnuplot grid, legend",
                     .line_width = 2,
                     .colour = kBlack,
                     .grid = Grid::kSolid,
                     .legend = true,
                     .gnuplot = true});
  styles->push_back({.name = "gnuplot dashed", .line_width = 2, .colour = kRed, .dash = 1, .gnuplot = true});
  styles->push_back({.name = "gnuplot second, JPEG 75",
                     .width = 1600,
                     .height = 1000,
                     .line_width = 2,
                     .colour = kBlue,
                     .ticks_inside = true,
                     .legend = true,
                     .second = true,
                     .jpeg = 75,
                     .gnuplot = true});
  styles->push_back({.name = "gnuplot turned, zero line",
                     .width = 1400,
                     .height = 900,
                     .line_width = 2,
                     .colour = kGreen,
                     .zero_line = true,
                     .rotation_deg = 2,
                     .gnuplot = true});
}

}  // namespace

std::vector<PlotStyle> PlotStyles() {
  std::vector<PlotStyle> styles;
  AddWidthsAndSizes(&styles);
  AddGridsAndColours(&styles);
  AddDashesAndSecondCurves(&styles);
  AddJpegs(&styles);
  AddTurnedAndPhotographed(&styles);
  AddGnuplots(&styles);
  return styles;
}

}  // namespace uiclink
