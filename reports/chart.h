#pragma once

#include <string>

#include "reports/figure.h"

namespace uiclink {

/// A figure as page/chart.js draws it: traces, axes, lines and texts of plotly.js, but without their places, which
/// follow from the width that the page has. JSON that may stand inside of a script element, whatever the texts are.
///
///   { "data": [trace...], "layout": {...},
///     "grid": { "columns": 2, "panel_height": 240, "title": "...",
///               "panels": [ { "x": "xaxis", "y": "yaxis", "title": 0, "legend": [0, 1], "guides": [3, 4] } ] },
///     "links": { "time": ["xaxis", "xaxis3"] } }
///
/// `legend` are indices of data, `title` (-1: none) and `guides` of layout.annotations. `links` are the words of
/// FigureAxis::link. x and y of a trace are arrays, or where they are long {"from", "to", "log", "u16"}
/// (reports/chart_data.h).
/// @throws std::invalid_argument if the figure is none (RenderSvg).
std::string FormatChart(const Figure& figure);

}  // namespace uiclink
