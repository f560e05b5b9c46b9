#pragma once

#include <vector>

#include "identify/digitise/inks.h"

namespace uiclink::digitise {

/// The ink of a curve in one column: from the upper edge of its first pixel to the lower edge of its last one [px].
struct Stroke {
  int x = 0;
  double low = 0;   ///< smaller row
  double high = 0;  ///< larger row
  int ink = 0;      ///< pixels of ink in between
};

/// The first, coarse reading of a curve. The drawn curve is a function of time, so its ink in a column is one stroke,
/// however steep it is, and strokes of neighbouring columns touch.
struct Trace {
  std::vector<Stroke> strokes;  ///< at most one a column, by increasing x
  double total_ink = 0;         ///< pixels of that ink inside the frame
  double ink = 0;               ///< of these, in the strokes
  int bridged = 0;              ///< longest hole inside strokes that was bridged [px]

  double Columns() const { return static_cast<double>(strokes.size()); }
};

/// The chain of strokes that holds most ink: by dynamic programming over the columns, where a jump of n pixels between
/// neighbours costs 4 n pixels of ink, less where holes of that length are bridged. Holes in a stroke (dashes, lines
/// that cross) are bridged, as little as needed.
Trace FindTrace(const InkLayer& layer, const Inks& inks);

/// Half the width of the line [px]: of its extents along rows and columns the smaller one counts, which is the width
/// itself where the line is level or steep.
double HalfWidth(const Trace& trace, const InkLayer& layer);

/// Strokes of a line are as tall as it is steep and thick; letters are taller than that while they stand still. True
/// where half of the strokes and more are no letters.
bool LooksDrawn(const Trace& trace, double half_width);

/// How far the strokes move up and down [px]: an axis or a line of text hardly does.
double Travel(const Trace& trace);

/// Part of the columns between first and last stroke that have one, or lie in a hole of at most `hole` columns.
double Coverage(const Trace& trace, int hole);

/// y(x) at the columns x0..x1 from the outer edges of the strokes, [px]: a stroke is the curve widened by a disc, so
/// the curve is where a disc rolls along the edges; on the outside of a turn only its outer edge counts. Columns
/// without a stroke are bridged by a line.
std::vector<double> RollDisc(const Trace& trace, double radius, int x0, int x1);

}  // namespace uiclink::digitise
