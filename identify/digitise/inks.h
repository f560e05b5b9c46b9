#pragma once

#include <array>
#include <string>
#include <vector>

#include "identify/digitise/page.h"

namespace uiclink::digitise {

using Colour = std::array<double, 3>;  ///< blue, green, red, 0 to 255

/// One colour of ink inside the frame.
struct Ink {
  Colour colour{};    ///< of its darkest parts
  double pixels = 0;  ///< how many are of it
};

/// What is known about the pixels of a page before anybody looks for a curve.
struct Inks {
  Colour paper{};
  double noise = 0;                ///< standard deviation of the paper [levels]
  bool sharp = true;               ///< every pixel has its own colour; false: colours are smeared (JPEG, photographs)
  std::vector<Ink> inks;           ///< by falling number of pixels, straight lines across the frame left out
  std::vector<int> level_lines;    ///< rows covered by straight lines from side to side (grid, axes)
  std::vector<int> upright_lines;  ///< columns
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;  ///< columns and rows that may hold the curve, both ends included
};

/// How much of one ink is in each pixel: 0 paper, 1 its full colour.
struct InkLayer {
  Plane share;
  Plane weight;  ///< 1 where `share` can be believed; 0 under other inks, grid lines of the same colour, ticks, outside
};

/// Colours of the page inside its frame: directions from the paper's colour, found on single pixels, or, where these
/// are smeared as in JPEG, on means over 5x5 pixels.
Inks FindInks(const Page& page);

/// @param which  index into inks.inks
InkLayer MakeLayer(const Page& page, const Inks& inks, std::size_t which);

/// "blue (#1f77b4)".
std::string ColourName(const Colour& colour);

/// A colour by its name or as #rrggbb. @throws std::invalid_argument when it is neither.
Colour ParseColour(const std::string& text);

/// Angle between two inks on that paper [rad], and how far they differ in strength [-]: 0 for the same ink.
double InkDistance(const Colour& a, const Colour& b, const Colour& paper);

}  // namespace uiclink::digitise
