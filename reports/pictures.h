#pragma once

#include <span>
#include <string>
#include <vector>

#include "reports/figure.h"

namespace uiclink {

/// A figure as files.
struct Pictures {
  std::string svg, png;
};

/// RenderSvg and RenderPng of several figures by one process of gnuplot: starting it and finding its fonts takes longer
/// than a small picture. The pictures are the same, though gnuplot may name pens that draw nothing.
/// @throws as they do.
std::vector<Pictures> RenderPictures(std::span<const Figure> figures);

}  // namespace uiclink
