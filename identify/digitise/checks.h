#pragma once

#include <string>
#include <utility>
#include <vector>

#include "identify/digitise/digitise.h"
#include "identify/digitise/line_fit.h"

namespace uiclink::digitise {

/// Which part of the curve can be given.
struct Readability {
  double first = 0, last = 0;                   ///< columns [px]
  std::vector<std::pair<double, double>> gaps;  ///< columns in between where nothing was seen for too long [px]
  double longest_bridge = 0;                    ///< of what is given, along the curve [px]
  double columns_read = 0;                      ///< part of the columns in which some of the line was seen

  bool InGap(double x) const;
};

/// From the first to the last stroke of the trace. Stretches of the curve that are hidden or not drawn are bridged
/// where the spline knows the row to a pixel across the line all the way; others are gaps.
Readability FindReadable(const LineFit& fit, const Trace& trace);

struct Reading {
  const Page& page;
  const Inks& inks;
  const InkLayer& layer;
  const Trace& trace;
  const LineFit& fit;
  const Readability& readable;
};

/// Compares what was read with the picture; fills the figures of *read and its warnings.
/// @throws InputError where the reading cannot be right or cannot be told from another one.
void CheckReading(const Reading& reading, const std::string& name, Digitised* read);

}  // namespace uiclink::digitise
